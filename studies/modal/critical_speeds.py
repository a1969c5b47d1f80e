"""Map of critical speeds against the stiffness of the shaft: Dataset, JSON document, figure."""

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.rotation.critical_speeds import ELLIPTIC_ORDERS, orders_of
from bladewhirl.models.stage.modal import Modelled, modal_model
from bladewhirl.models.structure.waves import Waves
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.modal.veering import spring_stiffnesses
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

AT_THE_CASE = (
    Column("direction", "whirl"),
    Column("branch", "branch", "d"),
    Column("rpm", "[rpm]", ".1f"),
    Column("spring_share", "springs", ".1%"),
)
"""Columns of the critical speeds at the shaft stiffness of the case."""


def critical_speeds(
    case_or_stage: Modelled,
    *,
    stiffnesses: FloatArray | None = None,
    branches: int = 2,
) -> xr.Dataset:
    """Compute the critical speeds of the bladed disk for many stiffnesses of the shaft.

    At a critical speed the shaft whirls at the speed of rotation: forward, as an imbalance drives
    it, or backward; on unequal stationary bearings it whirls in an ellipse, which an imbalance
    drives in any case. The speeds follow directly from an eigenproblem at each stiffness, without a
    search along the speed, and include all rotation effects. The casing is not included.

    Over `stiffness` of each shaft spring [N/m], `direction` and `branch`: critical_speed [rpm],
    ascending along a branch, and spring_share, the share of the strain energy in the shaft springs;
    nan where a branch has no critical speed. `bladewhirl.plot.critical_speeds` draws the map::

        speeds = bladewhirl.critical_speeds(case)
        speeds.critical_speed.sel(direction="forward", branch=1, stiffness=3e7, method="nearest")

    Args:
        case_or_stage: a case with rotation.effects = "full", or its stage.
        stiffnesses: stiffnesses of each shaft spring [N/m], ascending, (stiffness,); by default
            from a thousandth to a thousand times that of the case. With shaft.stiffness_y they are
            stiffnesses along x, and both springs are scaled alike.
        branches: number of branches in each direction, from the lowest; twice as many elliptic
            ones.

    Raises:
        UserError: the case has no Coriolis forces, the sectors of the bladed disk differ, or a
            stiffness is not positive.
    """
    stage = modal_model(case_or_stage)
    nominal, at = stage.shaft_waves, stage.case.shaft.stiffness
    orders = orders_of(nominal)
    count = 2 * branches if orders is ELLIPTIC_ORDERS else branches
    springs = spring_stiffnesses(stage.case, None, stiffnesses)

    def found(waves: Waves) -> tuple[FloatArray, FloatArray]:
        speed, share = np.full((2, len(springs), len(orders), count), np.nan)
        for i, ratio in enumerate(springs / at):
            for j, order in enumerate(orders.values()):
                omegas, shares = (a[:count] for a in waves.on_springs(ratio).synchronous(order))
                speed[i, j, : len(omegas)] = omegas * 30.0 / np.pi
                share[i, j, : len(shares)] = shares
        return speed, share

    speed, share = found(nominal)
    covering = stage.covering(np.nanmax(speed, initial=0.0) * np.pi / 30.0)
    if covering is not stage:  # its modes describe the structure at these speeds
        speed, share = found(covering.shaft_waves)
    over = ("stiffness", "direction", "branch")
    name = "share of the strain energy in the shaft springs"
    return xr.Dataset(
        {
            "critical_speed": quantity(over, speed, "rpm", "critical speed"),
            "spring_share": quantity(over, share, "1", name),
        },
        coords={
            "stiffness": quantity("stiffness", springs, "N/m", "stiffness of each shaft spring"),
            "direction": ("direction", list(orders)),
            "branch": ("branch", np.arange(1, count + 1)),
        },
        attrs={
            "title": "critical speeds against shaft stiffness",
            "case": stage.case.title,
            "case_stiffness": at,
            "case_speed": stage.speed * 30.0 / np.pi,
        },
    )


def report(stage: ModalModel, branches: int, interval: FloatArray | None = None) -> Study:
    """Return the critical speeds at the shaft stiffness of the case as document and table, forward
    first, and the map over an interval of stiffnesses, see `spring_stiffnesses`, as figure."""
    at, springs = stage.case.shaft.stiffness, stage.case.shaft.springs
    speeds = critical_speeds(stage, stiffnesses=np.array([at]), branches=branches)
    stacked = speeds.isel(stiffness=0).stack(row=("direction", "branch")).reset_index("row")
    rows = rows_of(stacked.rename(critical_speed="rpm"), AT_THE_CASE)
    rows = [row for row in rows if row["rpm"] is not None]

    def figures() -> Figures:
        from bladewhirl.postprocess.modal.veering import plot_critical_speeds

        over = spring_stiffnesses(stage.case, interval)
        data = critical_speeds(stage, stiffnesses=over, branches=branches)
        return {"critical-speeds": (plot_critical_speeds(data), data)}

    each = " and ".join(dict.fromkeys(f"{spring:.4g}" for spring in springs))
    tables = [table(rows, AT_THE_CASE, f"Critical speeds with shaft springs of {each} N/m")]
    document = {"stiffness": at, "critical_speeds": rows}
    return Study(name="critical-speeds", document=document, tables=tables, figures=figures)
