"""Branches of periodic motions of all blades of a wheel over a key of the case: Dataset, rows."""

from collections.abc import Callable
from dataclasses import fields, replace
from functools import lru_cache
from typing import Any, cast

import numpy as np
import xarray as xr

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.postprocess.joints.motions import plot_joint_branch
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joint_search import branch as followed
from bladewhirl.solvers.periodic.joint_search import joint_motion
from bladewhirl.solvers.periodic.joints import JointGrid, JointMotion, common_order
from bladewhirl.studies.joints.dataset import dataset
from bladewhirl.studies.joints.motions import beyond, check, reaches, rubbing_wheel
from bladewhirl.studies.joints.rows import hints, rows_of, shown_columns
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, table
from bladewhirl.studies.sweeps.parameter import Parameter

HARMONICS = 32  #: highest harmonic of the forces along a branch, for each engine order
MOST = 400  #: largest number of points
REACHED = "stopped: the tips reach the wall"  #: the end of a branch without a wall
LINEAR = 1e-9  #: largest relative error of a wheel between two others
SPLIT = (0.5, 0.3141)  #: places at which this error is computed
MIXED = (
    *("friction", "gap", "speed", "stiffness", "damping", "contact", "loads", "static"),
    *("wall", "radius"),
)
"""Properties of a wheel that are interpolated."""


def branch(
    case: Case,
    parameter: Parameter,
    points: int,
    progress: Callable[[float, int], None] | None = None,
) -> xr.Dataset:
    """Follow the periodic motion of a tuned wheel with joints over a key; see `bladewhirl.branch`.
    If its tips reach the wall, the whole branch is followed with it.

    Raises:
        CaseError: the case cannot be built at a value.
        UserError: the method does not apply, or no first motion was found.
    """
    stage = build_stage(parameter.case(case, parameter.start))
    problem = contact_problem(stage, steps=False)
    check(stage, problem)
    loads = [each for each in case.excitations.values() if isinstance(each, EngineOrder)]
    without = bool(case.joint) and any(each.order for each in loads)
    for wall in (False, True) if without else (True,):
        points_of = _Followed(problem, wall, progress)
        points_of.follow(_family(case, parameter, wall), parameter, points)
        if points_of.ended != REACHED:
            break
    motions = points_of.motions
    if not motions:
        where = parameter.text(parameter.start)
        raise UserError(f"branch: no motion was found at {where}: {points_of.ended}")
    values = parameter.start + np.array(points_of.shares) * parameter.width
    return (
        dataset(case, motions, stage.reference_frequency)
        .swap_dims(speed="place")
        .assign_coords(parameter=("place", values), heading=("place", points_of.headings))
        .assign_attrs(key=parameter.key, unit=parameter.unit, ended=points_of.ended)
    )


class _Followed:
    """Points of a branch that is followed."""

    def __init__(
        self, problem: ContactProblem, wall: bool, progress: Callable[[float, int], None] | None
    ) -> None:
        self._problem, self._wall, self._progress = problem, wall, progress
        self.shares, self.motions, self.headings = list[float](), list[JointMotion](), list[float]()
        self.ended = f"has {MOST} points"

    def follow(
        self, grid_at: Callable[[float], JointGrid], parameter: Parameter, points: int
    ) -> None:
        """Follow the branch until it leaves the range, is lost, or reaches a wall that it does not
        have."""
        try:
            start = joint_motion(grid_at(0.0).wheel)
            for share, motion, heading in followed(start.on(grid_at(0.0)), grid_at, points):
                if reason := self._obstacle(motion):
                    self.ended = reason
                    return
                self.shares.append(share)
                self.motions.append(motion)
                self.headings.append(heading)
                if self._progress is not None:
                    self._progress(share, len(self.motions))
                if len(self.motions) == MOST:
                    return
            self.ended = f"reaches {parameter.text(parameter.start + share * parameter.width)}"
        except NotConverged as reason:
            self.ended = f"lost: {reason}"

    def _obstacle(self, motion: JointMotion) -> str:
        """Return why a motion ends the branch; empty if it does not."""
        if reason := beyond(self._problem, motion):
            return f"stopped: {reason}"
        return REACHED if not self._wall and reaches(self._problem, motion) else ""


def _family(case: Case, parameter: Parameter, wall: bool) -> Callable[[float], JointGrid]:
    """Return the wheel at a share of the range, with a wall or without, interpolated if it is
    linear in the parameter."""

    def at_value(share: float) -> JointedWheel:
        value = parameter.start + min(max(share, 0.0), 1.0) * parameter.width
        stage = cast(Matrices, build_stage(parameter.case(case, value)))
        if not wall:
            return jointed_wheel(stage)
        return rubbing_wheel(stage, contact_problem(stage, steps=False))

    one, other = at_value(0.0), at_value(1.0)
    none = {n: 0.0 * gap for each in (one, other) for n, gap in each.wall.items()}

    def built(share: float) -> JointedWheel:
        """Return a wheel with the period of the whole range, although lobes of some are zero."""
        wheel = at_value(share)
        return replace(wheel, wall=none | dict(wheel.wall))

    one, other = (replace(each, wall=none | dict(each.wall)) for each in (one, other))
    linear = all(_apart(_between(one, other, share), built(share)) <= LINEAR for share in SPLIT)
    unit = max(max(each.main_orders) for each in (one, other))
    highest = HARMONICS * unit // common_order(one)

    @lru_cache(maxsize=4)
    def at(share: float) -> JointGrid:
        return JointGrid(_between(one, other, share) if linear else built(share), highest)

    return at


def _numbers(wheel: JointedWheel, name: str) -> dict[Any, Any]:
    """Return a property as numbers by key."""
    value = getattr(wheel, name)
    return value if isinstance(value, dict) else {None: value}


def _between(one: JointedWheel, other: JointedWheel, share: float) -> JointedWheel:
    """Return a wheel between two others, whose numbers are those of both in proportion."""
    mixed = {}
    for name in MIXED:
        first, last = _numbers(one, name), _numbers(other, name)
        each = {key: first[key] + share * (last[key] - first[key]) for key in first}
        mixed[name] = each.get(None, each)
    return replace(one, **mixed)


def _apart(one: JointedWheel, other: JointedWheel) -> float:
    """Return the largest relative difference of the numbers of two wheels."""
    apart = 0.0
    for field in fields(one):
        first, last = _numbers(one, field.name), _numbers(other, field.name)
        for key in first:
            x, y = np.asarray(first[key]), np.asarray(last[key])
            if x.dtype.kind in "fc" and x.size and y.any():
                apart = max(apart, float(np.abs(x - y).max() / np.abs(y).max()))
    return apart


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of a branch."""
    rows, heading = rows_of(data, "place"), data["heading"].values
    for row, value in zip(rows, data["parameter"].values.tolist(), strict=True):
        row["parameter"] = value
    folds = [rows[n]["parameter"] for n in range(1, len(rows)) if heading[n] != heading[n - 1]]
    least = min(rows, key=lambda row: row["amplitude"] or 0.0)
    shown = [rows[n] for n in sorted({0, rows.index(least), len(rows) - 1})]
    columns = (Column("parameter", data.attrs["key"], ".6g"), *shown_columns(data))
    return Study(
        name="periodic",
        document={
            **{name: data.attrs[name] for name in ("key", "unit", "ended")},
            "smallest_amplitude": {key: least[key] for key in ("parameter", "amplitude")},
            "folds": folds,
            "points": rows,
        },
        tables=[table(shown, columns, "Branch: start, smallest amplitude, end")],
        figures=lambda: {"branch": (plot_joint_branch(data), data)},
        hints=hints([row | {"change": 0.0} for row in rows]),
    )
