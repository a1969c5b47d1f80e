"""Documents, tables and figures of a stability study."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.coupling.springs import SIX_NAMES
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.solvers.stability.growth import Progress, is_unstable
from bladewhirl.studies.modal.coupled_system import EvenSystem, System
from bladewhirl.studies.modal.stability import stability_point
from bladewhirl.studies.modal.stability_chart import (
    spectrum_along,
    stability_chart,
    truncation,
    zones,
)
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, facts, rows_of, table, texts

BORDERS = (
    Column("kappa", "at [N/m]", ".4g"),
    Column("lower", "from [ω₁]", ".4f"),
    Column("upper", "to [ω₁]", ".4f"),
    Column("growth"),
)
"""Columns of a zone whose value in JSON is a list, with an entry for each stiffness."""

ZONES = (
    Column("casing", "casing"),
    Column("rotor", "bladed disk"),
    Column("nodal_diameter"),
    Column("coincidence", "coincidence [ω₁]", ".4f", variable="start"),
    *BORDERS,
)
"""Columns of a zone; the variables have the prefix "zone_"."""

COINCIDENCES = (
    Column("casing", variable="coincidence_casing"),
    Column("rotor", variable="coincidence_rotor"),
    Column("speed", variable="coincidence"),
)
"""Columns of a coincidence."""

POINT = (
    Column("speed", "speed [ω₁]", ".6g"),
    Column("speed_rad_per_s", "speed [rad/s]", ".6g"),
    Column("kappa", "coupling stiffness [N/m]", ".6g"),
    Column("modes", "coupled modes"),
    Column("growth_rate", "growth rate [1/s]", ".6g"),
    Column("stability", "stability"),
    Column("growth_rate_floquet", "growth rate, monodromy [1/s]", ".6g"),
)
"""Columns of one point of the chart."""

MOTION = (
    Column("coupled_mode.nodal_diameter", "nodal diameter", "d"),
    Column("coupled_mode.rotor_wave_speed", "rotor wave speed [rad/s]", ".6g"),
    Column("coupled_mode.casing_wave_speed", "casing wave speed [rad/s]", ".6g"),
    Column("coupled_mode.whirl_speed_rotating", "whirl speed, rotating [rad/s]", ".6g"),
    Column("coupled_mode.whirl_speed_static", "whirl speed, static [rad/s]", ".6g"),
    Column("coupled_mode.shaft_lead_degrees", "shaft lead [°]", ".6g"),
)
"""Columns of the divergent mode at this point."""

CHART = (
    Column("largest_growth_rate", "largest growth rate [1/s]", ".4g"),
    Column("at_speed", "speed of the largest growth rate [ω₁]", ".4g"),
    Column("at_kappa", "stiffness of the largest growth rate [N/m]", ".4g"),
    Column("unstable_share", "unstable share of the chart [%]", ".3g", 100.0),
)
"""Columns of a whole chart."""

ROTOR_ALONE = (
    Column("critical_speed", "critical speed [ω₁]", ".5g"),
    Column("rotor_growth_rate", "growth rate, bladed disk alone [1/s]", ".4g"),
    Column("rotor_nodal_diameter", "nodal diameter of this growth", "d"),
    Column("cause", "cause of this growth"),
    Column(
        "holding_damping",
        "damping of each of two static bearings that stops this growth [N s/m]",
        ".4g",
    ),
)
"""Columns of the bladed disk without the casing."""


def point_report(
    system: System, omega: float, kappa: float, folder: Path | None, *, films: bool, overwrite: bool
) -> Study:
    """Return growth rate and eigenvalues at a speed omega [rad/s] and a spring stiffness kappa
    [N/m]; draw the divergent mode into a folder unless the folder is None.

    The options `films` and `overwrite` are described in `draw_coupled_mode`.

    Raises:
        UserError: there is no divergent mode to draw, or the figures cannot be written.
    """
    data = stability_point(system, omega, kappa)
    names = ("speed", "speed_rad_per_s", "kappa", "growth_rate", "unstable")
    point = {name: data[name].item() for name in names}
    point["eigenvalues"] = np.column_stack([data["real"], data["imaginary"]]).tolist()
    if "growth_rate_floquet" in data:
        point["growth_rate_floquet"] = data["growth_rate_floquet"].item()
    point |= system.options() | system.rotor_alone(omega)
    if folder is not None:
        if not isinstance(system, EvenSystem):
            raise UserError(
                f"--output {folder}: the divergent mode can be drawn only if each mode has one"
                " nodal diameter, which requires cyclic symmetry, equal bearings and no dampers"
            )
        if not data["unstable"]:
            raise UserError(
                f"--output {folder}: expected an unstable point; at --speed"
                f" {float(data['speed']):.6g} --kappa {kappa:g} there is no divergent mode to draw"
            )
        # Slow to load.
        from bladewhirl.studies.modal.coupled_mode_figures import draw_coupled_mode

        draw_coupled_mode(system, omega, kappa, folder, films=films, overwrite=overwrite)
        measures = [column.key.removeprefix("coupled_mode.") for column in MOTION]
        measured = {name: data[name].item() for name in measures if name in data}
        point["coupled_mode"] = measured
    verdict = {"stability": "unstable" if point["unstable"] else "stable"}
    values = texts(point | verdict, (*POINT, *MOTION)) | _rotor_alone(point)
    return Study(name="stability", document=point, tables=[facts(values)])


def chart_report(
    system: System,
    omegas: FloatArray,
    kappas: FloatArray,
    *,
    line: float,
    progress: Progress | None = None,
) -> Study:
    """Return zones, coincidence speeds, largest growth rate and figures of a chart.

    Speeds omegas [rad/s] and spring stiffnesses kappas [N/m] are in ascending order. One figure
    shows eigenvalues at the spring stiffness `line` [N/m].
    """
    chart = stability_chart(system, omegas, kappas, progress)

    def figures() -> Figures:
        from bladewhirl.postprocess.modal.stability import (
            plot_chart,
            plot_spectrum,
            plot_truncation,
        )

        drawn = {"stability": (plot_chart(chart), chart)}
        if isinstance(system, EvenSystem):
            spectrum = spectrum_along(system, omegas, line)
            drawn["spectrum"] = plot_spectrum(spectrum), spectrum
        if isinstance(system, EvenSystem) and set(system.modes.name) != set(SIX_NAMES):
            hidden = truncation(chart, zones(system, system.six, omegas, kappas))
            drawn["truncation"] = plot_truncation(hidden), hidden
        return drawn

    document = _zones(chart) if "zone" in chart.dims else {}
    growth = chart["growth"]
    largest = growth.isel(growth.argmax(...))
    document |= {
        "largest_growth_rate": float(largest),
        "at_speed": float(largest["speed"]),
        "at_kappa": float(largest["kappa"]),
        "unstable_share": float(is_unstable(growth.values, omegas).mean()),
    }
    document |= system.rotor_alone(float(omegas[-1])) | system.options()
    tables = [facts(texts(document, CHART) | _rotor_alone(document))]
    if "zones" in document:
        lists = [column.key for column in BORDERS]
        rows = [zone | {key: zone[key][-1] for key in lists} for zone in document["zones"]]
        tables.insert(0, table(rows, ZONES, "Unstable zones"))
    return Study(name="stability", document=document, tables=tables, figures=figures)


def _zones(chart: xr.Dataset) -> dict[str, Any]:
    """Return the zones and coincidence speeds of a chart."""
    merged: dict[tuple[str, str], dict[str, Any]] = {}
    lists = [column.key for column in BORDERS]
    for row in rows_of(chart, ZONES, "zone_"):
        zone = merged.setdefault((row["casing"], row["rotor"]), row | {key: [] for key in lists})
        for key in lists:
            zone[key].append(row[key])
    return {"zones": [*merged.values()], "coincidence_speeds": rows_of(chart, COINCIDENCES)}


def _rotor_alone(document: dict[str, Any]) -> dict[str, str]:
    """Return the texts of `ROTOR_ALONE`, with the cause of growth of the uncoupled bladed disk
    above a critical speed, if any; the document is that of a point or of a chart."""
    cause = None
    if document.get("critical_speed") is None:
        pass
    elif document["rotation_effects"] == "centrifugal":
        cause = "no Coriolis forces; only rotation.effects = full stabilises a rotor"
    elif document["waves_met"]:
        cause = "two waves of the bladed disk have merged; they grow without damping"
    elif document["rotor_growth_rate"] > 0.0:
        unheld = document["holding_damping"] is None
        limit = ", which no bearing damping stabilises" if unheld else ""
        cause = f"internal damping of the forward wave{limit}"
    return texts(document | {"cause": cause}, ROTOR_ALONE)
