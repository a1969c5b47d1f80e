"""Meshes of solids in .med files of Salome and Code_Aster, read with meshlane.

Groups of nodes and of elements keep their names. The files contain no materials.
"""

from pathlib import Path

import h5py
import meshio

from bladewhirl.files import check_regular
from bladewhirl.meshes.files.abaqus_solids import SolidMesh
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.meshio_cells import readable
from bladewhirl.meshes.hdf5 import open_hdf5

CURVILINEAR = (1, 2)  #: numbers of cylindrical and spherical coordinates of a mesh


def med_mesh(path: Path) -> SolidMesh:
    """Return the cells of a .med file with its groups.

    Raises:
        MeshFileError: the file cannot be read.
    """
    from meshlane import med  # long to load

    with readable(path, "meshlane"):
        path.stat()  # an error if there is no file
        check_regular(path)
        if not h5py.is_hdf5(path):
            raise MeshFileError(
                "a .med file as Salome and Code_Aster export it: this one is no HDF5"
            )
        with open_hdf5(path, kinds="iuf") as file:
            stored = file.get("ENS_MAA", {}).values()
            if any(one.attrs.get("REP") in CURVILINEAR for one in stored):
                raise MeshFileError("a .med file in Cartesian coordinates")
        mesh = med.read(str(path))
        cells = [(block.type, block.data) for block in mesh.cells]
        return SolidMesh(
            meshio.Mesh(mesh.points, cells, point_sets=mesh.point_sets, cell_sets=mesh.cell_sets)
        )
