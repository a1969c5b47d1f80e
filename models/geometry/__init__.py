"""Beam models of bladed disks, from the standard disk, a sketch or a mesh file."""
