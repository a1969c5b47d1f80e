"""Finite elements of solids, from which superelements are made."""
