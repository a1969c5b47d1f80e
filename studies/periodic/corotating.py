"""Contact that is constant in rotating axes, without time integration: Dataset, rows, figure."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.corotating import (
    CorotatingContact,
    corotating_contact,
    obstacles,
)
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

COLUMNS = (
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("speed_rad_s"),
    Column("speed_rpm", "[rpm]", ".1f", variable="rpm"),
    Column("impulse_per_revolution", "impulse per revolution [N s]", ".5g"),
    Column("largest_force", "largest normal force [N]", ".5g"),
    Column("tips", "tips in contact", "d"),
    Column("normal_force"),
    Column("radius", "radius of the shaft [mm]", ".5f", 1e3),
    Column("growth_rate", "growth rate [1/s]", ".4g"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("multipliers", variable="pairs"),
    Column("stable", "stable"),
    Column("residual"),
)
"""Columns of the solutions."""


def is_corotating(problem: ContactProblem) -> bool:
    """Return whether loads press the bladed disk into the wall constantly in rotating axes."""
    return bool(problem.loads) and not any(obstacles(problem))


def solution(problem: ContactProblem, speed: str) -> CorotatingContact:
    """Return the constant contact at a speed, whose text is in messages.

    Raises:
        UserError: there is no contact, or no solution was found.
    """
    try:
        found = corotating_contact(problem)
    except NotConverged as reason:
        raise UserError(f"periodic: no constant contact was found at {speed}: {reason}") from None
    if not found.normal.any():
        raise UserError(
            f"periodic: no contact at {speed}: the smallest gap is {1e3 * found.gap.min():.4g} mm"
        )
    return found


def dataset(
    case: Case,
    found: Sequence[tuple[ContactProblem, CorotatingContact]],
    reference: float,
) -> xr.Dataset:
    """Return the Dataset of solutions at speeds, for a reference frequency [rad/s]."""
    speeds = np.array([problem.speed for problem, _ in found])
    normal = np.stack([each.normal for _, each in found])
    gap = np.stack([each.gap for _, each in found])
    centre = np.stack([each.centre for _, each in found])
    period = 2.0 * np.pi / np.abs(speeds)
    common = min(len(each.rates) for _, each in found)
    rates = np.stack([each.rates[:common] for _, each in found])
    return xr.Dataset(
        {
            "impulse_per_revolution": quantity(
                "speed", normal.sum(axis=1) * period, "N s", "normal impulse per revolution"
            ),
            "normal_force": quantity(("speed", "tip"), normal, "N", "normal force"),
            "gap": quantity(("speed", "tip"), gap, "m", "gap"),
            "centre": quantity(("speed", "axis"), centre, "m", "displacement of the centre"),
            "growth_rate": quantity("speed", rates[:, 0].real, "1/s", "growth rate of deviations"),
            "period": quantity("speed", period, "s"),
            "multipliers": (("speed", "multiplier"), np.exp(rates * period[:, None])),
            "stable": ("speed", [each.stable for _, each in found]),
        },
        coords={
            "speed": quantity("speed", speeds / reference, "1", "normalised speed"),
            "rpm": quantity("speed", speeds * 30.0 / np.pi, "rpm", "speed"),
            "axis": ["x", "y"],
        },
        attrs={
            "title": "contact constant in rotating axes",
            "case": case.title,
            "reference_frequency_hz": reference / (2.0 * np.pi),
        },
    )


@styled
def plot_corotating(data: xr.Dataset) -> Figure:
    """Draw the normal force on each tip at each speed."""
    figure = new_figure(height=0.06)
    axes = figure.subplots()
    for n in range(data.sizes["speed"]):
        one = data.isel(speed=n)
        axes.plot(one["normal_force"].values, ".-", label=f"{float(one['rpm']):.6g} rpm")
    axes.axhline(0.0, color=COLOURS["rest"], linewidth=0.5)
    axes.set(xlabel="tip", ylabel="normal force [N]")
    axes.legend(loc="best")
    set_title(figure, data.attrs["case"], "contact constant in rotating axes")
    return figure


def report(data: xr.Dataset, failures: Sequence[str]) -> Study:
    """Return the document, table and figure of constant contact; a multiplier is the factor by
    which a small deviation grows in a turn."""
    values = data["multipliers"].values
    normal, gap = data["normal_force"], abs(data["gap"])
    shown = data.assign(
        speed_rad_s=data["rpm"] * np.pi / 30.0,
        largest_force=normal.max("tip"),
        tips=(normal != 0.0).sum("tip"),
        radius=np.hypot(data["centre"].sel(axis="x"), data["centre"].sel(axis="y")),
        largest_multiplier=np.abs(data["multipliers"][:, 0]),
        pairs=(("speed", "multiplier", "part"), np.stack([values.real, values.imag], axis=-1)),
        residual=gap.where(normal > 0.0).max("tip") / gap.max("tip"),
    )
    rows = rows_of(shown, COLUMNS)
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "solutions": rows,
        "failures": list(failures),
    }
    return Study(
        name="periodic",
        document=document,
        tables=[table(rows, COLUMNS, "Contact constant in rotating axes")],
        figures=lambda: {"periodic": (plot_corotating(data), data)},
    )
