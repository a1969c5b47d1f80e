"""JSON documents and figures of a stability study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.modal.stability import plot_chart, plot_spectrum, plot_truncation
from bladewhirl.solvers.stability.growth import Progress, is_unstable
from bladewhirl.studies.modal.coupled_mode import MEASURES
from bladewhirl.studies.modal.coupled_system import EvenSystem, System
from bladewhirl.studies.modal.modes import rows_of
from bladewhirl.studies.modal.stability import stability_point
from bladewhirl.studies.modal.stability_chart import (
    spectrum_along,
    stability_chart,
    truncation,
    zones,
)
from bladewhirl.studies.runs.figures_folder import save_figures

ZONE_KEYS = {
    "casing": "zone_casing",
    "rotor": "zone_rotor",
    "nodal_diameter": "zone_nodal_diameter",
    "coincidence": "zone_start",
}
"""Variables of a zone by their keys in JSON."""

BORDER_KEYS = ("kappa", "lower", "upper", "growth")
"""Keys of lists in a zone, with a value at each stiffness."""

COINCIDENCE_KEYS = {
    "casing": "coincidence_casing",
    "rotor": "coincidence_rotor",
    "speed": "coincidence",
}
"""Variables of a coincidence by their keys in JSON."""


def point_report(
    system: System, omega: float, kappa: float, folder: Path | None, *, films: bool, overwrite: bool
) -> dict[str, Any]:
    """Return growth rate and eigenvalues at a point; draw the divergent mode.

    Args:
        system: the coupled modes.
        omega: speed [rad/s].
        kappa: spring stiffness [N/m].
        folder: of the figures of the divergent mode; no figures if None.
        films: also write a VTK series and a GIF.
        overwrite: replace existing files, whoever wrote them.

    Raises:
        UserError: there is no divergent mode to draw, or it cannot be written.
    """
    data = stability_point(system, omega, kappa)
    names = ("speed", "speed_rad_per_s", "kappa", "growth_rate", "unstable")
    point = {name: data[name].item() for name in names}
    point["eigenvalues"] = np.column_stack([data["real"], data["imaginary"]]).tolist()
    if "growth_rate_floquet" in data:
        point["growth_rate_floquet"] = data["growth_rate_floquet"].item()
    point |= system.options()
    if isinstance(system, EvenSystem):
        point |= system.rotor_alone(omega)
    if folder is None:
        return point
    if not isinstance(system, EvenSystem):
        raise UserError(
            f"--output {folder}: the divergent mode is drawn where each mode has one nodal"
            " diameter: stages with cyclic symmetry, equal bearings, no dampers"
        )
    if not data["unstable"]:
        raise UserError(
            f"--output {folder}: expected an unstable point; at --speed"
            f" {float(data['speed']):.6g} --kappa {kappa:g} there is no divergent mode to draw"
        )
    # Slow to load.
    from bladewhirl.studies.modal.coupled_mode_figures import draw_coupled_mode

    draw_coupled_mode(system, omega, kappa, folder, films=films, overwrite=overwrite)
    return point | {"coupled_mode": {n: data[n].item() for n in MEASURES if n in data}}


def chart_report(
    system: System,
    omegas: FloatArray,
    kappas: FloatArray,
    folder: Path | None,
    *,
    line: float,
    overwrite: bool,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Return zones, coincidence speeds and the largest growth rate of a chart; draw it.

    Args:
        system: the coupled modes.
        omegas: speeds [rad/s], ascending.
        kappas: spring stiffnesses [N/m], ascending.
        folder: of figures and data; none if None.
        line: stiffness along which eigenvalues are drawn [N/m].
        overwrite: replace existing files, whoever wrote them.
        progress: called with the finished points and all points.
    """
    chart = stability_chart(system, omegas, kappas, progress)
    if folder is not None:
        figures = {"stability": (plot_chart(chart), chart)}
        if isinstance(system, EvenSystem):
            spectrum = spectrum_along(system, omegas, line)
            figures["spectrum"] = plot_spectrum(spectrum), spectrum
        if isinstance(system, EvenSystem) and not system.is_six:
            hidden = truncation(chart, zones(system, system.six, omegas, kappas))
            figures["truncation"] = plot_truncation(hidden), hidden
        save_figures(folder, figures, overwrite=overwrite)
    document = _zones(chart) if "zone" in chart.dims else {}
    growth = chart["growth"]
    largest = growth.isel(growth.argmax(...))
    document |= {
        "largest_growth_rate": float(largest),
        "at_speed": float(largest["speed"]),
        "at_kappa": float(largest["kappa"]),
        "unstable_share": float(is_unstable(growth.values, omegas).mean()),
    }
    if isinstance(system, EvenSystem):
        document |= system.rotor_alone(float(omegas[-1]))
    return document | system.options()


def _zones(chart: xr.Dataset) -> dict[str, Any]:
    """Return the zones and coincidence speeds of a chart."""
    merged: dict[tuple[str, str], dict[str, Any]] = {}
    keys = ZONE_KEYS | {name: f"zone_{name}" for name in BORDER_KEYS}
    for row in rows_of(chart, keys):
        first = {name: [] if name in BORDER_KEYS else value for name, value in row.items()}
        zone = merged.setdefault((row["casing"], row["rotor"]), first)
        for name in BORDER_KEYS:
            zone[name].append(row[name])
    return {
        "zones": [*merged.values()],
        "coincidence_speeds": rows_of(chart, COINCIDENCE_KEYS),
    }
