"""Periodic motions of a tuned wheel with friction joints at speeds: Dataset, rows, document."""

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import speed_of
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.limits import LIMITS
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.modal_loads import NEVER
from bladewhirl.postprocess.joints.motions import plot_joints
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joint_law import OPEN, SLIPPING
from bladewhirl.solvers.periodic.joint_search import joint_motion
from bladewhirl.solvers.periodic.joint_stability import NEUTRAL, multipliers
from bladewhirl.solvers.periodic.joints import JointMotion
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, table

VAGUE = 0.05  #: change with the harmonics from which on a hint names a motion
INSTANTS = 128  #: least number of instants of the forces in the Dataset

COLUMNS = (
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("speed_rad_s"),
    Column("speed_rpm", "[rpm]", ".1f"),
    Column("amplitude", "amplitude of a point [mm]", ".4g", 1e3),
    Column("point_amplitude"),
    Column("largest_normal_force", "largest normal force [N]", ".4g"),
    Column("share_open", "open [–]", ".2f"),
    Column("share_slipping", "slipping [–]", ".2f"),
    Column("work", "work in a period [J]", ".4g"),
    Column("joints"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("stable", "stable"),
    Column("linear_limits"),
    Column("harmonics", "harmonics", "d"),
    Column("change", "change with harmonics [–]", ".1e"),
    Column("residual", "residual", ".1e"),
)
"""Columns of the solutions; of several joints the largest force and share, and all work."""

OF_JOINTS = {
    "largest_normal_force": ("N", "largest normal force"),
    "share_open": ("1", "share of the period in which the nodes are open"),
    "share_slipping": ("1", "share of the period in which the nodes slip"),
    "work": ("J", "work that the joint takes from the blades in a period"),
}
"""Variables over (speed, joint) with unit and name."""


def periodic(
    case: Case,
    *,
    speeds: Sequence[float | str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Compute the periodic motions of a tuned wheel with joints; see `bladewhirl.periodic`.

    Raises:
        CaseError: the case cannot be built at one of the speeds.
        UserError: the method does not apply, or at no speed a motion was found.
    """
    given = [case.march.speed.given] if speeds is None else list(speeds)
    if not given:
        raise UserError("periodic: speeds []: expected at least one speed")
    found: list[JointMotion] = []
    failures, motion, stage = list[str](), None, None
    for done, each in enumerate(given, 1):
        speed = speed_of(each, f"periodic: speeds {each!r}")
        stage = stage_of(with_values(case, {"march.speed": speed.given}), stage)
        problem = contact_problem(stage, steps=False)
        wheel = checked(problem, jointed_wheel(stage))
        try:
            motion = joint_motion(wheel, motion)
            if reason := beyond(problem, motion):
                failures.append(f"periodic: at {speed} {reason}")
            else:
                found.append(motion)
        except NotConverged as reason:
            failures.append(f"periodic: no periodic motion was found at {speed}: {reason}")
        if progress is not None:
            progress(done, len(given))
    if not found or stage is None:
        raise UserError(*failures)
    data = dataset(case, found, stage.reference_frequency)
    return data.assign_attrs(failures="\n".join(failures))


def stage_of(case: Case, like: Matrices | None = None) -> Matrices:
    """Return the stage of a case with joints; `like`: that of a case that differs only in speed,
    joints and loads."""
    if like is None:
        return cast(Matrices, build_stage(case))  # only superelements have joints
    speed = case.march.speed.rad_per_s(like.reference_frequency)
    return cast(Matrices, like.with_case(case)).at(speed)


def checked(problem: ContactProblem, wheel: JointedWheel) -> JointedWheel:
    """Return a wheel to which the method applies.

    Raises:
        UserError: it does not.
    """
    if problem.speed == 0.0:
        raise UserError("periodic: march.speed = 0: expected a speed at which the loads vary")
    if not any(wheel.orders):
        raise UserError('periodic: expected excitation.type = "engine-order" of an order above 0')
    if problem.casing.is_flexible:
        raise UserError('periodic: joints: expected casing.type = "rigid"')
    if any(abs(load.rotor).any() for load in problem.loads if load.end != NEVER):
        raise UserError("periodic: a load ends; expected loads without an end")
    return wheel


def beyond(problem: ContactProblem, motion: JointMotion) -> str:
    """Return why a motion is not one of the joints alone; empty if it is."""
    moved = motion.of_points()
    largest = float(np.abs(moved).max(initial=0.0))
    if largest > problem.displacement_limit:
        return (
            f"points move by {largest:.4g} m, beyond march.displacement_limit ="
            f" {problem.displacement_limit:.4g} m"
        )
    tips = moved[:, len(motion.grid.wheel.loaded) :, 0]
    clearance = float(problem.clearance(NEVER)[:, 0].min())
    if tips.size and tips.max() > clearance:
        return (
            f"the tips reach the wall: they move outward by {1e3 * tips.max():.4g} mm, and the"
            f" clearance is {1e3 * clearance:.4g} mm; joints with a rub are not computed"
        )
    return ""


def amplitudes_of(motion: JointMotion) -> ComplexArray:
    """Return the complex amplitudes of the lowest engine order at `JointedWheel.shown` [m],
    (points, 3)."""
    wheel = motion.grid.wheel
    order = next(each for each in wheel.orders if each)
    return wheel.at_points(order, motion.of_order(order))[: len(wheel.shown)]


def limits_of(wheel: JointedWheel) -> FloatArray:
    """Return the amplitudes of the same points in the linear limits, (limits, points) [m]."""
    order = next(each for each in wheel.orders if each)
    moved = [wheel.limit(order, held)[: len(wheel.shown)] for held in LIMITS.values()]
    return np.asarray(np.linalg.norm(moved, axis=-1))


def dataset(case: Case, motions: Sequence[JointMotion], reference: float) -> xr.Dataset:
    """Return the Dataset of motions at speeds, for a reference frequency [rad/s]."""
    wheel = motions[0].grid.wheel
    speeds = np.array([each.grid.wheel.speed for each in motions])
    count = wheel.blades * -(-INSTANTS // wheel.blades)  # all blades have the same instants
    force, moved, states = (
        np.stack(each) for each in zip(*(motion.at(count) for motion in motions), strict=True)
    )

    def of_joints(values: Callable[[JointMotion], Any], merged: Callable[[Any], Any]) -> Any:
        """Return a value of each joint from those of its nodes, (speeds, joints)."""
        numbers = range(len(wheel.names))
        return [[merged(values(each)[..., wheel.joint == n]) for n in numbers] for each in motions]

    sums = {
        "largest_normal_force": of_joints(lambda m: m.force[..., 0], np.max),
        "share_open": of_joints(lambda m: m.states == OPEN, np.mean),
        "share_slipping": of_joints(lambda m: m.states == SLIPPING, np.mean),
        "work": of_joints(lambda m: m.work, np.sum),
    }
    order = next(each for each in wheel.orders if each)
    amplitude = [np.abs(amplitudes_of(each)) for each in motions]
    limits = [limits_of(each.grid.wheel) for each in motions]
    largest = np.array([abs(multipliers(each)[0]) for each in motions])
    over, nodes = "speed", ("speed", "instant", "joint_node")
    return xr.Dataset(
        {
            **{
                name: quantity((over, "joint"), sums[name], unit, label)
                for name, (unit, label) in OF_JOINTS.items()
            },
            "point_amplitude": quantity(
                (over, "point", "direction"), amplitude, "m", f"amplitude of engine order {order}"
            ),
            "linear_limit": quantity(
                (over, "limit", "point"),
                limits,
                "m",
                "amplitude with joints free, closed without friction, or stuck",
            ),
            "largest_multiplier": quantity(
                over, largest, "1", "factor by which a deviation grows in a period"
            ),
            "stable": (over, largest < 1.0 + NEUTRAL),
            "normal_force": quantity(nodes, force[..., 0], "N", "normal force"),
            "tangential_force": quantity(
                (*nodes, "tangent"), force[..., 1:], "N", "tangential force"
            ),
            "relative_displacement": quantity(
                (*nodes, "component"),
                moved,
                "m",
                "displacement of the next blade relative to this one: normal, two tangents",
            ),
            "state": quantity(nodes, states, "1", "open 0, stuck 1, slipping 2"),
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
            "title": "periodic motion of a wheel with joints",
            "case": case.title,
            "engine_order": order,
            "points": "point" if wheel.loaded else "tip node",
            "blades": wheel.blades,
            "reference_frequency_hz": reference / (2.0 * np.pi),
        },
    )


def report(data: xr.Dataset, failures: Sequence[str]) -> Study:
    """Return the document, table and figure of `periodic`."""
    rows = rows_of(data)
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "engine_order": data.attrs["engine_order"],
        "solutions": rows,
        "failures": list(failures),
    }
    return Study(
        name="periodic",
        document=document,
        tables=[table(rows, COLUMNS, "Periodic motions with joints")],
        figures=lambda: {"periodic": (plot_joints(data), data)},
        hints=hints(rows),
    )


def hints(rows: Sequence[dict[str, Any]]) -> str:
    """Return hints about motions that are not stable or depend on the number of harmonics."""
    lost = sum(not row["stable"] for row in rows)
    alone = sum(row["change"] is None for row in rows)
    vague = sum((row["change"] or 0.0) > VAGUE for row in rows)
    found = []
    if lost:
        found.append(
            f"{lost} of {len(rows)} motions are not stable: a march does not settle on them"
        )
    if vague:
        found.append(
            f"{vague} of {len(rows)} motions change by more than {VAGUE:.0%} with the number of"
            " harmonics: compare them with a march"
        )
    if alone:
        found.append(
            f"{alone} of {len(rows)} motions were found with one number of harmonics alone, and"
            " their error is unknown (no change in the table): compare them with a march"
        )
    return "; ".join(found)


def rows_of(data: xr.Dataset, over: str = "speed") -> list[dict[str, Any]]:
    """Return the rows of the motions over a dimension."""
    rows, limits = [], data["limit"].values.tolist()
    for n in range(data.sizes[over]):
        one = data.isel({over: n})
        of_joints = {
            name: {key: float(one[key].sel(joint=name)) for key in OF_JOINTS}
            for name in one["joint"].values.tolist()
        }
        rows.append(
            {
                "speed": float(one["speed"]),
                "speed_rad_s": float(one["rpm"]) * np.pi / 30.0,
                "speed_rpm": float(one["rpm"]),
                "amplitude": _largest(one["point_amplitude"].values),
                "point_amplitude": one["point_amplitude"].values.tolist(),
                **{key: float(one[key].max("joint")) for key in list(OF_JOINTS)[:3]},
                "work": float(one["work"].sum("joint")),
                "joints": of_joints,
                "largest_multiplier": float(one["largest_multiplier"]),
                "stable": bool(one["stable"]),
                "linear_limits": dict(
                    zip(limits, one["linear_limit"].values.tolist(), strict=True)
                ),
                "harmonics": int(one["harmonics"]),
                "change": _finite(float(one["change"])),
                "residual": float(one["residual"]),
            }
        )
    return rows


def _finite(value: float) -> float | None:
    """Return a value, or None for infinity."""
    return value if np.isfinite(value) else None


def _largest(amplitudes: FloatArray) -> float | None:
    """Return the largest length of some vectors, (vectors, 3); None without any."""
    return float(np.linalg.norm(amplitudes, axis=-1).max()) if len(amplitudes) else None
