"""Rotation effects on a bladed disk: tension, spin softening, Coriolis, growth, critical speeds."""
