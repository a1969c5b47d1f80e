"""Stability of a shaft line over the speed: Dataset, JSON document, tables, figure."""

from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.shaft_line.growth import Growth, borders, growth
from bladewhirl.models.shaft_line.line import line_model
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

RPM = 30.0 / np.pi
SIDE = 1e-6  #: relative distance from a border at which its kind is found

COLUMNS = (
    Column("rpm", "speed [rpm]", ".2f"),
    Column("speed_rad_s", "[rad/s]", ".4f"),
    Column("growth", "growth"),
    Column("growth_rate", "largest growth rate [1/s]", ".5g"),
    Column("frequency_hz", "[Hz]", ".5f", variable="frequency"),
    Column("direction", "whirl"),
)
"""Columns of the fastest growing motion at a speed."""

BORDERS = tuple(column for column in COLUMNS if column.key != "growth_rate")
"""Columns of a speed at which growth begins or ends."""


def line_stability(case: Case, *, speeds: FloatArray) -> xr.Dataset:
    """Compute the growth rate of the shaft line of a case at many speeds.

    Over `speed` [rpm] and, at the speed of the case, over `point`: growth_rate, the largest real
    part of an eigenvalue [1/s], negative if all motions decay, with the frequency [Hz] and the
    direction of this motion. Over `border`: the speeds at which growth begins or ends, with
    frequency and direction of the motion. A range of growth between two of the speeds is not found.

    Args:
        case: a case with [shaft_line].
        speeds: ascending speeds of rotation [rad/s], (speeds,).

    Raises:
        CaseError: the bearings do not hold the line, or the wheel has no hub.
    """
    line = line_model(case, float(np.abs(speeds).max(initial=0.0)))
    found = [growth(line, float(omega)) for omega in speeds]
    ends, own = borders(line, found), growth(line, line.speed)
    beyond = [growth(line, (1.0 + SIDE) * each.speed).grows for each in ends]
    kind = np.array(["begins" if grows else "ends" for grows in beyond], dtype=object)
    return xr.Dataset(
        {
            **_motions("speed", found),
            **_motions("border", ends),
            "border_growth": ("border", kind),
            **_motions("point", [own]),
            "point_growth": ("point", ["unstable" if own.grows else "stable"]),
        },
        coords={"speed": quantity("speed", speeds * RPM, "rpm", "speed of rotation")},
        attrs={"title": case.title},
    )


def _motions(over: str, found: list[Growth]) -> dict[str, Any]:
    """Return speed, growth rate, frequency and direction of motions as variables."""
    prefix = "" if over == "speed" else f"{over}_"
    rate = np.array([each.eigenvalue for each in found], dtype=np.complex128)
    speed = np.array([each.speed for each in found])
    names = np.array([each.direction for each in found], dtype=object)
    variables = {
        "growth_rate": quantity(over, rate.real, "1/s", "largest growth rate"),
        "frequency": quantity(over, rate.imag / (2.0 * np.pi), "Hz", "frequency of the motion"),
        "direction": (over, names),
        "speed_rad_s": quantity(over, speed, "rad/s", "speed of rotation"),
        "rpm": quantity(over, speed * RPM, "rpm", "speed of rotation"),
    }
    return {f"{prefix}{name}": value for name, value in variables.items()}


def report(computed: xr.Dataset) -> Study:
    """Return the document, the tables and the figure of `line_stability`."""
    [own] = rows_of(computed, COLUMNS, "point_")
    rows = rows_of(computed, BORDERS, "border_")
    names = ("rpm", "growth_rate", "frequency", "direction")
    of_speeds = {name: computed[name].values.tolist() for name in names}
    first, last = computed["speed"].values[[0, -1]]

    def figures() -> Figures:
        from bladewhirl.postprocess.shaft_line.stability import plot_line_stability

        return {"stability": (plot_line_stability(computed), computed)}

    between = f"between {first:.6g} and {last:.6g} rpm"
    listed: list[Any] = [table([own], COLUMNS, "Fastest growing motion at the speed of the case")]
    if rows:
        listed.append(table(rows, BORDERS, f"Speeds at which growth begins or ends {between}"))
    else:
        listed.append(f"Growth neither begins nor ends {between}.")
    return Study(
        name="stability",
        document={"point": own, "shaft_line": rows, **of_speeds},
        tables=listed,
        figures=figures,
    )
