"""A coupled mode laid out like the result of a run, so that everything that reads one draws it."""

from __future__ import annotations

from importlib import metadata

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.coupling.stage_modes import StageModes
from bladewhirl.postprocess.fields.mode_result import stage_dataset, with_history
from bladewhirl.solvers.stability.coupled_modes import CoupledMotion, RadialShapes


def radial_shapes(stage: StageModes) -> RadialShapes:
    """Shapes of shaft, tips and casing for unit coordinates, step 4 of Section 3.3.2.

    Args:
        stage: the coupled modes; shapes are those of the finite element modes, whatever
            amplitudes the coupling takes.
    """
    disk, casing, size = stage.modal.disk, stage.modal.casing, stage.modes.size
    rotor, rotor_modes = stage.mode_numbers(on_casing=False)
    wall, wall_modes = stage.mode_numbers(on_casing=True)
    shapes = stage.modal.disk_modes.fields(rotor_modes)
    tips = np.zeros((len(disk.tip_angles), size))
    tips[:, rotor] = shapes[disk.tip_radial]
    centre = np.zeros((2, size))
    centre[:, rotor] = disk.cartesian(shapes)[disk.mesh.node_sets["centre"][0], :2]
    radial = np.zeros((casing.mesh.elements, size))
    radial[:, wall] = casing.nodal(stage.modal.casing_modes.fields(wall_modes))[:, 0]
    return RadialShapes(
        centre=centre,
        tips=tips,
        tip_angle=disk.tip_angles,
        casing=radial,
        casing_angle=casing.mesh.angles,
    )


def coupled_mode_result(
    stage: StageModes,
    motion: CoupledMotion,
    springs: CouplingSprings,
    *,
    reference: float,
    case: str,
) -> xr.Dataset:
    """Lay a coupled mode in time out like `result.nc`.

    Nothing touches: contacts, impulses and friction are zero.

    Args:
        stage: the coupled modes.
        motion: of one coupled mode, equally spaced in time.
        springs: that couple these modes.
        reference: frequency that speeds are multiples of [rad/s].
        case: the case file's text.
    """
    rotor, rotor_modes = stage.mode_numbers(on_casing=False)
    wall, wall_modes = stage.mode_numbers(on_casing=True)
    arrays = stage.modal.arrays(rotor_modes, wall_modes)
    energy, lost = _energy(motion, springs), _damping_work(stage, motion)
    history = {
        "time": motion.time,
        "rotor_displacement": motion.displacement[:, rotor],
        "rotor_velocity": motion.velocity[:, rotor],
        "casing_displacement": motion.displacement[:, wall],
        "casing_velocity": motion.velocity[:, wall],
        "gap": _gaps(stage, motion),
        "energy": energy,
        "damping_work": lost,
        "coupling_work": energy - energy[0] + lost,
    }
    given = stage.modal.case
    return with_history(stage_dataset(arrays), history).assign_attrs(
        {
            "title": "coupled mode",
            "version": metadata.version("bladewhirl"),
            "speed": motion.speed,
            "reference_frequency": reference,
            "casing_radius": stage.modal.casing.mesh.radius,
            "tip_radius": given.tip_radius,
            "friction": 0.0,
            "clamped": int(given.shaft.clamped),
            "end_reason": "completed",
            "end_message": "the clearance closes here",
            "case": case,
            "steps": len(motion.time) - 1,
        }
    )


def _gaps(stage: StageModes, motion: CoupledMotion) -> FloatArray:
    """Gap at each tip at each record, (records, blades)."""
    angle = stage.modal.disk.tip_angles + motion.speed * motion.time[:, None]
    wall = (motion.casing_wave[:, None] * np.exp(-1j * motion.nodal_diameter * angle)).real
    tips = motion.displacement @ radial_shapes(stage).tips.T
    at_rest = stage.modal.case.casing.clearance + stage.modal.disk.model.tip_recess
    return np.asarray(at_rest + wall - tips)


def _energy(motion: CoupledMotion, springs: CouplingSprings) -> FloatArray:
    """Energy of both bodies and of the springs between them, (records,)."""
    moved = motion.displacement
    strain = springs.modes.frequency[springs.modes.entry] * moved
    bodies = 0.5 * np.sum(motion.velocity**2 + strain**2, axis=1)
    held = springs.stiffness(angle=motion.speed * motion.time)
    return np.asarray(bodies + 0.5 * np.einsum("ti,tij,tj->t", moved, held, moved))


def _damping_work(stage: StageModes, motion: CoupledMotion) -> FloatArray:
    """Energy that modal damping has taken since the first record, (records,)."""
    power = motion.velocity**2 @ stage.modes.damping_rate[stage.modes.entry]
    return np.asarray(cumulative_trapezoid(power, motion.time, initial=0.0))
