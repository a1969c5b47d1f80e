"""Sweeps of a case over ranges of its keys: plan, points, store, cluster."""
