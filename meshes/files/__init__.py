"""Mesh files in and out: Gmsh, Abaqus and VTK, and the groups that they hold."""
