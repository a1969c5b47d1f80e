"""Animation of a run as one HTML file that a browser plays offline; surfaces can be turned.

The page contains points as 16-bit integers, colours as 8-bit integers, and the program that draws
them (`web_page.html`).
"""

import base64
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.files import write_atomically
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.enlarged import rounded_down
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import LOSS
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.points import Points
from bladewhirl.postprocess.fields.wheels import with_surfaces
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.colouring import Colouring
from bladewhirl.postprocess.pictures.drawing import Drawing, Picture
from bladewhirl.postprocess.pictures.films import Progress
from bladewhirl.postprocess.pictures.solids import sharp_edges, smooth_parts
from bladewhirl.postprocess.pictures.symbols import MASS
from bladewhirl.postprocess.plotting.files import checked_target, filled_template

FULL = 32767  #: largest signed number of 16 bits
SHADES = 112  #: colours of each scale; those of the wall and of solids follow those of the rotor
BAR_SHARE = 0.15  #: longest scale bar, relative to the picture
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
    write_atomically(target, film_page(dataset, records, progress=progress, **view))
    return target


def film_page(
    dataset: xr.Dataset, records: IntArray, *, progress: Progress | None = None, **view: Any
) -> str:
    """Return the text of the page, see `render_page`."""
    dataset = with_surfaces(dataset)
    drawing = Drawing(dataset, records, **view)
    stage, contact = drawing.reach()
    size = max(stage, contact / (1 - look.LONGEST_ARROW)) * look.MARGIN
    places, shades, layout = _pack(drawing, size, progress)
    about = {
        **_instants(dataset, drawing),
        **_looks(drawing.colouring),
        "strokes": [
            [name, width * FULL / look.MARGIN, shade]
            for name, width, shade, _ in look.strokes_of(drawing.picture(0).symbols)
        ],
        **(_orbit(dataset, drawing) if has(dataset, "centre") else {}),
        "layout": layout,
        "casingShades": drawing.picture(0).rotor.values.size,
        "surfaceShades": shades.shape[1] - layout["surface"][1] - layout["nodes"][1],
        "nodeShades": shades.shape[1] - layout["nodes"][1],
        "solidColours": [solid.colour for solid in drawing.solids if solid.shows is None],
        "marks": drawing.around,
        "bar": _bar(drawing, size),
        **_members(drawing.points),
        "bladeOf": dataset["blade"].values.tolist(),
        "largestForce": handy(float(drawing.total_force.max()), "N", 3),
        "force": [float(f"{force:.4g}") for force in drawing.total_force],
    }
    colouring = drawing.colouring
    return filled_template(
        "bladewhirl.postprocess.pictures",
        "web_page.html",
        title=str(dataset.attrs["title"]),
        notes="\n".join(
            [
                f"{drawing.frame} frame",
                look.enlargement(drawing.exaggeration),
                *([str(dataset.attrs[LOSS])] if LOSS in dataset.attrs else []),
                *drawing.discs,
                *([] if drawing.solids else drawing.dots),
            ]
        ),
        key=colouring.parts and list(colouring.parts.items()),
        quantity=colouring.name,
        scales=[
            (label, scale.shades(9), [f"{tick:.3g}" for tick in np.linspace(*scale.limits, 5)])
            for label, scale in ({} if colouring.parts else colouring.scales).items()
        ],
        ink=look.INK,
        faint=look.FAINT,
        force=look.FORCE_COLOUR,
        about=about,
        turns=bool(drawing.solids),
        triangles=_packed(np.stack(_triangles(drawing)).astype("<i4")),
        edges=_packed(_edges(drawing).astype("<u4")),
        places=_packed(places),
        shades=_packed(shades),
    )


def _pack(
    drawing: Drawing, size: float, progress: Progress | None
) -> tuple[Array, Array, dict[str, list[int]]]:
    """Return the points (record, coordinate), the shades (record, station), and the layout of a
    record: the offset and shape of each array of points, by name. Shades are those of the shapes
    rotor, casing and surface."""
    places, shades, layout = [], [], dict[str, list[int]]()
    for index in range(len(drawing)):
        picture = drawing.picture(index)
        shapes = _shapes(drawing, picture, size)
        if not layout:
            first = 0
            for name, values in shapes.items():
                layout[name] = [first, *values.shape]
                first += values.size
        places.append(np.concatenate([values.ravel() for values in shapes.values()]))
        shades.append(_picture_shades(drawing, picture))
        if progress is not None:
            progress(index + 1, len(drawing))
    scaled = np.clip(np.round(FULL / size * np.array(places)), -FULL, FULL)  # depth may be larger
    return scaled.astype("<i2"), np.array(shades), layout


def _triangles(drawing: Drawing) -> tuple[IntArray, IntArray]:
    """Return the points of each triangle of the solids, counter-clockwise as seen from outside, and
    the number of the corner in a smooth part, which has its own normal, (triangle, 3) each."""
    none = np.zeros((0, 3), dtype=np.int64)
    faces, parts, point, part = [none], [none], 0, 0
    for solid, (points, _) in zip(drawing.solids, drawing.picture(0).solids, strict=True):
        smooth, origin = smooth_parts(points, solid.triangles)
        faces.append(point + origin[smooth])
        parts.append(part + smooth)
        point += len(points)
        part += len(origin)
    return np.concatenate(faces), np.concatenate(parts)


def _edges(drawing: Drawing) -> IntArray:
    """Return the end points (edge, 2) of the sharp edges of the solids."""
    first, found = 0, [np.zeros((0, 2), dtype=np.int64)]
    for solid, (points, _) in zip(drawing.solids, drawing.picture(0).solids, strict=True):
        found.append(first + sharp_edges(points, solid.triangles))
        first += len(points)
    return np.concatenate(found)


def _picture_shades(drawing: Drawing, picture: Picture) -> NDArray[np.uint8]:
    """Return the shades of rotor, casing, solids and contact nodes; those of solids with a colour
    of their own follow the colours of the scale."""
    colouring = drawing.colouring
    shades = [
        _shades(colouring, ribbon.values.ravel(), of_wall=ribbon is picture.casing)
        for ribbon in (picture.rotor, picture.casing)
    ]
    following = len(_colours(colouring))
    for solid, placed in zip(drawing.solids, picture.solids, strict=True):
        if solid.shows:
            shades.append(_shades(colouring, placed.values, of_wall=solid.shows == "wall"))
        else:
            shades.append(np.full(len(placed.points), following, dtype=np.uint8))
            following += 1
    return np.concatenate([*shades, _shades(colouring, picture.tip_values, of_wall=False)])


def _packed(values: NDArray[Any]) -> str:
    """Return an array compressed, as text."""
    return base64.b64encode(zlib.compress(values.tobytes())).decode()


def _members(wheels: Sequence[Points]) -> dict[str, list[str]]:
    """Return the name of the member that each beam and each point of the surfaces belongs to."""
    first = wheels[0]
    beams = [first.members[number] for number in first.stations(first.member)[:, 0]]
    surfaces = [points for points in wheels if not points.flat]
    of_points = [points.members[number] for points in surfaces for number in points.member]
    return {"members": beams, "ofPoints": of_points}


def _shapes(drawing: Drawing, picture: Picture, size: float) -> Mapping[str, Array]:
    """Return the points of all drawn shapes, by the name of the shape [m]."""
    return {
        "rotor": picture.rotor.sides,
        "casing": picture.casing.sides,
        "surface": np.concatenate([np.zeros((0, 3)), *(each.points for each in picture.solids)]),
        **{name: strokes for name, _, _, strokes in look.strokes_of(picture.symbols)},
        "masses": picture.symbols.masses,
        "nodes": picture.tip_places,
        "pushes": _metres_per_newton(drawing, size) * picture.pushes,
        "shaft": picture.shaft,
        "mark": picture.mark,
    }


def _colours(colouring: Colouring) -> list[str]:
    """Return the colours of rotor and wall; those of parts are the same for both."""
    if colouring.parts is not None:
        return [*colouring.parts.values()]
    return [*colouring.disk.shades(SHADES), *colouring.wall.shades(SHADES)]


def _shades(colouring: Colouring, values: Array, *, of_wall: bool) -> Array:
    """Return the number of the colour of each value; `NONE` for NaN."""
    scale = colouring.wall if of_wall else colouring.disk
    (low, high), last, first = scale.limits, SHADES - 1, SHADES * of_wall
    if colouring.parts is not None:
        low, high, last, first = 0.0, len(colouring.parts) - 1.0, len(colouring.parts) - 1, 0
    share = (scale.factor * values - low) / (high - low)
    missing = ~np.isfinite(share)
    shades = first + np.round(last * np.clip(np.where(missing, 0.0, share), 0.0, 1.0))
    return np.where(missing, NONE, shades).astype(np.uint8)


def _bar(drawing: Drawing, size: float) -> dict[str, Any]:
    """Return length and text of the scale bar."""
    length = rounded_down(2.0 * BAR_SHARE * size)
    words = look.bar_text(
        length, "motion, clearance", drawing.exaggeration, _metres_per_newton(drawing, size)
    )
    return {"length": length / size * FULL, "text": words.splitlines()}


def _metres_per_newton(drawing: Drawing, size: float) -> float:
    """Return the length of arrows."""
    return look.metres_per_newton(drawing.largest_force, size / look.MARGIN)


def _instants(dataset: xr.Dataset, drawing: Drawing) -> dict[str, Any]:
    """Return for each picture its time, texts about speed and contact, lost blades, and 1 for each
    contact node in contact, else 0; and the picture with the largest force, which is shown first.
    """
    pictures = [drawing.picture(index) for index in range(len(drawing))]
    blades, reference = dataset["blade"].values, float(dataset.attrs["reference_frequency"])
    return {
        "first": int(np.argmax([np.linalg.norm(picture.forces) for picture in pictures])),
        "times": [look.time_text(time, drawing.record_step) for time in drawing.times],
        "speeds": [
            look.speed_text(reference, picture.speed) if picture.speed else ""
            for picture in pictures
        ],
        "contact": [look.contact_text(one.blade_forces, drawing.record_step) for one in pictures],
        "lost": [np.unique(blades[lost]).tolist() for lost in drawing.lost],
        "touching": [np.any(picture.pushes, axis=1).astype(int).tolist() for picture in pictures],
    }


def _looks(colouring: Colouring) -> dict[str, Any]:
    """Return colours, and sizes in the units of the integer points."""
    unit = FULL / look.MARGIN
    return {
        "ink": look.INK,
        "faint": look.FAINT,
        "force_colour": look.FORCE_COLOUR,
        "none": look.NO_VALUE,
        "massColour": look.MASS_COLOUR,
        "outline": look.OUTLINE * unit,
        "hub": look.HUB * unit,
        "markSize": look.MARK * unit,
        "disc": look.CONTACT_DISC * unit,
        "arrow": look.ARROW_WIDTH * unit,
        "nodeDisc": look.NODE_DISC * unit,
        "mass": MASS * unit,
        "colours": _colours(colouring),
        "scales": [[*scale.limits, scale.unit] for scale in (colouring.disk, colouring.wall)],
        "perScale": SHADES,
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
