"""Friction joints between neighbouring blades: axes, gaps and preloads, waves of a tuned wheel."""
