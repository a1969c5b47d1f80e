"""Periodic motions of a 3D blade that rubs, without time integration: Dataset, rows, document."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import speed_of
from bladewhirl.models.stage.build import Buildable, build_stage, contact_problem
from bladewhirl.models.stage.cone import in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.stage import Stage
from bladewhirl.solvers.periodic.blade import Blade
from bladewhirl.solvers.periodic.contact import Motion, NotConverged
from bladewhirl.solvers.periodic.search import LEAST_INSTANTS, periodic_motion
from bladewhirl.studies.joints import motions as joints
from bladewhirl.studies.joints.dataset import dataset as dataset_of_joints
from bladewhirl.studies.joints.rows import report as report_of_joints
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.periodic import corotating, fine_stability
from bladewhirl.studies.periodic.figures import drawn, plot_periodic
from bladewhirl.studies.periodic.origins import motion_of
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

MOST_PERIODS = 32
"""Largest number of periods of the wall in a period of the motion; 1000 need 12 GiB."""

MANY = 8  #: number of speeds from which on a bladed disk with joints is condensed for all of them

HARMONICS = 32  #: number of harmonics in the Dataset, with the mean

COLUMNS = (
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("speed_rad_s"),
    Column("speed_rpm", "[rpm]", ".1f", variable="rpm"),
    Column("impulse_per_revolution", "impulse per revolution [N s]", ".5g"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("multipliers", variable="pairs"),
    Column("stable", "stable"),
    Column("instants", "instants", "d"),
    Column("residual", "residual", ".1e"),
)
"""Columns of the solutions."""


@dataclass(frozen=True)
class Solution:
    """A periodic motion at a speed."""

    problem: ContactProblem
    motion: Motion
    multipliers: Any  #: complex, the largest first, (2 * modes,)

    @property
    def every(self) -> int:
        """Instants of the motion for one of the Dataset."""
        return self.motion.grid.instants // LEAST_INSTANTS

    def components(self, values: FloatArray) -> FloatArray:
        """Return radial, tangential and axial components of displacements or forces in the axes of
        the wall, (instants of the Dataset, nodes, 3)."""
        cylindrical = in_wall_axes(values.T, -self.problem.slope).T
        return np.asarray(cylindrical[:: self.every].reshape(LEAST_INSTANTS, -1, 3))


def periodic(
    case_or_stage: Buildable,
    *,
    speeds: Sequence[float | str] | None = None,
    blade: int = 0,
    periods: int = 1,
    origin: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Compute the periodic motion of a 3D blade that rubs on a rigid wall or a uniform flexible
    casing, without time integration, and its stability.

    The equations are those of the time integration with massless contact nodes. The motion has the
    period of the wall and of the engine orders, a turn divided by their common number of lobes.
    Ramps of loads are over, and the closure of the casing has its final value. There can be more
    than one periodic motion; this function finds one, stable or not, and not always the one that a
    march from rest finds.

    If the loads are constant in rotating axes, as those of an imbalance, and the wall is round,
    contact is constant in these axes too: on bladed disks of beams or superelements, in a rigid or
    a uniform flexible casing. The Dataset then has `normal_force` [N], `gap` [m] and
    `tip_displacement` [m] of each tip, `centre` [m], `impulse_per_revolution`, `growth_rate` [1/s]
    and `growth_frequency` [rad/s] of the fastest small deviation, `multipliers`, the factors of
    deviations in a turn, and `stable`. Above critical speeds and with dampers in the static frame
    there can be several such motions: all that the search finds follow one another along `speed`,
    stable ones first, at last the one without contact. On a shaft line with equal bearings there
    are also `shaft_displacement` [m, rad] of each node in rotating axes, `bearing_amplitude` [m]
    and `bearing_force` [N].

    A case with [[joint]], a sector or a wheel has the motion of all blades of a tuned wheel, from
    one of them, under engine orders and in a rigid wall. The Dataset then has over (speed, joint)
    `largest_normal_force` [N], `share_open`, `share_slipping` and `work` [J] in a period, for each
    joint and the "casing wall" if tips touch it; `impulse_per_revolution` [N s], `friction_heat`
    and `drive_work` [J] in a period at the wall; `point_amplitude` [m]; and
    over (speed, instant, joint_node) `normal_force`, `tangential_force` [N],
    `relative_displacement` [m] and `state`.

    Args:
        case_or_stage: a case with a superelement in a rigid wall or, with equal blades at equal
            angles of the kind "blade", in a uniform flexible casing; or with an imbalance and a
            round wall, or its stage.
        speeds: speeds of rotation, each a multiple of the reference frequency or text such as "2500
            rpm"; by default the speed of the case.
        blade: number of the blade; in a rigid wall blades do not influence each other, in a
            flexible casing all have the same motion one after another.
        periods: number of periods of the wall and the loads in a period of the motion: 2 for
            motions after a period doubling.
        origin: folder of a run, whose last period begins the search at each speed, or of a branch,
            whose last point does; None: the motion without contact.
        progress: called with the numbers of speeds done and in total.

    Returns:
        over speed: `impulse_per_revolution` [N s] of the normal forces on the blade, `stable`,
        `residual`, `instants` of the grid and `period` [s]; over (speed, multiplier): complex
        `multipliers`, the largest first; over (speed, instant, node) and `direction` (radial,
        tangential, axial): `contact_displacement` [m], `contact_force` [N] and `gap` [m], which is
        normal to the wall; over (speed, order, node, direction): `amplitude` [m] of the harmonics,
        whose engine orders are the coordinate `order`. `speed` is in multiples of the reference
        frequency, with the coordinate `rpm`; `instant` is the share of the period. Speeds without
        contact or with no motion that was found are left out; the attribute `failures` has a line
        for each.

    Raises:
        CaseError: the case cannot be built at one of the speeds.
        UserError: the method does not apply to the case, or at no speed a motion with contact was
            found.
    """
    stage = case_or_stage if isinstance(case_or_stage, Case) else case_or_stage.case
    given = [stage.march.speed.given] if speeds is None else list(speeds)
    if not given:
        raise UserError("periodic: speeds []: expected at least one speed")
    solutions, failures, reference = list[Solution](), list[str](), 1.0
    constant, of_all = list[corotating.State](), list[joints.Found]()
    for done, each in enumerate(given, 1):
        speed = speed_of(each, f"periodic: speeds {each!r}")
        own = corotating.without_steps(with_values(stage, {"march.speed": speed.given}))
        at_speed = _stage_of(own, of_all, len(given))
        reference = at_speed.reference_frequency
        problem = contact_problem(at_speed, steps=False)
        rests = not stage.joint and corotating.is_corotating(problem)
        by_sector = not rests and joints.applies(stage)
        if by_sector and (blade or periods != 1 or origin is not None):
            raise UserError(f"periodic: {joints.ALL_BLADES}: expected no blade, periods and origin")
        structure = None if rests or by_sector else blade_of(at_speed, blade, periods)
        try:
            if by_sector:
                of_all.append(joints.found_at(at_speed, problem, str(speed), of_all))
            elif structure is None:
                constant += corotating.states(problem, str(speed))
            else:
                start = None if origin is None else motion_of(Path(origin), structure, blade)
                solutions.append(solution(problem, structure, str(speed), blade, start))
        except UserError as failure:
            failures += failure.lines
        if progress is not None:
            progress(done, len(given))
    if of_all:
        data = dataset_of_joints(stage, joints.alike(of_all), reference)
    elif constant:
        data = corotating.dataset(at_speed, constant)
    elif solutions:
        data = _dataset(stage, solutions, reference).assign_attrs(blade=blade, periods=periods)
    else:
        raise UserError(*failures)
    return data.assign_attrs(failures="\n".join(failures))


def _stage_of(case: Case, before: Sequence[joints.Found], speeds: int) -> Stage:
    """Return the stage of a case at one of several speeds, after motions at other ones."""
    if not before:
        return build_stage(case)
    like = before[-1].stage
    return joints.stage_of(case, like.over_many_speeds if speeds >= MANY else like)


def nodes_of(stage: Stage, blade: int) -> Stage:
    """Return a stage whose blade with a number is a superelement of its own.

    Raises:
        UserError: it has no such blade.
    """
    table = stage.case.bladed_disk.superelement
    expected = "a superelement, as tips of beams have mass"
    if table is not None:
        expected = (
            f'bladed_disk.superelement.kind = "blade", found "{table.kind}", whose blades move'
            " each other through the disk: a march shows their motion"
        )
    if stage.case.shaft_line is not None:
        expected = "a case without [shaft_line]: a march shows the motion of a line"
    if stage.case.shaft_line is not None or table is None or table.kind != "blade":
        problem = contact_problem(stage, steps=False)
        reason = next(corotating.reasons(stage.case, problem), "no load acts on the bladed disk")
        raise UserError(
            f"periodic: {reason}, so that contact is not constant in rotating axes; other motions"
            f" need {expected}"
        )
    if not 0 <= blade < table.copies:
        raise UserError(f"periodic: blade {blade}: expected 0 to {table.copies - 1}")
    return stage


def blade_of(
    stage: Any, blade: int, periods: int = 1, others: Sequence[ContactProblem] = ()
) -> Blade:
    """Return a blade of a stage for the method, whose motion has several periods of the wall; for
    `others` see `Blade.of_problem`.

    Raises:
        UserError: the method does not apply.
    """
    if not 1 <= periods <= MOST_PERIODS:
        raise UserError(f"periodic: periods {periods}: expected from 1 to {MOST_PERIODS}")
    try:
        problem = contact_problem(nodes_of(stage, blade))
        structure = Blade.of_problem(problem, blade, others)
    except ValueError as reason:
        raise UserError(f"periodic: {reason}") from None
    if periods > 1 and structure.ring is not None:
        raise UserError(
            f"periodic: periods {periods}: expected 1 in a flexible casing, in which the blades"
            " follow one another"
        )
    return replace(structure, periods=periods)


def solution(
    problem: ContactProblem, blade: Blade, speed: str, number: int, start: Motion | None = None
) -> Solution:
    """Return the periodic motion of a blade with a number at a speed, whose text is in messages;
    the search begins at `start`.

    Raises:
        UserError: the blade does not touch the wall, or no motion was found.
    """
    motion = found_motion(blade, speed, start)
    if not motion.touches:
        smallest = motion.gap.min()
        raise UserError(
            f"periodic: no contact at {speed}: the smallest gap is {1e3 * smallest:.4g} mm"
        )
    largest = np.abs(motion.displacement).max()
    if largest > problem.displacement_limit:
        raise UserError(
            f"periodic: at {speed} contact nodes move by {largest:.4g} m, beyond"
            f" march.displacement_limit = {problem.displacement_limit:.4g} m"
        )
    check_periods(motion, speed)
    return Solution(problem, motion, fine_stability.multipliers(problem, motion, number))


def check_periods(motion: Motion, where: str) -> None:
    """Check that a motion with several periods of the wall does not repeat before.

    Raises:
        UserError: it does.
    """
    if motion.repeats:
        raise UserError(
            f"periodic: at {where} the motion repeats in less than {motion.grid.blade.periods}"
            " periods; expected another start: --from with a run that has this motion"
        )


def found_motion(blade: Blade, where: str, start: Motion | None = None) -> Motion:
    """Return a periodic motion of a blade; `where` is the speed or another value in messages.

    Raises:
        UserError: no motion was found.
    """
    try:
        return periodic_motion(blade, start)
    except NotConverged as reason:
        raise UserError(
            f"periodic: no periodic motion was found at {where}: {reason}; other speeds or a march"
            " can show whether there is one"
        ) from None


def _dataset(case: Case, solutions: Sequence[Solution], reference: float) -> xr.Dataset:
    """Return the Dataset of solutions at speeds, for a reference frequency [rad/s]."""
    motions = [each.motion for each in solutions]
    speeds = np.array([each.problem.speed for each in solutions])
    moved = np.stack([each.components(each.motion.displacement) for each in solutions])
    force = np.stack([each.components(each.motion.force) for each in solutions])
    gap = np.stack([each.motion.gap[:: each.every] for each in solutions])
    spectrum = np.abs(np.fft.rfft(moved, axis=1)) / LEAST_INSTANTS
    spectrum[:, 1:] *= 2.0
    over, nodes = "speed", ("speed", "instant", "node")
    return xr.Dataset(
        {
            "impulse_per_revolution": quantity(
                over, [each.impulse for each in motions], "N s", "normal impulse per revolution"
            ),
            "multipliers": (
                ("speed", "multiplier"),
                np.stack([each.multipliers for each in solutions]),
            ),
            "stable": (over, [bool(abs(each.multipliers[0]) < 1.0) for each in solutions]),
            "residual": (over, [each.residual for each in motions]),
            "instants": (over, [each.grid.instants for each in motions]),
            "period": quantity(over, [each.grid.blade.period for each in motions], "s"),
            "contact_displacement": quantity((*nodes, "direction"), moved, "m"),
            "contact_force": quantity((*nodes, "direction"), force, "N"),
            "gap": quantity(nodes, gap, "m", "gap"),
            "amplitude": quantity(
                ("speed", "order", "node", "direction"), spectrum[:, :HARMONICS], "m"
            ),
        },
        coords={
            "speed": quantity(over, speeds / reference, "1", "normalised speed"),
            "rpm": quantity(over, speeds * 30.0 / np.pi, "rpm", "speed"),
            "instant": np.arange(LEAST_INSTANTS) / LEAST_INSTANTS,
            "direction": ["radial", "tangential", "axial"],
            "order": motions[0].grid.blade.first_order * np.arange(HARMONICS),
        },
        attrs={
            "title": "periodic motion of a rub",
            "case": case.title,
            "reference_frequency_hz": reference / (2.0 * np.pi),
        },
    )


def failures(data: xr.Dataset) -> list[str]:
    """Return a sentence for each speed at which `periodic` found no motion with contact."""
    return str(data.attrs["failures"]).splitlines()


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of `periodic`; multipliers in the document are pairs of
    real and imaginary part, the largest first."""
    if "joint" in data.dims:
        return report_of_joints(data, failures(data))
    if "normal_force" in data:
        return corotating.report(data, failures(data))
    values = data["multipliers"].values
    shown = data.assign(
        speed_rad_s=data["rpm"] * np.pi / 30.0,
        largest_multiplier=np.abs(data["multipliers"][:, 0]),
        pairs=(("speed", "multiplier", "part"), np.stack([values.real, values.imag], axis=-1)),
    )
    rows = rows_of(shown, COLUMNS)
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "solutions": rows,
        "failures": failures(data),
    }
    return Study(
        name="periodic",
        document=document,
        tables=[table(rows, COLUMNS, "Periodic motions")],
        figures=lambda: {"periodic": (plot_periodic(data), drawn(data))},
    )
