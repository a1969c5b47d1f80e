"""Positions of the nodes of bulk data of Nastran in the basic coordinate system."""

from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.nastran_entries import Entry
from bladewhirl.meshes.line_mesh import FloatArray

RECTANGULAR, CYLINDRICAL, SPHERICAL = "RCS"
"""Last letters of the names of coordinate systems: x, y, z; r, angle [degrees], z; r, angle from
the z axis and angle about it [degrees]."""

SYSTEMS = tuple(f"CORD{how}{kind}" for how in "12" for kind in "RCS")
"""Entries of coordinate systems: 1 by three nodes, 2 by three points."""

Frame = tuple[str, FloatArray, FloatArray]
"""Last letter of a coordinate system, its origin and its axes as columns, in basic coordinates."""

BASIC: Frame = (RECTANGULAR, np.zeros(3), np.eye(3))


def basic_points(
    nodes: Sequence[Entry], default: int, cards: Mapping[str, Sequence[Entry]]
) -> FloatArray:
    """Return the positions of nodes in the basic coordinate system, (nodes, 3).

    Args:
        nodes: entries GRID.
        default: coordinate system of the nodes that name none; 0 is the basic one.
        cards: all entries by name.

    Raises:
        MeshFileError: a coordinate system is missing, given twice or not valid.
    """
    frames = _Frames(nodes, default, cards)
    given = np.array([[one.real(place, 0.0) for place in (2, 3, 4)] for one in nodes])
    rows = defaultdict[int, list[int]](list)
    for row, one in enumerate(nodes):
        rows[one.whole(1, default)].append(row)
    for system, chosen in rows.items():
        if system:
            given[chosen] = _in_basic(given[chosen], frames.of(system))
    return given


class _Frames:
    """Coordinate systems of a file, found when they are needed."""

    def __init__(
        self, nodes: Sequence[Entry], default: int, cards: Mapping[str, Sequence[Entry]]
    ) -> None:
        self._nodes = {one.whole(0): one for one in nodes}
        self._default = default
        self._given: dict[int, tuple[Entry, int]] = {}
        self._known: dict[int, Frame | None] = {0: BASIC}
        for name in SYSTEMS:
            for entry in cards.get(name, ()):
                starts = (0,) if name[-2] == "2" else range(0, len(entry.fields), 4)
                for start in starts:
                    number = entry.whole(start)
                    if number in self._given:
                        raise MeshFileError(f"each coordinate system once; {number} is there twice")
                    self._given[number] = entry, start

    def of(self, number: int) -> Frame:
        """Return a coordinate system."""
        if number not in self._known:
            if number not in self._given:
                raise MeshFileError(
                    f"a coordinate system {number} of the types {', '.join(SYSTEMS)}, which nodes"
                    " have; there is none"
                )
            self._known[number] = None  # until it is known
            entry, start = self._given[number]
            points = (
                np.array([self._position(entry.whole(start + one)) for one in (1, 2, 3)])
                if entry.name[-2] == "1"
                else _in_basic(
                    np.array([entry.real(n, 0.0) for n in range(2, 11)]).reshape(3, 3),
                    self.of(entry.whole(1, 0)),
                )
            )
            self._known[number] = entry.name[-1], points[0], _axes(points, number)
        if (frame := self._known[number]) is None:
            raise MeshFileError(f"coordinate systems not defined by themselves; {number} is")
        return frame

    def _position(self, node: int) -> FloatArray:
        if (entry := self._nodes.get(node)) is None:
            raise MeshFileError(f"all nodes of the coordinate systems; node {node} is not defined")
        given = np.array([[entry.real(place, 0.0) for place in (2, 3, 4)]])
        return np.asarray(_in_basic(given, self.of(entry.whole(1, self._default)))[0])


def _axes(points: FloatArray, number: int) -> FloatArray:
    """Return the axes of a system with the number, from its origin, a point of its z axis and one
    of its plane of x and z."""
    z, x = points[1:] - points[0]
    y = np.cross(z, x)
    if not min(np.linalg.norm(z), np.linalg.norm(y)) > 0.0:
        raise MeshFileError(f"three points that are not in a line for coordinate system {number}")
    y, z = y / np.linalg.norm(y), z / np.linalg.norm(z)
    return np.column_stack([np.cross(y, z), y, z])


def _in_basic(points: FloatArray, frame: Frame) -> FloatArray:
    kind, origin, axes = frame
    first, second, third = points.T
    angle = np.radians(second)
    if kind == CYLINDRICAL:
        points = np.column_stack([first * np.cos(angle), first * np.sin(angle), third])
    elif kind == SPHERICAL:
        about, radius = np.radians(third), first * np.sin(angle)
        across = (radius * np.cos(about), radius * np.sin(about))
        points = np.column_stack([*across, first * np.cos(angle)])
    return np.asarray(origin + points @ axes.T)
