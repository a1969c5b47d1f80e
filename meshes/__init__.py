"""Geometry: line meshes of bladed disks, ring meshes of casings, mesh files."""
