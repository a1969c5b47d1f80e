"""Impulse and work of tips that rub on a wall in a periodic motion of `joints`.

In a period, sliding turns the work -l_t s of the slip s of tips, by the rotation and by their own
motion, into heat. In the static frame the wall is at rest, and the drive supplies the heat and the
work of the wall on the blades: that of the tangential forces over the turned angle, and that of the
normal forces over the change of the gaps g_0.
"""

from typing import NamedTuple

import numpy as np

from bladewhirl.models.joints.wheel import DIRECTIONS
from bladewhirl.solvers.periodic.joints import JointMotion


class Rub(NamedTuple):
    """Rub of the tips of a blade."""

    impulse: float  #: normal impulse on a blade per revolution [N s]
    heat: float  #: work of sliding in a period [J]
    drive: float  #: work of the drive in a period [J]


def rub(motion: JointMotion) -> Rub:
    """Return the rub of a motion of a wheel with a wall."""
    grid, wheel = motion.grid, motion.grid.wheel
    tips = np.flatnonzero(wheel.joint == len(wheel.names) - 1)
    force = motion.harmonics.reshape(len(grid.number), -1, DIRECTIONS)[:, tips]
    moved = motion.moved.reshape(force.shape[0], -1, DIRECTIONS)[:, tips]
    turned = -2.0 * np.pi * float(force[0, :, 1].real @ grid.turning[tips])
    by_harmonic = np.pi * grid.number
    along = (force[..., 1:].conj() * moved[..., 1:]).imag.sum(axis=(1, 2))
    across = (force[..., 0].conj() * grid.uneven[:, tips]).imag.sum(axis=1)
    return Rub(
        impulse=2.0 * np.pi / abs(wheel.speed) * float(force[0, :, 0].real.sum()),
        heat=turned + float(by_harmonic @ along),
        drive=turned + float(by_harmonic @ across),
    )
