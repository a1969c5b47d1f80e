"""Symbols of what holds a stage: springs, dampers, struts, ground, rigid links, point masses.

Sizes are shares of the tip radius; only a strut has its true length. One end of a symbol moves
with the body that it holds, the other stands on the ground: that of the casing in static axes,
that of the shaft's springs in the axes that the case puts them in, that of its dampers in rotating
ones, since that is how the model has them.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.kinematics import Array, IntArray, rotate

SPRING = 0.075  #: length of a spring at rest
ZIGZAG = 0.016  #: half of its width
TEETH = 7
DASHPOT = 0.013  #: half of the width of a damper
CUP = 3.0  #: length of its cup, over that half width
GROUND = 0.022  #: half of the width of a piece of ground
HATCHES = 4
BESIDE = 0.048  #: from a spring or strut to the damper beside it
BRACKET = 0.03  #: from the wall to a spring along it, which is clear of it
FOUNDATION = 36  #: springs that stand for a casing's uniform support
SMALL = 0.6  #: their size, and that of the shaft's, compared with single springs
SHAFT_SPRING = 2.4  #: length of the shaft's springs, compared with others as small
MASS = 0.02  #: radius of the largest point mass


NO_STROKES = np.zeros((0, 2, 2))


class Symbols(NamedTuple):
    """Drawn symbols: strokes (stroke, 2, 2), from end to end, and discs."""

    springs: Array = NO_STROKES
    dampers: Array = NO_STROKES
    ground: Array = NO_STROKES
    struts: Array = NO_STROKES  #: rigid links too
    masses: Array = NO_STROKES[:, 0]  #: middles (mass, 2)


Kind = Literal["spring", "damper", "strut"]


class _Holders(NamedTuple):
    """Things of one kind that hold the casing, each at its foot on the wall."""

    kind: Kind
    angles: Array  #: of their feet (foot,) [rad]
    ways: Array  #: from foot to ground (foot, 2)
    lift: Array  #: of the bracket that they start from, over the wall (foot,)
    scale: float = 1.0  #: of their size


class StageSymbols:
    """All symbols of a stage; the casing's stations at `angles` (station,) carry its supports.

    Springs of the casing are longer by `room` [m], what it is drawn to move outward.
    """

    def __init__(self, dataset: xr.Dataset, angles: Array, room: float = 0.0) -> None:
        radius = float(dataset.attrs["tip_radius"])
        self._on_casing = CasingSymbols(dataset, radius, room)
        self._on_shaft = ShaftSymbols(dataset, radius)
        self._on_rotor = RotorSymbols(dataset, radius)
        away = np.angle(np.exp(1j * (self._on_casing.angles[:, None] - angles)))
        self._feet = np.argmin(np.abs(away), axis=1)

    def drawn(
        self, wall: Array, rest: Array, centre: Array, nodes: Array, ahead: float = 0.0
    ) -> tuple[Symbols, ...]:
        """Symbols of casing, shaft's springs, its dampers and rotor, each in axes of its own.

        Args:
            wall: drawn outer surface (station, 2) [m].
            rest: the same at rest.
            centre: drawn, in rotating axes (2,) [m].
            nodes: drawn, in rotating axes (rotor_node, 2) [m].
            ahead: of the rotating axes, seen from the static ones [rad].
        """
        return (
            self._on_casing.symbols(wall[self._feet], rest[self._feet]),
            self._on_shaft.springs(rotate(centre, ahead * self._on_shaft.static)),
            self._on_shaft.dampers(centre),
            self._on_rotor.symbols(nodes),
        )

    def together(
        self, symbols: tuple[Symbols, ...], casing_turn: float, rotor_turn: float
    ) -> Symbols:
        """What `drawn` gives, turned from the axes of casing and rotor by angles [rad]."""
        spring_turn = casing_turn if self._on_shaft.static else rotor_turn
        turns = (casing_turn, spring_turn, rotor_turn, rotor_turn)
        turned = [
            Symbols(*(rotate(shapes, angle) if len(shapes) else shapes for shapes in each))
            for each, angle in zip(symbols, turns, strict=True)
        ]
        return Symbols(*(np.concatenate(shapes) for shapes in zip(*turned, strict=True)))


class CasingSymbols:
    """Supports of the casing, in static axes, with its feet on the wall's outer surface at
    `angles` (foot,).
    """

    def __init__(self, dataset: xr.Dataset, radius: float, room: float = 0.0) -> None:
        holders = _holders(dataset, radius, room)
        count = [len(each.angles) for each in holders]
        self._kind = np.repeat([each.kind for each in holders], count)
        self._scale = radius * np.repeat([each.scale for each in holders], count)
        self.angles = np.concatenate([each.angles for each in holders])
        self._way = np.concatenate([each.ways for each in holders])
        lift = np.concatenate([each.lift for each in holders])
        self._lifted = lift > 0
        self._bracket = lift[:, None] * _outward(self.angles)

    def symbols(self, foot: Array, rest: Array) -> Symbols:
        """Symbols for drawn feet (foot, 2), and those at rest, by which the ground stands."""
        start, end = foot + self._bracket, rest + self._bracket + self._way
        spring, damper, strut = (self._kind == kind for kind in ("spring", "damper", "strut"))
        brackets = np.stack([foot, start], axis=1)[self._lifted]
        return Symbols(
            springs=_zigzags(start[spring], end[spring], ZIGZAG * self._scale[spring]),
            dampers=_dashpots(start[damper], end[damper], DASHPOT * self._scale[damper]),
            ground=_grounds(end, _unit(self._way), GROUND * self._scale),
            struts=np.concatenate([brackets, np.stack([start, end], axis=1)[strut]]),
        )


def _holders(dataset: xr.Dataset, radius: float, room: float) -> list[_Holders]:
    """Springs, dampers and struts between casing and ground: those of an angle side by side."""
    founded = float(dataset.get("casing_foundation", 0.0)) > 0
    around = 2 * np.pi * (np.arange(FOUNDATION if founded else 0) + 0.5) / FOUNDATION
    length = radius * SPRING
    uniform = _Holders(
        "spring", around, (SMALL * length + room) * _outward(around), 0.0 * around, scale=SMALL
    )
    if "support_kind" not in dataset:
        return [uniform]
    strut = dataset["support_kind"].values.astype(str) == "strut"
    angle, reach = dataset["support_angle"].values, dataset["support_reach"].values
    (sprung_out, damped_out), (sprung_along, damped_along) = (
        [
            _positive(dataset, f"support_{way}_{what}", len(strut))
            for what in ("stiffness", "damping")
        ]
        for way in ("radial", "tangential")
    )
    radial = ~strut & (sprung_out | damped_out)
    outward = (length + room) * _outward(angle)
    along = length * rotate(_outward(angle), np.pi / 2)
    level = np.full(len(angle), radius * BRACKET)
    aside = angle + BESIDE * radial  # clear of what leads outward from the same foot

    flat = 0.0 * level
    beside_spring = level + radius * BESIDE * sprung_along
    every: list[tuple[Kind, NDArray[np.bool_], Array, Array, Array]] = [
        ("spring", ~strut & sprung_out, angle, outward, flat),
        ("damper", ~strut & damped_out, angle - BESIDE * sprung_out, outward, flat),
        ("spring", ~strut & sprung_along, aside, along, level),
        ("damper", ~strut & damped_along, aside, along, beside_spring),
        ("strut", strut, angle, reach, flat),
        ("damper", strut & (damped_out | damped_along), angle - BESIDE, reach, flat),
    ]
    return [
        uniform,
        *(
            _Holders(kind, angles[which], ways[which], lift[which])
            for kind, which, angles, ways, lift in every
        ),
    ]


class RotorSymbols:
    """Attachments of the bladed disk, in rotating axes: springs between nodes, masses, links."""

    def __init__(self, dataset: xr.Dataset, radius: float) -> None:
        self._size = radius
        self._nodes = dataset["rotor_point"].values
        self.links: IntArray = _optional(dataset, "rotor_link", (0, 2))
        self.mass_nodes: IntArray = _optional(dataset, "mass_node", (0,))
        springs: IntArray = _optional(dataset, "rotor_spring", (0, 2))
        self._between = springs[springs[:, 1] >= 0]
        self._grounded = springs[springs[:, 1] < 0, 0]

    def symbols(self, drawn: Array) -> Symbols:
        """Symbols for drawn nodes (rotor_node, 2)."""
        small = SMALL * self._size
        held = self._nodes[self._grounded]
        ways = _unit(held) * small * SPRING
        start = np.concatenate([drawn[self._grounded], drawn[self._between[:, 0]]])
        end = np.concatenate([held + ways, drawn[self._between[:, 1]]])
        leader, led = (drawn[self.links[:, side]] for side in (1, 0))
        return Symbols(
            springs=_zigzags(start, end, ZIGZAG * small),
            ground=_grounds(held + ways, _unit(ways), GROUND * small),
            struts=np.stack([leader, led], axis=1),
            masses=drawn[self.mass_nodes],
        )


class ShaftSymbols:
    """Supports of the centre: springs along x and y, dampers along -x and -y, each of them in
    axes of their own.
    """

    def __init__(self, dataset: xr.Dataset, radius: float) -> None:
        held = bool(dataset.attrs.get("clamped", 0))
        self._size = SMALL * radius
        ways = SHAFT_SPRING * SPRING * self._size * np.eye(2)
        self._springs = ways[: 0 if held else 2]
        self._dampers = -self._springs[_positive(dataset, "shaft_damping", len(self._springs))]
        #: whether the springs stand in static axes
        self.static = str(dataset.get("shaft_frame", xr.DataArray("rotating")).values) == "static"

    def springs(self, centre: Array) -> Symbols:
        """Symbols of the springs, for the drawn centre (2,) in their axes."""
        strokes = _zigzags(*self._ends(centre, self._springs), ZIGZAG * self._size)
        return Symbols(springs=strokes, ground=self._ground(self._springs))

    def dampers(self, centre: Array) -> Symbols:
        """Symbols of the dampers, for the drawn centre (2,) in rotating axes."""
        strokes = _dashpots(*self._ends(centre, self._dampers), DASHPOT * self._size)
        return Symbols(dampers=strokes, ground=self._ground(self._dampers))

    def _ends(self, centre: Array, end: Array) -> tuple[Array, Array]:
        return np.broadcast_to(centre, end.shape), end

    def _ground(self, end: Array) -> Array:
        return _grounds(end, _unit(end), GROUND * self._size)


def sample(kind: str, start: Array, end: Array) -> Symbols:
    """A spring, damper or strut, one of `KINDS`, from a point (2,) to another."""
    width = float(0.18 * np.linalg.norm(end - start))
    return Symbols()._replace(**{kind: KINDS[kind][1](start[None], end[None], width)})


def _outward(angles: Array) -> Array:
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _optional(dataset: xr.Dataset, name: str, shape: tuple[int, ...]) -> IntArray:
    return dataset[name].values if name in dataset else np.zeros(shape, dtype=np.int64)


def _positive(dataset: xr.Dataset, name: str, count: int) -> NDArray[np.bool_]:
    """A mask of the first numbers of a variable that are positive; none where it is missing."""
    found = dataset[name].values[:count] > 0 if name in dataset else np.zeros(count)
    return np.asarray(found, dtype=np.bool_)


def _zigzags(start: Array, end: Array, half_width: Array | float) -> Array:
    """Strokes of springs from start to end (spring, 2): straight, teeth, straight."""
    knots = np.concatenate([[0.0], np.linspace(0.2, 0.8, TEETH), [1.0]])
    side = np.zeros(len(knots))
    side[2:-2] = np.where(np.arange(len(knots) - 4) % 2, -1.0, 1.0)
    aside = rotate(_unit(end - start), np.pi / 2) * _column(half_width)
    points = start[:, None] + knots[:, None] * (end - start)[:, None]
    points = points + side[:, None] * aside[:, None]
    return np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 2)


def _dashpots(start: Array, end: Array, half_width: Array | float) -> Array:
    """Strokes of dampers from start to end (damper, 2): rod and piston, cup and rod."""
    span = end - start
    length = np.linalg.norm(span, axis=1)
    cup = np.minimum(0.5 * CUP * np.asarray(half_width), 0.35 * length)
    # Along from the middle and aside, in halves of the cup and of its width.
    corners = np.array(
        [[0, 0], [0, -0.6], [0, 0.6], [1, -1], [1, 1], [-1, -1], [-1, 1], [1, 0]], dtype=np.float64
    )
    along, aside = _unit(span), rotate(_unit(span), np.pi / 2)
    points = ((start + end) / 2)[:, None] + (
        corners[:, :1] * (cup[:, None] * along)[:, None]
        + corners[:, 1:] * (_column(half_width) * aside)[:, None]
    )
    piston, left, right, foot_left, foot_right, top_left, top_right, bottom = np.moveaxis(
        points, 1, 0
    )
    strokes = [
        (start, piston),
        (left, right),
        (top_left, foot_left),
        (foot_left, foot_right),
        (foot_right, top_right),
        (bottom, end),
    ]
    return np.stack([np.stack(stroke, axis=1) for stroke in strokes], axis=1).reshape(-1, 2, 2)


def _grounds(at: Array, away: Array, half_width: Array | float) -> Array:
    """Strokes of hatched ground at points, whose body lies on the side of `away` (point, 2)."""
    aside = rotate(away, np.pi / 2) * _column(half_width)
    line = np.stack([at - aside, at + aside], axis=1)[:, None]
    place = np.linspace(-0.7, 1.0, HATCHES)[:, None]
    top = at[:, None] + place * aside[:, None]
    foot = top + (0.55 * away * _column(half_width))[:, None] - 0.45 * aside[:, None]
    hatches = np.stack([top, foot], axis=2)
    return np.concatenate([line, hatches], axis=1).reshape(-1, 2, 2)


def _column(sizes: Array | float) -> Array:
    """Sizes of symbols, or one of all, that multiply vectors (symbol, 2)."""
    return np.asarray(sizes)[..., None]


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))


def _bars(start: Array, end: Array, half_width: Array | float) -> Array:
    """Strokes of struts."""
    return np.stack([start, end], axis=1)


KINDS = {
    "springs": ("spring", _zigzags),
    "dampers": ("damper", _dashpots),
    "struts": ("strut or rigid link", _bars),
}
"""Symbols drawn by strokes from end to end: the name of one, and the function that makes them from
start (symbol, 2), end (symbol, 2) and half the width, (symbol,) or one of all."""
