"""Figures of wheels with friction joints."""
