"""The bladed disk of a result cut into sectors, and fields transformed over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.spatial import KDTree

from bladewhirl.models.elements.cyclic import nodal_diameter_of, real_dft
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, rotate

SAME_PLACE = 1e-6
"""Distance, as a share of the tip radius, at which two places are one."""


@dataclass(frozen=True, kw_only=True)
class Sectors:
    """Nodes that are turned into each other by a sector's angle.

    Node j of sector n is node j of sector 0 turned counter-clockwise by n sectors.
    """

    nodes: IntArray  #: (sector, node of a sector)
    centre: IntArray  #: nodes on the axis, (centre,)

    @property
    def count(self) -> int:
        """Number of sectors N."""
        return len(self.nodes)

    @property
    def nodal_diameter(self) -> IntArray:
        """Nodal diameter of each row of `transform`."""
        columns = np.array([nodal_diameter_of(column) for column in range(self.count)])
        per_sector = 3 * self.nodes.shape[1]
        return np.concatenate(
            [np.repeat(columns, per_sector), np.tile([1, 1, 0], len(self.centre))]
        )

    def transform(self, field: Array) -> Array:
        """Real DFT over sectors of fields (..., node, 3) of x, y and rotation: (..., row).

        Vectors are taken in axes that turn with the sector. The transform keeps lengths, and the
        axis belongs to one nodal diameter as it moves, to none as it turns (Eqs 11-13).
        """
        turned = field[..., self.nodes, :]
        back = -2 * np.pi * np.arange(self.count) / self.count
        plane = rotate(turned[..., :2], back[:, None])
        own = np.concatenate([plane, turned[..., 2:]], axis=-1)
        flat = own.reshape(*own.shape[:-2], -1)
        waves = real_dft(self.count).T @ flat
        lead = field.shape[:-2]
        axis = field[..., self.centre, :].reshape(*lead, -1)
        return np.concatenate([waves.reshape(*lead, -1), axis], axis=-1)


def sectors(dataset: xr.Dataset) -> Sectors:
    """Cut the bladed disk of a result into as many sectors as it has blades.

    Raises:
        ViewError: turning its nodes by a sector does not give its nodes.
    """
    points, count = dataset["rotor_point"].values, dataset.sizes["blade"]
    near = SAME_PLACE * dataset.attrs["tip_radius"]
    distance, turned = KDTree(points).query(rotate(points, 2 * np.pi / count))
    if distance.max() > near:
        worst = int(np.argmax(distance))
        raise ViewError(
            f"expected a bladed disk of {count} like sectors; node {worst} turned by one sector "
            f"is {distance[worst]:.3g} m away from the nearest node"
        )
    images = [np.arange(len(points))]
    for _ in range(1, count):
        images.append(turned[images[-1]])
    orbits = np.stack(images)
    on_axis = np.hypot(*points.T) <= near
    first = ~on_axis & (orbits.min(axis=0) == orbits[0])
    return Sectors(nodes=orbits[:, first], centre=np.flatnonzero(on_axis))
