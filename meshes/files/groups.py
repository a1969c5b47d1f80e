"""Contents of a mesh file before interpretation: points, lines, named groups and data."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, freeze

FLAT = 1e-6
"""A mesh is plane if its nodes are off the plane by at most this fraction of the size of the
mesh."""

SPRING = ("spring_radial", "spring_tangential", "spring_rotation")
"""Names of line data: stiffnesses of springs. A line with such data is a spring."""

RIGID = "rigid"  #: name of the line data that are 1 for rigid links


class MeshFileError(ValueError):
    """Error for an unreadable or unsuitable mesh file; the text completes "expected ..."."""


class OtherCellsError(MeshFileError):
    """Error for a mesh without the kind of cells that is looked for, lines or solids."""


CONSTANTS = {
    "young_modulus": "a positive Young's modulus",
    "poisson_ratio": "a Poisson's ratio from 0 to less than 0.5",
    "density": "a positive density",
}
"""What is expected of the constants of an isotropic material."""


def constant(key: str, value: float, place: str = "") -> float:
    """Return a constant of a material if solids can have it; `place` ends the message."""
    if not (0.0 <= value < 0.5 if key == "poisson_ratio" else 0.0 < value < inf):
        raise MeshFileError(f"{CONSTANTS[key]}, got {value:g}{place}")
    return value


def places_of_nodes(place: Mapping[int, int], element: int, nodes: Iterable[int]) -> list[int]:
    """Return the places of the nodes of an element.

    Raises:
        MeshFileError: a node is not defined.
    """
    try:
        return [place[node] for node in nodes]
    except KeyError as error:
        text = f"node {error.args[0]} of element {element} is not defined"
        raise MeshFileError(f"all nodes of the elements; {text}") from None


def check_numbers(lines: Iterable[str]) -> None:
    """Check that numbers, which other libraries read, have ASCII digits and no low lines."""
    for number, line in enumerate(lines, 1):
        for word in line.replace(",", " ").split() if "_" in line or not line.isascii() else ():
            foreign = "_" in word or not word.isascii()
            if foreign and re.fullmatch(r"[-+.]*\d[-+.\d_eEdD]*", word):
                raise MeshFileError(f"a number, got {word!r} (line {number})")


@dataclass(frozen=True, kw_only=True)
class GroupedLines:
    """Contents of a mesh file with straight two-node lines, in the unit of length of the file.

    Groups may overlap and may be empty; their members are in the order of the file. Data have one
    number for each node or line.
    """

    points: FloatArray  #: positions of the nodes, (nodes, 2)
    lines: IntArray  #: end nodes of each line, (lines, 2)
    node_groups: Mapping[str, IntArray] = field(default_factory=dict)  #: name -> numbers of nodes
    line_groups: Mapping[str, IntArray] = field(default_factory=dict)  #: name -> numbers of lines
    node_data: Mapping[str, FloatArray] = field(default_factory=dict)  #: name -> values (nodes,)
    line_data: Mapping[str, FloatArray] = field(default_factory=dict)  #: name -> values (lines,)
    ignored: tuple[str, ...] = ()  #: what the file says about the motion and is not read

    def __post_init__(self) -> None:
        freeze(self)

    @property
    def is_rigid(self) -> NDArray[np.bool_]:
        """Mask of the lines that are rigid links, (lines,)."""
        return self._has(RIGID)

    @property
    def is_beam(self) -> NDArray[np.bool_]:
        """Mask of the lines that are beams, that is, not springs or rigid links, (lines,)."""
        return ~self._has(RIGID, *SPRING)

    def _has(self, *names: str) -> NDArray[np.bool_]:
        none = np.zeros(len(self.lines))
        rows = [np.nan_to_num(self.line_data.get(name, none)) for name in names]
        return np.asarray(np.any(rows, axis=0))

    def beams(self) -> "GroupedLines":
        """Return the mesh without springs and rigid links."""
        beam = self.is_beam
        number = np.cumsum(beam) - 1
        groups = {name: lines[beam[lines]] for name, lines in self.line_groups.items()}
        return replace(
            self,
            lines=self.lines[beam],
            line_groups={
                name: number[lines]
                for name, lines in groups.items()
                if len(lines) or not len(self.line_groups[name])
            },
            line_data={
                name: values[beam]
                for name, values in self.line_data.items()
                if name not in (*SPRING, RIGID)
            },
        )


def in_plane(points: FloatArray) -> FloatArray:
    """Return x and y of points in a plane z = const, (nodes, 2).

    Args:
        points: coordinates x and y, (nodes, 2), or x, y and z, (nodes, 3).

    Raises:
        MeshFileError: coordinates are not finite, or the points are not in a plane z = const.
    """
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or not len(points):
        raise MeshFileError("a mesh of nodes with two or three coordinates")
    if not np.isfinite(points).all():
        bad = int((~np.isfinite(points)).any(axis=1).argmax()) + 1
        raise MeshFileError(f"finite coordinates; the coordinates of node {bad} are not finite")
    if points.shape[1] == 3:
        size = np.ptp(points[:, :2], axis=0).max()
        away = np.abs(points[:, 2] - points[0, 2])
        if away.max() > FLAT * size:
            x, y, z = points[int(away.argmax())]
            raise MeshFileError(
                f"a mesh in one plane z = {points[0, 2]:g}; a node is at ({x:g}, {y:g}, {z:g})"
            )
    return np.ascontiguousarray(points[:, :2])
