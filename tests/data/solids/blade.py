"""Make blade.msh with Gmsh (pip install gmsh; 4.15 was used): python tests/data/solids/blade.py"""

from pathlib import Path

import gmsh

gmsh.initialize()
gmsh.model.occ.addBox(200.0, -15.0, -2.5, 100.0, 30.0, 5.0)  # mm
gmsh.model.occ.synchronize()
centre = gmsh.model.occ.getCenterOfMass
faces = {round(centre(2, tag)[0]): tag for _, tag in gmsh.model.getEntities(2)}
gmsh.model.addPhysicalGroup(2, [faces[200]], name="root")
gmsh.model.addPhysicalGroup(2, [faces[300]], name="tip")
gmsh.model.addPhysicalGroup(3, [1], name="blade")
gmsh.option.setNumber("Mesh.MeshSizeMin", 20.0)
gmsh.option.setNumber("Mesh.MeshSizeMax", 20.0)
gmsh.option.setNumber("Mesh.ElementOrder", 2)
gmsh.model.mesh.generate(3)
gmsh.write(str(Path(__file__).with_suffix(".msh")))
gmsh.finalize()
