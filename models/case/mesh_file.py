"""The `[bladed_disk.mesh]` table of a case: a mesh file and the meaning of its groups."""

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PlainValidator, PrivateAttr, StrictStr

from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.errors import LONGEST_VALUE, CaseError, Fault, shown
from bladewhirl.models.inputs.fields import Length, expectation, file_path, positive
from bladewhirl.models.inputs.rules import Inconsistency
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.rectangular import BeamSection

KEY = "bladed_disk.mesh"

SAME_PLACE = 1e-6
"""Two nodes closer than this fraction of the size of the mesh count as duplicates."""


def _metres(unit: str | float) -> float:
    """Return a unit of length in metres; "mm" means "1 mm"."""
    named = isinstance(unit, str) and re.match(r"\s*[A-Za-zµ]", unit)
    return positive("unit", f"1 {unit}" if named else unit, "m")


def _unit(value: Any) -> str | float:
    """Validate a unit of length and return it as the user wrote it, for messages and files."""
    try:
        _metres(value)
    except CaseError as error:
        raise expectation(error.faults[0].expected) from None
    return value  # type: ignore[no-any-return]


class MeshSection(BeamSection):
    """Section of the lines of a group; its sizes have no defaults."""

    width: Length
    """Size out of the plane of motion [m]."""
    thickness: Length
    """Size in the plane of motion [m]."""


class MeshTable(Table):
    """A mesh file of lines in the plane z = const, and the meaning of its groups.

    The groups of nodes and of lines become sets of the stage with the same names. The file is read
    when the table is made, because the case needs the number of blades and their tips.
    """

    file: Annotated[str, file_path('the path of a mesh file such as "stage.msh"')]
    """Path of a mesh file (.msh of Gmsh, .inp of Abaqus, or .vtu), relative to the case file."""
    unit: Annotated[str | float, PlainValidator(_unit)] = 1.0
    """Unit of length in the file, such as "mm", or the size of this unit in metres, such as
    0.001."""
    tips: StrictStr = "tips"
    """Name of the group of nodes at the blade tips, in any order. The tip of blade 0 is the one
    nearest to +x; the other blades follow counter-clockwise."""
    centre: StrictStr = "centre"
    """Name of the group with the node at the origin, on the shaft."""
    sections: dict[str, MeshSection] = Field(default={})
    """Section of each group of lines, { width, thickness, material }; material, a name in
    material.named, may be left out. Lines of other groups have the sections given in the mesh
    file."""
    tip_radius: Length | None = None
    """Radius from which the clearance is measured [m]; the largest tip radius by default."""

    def __hash__(self) -> int:
        """Return a hash of the contents; pydantic provides none for a table with a mapping."""
        return hash(self.model_dump_json())

    _tip_points: tuple[tuple[float, float], ...] = PrivateAttr(default=())

    @property
    def metres(self) -> float:
        """Unit of length in the file [m]."""
        return _metres(self.unit)

    @property
    def tip_points(self) -> tuple[tuple[float, float], ...]:
        """Points of the blade tips in blade order [m]."""
        return self._tip_points

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield errors for an unreadable file and for names that the file does not contain."""
        try:
            lines = self.lines()
            tips = self.tip_nodes(lines)
        except CaseError as error:
            for fault in error.faults:
                key = fault.key.removeprefix(f"{KEY}.")
                yield Inconsistency(key, fault.expected, fault.value)
        else:
            self._tip_points = tuple((x, y) for x, y in (lines.points[tips] * self.metres).tolist())

    def lines(self) -> GroupedLines:
        """Return the lines of the file with its groups, and check the groups named in this table.

        Raises:
            CaseError: the file cannot be read, a section names a group of lines that the file
                lacks, or a tip belongs to no line.
        """
        mesh = self._read()
        faults = [
            Fault(
                key=f"{KEY}.sections.{name}",
                value=section.model_dump(exclude_none=True),
                expected=self._one_of("lines", mesh.line_groups),
            )
            for name, section in self.sections.items()
            if name not in mesh.line_groups
        ] or [*self._bare_tips(mesh)]
        if faults:
            raise CaseError(faults)
        return _lines_only(mesh)

    def tip_nodes(self, mesh: GroupedLines) -> IntArray:
        """Return the tip nodes, counter-clockwise from the tip nearest to +x, (blades,).

        Raises:
            CaseError: there are no tip nodes.
        """
        nodes = self.group_nodes(mesh, "tips")
        angles = np.arctan2(*(mesh.points[nodes] * self.metres).T[::-1])
        order = np.argsort(angles)
        # If two tips are equally near, the small shift selects the tip at the positive angle.
        first = int(np.argmin(np.abs(angles[order] - SAME_PLACE)))
        return np.asarray(nodes[np.roll(order, -first)])

    def group_nodes(self, mesh: GroupedLines, key: str) -> IntArray:
        """Return in ascending order the nodes of the group named by a key of this table.

        Raises:
            CaseError: there are no such nodes.
        """
        name = getattr(self, key)
        if name not in mesh.node_groups:
            raise CaseError([self.fault(key, self._one_of("nodes", mesh.node_groups))])
        if not len(mesh.node_groups[name]):
            expected = (
                f"a group of nodes on lines; in {self.file_name} none of its nodes is on a line"
            )
            raise CaseError([self.fault(key, expected)])
        return np.unique(mesh.node_groups[name])

    def fault(self, key: str, expected: str) -> Fault:
        """Return a fault at a key of the table."""
        values = {"file": _short(self.file), "sections": None}
        value = values.get(key, getattr(self, key))
        return Fault(key=f"{KEY}.{key}", value=value, expected=expected)

    @property
    def file_name(self) -> str:
        """Name of the file without folders."""
        return os.path.basename(self.file)

    def _read(self) -> GroupedLines:
        try:
            stamp = os.stat(self.file)
            return _cached(self.file, (stamp.st_mtime_ns, stamp.st_size))
        except OSError as error:
            expected = f"a readable file ({error.strerror})"
        except MeshFileError as error:
            expected = str(error)
        raise CaseError([self.fault("file", expected)]) from None

    def _bare_tips(self, mesh: GroupedLines) -> Iterator[Fault]:
        """Yield a fault if some of the tips, but not all, belong to no line: their blades are
        missing."""
        tips = np.unique(mesh.node_groups.get(self.tips, np.zeros(0, np.int64)))
        bare = np.setdiff1d(tips, mesh.lines)
        if 0 < len(bare) < len(tips):
            x, y = (mesh.points[bare[0]] * self.metres).tolist()
            yield self.fault(
                "tips",
                f"every node of the group on a line; of {len(tips)} nodes in {self.file_name}"
                f" {len(bare)} are on no line, the first at ({x:.4g}, {y:.4g}) m",
            )

    def _one_of(self, kind: str, groups: Mapping[str, IntArray]) -> str:
        existing = ", ".join(shown(name) for name in groups) or "none"
        return f"a group of {kind} of {self.file_name}: {existing}"


@lru_cache(maxsize=8)
def _cached(file: str, stamp: tuple[int, int]) -> GroupedLines:
    """Read a mesh once for all stages of a sweep. The stamp, time of change and size of the file,
    makes sure that a changed file is read again."""
    from bladewhirl.meshes.files.registry import read_line_mesh  # here: slow to load

    return read_line_mesh(file)


def _lines_only(mesh: GroupedLines) -> GroupedLines:
    """Return the mesh without nodes that belong to no line, such as centres of arcs."""
    used = np.unique(mesh.lines)
    number = np.full(len(mesh.points), -1)
    number[used] = np.arange(len(used))
    groups = {name: number[nodes] for name, nodes in mesh.node_groups.items()}
    return replace(
        mesh,
        points=mesh.points[used],
        lines=number[mesh.lines],
        node_groups={name: nodes[nodes >= 0] for name, nodes in groups.items()},
        node_data={name: values[used] for name, values in mesh.node_data.items()},
    )


def _short(path: str) -> str:
    """Return a path, or its form relative to the working directory if shorter; the start of a path
    that is too long for a message is cut."""
    path = min(path, os.path.relpath(path), key=len)
    return path if len(path) <= LONGEST_VALUE - 2 else f"...{path[5 - LONGEST_VALUE :]}"
