"""Beams and casing wall as boxes of their true thickness and width, or as lines.

Every beam of the rotor and every element of the casing is a box along the axis of the beam, with
stations of its own, so that strains can jump between elements. Cross-sections stay plane and
normal: a corner at the distance y from the axis has the displacement of the axis minus y times the
rotation of the cross-section, along the axis. A line is a box without thickness, which has one
corner at each station instead of four.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.hermite import cubic_weights, slope_weights
from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields import kinematics
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, history
from bladewhirl.postprocess.fields.strains import (
    Strains,
    casing_strain_rows,
    rotor_sections,
    rotor_strain_rows,
)

BEAM_PIECES = 2  #: number of pieces of a beam
ARC_POINTS = 256  #: smallest number of pieces of the casing
SIDES = np.array([0, 1, 1, 0])  #: side of each corner of a cross-section: 0 right, 1 left
ENDS = np.array([-0.5, -0.5, 0.5, 0.5])  #: axial positions of these corners, divided by the width

LINE = np.zeros(1)  #: axial position of the only corner of a line


@dataclass(frozen=True, kw_only=True)
class Boxes:
    """Boxes of a body at rest, in the axes of the body."""

    body: str  #: "rotor" or "casing"
    line: Array  #: stations (element, station, 2) [m]
    #: unit normals, to the left of beams and outward on the casing (element, station, 2)
    normal: Array
    #: positions of right and left (inner and outer) side along `normal` (element, station, 2) [m]
    offset: Array
    width: Array  #: (element, station) or (element, 1) [m]
    modulus: Array  #: Young's modulus, (element, station) or (element, 1) [Pa]
    rows: Array  #: displacement for unit coordinates (element, station, 2, mode)
    turn_rows: Array  #: rotation of the cross-section for unit coordinates (element, station, mode)
    strain_rows: Strains
    solid: bool = True  #: true for boxes, false for lines

    @property
    def shape(self) -> tuple[int, int]:
        """Number of elements, and number of stations of an element."""
        return self.line.shape[0], self.line.shape[1]

    def points(self) -> Array:
        """Return the corners (corner, 3) [m], 4 for each station of a box, 1 for each of a line."""
        place = self.line[:, :, None] + self._beside()
        ends = ENDS if self.solid else LINE
        height = np.broadcast_to(ends * self.width[..., None], place.shape[:-1])
        return np.concatenate([place, height[..., None]], axis=-1).reshape(-1, 3)

    def cells(self) -> IntArray:
        """Return the corners of the pieces, element by element: hexahedra (piece, 8), in the order
        of VTK, or lines (piece, 2)."""
        (elements, stations), corner = self.shape, np.arange(4 if self.solid else 1)
        along, normal = self.line[0, 1] - self.line[0, 0], self.normal[0, 0]
        if along[0] * normal[1] - along[1] * normal[0] < 0:  # mirrored
            corner = corner[::-1]
        each = len(corner)
        first = each * (stations * np.arange(elements)[:, None] + np.arange(stations - 1))
        both = np.concatenate([corner, corner + each])
        return np.asarray(first[..., None] + both).reshape(-1, 2 * each)

    def on_cells(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values of elements (element,), or of their pieces (element, piece), as values of
        the cells."""
        elements, stations = self.shape
        return np.broadcast_to(values.reshape(elements, -1), (elements, stations - 1)).ravel()

    def vectors(self, dataset: xr.Dataset, quantity: str, records: IntArray) -> Array:
        """Return displacement [m] or velocity [m/s] (record, corner, 2) in the axes of the body."""
        coordinates = history(dataset, f"{self.body}_{quantity}", records)
        count = len(records)
        flat = self.rows.reshape(-1, self.rows.shape[-1])
        line = (coordinates @ flat.T).reshape(count, *self.shape, 1, 2)
        turned = coordinates @ self.turn_rows.reshape(-1, self.rows.shape[-1]).T
        across = rotate(self._beside(), np.pi / 2)  # displacement for a small unit rotation
        moved = line + turned.reshape(count, *self.shape, 1, 1) * across
        return np.asarray(moved.reshape(count, -1, 2))

    def strains(self, dataset: xr.Dataset, records: IntArray) -> Strains:
        """Return axial and bending strain at the stations (record, element, station) [1]."""
        return self.strain_rows.at(history(dataset, f"{self.body}_displacement", records))

    def _beside(self) -> Array:
        """Return vectors from the axis of each beam to the corners of its cross-section [m],
        (element, station, 4, 2); (element, station, 1, 2) with zeros for a line."""
        if not self.solid:
            return np.zeros((*self.shape, 1, 2))
        return np.asarray(self.offset[:, :, SIDES, None] * self.normal[:, :, None])


def rotor_boxes(dataset: xr.Dataset, pieces: int = BEAM_PIECES) -> Boxes:
    """Return the beams of the rotor, in rotating axes."""
    line, rows = kinematics.line_rows(dataset, pieces)
    normal = rotate(unit(line[:, -1] - line[:, 0])[:, None], np.pi / 2)
    half = rotor_sections(dataset, "thickness", pieces)[..., None] / 2
    return Boxes(
        body="rotor",
        line=line,
        normal=np.broadcast_to(normal, line.shape),
        offset=np.broadcast_to(half * np.array([-1.0, 1.0]), line.shape),
        width=rotor_sections(dataset, "width", pieces),
        modulus=rotor_sections(dataset, "young_modulus", pieces),
        rows=rows,
        turn_rows=kinematics.slope_rows(dataset, np.linspace(0.0, 1.0, pieces + 1)),
        strain_rows=rotor_strain_rows(dataset, pieces),
    )


def casing_boxes(dataset: xr.Dataset, arc_points: int = ARC_POINTS) -> Boxes:
    """Return the wall of the casing in static axes; the inner surface lies at the clearance."""
    pieces = -(-arc_points // dataset.sizes["casing_node"])
    angle = kinematics.station_angles(dataset, pieces)
    outward = directions(angle)
    clearance = kinematics.clearance_at(dataset, angle.ravel()).reshape(angle.shape)
    radius = float(dataset.attrs["tip_radius"]) + clearance
    wall = np.broadcast_to(dataset["casing_thickness"].values[:, None], angle.shape)
    x = np.linspace(0.0, 1.0, pieces + 1)
    polar = kinematics.wall_rows(dataset, cubic_weights(x))
    slope = kinematics.wall_rows(dataset, slope_weights(x))[:, :, 0]
    slope /= kinematics.element_lengths(dataset)[:, None, None]
    return Boxes(
        body="casing",
        line=radius[..., None] * outward,
        normal=outward,
        offset=np.stack([np.zeros_like(wall), wall], axis=-1),
        width=dataset["casing_width"].values[:, None],
        modulus=dataset["casing_young_modulus"].values[:, None],
        rows=rotate(polar, angle[..., None], axis=2),
        turn_rows=polar[:, :, 1] / float(dataset.attrs["casing_radius"]) - slope,
        strain_rows=casing_strain_rows(dataset, pieces),
    )
