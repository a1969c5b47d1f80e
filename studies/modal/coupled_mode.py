"""Motion of the divergent mode at one speed and coupling stiffness, and its measures."""

from __future__ import annotations

from typing import Any

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
from bladewhirl.studies.modal.columns import quantity
from bladewhirl.studies.modal.coupled_system import EvenSystem

RECORDS_PER_TURN = 48
"""Number of records in a turn: twice that of a smooth animation."""

GROWTHS = 2.5
"""Logarithm of the growth of the amplitude over the motion shown, if the numbers of turns
permit."""

FEWEST_TURNS, MOST_TURNS = 3, 40
"""Smallest and largest number of turns of the rotor in the motion shown."""


def fastest_mode(system: EvenSystem, omega: float, kappa: float) -> CoupledMode:
    """Return the fastest growing coupled mode at a point."""
    return coupled_modes(system.modes, speed=omega, kappa=kappa, with_pi=system.with_pi)[0]


def divergent_motion(system: EvenSystem, omega: float, kappa: float) -> CoupledMotion:
    """Compute the motion of the fastest growing coupled mode, until the clearance is closed."""
    mode = fastest_mode(system, omega, kappa)
    return coupled_motion(
        mode,
        time=whirl_records(mode),
        shapes=radial_shapes(system.stage),
        clearance=shown_clearance(system.stage.modal),
    )


def whirl_records(mode: CoupledMode) -> FloatArray:
    """Return instants of the motion of a growing mode [s], equally spaced."""
    turn = 2.0 * np.pi / abs(mode.speed)
    turns = float(np.clip(GROWTHS / mode.eigenvalue.real / turn, FEWEST_TURNS, MOST_TURNS))
    records = np.arange(round(turns * RECORDS_PER_TURN) + 1)
    return np.asarray(turn / RECORDS_PER_TURN * records, dtype=np.float64)


def motion_measures(motion: CoupledMotion) -> dict[str, Any]:
    """Return measures of the motion of a coupled mode as variables; speeds are forward positive."""
    speed = {"units": "rad/s"}
    measures: dict[str, Any] = {
        "nodal_diameter": quantity((), motion.nodal_diameter, "1"),
        "rotor_wave_speed": ((), motion.rotor_wave_speed, speed | {"frame": "rotating"}),
        "casing_wave_speed": ((), motion.casing_wave_speed, speed | {"frame": "static"}),
    }
    if motion.nodal_diameter == 1:
        lead = float(np.degrees(motion.shaft_lead[-1]))
        measures |= {
            "whirl_speed_rotating": ((), motion.whirl_speed, speed),
            "whirl_speed_static": ((), motion.whirl_speed_static, speed),
            "shaft_lead_degrees": quantity((), lead, "degrees"),
        }
    return measures


def motion_dataset(motion: CoupledMotion, *, reference: float) -> xr.Dataset:
    """Return phases and amplitudes of the motion of a coupled mode.

    Args:
        motion: motion of the coupled mode.
        reference: frequency by which speeds are normalised [rad/s].
    """
    moves = motion.nodal_diameter == 1  # only such waves move the shaft
    missing = np.full(len(motion.time), np.nan)
    static = motion.shaft_static
    phase = np.unwrap(np.arctan2(static[:, 1], static[:, 0])) if moves else missing
    place = motion.smallest_clearance_angle
    return xr.Dataset(
        data_vars={
            "shaft_phase": quantity("time", phase, "rad"),
            "smallest_clearance_phase": quantity("time", place, "rad"),
            "shaft_lead": quantity("time", motion.shaft_lead if moves else missing, "rad"),
            "rotor_amplitude": quantity("time", np.abs(motion.rotor_wave), "m"),
            "casing_amplitude": quantity("time", np.abs(motion.casing_wave), "m"),
        },
        coords={"time": quantity("time", motion.time, "s")},
        attrs={
            "title": "coupled mode in time, static frame",
            "nodal_diameter": motion.nodal_diameter,
            "speed": motion.speed,
            "reference_frequency": reference,
            "rotor_wave_speed": motion.rotor_wave_speed,  # rad/s, forward positive
            "casing_wave_speed": motion.casing_wave_speed,
        },
    )
