"""What a result says: fields, series for ParaView, pictures; results are read, never made."""

from bladewhirl.postprocess.drawing import Drawing
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
from bladewhirl.postprocess.render import animation_records, render_animation, render_still
from bladewhirl.postprocess.vtk_series import SeriesWriter, undeformed_mesh, write_vtk

__all__ = [
    "Drawing",
    "OffScreenError",
    "SeriesWriter",
    "ViewError",
    "animation_records",
    "casing_field",
    "casing_points",
    "contact_forces",
    "frame_records",
    "render_animation",
    "render_still",
    "rotor_field",
    "rotor_points",
    "sampling_hint",
    "undeformed_mesh",
    "write_vtk",
]
