"""A shaft line in space: its surface as a body of revolution, rings at its bearings, their motion.

Axes are those of the wheel that stands on the line, or of the line without a wheel.
"""

import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array

AROUND = 24  #: number of points around a section
RING = ((1.3, -0.6), (1.3, 0.6), (2.0, 0.6), (2.0, -0.6))
"""Radius and axial position of the corners of the ring at a bearing, by the radius of the shaft."""


class ShaftSurface:
    """Surface of a shaft line of a result with sections at its nodes, in rotating axes, and rings
    at its bearings, in static axes."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._motion = dataset["shaft_displacement"]
        self._support = dataset["support_displacement"]
        self._angles = rotation.angles(dataset)
        origin = float(dataset["wheel_origin"]) if "wheel_origin" in dataset else 0.0
        self.position = dataset["shaft_position"].values - origin  #: of each node [m], (nodes,)
        radius = dataset["shaft_radius"].values
        around = directions(2.0 * np.pi / AROUND * np.arange(AROUND))
        at, size = self.position[:, None], radius[:, None, None]
        self.rest = _revolved(around, size, at).reshape(-1, 3)
        """Points at rest, section by section, (nodes * AROUND, 3) [m]."""
        held = dataset["bearing_node"].values
        radial, axial = np.array(RING).T
        size = radius[held, None, None]
        self.rings = _revolved(
            around[:, None],
            (size * radial)[..., None],
            self.position[held, None, None] + size * axial,
        )
        """Corners of the rings at rest, (bearings, AROUND, 4, 3) [m]."""

    def displacement(self, record: int) -> Array:
        """Return the displacement of the points at a record in rotating axes, (point, 3) [m]."""
        both = rotate(self._motion[record].values.reshape(-1, 3), -self._angles[record])
        shift, tilt = (np.repeat(each, AROUND, axis=0) for each in (both[::2], both[1::2]))
        return np.asarray(shift + np.cross(tilt, self.rest * [1.0, 1.0, 0.0]))

    def ring_displacement(self, record: int) -> Array:
        """Return the displacement of the supports of the bearings at a record in static axes,
        (bearings, 1, 1, 3) [m]; zero without a support."""
        return np.pad(self._support[record].values, ((0, 0), (0, 1)))[:, None, None]


def _revolved(around: Array, radius: Array, axial: Array) -> Array:
    """Return points (..., 3) at radii and axial positions, in directions `around` (..., 2)."""
    plane = around * radius
    return np.concatenate(
        [plane, np.broadcast_to(axial[..., None], (*plane.shape[:-1], 1))], axis=-1
    )
