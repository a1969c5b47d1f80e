"""Compiled time integration, called with arrays."""
