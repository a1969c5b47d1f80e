"""Periodic motions of a tuned wheel with friction joints or a rub: Dataset, rows, document."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder, NoExcitation
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.limits import LIMITS
from bladewhirl.models.joints.tips import WALL, obstacles
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.modal_loads import NEVER
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.joints.motions import plot_joints
from bladewhirl.solvers.periodic.blade import obstacles_over_time
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joint_law import OPEN, SLIPPING
from bladewhirl.solvers.periodic.joint_rub import rub
from bladewhirl.solvers.periodic.joint_search import joint_motion
from bladewhirl.solvers.periodic.joint_stability import NEUTRAL, multipliers
from bladewhirl.solvers.periodic.joints import JointGrid, JointMotion, common_order
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, table

ALL_BLADES = "one motion for all blades"
"""The kind of motion in messages."""
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
    Column("wall"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("stable", "stable"),
    Column("linear_limits"),
    Column("harmonics", "harmonics", "d"),
    Column("change", "change with harmonics [–]", ".1e"),
    Column("residual", "residual", ".1e"),
)
"""Columns of the solutions; of several joints the largest force and share, and all work."""

WALL_COLUMNS = (
    Column("wall.largest_normal_force", "largest force on a tip [N]", ".4g"),
    Column("wall.share_open", "tips open [–]", ".3f"),
    Column("wall.impulse_per_revolution", "impulse per revolution [N s]", ".4g"),
    Column("wall.friction_heat", "friction heat in a period [J]", ".4g"),
    Column("wall.drive_work", "work of the drive in a period [J]", ".4g"),
)
"""Columns of the solutions with a wall."""

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


class Found(NamedTuple):
    """A motion, and the stage and the contact problem that it belongs to."""

    stage: Matrices
    problem: ContactProblem
    motion: JointMotion


def applies(case: Case) -> bool:
    """Return whether motions of a case are those of all blades of a tuned wheel."""
    table = None if case.shaft_line is not None else case.bladed_disk.superelement
    return bool(case.joint) or (table is not None and table.kind != "blade")


def found_at(
    stage: Stage, problem: ContactProblem, speed: str, before: Sequence[Found] = ()
) -> Found:
    """Return a periodic motion of a tuned wheel with joints, or with a wall that it touches.

    Args:
        stage: stage of a superelement.
        problem: its contact problem.
        speed: text of the speed in messages.
        before: motions at other speeds, near the last of which the motion may be.

    Raises:
        CaseError: the preload of a joint is not possible.
        UserError: the method does not apply, or no motion was found.
    """
    check(stage, problem)
    own = cast(Matrices, stage)  # of superelements, see `applies`
    start = before[-1].motion if before else None
    try:
        motion = _motion(own, problem, start)
    except NotConverged as missed:
        raise UserError(f"periodic: no periodic motion was found at {speed}: {missed}") from None
    if not motion.touches and not stage.case.joint:
        raise UserError(
            f"periodic: no contact at {speed}: the smallest gap is"
            f" {1e3 * motion.smallest_gap:.4g} mm"
        )
    if reason := beyond(problem, motion):
        raise UserError(f"periodic: at {speed} {reason}")
    return Found(own, problem, motion)


def stage_of(case: Case, like: Matrices | None = None) -> Matrices:
    """Return the stage of a case with joints; `like`: that of a case that differs only in speed,
    joints and loads."""
    if like is None:
        return cast(Matrices, build_stage(case))  # only superelements have joints
    speed = case.march.speed.rad_per_s(like.reference_frequency)
    return cast(Matrices, like.with_case(case)).at(speed)


def _motion(stage: Matrices, problem: ContactProblem, start: JointMotion | None) -> JointMotion:
    """Return a motion, with the wall only if it is touched without it; for errors see `found_at`
    and `joint_motion`."""
    if stage.case.joint and (wheel := jointed_wheel(stage)).varies:
        motion = joint_motion(wheel, start)
        if not reaches(problem, motion):
            return motion
    return joint_motion(rubbing_wheel(stage, problem), start)


def rubbing_wheel(stage: Matrices, problem: ContactProblem) -> JointedWheel:
    """Return the wheel of a stage whose tips touch the wall of its contact problem.

    Raises:
        UserError: the method does not apply.
    """
    for reason in obstacles(problem):
        raise UserError(f"periodic: {ALL_BLADES}: {reason}")
    wheel = jointed_wheel(stage, problem)
    if not wheel.varies:
        raise UserError(
            "periodic: the wall is round and no load varies with time, so that the motion has no"
            " period"
        )
    return wheel


def check(stage: Stage, problem: ContactProblem) -> None:
    """Check that the motions of a stage follow from one blade.

    Raises:
        UserError: they do not.
    """
    if problem.speed == 0.0:
        raise UserError("periodic: march.speed = 0: expected a speed at which the loads vary")
    for reason in obstacles_over_time(problem):
        raise UserError(f"periodic: {reason}")
    for key, load in stage.case.excitations.items():
        if not isinstance(load, EngineOrder | NoExcitation):
            raise UserError(f'periodic: {key}.type = "{load.type}": expected engine orders or none')
    if any(abs(load.rotor).any() for load in problem.loads if load.end != NEVER):
        raise UserError("periodic: a load ends; expected loads without an end")


def reaches(problem: ContactProblem, motion: JointMotion) -> bool:
    """Return whether the tips of a motion without a wall can be beyond it."""
    tips = motion.of_points()[:, len(motion.grid.wheel.loaded) :, 0]
    nearest = problem.clearance(NEVER)[:, 0].min() + problem.rotor.tip_recess.min()
    return bool(tips.size and tips.max() > nearest)


def beyond(problem: ContactProblem, motion: JointMotion) -> str:
    """Return why the displacements of a motion are too large; empty if they are not."""
    largest = float(np.abs(motion.of_points()).max(initial=0.0))
    if largest <= problem.displacement_limit:
        return ""
    return (
        f"points move by {largest:.4g} m, beyond march.displacement_limit ="
        f" {problem.displacement_limit:.4g} m"
    )


def amplitudes_of(motion: JointMotion) -> ComplexArray:
    """Return the complex amplitudes of the lowest engine order at `JointedWheel.shown` [m],
    (points, 3)."""
    wheel = motion.grid.wheel
    order = wheel.shown_order
    return wheel.at_points(order, motion.of_order(order))[: len(wheel.shown)]


def limits_of(wheel: JointedWheel) -> FloatArray:
    """Return the amplitudes of the same points in the linear limits, (limits, points) [m]."""
    order = wheel.shown_order
    moved = [wheel.limit(order, held)[: len(wheel.shown)] for held in LIMITS.values()]
    return np.asarray(np.linalg.norm(moved, axis=-1))


def dataset(case: Case, motions: Sequence[JointMotion], reference: float) -> xr.Dataset:
    """Return the Dataset of motions at speeds, for a reference frequency [rad/s]; either all of
    them have a wall or none."""
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
    order = wheel.shown_order
    amplitude = [np.abs(amplitudes_of(each)) for each in motions]
    limits = [limits_of(each.grid.wheel) for each in motions]
    largest = np.array([abs(multipliers(each)[0]) for each in motions])
    over, nodes = "speed", ("speed", "instant", "joint_node")
    label = f"amplitude of engine order {order}"
    return xr.Dataset(
        {
            **{
                name: quantity((over, "joint"), sums[name], unit, label)
                for name, (unit, label) in OF_JOINTS.items()
            },
            **_of_wall(motions),
            "point_amplitude": quantity((over, "point", "direction"), amplitude, "m", label),
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
            "title": "periodic motion of all blades of a wheel",
            "case": case.title,
            "engine_order": order,
            "points": "point" if wheel.loaded else "tip node",
            "blades": wheel.blades,
            "reference_frequency_hz": reference / (2.0 * np.pi),
        },
    )


def _of_wall(motions: Sequence[JointMotion]) -> dict[str, Any]:
    """Return the variables of the rub on a wall; none without a wall."""
    if not motions[0].grid.wheel.rubs:
        return {}
    rubs = np.array([rub(each) for each in motions])
    return {
        name: quantity("speed", values, unit, label)
        for (name, (unit, label)), values in zip(OF_WALL.items(), rubs.T, strict=True)
    }


def alike(found: Sequence[Found]) -> list[JointMotion]:
    """Return motions that all have a wall if one of them touches it."""
    motions = [each.motion for each in found]
    if not any(motion.grid.wheel.rubs for motion in motions):
        return motions
    for n, (stage, problem, motion) in enumerate(found):
        if not motion.grid.wheel.rubs:
            wheel = rubbing_wheel(stage, problem)
            finer = motion.grid.order // common_order(wheel)
            grid = JointGrid(wheel, motion.grid.harmonics * finer)
            motions[n] = replace(motion.on(grid), change=motion.change)
    return motions


def report(data: xr.Dataset, failures: Sequence[str]) -> Study:
    """Return the document, table and figure of `periodic`."""
    rows = rows_of(data)
    columns = shown_columns(data)
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "engine_order": data.attrs["engine_order"],
        "solutions": rows,
        "failures": list(failures),
    }
    return Study(
        name="periodic",
        document=document,
        tables=[table(rows, columns, "Periodic motions of all blades")],
        figures=lambda: {"periodic": (plot_joints(data), data)},
        hints=hints(rows),
    )


def shown_columns(data: xr.Dataset) -> tuple[Column, ...]:
    """Return the columns of motions: those of joints only if there are some besides a wall."""
    contacts = data["joint"].values.tolist()
    own = COLUMNS if contacts != [WALL] else [each for each in COLUMNS if each.key not in OF_JOINTS]
    return (*own, *(WALL_COLUMNS if WALL in contacts else ()))


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
        contacts = {
            name: {key: float(one[key].sel(joint=name)) for key in OF_JOINTS}
            for name in one["joint"].values.tolist()
        }
        wall = contacts.pop(WALL, None)
        points = one["point_amplitude"].values
        rows.append(
            {
                "speed": float(one["speed"]),
                "speed_rad_s": float(one["rpm"]) * np.pi / 30.0,
                "speed_rpm": float(one["rpm"]),
                "amplitude": _largest(points),
                "point_amplitude": points.tolist(),
                **{
                    key: (sum if key == "work" else max)(each[key] for each in contacts.values())
                    for key in (OF_JOINTS if contacts else ())
                },
                "joints": contacts,
                "wall": wall and wall | {key: float(one[key]) for key in OF_WALL},
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
