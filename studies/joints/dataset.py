"""Dataset of periodic motions of a tuned wheel with friction joints or a rub."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.models.case.case import Case
from bladewhirl.models.joints.limits import LIMITS
from bladewhirl.solvers.periodic.joint_law import OPEN, SLIPPING
from bladewhirl.solvers.periodic.joint_rub import rub
from bladewhirl.solvers.periodic.joint_stability import NEUTRAL, largest_multiplier
from bladewhirl.solvers.periodic.joints import JointMotion
from bladewhirl.studies.joints.motions import amplitudes_of, limits_of
from bladewhirl.studies.runs.columns import quantity

INSTANTS = 128  #: least number of instants of the forces in the Dataset


OF_JOINTS = {
    "largest_normal_force": ("N", "largest normal force"),
    "share_open": ("1", "share of the period in which the nodes are open"),
    "share_slipping": ("1", "share of the period in which the nodes slip"),
    "work": ("J", "work that the joint takes from the blades in a period"),
}
"""Variables over (speed, joint) with unit and name."""

OF_WALL = {
    "impulse_per_revolution": ("N s", "normal impulse of a blade on the wall per revolution"),
    "friction_heat": ("J", "heat of the friction of a blade on the wall in a period"),
    "drive_work": ("J", "work of the drive by a blade on the wall in a period"),
}
"""Variables over speed of a rub, in the order of `Rub`, with unit and name."""


def dataset(case: Case, motions: Sequence[JointMotion], reference: float) -> xr.Dataset:
    """Return the Dataset of motions at speeds, for a reference frequency [rad/s]; either all of
    them have a wall or none."""
    wheel, over = motions[0].grid.wheel, "speed"
    speeds = np.array([each.grid.wheel.speed for each in motions])
    count = wheel.blades * -(-INSTANTS // wheel.blades)  # all blades have the same instants
    limits = [limits_of(each.grid.wheel) for each in motions]
    largest = np.array([largest_multiplier(each) for each in motions])
    amplitude = [np.abs(amplitudes_of(each)) for each in motions]
    of_order = f"amplitude of engine order {wheel.shown_order}"
    growth = "factor by which a deviation grows in a period"
    limit = "amplitude with joints free, closed without friction, or stuck"
    return xr.Dataset(
        {
            **_of_joints(motions),
            **_of_dampers(motions),
            **_of_wall(motions),
            "point_amplitude": quantity((over, "point", "direction"), amplitude, "m", of_order),
            "linear_limit": quantity((over, "limit", "point"), limits, "m", limit),
            "largest_multiplier": quantity(over, largest, "1", growth),
            "stable": (over, largest < 1.0 + NEUTRAL),
            **_over_a_period(motions, count),
            "harmonics": (over, [each.grid.harmonics for each in motions]),
            "change": quantity(over, [each.change for each in motions], "1"),
            "residual": quantity(over, [each.error for each in motions], "m"),
            "period": quantity(over, [each.grid.period for each in motions], "s"),
        },
        coords={
            "speed": quantity(over, speeds / reference, "1", "normalised speed"),
            "rpm": quantity(over, speeds * 30.0 / np.pi, "rpm", "speed"),
            "instant": np.arange(count) / count,
            "joint": list(wheel.names),
            "name": ("joint_node", [wheel.names[n] for n in wheel.joint]),
            "point": list(wheel.shown),
            "direction": ["radial", "tangential", "axial"],
            "limit": list(LIMITS),
        },
        attrs={
            "title": "periodic motion of all blades of a wheel",
            "case": case.title,
            "engine_order": wheel.shown_order,
            "points": "point" if wheel.loaded else "tip node",
            "blades": wheel.blades,
            "reference_frequency_hz": reference / (2.0 * np.pi),
        },
    )


def _of_joints(motions: Sequence[JointMotion]) -> dict[str, Any]:
    """Return the variables over (speed, joint), which follow from those of the nodes."""
    wheel = motions[0].grid.wheel

    def merged(values: Callable[[JointMotion], Any], merge: Callable[[Any], Any]) -> Any:
        numbers = range(len(wheel.names))
        return [[merge(values(each)[..., wheel.joint == n]) for n in numbers] for each in motions]

    found = {
        "largest_normal_force": merged(lambda m: m.force[..., 0], np.max),
        "share_open": merged(lambda m: m.states == OPEN, np.mean),
        "share_slipping": merged(lambda m: m.states == SLIPPING, np.mean),
        "work": merged(lambda m: m.work, np.sum),
    }
    return {
        name: quantity(("speed", "joint"), found[name], unit, label)
        for name, (unit, label) in OF_JOINTS.items()
    }


def _over_a_period(motions: Sequence[JointMotion], count: int) -> dict[str, Any]:
    """Return the variables of the joint nodes at a number of instants of the period."""
    force, moved, states = (
        np.stack(each) for each in zip(*(motion.at(count) for motion in motions), strict=True)
    )
    nodes = "speed", "instant", "joint_node"
    relative = "displacement of the next blade relative to this one: normal, two tangents"
    return {
        "normal_force": quantity(nodes, force[..., 0], "N", "normal force"),
        "tangential_force": quantity((*nodes, "tangent"), force[..., 1:], "N", "tangential force"),
        "relative_displacement": quantity((*nodes, "component"), moved, "m", relative),
        "state": quantity(nodes, states, "1", "open 0, stuck 1, slipping 2"),
    }


def _of_dampers(motions: Sequence[JointMotion]) -> dict[str, Any]:
    """Return how far dampers walk, NaN of other joints; none if all are held."""
    if not motions[0].walks:
        return {}
    names = motions[0].grid.wheel.names
    walks = [[each.walks.get(name, np.nan) for name in names] for each in motions]
    label = "distance by which the damper walks along the axis in a period"
    return {"walk": quantity(("speed", "joint"), walks, "m", label)}


def _of_wall(motions: Sequence[JointMotion]) -> dict[str, Any]:
    """Return the variables of the rub on a wall; none without a wall."""
    if not motions[0].grid.wheel.rubs:
        return {}
    rubs = np.array([rub(each) for each in motions])
    return {
        name: quantity("speed", values, unit, label)
        for (name, (unit, label)), values in zip(OF_WALL.items(), rubs.T, strict=True)
    }
