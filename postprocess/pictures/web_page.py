"""Animation of a run as one HTML file that a browser plays offline.

The page contains points as 16-bit integers, colours as 8-bit integers, and the program that draws
them (`web_page.html`).
"""

import base64
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.files import write_atomically
from bladewhirl.postprocess.fields.blades import member_names
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.colouring import Colouring
from bladewhirl.postprocess.pictures.drawing import Drawing, Picture, arrows
from bladewhirl.postprocess.pictures.films import Progress
from bladewhirl.postprocess.pictures.symbols import MASS
from bladewhirl.postprocess.plotting.files import checked_target, filled_template

FULL = 32767  #: largest signed number of 16 bits
SHADES = 128
NONE = 255  #: shade of stations without a value


def render_page(
    dataset: xr.Dataset,
    path: str | Path,
    records: IntArray,
    *,
    progress: Progress | None = None,
    **view: Any,
) -> Path:
    """Write an animation of records (see `animation_records`) as an HTML page; return the path.

    `view` is exaggeration, frame and colour, see `Drawing`; see `films.Progress` for `progress`.

    Raises:
        ViewError: the path does not end in .html.
    """
    target = checked_target(path, ".html")
    drawing = Drawing(dataset, records, **view)
    stage, contact = drawing.reach()
    size = max(stage, contact / (1 - look.LONGEST_ARROW)) * look.MARGIN
    places, shades, layout = _pack(drawing, size, progress)
    names, member = member_names(dataset)
    about = {
        **_instants(drawing),
        **_looks(drawing.colouring),
        "strokes": [
            [name, width * FULL / look.MARGIN, shade]
            for name, width, shade, _ in look.strokes_of(drawing.picture(0).symbols)
        ],
        **_orbit(dataset, drawing),
        "layout": layout,
        "casingShades": drawing.colouring.rotor[0].size,
        "members": [names[number] for number in member],  # of each beam
    }
    colouring = drawing.colouring
    text = filled_template(
        "bladewhirl.postprocess.pictures",
        "web_page.html",
        title=str(dataset.attrs["title"]),
        notes=f"{look.speed_text(dataset)}\n{drawing.frame} frame\n"
        + look.enlargement(drawing.exaggeration),
        key=colouring.parts and list(colouring.parts.items()),
        scale=f"{colouring.name} [{colouring.unit}]",
        ticks=[f"{tick:.3g}" for tick in np.linspace(*colouring.limits, 5)],
        ink=look.INK,
        faint=look.FAINT,
        force=look.FORCE_COLOUR,
        about=about,
        places=base64.b64encode(zlib.compress(places.tobytes())).decode(),
        shades=base64.b64encode(zlib.compress(shades.tobytes())).decode(),
    )
    write_atomically(target, text)
    return target


def _pack(
    drawing: Drawing, size: float, progress: Progress | None
) -> tuple[Array, Array, dict[str, list[int]]]:
    """Return the points (record, coordinate), the shades (record, station), and the layout of a
    record: the offset and shape of each array of points, by name."""
    places, shades, layout = [], [], dict[str, list[int]]()
    for index in range(len(drawing)):
        shapes = _shapes(drawing, drawing.picture(index), size)
        if not layout:
            first = 0
            for name, values in shapes.items():
                layout[name] = [first, *values.shape]
                first += values.size
        places.append(np.concatenate([values.ravel() for values in shapes.values()]))
        rotor, casing = drawing.colouring.rotor[index], drawing.colouring.casing[index]
        values = np.concatenate([rotor.ravel(), casing.ravel(), casing[0]])
        shades.append(_shades(drawing.colouring, values))
        if progress is not None:
            progress(index + 1, len(drawing))
    scaled = np.round(FULL / size * np.array(places))
    return scaled.astype("<i2"), np.array(shades), layout


def _shapes(drawing: Drawing, picture: Picture, size: float) -> Mapping[str, Array]:
    """Return the points of all drawn shapes, by the name of the shape [m]."""
    force = drawing.largest_force
    length = look.LONGEST_ARROW * size / look.MARGIN / force if force else 0.0
    return {
        "rotor": picture.rotor.sides,
        "casing": picture.casing.sides,
        **{name: strokes for name, _, _, strokes in look.strokes_of(picture.symbols)},
        "masses": picture.symbols.masses,
        "arrows": arrows(picture.tips, picture.forces, length, look.ARROW_WIDTH * size),
        "tips": picture.tips,
        "shaft": picture.shaft,
        "mark": picture.mark,
    }


def _shades(colouring: Colouring, values: Array) -> Array:
    """Return the number of the colour of each value; `NONE` for NaN."""
    low, high = colouring.limits
    if colouring.parts is not None:
        low, high = 0.0, len(colouring.parts) - 1.0
    last = len(colouring.colours(SHADES)) - 1
    share = (colouring.scale * values - low) / (high - low)
    missing = ~np.isfinite(share)
    shades = np.round(last * np.clip(np.where(missing, 0.0, share), 0.0, 1.0))
    return np.where(missing, NONE, shades).astype(np.uint8)


def _instants(drawing: Drawing) -> dict[str, Any]:
    """Return for each picture its time, the text about contact, and 1 for each blade in contact,
    else 0."""
    forces = [drawing.picture(index).forces for index in range(len(drawing))]
    return {
        "times": [f"t = {1e3 * time:.1f} ms" for time in drawing.times],
        "contact": [look.contact_text(force) for force in forces],
        "touching": [np.any(force, axis=1).astype(int).tolist() for force in forces],
    }


def _looks(colouring: Colouring) -> dict[str, Any]:
    """Return colours, and sizes in the units of the integer points."""
    unit = FULL / look.MARGIN
    return {
        "ink": look.INK,
        "faint": look.FAINT,
        "force": look.FORCE_COLOUR,
        "none": look.NO_VALUE,
        "massColour": look.MASS_COLOUR,
        "outline": look.OUTLINE * unit,
        "hub": look.HUB * unit,
        "markSize": look.MARK * unit,
        "disc": look.CONTACT_DISC * unit,
        "mass": MASS * unit,
        "colours": colouring.colours(SHADES),
        "limits": list(colouring.limits),
        "unit": colouring.unit,
        "value": colouring.parts is None,
    }


def _orbit(dataset: xr.Dataset, drawing: Drawing) -> dict[str, Any]:
    """Return the orbit of the shaft from the first to the last picture, the title of the orbit, and
    the position of each picture in the orbit."""
    records = np.arange(drawing.records.min(), drawing.records.max() + 1)
    places, title = look.shaft_trail(dataset, records, drawing.frame)
    return {
        "orbit": np.round(places, 4).tolist(),
        "orbitPlace": (drawing.records - records[0]).tolist(),
        "orbitTitle": title,
    }
