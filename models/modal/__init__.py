"""Modes of a structure by nodal diameter and family, and Craig-Bampton reduction."""
