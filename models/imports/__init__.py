"""Superelements from the matrices of other finite element codes."""
