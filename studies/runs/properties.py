"""Properties of a stage: masses, frequencies, time step, speed, loads, sizes."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import W
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import CasingDistortion, Imbalance
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.elements.cyclic import NO_COLUMN
from bladewhirl.models.modal.modes import ModeTable
from bladewhirl.models.stage.basis_error import basis_error
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.build import steady_problem
from bladewhirl.models.stage.contact_problem import critical_time_step
from bladewhirl.models.stage.excitations import radial_mode, unbalance_to_touch
from bladewhirl.models.stage.loads import imbalance_force, unbalance, unbalance_direction
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.wall_coating import WallCoating
from bladewhirl.solvers.march.recorder import result_bytes

TURN = 2.0 * np.pi

LOWEST = 12  #: number of frequencies listed for a body without cyclic symmetry

MARCHES = {True: "harmonic by harmonic", False: "by dense products"}
"""Name of the method that marches a body, with and without use of cyclic symmetry."""

Rate = dict[str, float]
"""An angular frequency or speed: rad_per_s, hz (turns or cycles per second), rpm, and normalised
(multiples of the reference frequency)."""

Mode = dict[str, Any]
"""A mode of a full model: its dominant nodal_diameter (-1 without sectors), its frequency (a rate),
and its purity, the share of this nodal diameter."""


def speed_hint(case: Case, speed: float) -> str:
    """Return which speed [rad/s] studies at one speed use if the speed of a case varies; an empty
    text at a constant speed."""
    march = case.march
    if not march.varies:
        return ""
    key = "speed_table" if march.speed_table is not None else "run_up"
    which = f"the fastest speed of march.{key}"
    if march.drive is not None:
        which = "march.speed, at which the free speed starts"
    rpm = speed * 30.0 / np.pi
    return f"the speed varies; values at one speed are those at {rpm:.6g} rpm, {which}"


def stage_properties(stage: Beams) -> dict[str, Any]:
    """Compute masses, frequencies, time step, loads and sizes of a stage, as a JSON document.

    Missing values are None: values of shaft springs if the centre is clamped, and values of loads
    that the case does not have.

    Raises:
        CaseError: a property exceeds the largest float.
    """
    case, modes = stage.case, stage.reduction.modes
    with numbers_within_reach(case):
        pair = [mode for mode, name in enumerate(stage.disk_family) if name == "suspension"]
        rotor, casing = stage.bodies
        critical = critical_time_step(rotor, casing, stage.kept.springs)
        timing, coating = case.march.timing, stage.coating
        return {
            "bladed_disk_mass": stage.disk.model.mass,  # kg
            "bladed_disk_parts": stage.disk.model.part_masses,  # beams by part, point masses [kg]
            # With the struts [kg]; None for a rigid wall.
            "casing_mass": stage.casing.mass if casing.is_flexible else None,
            # The lowest frequency of the full bladed disk with free centre, at rest.
            "reference_frequency": _rate(stage, stage.reference_frequency),
            "speed": _rate(stage, stage.speed),
            "rotation_effects": case.rotation.effects,  # effects included in the frequencies below
            # The lowest mode of each nodal diameter; with unequal sectors the lowest modes.
            "bladed_disk": _lowest_of_disk(stage),
            "shaft_stiffness": None if case.shaft.clamped else case.shaft.springs,  # x and y [N/m]
            # The lower frequency of the pair; at speed, of the branch with most spring energy.
            "suspension": _rate(stage, modes.frequency[pair[0]]) if pair else None,
            "suspension_spring_share": float(modes.spring_share[pair[0]]) if pair else None,
            "casing": _lowest_of_casing(stage),
            "reduction": _reduction(stage),
            "symmetry": stage.symmetry,
            # Whether a body is marched by harmonics or by dense products.
            "cyclic": {"bladed_disk": rotor.by_harmonics, "casing": casing.by_harmonics},
            "critical_time_step": critical,  # s
            "dt_over_critical": case.march.time_step / critical,
            "steps": case.march.steps,
            "records": timing.records,
            # The approximate size of result.nc.
            "result_bytes": result_bytes(stage.arrays, timing, coating),
            "imbalance": _imbalance(stage),
            "distortion": _distortion(stage),
            "coating": _coating(coating),
        }


def _coating(coating: WallCoating | None) -> dict[str, float] | None:
    """Return number and arc length of the rods of the coating, the arc that a tip covers, and the
    force at which the coating under a tip gives way; None without a coating."""
    if coating is None:
        return None
    footprint = float(coating.footprint.min())
    return {
        "rods": coating.strain.shape[1],
        "arc": coating.arc,  # m
        "footprint": footprint,  # of the narrowest tip [m]
        "yield_force": coating.yield_stress * float(coating.width[0]) * footprint,  # N
    }


def _reduction(stage: Beams) -> dict[str, Any]:
    """Return size and accuracy of the Craig-Bampton reduction of the bladed disk."""
    boundary = {name: len(dofs) for name, dofs in stage.boundary_sets.items()}
    return {
        "boundary": boundary,  # numbers of boundary degrees of freedom, by node set
        # With complete pairs, possibly one more than requested.
        "fixed_interface_modes": stage.reduction.kept,
        "wanted": stage.case.reduction.fixed_interface_modes,
        "internal": stage.disk.structure.size - sum(boundary.values()),
        "modes": stage.reduction.modes.count,
        "marched": {"bladed_disk": len(stage.kept.rotor), "casing": len(stage.kept.casing)},
        "frequency_error": stage.frequency_error,  # largest relative error, by family
    }


def _rate(stage: Beams, rad_per_s: float) -> Rate:
    return {
        "rad_per_s": float(rad_per_s),
        "hz": float(rad_per_s / TURN),
        "rpm": float(60.0 * rad_per_s / TURN),
        "normalised": float(rad_per_s / stage.reference_frequency),
    }


def _lowest_of_disk(stage: Beams) -> list[Mode]:
    """Return the lowest modes of the full model. If sectors differ, nodal diameters and purities
    are taken from the modes of the reduced model."""
    frequencies, modes = stage.disk_frequencies, stage.reduction.modes
    if NO_COLUMN not in frequencies:
        return [_mode(stage, k, values[0], 1.0) for k, values in frequencies.items()]
    lowest = frequencies[NO_COLUMN]
    return _modes(stage, modes, range(min(LOWEST, modes.count, len(lowest))), lowest)


def _lowest_of_casing(stage: Beams) -> list[Mode]:
    modes = stage.casing_modes  # in ascending order
    if not modes.count:
        return []
    diameters, first = np.unique(modes.nodal_diameter, return_index=True)
    numbers = range(min(LOWEST, modes.count)) if diameters[0] < 0 else first.tolist()
    return _modes(stage, modes, numbers, modes.frequency)


def _modes(
    stage: Beams, modes: ModeTable, numbers: Iterable[int], frequencies: FloatArray
) -> list[Mode]:
    """Return modes by number, with their frequencies [rad/s]."""
    return [
        _mode(stage, int(modes.nodal_diameter[i]), frequencies[i], float(modes.purity[i]))
        for i in numbers
    ]


def _mode(stage: Beams, k: int, frequency: float, purity: float) -> Mode:
    return {"nodal_diameter": k, "frequency": _rate(stage, frequency), "purity": purity}


def _imbalance(stage: Beams) -> dict[str, float] | None:
    """Return size, force and effect of the imbalance at the speed of the case, if any."""
    loads = stage.case.excitations.values()
    if not any(isinstance(load, Imbalance) for load in loads):
        return None
    size = unbalance(stage)
    return {
        "unbalance": size,  # m e [kg m]
        "force": imbalance_force(stage),  # m e Omega^2 [N]
        # The share of the clearance closed by the static response, at the nearest tip.
        "closing": size / unbalance_to_touch(stage, stage.speed, unbalance_direction(stage)),
    }


def _distortion(stage: Beams) -> dict[str, Any] | None:
    """Return the frequency of the loaded casing mode and its largest radial displacement under the
    static load [m], for the first casing distortion; None without a casing distortion, or if the
    mode has no stiffness."""
    loads = stage.case.excitations.values()
    load = next((load for load in loads if isinstance(load, CasingDistortion)), None)
    if load is None:
        return None
    number = radial_mode(stage, load.nodal_diameter, stage.case.key_of(load))
    frequency = stage.casing_modes.frequency[number]
    if frequency == 0.0:
        return None
    wall = np.abs(stage.reduced_casing.nodal[:, W, number]).max()
    return {
        "frequency": _rate(stage, frequency),
        "static_displacement": float(wall * load.modal_force / frequency**2),
    }


def superelement_properties(stage: Matrices) -> dict[str, Any]:
    """Return properties of the stage of a superelement, for JSON."""
    problem, timing, speed = steady_problem(stage), stage.case.march.timing, stage.speed
    reference, limit, layer = stage.reference_frequency, problem.critical_time_step, problem.coating
    coating: dict[str, Any] = {}
    if layer is not None:
        tracks, rods = layer.strain.shape
        coating = {"tracks": tracks, "rods": rods, "footprint": float(layer.footprint.min())}
        coating["width"] = float(np.sum(layer.width))
    return {
        "superelement": stage.part.name,
        "source": stage.part.source,
        "coordinates": stage.table.part.size,
        "copies": stage.table.copies,
        "reference_frequency": {"hz": reference / (2.0 * np.pi), "rad_per_s": reference},
        "speed": {"rad_per_s": speed, "rpm": speed * 30.0 / np.pi, "normalised": speed / reference},
        "modes": problem.rotor.tip_radial.shape[1] * stage.copies,
        "frequency_error": basis_error(stage),
        "smallest_clearance": float(problem.casing.clearance[:, 0].min() + stage.recess.min()),
        **({"coating": coating} if coating else {}),
        **({} if stage.reduced.stress is None else {"stress_points": stage.given.point_count}),
        "contact_nodes": list(_nodes(stage)),
        "critical_time_step": limit,
        "dt_over_critical": timing.time_step / limit,
        "steps": timing.steps,
        "records": timing.records,
        "result_bytes": result_bytes(stage.arrays, timing, layer),
    }


def _nodes(stage: Matrices) -> Iterator[dict[str, Any]]:
    part, residual = stage.part, np.diag(stage.reduced.compliance)
    radial, _ = stage.static_response()
    locking = stage.locking_friction()
    equal = stage.table.copies // stage.copies if np.ptp(stage.factor) == 0.0 else 1
    for node in range(part.contacts // equal):
        yield {
            "node": node,
            "radius": float(part.contact_radius[node]),
            "angle": float(stage.angle[0, node]),
            "axial": float(part.contact_position[node, 2]),
            "flexibility": float(radial[node]) if radial.size else None,
            "residual": float(residual[3 * node]),
            "locking_friction": locking.get(node),
        }
