"""Stability of the coupled stage at one speed and coupling stiffness."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import rich
import typer
from rich.table import Table

from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import Speed
from bladewhirl.solvers.stability.coupled_modes import CoupledMotion, coupled_modes
from bladewhirl.solvers.stability.floquet import coupled_floquet
from bladewhirl.solvers.stability.growth import eigenvalues, growth_rate, is_unstable
from bladewhirl.studies.modal.coupled_system import System

FEW = 4
"""Modes that are listed by name."""


def look_at_point(
    system: System, *, speed: str, kappa: float, folder: Path | None, films: bool, as_json: bool
) -> None:
    """Report growth rate and spectrum at a point; draw the divergent mode where there is one.

    Args:
        system: the coupled modes.
        speed: as the user gave it.
        kappa: spring stiffness [N/m].
        folder: where the divergent mode is drawn; not at all when None.
        films: draw it as VTK series and GIF too.
        as_json: print one JSON document instead of a table.
    """
    omega = given_speed(speed).rad_per_s(system.reference)
    point = point_report(system, omega, kappa)
    motion = None
    if folder is not None:
        if not point["unstable"]:
            raise UserError(
                f"--output {folder}: expected an unstable point; at --speed {speed} --kappa"
                f" {kappa:g} there is no divergent mode to draw"
            )
        motion = _draw(system, omega, kappa, folder, films)
        point["coupled_mode"] = motion_report(motion)
    if as_json:
        typer.echo(json.dumps(point, indent=2))
    else:
        print_point(point)


def point_report(system: System, omega: float, kappa: float) -> dict[str, Any]:
    """Growth rate, verdict and spectrum at a point.

    The growth rate comes from the autonomous form; next to it stands that of the monodromy matrix
    of the periodic system, which knows nothing of that form (absent at rest, which has no period).

    Args:
        system: the coupled modes.
        omega: speed [rad/s].
        kappa: spring stiffness [N/m].
    """
    arguments: dict[str, Any] = {"speed": omega, "kappa": kappa, "with_pi": system.with_pi}
    spectrum = eigenvalues(system.modes, **arguments)
    growth = float(growth_rate(system.modes, **arguments))
    report = point_facts(spectrum, growth, omega=omega, kappa=kappa, reference=system.reference)
    if omega:
        turns = coupled_floquet(system.modes, **arguments)
        report["growth_rate_floquet"] = max(float(turn.growth) for turn in turns.values())
    return report | system.options()


def point_facts(
    spectrum: ComplexArray, growth: float, *, omega: float, kappa: float, reference: float
) -> dict[str, Any]:
    """What reports of a point have in common, by whatever method it was looked at.

    Args:
        spectrum: eigenvalues or Floquet exponents [1/s].
        growth: growth rate [1/s].
        omega: speed [rad/s].
        kappa: spring stiffness [N/m].
        reference: frequency that speeds are multiples of [rad/s].
    """
    fastest_first = np.sort_complex(spectrum)[::-1].tolist()
    return {
        "speed": omega / reference,
        "speed_rad_per_s": omega,
        "kappa": kappa,
        "growth_rate": growth,
        "unstable": bool(is_unstable(growth, omega)),
        "eigenvalues": [[value.real, value.imag] for value in fastest_first],
    }


def motion_report(motion: CoupledMotion) -> dict[str, Any]:
    """What a coupled mode was measured to do; speeds in rad/s, forward positive."""
    report: dict[str, Any] = {
        "nodal_diameter": motion.nodal_diameter,
        "rotor_wave_speed": motion.rotor_wave_speed,
        "casing_wave_speed": motion.casing_wave_speed,
    }
    if motion.nodal_diameter == 1:
        report |= {
            "whirl_speed_rotating": motion.whirl_speed,
            "whirl_speed_static": motion.whirl_speed_static,
            "shaft_lead_degrees": float(np.degrees(motion.shaft_lead[-1])),
        }
    return report


def _draw(system: System, omega: float, kappa: float, folder: Path, films: bool) -> CoupledMotion:
    from bladewhirl.studies.modal.coupled_mode import draw_coupled_mode  # takes long to load

    arguments: dict[str, Any] = {"speed": omega, "kappa": kappa, "with_pi": system.with_pi}
    k = coupled_modes(system.modes, **arguments)[0].nodal_diameter
    part = system.stage.take(np.flatnonzero(system.modes.nodal_diameter == k))
    folder.mkdir(parents=True, exist_ok=True)
    return draw_coupled_mode(
        part,
        coupled_modes(part.modes, **arguments)[0],
        part.springs(kappa, with_pi=system.with_pi),
        folder,
        reference=system.reference,
        films=films,
    )


def print_point(point: dict[str, Any]) -> None:
    """Print a report as a table."""
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_row("speed", f"{point['speed']:.6g} ω₁ = {point['speed_rad_per_s']:.6g} rad/s")
    table.add_row("coupling stiffness", f"{point['kappa']:.6g} N/m")
    table.add_row("coupled modes", _listed(point["modes"]))
    verdict = "unstable" if point["unstable"] else "stable"
    table.add_row("growth rate", f"{point['growth_rate']:.6g} 1/s ({verdict})")
    if "growth_rate_floquet" in point:
        table.add_row("by the monodromy", f"{point['growth_rate_floquet']:.6g} 1/s")
    for name, value in point.get("coupled_mode", {}).items():
        unit = " rad/s" if "speed" in name else "°" if "degrees" in name else ""
        table.add_row(name.replace("_degrees", "").replace("_", " "), f"{value:.6g}{unit}")
    rich.print(table)


def _listed(names: list[str]) -> str:
    few = ", ".join(names[:FEW])
    return few if len(names) <= FEW else f"{few} and {len(names) - FEW} more"


def given_speed(text: str) -> Speed:
    """A speed of the command line.

    Raises:
        UserError: it is none.
    """
    try:
        return Speed(float(text))
    except ValueError:
        pass
    try:
        return Speed(text)
    except ValueError as error:
        raise UserError(
            f"--speed {text}: expected multiples of the reference frequency, or text in rpm, Hz or"
            f" rad/s ({error})"
        ) from None
