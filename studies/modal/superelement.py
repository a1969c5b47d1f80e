"""Modes and properties of a case with a superelement."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.hints import locking_friction, static_response
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage
from bladewhirl.models.superelements.reduction import lowest_modes
from bladewhirl.solvers.march.recorder import result_bytes


def superelement_modes(case: Case, count: int) -> dict[str, Any]:
    """Return the lowest natural frequencies of one copy of a superelement, or of its wheel.

    Returns:
        JSON document: "bladed_disk", a list of modes with "number", "frequency_hz" and
        "normalised", the frequency divided by the lowest one that is not of a rigid mode.
    """
    stage = superelement_stage(case)
    frequency = stage.reduced.frequency
    if stage.table.kind != "sector":
        most = min(count, stage.part.size - 1)
        frequency = np.sqrt(np.maximum(lowest_modes(stage.part, most)[0], 0.0))
    hertz = (frequency / (2.0 * np.pi)).tolist()
    normalised = (frequency / stage.reference_frequency).tolist()
    rows = [
        {"number": number, "frequency_hz": hz, "normalised": ratio}
        for number, hz, ratio in zip(range(1, count + 1), hertz, normalised, strict=False)
    ]
    return {"bladed_disk": rows}


def superelement_properties(stage: SuperelementStage) -> dict[str, Any]:
    """Return properties of the stage of a superelement, for JSON."""
    problem, timing, speed = stage.problem, stage.case.march.timing, stage.speed
    reference, limit, layer = stage.reference_frequency, problem.critical_time_step, problem.coating
    coating: dict[str, Any] = {}
    if layer is not None:
        tracks, rods = layer.strain.shape
        coating = {"tracks": tracks, "rods": rods}
        coating |= {name: float(getattr(layer, name).min()) for name in ("footprint", "width")}
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
        **({"coating": coating} if coating else {}),
        "contact_nodes": list(_nodes(stage)),
        "critical_time_step": limit,
        "dt_over_critical": timing.time_step / limit,
        "steps": timing.steps,
        "records": timing.records,
        "result_bytes": result_bytes(stage.arrays, timing.records),
    }


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
