"""Critical speeds and Campbell diagram of a shaft line: Datasets, JSON documents, tables,
figure."""

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.shaft_line import whirl as whirl_of
from bladewhirl.models.shaft_line.axial import with_axial
from bladewhirl.models.shaft_line.line import line_model
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table
from bladewhirl.studies.shaft_line.modes import places

COLUMNS = (
    Column("number", "number", "d", variable="critical"),
    Column("rpm", "[rpm]", ".2f", variable="critical_speed"),
    Column("speed_rad_s", "[rad/s]", ".4f"),
    Column("decay_per_s", "decay [1/s]", ".5g", variable="decay"),
    Column("direction", "whirl", variable="whirl"),
)


def line_critical_speeds(case: Case, *, count: int = 4) -> xr.Dataset:
    """Compute the critical speeds of the shaft line of a case.

    A critical speed equals the frequency of a mode at this speed, with dampers, gyroscopic moments
    and unequal bearings. Over `critical`: critical_speed [rpm], speed_rad_s [rad/s], decay, the
    real part of the eigenvalue [1/s], and whirl: forward, which an unbalance drives, or backward,
    which it drives on unequal bearings only.

    Args:
        case: a case with [shaft_line].
        count: number of modes that are followed from rest; a mode whose frequency rises as fast as
            the speed has no critical speed.

    Raises:
        CaseError: the bearings do not hold the line.
    """
    line = line_model(case)
    if line.wheels:
        highest = whirl_of.line_modes(line, 0.0, count).eigenvalue.imag.max()
        line = line_model(case, float(highest))
    found = whirl_of.line_critical_speeds(line, count)
    return xr.Dataset(
        {
            "critical_speed": quantity("critical", found.speed * 30.0 / np.pi, "rpm"),
            "speed_rad_s": quantity("critical", found.speed, "rad/s", "critical speed"),
            "decay": quantity("critical", found.decay, "1/s", "real part of the eigenvalue"),
        },
        coords={
            "critical": np.arange(1, len(found.speed) + 1),
            "whirl": ("critical", np.array(found.direction, dtype=object)),
        },
        attrs={"title": case.title} | places(line),
    )


def line_campbell(case: Case, *, speeds: FloatArray, count: int = 8) -> xr.Dataset:
    """Compute the frequencies of the shaft line of a case at many speeds, in static axes.

    Over (speed, mode): frequency [Hz], decay [1/s] and whirl, forward, backward, planar, axial or
    torsional, of the lowest modes; nan if there are fewer.

    Args:
        case: a case with [shaft_line].
        speeds: speeds of rotation [rad/s], (speeds,).
        count: number of modes.

    Raises:
        CaseError: the bearings do not hold the line.
    """
    line = line_model(case, float(np.abs(speeds).max(initial=0.0)))
    rates = np.full((len(speeds), count), np.nan, dtype=np.complex128)
    whirl = np.full((len(speeds), count), "", dtype=object)
    for row, omega in enumerate(speeds):
        modes = with_axial(line, whirl_of.line_modes(line, float(omega), count), count)
        rates[row, : len(modes.eigenvalue)] = modes.eigenvalue
        whirl[row, : len(modes.eigenvalue)] = modes.direction
    over = ("speed", "mode")
    return xr.Dataset(
        {
            "frequency": quantity(over, rates.imag / (2.0 * np.pi), "Hz", "natural frequency"),
            "decay": quantity(over, rates.real, "1/s", "real part of the eigenvalue"),
        },
        coords={
            "speed": quantity("speed", speeds * 30.0 / np.pi, "rpm", "speed of rotation"),
            "mode": np.arange(1, count + 1),
            "whirl": (over, whirl),
        },
        attrs={"title": case.title, "case_rpm": line.speed * 30.0 / np.pi},
    )


def critical_report(computed: xr.Dataset) -> Study:
    """Return the document and the table of `line_critical_speeds`."""
    rows = rows_of(computed, COLUMNS)
    return Study(
        name="critical-speeds",
        document={"shaft_line": rows},
        tables=[table(rows, COLUMNS, "Critical speeds of the shaft line")],
    )


def campbell_report(diagram: xr.Dataset, critical: xr.Dataset) -> Study:
    """Return the critical speeds within the diagram as document and table, and the diagram."""
    last = float(diagram["speed"].max())
    inside = critical.isel(critical=critical["critical_speed"].values <= last)
    rows = rows_of(inside, COLUMNS)

    def figures() -> Figures:
        from bladewhirl.postprocess.shaft_line.campbell import plot_line_campbell

        return {"campbell": (plot_line_campbell(diagram, inside), diagram)}

    title = f"Critical speeds up to {last:.6g} rpm"
    return Study(
        name="campbell",
        document={
            "shaft_line": rows,
            "rpm": diagram["speed"].values.tolist(),
            "frequency_hz": [
                [None if value != value else value for value in row]
                for row in diagram["frequency"].values.tolist()
            ],
            "whirl": diagram["whirl"].values.tolist(),
        },
        tables=[table(rows, COLUMNS, title)],
        figures=figures,
    )
