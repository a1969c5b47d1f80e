"""Stability chart of the coupled stage: figures and data."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import typer
import xarray as xr
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.postprocess.modal.stability import (
    chart_dataset,
    plot_chart,
    plot_spectrum,
    plot_truncation,
    spectrum_dataset,
    truncation_dataset,
    zones_dataset,
)
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.solvers.stability.growth import eigenvalues, stability_chart
from bladewhirl.solvers.stability.tracking import track
from bladewhirl.solvers.stability.zones import unstable_zones
from bladewhirl.studies.modal.coupled_system import System

BORDER_STIFFNESSES = 61
"""Stiffnesses at which the borders of zones are found."""

COLUMNS = ("kappa", "lower", "upper", "growth")
"""What a report tells of a zone at each stiffness."""

LINE_SPEEDS = 1201
"""Speeds along a line of constant stiffness, ..."""

ZONE_SPEEDS = 21
"""... and further ones inside each of its zones, which may be narrow."""


def make_chart(
    system: System,
    *,
    speeds: FloatArray,
    kappas: FloatArray,
    line: float,
    folder: Path | None,
    as_json: bool,
) -> None:
    """Chart the growth rate, draw all figures, report the zones.

    Args:
        system: the coupled modes.
        speeds: in multiples of the reference frequency, ascending.
        kappas: spring stiffnesses [N/m], ascending.
        line: stiffness along which eigenvalues are drawn [N/m].
        folder: where figures and data go; none are made when None.
        as_json: print one JSON document instead of a line on each zone.
    """
    omegas = speeds * system.reference
    zones = zones_of(system, system.modes, omegas, kappas)
    with progress_bar(quiet=as_json) as bar:
        task = bar.add_task("growth rates", total=omegas.size * kappas.size)
        grid = stability_chart(
            system.modes,
            speeds=omegas,
            kappas=kappas,
            with_pi=system.with_pi,
            progress=lambda done, _: bar.update(task, completed=done),
        )
    chart = chart_dataset(grid, zones)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        save_figure(plot_chart(chart), folder / "stability", chart)
        draw_spectrum(system, omegas, line, folder)
        if not system.is_six:
            truncation = truncation_dataset(zones, zones_of(system, system.six, omegas, kappas))
            save_figure(plot_truncation(truncation), folder / "truncation", truncation)
    report = zone_report(chart)
    if as_json:
        typer.echo(json.dumps(report | system.options(), indent=2))
        return
    for zone in report["zones"]:
        typer.echo(
            f"{zone['casing']} + {zone['rotor']}: from {zone['coincidence']:.4g} ω₁; at"
            f" {zone['kappa'][-1]:.4g} N/m {zone['lower'][-1]:.4g} to {zone['upper'][-1]:.4g} ω₁"
        )
    if not report["zones"]:
        typer.echo("No unstable point in this range.")
    if folder is not None:
        typer.echo(f"Wrote {folder}.")


def zone_report(chart: xr.Dataset) -> dict[str, Any]:
    """Borders of the zones, and coincidence speeds, in multiples of the reference frequency."""
    zones: dict[tuple[str, str], dict[str, Any]] = {}
    for row in range(chart.sizes["zone"]):
        here = chart.isel(zone=row)
        casing, rotor = str(here["zone_casing"].item()), str(here["zone_rotor"].item())
        zone = zones.setdefault(
            (casing, rotor),
            {
                "casing": casing,
                "rotor": rotor,
                "nodal_diameter": here["zone_nodal_diameter"].item(),
                "coincidence": here["zone_start"].item(),
                **{name: [] for name in COLUMNS},
            },
        )
        for name in COLUMNS:
            zone[name].append(here[f"zone_{name}"].item())
    return {
        "zones": list(zones.values()),
        "coincidence_speeds": [
            {"casing": str(casing), "rotor": str(rotor), "speed": float(speed)}
            for casing, rotor, speed in zip(
                *(chart[f"coincidence{part}"].values for part in ("_casing", "_rotor", "")),
                strict=True,
            )
        ],
        "largest_growth_rate": float(chart["growth"].max()),
    }


def zones_of(
    system: System, modes: CouplingModes, omegas: FloatArray, kappas: FloatArray
) -> xr.Dataset:
    """Borders of the unstable zones of some modes, and coincidence speeds.

    Args:
        system: the coupled modes that the options belong to.
        modes: whose zones are looked for.
        omegas: speeds [rad/s], ascending.
        kappas: spring stiffnesses [N/m], ascending.
    """
    borders = np.linspace(kappas[0], kappas[-1], BORDER_STIFFNESSES)
    zones = unstable_zones(
        modes, kappas=borders, low=omegas[0], high=omegas[-1], with_pi=system.with_pi
    )
    return zones_dataset(zones, modes, speed=omegas, kappa=kappas, reference=system.reference)


def draw_spectrum(system: System, omegas: FloatArray, line: float, folder: Path) -> None:
    """Draw the eigenvalues along a line of constant stiffness, tracked."""
    zones = unstable_zones(
        system.modes,
        kappas=np.array([line]),
        low=omegas[0],
        high=omegas[-1],
        with_pi=system.with_pi,
    )
    inside = np.linspace(zones.lower, zones.upper, ZONE_SPEEDS).ravel()
    along = np.unique(np.append(np.linspace(omegas[0], omegas[-1], LINE_SPEEDS), inside))
    spectra = eigenvalues(system.modes, speed=along, kappa=line, with_pi=system.with_pi)
    data = spectrum_dataset(along, track(along, spectra), kappa=line, reference=system.reference)
    save_figure(plot_spectrum(data), folder / "spectrum", data)


def progress_bar(*, quiet: bool) -> Progress:
    """A progress bar on standard error."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True, quiet=quiet),
    )
