"""Symbols of what holds a stage: springs, struts, ground, rigid links, point masses.

Sizes are shares of the tip radius; only a strut has its true length. One end of a symbol moves
with the body that it holds, the other stands on the ground: that of the casing in static axes,
that of the shaft's springs in rotating ones, since that is how the model has them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields import Array, IntArray, rotate

SPRING = 0.075  #: length of a spring at rest
ZIGZAG = 0.016  #: half of its width
TEETH = 7
GROUND = 0.022  #: half of the width of a piece of ground
HATCHES = 4
FOUNDATION = 36  #: springs that stand for a casing's uniform support
SMALL = 0.6  #: their size, and that of the shaft's, compared with single springs
MASS = 0.02  #: radius of the largest point mass


class Symbols(NamedTuple):
    """Drawn symbols: strokes (stroke, 2, 2), from end to end, and discs."""

    springs: Array
    ground: Array
    struts: Array  #: rigid links too
    masses: Array  #: middles (mass, 2)


class CasingFittings:
    """What holds the casing, in static axes, with its feet on the wall's outer surface at
    `angles` (foot,).
    """

    def __init__(self, dataset: xr.Dataset, radius: float) -> None:
        self._size = size = radius
        strut = np.zeros(0, dtype=bool)
        if "support_kind" in dataset:
            strut = dataset["support_kind"].values.astype(str) == "strut"
        angle = dataset["support_angle"].values if len(strut) else np.zeros(0)
        self._reach = dataset["support_reach"].values[strut] if len(strut) else np.zeros((0, 2))
        sprung = np.flatnonzero(~strut)
        radial, tangential = (
            sprung[dataset[f"support_{way}_stiffness"].values[sprung] > 0] if len(strut) else sprung
            for way in ("radial", "tangential")
        )
        founded = "casing_foundation" in dataset and float(dataset["casing_foundation"]) > 0
        around = 2 * np.pi * (np.arange(FOUNDATION if founded else 0) + 0.5) / FOUNDATION
        self.angles = np.concatenate([around, angle[radial], angle[tangential], angle[strut]])
        count = [len(around), len(radial), len(tangential), len(self._reach)]
        self._cut = np.cumsum(count)[:-1]
        outward = np.column_stack([np.cos(self.angles), np.sin(self.angles)])
        along = rotate(outward, np.pi / 2)
        share = np.repeat([SMALL, 1.0, 1.0, 0.0], count)[:, None]
        sideways = np.repeat([False, False, True, False], count)[:, None]
        self._way = size * SPRING * share * np.where(sideways, along, outward)
        self._way[self._cut[2] :] = self._reach
        # A spring along the wall starts from a bracket, clear of it.
        self._bracket = np.where(sideways, 0.03 * size * outward, 0.0)
        self._scale = np.repeat([SMALL, 1.0, 1.0, 1.0], count) * size

    def symbols(self, foot: Array, rest: Array) -> Symbols:
        """Symbols for drawn feet (foot, 2), and those at rest, by which the ground stands."""
        start, end = foot + self._bracket, rest + self._bracket + self._way
        struts = slice(int(self._cut[2]), None)
        sprung = slice(0, int(self._cut[2]))
        brackets = np.stack([foot, start], axis=1)[self._cut[1] : self._cut[2]]
        way = _unit(self._way)
        return Symbols(
            springs=_zigzags(start[sprung], end[sprung], ZIGZAG * self._scale[sprung]),
            ground=_grounds(end, way, GROUND * self._scale),
            struts=np.concatenate([brackets, np.stack([start, end], axis=1)[struts]]),
            masses=np.zeros((0, 2)),
        )


class RotorFittings:
    """What hangs on the rotor, in rotating axes: springs of the shaft, masses, links."""

    def __init__(self, dataset: xr.Dataset, radius: float) -> None:
        self._size = radius
        self._free = not int(dataset.attrs.get("clamped", 0))
        nodes = dataset["rotor_point"].values
        self._centre = int(dataset["centre_node"])
        self.links: IntArray = _optional(dataset, "rotor_link", (0, 2))
        self.mass_nodes: IntArray = _optional(dataset, "mass_node", (0,))
        springs: IntArray = _optional(dataset, "rotor_spring", (0, 2))
        self._between = springs[springs[:, 1] >= 0]
        self._grounded = springs[springs[:, 1] < 0, 0]
        self._nodes = nodes

    def symbols(self, drawn: Array) -> Symbols:
        """Symbols for drawn nodes (rotor_node, 2)."""
        nodes, small = self._nodes, SMALL * self._size
        ways = small * SPRING * 1.6 * np.array([[1.0, 0.0], [0.0, 1.0]])
        shaft = np.repeat(drawn[[self._centre]], 2, axis=0)
        held = nodes[[self._centre, self._centre]] + ways
        if not self._free:
            shaft, held, ways = (np.zeros((0, 2)) for _ in range(3))
        at = drawn[self._grounded]
        outward = _unit(nodes[self._grounded]) * small * SPRING
        start = np.concatenate([shaft, at, drawn[self._between[:, 0]]])
        fixed = np.concatenate([held, nodes[self._grounded] + outward])
        end = np.concatenate([fixed, drawn[self._between[:, 1]]])
        leader, led = (drawn[self.links[:, side]] for side in (1, 0))
        return Symbols(
            springs=_zigzags(start, end, np.full(len(start), ZIGZAG * small)),
            ground=_grounds(
                fixed, _unit(np.concatenate([ways, outward])), np.full(len(fixed), GROUND * small)
            ),
            struts=np.stack([leader, led], axis=1),
            masses=drawn[self.mass_nodes],
        )


def together(symbols: tuple[Symbols, ...], angles: tuple[float, ...]) -> Symbols:
    """Symbols of several bodies, each turned by its angle [rad]."""
    turned = [
        Symbols(*(rotate(shapes, angle) for shapes in each))
        for each, angle in zip(symbols, angles, strict=True)
    ]
    return Symbols(*(np.concatenate(shapes) for shapes in zip(*turned, strict=True)))


def _optional(dataset: xr.Dataset, name: str, shape: tuple[int, ...]) -> IntArray:
    return dataset[name].values if name in dataset else np.zeros(shape, dtype=np.int64)


def _zigzags(start: Array, end: Array, half_width: Array) -> Array:
    """Strokes of springs from start to end (spring, 2): straight, teeth, straight."""
    knots = np.concatenate([[0.0], np.linspace(0.2, 0.8, TEETH), [1.0]])
    side = np.zeros(len(knots))
    side[2:-2] = np.where(np.arange(len(knots) - 4) % 2, -1.0, 1.0)
    aside = rotate(_unit(end - start), np.pi / 2) * half_width[:, None]
    points = start[:, None] + knots[:, None] * (end - start)[:, None]
    points = points + side[:, None] * aside[:, None]
    return np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 2)


def _grounds(at: Array, away: Array, half_width: Array) -> Array:
    """Strokes of hatched ground at points, whose body lies on the side of `away` (point, 2)."""
    aside = rotate(away, np.pi / 2) * half_width[:, None]
    line = np.stack([at - aside, at + aside], axis=1)[:, None]
    place = np.linspace(-0.7, 1.0, HATCHES)[:, None]
    top = at[:, None] + place * aside[:, None]
    foot = top + (0.55 * away * half_width[:, None])[:, None] - 0.45 * aside[:, None]
    hatches = np.stack([top, foot], axis=2)
    return np.concatenate([line, hatches], axis=1).reshape(-1, 2, 2)


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
