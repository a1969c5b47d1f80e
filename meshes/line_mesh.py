"""Line meshes in the plane: points, two-node lines, named sets, sectors."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]


def absent() -> Any:
    """Return the default of a field of a dataclass for an array that can be absent: an empty
    array."""
    return field(default_factory=lambda: np.zeros(0))


REAL = ("points", "node_axes", "node_data", "line_data")
"""Names of the fields of meshes that contain real numbers; the other fields contain integers."""

SAMPLES = 64  #: number of samples between two points to compute the length of a curve


@dataclass(frozen=True, kw_only=True)
class LineMesh:
    """A mesh of straight two-node lines in the plane, in metres.

    The mesh stores read-only copies of all arrays; to change a mesh, make a new one.
    """

    points: FloatArray  #: node positions [m], (nodes, 2)
    lines: IntArray  #: end nodes of each line, (lines, 2)
    node_axes: FloatArray
    """Angle of the first displacement axis of each node from +x [rad], (nodes,)."""
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)  #: name -> node numbers
    line_sets: Mapping[str, IntArray] = field(default_factory=dict)  #: name -> line numbers
    sectors: IntArray | None = None
    """Nodes of each sector, in the same order in every sector, (sectors, nodes per sector)."""

    def __post_init__(self) -> None:
        freeze(self)

    @property
    def lengths(self) -> FloatArray:
        """Length of each line [m], (lines,)."""
        return np.asarray(np.linalg.norm(self._spans, axis=1))

    @property
    def line_axes(self) -> FloatArray:
        """Angle of each line from +x [rad], (lines,)."""
        return np.asarray(np.arctan2(self._spans[:, 1], self._spans[:, 0]))

    @property
    def line_parts(self) -> list[str]:
        """Name of the line set of each line, "" if a line is in no set."""
        parts = [""] * len(self.lines)
        for name, numbers in self.line_sets.items():
            for number in numbers:
                parts[int(number)] = name
        return parts

    @property
    def _spans(self) -> FloatArray:
        ends = self.points[self.lines]
        return np.asarray(ends[:, 1] - ends[:, 0])


def freeze(mesh: Any) -> None:
    """Replace the arrays of a mesh by read-only copies; for the ``__post_init__`` of a mesh.
    Tuples of texts remain."""
    for item in fields(mesh):
        value = getattr(mesh, item.name)
        kind = np.float64 if item.name in REAL else np.int64
        if isinstance(value, Mapping):
            frozen: Any = {str(name): _frozen(array, kind) for name, array in value.items()}
            object.__setattr__(mesh, item.name, MappingProxyType(frozen))
        elif value is not None and not isinstance(value, tuple):
            object.__setattr__(mesh, item.name, _frozen(value, kind))


def _frozen(values: Any, kind: type) -> NDArray[Any]:
    array: NDArray[Any] = np.array(values, dtype=kind)
    array.setflags(write=False)
    return array


def points_along(given: FloatArray, elements: int) -> FloatArray:
    """Return the ends of elements of equal length along a centre line, (elements + 1, 2).

    Two points are connected by a straight line, more points by a cubic spline over the length of
    their chords. The first and the last point are returned without rounding.

    Args:
        given: points on the centre line in order [m], (points, 2); neighbours must differ.
        elements: number of elements.
    """
    share = np.linspace(0.0, 1.0, elements + 1)[:, None]
    if len(given) == 2:
        return np.asarray((1.0 - share) * given[0] + share * given[1])
    chords = np.linalg.norm(np.diff(given, axis=0), axis=1)
    knots = np.concatenate([[0.0], np.cumsum(chords)])
    from scipy.interpolate import CubicSpline  # here: slow to load

    curve = CubicSpline(knots, given)
    fine = np.interp(np.arange(SAMPLES * len(chords) + 1) / SAMPLES, np.arange(len(knots)), knots)
    steps = np.linalg.norm(np.diff(curve(fine), axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    points = np.asarray(curve(np.interp(share[:, 0] * length[-1], length, fine)))
    points[0], points[-1] = given[0], given[-1]
    return points


class Chain(NamedTuple):
    """Lines that lead from a root to a tip, in this order."""

    lines: IntArray  #: number of each line, (lines,)
    outward: BoolArray  #: true if the second end of a line is the end towards the tip, (lines,)
    root: int  #: first node; the tip itself if there is no line

    def ends(self, lengths: FloatArray) -> FloatArray:
        """Return the distance of the ends of the lines from the root [m], (lines + 1,).

        Args:
            lengths: length of each line of the mesh [m].
        """
        return np.concatenate([[0.0], np.cumsum(lengths[self.lines])])

    def place(self, share: float, lengths: FloatArray) -> tuple[int, float]:
        """Return the place at a share of the length from the root: position of the line in the
        chain, and position along this line from 0 at its first end to 1 at its second end."""
        ends = self.ends(lengths)
        at = share * ends[-1]
        number = min(int(np.searchsorted(ends, at, side="right")) - 1, len(self.lines) - 1)
        inside = float((at - ends[number]) / (ends[number + 1] - ends[number]))
        return number, inside if self.outward[number] else 1.0 - inside


def chain_to(tip: int, lines: IntArray, among: BoolArray) -> Chain:
    """Return the chain that ends at a tip and begins where its lines end or branch.

    Args:
        tip: node of the tip.
        lines: nodes at the ends of each line, (lines, 2).
        among: lines that can belong to the chain, (lines,).
    """
    left, node = among.copy(), int(tip)
    chain: list[tuple[int, bool]] = []
    while len(at_node := np.flatnonzero(left & (lines == node).any(axis=1))) == 1:
        (line,) = at_node.tolist()
        left[line] = False
        chain.append((line, bool(lines[line, 1] == node)))
        node = int(lines[line].sum()) - node
    numbers, outward = np.array(chain[::-1], dtype=np.int64).reshape(-1, 2).T
    return Chain(numbers, outward == 1, node)


def outward_line(points: FloatArray, lines: IntArray, tip: int) -> IntArray:
    """Return the line at a tip that points most outward, (1,), or none, (0,)."""
    at_tip = np.flatnonzero((lines == tip).any(axis=1))
    span = points[tip] - points[lines[at_tip].sum(axis=1) - tip]
    cosine = span @ points[tip] / np.linalg.norm(span, axis=1)
    return at_tip[np.argsort(-cosine, kind="stable")[:1]]


def part_up_to(tip: int, points: FloatArray, lines: IntArray, parts: NDArray[np.str_]) -> Chain:
    """Return the chain of a blade: of the part of the mesh whose line at the tip points most
    outward, up to a node where this part ends or branches.

    Args:
        tip: node of the tip.
        points: nodes, (nodes, 2) [m].
        lines: nodes at the ends of each line, (lines, 2).
        parts: part of the mesh of each line, (lines,).
    """
    first = outward_line(points, lines, tip)
    among = np.isin(parts, parts[first]) & (lines != tip).all(axis=1)
    among[first] = True
    return chain_to(tip, lines, among)
