"""Quarter of a wheel, meshed by Gmsh, in the formats and versions it writes; for test_mesh_files.

    pip install gmsh && python quarter_wheel.py

Two spokes of two lines each and an arc of three between their ends.
"""

import gmsh

gmsh.initialize()
g = gmsh.model.geo
centre = g.addPoint(0, 0, 0)
ends = [g.addPoint(100, 0, 0), g.addPoint(0, 100, 0)]
spokes = [g.addLine(centre, end) for end in ends]
rim = g.addCircleArc(ends[0], centre, ends[1])
for curve, lines in ((spokes[0], 2), (spokes[1], 2), (rim, 3)):
    g.mesh.setTransfiniteCurve(curve, lines + 1)
g.synchronize()
gmsh.model.addPhysicalGroup(1, spokes, name="blades")
gmsh.model.addPhysicalGroup(1, [rim], name="rim")
gmsh.model.addPhysicalGroup(1, [*spokes, rim], name="all of it")
gmsh.model.addPhysicalGroup(0, ends, name="tips")
gmsh.model.addPhysicalGroup(0, [centre], name="hub")
gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
gmsh.model.mesh.generate(1)
gmsh.write("gmsh_4.1.msh")
gmsh.option.setNumber("Mesh.Binary", 1)
gmsh.write("gmsh_4.1_binary.msh")
gmsh.option.setNumber("Mesh.Binary", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
gmsh.write("gmsh_2.2.msh")
gmsh.write("gmsh.inp")
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.model.mesh.setOrder(2)
gmsh.write("gmsh_curved.msh")
gmsh.write("gmsh_curved.inp")
gmsh.finalize()
