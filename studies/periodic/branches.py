"""Branches of periodic motions over a key of the case, through folds: Dataset, rows, document."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.files import claim
from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.cone import in_wall_axes
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.periodic.branch import plot_branch
from bladewhirl.postprocess.periodic.dataset import (
    BRANCH_NAME,
    KIND_NAMES,
    TO_RESUME,
    open_branch,
    with_stability,
)
from bladewhirl.solvers.periodic import bifurcation
from bladewhirl.solvers.periodic.blade import Blade, Grid, alike, between, comparable
from bladewhirl.solvers.periodic.contact import Motion, NotConverged
from bladewhirl.solvers.periodic.continuation import Continuation, Point
from bladewhirl.solvers.periodic.search import prolonged
from bladewhirl.studies.joints import branches as joints
from bladewhirl.studies.joints.design import VALUES, design
from bladewhirl.studies.joints.design import report as report_design
from bladewhirl.studies.joints.motions import ALL_BLADES, applies
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.periodic import corotating_branches
from bladewhirl.studies.periodic.branch_file import (
    UNITS,
    BranchFile,
    Row,
    dataset,
    rows,
)
from bladewhirl.studies.periodic.motions import (
    HARMONICS,
    blade_of,
    check_periods,
    found_motion,
    nodes_of,
)
from bladewhirl.studies.periodic.origins import check_nodes, motion_of
from bladewhirl.studies.runs.columns import Column, rows_of, table
from bladewhirl.studies.runs.figures_folder import check_figure_folder
from bladewhirl.studies.runs.folder import CASE_NAME, case_files
from bladewhirl.studies.sweeps.axes import OVER, unit_of
from bladewhirl.studies.sweeps.parameter import Parameter

INSTANTS = 256  #: instants of the points of a branch
POINTS = 50  #: number of the longest steps from start to stop
MOST_POINTS = 2000  #: largest number of points of a branch
LONGEST = 0.1  #: longest step, relative to the forces
LINEAR = 1e-7  #: largest relative error of a blade between two others
SPLIT = (0.5, 0.3141)  #: places at which this error is computed
FAILED = ("lost", "stopped")  #: first words of the attribute `ended` of an incomplete branch
CLOSED = 12  #: number of points before a branch can return to its start

COLUMNS = (
    Column("kind", "bifurcation", variable="kind_name"),
    Column("parameter", "value", ".6g"),
    Column("speed_rad_s"),
    Column("speed_rpm", "[rpm]", ".1f"),
    Column("impulse_per_revolution", "impulse per revolution [N s]", ".5g"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("multipliers"),
    Column("stable"),
    Column("residual"),
)
"""Columns of the points of a branch; the bifurcations are printed."""


def parse_over(option: str) -> tuple[str, str, str]:
    """Return key, start and stop of "KEY=START:STOP".

    Raises:
        UserError: the text has another form.
    """
    key, _, values = (part.strip() for part in option.partition("="))
    ends = [part.strip() for part in values.split(":")]
    if not key or len(ends) != 2 or not all(ends):
        raise UserError(f"{OVER} {option}: expected KEY=START:STOP")
    return key, ends[0], ends[1]


class Family:
    """Blades of a case over a parameter.

    If all properties depend linearly on it, as on speed, clearance, friction or damping without
    effects of rotation, they are interpolated; otherwise each blade is built from its case.
    """

    def __init__(self, case: Case, parameter: Parameter, blade: int, periods: int) -> None:
        self._case, self._parameter = case, parameter
        self._blade, self._periods = blade, periods
        first, width = parameter.start, parameter.stop - parameter.start
        sampled = [self._stage(first + share * width) for share in (0.0, 1.0, *SPLIT)]
        self._samples = [contact_problem(stage) for stage in sampled]
        start, stop, *middle = (self._built(stage) for stage in sampled)
        self._ends = start, stop
        self._linear = comparable(start, stop) and all(
            comparable(start, each) and alike(each, between(start, stop, share), LINEAR)
            for each, share in zip(middle, SPLIT, strict=True)
        )
        self.grid = lru_cache(maxsize=8)(self._grid)
        self.problem = self._samples[0]
        if start.speed * stop.speed <= 0.0:
            raise UserError(f"{OVER} {parameter.key}: expected a range without the speed 0")

    def _stage(self, value: float) -> Stage:
        """Return the stage of the case at a value of the parameter."""
        return nodes_of(build_stage(self._parameter.case(self._case, value)), self._blade)

    def _built(self, stage: Stage) -> Blade:
        """Return the blade of a stage, with the period and the unknowns of the whole range."""
        return blade_of(stage, self._blade, self._periods, self._samples)

    def _grid(self, value: float, instants: int) -> Grid:
        one = self._parameter
        if not self._linear:
            inside = min(max(value, min(one.start, one.stop)), max(one.start, one.stop))
            try:
                return Grid(self._built(self._stage(value)), instants)
            except UserError:  # steps may leave the range to values that the case does not have
                if inside == value:
                    raise
                return self.grid(inside, instants)
        share = (value - one.start) / (one.stop - one.start)
        return Grid(between(*self._ends, share), instants)


def branch(
    case: Case,
    over: str,
    start: float | str,
    stop: float | str,
    *,
    blade: int = 0,
    points: int | None = None,
    speeds: Sequence[float | str] | None = None,
    instants: int = INSTANTS,
    periods: int = 1,
    origin: str | Path | None = None,
    directory: str | Path | None = None,
    overwrite: bool = False,
    progress: Callable[[float, int], None] | None = None,
) -> xr.Dataset:
    """Follow the periodic motion of a rubbing 3D blade over a key of the case, through folds.

    The branch begins at `start` with the motion that `bladewhirl.periodic` finds, or with one from
    a folder, and ends where the key leaves the range. Folds, period doublings and Neimark-Sacker
    bifurcations are points of their own; each was found again with twice as many instants.

    The branch of contact that is constant in rotating axes, see `bladewhirl.periodic`, is followed
    from its first state, or from the motion without contact. Between corners, where a tip joins or
    leaves those in contact, its points are exact; folds are corners. The Dataset has over `point`
    the variables of `bladewhirl.periodic`, with `parameter` and `kind`; nothing is written.

    Args:
        case: case as for `bladewhirl.periodic`.
        over: key of the case, such as "march.speed" or "casing.clearance".
        start: value at the start, as in a case file: a number, or text with a unit.
        stop: value at the other end of the range.
        blade: number of the blade.
        points: number of the longest steps from start to stop, by default 50; steps are shorter
            where forces change. With speeds, the number of values of the key, by default 12.
        speeds: of a case with [[joint]], speeds between which the largest amplitude is found at
            each value of the key, see below; None: the motion is followed at the speed of the case.
        instants: number of instants in a period of the motion, a power of two.
        periods: number of periods of the wall and the loads in a period of the motion; motions
            after a period doubling have two.
        origin: folder of a run, whose last period gives the first motion, or of a branch, whose
            last point does; for branches that no motion from rest leads to.
        directory: folder in which branch.nc is written point by point; `resume_branch` continues it
            after an interruption. None: nothing is written.
        overwrite: whether the folder may exist.
        progress: called with the share of the range and the number of points.

    Returns:
        over `point`: `parameter` in the unit of `start`, `speed_rad_s`, `impulse_per_revolution`
        [N s], `kind` (0, or the number of the bifurcation: 1 fold, 2 period doubling, 3
        Neimark-Sacker), `stable`, `residual`; `multiplier_real`, `multiplier_imaginary`, the
        largest first; over (point, instant, node): `normal_force` [N], `slip_direction` [rad],
        `contact_displacement` [m] in three directions; `amplitude` [m] of the harmonics. The
        attribute `ended` tells why the branch ends. With speeds, over `value` of the key:
        `peak_amplitude` [m] of the points, `peak_rpm`, `place` ("peak" or "end of the range"),
        `largest_multiplier` and `stable`; over (value, speed) `amplitude` [m], NaN where no motion
        was found; over (limit, speed) `linear_limit` [m]. Values near the smallest peak are added.

    Raises:
        CaseError: the case cannot be built at a value.
        UserError: the method does not apply, no first motion was found, there is no contact, or the
            folder cannot be used.
    """
    if instants < 64 or instants & (instants - 1):
        raise UserError(f"branch: instants {instants}: expected a power of two of at least 64")
    if points is not None and points < 1:
        raise UserError(f"branch: points {points}: expected at least 1")
    folder = None if directory is None else Path(directory)
    check_figure_folder(folder, overwrite=overwrite)
    parameter = Parameter.of(case, over, start, stop)
    if applies(case):
        if (blade, periods, origin, folder) != (0, 1, None, None):
            raise UserError(
                f"branch: {ALL_BLADES}: expected no blade, periods, origin and directory"
            )
        if speeds is not None and case.joint:
            return design(case, parameter, speeds, points or VALUES, progress)
        if speeds is None:
            return joints.branch(case, parameter, points or POINTS, progress)
    if speeds is not None:
        raise UserError("branch: speeds: expected none without [[joint]], or a sweep")
    points = points or POINTS
    if corotating_branches.applies(case, parameter):
        if (blade, periods, origin) != (0, 1, None):
            raise UserError("branch: constant contact: expected no blade, periods and origin")
        return corotating_branches.branch(case, parameter, points, progress)
    family = Family(case, parameter, blade, periods)
    grid = family.grid(parameter.start, instants)
    first = _first(grid, parameter, None if origin is None else Path(origin), blade)
    attributes = {
        "title": "branch of periodic motions of a rub",
        "case": case.title,
        "key": over,
        "unit": parameter.unit,
        UNITS: parameter.unit or unit_of(case, over),
        "start": parameter.start,
        "stop": parameter.stop,
        "blade": blade,
        "periods": periods,
        "points": points,
    }
    files = case_files(case)

    def made() -> Path:
        """Return the folder, which is made with the first contact."""
        assert folder is not None
        with writing(folder):
            claim(folder, [BRANCH_NAME, *files], overwrite=overwrite)
            for name, content in files.items():
                (folder / name).write_bytes(content)
        return folder

    tracing = _Tracing(family, parameter, attributes, points, instants)
    return tracing.run(None if folder is None else made, [], first, progress)


def resume_branch(
    directory: str | Path, *, progress: Callable[[float, int], None] | None = None
) -> xr.Dataset:
    """Continue a branch that was interrupted, from its last point.

    Args:
        directory: folder of `branch`.
        progress: see `branch`.

    Returns:
        the Dataset of `branch`.

    Raises:
        UserError: the folder has no branch, or one of an earlier version or of another case, or
            cannot be written.
    """
    folder = Path(directory)
    try:
        data = open_branch(folder)
    except UserError as reason:
        raise UserError(
            f"{reason}; branches with [[joint]] or of constant contact are not kept point by point:"
            " compute them again"
        ) from None
    if "ended" in data.attrs:
        return _derived(data)
    case, known = read_case(folder / CASE_NAME), data.attrs
    regular = np.flatnonzero(data["kind"].values == 0)
    if not {*TO_RESUME} <= data.data_vars.keys() or UNITS not in known or not len(regular):
        raise UserError(f"{folder / BRANCH_NAME}: expected a branch of this version to resume")
    start, stop = (f"{float(known[name])!r} {known['unit']}".strip() for name in ("start", "stop"))
    try:
        parameter = Parameter.of(case, known["key"], start, stop)
    except UserError as reason:
        raise UserError(f"{folder}: {reason}") from None
    family = Family(case, parameter, int(known["blade"]), int(known.get("periods", 1)))
    check_nodes(data, family.grid(parameter.start, data.sizes["instant"]).blade, str(folder))
    tracing = _Tracing(family, parameter, dict(known), int(known["points"]), data.sizes["instant"])
    found = rows(data)[: regular[-1] + 1]  # bifurcations are found again with the next point
    return tracing.run(lambda: folder, found, None, progress)


def _first(grid: Grid, parameter: Parameter, origin: Path | None, number: int) -> Motion:
    """Return the motion at the start of a branch of a blade with a number.

    Raises:
        UserError: no motion was found.
    """
    where = parameter.text(parameter.start)
    blade = grid.blade
    guess = found_motion(blade, where) if origin is None else motion_of(origin, blade, number)
    try:
        motion = prolonged(guess.on(grid))
    except NotConverged as reason:
        raise UserError(f"branch: no motion was found at {where}: {reason}") from None
    check_periods(motion, where)
    return motion


class _Tracing:
    """A branch that is followed and recorded."""

    def __init__(
        self,
        family: Family,
        parameter: Parameter,
        attributes: Mapping[str, Any],
        points: int,
        instants: int,
    ) -> None:
        self._family, self._parameter, self._attributes = family, parameter, attributes
        self._instants = instants
        self._branch = Continuation(
            lambda value, count: (family.grid(value, count), 0.0),
            abs(parameter.width) / (points * LONGEST),
        )
        self._rows: list[Row] = []
        self._sink: BranchFile | None = None
        self._opened: Callable[[], BranchFile | None] = lambda: None

    def run(
        self,
        made: Callable[[], Path] | None,
        known: list[Row],
        first: Motion | None,
        progress: Callable[[float, int], None] | None,
    ) -> xr.Dataset:
        """Follow the branch from its first motion, or after known points, and return it; `made`
        returns the folder of its file."""
        blade, parameter = (
            self._family.grid(self._parameter.start, self._instants).blade,
            self._parameter,
        )
        coordinates = {
            "instant": np.arange(self._instants) / self._instants,
            "node": np.arange(float(blade.nodes)),
            "direction": ["radial", "tangential", "axial"],
            "order": blade.first_order * np.arange(float(HARMONICS)),
            "multiplier": np.arange(2.0 * len(blade.stiffness)),
        }
        with ExitStack() as stack:

            def opened() -> BranchFile | None:
                """Return the file of the branch, with the points so far."""
                if made is None:
                    return None
                place = made() / BRANCH_NAME
                axes = None if known else coordinates
                sink = stack.enter_context(BranchFile(place, axes, self._attributes, len(known)))
                for row in self._rows[len(known) :]:
                    sink.add(row)
                return sink

            self._opened, self._rows = opened, list(known)
            try:
                if first is not None:
                    sign = float(np.sign(parameter.stop - parameter.start))
                    begin = start = self._branch.begin(first, parameter.start, sign)
                    self._add(begin, bifurcation.multipliers(begin))
                else:
                    start, begin = self._point(known[0]), self._point(known[-1])
                ended = self._follow(start, begin, progress)
            except NotConverged as reason:
                ended = f"lost: {reason}"
            self._drop_pairs()
            if self._sink is not None:
                self._sink.note(ended=ended)
            if progress is not None:
                progress(1.0, len(self._rows))
        return _derived(dataset(self._rows, coordinates, {**self._attributes, "ended": ended}))

    def _follow(
        self, start: Point, begin: Point, progress: Callable[[float, int], None] | None
    ) -> str:
        """Add the points after one to a branch with a start, and return why the branch ends.

        Raises:
            NotConverged: the branch was lost.
        """
        one, limit = self._parameter, self._family.problem.displacement_limit
        low, high = sorted((one.start, one.stop))
        before, values = begin, bifurcation.multipliers(begin)
        for point in self._branch.follow(begin, LONGEST, begin.ahead or LONGEST):
            edge = min(max(point.parameter, low), high)
            left = edge != point.parameter
            if left:
                point = self._branch.landed(before, point, edge)
            after = bifurcation.multipliers(point)
            kinds = bifurcation.changed(before, point, values, after)
            for each in bifurcation.found(self._branch, before, point, kinds):
                self._add(each.point, bifurcation.multipliers(each.point), each)
            self._add(point, after)
            if left:
                return f"reaches {one.text(edge)}"
            largest = np.abs(point.motion.displacement).max()
            if largest > limit:
                return (
                    f"stopped: at {one.text(point.parameter)} contact nodes move by"
                    f" {largest:.4g} m, beyond march.displacement_limit = {limit:.4g} m"
                )
            if self._returned(start, before, point):
                return "closed: returns to its start"
            if len(self._rows) >= MOST_POINTS:
                return f"stopped: after {MOST_POINTS} points"
            if progress is not None:
                progress((point.parameter - one.start) / one.width, len(self._rows))
            before, values = point, after
        raise AssertionError

    def _returned(self, start: Point, before: Point, point: Point) -> bool:
        """Return whether a branch passes its first point again."""
        step = self._branch.distance(before, point)
        return len(self._rows) > CLOSED and self._branch.distance(start, point) < 0.6 * step

    def _add(
        self, point: Point, values: ComplexArray, special: bifurcation.Bifurcation | None = None
    ) -> None:
        """Record a point; those of bifurcations have more instants, of which some are recorded."""
        motion = point.motion
        every = len(motion.normal) // self._instants
        moved = in_wall_axes(motion.displacement.T, -self._family.problem.slope).T
        moved = moved.reshape(len(motion.normal), -1, 3)
        spectrum = np.abs(np.fft.rfft(moved, axis=0))[:HARMONICS] / len(moved)
        spectrum[1:] *= 2.0
        row = {
            "parameter": point.parameter,
            "speed_rad_s": motion.grid.blade.speed,
            "impulse_per_revolution": motion.impulse,
            "residual": motion.residual,
            "kind": 0 if special is None else 1 + bifurcation.KINDS.index(special.kind),
            "shift": 0.0 if special is None else special.shift,
            "heading": point.heading,
            "multiplier_real": values.real,
            "multiplier_imaginary": values.imag,
            "normal_force": motion.normal[::every],
            "slip_direction": motion.angle[::every],
            "contact_displacement": moved[::every],
            "amplitude": spectrum,
            "tangent_force": point.normal[::every],
            "tangent_direction": point.angle[::every],
            "next_step": point.ahead,
        }
        self._rows.append(row)
        if self._sink is not None:
            self._sink.add(row)
        elif motion.touches:
            self._sink = self._opened()

    def _point(self, row: Row) -> Point:
        """Return a regular point that was recorded."""
        value = float(row["parameter"])
        grid = self._family.grid(value, self._instants)
        return Point(
            Motion(grid, row["normal_force"], row["slip_direction"]),
            value,
            row["tangent_force"],
            row["tangent_direction"],
            float(row["heading"]),
            ahead=float(row["next_step"]),
        )

    def _drop_pairs(self) -> None:
        """Leave out pairs of folds that are closer to each other than to those on other grids, and
        folds at which the branch turns in the direction in which it goes, as far as the other
        folds are known: the one before was not confirmed."""
        heading, first = 0.0, float(self._rows[0]["heading"])
        kept, left_out = list[int](), list[int]()
        for n, row in enumerate(self._rows):
            if row["kind"] != 1:
                heading = heading if row["kind"] else float(row["heading"])
            elif (heading * first > 0.0) != (len(kept) % 2 == 0):
                left_out.append(n)
            elif kept and self._close(kept[-1], n):
                left_out += [kept.pop(), n]
            else:
                kept.append(n)
        for n in left_out:
            self._rows[n] = {**self._rows[n], "kind": 0}
            if self._sink is not None:
                self._sink.correct("kind", n, 0.0)

    def _close(self, one: int, other: int) -> bool:
        """Return whether two bifurcations are as close as each to that on the other grid."""
        first, second = self._rows[one], self._rows[other]
        apart = abs(first["parameter"] - second["parameter"])
        return bool(apart <= first["shift"] + second["shift"])


def _derived(data: xr.Dataset) -> xr.Dataset:
    """Return the Dataset of a branch with what follows from its variables.

    Raises:
        UserError: there is no contact on the branch.
    """
    if not data["impulse_per_revolution"].any():
        where = f"from {data.attrs['start']:g} to {data.attrs['stop']:g} {data.attrs['unit']}"
        raise UserError(f"branch: {data.attrs['key']} {where}: no contact".replace(" :", ":"))
    return with_stability(data)


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of a branch."""
    if "limit" in data.dims and "value" in data.dims:
        return report_design(data)
    if "joint" in data.dims:
        return joints.report(data)
    if "growth_rate" in data:
        return corotating_branches.report(data)
    real, imaginary = (data[f"multiplier_{part}"].values for part in ("real", "imaginary"))
    found = rows_of(
        data.assign(
            kind_name=("point", [KIND_NAMES[kind] for kind in data["kind"].values.tolist()]),
            speed_rpm=data["speed_rad_s"] * 30.0 / np.pi,
            largest_multiplier=("point", np.hypot(real, imaginary).max(axis=1)),
            multipliers=(("point", "multiplier", "part"), np.stack([real, imaginary], axis=-1)),
        ),
        COLUMNS,
    )
    special = [each for each in found if each["kind"] != "none"]
    ends = [{**found[n], "kind": name} for n, name in ((0, "(start)"), (-1, "(end)"))]
    names = ("key", "unit", "ended")
    return Study(
        name="periodic",
        document={**{name: data.attrs[name] for name in names}, "points": found},
        tables=[table([ends[0], *special, ends[1]], COLUMNS, "Branch of periodic motions")],
        figures=lambda: {"branch": (plot_branch(data), data)},
    )
