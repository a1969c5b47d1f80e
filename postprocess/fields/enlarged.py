"""Positions of the bodies with displacements and clearance multiplied by one factor, for all views.

A clearance of 1 mm on a radius of 0.5 m is invisible, and so is motion within it. Drawn
displacements are therefore multiplied by a factor, and **so is the clearance**: the casing's inner
wall is drawn at tip radius + factor (clearance + w), a tip at tip radius + factor u_r, so the drawn
gap is the factor times the true gap and bodies touch in the picture exactly when they touch in the
run. If a blade ends short of the tip radius, or beyond it, this distance is multiplied by the
factor, too. Thicknesses stay true; the end of a blade is cut parallel to the wall that it faces, so
that no corner reaches the wall before the tip does.

Multiplied small displacements are no longer small. Each body is therefore first shifted by its mean
motion (the rotor by the motion of its centre, the ring by the mean over its circumference), along
straight lines, and what remains is drawn in polar coordinates about the shifted centre, (r, theta)
-> (r + factor u_r, theta + factor u_theta / r). So a shift stays a shift and a circle a circle,
while a blade that bends swings on an arc instead of growing longer into the casing: the linear
model has no second-order elongation of a bent blade either.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.blades import line_blades, with_recess
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    IntArray,
    ViewError,
    casing_rows,
    clearance_at,
    combine,
    history,
    line_rows,
    recess_at_rest,
    ring_angles,
    rotate,
    turn,
)
from bladewhirl.postprocess.fields.strains import rotor_sections

#: drawn clearance as a share of the tip radius, if the factor is chosen automatically
DRAWN_CLEARANCE = 0.1
#: largest drawn displacement as a share of the tip radius, if the factor is chosen automatically
DRAWN_MOTION = 0.25
#: share of the tip radius from which the linear displacement of a bent blade is wrong by a tenth
LARGE_DISPLACEMENT = 0.3

MOST = 1e9  #: largest useful exaggeration; its inverse is the smallest


class EnlargedStage:
    """Both bodies at chosen records, each in its own axes, with displacements and clearance
    multiplied.

    Args:
        dataset: a result.
        records: numbers of records.
        factor: factor of displacements and clearance. None chooses a round number: the clearance is
            drawn as at most a tenth of the tip radius, and the largest displacement stays in the
            picture.
        per_line: number of pieces of a beam.
        per_element: number of pieces of an element of the casing.

    Raises:
        ViewError: the factor is not positive, larger than `MOST`, or smaller than the inverse of
            `MOST`.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        factor: float | None,
        per_line: int,
        per_element: int,
    ) -> None:
        if factor is not None and not 1.0 / MOST <= factor <= MOST:
            raise ViewError(
                f"exaggeration must be a positive number, {1.0 / MOST:g} to {MOST:g}, got {factor}"
            )
        self._dataset = dataset
        self.tip_radius = float(dataset.attrs["tip_radius"])
        #: angle from the casing's to the rotor's axes (record,) [rad]
        self.turns = turn(dataset, records)
        self.line, rows = line_rows(dataset, per_line)
        self._thickness = rotor_sections(dataset, "thickness", per_line)
        q = history(dataset, "rotor_displacement", records)
        self.rotor_displacement = combine(q, rows.reshape(-1, 2, rows.shape[-1]))
        self._node = combine(q, dataset["rotor_shape"].values[:, :2])
        self.centre = self._node[:, int(dataset["centre_node"])]
        self.angle = ring_angles(dataset, per_element)
        ring = combine(
            history(dataset, "casing_displacement", records), casing_rows(dataset, self.angle)
        )
        self.ring_displacement = rotate(ring, self.angle)
        self.wall_thickness = np.repeat(dataset["casing_thickness"].values, per_element)
        self.largest_displacement = float(
            max(
                np.linalg.norm(field, axis=-1).max()
                for field in (self.rotor_displacement, self.ring_displacement)
            )
        )
        clearance, recess = clearance_at(dataset, self.angle), dataset["tip_recess"].values
        largest_clearance = float(clearance.max() + np.max(recess, initial=0.0))
        self.factor = (
            round_factor(self.tip_radius, largest_clearance, self.largest_displacement)
            if factor is None
            else factor
        )
        self.inner_radius = self.tip_radius + self.factor * clearance
        self.nodes = dataset["rotor_point"].values  #: at rest, as drawn (rotor_node, 2) [m]
        shift = self.factor * recess - recess_at_rest(dataset)
        if shift.any():
            self.nodes, self.line = with_recess(dataset, self.line, shift)

    def rotor_line(self, index: int) -> Array:
        """Return the stations of the beams (line, station, 2) [m] at the index-th record."""
        shift = self.centre[index]
        flat = self.line.reshape(-1, 2)
        line = magnify(flat, self.rotor_displacement[index], shift, self.factor)
        return line.reshape(self.line.shape)

    def rotor_nodes(self, index: int) -> Array:
        """Return the nodes (rotor_node, 2) [m] at the index-th record."""
        return magnify(self.nodes, self._node[index], self.centre[index], self.factor)

    def outward_reach(self) -> float:
        """Largest outward displacement of the casing, as drawn [m]."""
        outward = (self.ring_displacement * _directions(self.angle)).sum(axis=-1)
        return self.factor * max(0.0, float(outward.max()))

    def wall(self, index: int) -> Array:
        """Return inner and outer surface of the casing (station, side, 2) [m]."""
        ring = self.ring_displacement[index]
        rest = self.inner_radius[:, None] * _directions(self.angle)
        inner = magnify(rest, ring, ring.mean(axis=0), self.factor)
        tangent = np.roll(inner, -1, axis=0) - np.roll(inner, 1, axis=0)
        outward = -rotate(_unit(tangent), np.pi / 2)
        return np.stack([inner, inner + self.wall_thickness[:, None] * outward], axis=1)

    def wall_at_rest(self) -> Array:
        """Outer surface of the casing at rest (station, 2) [m]."""
        radius = self.inner_radius + self.wall_thickness
        return np.asarray(radius[:, None] * _directions(self.angle))

    def rotor_sides(self, index: int, line: Array, wall: Array) -> Array:
        """Return the right and left sides of the beams (line, station, side, 2) [m] along their
        drawn `line`; the ends of blades are cut along the `wall`.
        """
        half = self._thickness[..., None] / 2 * _normals(line)
        sides = np.stack([line - half, line + half], axis=2)
        beams, stations = self._ends
        corner, middle = sides[beams, stations], line[beams, stations][:, None]
        inner = wall[:, 0]
        ahead = float(self.turns[index])
        wall_angle, wall_radius = _polar(inner)
        (angle, _), (at_tip, radius) = _polar(corner), _polar(middle)
        facing, before = (
            np.interp(place + ahead, wall_angle, wall_radius, period=2 * np.pi)
            for place in (angle, at_tip)
        )
        sides[beams, stations] = (radius + facing - before)[..., None] * _directions(angle)
        return sides

    @cached_property
    def _ends(self) -> tuple[IntArray, IntArray]:
        """Return the beams at the blade tips, and the station of each that is the tip (beam,)."""
        lines, tips = self._dataset["rotor_line"].values, self._dataset["tip_node"].values
        ending = np.isin(lines, tips) & (line_blades(self._dataset) >= 0)[:, None]
        beams, end = np.nonzero(ending)
        return beams, np.where(end == 1, self.line.shape[1] - 1, 0)


def magnify(points: Array, displacement: Array, shift: Array, factor: float) -> Array:
    """Return drawn positions (point, 2) of points moved by `factor` times their displacement.
    `shift` (2,) is the displacement common to all points, drawn along a straight line; the rest is
    drawn in polar coordinates (module docstring). A point at the centre, which has no radius, only
    gets the shift.
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
    """Return an exaggeration of 1, 2 or 5 times a power of ten that keeps the picture readable: the
    drawn clearance is at most a tenth of the tip radius, the largest drawn displacement at most a
    quarter.
    """
    limits = [
        share * tip_radius / length
        for share, length in ((DRAWN_CLEARANCE, clearance), (DRAWN_MOTION, largest_displacement))
        if length > 0
    ]
    limit = min(max(1.0, min(limits, default=1.0)), MOST)
    decade = 10.0 ** np.floor(np.log10(limit))
    # A rounding error must not turn a limit of exactly 50 into 20.
    return float(decade * max(step for step in (1, 2, 5) if step * decade <= limit * (1 + 1e-9)))


def _directions(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _polar(points: Array) -> tuple[Array, Array]:
    """Return angles [rad] and radii of points (..., 2)."""
    return np.arctan2(points[..., 1], points[..., 0]), np.linalg.norm(points, axis=-1)


def _unit(vectors: Array) -> Array:
    unit: Array = vectors / np.linalg.norm(vectors, axis=-1)[..., None]
    return unit


def _normals(line: Array) -> Array:
    """Return unit normals (line, station, 2) of drawn lines, from second-order differences."""
    return rotate(_unit(np.gradient(line, axis=1, edge_order=2)), np.pi / 2)
