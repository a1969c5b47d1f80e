"""Largest amplitude of a wheel with joints over the speed."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joint_search import joint_motion, rough_motion, solve
from bladewhirl.solvers.periodic.joints import JointGrid, JointMotion
from bladewhirl.studies.joints.motions import amplitudes_of

STEPS, WIDTH, NEAR = (25, 10), 2e-3, 0.1
"""Largest numbers of speeds at which a peak is sought with rough and with converged motions, its
accuracy as a share of the range, and half the range of the latter as a share of the former."""


class Peak(NamedTuple):
    """The largest amplitude over the speed."""

    amplitude: float  #: [m]
    speed: float  #: [rad/s]
    motion: JointMotion
    at_speeds: FloatArray  #: amplitudes at the given speeds [m], NaN where no motion was found
    place: str  #: "peak" or "end of the range"


def peak(wheel_at: Callable[[float], JointedWheel], speeds: Sequence[float]) -> Peak:
    """Return the largest amplitude of a wheel with joints over the speed.

    Args:
        wheel_at: function that returns the wheel at a speed [rad/s].
        speeds: speeds, ascending [rad/s]; a peak is sought beside that of the largest amplitude.

    Raises:
        NotConverged: no motion was found at any speed.
    """
    found, near = dict[float, JointMotion](), None
    for speed in speeds:
        try:
            near = found[speed] = rough_motion(wheel_at(speed), near)
        except NotConverged:
            continue
    if not found:
        raise NotConverged("no periodic motion was found at any of the speeds")
    each = {speed: _largest(motion) for speed, motion in found.items()}
    most = max(each, key=each.__getitem__)
    place = list(speeds).index(most)
    at_speeds = np.array([each.get(speed, np.nan) for speed in speeds])
    if place in (0, len(speeds) - 1):
        end = joint_motion(wheel_at(most), found[most], thorough=False)
        return Peak(_largest(end), most, end, at_speeds, "end of the range")
    low, high = speeds[place - 1], speeds[place + 1]
    first = found[most]
    rough = _highest(lambda speed: rough_motion(wheel_at(speed), first), (low, high), STEPS[0])
    rough = max(rough, first, key=_largest)
    at, aside = rough.grid.wheel.speed, NEAR * (high - low)
    ends = max(low, at - aside), min(high, at + aside)
    middle = joint_motion(wheel_at(at), rough, thorough=False)
    fine = _highest(lambda speed: _beside(middle, wheel_at(speed)), ends, STEPS[1])
    fine = max(fine, middle, key=_largest)
    return Peak(_largest(fine), fine.grid.wheel.speed, fine, at_speeds, "peak")


def _beside(motion: JointMotion, wheel: JointedWheel) -> JointMotion:
    """Return the motion at a speed beside that of a converged one, with as many harmonics if it is
    found so.

    Raises:
        NotConverged: no motion was found.
    """
    try:
        return solve(motion.on(JointGrid(wheel, motion.grid.harmonics)))
    except NotConverged:
        return joint_motion(wheel, motion, thorough=False)


def _highest(
    motion_at: Callable[[float], JointMotion], ends: tuple[float, float], steps: int
) -> JointMotion:
    """Return the motion with the largest amplitude between two speeds, which is found in a number
    of steps.

    Raises:
        NotConverged: no motion was found.
    """
    found = list[JointMotion]()

    def below(speed: float) -> float:
        try:
            found.append(motion_at(float(speed)))
        except NotConverged:
            return 0.0
        return -_largest(found[-1])

    width = WIDTH * (ends[1] - ends[0])
    options = {"xatol": width, "maxiter": steps}
    minimize_scalar(below, bounds=ends, method="bounded", options=options)
    if not found:
        raise NotConverged("no periodic motion was found near the peak")
    return max(found, key=_largest)


def _largest(motion: JointMotion) -> float:
    """Return the largest amplitude of the points of a motion [m]."""
    return float(np.linalg.norm(amplitudes_of(motion), axis=-1).max())
