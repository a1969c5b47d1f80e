"""Figures and films of the divergent mode at one speed and coupling stiffness."""

from pathlib import Path

import numpy as np

from bladewhirl.files import claim, replacing, write_atomically
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.errors import writing
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.modal.coupled_modes import plot_phases, plot_shapes
from bladewhirl.postprocess.modal.motion import coupled_mode_motion
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.pictures.render import animation_records, render_animation
from bladewhirl.postprocess.shaft.orbits import plot_orbit, shaft_orbit
from bladewhirl.solvers.stability.coupled_modes import CoupledMotion
from bladewhirl.studies.modal.coupled_system import EvenSystem
from bladewhirl.studies.modal.stability import divergent_motion, fastest_mode, motion_dataset
from bladewhirl.studies.runs.figures_folder import save_figures
from bladewhirl.studies.runs.folder import case_files

ANIMATION = "animation.gif"
MOTION_NAME = "mode.nc"

SHAPES = 4  #: number of deformed shapes, over one turn of the whirl


def draw_coupled_mode(
    system: EvenSystem,
    omega: float,
    kappa: float,
    folder: Path,
    *,
    films: bool,
    overwrite: bool = False,
) -> None:
    """Draw the motion of the fastest growing coupled mode into a folder, with its data.

    At the speed omega [rad/s] and the spring stiffness kappa [N/m] a mode must grow. With `films`,
    a VTK series and a GIF are also written; with `overwrite`, files that bladewhirl did not write
    are replaced.

    Raises:
        UserError: a file cannot be written, or exists and was not written by bladewhirl.
    """
    part = system.of_diameter(fastest_mode(system, omega, kappa).nodal_diameter)
    stage = part.stage
    motion = divergent_motion(part, omega, kappa)
    texts = case_files(stage.modal.case)
    moving = coupled_mode_motion(stage, motion, kappa)
    moving = moving.assign_attrs(case=stage.modal.case.title, kappa=kappa)
    with writing(folder):
        names = [*texts, MOTION_NAME, *([ANIMATION] if films else [])]
        claim(folder, names, overwrite=overwrite)
        for name, content in texts.items():
            write_atomically(folder / name, content)
        with replacing(folder / MOTION_NAME) as draft:
            moving.to_netcdf(draft, engine="h5netcdf")
    measured = motion_dataset(motion, reference=system.reference).assign_attrs(
        case=stage.modal.case.title, kappa=kappa
    )
    records = _one_whirl(motion)
    shapes = moving.isel(time=records)[["gap", "rotor_displacement", "casing_displacement"]]
    figures = {
        "phases": (plot_phases(measured), measured),
        "shapes": (plot_shapes(moving, records), shapes),
    }
    if motion.nodal_diameter == 1:
        title = f"{stage.modal.case.title}, κ = {handy(kappa, 'N/m', 4)}"
        orbit = shaft_orbit(moving).assign_attrs(case_title=title, kappa=kappa)
        figures["orbit"] = plot_orbit(orbit), orbit
    save_figures(folder, figures, overwrite=overwrite)
    if films:
        with writing(folder):
            export_vtk(moving, folder / "vtk", overwrite=overwrite)
            render_animation(moving, folder / ANIMATION, animation_records(moving))


def _one_whirl(motion: CoupledMotion) -> IntArray:
    """Return indices of records over the last turn of the rotor's wave in the static frame."""
    rate = abs(motion.rotor_wave_speed + motion.speed)
    span = min(2.0 * np.pi / rate if rate else np.inf, motion.time[-1])
    instants = motion.time[-1] - span * np.arange(SHAPES)[::-1] / SHAPES
    return np.asarray(np.searchsorted(motion.time, instants), dtype=np.int64)
