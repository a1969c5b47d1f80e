"""Meshes of solids in .med files of Salome and Code_Aster, read with meshlane.

Groups of nodes and of elements keep their names. The files contain no materials.
"""

from pathlib import Path

import meshio

from bladewhirl.meshes.files.abaqus_solids import SolidMesh
from bladewhirl.meshes.files.meshio_cells import readable
from bladewhirl.meshes.hdf5 import open_hdf5


def med_mesh(path: Path) -> SolidMesh:
    """Return the cells of a .med file with its groups.

    Raises:
        MeshFileError: the file cannot be read.
    """
    from meshlane import med  # long to load

    with readable(path, "meshlane"):
        open_hdf5(path, kinds="iuf").close()
        mesh = med.read(str(path))
        cells = [(block.type, block.data) for block in mesh.cells]
        return SolidMesh(
            meshio.Mesh(mesh.points, cells, point_sets=mesh.point_sets, cell_sets=mesh.cell_sets)
        )
