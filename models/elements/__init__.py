"""Finite elements of bladed disk and casing: weak forms, assembly, supports, sectors."""
