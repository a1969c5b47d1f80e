"""Pictures of a run: one function for stills, sheets, films and pages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.errors import writing

if TYPE_CHECKING:
    import xarray as xr

    from bladewhirl.postprocess.pictures.choices import Field, Frame, View

SHEET_PICTURES = 9  #: default number of pictures of a sheet


def render(
    result: xr.Dataset | str | PathLike[str],
    path: str | Path,
    *,
    time: float | Sequence[float] | None = None,
    frames: int | None = None,
    start: float | None = None,
    end: float | None = None,
    exaggeration: float | None = None,
    frame: Frame | None = None,
    colour: Field = "deformation",
    view: View | None = None,
    orbit: bool = False,
    width: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Draw a run without a display; the suffix of the file selects the kind of picture. ``.gif``
    and ``.mp4`` are films, ``.html`` is a film for any browser with zoom and values at the pointer,
    ``.png`` is a still, or a sheet of stills if several times, a number of frames or a time window
    are given.

    Args:
        result: an open result, a run, the folder of a run, or its result.nc.
        path: path of the file; an older file is replaced.
        time: instant of a still, or instants of a sheet [s]; if None, a still shows the instant of
            the largest contact force.
        frames: number of pictures; if None, 120 in a film, 9 in a sheet.
        start: start of a film or a sheet [s]. Without start and end, a film is around the strongest
            contact, and a sheet covers the revolution with the strongest contact.
        end: end of a film or a sheet [s].
        exaggeration: factor on displacements and clearance, 1 for true size; automatic if None.
        frame: "static" or "rotating" axes; if None, static, and rotating for a single blade.
        colour: field that colours rotor and wall, such as "velocity"; strains and stresses are
            those of beams.
        view: direction of the view of a superelement: "oblique", the default, "axial" or "side";
            "line": the whole shaft line with the orbits at its bearings, the only view without
            blades.
        orbit: whether stills, GIF and MP4 have an inset with the orbit of the shaft.
        width: width of a still in print [m], in which all text has 7 points; if None, the still is
            a picture for screens.
        progress: called with the numbers of finished and of all pictures of a film.

    Returns:
        the path of the file.

    Raises:
        ResultError: the result does not exist.
        ViewError: the suffix or the view is unknown, a time or the window is invalid, the file of a
            superelement has no triangles, or it has no strains of its surface.
        OffScreenError: the system cannot draw without a display.
        UserError: the file cannot be written.
    """
    from bladewhirl.postprocess.fields.kinematics import ViewError, nearest_records
    from bladewhirl.postprocess.fields.result import opened
    from bladewhirl.postprocess.pictures import render as pictures
    from bladewhirl.postprocess.pictures.printed import print_still
    from bladewhirl.postprocess.pictures.shaft_line import is_line, largest_deflection, render_line
    from bladewhirl.postprocess.pictures.web_page import render_page

    target = Path(path)
    kind = target.suffix.lower()
    windowed = any(value is not None for value in (frames, start, end))
    if time is not None and (windowed or kind != ".png"):
        raise ViewError(
            f"{target}: omit time; it is allowed for .png only, without frames, start and end"
        )
    if width is not None and (orbit or windowed or kind != ".png" or isinstance(time, Sequence)):
        raise ViewError(f"{target}: omit width; it is allowed for a still without orbit only")
    look: dict[str, Any] = dict(exaggeration=exaggeration, frame=frame, colour=colour, view=view)
    with opened(result) as dataset, writing(target):
        if view == "line" or (is_line(dataset) and view is None):
            given: dict[str, Any] = {"frame": frame, "orbit": orbit, "width": width}
            given["colour"] = colour != "deformation"
            if unused := [name for name, value in given.items() if value]:
                raise ViewError(f"{', '.join(unused)}: not allowed for a picture of a shaft line")
            if kind != ".png":
                records = window_records(dataset, target, frames=frames, start=start, end=end)
            elif windowed or isinstance(time, Sequence):
                raise ViewError(f"{target}: expected a still or a film of a shaft line, no sheet")
            elif time is None:
                records = np.array([largest_deflection(dataset)])
            else:
                records = nearest_records(dataset, np.atleast_1d(time))
            return render_line(
                dataset, target, records, exaggeration=exaggeration, progress=progress
            )
        still = kind == ".png" and not windowed and not isinstance(time, Sequence)
        if time is not None:
            records = nearest_records(dataset, np.atleast_1d(time))
        elif still:
            records = np.array([pictures.strongest_contact(dataset)])
        else:
            records = window_records(dataset, target, frames=frames, start=start, end=end)
        if width is not None:
            return print_still(dataset, target, int(records[0]), width=width, **look)
        if still:
            return pictures.render_still(dataset, target, int(records[0]), orbit=orbit, **look)
        if kind == ".png":
            return pictures.render_sheet(dataset, target, records, **look)
        if kind == ".html":
            return render_page(dataset, target, records, progress=progress, **look)
        return pictures.render_animation(
            dataset, target, records, orbit=orbit, progress=progress, **look
        )


def window_records(
    result: xr.Dataset, path: Path, *, frames: int | None, start: float | None, end: float | None
) -> IntArray:
    """Return the records of a sheet if the path ends in .png, otherwise the records of a film."""
    from bladewhirl.postprocess.pictures import render as pictures

    if path.suffix.lower() == ".png":
        return pictures.sheet_records(result, frames or SHEET_PICTURES, start=start, end=end)
    return pictures.animation_records(result, frames=frames, start=start, end=end)
