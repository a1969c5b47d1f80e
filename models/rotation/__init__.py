"""Rotation effects on a bladed disk: tension, spin softening, Coriolis forces, growth of the
tips."""
