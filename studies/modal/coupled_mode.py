"""The divergent mode at one speed and coupling stiffness, in time: figures and films."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.coupling.stage_modes import StageModes
from bladewhirl.postprocess.modal.coupled_modes import (
    motion_dataset,
    plot_orbits,
    plot_phases,
    plot_shapes,
)
from bladewhirl.postprocess.modal.motion import (
    coupled_mode_motion,
    radial_shapes,
    shown_clearance,
)
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.pictures.render import animation_records, render_animation
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.postprocess.run.orbits import shaft_orbit
from bladewhirl.solvers.stability.coupled_modes import CoupledMode, CoupledMotion, coupled_motion
from bladewhirl.studies.runs.folder import case_files

ANIMATION = "animation.gif"
MOTION_NAME = "mode.nc"

RECORDS_PER_TURN = 48
"""Twice what a smooth animation needs."""

GROWTHS = 2.5
"""The motion shown grows by exp of this, ..."""

FEWEST_TURNS, MOST_TURNS = 3, 40
"""... within these numbers of turns of the rotor."""

SHAPES = 4
"""Deformed shapes side by side, over one turn of the whirl."""


def whirl_records(mode: CoupledMode) -> FloatArray:
    """Instants at which a growing mode is shown [s], equally spaced."""
    turn = 2.0 * np.pi / abs(mode.speed)
    turns = float(np.clip(GROWTHS / mode.eigenvalue.real / turn, FEWEST_TURNS, MOST_TURNS))
    records = np.arange(round(turns * RECORDS_PER_TURN) + 1)
    return np.asarray(turn / RECORDS_PER_TURN * records, dtype=np.float64)


def draw_coupled_mode(
    stage: StageModes,
    mode: CoupledMode,
    springs: CouplingSprings,
    folder: Path,
    *,
    reference: float,
    films: bool,
) -> CoupledMotion:
    """Write all that shows a growing coupled mode in time into an existing folder.

    Args:
        stage: the coupled modes.
        mode: one that grows.
        springs: that couple these modes.
        folder: where to.
        reference: frequency that speeds are multiples of [rad/s].
        films: write a VTK series and a GIF too.
    """
    motion = coupled_motion(
        mode,
        time=whirl_records(mode),
        shapes=radial_shapes(stage),
        clearance=shown_clearance(stage.modal),
    )
    for name, content in case_files(stage.modal.case).items():
        (folder / name).write_bytes(content)
    moving = coupled_mode_motion(stage, motion, springs)
    moving.to_netcdf(folder / MOTION_NAME, engine="h5netcdf")
    measured = motion_dataset(motion, reference=reference)
    save_figure(plot_phases(measured), folder / "phases", measured)
    records = _one_whirl(motion)
    shapes = moving.isel(time=records)[["gap", "rotor_displacement", "casing_displacement"]]
    save_figure(plot_shapes(moving, records), folder / "shapes", shapes)
    if motion.nodal_diameter == 1:
        orbit = shaft_orbit(moving)
        save_figure(plot_orbits(orbit), folder / "orbit", orbit)
    if films:
        export_vtk(moving, folder / "vtk")
        render_animation(moving, folder / ANIMATION, animation_records(moving))
    return motion


def _one_whirl(motion: CoupledMotion) -> IntArray:
    """Records spread over the last turn of the wave on the rotor, as seen in the static frame."""
    rate = abs(motion.rotor_wave_speed + motion.speed)
    span = min(2.0 * np.pi / rate if rate else np.inf, motion.time[-1])
    instants = motion.time[-1] - span * np.arange(SHAPES)[::-1] / SHAPES
    return np.asarray(np.searchsorted(motion.time, instants), dtype=np.int64)
