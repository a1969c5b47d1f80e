"""Reading and writing of mesh files of Gmsh, Abaqus and VTK, with their groups."""
