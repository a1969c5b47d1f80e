"""A case marched over ranges of its keys: plan, points, store, cluster."""
