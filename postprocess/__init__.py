"""What a result says: fields, series for ParaView, pictures; results are read, never made.

``open_result(folder)`` gives an xarray.Dataset; from it `shaft_orbit`, `tip_displacement`,
`strain_energies`, `stress_history`, `contact_maps`, `contact_classes`, `shaft_spectrum` and their
like make Datasets with named dimensions and units. ``RunFigures(result).draw(name)`` draws one of
`FIGURES`, `save_figure` keeps it with its data, `render_animation` and `write_vtk` show the stage.
"""

from bladewhirl.postprocess.blade_contact import contact_classes, contact_maps
from bladewhirl.postprocess.contact_side import contact_phase
from bladewhirl.postprocess.drawing import Drawing
from bladewhirl.postprocess.energies import plot_energy, strain_energies
from bladewhirl.postprocess.family_energies import cyclic_energies, family_energies
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
from bladewhirl.postprocess.picture_sheet import render_sheet
from bladewhirl.postprocess.poincare import poincare_map, state_space
from bladewhirl.postprocess.pyvista_blocks import stage_blocks
from bladewhirl.postprocess.regimes import Growth, Regime, classify
from bladewhirl.postprocess.render import animation_records, render_animation, render_still
from bladewhirl.postprocess.result import ResultError, open_result
from bladewhirl.postprocess.run_figures import FIGURES, RunFigures
from bladewhirl.postprocess.spectra import modal_lines, shaft_spectrogram, shaft_spectrum
from bladewhirl.postprocess.stage_picture import draw_stage, stage_at_rest
from bladewhirl.postprocess.stresses import plot_stress, stress_history
from bladewhirl.postprocess.style import save_figure
from bladewhirl.postprocess.summary import Summary, summarise, summary_table, write_summary
from bladewhirl.postprocess.sweep_figures import LEFT_BY_A_SWEEP, SWEEP_FIGURES, SweepFigures
from bladewhirl.postprocess.sweep_result import SweepError, open_sweep
from bladewhirl.postprocess.tip_motion import tip_displacement
from bladewhirl.postprocess.vtk_series import SeriesWriter, undeformed_mesh, write_vtk
from bladewhirl.postprocess.web_page import render_page
from bladewhirl.postprocess.whirling import whirl_history
from bladewhirl.postprocess.windows import late_part, select_window

__all__ = [
    "FIGURES",
    "LEFT_BY_A_SWEEP",
    "SWEEP_FIGURES",
    "Drawing",
    "Growth",
    "OffScreenError",
    "Regime",
    "ResultError",
    "RunFigures",
    "SeriesWriter",
    "Summary",
    "SweepError",
    "SweepFigures",
    "ViewError",
    "Whirl",
    "animation_records",
    "casing_field",
    "casing_points",
    "classify",
    "contact_classes",
    "contact_forces",
    "contact_maps",
    "contact_phase",
    "cyclic_energies",
    "draw_stage",
    "family_energies",
    "frame_records",
    "late_part",
    "modal_lines",
    "open_result",
    "open_sweep",
    "plot_energy",
    "plot_orbit",
    "plot_stress",
    "poincare_map",
    "render_animation",
    "render_page",
    "render_sheet",
    "render_still",
    "rotor_field",
    "rotor_points",
    "sampling_hint",
    "save_figure",
    "select_window",
    "shaft_orbit",
    "shaft_spectrogram",
    "shaft_spectrum",
    "stage_at_rest",
    "stage_blocks",
    "state_space",
    "strain_energies",
    "stress_history",
    "summarise",
    "summary_table",
    "tip_displacement",
    "undeformed_mesh",
    "whirl",
    "whirl_history",
    "write_summary",
    "write_vtk",
]
