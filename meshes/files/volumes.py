"""Meshes of solids: tetrahedra or hexahedra of first or second order, with groups of nodes."""

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

import meshio
import numpy as np

from bladewhirl.meshes.files.abaqus_reader import abaqus_mesh
from bladewhirl.meshes.files.gmsh import TAG, gmsh_mesh, is_member
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.meshio_cells import readable, stacked
from bladewhirl.meshes.files.vtu import integer_groups
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

CELLS = ("tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27")
"""Types of the cells of solids, with the names of meshio and the order of nodes of VTK."""


@dataclass(frozen=True, kw_only=True)
class VolumeMesh:
    """Mesh of a solid with cells of one type, in the unit of length of its source.

    Every node belongs to a cell.
    """

    points: FloatArray  #: positions of the nodes, (nodes, 3)
    cell_type: str  #: one of `CELLS`
    cells: IntArray  #: nodes of each cell in the order of VTK, (cells, nodes of a cell)
    groups: Mapping[str, IntArray] = field(default_factory=dict)  #: name -> numbers of nodes
    name: str = ""  #: name of the file, without its folder
    rows: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Place of each node among the points of the source, (nodes,)."""


def read_volume_mesh(mesh: meshio.Mesh | str | PathLike[str]) -> VolumeMesh:
    """Read a mesh of a solid with its groups.

    A group contains the nodes of its cells, which may have any dimension. The groups of a Gmsh file
    are its physical groups of points, curves, surfaces and volumes; the groups of an Abaqus file
    are its sets of nodes and of elements; the groups of a VTK file are the arrays of integers on
    points or cells that are 1 for members and 0 elsewhere. Cells of a lower dimension serve as
    groups only.

    Args:
        mesh: mesh of meshio, or path of a .msh file of Gmsh, a .vtu file, or an .inp file of Abaqus
            or CalculiX.

    Raises:
        MeshFileError: the file cannot be read, or its solid cells do not have one supported type;
            the text completes "expected ...".
    """
    if isinstance(mesh, meshio.Mesh):
        return _volumes(mesh, "the mesh")
    file = Path(mesh)
    if file.exists() and not file.is_file():
        raise MeshFileError("a regular file")
    if file.suffix.lower() not in READERS:
        raise MeshFileError(f"a mesh file, {', '.join(READERS)}")
    return _volumes(READERS[file.suffix.lower()](file), file.name)


def _vtu_mesh(path: Path) -> meshio.Mesh:
    with readable(path):
        return meshio.vtu.read(str(path))


READERS: dict[str, Callable[[Path], meshio.Mesh]] = {
    ".msh": gmsh_mesh,
    ".vtu": _vtu_mesh,
    ".inp": abaqus_mesh,
}


def _volumes(mesh: meshio.Mesh, name: str) -> VolumeMesh:
    solid = [block for block in mesh.cells if block.dim == 3 and len(block.data)]
    kinds = sorted({block.type for block in solid})
    if len(kinds) != 1 or kinds[0] not in CELLS:
        existing = f"found {', '.join(kinds)}" if kinds else "there are none"
        raise MeshFileError(f"cells of one of the types {', '.join(CELLS)}; {existing}")
    cells = stacked([block.data for block in solid]).astype(np.int64)
    # A file of Gmsh 2.2 repeats a cell for each of its groups; one occurrence remains.
    cells = cells[np.sort(np.unique(np.sort(cells, axis=1), axis=0, return_index=True)[1])]
    if not (cells.min() >= 0 and cells.max() < len(mesh.points)):
        raise MeshFileError("all nodes of the cells; some nodes are not defined")
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise MeshFileError("nodes with three finite coordinates")
    used, numbers = np.unique(cells, return_inverse=True)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    groups = {key: np.unique(place[nodes]) for key, nodes in _groups(mesh).items()}
    return VolumeMesh(
        points=points[used],
        cell_type=kinds[0],
        cells=numbers.reshape(cells.shape),
        groups={key: nodes[nodes >= 0] for key, nodes in groups.items()},
        name=name,
        rows=used,
    )


def _groups(mesh: meshio.Mesh) -> dict[str, IntArray]:
    """Return the numbers of the nodes of each group, repeated nodes included."""
    groups: defaultdict[str, list[IntArray]] = defaultdict(list)
    for key, nodes in mesh.point_sets.items():
        groups[key].append(np.asarray(nodes, dtype=np.int64))
    for key, members in mesh.cell_sets.items():
        if not key.startswith("gmsh:"):
            for block, inside in zip(mesh.cells, members, strict=True):
                if inside is not None and len(inside):
                    groups[key].append(block.data[np.asarray(inside, dtype=int)])
    for key, nodes in integer_groups(_named(mesh.point_data)):
        groups[key].append(nodes)
    for number, block in enumerate(mesh.cells):
        arrays = {key: values[number] for key, values in _named(mesh.cell_data).items()}
        for key, inside in integer_groups(arrays):
            groups[key].append(block.data[inside])
    # Without tags the field data are not groups of Gmsh.
    for key, (tag, dimension) in mesh.field_data.items() if TAG in mesh.cell_data else ():
        for number, block in enumerate(mesh.cells):
            if block.dim == dimension:
                inside = is_member(mesh, number, key, tag)
                groups[key].append(block.data[inside])
    return {key: np.concatenate([np.ravel(one) for one in nodes]) for key, nodes in groups.items()}


def _named(arrays: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    return {key: values for key, values in arrays.items() if not key.startswith("gmsh:")}
