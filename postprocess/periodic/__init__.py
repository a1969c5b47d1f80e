"""Branches of periodic motions: their file and figures."""
