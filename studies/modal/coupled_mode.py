"""The divergent mode at one speed and coupling stiffness, in time: its motion and measures."""

from __future__ import annotations

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.postprocess.modal.motion import radial_shapes, shown_clearance
from bladewhirl.solvers.stability.coupled_modes import (
    CoupledMode,
    CoupledMotion,
    coupled_modes,
    coupled_motion,
)
from bladewhirl.studies.modal.coupled_system import EvenSystem

RECORDS_PER_TURN = 48
"""Twice what a smooth animation needs."""

GROWTHS = 2.5
"""The motion shown grows by exp of this, ..."""

FEWEST_TURNS, MOST_TURNS = 3, 40
"""... within these numbers of turns of the rotor."""

MEASURES = (
    "nodal_diameter",
    "rotor_wave_speed",
    "casing_wave_speed",
    "whirl_speed_rotating",
    "whirl_speed_static",
    "shaft_lead_degrees",
)
"""Names in `motion_measures`."""


def fastest_mode(system: EvenSystem, omega: float, kappa: float) -> CoupledMode:
    """The fastest growing of the coupled modes at a point."""
    return coupled_modes(system.modes, speed=omega, kappa=kappa, with_pi=system.with_pi)[0]


def divergent_motion(system: EvenSystem, omega: float, kappa: float) -> CoupledMotion:
    """The fastest growing coupled mode in time, as it closes the clearance."""
    mode = fastest_mode(system, omega, kappa)
    return coupled_motion(
        mode,
        time=whirl_records(mode),
        shapes=radial_shapes(system.stage),
        clearance=shown_clearance(system.stage.modal),
    )


def whirl_records(mode: CoupledMode) -> FloatArray:
    """Instants at which a growing mode is shown [s], equally spaced."""
    turn = 2.0 * np.pi / abs(mode.speed)
    turns = float(np.clip(GROWTHS / mode.eigenvalue.real / turn, FEWEST_TURNS, MOST_TURNS))
    records = np.arange(round(turns * RECORDS_PER_TURN) + 1)
    return np.asarray(turn / RECORDS_PER_TURN * records, dtype=np.float64)


def motion_measures(motion: CoupledMotion) -> dict[str, tuple[float, dict[str, str]]]:
    """Numbers measured of a coupled mode in time, with units; speeds are forward positive."""
    speed = {"units": "rad/s"}
    found: dict[str, tuple[float, dict[str, str]]] = {
        "nodal_diameter": (motion.nodal_diameter, {"units": "1"}),
        "rotor_wave_speed": (motion.rotor_wave_speed, speed | {"frame": "rotating"}),
        "casing_wave_speed": (motion.casing_wave_speed, speed | {"frame": "static"}),
    }
    if motion.nodal_diameter == 1:
        lead = float(np.degrees(motion.shaft_lead[-1]))
        found |= {
            "whirl_speed_rotating": (motion.whirl_speed, speed),
            "whirl_speed_static": (motion.whirl_speed_static, speed),
            "shaft_lead_degrees": (lead, {"units": "degrees"}),
        }
    return found


def motion_dataset(motion: CoupledMotion, *, reference: float) -> xr.Dataset:
    """Phases and amplitudes of a coupled mode in time, as measured from its fields.

    Args:
        motion: of the coupled mode.
        reference: frequency that speeds are multiples of [rad/s].
    """
    metre, radian = {"units": "m"}, {"units": "rad"}
    moves = motion.nodal_diameter == 1  # the only waves with a shaft phase
    nothing = np.full(len(motion.time), np.nan)
    static = motion.shaft_static
    phase = np.unwrap(np.arctan2(static[:, 1], static[:, 0])) if moves else nothing
    return xr.Dataset(
        data_vars={
            "shaft_phase": ("time", phase, radian),
            "smallest_clearance_phase": ("time", motion.smallest_clearance_angle, radian),
            "shaft_lead": ("time", motion.shaft_lead if moves else nothing, radian),
            "rotor_amplitude": ("time", np.abs(motion.rotor_wave), metre),
            "casing_amplitude": ("time", np.abs(motion.casing_wave), metre),
        },
        coords={"time": ("time", motion.time, {"units": "s"})},
        attrs={
            "title": "coupled mode in time, static frame",
            "nodal_diameter": motion.nodal_diameter,
            "speed": motion.speed,
            "reference_frequency": reference,
            "rotor_wave_speed": motion.rotor_wave_speed,  # rad/s, forward positive
            "casing_wave_speed": motion.casing_wave_speed,
        },
    )
