"""Geometry of a picture of the stage: beams and wall as filled ribbons, contact as arrows.

A clearance of 1 mm on a radius of 0.5 m is invisible, and so is motion within it. Drawn
displacements are therefore multiplied by a factor, and **so is the clearance**: the casing's inner
wall is drawn at tip radius + factor (clearance + w), a tip at tip radius + factor u_r, so the drawn
gap is the factor times the true gap and bodies touch in the picture exactly when they touch in the
run. A blade that ends short of the tip radius, or beyond it, is drawn so by the factor, too.
Thicknesses stay true.

Multiplied small displacements are no longer small. Each body is therefore first shifted by its
mean motion (the rotor by that of its centre, the ring by the mean over its circumference), along
straight lines, and what remains is drawn in polar coordinates about the shifted centre,
(r, theta) -> (r + factor u_r, theta + factor u_theta / r). So a shift stays a shift and a circle a
circle, while a blade that bends swings on an arc instead of growing longer into the casing.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.blades import with_recess
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    IntArray,
    ViewError,
    casing_rows,
    clearance_at,
    combine,
    contact_forces,
    history,
    line_rows,
    recess_at_rest,
    ring_angles,
    rotate,
    turn,
)
from bladewhirl.postprocess.fields.sections import rotor_sections
from bladewhirl.postprocess.pictures.colouring import Field, Stations, colouring
from bladewhirl.postprocess.pictures.symbols import (
    CasingSymbols,
    RotorSymbols,
    ShaftSymbols,
    Symbols,
    together,
)

Frame = Literal["static", "rotating"]

BEAM_STATIONS = 6  #: a beam is drawn as this many straight pieces
RING_STATIONS = 720  #: and the casing as at least this many
MARK = 0.7  #: where the first blade is marked, as a share of its tip's radius
DRAWN_CLEARANCE = 0.1  #: share of the tip radius that the clearance takes, if factors are automatic
DRAWN_MOTION = 0.25  #: share that the largest displacement may take then


@dataclass(frozen=True, kw_only=True)
class Ribbon:
    """A strip of quads along lines, `sides` (line, station, side, 2) with sides 0 and 1."""

    sides: Array  #: (line, station, 2, 2) [m]
    values: Array  #: of the field that colours it, true, at its sides (line, station, 2)


@dataclass(frozen=True, kw_only=True)
class Picture:
    """The stage at one record. Lengths are as drawn, values are true."""

    time: float  #: [s]
    rotor: Ribbon
    casing: Ribbon
    shaft: Array  #: drawn centre (2,) [m]
    tips: Array  #: drawn tips (blade, 2) [m]
    mark: Array  #: a drawn point of the first blade (2,) [m], by which a turn can be followed
    symbols: Symbols  #: springs, supports, masses
    forces: Array  #: contact force on each tip (blade, 2) [N], true size, in the picture's axes


class Drawing:
    """The stage at chosen records, ready to be drawn.

    `exaggeration` multiplies displacements and clearance (module docstring); None chooses a round
    number by which the clearance is drawn as a tenth of the tip radius, or less where the largest
    displacement would then leave the picture. `colour` is the field that colours beams and wall
    (`colouring`). `frame` is the observer's: "static" shows a turning
    rotor, "rotating" holds it and turns the casing back.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        exaggeration: float | None = None,
        frame: Frame = "static",
        colour: Field = "displacement",
    ) -> None:
        if exaggeration is not None and not (np.isfinite(exaggeration) and exaggeration > 0):
            raise ViewError(f"exaggeration must be a positive number, got {exaggeration}")
        if frame not in ("static", "rotating"):
            raise ViewError(f'frame must be "static" or "rotating", got {frame!r}')
        self.records = records
        self.frame = frame
        self.tip_radius = float(dataset.attrs["tip_radius"])
        self.times = dataset["time"].values[records]
        angle = turn(dataset, records)
        self._rotor_turn, self._casing_turn = (
            (angle, 0 * angle) if frame == "static" else (0 * angle, -angle)
        )
        self._forces = contact_forces(dataset, records, rotating=frame == "rotating")

        self._stations, rows = line_rows(dataset, BEAM_STATIONS)
        self._line_shape = (len(rows), BEAM_STATIONS + 1)
        self._thickness = rotor_sections(dataset, "thickness", BEAM_STATIONS)
        q = history(dataset, "rotor_displacement", records)
        self._rotor = combine(q, rows.reshape(-1, 2, rows.shape[-1]))
        #: the rotor's nodes at rest, as drawn (rotor_node, 2) [m]
        self.nodes = dataset["rotor_point"].values
        self._node = combine(q, dataset["rotor_shape"].values[:, :2])
        self._tips = dataset["tip_node"].values
        from_mark = self._stations.reshape(-1, 2) - MARK * self.nodes[self._tips[0]]
        self._mark = int(np.argmin(np.sum(from_mark**2, axis=1)))
        self._centre = self._node[:, int(dataset["centre_node"])]

        per_element = -(-RING_STATIONS // dataset.sizes["casing_node"])
        self._angle = ring_angles(dataset, per_element)
        ring = combine(
            history(dataset, "casing_displacement", records), casing_rows(dataset, self._angle)
        )
        self._ring = rotate(ring, self._angle)
        self._wall = np.repeat(dataset["casing_thickness"].values, per_element)

        self.largest_displacement = float(
            max(np.linalg.norm(field, axis=-1).max() for field in (self._rotor, self._ring))
        )
        clearance = clearance_at(dataset, self._angle)
        recess = dataset["tip_recess"].values
        room = float(clearance.max() + np.max(recess, initial=0.0))
        self.exaggeration = (
            round_factor(self.tip_radius, room, self.largest_displacement)
            if exaggeration is None
            else exaggeration
        )
        self._inner_radius = self.tip_radius + self.exaggeration * clearance
        shift = self.exaggeration * recess - recess_at_rest(dataset)
        if shift.any():
            self.nodes, self._stations = with_recess(dataset, self._stations, shift)
        self.colouring = colouring(dataset, colour, records, Stations(BEAM_STATIONS, per_element))
        self._on_rotor = RotorSymbols(dataset, self.tip_radius)
        self._shaft = ShaftSymbols(dataset, self.tip_radius)
        self._on_casing = CasingSymbols(dataset, self.tip_radius)
        away = np.angle(np.exp(1j * (self._on_casing.angles[:, None] - self._angle)))
        self._feet = np.argmin(np.abs(away), axis=1)

    @property
    def largest_force(self) -> float:
        """Largest contact force in the records [N]."""
        return float(np.linalg.norm(self._forces, axis=-1).max())

    def reach(self) -> tuple[float, float]:
        """Largest distances from the origin [m], over all records, of the drawn stage and of a
        tip in contact (0 if there is none).
        """
        stage = contact = 0.0
        for index in range(len(self)):
            seen = self.picture(index)
            touching = seen.tips[np.any(seen.forces, axis=1)]
            contact = max(contact, float(np.max(np.sum(touching**2, axis=-1), initial=0.0)))
            for shape in (seen.rotor.sides, seen.casing.sides, *seen.symbols):
                stage = max(stage, float(np.max(np.sum(shape**2, axis=-1), initial=0.0)))
        return float(np.sqrt(stage)), float(np.sqrt(contact))

    def __len__(self) -> int:
        return len(self.records)

    def picture(self, index: int) -> Picture:
        """The stage at the index-th of the chosen records."""
        shift = self._centre[index]
        turned = self._rotor_turn[index]
        flat = self._stations.reshape(-1, 2)
        line = magnify(flat, self._rotor[index], shift, self.exaggeration)
        line = line.reshape(*self._line_shape, 2)
        nodes = magnify(self.nodes, self._node[index], shift, self.exaggeration)
        half = self._thickness[..., None] / 2
        normal = _normals(line)
        wall, rest = self._wall_sides(index)
        centre = self.exaggeration * shift
        spring_turn = self._casing_turn[index] if self._shaft.static else turned
        return Picture(
            time=float(self.times[index]),
            rotor=Ribbon(
                sides=rotate(np.stack([line - half * normal, line + half * normal], 2), turned),
                values=self.colouring.rotor[index],
            ),
            casing=self._casing_ribbon(index, wall),
            shaft=rotate(centre, turned),
            tips=rotate(nodes[self._tips], turned),
            mark=rotate(line.reshape(-1, 2)[self._mark], turned),
            symbols=together(
                (
                    self._on_casing.symbols(wall[self._feet, 1], rest[self._feet]),
                    self._shaft.springs(rotate(centre, turned - spring_turn)),
                    self._shaft.dampers(centre),
                    self._on_rotor.symbols(nodes),
                ),
                (self._casing_turn[index], spring_turn, turned, turned),
            ),
            forces=self._forces[index],
        )

    def _wall_sides(self, index: int) -> tuple[Array, Array]:
        """Inner and outer surface of the wall (station, side, 2), and the outer one at rest."""
        ring = self._ring[index]
        unit = np.column_stack([np.cos(self._angle), np.sin(self._angle)])
        rest = self._inner_radius[:, None] * unit
        inner = magnify(rest, ring, ring.mean(axis=0), self.exaggeration)
        tangent = np.roll(inner, -1, axis=0) - np.roll(inner, 1, axis=0)
        outward = -rotate(_unit(tangent), np.pi / 2)
        wall = self._wall[:, None]
        return np.stack([inner, inner + wall * outward], axis=1), rest + wall * unit

    def _casing_ribbon(self, index: int, sides: Array) -> Ribbon:
        """The wall, from the surface that is rubbed outward; the line is closed by repetition."""
        closed = np.append(np.arange(len(sides)), 0)
        return Ribbon(
            sides=rotate(sides[closed], self._casing_turn[index])[None],
            values=self.colouring.casing[index][closed][None],
        )


def magnify(points: Array, displacement: Array, shift: Array, factor: float) -> Array:
    """Drawn positions (point, 2) of points moved by `factor` times their displacement.

    `shift` (2,) is the part that all share, drawn straight; the rest is drawn in polar
    coordinates (module docstring). A point at the centre, which has no radius, gets the shift.
    """
    radius = np.linalg.norm(points, axis=-1)
    away = radius > 0
    unit = np.divide(points, radius[:, None], out=np.zeros_like(points), where=away[:, None])
    rest = displacement - shift
    radial = np.sum(rest * unit, axis=-1)
    tangential = np.sum(rest * rotate(unit, np.pi / 2), axis=-1)
    swing = np.divide(factor * tangential, radius, out=np.zeros_like(radius), where=away)
    drawn: Array = factor * shift + (radius + factor * radial)[:, None] * rotate(unit, swing)
    return drawn


def round_factor(tip_radius: float, clearance: float, largest_displacement: float) -> float:
    """An exaggeration of 1, 2 or 5 times a power of ten that keeps the picture readable: the
    clearance at most a tenth of the tip radius, the largest displacement at most a quarter.
    """
    limits = [
        share * tip_radius / length
        for share, length in ((DRAWN_CLEARANCE, clearance), (DRAWN_MOTION, largest_displacement))
        if length > 0
    ]
    limit = max(1.0, min(limits, default=1.0))
    decade = 10.0 ** np.floor(np.log10(limit))
    # A rounding error must not turn a limit of exactly 50 into 20.
    return float(decade * max(step for step in (1, 2, 5) if step * decade <= limit * (1 + 1e-9)))


def arrows(tips: Array, forces: Array, length_per_newton: float, width: float) -> Array:
    """Outlines (blade, 7, 2) of arrows that end on the tips and point along the forces.

    Corners 0, 1, 5, 6 are the shaft and 2, 3, 4 the head, up to five widths long. A blade without
    contact has an arrow of no size.
    """
    size = np.linalg.norm(forces, axis=1)
    ahead = np.divide(forces, size[:, None], out=np.zeros_like(forces), where=size[:, None] > 0)
    aside = rotate(ahead, np.pi / 2)
    length = length_per_newton * size
    head = np.minimum(5 * width, length)
    back = np.stack([length, head, head, 0 * head, head, head, length], axis=1)
    side = np.array([0.5, 0.5, 1.6, 0.0, -1.6, -0.5, -0.5]) * width
    outline: Array = (
        tips[:, None] - back[..., None] * ahead[:, None] + side[:, None] * aside[:, None]
    )
    return outline


def widened(sides: Array, margin: float) -> Array:
    """Ribbon sides (line, station, 2, 2) with a margin [m] on both sides and at both ends."""
    across = _unit(sides[:, :, 1] - sides[:, :, 0])
    wide = np.stack([sides[:, :, 0] - margin * across, sides[:, :, 1] + margin * across], axis=2)
    middle = sides.mean(axis=2)
    wide[:, 0] -= margin * _unit(middle[:, 1] - middle[:, 0])[:, None]
    wide[:, -1] += margin * _unit(middle[:, -1] - middle[:, -2])[:, None]
    return wide


def _unit(vectors: Array) -> Array:
    unit: Array = vectors / np.linalg.norm(vectors, axis=-1)[..., None]
    return unit


def _normals(line: Array) -> Array:
    """Unit normals (line, station, 2) of drawn lines, from second-order differences."""
    return rotate(_unit(np.gradient(line, axis=1, edge_order=2)), np.pi / 2)
