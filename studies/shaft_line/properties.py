"""Masses, static loads and sag of a shaft line."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.shaft_line.line import line_model
from bladewhirl.models.shaft_line.whirl import sag
from bladewhirl.studies.runs.columns import Column, facts, table, texts

if TYPE_CHECKING:
    from rich.table import Table

PROPERTIES = (
    Column("mass", "mass with disks and wheels, without supports [kg]", ".6g"),
    Column("shaft_mass", "mass of the shaft [kg]", ".6g"),
    Column("polar_inertia", "polar inertia [kg m2]", ".6g"),
    Column("centre_of_mass", "centre of mass along the shaft [m]", ".6g"),
    Column("nodes", "nodes", "d"),
    Column("reference_frequency.hz", "lowest frequency at rest [Hz]", ".6g"),
    Column("speed.rpm", "speed [rpm]", ".6g"),
    Column("largest_sag", "largest sag [mm]", ".4g", 1e3),
)
WHEELS = (
    Column("position", "wheel at [m]", ".4g"),
    Column("consists_of", "consists of"),
    Column("mass", "mass [kg]", ".6g"),
    Column("polar_inertia", "polar inertia [kg m2]", ".6g"),
    Column("diametral_inertia", "diametral inertia [kg m2]", ".6g"),
    Column("centre_of_mass", "centre of mass [m]", ".6g"),
)
BEAMS = "beams, rigid in tilt"

BEARINGS = (
    Column("name", "bearing"),
    Column("position", "position [m]", ".4g"),
    Column("force_x", "static force x [N]", ".5g"),
    Column("force_y", "static force y [N]", ".5g"),
    Column("sag", "sag [mm]", ".4g", 1e3),
)


def draw(case: Case, path: Path) -> None:
    """Draw the shaft line of a case at rest as PNG.

    Raises:
        CaseError: the bearings do not hold the line, or the wheel has no hub.
    """
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.postprocess.shaft_line.rotor import plot_rotor, rotor_of

    line = line_model(case)
    wheels = [
        (float(line.position[wheel.node]), float(wheel.source.part.contact_radius.max()))
        for wheel in line.wheels
    ]
    rotor = rotor_of(line.table, line.position, title=case.title, wheels=wheels)
    save_figure(plot_rotor(rotor), path)


def properties(case: Case) -> tuple[dict[str, Any], "list[Table]"]:
    """Return the properties of the shaft line of a case as document and tables.

    With [gravity], these contain the static forces of the bearings on the shaft, and the sag at the
    speed of the case.

    Raises:
        CaseError: the bearings do not hold the line, or the wheel has no hub.
    """
    line = line_model(case)
    node = slice(0, 2 * len(line.position), 2)
    moved_aside, tilted = np.zeros((2, line.size))
    moved_aside[node] = 1.0
    tilted[node], tilted[1 : 2 * len(line.position) : 2] = line.position, 1.0
    mass = float((moved_aside @ line.mass @ moved_aside).real)
    document: dict[str, Any] = {
        "mass": mass,
        "shaft_mass": mass - sum(each.mass for each in line.table.disks),
        "polar_inertia": line.polar_inertia,
        "centre_of_mass": float((moved_aside @ line.mass @ tilted).real) / mass,
        "nodes": len(line.position),
        "reference_frequency": {"hz": line.reference_frequency / (2.0 * np.pi)},
        "speed": {"rpm": line.speed * 30.0 / np.pi, "rad_per_s": line.speed},
    }
    tables = []
    if line.wheels:
        document["shaft_mass"] -= sum(wheel.mass for wheel in line.wheels)
        document["polar_inertia"] += sum(wheel.polar_inertia for wheel in line.wheels)
        document["wheels"] = [
            {
                "position": (position := float(line.position[wheel.node])),
                "consists_of": BEAMS if wheel.source.of_beams else "solids",
                "mass": wheel.mass,
                "polar_inertia": wheel.polar_inertia,
                "diametral_inertia": wheel.diametral_inertia,
                "centre_of_mass": position + wheel.offset,
            }
            for wheel in line.wheels
        ]
        tables.append(table(document["wheels"], WHEELS, "Wheels"))
    if case.gravity is not None:
        moved = sag(line, line.speed)
        forces = line.bearing_force(moved, np.zeros_like(moved))
        document["largest_sag"] = float(np.abs(moved[node]).max())
        document["bearings"] = [
            {
                "name": name,
                "position": bearing.position,
                "force_x": float(force.real) + 0.0,
                "force_y": float(force.imag) + 0.0,
                "sag": float(np.abs(moved[2 * line.node(bearing.position)])),
            }
            for name, bearing, force in zip(
                line.table.named(), line.table.bearings, forces, strict=True
            )
        ]
        document["sag"] = {
            "position": line.position.tolist(),
            "x": moved[node].real.tolist(),
            "y": moved[node].imag.tolist(),
        }
        tables.append(table(document["bearings"], BEARINGS, "Static loads of the bearings"))
    return document, [facts(texts(document, PROPERTIES)), *tables]
