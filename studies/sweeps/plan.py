"""Plan of a sweep: validated points, their cost, and the layout of the results."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from bladewhirl.files import json_text, write_atomically
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import loads, with_values
from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.progress import count
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.postprocess.sweep.dataset import Layout
from bladewhirl.solvers.march.free_motion import RULE, STOPS, FreeMotion, StopWhen
from bladewhirl.solvers.march.schema import DRAW, POINT, SWEEP_FORMAT
from bladewhirl.studies.runs import folder
from bladewhirl.studies.runs.prepare import problem_of, screened
from bladewhirl.studies.sweeps.axes import OVER, Grid, PointTable, coordinate, make_grid, unit_of
from bladewhirl.studies.sweeps.carried import (
    CARRIES,
    CARRY_RULE,
    CONTINUE,
    FEWEST_TURNS,
    Carry,
    carry_fault,
)
from bladewhirl.studies.sweeps.draws import Draws, parse_draws
from bladewhirl.studies.sweeps.layout import history_bytes, make_layout, march_extent
from bladewhirl.studies.sweeps.points import Point
from bladewhirl.studies.sweeps.stages import stage_at
from bladewhirl.studies.sweeps.starts import (
    SPEED,
    START,
    START_RULE,
    STARTS,
    StartName,
    check_start,
    line_of,
)
from bladewhirl.studies.sweeps.store import Coordinates

STOP_WHEN, SCREEN = "--stop-when", "--screen"

FEWEST_SCREENED = 4
"""Smallest number of random draws of a screened sweep: with fewer draws, the confidence interval of
a share includes one half even if all draws agree."""

SCREEN_RULE = (
    "a point is screened: its draws are marched, until two differ, with casing modes above a cut"
    " scaled down to it, and with a time step of at most half the critical one; where the regimes"
    " of the draws differ or the 95 % interval of the share of a regime includes one half, the"
    " draws are repeated with the time step of the case, all of them, or those that the rule of"
    " --until needs if it is given"
)
"""Text of the rule, which every screened sweep contains."""

PLAN_NAME = "sweep.json"  #: name of the file with the plan of a sweep, for resuming it

CHECKED_STAGES, CHECK_TIME = 30, 5.0
"""Largest number of stages validated before a sweep besides those of the first and of the last
point, and the time that they may take [s]; faults of other stages appear as failed points."""

CHECKING, CHECKED = "checking points", "points checked"

ASKED_STEPS, ASKED_STEPS_IN_ALL = 1_000_000_000, 1_000_000_000_000
"""Largest numbers of steps of one march and of a sweep without confirmation: such a march takes
hours, such a sweep weeks on many cores."""


@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """How the points of a sweep are marched."""

    histories: bool = False  #: whether full histories are kept
    stop_when: StopWhen | None = None  #: condition for ending a march early, see `free_motion.RULE`
    screen: bool = False  #: whether points are screened, see `SCREEN_RULE`
    carry: Carry | None = None  #: direction in which the motion is carried, see `CARRY_RULE`
    start: StartName = "rest"  #: motion from which marches start, see `START_RULE`


@dataclass(frozen=True, kw_only=True)
class SweepPlan(SweepOptions):
    """Validated sweep with its points and cost."""

    case: Case
    grid: Grid
    coordinates: Coordinates
    layout: Layout
    steps: int  #: number of steps of all marches together, if none ends early
    history_bytes: int  #: size of all full histories [bytes]

    @property
    def dataset_bytes(self) -> int:
        """Size of the dataset [bytes]."""
        return self.grid.size * self.layout.bytes_per_point

    @property
    def digest(self) -> str:
        """Digest of the input of the points, see `plan_digest`."""
        return plan_digest(self.case, self.grid.over, self, self.grid.draws, self.grid.listed)

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the dataset that depend on the case and on the program."""
        attributes = {"title": self.case.title, "case": folder.portable_case(self.case)}
        attributes |= {"version": folder.version(), "plan": self.digest}
        attributes |= {} if self.stop_when is None else {"stop_rule": RULE}
        attributes |= {"screen_rule": SCREEN_RULE} if self.screen else {}
        if self.carry is not None:
            attributes |= {"carry": self.carry, "carry_rule": CARRY_RULE}
        attributes |= {"start_rule": START_RULE} if self.start == "periodic" else {}
        return attributes

    @property
    def hints(self) -> tuple[str, ...]:
        """Warnings about implausible values at the first and the last point."""
        ends = (self.grid.values(number) for number in (0, self.grid.size - 1))
        return tuple(
            dict.fromkeys(hint for at in ends for hint in case_hints(with_values(self.case, at)))
        )

    def point(self, number: int, *, screen: bool = False, before: int | None = None) -> Point:
        """Return a point for a worker to march. If `screen`, masses are scaled; if `before` is
        given, the march starts from the state at the end of the point with this number."""
        line = line_of(self.grid, number) if self.start == "periodic" else None
        digits = len(str(self.grid.size - 1))
        name = f"point_{number:0{digits}d}.nc" if self.histories else None
        return Point(
            number=number,
            values=self.grid.values(number),
            history=name,
            screen=screen,
            before=None if before is None else f"point_{before}.npz",
            after=None if self.carry is None else f"point_{number}.npz",
            branch=None if line is None else line.folder,
            value=None if line is None else self.grid.values(number)[line.key],
        )


def plan_sweep(
    case: Case, grid: Grid, options: SweepOptions | None = None, *, large: bool = True
) -> SweepPlan:
    """Validate every point of a sweep and estimate its cost.

    Points are validated one after the other, so that a sweep of any size takes little memory.

    Args:
        case: case that is varied.
        grid: points of the sweep.
        options: how the points are marched; the defaults if None.
        large: whether to allow more than a billion steps of a march, or a trillion of the sweep.

    Raises:
        UserError: the case has errors at a point, which the message names; there are more steps
            than allowed; or a case does not permit `stop_when` or `screen`.
    """
    options = options or SweepOptions()
    histories, screen, stop_when = options.histories, options.screen, options.stop_when
    with grid.naming(0):
        stage = stage_at(with_values(case, grid.values(0)))
    extent = march_extent(each.in_seconds(stage.reference_frequency) for each in grid.cases(case))
    for steps, most, what in (
        (extent.most_steps, ASKED_STEPS, "steps of one march"),
        (extent.steps, ASKED_STEPS_IN_ALL, "steps of all marches"),
    ):
        if steps > most and not large:
            raise UserError(
                f"{OVER}: {steps:.3g} {what} are more than {most:.0e}; --yes runs them all"
            )
    coordinates = _coordinates(case, grid)
    _check_stages(case, grid, screen=screen)
    if screen and (grid.draws is None or grid.draws.count < FEWEST_SCREENED):
        raise UserError(f"{SCREEN}: needs --draws of at least {FEWEST_SCREENED}")
    if screen and histories:
        raise UserError(
            f"{SCREEN}: not allowed together with --histories: a screening march has no accurate"
            " stresses, nor spectra above its cut-off frequency"
        )
    if options.carry is not None:
        others = histories or screen or stop_when or (grid.draws and grid.draws.until)
        _check_carry(case, grid, coordinates, others=bool(others))
    if options.start == "periodic":
        _check_start(case, grid, others=bool(screen or options.carry or histories))
    if stop_when is not None:
        try:
            FreeMotion.of(problem_of(stage), stage.case.march.time_step)
        except ValueError as error:
            expected = "expected a motion that decays without contact"
            raise UserError(f"{STOP_WHEN} {stop_when}: {expected}, but {error}") from None
    return SweepPlan(
        case=case,
        grid=grid,
        coordinates=coordinates,
        layout=make_layout(extent, stage, starts=options.start == "periodic"),
        **asdict(options),
        steps=extent.steps,
        history_bytes=history_bytes(extent, stage) if histories else 0,
    )


def _described(draws: Draws) -> dict[str, Any]:
    """Return draws as they are written into the plan."""
    perturb = [perturbation.text for perturbation in draws.perturbations]
    described = {"count": draws.count, "seed": draws.seed, "perturb": perturb}
    return described if draws.until is None else {**described, "until": draws.until}


def plan_digest(
    case: Case,
    over: Mapping[str, Any],
    options: SweepOptions,
    draws: Draws | None,
    table: Mapping[str, Any],
) -> str:
    """Return the SHA-256 digest of all input of the points; plan and dataset contain this
    digest."""
    # The last entry, 1, is the number of points marched together.
    made_by = [folder.version(), SWEEP_FORMAT, dict(over), 1]
    made_by += [] if options.stop_when is None else [options.stop_when]
    made_by += [] if draws is None else [_described(draws)]
    made_by += [dict(table)] if table else []
    made_by += [SCREEN] if options.screen else []
    made_by += [CONTINUE, options.carry] if options.carry else []
    made_by += [START, options.start] if options.start != "rest" else []
    whole = sha256(json.dumps(made_by).encode())
    for name, content in folder.case_files(case).items():
        whole.update(name.encode() + content)
    return whole.hexdigest()


def write_plan(plan: SweepPlan, directory: Path) -> None:
    """Write the plan of a sweep into its folder, with a copy of the case's mesh file."""
    files = folder.case_files(plan.case)
    document = {
        folder.PACKAGE: folder.version(),
        "format": SWEEP_FORMAT,
        "digest": plan.digest,
        "case": files.pop(folder.CASE_NAME).decode(),
        "over": plan.grid.over,
        "histories": plan.histories,
        "stop_when": plan.stop_when,
    }
    if plan.grid.table:
        document["table"] = plan.grid.listed
    if plan.screen:
        document["screen"] = True
    if plan.carry is not None:
        document["carry"] = plan.carry
    if plan.start != "rest":
        document["start"] = plan.start
    if plan.grid.draws is not None:
        document["draws"] = _described(plan.grid.draws)
    for name, content in files.items():
        write_atomically(directory / name, content)
    write_atomically(directory / PLAN_NAME, json_text(document))


def require_new(directory: Path) -> None:
    """Check that a folder for results does not exist or is empty.

    Raises:
        UserError: it is not; the message says whether a sweep in it can be resumed.
    """
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        resumable = (directory / PLAN_NAME).exists()
        hint = "; --resume finishes the sweep in it" if resumable else ""
        raise UserError(f"{directory}: expected a new or an empty folder{hint}")


def read_plan(directory: Path) -> SweepPlan:
    """Return the plan of an existing sweep.

    Raises:
        UserError: there is no plan, or the plan has another version or format, or was changed.
    """
    path = directory / PLAN_NAME
    try:
        document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        made_by, text = str(document[folder.PACKAGE]), str(document["case"])
        over, table = (
            {str(key): tuple(values) for key, values in dict(given).items()}
            for given in (document["over"], document.get("table", {}))
        )
        stop_rule, direction = document.get("stop_when"), document.get("carry")
        options = SweepOptions(
            histories=bool(document["histories"]),
            stop_when=None if stop_rule is None else STOPS[STOPS.index(stop_rule)],
            screen=bool(document.get("screen", False)),
            carry=None if direction is None else CARRIES[CARRIES.index(direction)],
            start=STARTS[STARTS.index(document.get("start", "rest"))],
        )
        drawn = document.get("draws")
        draws = drawn and parse_draws(
            drawn["count"], drawn["perturb"], drawn["seed"], drawn.get("until")
        )
    except OSError as error:
        raise UserError(f"{path}: expected the plan of a sweep ({error.strerror})") from None
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise UserError(f"{path}: expected the plan of a sweep ({error!r})") from None
    current = f"bladewhirl {folder.version()} in format {SWEEP_FORMAT}"
    origin = f"bladewhirl {made_by} in format {document.get('format', 1)}"
    if origin != current:
        raise _outdated(path, current, f"it is of {origin}")
    case = loads(text, file=str(path))
    try:
        digest = plan_digest(case, over, options, draws, table)
    except OSError as error:  # raised for the mesh file
        raise UserError(f"{error.filename}: expected a readable file ({error.strerror})") from None
    if document.get("digest") != digest:
        raise _outdated(path, current, "it was changed")
    points = PointTable(values=table) if table else None
    case = folder.with_originals(case, directory)
    grid = make_grid(case, over, large=True, draws=draws, table=points)
    return plan_sweep(case, grid, options)


def _outdated(path: Path, current: str, reason: str) -> UserError:
    return UserError(
        f"{path}: expected a plan of {current}; {reason}, so new points would not agree with the"
        " points already marched"
    )


def _coordinates(case: Case, grid: Grid) -> Coordinates:
    coordinates = {}
    for axis in (*grid.axes, *grid.table):
        if axis.key in (DRAW, POINT):
            coordinates[axis.key] = axis.numbers, "1"
            continue
        each = grid.size // len(axis.values) if axis in grid.table else 0  # points in a row
        along = (
            with_values(case, {**grid.values(each * number), axis.key: value})
            for number, value in enumerate(axis.values)
        )
        values, unit = coordinate([value_at(each, path_of(axis.key)) for each in along])
        coordinates[axis.key] = (values, unit or unit_of(case, axis.key))
    for key, name in grid.drawn.items():
        _, unit = coordinate([value_at(case, path_of(key))])
        coordinates[name] = np.array(grid.nominal[key]), unit or unit_of(case, key)
    return coordinates


def _check_carry(case: Case, grid: Grid, coordinates: Coordinates, *, others: bool) -> None:
    """Check that motion can be carried from speed to speed.

    Args:
        case: case that is varied.
        grid: points of the sweep.
        coordinates: values of the swept keys.
        others: true if options are given that are not allowed together with this one.

    Raises:
        UserError: the motion cannot be carried; the message states the reason.
    """
    if SPEED not in grid.over:
        raise UserError(f"{CONTINUE}: needs --over {SPEED}=...; a --table is not enough")
    if others:
        raise UserError(
            f"{CONTINUE}: not allowed together with --screen, --until, --stop-when and --histories"
        )
    for number in (0, grid.size - 1):
        at_point = with_values(case, grid.values(number))
        with grid.naming(number):
            if fault := carry_fault(at_point):
                raise UserError(f"{CONTINUE}: expected {fault}")
            stage = stage_at(at_point)
            turns = abs(stage.speed) * stage.case.march.duration / (2.0 * np.pi)
            if not turns >= FEWEST_TURNS:
                raise UserError(
                    f"{CONTINUE}: expected marches of at least {FEWEST_TURNS:g} revolutions, not of"
                    f" {turns:.3g}"
                )


def _check_start(case: Case, grid: Grid, *, others: bool) -> None:
    """Check that marches can start on periodic motions; `others` is true if options are given that
    are not allowed together with this one.

    Raises:
        UserError: they cannot; the message states the reason.
    """
    if others:
        raise UserError(
            f"{START} periodic: not allowed together with --screen, {CONTINUE} and --histories"
        )
    for number in (0, grid.size - 1):
        with grid.naming(number):
            try:
                check_start(with_values(case, grid.values(number)))
            except UserError as reason:
                raise UserError(f"{START} periodic: {reason.lines[0]}") from None


def _check_stages(case: Case, grid: Grid, *, screen: bool) -> None:
    """Detect errors before a sweep: build the stages of some points, including the first and the
    last, and check that these points can be screened if `screen` is set.

    Raises:
        UserError: the first error, with its point.
    """

    def check(point: int) -> float:
        began = monotonic()
        with grid.naming(point):
            at_point = with_values(case, grid.values(point))
            problem = problem_of(stage_at(at_point))
            if screen:
                screened(problem, at_point.march.timing)
        count(CHECKING, finished=1, noun=CHECKED)
        return monotonic() - began

    last = grid.size - 1
    count(CHECKING, expected=1 + (last > 0), noun=CHECKED)
    check(0)
    if last == 0:
        return
    # The first point prepared what all share, so that the last one shows what the others cost.
    most = int(CHECK_TIME / check(last))
    if any(not axis.key.startswith(("march.", "contact.")) for axis in grid.axes):
        most = min(most, CHECKED_STAGES)
    chosen = np.unique(np.linspace(0, last, min(2 + most, grid.size)).round().astype(int))
    count(CHECKING, expected=len(chosen) - 2, noun=CHECKED)
    for point in chosen[1:-1]:
        check(int(point))
