"""Dampers between blades in periodic motions: balance of the mean forces on them, and their place.

The balance B^T l + F = 0 of `models.joints.wheel` determines the part of the mean forces l on the
joints in the columns of B. In its place, the unknowns p in place of l have the mean place x of the
dampers. With the projection Pi on the columns of B and particular forces c in these,

    l = p - Pi (p - c),    B x = K Pi (p - c),

with flexibilities K of the size of those of the joints. Mean slips are zero, except those of a
damper that only friction holds along the axis: it walks, and x is its distance in a radian.
"""

from typing import NamedTuple, Self

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.models.joints.pressed import pressed
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel


class Balance(NamedTuple):
    """Balance of the mean forces on the dampers of a blade, in the directions in which they
    move."""

    rows: FloatArray  #: B, (values, dampers)
    pull: FloatArray  #: F [N], (dampers,)
    walks: BoolArray  #: whether x is the distance in a radian, (dampers,)
    to_place: FloatArray  #: x by p - c [m/N], (dampers, values)
    moved: FloatArray
    """Mean normal displacements and tangential slips of the joints by p - c [m/N], (values,
    values)."""
    share: FloatArray  #: Pi, (values, values)
    pulled: FloatArray  #: c [N], (values,)

    @classmethod
    def of(cls, wheel: JointedWheel, soft: FloatArray) -> Self:
        """Return the balance of a wheel with flexibilities of its joints [m/N], (values,)."""
        rows = np.zeros((wheel.values, len(wheel.pull)))
        rows[: len(wheel.dampers)] = wheel.dampers
        walks = np.asarray(~rows[::DIRECTIONS].any(axis=0))
        tangential = np.arange(wheel.values) % DIRECTIONS > 0
        moved = np.where(tangential[:, None] & ~walks, 0.0, rows)
        size = soft @ moved**2 / (moved**2).sum(axis=0)
        back = np.linalg.pinv(rows)
        return cls(
            rows=rows,
            pull=wheel.pull,
            walks=walks,
            to_place=size[:, None] * back,
            moved=moved * size @ back,
            share=rows @ back,
            pulled=-back.T @ wheel.pull,
        )

    def forces(self, mean: FloatArray) -> FloatArray:
        """Return the mean forces l of p [N], (values,)."""
        return np.asarray(mean - self.share @ mean + self.pulled)

    def place(self, mean: FloatArray) -> FloatArray:
        """Return x of p [m], (dampers,)."""
        return np.asarray(self.to_place @ (mean - self.pulled))

    def unknowns(self, forces: FloatArray, place: FloatArray) -> FloatArray:
        """Return p for mean forces, which balance except for the part that p does not have, and x,
        (values,)."""
        return np.asarray(self.forces(forces) + np.linalg.pinv(self.to_place) @ place)

    def at_rest(self, flexible: FloatArray, gap: FloatArray) -> FloatArray:
        """Return p of static normal forces without friction, (values,).

        Args:
            flexible: mean normal displacements by normal forces [m/N], (nodes, nodes).
            gap: gaps [m], (nodes,).

        Raises:
            NoStaticForces: there are no such forces.
        """
        normal = self.rows[::DIRECTIONS]
        back, tied = np.linalg.pinv(normal), ~normal.any(axis=1)
        force = -back.T @ self.pull
        opened = gap + flexible @ force
        force[tied] = pressed(flexible[np.ix_(tied, tied)], opened[tied])
        forces = np.zeros(len(self.rows))
        forces[::DIRECTIONS] = force
        return self.unknowns(forces, -back @ (gap + flexible @ force))
