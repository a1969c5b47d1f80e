"""Periodic motions of a rub at given speeds: Dataset, table, figure."""
