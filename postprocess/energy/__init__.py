"""Energy of a run: who holds it, where it came from, whether it grows, and the regime."""
