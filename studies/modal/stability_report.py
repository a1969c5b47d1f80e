"""Tables, JSON documents and figures of what a study of stability found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import rich
import typer
import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.modal.stability import plot_chart, plot_spectrum, plot_truncation
from bladewhirl.solvers.stability.growth import is_unstable
from bladewhirl.studies.modal.coupled_mode import MEASURES
from bladewhirl.studies.modal.coupled_system import EvenSystem, System
from bladewhirl.studies.modal.stability import stability_point
from bladewhirl.studies.modal.stability_chart import (
    spectrum_along,
    stability_chart,
    truncation,
    zones,
)
from bladewhirl.studies.runs.figures_folder import save_figures

FEW = 4
"""Modes that are listed by name."""

COLUMNS = ("kappa", "lower", "upper", "growth")
"""Columns of a zone in a report, a value at each stiffness."""


def report_point(
    system: System,
    omega: float,
    kappa: float,
    folder: Path | None,
    *,
    films: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Print growth rate and spectrum at a point; draw the divergent mode where there is one.

    Args:
        system: the coupled modes.
        omega: speed [rad/s].
        kappa: spring stiffness [N/m].
        folder: where the divergent mode is drawn; not at all when None.
        films: draw it as VTK series and GIF too.
        overwrite: replace files that are there, whosever they are.
        as_json: print one JSON document instead of a table.
    """
    data = stability_point(system, omega, kappa)
    point = point_document(data) | system.options()
    if isinstance(system, EvenSystem):
        point |= system.rotor_alone(omega)
    if folder is not None:
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
        # This takes long to load.
        from bladewhirl.studies.modal.coupled_mode_figures import draw_coupled_mode

        draw_coupled_mode(system, omega, kappa, folder, films=films, overwrite=overwrite)
        point["coupled_mode"] = {n: data[n].item() for n in MEASURES if n in data}
    if as_json:
        typer.echo(json.dumps(point, indent=2))
    else:
        _print_point(point)


def point_document(data: xr.Dataset) -> dict[str, Any]:
    """Growth rate, verdict and eigenvalues of a point of `stability_point`."""
    names = ("speed", "speed_rad_per_s", "kappa", "growth_rate", "unstable")
    point = {name: data[name].item() for name in names}
    point["eigenvalues"] = np.column_stack([data["real"], data["imaginary"]]).tolist()
    if "growth_rate_floquet" in data:
        point["growth_rate_floquet"] = data["growth_rate_floquet"].item()
    return point


def _print_point(point: dict[str, Any]) -> None:
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_row("speed", f"{point['speed']:.6g} ω₁ = {point['speed_rad_per_s']:.6g} rad/s")
    table.add_row("coupling stiffness", f"{point['kappa']:.6g} N/m")
    few = ", ".join(point["modes"][:FEW])
    more = len(point["modes"]) - FEW
    table.add_row("coupled modes", f"{few} and {more} more" if more > 0 else few)
    verdict = "unstable" if point["unstable"] else "stable"
    table.add_row("growth rate", f"{point['growth_rate']:.6g} 1/s ({verdict})")
    if "growth_rate_floquet" in point:
        table.add_row("by the monodromy", f"{point['growth_rate_floquet']:.6g} 1/s")
    for text in rotor_sentences(point, point["speed"]):
        table.add_row("bladed disk alone", text)
    for name, value in point.get("coupled_mode", {}).items():
        unit = " rad/s" if "speed" in name else "°" if "degrees" in name else ""
        table.add_row(name.replace("_degrees", "").replace("_", " "), f"{value:.6g}{unit}")
    rich.print(table)


def report_chart(
    system: System,
    omegas: FloatArray,
    kappas: FloatArray,
    folder: Path | None,
    *,
    line: float,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Chart the growth rate, draw all figures, report zones or the largest growth.

    Args:
        system: the coupled modes.
        omegas: speeds [rad/s], ascending.
        kappas: spring stiffnesses [N/m], ascending.
        folder: where figures and data go; none are made when None.
        line: stiffness along which eigenvalues are drawn [N/m].
        overwrite: replace files that are there, whosever they are.
        as_json: print one JSON document instead of lines.
    """
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True, quiet=as_json),
    ) as bar:
        task = bar.add_task("growth rates", total=omegas.size * kappas.size)
        chart = stability_chart(
            system, omegas, kappas, lambda done, _: bar.update(task, completed=done)
        )
    if folder is not None:
        figures = {"stability": (plot_chart(chart), chart)}
        if isinstance(system, EvenSystem):
            figures |= _even_figures(system, chart, omegas, kappas, line)
        save_figures(folder, figures, overwrite=overwrite)
    document = chart_document(chart)
    if isinstance(system, EvenSystem):
        document |= system.rotor_alone(float(omegas[-1]))
    if as_json:
        typer.echo(json.dumps(document | system.options(), indent=2))
        return
    for sentence in _sentences(document):
        typer.echo(sentence)
    for sentence in rotor_sentences(document | system.options(), omegas[-1] / system.reference):
        typer.echo(f"Bladed disk alone: {sentence}.")
    if folder is not None:
        typer.echo(f"Wrote {folder}.")


def _even_figures(
    system: EvenSystem,
    chart: xr.Dataset,
    omegas: FloatArray,
    kappas: FloatArray,
    line: float,
) -> dict[str, tuple[Figure, xr.Dataset]]:
    """Eigenvalues along a line of the chart and, of other modes than six, what six hide."""
    spectrum = spectrum_along(system, omegas, line)
    figures = {"spectrum": (plot_spectrum(spectrum), spectrum)}
    if not system.is_six:
        hidden = truncation(chart, zones(system, system.six, omegas, kappas))
        figures["truncation"] = plot_truncation(hidden), hidden
    return figures


def chart_document(chart: xr.Dataset) -> dict[str, Any]:
    """Zones and coincidence speeds of a chart where it has them, and its largest growth rate."""
    growth = chart["growth"]
    largest = growth.isel(growth.argmax(...))
    unstable = is_unstable(
        growth.values, chart["speed"].values * chart.attrs["reference_frequency"]
    )
    found: dict[str, Any] = {
        "largest_growth_rate": float(largest),
        "at_speed": float(largest["speed"]),
        "at_kappa": float(largest["kappa"]),
        "unstable_share": float(unstable.mean()),
    }
    if "zone" not in chart.dims:
        return found
    rows = chart[[str(name) for name in chart.data_vars if chart[name].dims == ("zone",)]]
    zones: dict[tuple[str, str], dict[str, Any]] = {}
    for row in rows.to_dataframe().to_dict("records"):
        zone = zones.setdefault(
            (row["zone_casing"], row["zone_rotor"]),
            {
                "casing": row["zone_casing"],
                "rotor": row["zone_rotor"],
                "nodal_diameter": row["zone_nodal_diameter"],
                "coincidence": row["zone_start"],
                **{name: [] for name in COLUMNS},
            },
        )
        for name in COLUMNS:
            zone[name].append(row[f"zone_{name}"])
    pairs = zip(
        *(chart[f"coincidence{part}"].values.tolist() for part in ("_casing", "_rotor", "")),
        strict=True,
    )
    names = ("casing", "rotor", "speed")
    return {
        "zones": [*zones.values()],
        "coincidence_speeds": [dict(zip(names, pair, strict=True)) for pair in pairs],
        **found,
    }


def rotor_sentences(found: Mapping[str, Any], speed: float) -> list[str]:
    """What a bladed disk with rotation effects does without the casing past its critical speed.

    Args:
        found: options and `EvenSystem.rotor_alone`.
        speed: that was looked at, normalised.
    """
    critical = found.get("critical_speed")
    if critical is None or abs(speed) <= critical:
        return []
    place = f"at {speed:.4g} ω₁, past its critical speed {critical:.5g} ω₁,"
    if found["rotation_effects"] == "centrifugal":
        return [
            f"{place} spin softening without Coriolis forces makes it diverge, which no rotor does;"
            ' rotation.effects = "full" holds it'
        ]
    k, grown = found["rotor_nodal_diameter"], f"growth {found['rotor_growth_rate']:.4g} 1/s"
    if found["waves_met"] and found["rotor_growth_rate"] > 0.0:
        return [f"{place} two of its waves with k = {k} have met and grow without damping, {grown}"]
    if not found["damped"]:
        return [f"{place} Coriolis forces alone hold it; --damped tells whether damping feeds it"]
    if found["rotor_growth_rate"] <= 0.0:
        return [f"{place} it decays"]
    damping = found["holding_damping"]
    grows = f"{place} internal damping feeds its forward wave with k = {k}, {grown}"
    if damping is None:
        return [f"{grows}; bearings cannot hold it"]
    return [f"{grows}; {damping:.4g} N s/m in each of two bearings that stand still hold it"]


def _sentences(document: dict[str, Any]) -> list[str]:
    """Lines on each zone of a chart or, where modes mix, on its largest growth."""
    if "zones" not in document:
        return [
            f"Largest growth rate {document['largest_growth_rate']:.4g} 1/s at"
            f" {document['at_speed']:.4g} ω₁ and {document['at_kappa']:.4g} N/m;"
            f" {100.0 * document['unstable_share']:.3g} % of the chart is unstable."
        ]
    return [
        f"{zone['casing']} + {zone['rotor']}: from {zone['coincidence']:.4g} ω₁; at"
        f" {zone['kappa'][-1]:.4g} N/m {zone['lower'][-1]:.4g} to {zone['upper'][-1]:.4g} ω₁"
        for zone in document["zones"]
    ] or ["No unstable point in this range."]
