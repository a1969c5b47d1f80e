"""Symbols of supports and attachments: springs, dampers, struts, ground, rigid links, point masses.

Sizes are relative to the tip radius; only struts have their true length. One end of a support moves
with the body, the other end is fixed to the ground. As in the model, the ground is at rest in
static axes for the casing, in the axes that the case specifies for the springs of the shaft, and in
rotating axes for the dampers of the shaft.
"""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.kinematics import Array

SPRING = 0.075  #: length of a spring at rest
ZIGZAG = 0.016  #: half of the width of a spring
TEETH = 7
DASHPOT = 0.013  #: half of the width of a damper
GROUND = 0.022  #: half of the width of a piece of ground
HATCHES = 4
BESIDE = 0.048  #: angle between a spring or strut and the damper next to it [rad]
BRACKET = 0.03  #: distance of a tangential spring from the wall
FOUNDATION = 36  #: number of springs that represent a uniform support of the casing
SMALL = 0.6  #: relative size of the springs of a uniform support and of the shaft springs
SHAFT_SPRING = 2.4  #: length of the shaft springs, relative to the springs of a uniform support
MASS = 0.02  #: radius of a point mass

NO_STROKES = np.zeros((0, 2, 2))
NO_MASSES = np.zeros((0, 2))


class Symbols(NamedTuple):
    """Drawn symbols: strokes, given by their end points (stroke, 2, 2), and discs."""

    springs: Array = NO_STROKES
    dampers: Array = NO_STROKES
    ground: Array = NO_STROKES
    struts: Array = NO_STROKES  #: struts and rigid links
    masses: Array = NO_MASSES  #: centres of the discs of point masses (mass, 2)


Kind = Literal["springs", "dampers", "struts"]


class Holder(NamedTuple):
    """Supports of one kind between the casing and the ground."""

    kind: Kind
    angles: Array  #: angles of the attachment points on the wall (foot,) [rad]
    ways: Array  #: vectors from each attachment point to the ground (foot, 2) [m]
    lift: float = 0.0  #: height of the brackets on the wall that carry the supports [m]
    scale: float = 1.0  #: relative size of the symbols


class Symbol(NamedTuple):
    """Symbols of one kind between two points."""

    kind: Kind
    start: Array  #: (symbol, 2) [m]
    end: Array  #: (symbol, 2) [m]
    size: float  #: length with which relative widths are multiplied [m]
    #: vectors into the ground, which is drawn at the ends (symbol, 2); None for ends on a body
    grounded: Array | None = None


class StageSymbols:
    """All symbols of a stage.

    Args:
        dataset: a result.
        angles: angles of the casing's stations (station,) [rad].
        clearance: additional length of the springs of the casing [m], which gives space to the
            drawn motion of the casing.
    """

    def __init__(self, dataset: xr.Dataset, angles: Array, clearance: float = 0.0) -> None:
        self._radius = radius = float(dataset.attrs["tip_radius"])
        self._holders = _holders(dataset, radius, clearance)
        feet = np.concatenate([holder.angles for holder in self._holders])
        away = np.abs(np.angle(np.exp(1j * (feet[:, None] - angles))))
        count = [len(holder.angles) for holder in self._holders]
        self._feet = np.split(np.argmin(away, axis=1), np.cumsum(count)[:-1])
        springs = 0 if dataset.attrs.get("clamped", 0) else 2
        self._shaft_springs = (SHAFT_SPRING * SPRING * (SMALL * radius) * np.eye(2))[:springs]
        self._shaft_dampers = -self._shaft_springs[_positive(dataset, "shaft_damping", springs)]
        self._static_springs = str(dataset["shaft_frame"].values) == "static"
        self._nodes = dataset["rotor_point"].values
        self._links = _optional(dataset, "rotor_link", (0, 2))
        self._masses = _optional(dataset, "mass_node", (0,))
        self._springs = _optional(dataset, "rotor_spring", (0, 2))

    def drawn(
        self, wall: Array, rest: Array, centre: Array, nodes: Array, ahead: float = 0.0
    ) -> tuple[Symbols, ...]:
        """Return four groups of symbols: casing, springs of the shaft, dampers of the shaft, rotor.

        The casing is in static axes, the springs of the shaft are in static or rotating axes, as
        the case specifies, dampers and rotor are in rotating axes.

        Args:
            wall: drawn outer surface of the casing (station, 2) [m].
            rest: drawn outer surface of the casing at rest (station, 2) [m].
            centre: drawn centre, in rotating axes (2,) [m].
            nodes: drawn nodes, in rotating axes (rotor_node, 2) [m].
            ahead: angle from the static to the rotating axes [rad].
        """
        size = SMALL * self._radius
        start = rotate(centre, ahead * self._static_springs)
        ends = self._shaft_springs, self._shaft_dampers
        springs = Symbol("springs", np.broadcast_to(start, ends[0].shape), ends[0], size, ends[0])
        dampers = Symbol("dampers", np.broadcast_to(centre, ends[1].shape), ends[1], size, ends[1])
        return (
            _strokes(self._on_casing(wall, rest)),
            _strokes([springs]),
            _strokes([dampers]),
            _strokes(self._on_rotor(nodes), nodes[self._masses]),
        )

    def together(
        self, symbols: tuple[Symbols, ...], casing_turn: float, rotor_turn: float
    ) -> Symbols:
        """Return the groups of `drawn` combined in the axes of the picture, in which the axes of
        casing and rotor have the given angles [rad]."""
        spring_turn = casing_turn if self._static_springs else rotor_turn
        turns = (casing_turn, spring_turn, rotor_turn, rotor_turn)
        turned = [
            Symbols(*(rotate(shapes, angle) if len(shapes) else shapes for shapes in group))
            for group, angle in zip(symbols, turns, strict=True)
        ]
        return Symbols(*(np.concatenate(shapes) for shapes in zip(*turned, strict=True)))

    def _on_casing(self, wall: Array, rest: Array) -> Iterator[Symbol]:
        for holder, feet in zip(self._holders, self._feet, strict=True):
            bracket = holder.lift * directions(holder.angles)
            start, end = wall[feet] + bracket, rest[feet] + bracket + holder.ways
            size = self._radius * holder.scale
            yield Symbol(holder.kind, start, end, size, holder.ways)
            if holder.lift:
                yield Symbol("struts", wall[feet], start, size)

    def _on_rotor(self, nodes: Array) -> Iterator[Symbol]:
        """Yield springs to the ground and between nodes, and rigid links."""
        size = SMALL * self._radius
        first, second = self._springs.T
        to_ground = first[second < 0]
        ways = unit(self._nodes[to_ground]) * size * SPRING
        yield Symbol("springs", nodes[to_ground], self._nodes[to_ground] + ways, size, ways)
        yield Symbol("springs", nodes[first[second >= 0]], nodes[second[second >= 0]], size)
        yield Symbol("struts", nodes[self._links[:, 1]], nodes[self._links[:, 0]], size)


def _holders(dataset: xr.Dataset, radius: float, clearance: float) -> list[Holder]:
    """Return springs, dampers and struts between casing and ground; supports at the same angle are
    side by side."""
    founded = float(dataset.get("casing_foundation", 0.0)) > 0
    around = 2 * np.pi * (np.arange(FOUNDATION if founded else 0) + 0.5) / FOUNDATION
    length = radius * SPRING
    uniform = (SMALL * length + clearance) * directions(around)
    holders = [Holder("springs", around, uniform, scale=SMALL)]
    if "support" not in dataset.dims:
        return holders
    strut = dataset["support_kind"].values.astype(str) == "strut"
    angle, reach = dataset["support_angle"].values, dataset["support_reach"].values
    (sprung_out, damped_out), (sprung_along, damped_along) = (
        [
            _positive(dataset, f"support_{way}_{what}", len(strut))
            for what in ("stiffness", "damping")
        ]
        for way in ("radial", "tangential")
    )
    outward = (length + clearance) * directions(angle)
    along = length * rotate(directions(angle), np.pi / 2)
    aside = angle + BESIDE * (~strut & (sprung_out | damped_out))  # next to the radial symbols
    low, high = radius * BRACKET, radius * (BRACKET + BESIDE)
    table: list[tuple[Kind, NDArray[np.bool_], Array, Array, float]] = [
        ("springs", ~strut & sprung_out, angle, outward, 0.0),
        ("dampers", ~strut & damped_out, angle - BESIDE * sprung_out, outward, 0.0),
        ("springs", ~strut & sprung_along, aside, along, low),
        ("dampers", ~strut & damped_along & ~sprung_along, aside, along, low),
        ("dampers", ~strut & damped_along & sprung_along, aside, along, high),
        ("struts", strut, angle, reach, 0.0),
        ("dampers", strut & (damped_out | damped_along), angle - BESIDE, reach, 0.0),
    ]
    return holders + [
        Holder(kind, angles[here], ways[here], lift) for kind, here, angles, ways, lift in table
    ]


def sample(kind: str, start: Array, end: Array) -> Symbols:
    """Return a symbol of one of the `KINDS` from the point `start` (2,) to the point `end` (2,)."""
    width = float(0.18 * np.linalg.norm(end - start))
    return Symbols()._replace(**{kind: _placed(SHAPES[kind], start[None], end[None], width)})


def _strokes(parts: Iterable[Symbol], masses: Array = NO_MASSES) -> Symbols:
    """Return the strokes of symbols, with the discs of point masses at `masses`."""
    strokes: dict[str, list[Array]] = {kind: [NO_STROKES] for kind in (*SHAPES, "ground")}
    for kind, start, end, size, grounded in parts:
        strokes[kind].append(_placed(SHAPES[kind], start, end, WIDTHS[kind] * size))
        if grounded is not None:
            half = GROUND * size
            ground = _placed(GROUND_SHAPE, end, end + half * unit(grounded), half)
            strokes["ground"].append(ground)
    return Symbols(masses=masses, **{kind: np.concatenate(s) for kind, s in strokes.items()})


def _optional(dataset: xr.Dataset, name: str, shape: tuple[int, ...]) -> NDArray[Any]:
    return dataset[name].values if name in dataset else np.zeros(shape, dtype=np.int64)


def _positive(dataset: xr.Dataset, name: str, count: int) -> NDArray[np.bool_]:
    """Return a mask of the first `count` values of a variable, true for positive values; all False
    if the dataset lacks the variable."""
    values = dataset[name].values[:count] > 0 if name in dataset else np.zeros(count)
    return np.asarray(values, dtype=np.bool_)


def _joined(points: list[tuple[float, float]]) -> Array:
    """Return the strokes between successive points, (stroke, 2, 2)."""
    return np.array([[start, end] for start, end in pairwise(points)])


def _placed(shape: Array, start: Array, end: Array, half_width: float) -> Array:
    """Return the strokes of symbols of one shape, (symbol * stroke, 2, 2).

    Args:
        shape: strokes (stroke, 2, 2); the first coordinate is relative to the length of a symbol,
            the second to half of its width.
        start: start of each symbol (symbol, 2) [m].
        end: end of each symbol (symbol, 2) [m].
        half_width: half of the width of the symbols [m].
    """
    span = (end - start)[:, None, None]
    aside = rotate(unit(span), np.pi / 2) * half_width
    strokes = start[:, None, None] + shape[..., :1] * span + shape[..., 1:] * aside
    return np.asarray(strokes.reshape(-1, 2, 2))


#: names of the symbols that connect two points
KINDS = {"springs": "spring", "dampers": "damper", "struts": "strut or rigid link"}
WIDTHS = {"springs": ZIGZAG, "dampers": DASHPOT, "struts": 0.0}  #: half widths of the symbols
SHAPES = {
    "springs": _joined(
        [
            (0.0, 0.0),
            *zip(np.linspace(0.2, 0.8, TEETH), [0, 1, -1, 1, -1, 1, 0], strict=True),
            (1.0, 0.0),
        ]
    ),
    "dampers": np.concatenate(
        [
            _joined([(0.0, 0.0), (0.5, 0.0)]),
            _joined([(0.5, -0.6), (0.5, 0.6)]),
            _joined([(0.35, -1.0), (0.65, -1.0), (0.65, 1.0), (0.35, 1.0)]),
            _joined([(0.65, 0.0), (1.0, 0.0)]),
        ]
    ),
    "struts": _joined([(0.0, 0.0), (1.0, 0.0)]),
}
"""Strokes of each kind of symbol, in the relative coordinates of `_placed`."""

GROUND_SHAPE = np.concatenate(
    [
        _joined([(0.0, -1.0), (0.0, 1.0)]),
        *(_joined([(0.0, y), (0.55, y - 0.45)]) for y in np.linspace(-0.7, 1.0, HATCHES)),
    ]
)
"""Strokes of hatched ground, in the relative coordinates of `_placed`."""
