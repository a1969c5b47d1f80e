"""Bladed disks as one beam model: the standard disk, a sketch, a mesh."""
