"""Mesh files of Gmsh, Abaqus and VTK, with their groups."""
