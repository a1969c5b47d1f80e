"""Meshes of solids: tetrahedra, wedges and hexahedra, with groups of nodes."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path

import meshio
import numpy as np

from bladewhirl.meshes.coincident import places_of
from bladewhirl.meshes.files.abaqus_solids import Section, SolidMesh, abaqus_mesh
from bladewhirl.meshes.files.ansys import ansys_mesh
from bladewhirl.meshes.files.formats import ABAQUS, format_of, unreadable
from bladewhirl.meshes.files.gmsh import TAG, gmsh_mesh, is_member, unnamed_groups
from bladewhirl.meshes.files.groups import MeshFileError, OtherCellsError
from bladewhirl.meshes.files.med import med_mesh
from bladewhirl.meshes.files.meshio_cells import stacked
from bladewhirl.meshes.files.nastran_bulk import nastran_mesh
from bladewhirl.meshes.files.vtu import integer_groups, vtu_mesh
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

ELEMENTS = {
    "tetra": "C3D4",
    "tetra10": "C3D10",
    "wedge": "C3D6",
    "wedge15": "C3D15",
    "hexahedron": "C3D8",
    "hexahedron20": "C3D20",
    "hexahedron27": "C3D27",
}
"""Name of the element of each type of cell, named as in meshio, in meshes without such names. The
order of nodes is that of VTK."""


FARTHEST = 1e15  #: largest coordinate of a node


@dataclass(frozen=True, kw_only=True)
class VolumeMesh:
    """Mesh of a solid, in the unit of length of its source.

    Every node belongs to a cell.
    """

    points: FloatArray  #: positions of the nodes, (nodes, 3)
    blocks: tuple[tuple[str, IntArray], ...]
    """Name of the elements, as in Abaqus, and nodes of each cell in the order of VTK, (cells,
    nodes of a cell)."""
    groups: Mapping[str, IntArray] = field(default_factory=dict)  #: name -> numbers of nodes
    cell_groups: Mapping[str, IntArray] = field(default_factory=dict)
    """Name -> numbers of cells, counted through all blocks."""
    sections: tuple[Section, ...] = ()  #: materials of groups of cells in the file
    ignored: tuple[str, ...] = ()  #: what connects or loads nodes in the file and is not read
    rigid: tuple[tuple[str, IntArray], ...] = ()  #: keyword and nodes of each rigid body
    held: str = ""  #: group of the nodes that the file holds, if there is one
    name: str = ""  #: name of the file, without its folder
    rows: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Place of each node among the points of the source, (nodes,)."""


def read_volume_mesh(
    mesh: meshio.Mesh | str | PathLike[str], *, outside: bool = False
) -> VolumeMesh:
    """Read a mesh of a solid with its groups.

    A group contains the nodes of its cells, which may have any dimension. The groups of a Gmsh file
    are its physical groups of points, curves, surfaces and volumes; those without a name are named
    by dimension and number, such as ``surface 2``. The groups of an Abaqus file
    are its sets of nodes and of elements; the groups of a VTK file are the arrays of integers on
    points or cells that are 1 for members and 0 elsewhere. Cells of a lower dimension serve as
    groups only.

    Args:
        mesh: mesh of meshio, or path of a .msh file of Gmsh, a .vtu file, an .inp file of Abaqus or
            CalculiX, a .cdb file of Ansys, bulk data of Nastran (.bdf, .nas), or a .med file of
            Code_Aster. A file with another suffix whose text is that of Abaqus is read as such.
        outside: whether files that an .inp file names may be outside its folder.

    Raises:
        MeshFileError: the file cannot be read, or cells have an unsupported type; the text
            completes "expected ...".
    """
    if isinstance(mesh, meshio.Mesh):
        return _volumes(SolidMesh(mesh), "the mesh")
    file = Path(mesh)
    if file.exists() and not file.is_file():
        raise MeshFileError("a regular file")
    kind = format_of(file)
    if kind not in READERS:
        raise MeshFileError(unreadable(file, READERS))
    source = abaqus_mesh(file, outside=outside) if kind == ABAQUS else READERS[kind](file)
    return _volumes(source, file.name)


def merged(mesh: VolumeMesh, distance: float) -> VolumeMesh:
    """Return a mesh in which nodes within a distance of each other are one node, the first of them.

    Args:
        mesh: mesh.
        distance: largest distance, in the unit of length of the mesh; nothing is merged if it is 0.

    Raises:
        MeshFileError: cells would lie on one another.
    """
    if distance <= 0.0:
        return mesh
    place = places_of(mesh.points, distance)
    kept = np.unique(place, return_index=True)[1]
    if len(kept) == len(mesh.points):
        return mesh
    blocks = tuple((element, place[cells]) for element, cells in mesh.blocks)
    for element, cells in blocks:
        if twice := len(cells) - len(_once(cells)[0]):
            raise MeshFileError(
                f"cells at different places; {twice} of {len(cells)} elements {element} lie on"
                " others"
            )
    return replace(
        mesh,
        points=mesh.points[kept],
        blocks=blocks,
        groups={name: np.unique(place[nodes]) for name, nodes in mesh.groups.items()},
        rigid=tuple((text, np.unique(place[nodes])) for text, nodes in mesh.rigid),
        rows=mesh.rows[kept],
    )


def without_cells(mesh: VolumeMesh, nodes: IntArray) -> tuple[VolumeMesh, IntArray]:
    """Return a mesh without the cells all of whose nodes are given, and the numbers of its nodes in
    the mesh, ascending: nodes that belong to no cell any more are left out."""
    stays = [~np.isin(cells, nodes).all(axis=1) for _, cells in mesh.blocks]
    blocks = [
        (element, cells[kept])
        for (element, cells), kept in zip(mesh.blocks, stays, strict=True)
        if kept.any()
    ]
    used = np.unique(np.concatenate([cells.ravel() for _, cells in blocks]))
    place, cell = np.full(len(mesh.points), -1), np.concatenate(stays)
    place[used] = np.arange(len(used))
    number = np.where(cell, np.cumsum(cell) - 1, -1)

    def among(numbers: IntArray, given: IntArray) -> IntArray:
        return np.asarray(numbers[given][numbers[given] >= 0])

    rest = replace(
        mesh,
        points=mesh.points[used],
        blocks=tuple((element, place[cells]) for element, cells in blocks),
        groups={name: among(place, each) for name, each in mesh.groups.items()},
        cell_groups={name: among(number, each) for name, each in mesh.cell_groups.items()},
        rigid=tuple((text, among(place, each)) for text, each in mesh.rigid),
        rows=mesh.rows[used] if len(mesh.rows) else mesh.rows,
    )
    return rest, used


def _gmsh_mesh(path: Path) -> SolidMesh:
    return SolidMesh(gmsh_mesh(path))


def _vtu_mesh(path: Path) -> SolidMesh:
    return SolidMesh(vtu_mesh(path))


READERS: dict[str, Callable[[Path], SolidMesh]] = {
    ".vtu": _vtu_mesh,
    ".msh": _gmsh_mesh,
    ".inp": abaqus_mesh,
    ".cdb": ansys_mesh,
    ".bdf": nastran_mesh,
    ".nas": nastran_mesh,
    ".med": med_mesh,
}


def _volumes(source: SolidMesh, name: str) -> VolumeMesh:
    mesh = source.mesh
    solid = {n: block for n, block in enumerate(mesh.cells) if block.dim == 3 and len(block.data)}
    kinds = sorted({block.type for block in solid.values()})
    if not kinds or not set(kinds) <= ELEMENTS.keys():
        existing = f"found {', '.join(kinds)}" if kinds else "there are none"
        raise OtherCellsError(f"cells of the types {', '.join(ELEMENTS)}; {existing}")
    sources: dict[str, list[int]] = {}
    for number, block in solid.items():
        element = source.elements[number] if source.elements else ELEMENTS[block.type]
        sources.setdefault(element, []).append(number)
    blocks: dict[str, IntArray] = {}
    place_of: dict[int, IntArray] = {}  # the number of each cell of a block of the source
    total = repeated = 0
    for element, numbers in sources.items():
        parts = [mesh.cells[number].data for number in numbers]
        blocks[element], rank = _once(stacked(parts).astype(np.int64))
        split = np.split(total + rank, np.cumsum([len(part) for part in parts])[:-1])
        place_of |= dict(zip(numbers, split, strict=True))
        total += len(blocks[element])
        repeated += sum(map(len, parts)) - len(blocks[element])
    ends = [end for one in blocks.values() for end in (one.min(), one.max())]
    if not (min(ends) >= 0 and max(ends) < len(mesh.points)):
        raise MeshFileError("all nodes of the cells; some nodes are not defined")
    if {mesh.points.dtype.kind, *(one.data.dtype.kind for one in solid.values())} - {*"iuf"}:
        raise MeshFileError("coordinates and nodes of cells as numbers")
    # Meshes of Gmsh without elements and materials repeat cells for each of their groups.
    notes = [f"{repeated} elements with the nodes of others"] if repeated else []
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not np.all(abs(points) <= FARTHEST):
        raise MeshFileError(f"nodes with three finite coordinates of at most {FARTHEST:g}")
    used = np.unique(np.concatenate([one.ravel() for one in blocks.values()]))
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    groups: defaultdict[str, list[IntArray]] = defaultdict(list)
    cell_groups: defaultdict[str, list[IntArray]] = defaultdict(list)
    for key, nodes in (*mesh.point_sets.items(), *integer_groups(_named(mesh.point_data))):
        groups[key].append(place[np.asarray(nodes, dtype=np.int64)])
    for key, number, inside in _cell_groups(mesh):
        groups[key].append(place[mesh.cells[number].data[inside].ravel()])
        if number in place_of:
            cell_groups[key].append(place_of[number][inside])
    members = {key: np.unique(np.concatenate(nodes)) for key, nodes in groups.items()}
    return VolumeMesh(
        points=points[used],
        blocks=tuple((element, place[one]) for element, one in blocks.items()),
        groups={key: _used(nodes) for key, nodes in members.items()},
        cell_groups={key: np.unique(np.concatenate(one)) for key, one in cell_groups.items()},
        sections=source.sections,
        ignored=(*source.ignored, *(notes if source.elements or source.sections else ())),
        rigid=tuple((text, _used(place[nodes])) for text, nodes in source.rigid),
        held=source.held if len(_used(members.get(source.held, used[:0]))) else "",
        name=name,
        rows=used,
    )


def _used(places: IntArray) -> IntArray:
    """Return places of nodes in ascending order, each once, without -1 for unused nodes."""
    return np.unique(places[places >= 0])


def _once(cells: IntArray) -> tuple[IntArray, IntArray]:
    """Return the cells without those that have the nodes of an earlier cell, and the place of each
    cell among them. A file of Gmsh 2.2 repeats a cell for each of its groups."""
    same = np.unique(np.sort(cells, axis=1), axis=0, return_index=True, return_inverse=True)
    first = np.sort(same[1])
    return cells[first], np.searchsorted(first, same[1][same[2].ravel()])


def _cell_groups(mesh: meshio.Mesh) -> Iterator[tuple[str, int, IntArray]]:
    """Yield the name of each group of cells, the number of a block and its members there."""
    for key, members in mesh.cell_sets.items():
        if not key.startswith("gmsh:"):
            for number, inside in enumerate(members):
                if inside is not None and len(inside):
                    yield key, number, np.asarray(inside, dtype=int)
    for number, block in enumerate(mesh.cells):
        arrays = {key: values[number] for key, values in _named(mesh.cell_data).items()}
        for key, inside in integer_groups(arrays):
            yield key, number, inside
        # Without tags the field data are not groups of Gmsh.
        for key, (tag, dimension) in mesh.field_data.items() if TAG in mesh.cell_data else ():
            if block.dim == dimension:
                yield key, number, np.flatnonzero(is_member(mesh, number, key, tag))
        yield from ((key, number, inside) for key, inside in unnamed_groups(mesh, number))


def _named(arrays: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    return {key: values for key, values in arrays.items() if not key.startswith("gmsh:")}
