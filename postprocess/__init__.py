"""What a result says: fields, series for ParaView, pictures; results are read, never made."""

from bladewhirl.postprocess.drawing import Drawing
from bladewhirl.postprocess.energies import plot_energy, strain_energies
from bladewhirl.postprocess.fields import (
    ViewError,
    casing_field,
    casing_points,
    contact_forces,
    frame_records,
    rotor_field,
    rotor_points,
    sampling_hint,
)
from bladewhirl.postprocess.off_screen import OffScreenError
from bladewhirl.postprocess.orbits import Whirl, plot_orbit, shaft_orbit, whirl
from bladewhirl.postprocess.regimes import Growth, Regime, classify
from bladewhirl.postprocess.render import animation_records, render_animation, render_still
from bladewhirl.postprocess.result import ResultError, open_result
from bladewhirl.postprocess.style import save_figure
from bladewhirl.postprocess.summary import Summary, summarise, summary_table, write_summary
from bladewhirl.postprocess.vtk_series import SeriesWriter, undeformed_mesh, write_vtk

__all__ = [
    "Drawing",
    "Growth",
    "OffScreenError",
    "Regime",
    "ResultError",
    "SeriesWriter",
    "Summary",
    "ViewError",
    "Whirl",
    "animation_records",
    "casing_field",
    "casing_points",
    "classify",
    "contact_forces",
    "frame_records",
    "open_result",
    "plot_energy",
    "plot_orbit",
    "render_animation",
    "render_still",
    "rotor_field",
    "rotor_points",
    "sampling_hint",
    "save_figure",
    "shaft_orbit",
    "strain_energies",
    "summarise",
    "summary_table",
    "undeformed_mesh",
    "whirl",
    "write_summary",
    "write_vtk",
]
