"""Branches of contact that is constant in rotating axes over a key: Dataset, rows, document."""

from collections.abc import Callable

import numpy as np
import xarray as xr

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.periodic.branch import plot_branch
from bladewhirl.postprocess.periodic.dataset import KIND_NAMES
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.contact_branch import ContactBranch, Point
from bladewhirl.solvers.periodic.corotating import Equations, contact_states
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.periodic import corotating
from bladewhirl.studies.runs.columns import Column, rows_of, table
from bladewhirl.studies.sweeps.parameter import Parameter
from bladewhirl.studies.sweeps.stages import stage_at

MOST = 2000  #: largest number of points
COLUMNS = (Column("kind", "bifurcation", variable="kind_name"), Column("parameter", "value", ".6g"))
"""Columns of the points of a branch besides those of constant contact."""


def applies(case: Case, parameter: Parameter) -> bool:
    """Return whether contact is constant in rotating axes at the start of a range."""
    return corotating.is_corotating(_problem(case, parameter, parameter.start)[1])


def branch(
    case: Case,
    parameter: Parameter,
    points: int,
    progress: Callable[[float, int], None] | None = None,
) -> xr.Dataset:
    """Follow the constant contact of a case over a key; see `bladewhirl.branch`.

    Raises:
        CaseError: the case cannot be built at a value.
        UserError: no solution was found at the start, or there is no contact in the range.
    """
    stage, _ = _problem(case, parameter, parameter.start)

    def equations(value: float) -> Equations:
        try:
            return Equations(_problem(case, parameter, value)[1])
        except ValueError as reason:
            raise UserError(f"branch: {parameter.text(value)}: {reason}") from None

    followed = ContactBranch(equations, parameter.start, parameter.stop, points)
    found, ended = list[Point](), f"has {MOST} points"
    try:
        first = contact_states(followed.at(parameter.start).problem)[0]
        for point in followed.follow(first):
            moved = float(np.abs(point.contact.tip).max())
            if moved > point.equations.problem.displacement_limit:
                ended = f"stopped: contact nodes move by {moved:.4g} m (march.displacement_limit)"
                break
            found.append(point)
            if progress is not None:
                share = abs(point.parameter - parameter.start) / abs(parameter.width)
                progress(share, len(found))
            if len(found) == MOST:
                break
        else:
            ended = f"reaches {parameter.text(found[-1].parameter)}"
    except NotConverged as reason:
        ended = f"lost: {reason}"
    if not found:
        where = parameter.text(parameter.start)
        raise UserError(f"branch: no motion was found at {where}: {ended}")
    if not any(point.contact.normal.any() for point in found):
        ends = f"from {parameter.start:g} to {parameter.text(parameter.stop).rpartition('= ')[2]}"
        raise UserError(f"branch: {parameter.key} {ends}: no contact")
    states = [corotating.State(point.equations.problem, point.contact) for point in found]
    data = corotating.dataset(stage, states).swap_dims(speed="point")
    multipliers = data["multipliers"].values
    return data.assign(
        parameter=("point", [point.parameter for point in found]),
        kind=("point", [point.kind for point in found]),
        speed_rad_s=data["rpm"] * np.pi / 30.0,
        multiplier_real=(("point", "multiplier"), multipliers.real),
        multiplier_imaginary=(("point", "multiplier"), multipliers.imag),
    ).assign_attrs(key=parameter.key, unit=parameter.unit, ended=ended)


def _problem(case: Case, parameter: Parameter, value: float) -> tuple[Stage, ContactProblem]:
    """Return stage and contact problem at a value of the key."""
    stage = stage_at(corotating.without_steps(parameter.case(case, value)))
    return stage, contact_problem(stage, steps=False)


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of a branch."""
    names = [KIND_NAMES[kind] for kind in data["kind"].values.tolist()]
    columns = (*COLUMNS, *corotating.columns_of(data))
    rows = rows_of(corotating.shown(data).assign(kind_name=("point", names)), columns)
    special = [row for row in rows if row["kind"] != "none"]
    ends = [{**rows[n], "kind": name} for n, name in ((0, "(start)"), (-1, "(end)"))]
    return Study(
        name="periodic",
        document={
            **{name: data.attrs[name] for name in ("key", "unit", "ended")},
            "folds": [row["parameter"] for row in rows if row["kind"] == "fold"],
            "points": rows,
        },
        tables=[table([ends[0], *special, ends[1]], columns, "Branch of constant contact")],
        figures=lambda: {"branch": (plot_branch(data), data)},
    )
