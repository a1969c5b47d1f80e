"""Properties of a stage: masses, frequencies, time step, speed, loads, sizes."""

from typing import Any

import numpy as np

from bladewhirl.meshes.ring_mesh import W
from bladewhirl.models.case.excitation import CasingDistortion, Imbalance
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.stage.contact_problem import critical_time_step
from bladewhirl.models.stage.excitations import radial_mode, unbalance_to_touch
from bladewhirl.models.stage.loads import imbalance_force, unbalance, unbalance_direction
from bladewhirl.models.stage.stage import LOWEST, Stage
from bladewhirl.models.stage.wall_coating import WallCoating
from bladewhirl.solvers.march.recorder import result_bytes
from bladewhirl.solvers.packing.rotor import blade_columns

MARCHES = {True: "harmonic by harmonic", False: "by dense products"}
"""Name of the method that marches a body, with and without use of cyclic symmetry."""


def stage_properties(stage: Stage) -> dict[str, Any]:
    """Compute masses, frequencies, time step, loads and sizes of a stage, as a JSON document.

    Missing values are None, such as values of loads that the case does not have.

    Raises:
        CaseError: a property exceeds the largest float.
    """
    case = stage.case
    with numbers_within_reach(case):
        rotor, casing = stage.bodies
        critical = critical_time_step(rotor, casing, stage.kept.springs)
        timing, coating = case.march.timing, stage.coating
        moves = stage.has_centre and not case.shaft.clamped
        return {
            # The lowest frequency of the full bladed disk with free centre, at rest.
            "reference_frequency": stage.rate(stage.reference_frequency),
            "speed": stage.rate(stage.speed),
            "rotation_effects": case.effects,  # effects included in the frequencies below
            "shaft_stiffness": case.shaft.springs if moves else None,  # x and y [N/m]
            # With the struts [kg]; None for a rigid wall.
            "casing_mass": stage.casing.mass if casing.is_flexible else None,
            "casing": _lowest_of_casing(stage),
            "smallest_clearance": float(casing.clearance[:, 0].min() + rotor.tip_recess.min()),
            **stage.own_properties,
            "symmetry": stage.symmetry or None,
            # Whether a body is marched by harmonics or by dense products.
            "cyclic": {
                "bladed_disk": blade_columns(rotor) is not None,
                "casing": casing.by_harmonics,
            },
            "critical_time_step": critical,  # s
            "dt_over_critical": case.march.time_step / critical,
            "steps": case.march.steps,
            "records": timing.records,
            # The approximate size of result.nc.
            "result_bytes": result_bytes(stage.arrays, timing, coating),
            "imbalance": _imbalance(stage),
            "distortion": _distortion(stage),
            "coating": None if coating is None else _coating(coating),
        }


def _coating(coating: WallCoating) -> dict[str, float]:
    """Return tracks and rods of a coating, the arc that a tip covers, and the force at which the
    coating under a tip gives way."""
    tracks, rods = coating.strain.shape
    covered = coating.width[coating.track] * coating.footprint
    return {
        "tracks": tracks,
        "rods": rods,  # of each track
        "arc": coating.arc,  # of a rod [m]
        "width": float(np.sum(coating.width)),  # of all tracks [m]
        "footprint": float(coating.footprint.min()),  # of the narrowest tip [m]
        "yield_force": coating.yield_stress * float(covered.min()),  # of the smallest tip [N]
    }


def _lowest_of_casing(stage: Stage) -> list[dict[str, Any]]:
    modes = stage.casing_modes  # in ascending order
    if not modes.count:
        return []
    diameters, first = np.unique(modes.nodal_diameter, return_index=True)
    numbers = range(min(LOWEST, modes.count)) if diameters[0] < 0 else first.tolist()
    return [
        stage.listed(int(modes.nodal_diameter[i]), modes.frequency[i], float(modes.purity[i]))
        for i in numbers
    ]


def _imbalance(stage: Stage) -> dict[str, float] | None:
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


def _distortion(stage: Stage) -> dict[str, Any] | None:
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
        "frequency": stage.rate(frequency),
        "static_displacement": float(wall * load.modal_force / frequency**2),
    }
