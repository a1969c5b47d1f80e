"""Periodic motions of wheels with friction joints: Dataset, table, figure."""
