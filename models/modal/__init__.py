"""Modes by nodal diameter and family, and the reduction onto them."""
