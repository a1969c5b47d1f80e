"""Reading and writing of line meshes of Gmsh, .msh: versions 4.1 and 2.2, text or binary.

Groups are physical groups: of points for nodes, of curves for lines. Data are stored as groups too:
the members of a group with the name ``thickness=0.01`` have the value 0.01 of ``thickness``. Data
are therefore preserved when a mesh is refined in Gmsh.

meshio reads the files. This module writes files of version 4.1 itself, because the writer of meshio
allows only one group for each element.
"""

import re
import shlex
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any, TextIO

import meshio
import numpy as np

from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError, in_plane
from bladewhirl.meshes.files.meshio_cells import POINT, line_blocks, readable, stacked
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

VERSIONS = ("4.1", "2.2")
"""Supported versions of the format; meshio cannot read files of version 4.0 written by Gmsh 4."""

TAG, ENTITY = "gmsh:physical", "gmsh:geometrical"
VALUE = re.compile(
    r"(?P<name>[A-Za-z]\w*)\s*=\s*(?P<value>[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?)", re.I
)

ALONE = "lines"
"""Name of the group for all lines without a group, because meshio cannot read such elements."""

LARGEST_NUMBER = 10_000_000
"""Largest number of a node, and largest count of nodes or elements; meshio allocates arrays of this
length."""

DIMENSIONS = ("point", "curve", "surface", "volume")

LINE_TYPE, POINT_TYPE = 1, 15  #: numbers of the element types two-node line and point in Gmsh


def read_msh(path: Path) -> GroupedLines:
    """Read a .msh file.

    Raises:
        MeshFileError: the file is not a valid .msh file, has other cells than lines and points, or
            has two physical groups with the same name, of which meshio would lose one.
    """
    mesh = gmsh_mesh(path)
    blocks = line_blocks(mesh)
    lines = stacked([mesh.cells[block].data for block in blocks]).astype(np.int64)
    homes = _homes(lines, *(_tags(mesh, blocks, name) for name in (ENTITY, TAG)))
    kept, number = np.unique(homes, return_inverse=True)
    node_groups, line_groups = {}, {}
    for name, (tag, dimension) in mesh.field_data.items():
        if dimension == 0:
            nodes = [
                block.data[is_member(mesh, number, name, tag)].ravel().astype(np.int64)
                for number, block in enumerate(mesh.cells)
                if block.type == POINT and len(block.data)
            ]
            node_groups[name] = stacked(nodes)
        elif dimension == 1:
            member = stacked([is_member(mesh, block, name, tag) for block in blocks])
            line_groups[name] = np.unique(number[np.flatnonzero(member)])
    return GroupedLines(
        points=in_plane(mesh.points),
        lines=lines[kept],
        node_groups={k: v for k, v in node_groups.items() if not VALUE.fullmatch(k)},
        line_groups={k: v for k, v in line_groups.items() if not VALUE.fullmatch(k)},
        node_data=_data(len(mesh.points), node_groups),
        line_data=_data(len(kept), line_groups),
    )


def gmsh_mesh(path: Path) -> meshio.Mesh:
    """Return the contents of a .msh file as meshio reads them.

    Raises:
        MeshFileError: the file is not a .msh file that meshio can read.
    """
    _check_head(path)
    with readable(path):
        try:
            return meshio.gmsh.read(str(path))
        except ValueError as error:
            if f"Incompatible cell data '{TAG}'" in str(error):
                raise MeshFileError(
                    "a .msh file with all its elements in physical groups (Mesh.SaveAll = 0)"
                ) from None
            raise


def _check_head(path: Path) -> None:
    """Check the version, the names of physical groups, and the numbers of nodes and elements.

    Raises:
        MeshFileError: meshio cannot read the file.
    """
    blocks: dict[str, list[int]] = defaultdict(list)
    section, binary = b"", False
    with readable(path), path.open("rb") as stream:
        for line in stream:
            section = line.strip() if line.startswith(b"$") else section
            if section in (b"$Nodes", b"$Elements") and not binary:
                if any(word.isdigit() and int(word) > LARGEST_NUMBER for word in line.split()):
                    raise MeshFileError(f"node and element numbers of at most {LARGEST_NUMBER}")
            if line.strip() == b"$MeshFormat":
                version, kind = stream.readline().decode().split()[:2]
                binary = kind != "0"
                if version not in VERSIONS:
                    raise MeshFileError(
                        f"a .msh file of version {' or '.join(VERSIONS)} "
                        f"(Mesh.MshFileVersion = {VERSIONS[0]}), not {version}"
                    )
            if line.strip() == b"$PhysicalNames":
                for _ in range(int(stream.readline())):
                    dimension, _, name = shlex.split(stream.readline().decode())
                    blocks[name].append(int(dimension))
                if binary:
                    break
    for name, dimensions in blocks.items():
        if len(dimensions) > 1:
            kinds = " and ".join(f"{DIMENSIONS[d]}s" for d in dimensions)
            raise MeshFileError(
                f"at most one physical group for each name; {kinds} share the name {name!r}"
            )


def is_member(mesh: meshio.Mesh, block: int, name: str, tag: int) -> Any:
    """Return a mask of the cells of a block that are in a physical group. Files of version 4.1 have
    sets of cells, files of version 2.2 have tags."""
    size = len(mesh.cells[block].data)
    if name in mesh.cell_sets:
        return np.isin(np.arange(size), mesh.cell_sets[name][block].astype(np.int64))
    return mesh.cell_data[TAG][block] == tag


def unnamed_groups(mesh: meshio.Mesh, block: int) -> Iterator[tuple[str, IntArray]]:
    """Yield the physical groups without a name, named such as ``surface 2``, and their cells in a
    block. Of several groups of a cell in a file of version 4.1, meshio reads the first one."""
    if TAG not in mesh.cell_data:
        return
    tags, dimension = mesh.cell_data[TAG][block], mesh.cells[block].dim
    named = [tag for tag, size in mesh.field_data.values() if size == dimension]
    for tag in np.setdiff1d(tags, [0, *named]).tolist():
        yield f"{DIMENSIONS[dimension]} {tag}", np.flatnonzero(tags == tag)


def _tags(mesh: meshio.Mesh, blocks: list[int], name: str) -> IntArray:
    if name not in mesh.cell_data:
        return np.zeros(sum(len(mesh.cells[block].data) for block in blocks), dtype=np.int64)
    return stacked([mesh.cell_data[name][block] for block in blocks]).astype(np.int64)


def _homes(lines: IntArray, entity: IntArray, group: IntArray) -> IntArray:
    """Return for each line the number of its first occurrence among the lines.

    In version 2.2 an element is repeated for each of its groups. A line that occurs twice in the
    same group, or on two curves, counts as two lines, which later checks report.
    """
    copies: Counter[tuple[int, ...]] = Counter()
    homes: dict[tuple[int, ...], int] = {}
    entities = np.zeros(len(lines), dtype=np.int64)
    rows = np.column_stack([lines, entity, group]).tolist()
    for number, (*place, tag) in enumerate(rows):
        repeat = copies[*place, tag]
        copies[*place, tag] += 1
        entities[number] = homes.setdefault((*place, repeat), number)
    return entities


def _data(size: int, groups: Mapping[str, IntArray]) -> dict[str, FloatArray]:
    """Return data encoded in the names of groups; NaN for nodes or lines without a value."""
    data: dict[str, FloatArray] = {}
    for group, members in groups.items():
        match = VALUE.fullmatch(group)
        if match is not None:
            values = data.setdefault(match["name"], np.full(size, np.nan))
            values[members] = float(match["value"])
    return data


def write_msh(path: Path, mesh: GroupedLines) -> None:
    """Write a .msh file of version 4.1 as text.

    `read_msh` returns the nodes, lines, groups and data of this mesh, but in another order.

    Raises:
        MeshFileError: a group of nodes and a group of lines have the same name, or a name is not
            allowed.
    """
    both = sorted(set(mesh.node_groups) & set(mesh.line_groups))
    both += sorted(set(mesh.node_data) & set(mesh.line_data))
    if both:
        raise MeshFileError(
            f"for .msh, different names for nodes and for lines; both have {both[0]!r}"
        )
    for name in [*mesh.node_groups, *mesh.line_groups]:
        if '"' in name or "\\" in name or not name.isprintable() or VALUE.fullmatch(name):
            raise MeshFileError(
                f"for .msh, names without quotes and without '= number', not {name!r}"
            )
    groups = (
        dict(mesh.node_groups) | _value_groups(mesh.node_data),
        dict(mesh.line_groups) | _value_groups(mesh.line_data),
    )
    alone = np.setdiff1d(np.arange(len(mesh.lines)), np.concatenate([[], *groups[1].values()]))
    if len(alone):
        groups[1][ALONE] = alone
    node_entity, node_tags = _entities(len(mesh.points), groups[0], 0)
    line_entity, line_tags = _entities(len(mesh.lines), groups[1], len(groups[0]))
    # Each node that is in a group is a geometric point; other nodes are on curves.
    grouped = np.flatnonzero([bool(tags) for tags in node_tags[node_entity]])
    curve_of = np.zeros(len(mesh.points), dtype=np.int64)
    curve_of[mesh.lines[::-1].T] = line_entity[::-1]
    with path.open("w", encoding="utf-8", newline="\n") as stream:
        stream.write("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n")
        tag = count(1)
        stream.write(f"$PhysicalNames\n{sum(map(len, groups))}\n")
        for dimension, names in enumerate(groups):
            stream.writelines(f'{dimension} {next(tag)} "{name}"\n' for name in names)
        stream.write("$EndPhysicalNames\n")
        stream.write(f"$Entities\n{len(grouped)} {len(line_tags)} 0 0\n")
        for node in grouped:
            x, y = mesh.points[node].tolist()
            stream.write(f"{node + 1} {x!r} {y!r} 0 {_list(node_tags[node_entity[node]])}\n")
        for curve, tags in enumerate(line_tags):
            ends = mesh.points[mesh.lines[line_entity == curve]].reshape(-1, 2)
            low, high = ends.min(axis=0).tolist(), ends.max(axis=0).tolist()
            box = f"{low[0]!r} {low[1]!r} 0 {high[0]!r} {high[1]!r} 0"
            stream.write(f"{curve + 1} {box} {_list(tags)} 0\n")
        stream.write("$EndEntities\n")
        _write_nodes(stream, mesh.points, grouped, curve_of)
        _write_elements(stream, mesh.lines, grouped, line_entity)


def _value_groups(data: Mapping[str, FloatArray]) -> dict[str, IntArray]:
    return {
        f"{name}={value!r}": np.flatnonzero(values == value)
        for name, values in data.items()
        for value in np.unique(values[np.isfinite(values)]).tolist()
    }


def _entities(size: int, groups: Mapping[str, IntArray], before: int) -> tuple[IntArray, Any]:
    """Assign nodes or lines to geometric entities, with one entity for each combination of groups.

    In Gmsh the members of a group are entities, not single nodes or lines.

    Args:
        size: number of nodes or lines.
        groups: numbers of the members of each group.
        before: number of groups with smaller tags.

    Returns:
        entity of each node or line, from 0, (size,), and the tags of the groups of each entity.
    """
    member = np.zeros((size, len(groups)), dtype=np.bool_)
    for column, numbers in enumerate(groups.values()):
        member[numbers, column] = True
    kinds, entity = np.unique(member, axis=0, return_inverse=True)
    tags = np.empty(len(kinds), dtype=object)
    tags[:] = [(np.flatnonzero(kind) + before + 1).tolist() for kind in kinds]
    return entity.ravel(), tags


def _write_nodes(stream: TextIO, points: FloatArray, grouped: IntArray, curve_of: IntArray) -> None:
    alone = np.setdiff1d(np.arange(len(points)), grouped)
    blocks = [(0, int(node) + 1, np.array([node])) for node in grouped]
    for curve in np.unique(curve_of[alone]):
        blocks.append((1, int(curve) + 1, alone[curve_of[alone] == curve]))
    stream.write(f"$Nodes\n{len(blocks)} {len(points)} 1 {len(points)}\n")
    for dimension, tag, nodes in blocks:
        stream.write(f"{dimension} {tag} 0 {len(nodes)}\n")
        stream.writelines(f"{node + 1}\n" for node in nodes)
        stream.writelines(f"{x!r} {y!r} 0\n" for x, y in points[nodes].tolist())
    stream.write("$EndNodes\n")


def _write_elements(
    stream: TextIO, lines: IntArray, grouped: IntArray, line_entity: IntArray
) -> None:
    curves = np.unique(line_entity)
    total = len(grouped) + len(lines)
    number = count(1)
    stream.write(f"$Elements\n{len(grouped) + len(curves)} {total} 1 {total}\n")
    for node in grouped:
        stream.write(f"0 {node + 1} {POINT_TYPE} 1\n{next(number)} {node + 1}\n")
    for curve in curves:
        mine = lines[line_entity == curve] + 1
        stream.write(f"1 {curve + 1} {LINE_TYPE} {len(mine)}\n")
        stream.writelines(f"{next(number)} {first} {second}\n" for first, second in mine.tolist())
    stream.write("$EndElements\n")


def _list(tags: list[int]) -> str:
    return " ".join(map(str, [len(tags), *tags]))
