"""Rotating structures: their matrices at any speed, on any basis, and by nodal diameter."""
