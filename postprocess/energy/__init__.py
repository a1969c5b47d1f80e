"""Energy of a run: its distribution over modes, its sources, its growth, and the regime."""
