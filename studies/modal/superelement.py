"""Modes and properties of a case with a superelement."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.contact_problem import NodeCoating
from bladewhirl.models.stage.hints import locking_friction, static_response
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage
from bladewhirl.models.superelements.reduction import lowest_modes
from bladewhirl.solvers.march.recorder import result_bytes
from bladewhirl.studies.modal.columns import Column

MODES = (
    Column("number", "mode", "d"),
    Column("frequency_hz", "[Hz]", ".4f"),
    Column("normalised", "/ ω₁", ".5f"),
)
NODES = (
    Column("node", "node", "d"),
    Column("radius", "radius [mm]", ".5g", 1e3),
    Column("angle", "angle [°]", ".4g", 180.0 / np.pi),
    Column("axial", "axial [mm]", ".4g", 1e3),
    Column("flexibility", "flexibility [m/N]", ".3g"),
    Column("residual", "residual [m/N]", ".3g"),
    Column("locking_friction", "locks above μ", ".3g"),
)
PROPERTIES = (
    Column("superelement", "superelement"),
    Column("coordinates", "coordinates", "d"),
    Column("copies", "copies", "d"),
    Column("reference_frequency.hz", "lowest frequency [Hz]", ".6g"),
    Column("speed.rpm", "speed [rpm]", ".6g"),
    Column("speed.normalised", "speed / lowest frequency", ".5g"),
    Column("modes", "modes of each copy", "d"),
    Column("smallest_clearance", "smallest clearance [mm]", ".4g", 1e3),
    Column("coating.tracks", "tracks of the coating", "d"),
    Column("coating.rods", "rods of each track", "d"),
    Column("coating.footprint", "arc under a contact node [mm]", ".3g", 1e3),
    Column("coating.width", "width of a track [mm]", ".3g", 1e3),
    Column("critical_time_step", "critical time step [s]", ".4g"),
    Column("dt_over_critical", "time step / critical", ".3g"),
    Column("steps", "steps", "d"),
    Column("records", "records", "d"),
    Column("result_bytes", "result.nc, about [MB]", ".3g", 1e-6),
)


def superelement_modes(case: Case, count: int) -> dict[str, Any]:
    """Return the lowest natural frequencies of one copy of a superelement, or of its wheel.

    Returns:
        JSON document: "bladed_disk", a list of modes with "number", "frequency_hz" and
        "normalised", the frequency divided by the lowest one that is not of a rigid mode.
    """
    stage = superelement_stage(case)
    frequency = stage.reduced.frequency
    if stage.table.kind != "sector":
        frequency = np.sqrt(np.maximum(lowest_modes(stage.part, _most(stage, count))[0], 0.0))
    reference = stage.reference_frequency
    return {
        "bladed_disk": [
            {
                "number": number + 1,
                "frequency_hz": float(value / (2.0 * np.pi)),
                "normalised": float(value / reference),
            }
            for number, value in enumerate(frequency[:count])
        ]
    }


def _most(stage: SuperelementStage, count: int) -> int:
    return min(count, stage.part.size - 1)


def superelement_properties(stage: SuperelementStage) -> dict[str, Any]:
    """Return properties of the stage of a superelement, for JSON."""
    problem, timing, speed = stage.problem, stage.case.march.timing, stage.speed
    reference = stage.reference_frequency
    limit = problem.critical_time_step
    return {
        "superelement": stage.part.name,
        "source": stage.part.source,
        "coordinates": stage.part.size,
        "copies": stage.copies,
        "reference_frequency": {"hz": reference / (2.0 * np.pi), "rad_per_s": reference},
        "speed": {
            "rad_per_s": speed,
            "rpm": speed * 30.0 / np.pi,
            "normalised": speed / reference,
        },
        "modes": problem.frequency.shape[1],
        "smallest_clearance": float(problem.wall[:, 0].min() + stage.recess.min()),
        **_layer(problem.coating),
        "contact_nodes": list(_nodes(stage)),
        "critical_time_step": limit,
        "dt_over_critical": timing.time_step / limit,
        "steps": timing.steps,
        "records": timing.records,
        "result_bytes": result_bytes(stage.arrays, timing.records),
    }


def _layer(coating: NodeCoating | None) -> dict[str, Any]:
    """Return sizes of a coating, with the smallest footprint and width; empty without a coating."""
    if coating is None:
        return {}
    tracks, rods = coating.strain.shape
    sizes = {"footprint": float(coating.footprint.min()), "width": float(coating.width.min())}
    return {"coating": {"tracks": tracks, "rods": rods, **sizes}}


def _nodes(stage: SuperelementStage) -> Iterator[dict[str, Any]]:
    part, residual = stage.part, np.diag(stage.reduced.compliance)
    radial, _ = static_response(stage)
    locking = locking_friction(stage)
    for node in range(part.contacts):
        yield {
            "node": node,
            "radius": float(part.contact_radius[node]),
            "angle": float(stage.angle[0, node]),
            "axial": float(part.contact_position[node, 2]),
            "flexibility": float(radial[node]) if radial.size else None,
            "residual": float(residual[3 * node]),
            "locking_friction": locking.get(node),
        }
