"""The stage at one record as polygons for a panel of a figure, without VTK."""

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap, Normalize, to_rgb

from bladewhirl.meshes.plane import unit
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.choices import Field
from bladewhirl.postprocess.pictures.drawing import Drawing, Ribbon, Surface, arrows, widened
from bladewhirl.postprocess.plotting.style import COLOURS

LAMP = unit(np.array([-0.35, 0.5, 0.8]))  #: direction to the lamp, in the axes of the picture
FINE = 4000  #: triangles of a surface are halved until there are as many
AMBIENT = 0.55  #: brightness of a surface that the lamp does not reach


def flat_stage(dataset: xr.Dataset, record: int, colour: Field) -> xr.Dataset:
    """Return the stage at a record as polygons, the farthest first.

    Returns:
        Dataset: `outline` (polygon, corner, axis) [m] as drawn, `value` (polygon,) of the field in
        the unit of the scale, nan without a value (the wall), and `shade` (polygon, rgb);
        `arrow` (contact_node, arrow_corner, axis) [m], outlines of contact forces. Attributes: the
        scale with `label`, `low`, `high` and `colours`, and the text `notes`.
    """
    drawing = Drawing(dataset, np.array([record]), colour=colour)
    picture, field = drawing.picture(0), drawing.colouring
    scale = field.disk
    reach = max(drawing.reach())
    outlines, values, shades = [], [], []

    def add(corners: Array, found: Array, fixed: str | None, light: Array | float) -> None:
        """Add polygons of corners (polygon, 4, 2) with values of the field or a fixed colour."""
        norm = Normalize(*scale.limits)
        face = scale.colours(norm(np.nan_to_num(scale.factor * found)))[:, :3]
        face[np.isnan(found)] = to_rgb(look.NO_VALUE)
        face = face if fixed is None else np.full_like(face, to_rgb(fixed))
        outlines.append(corners)
        values.append(np.full(len(corners), np.nan) if fixed else scale.factor * found)
        shades.append(face * np.reshape(light, (-1, 1)))

    if len(picture.surface.points):
        depth = []
        bodies: list[tuple[Surface, IntArray, str | None]]
        bodies = [(picture.surface, drawing.triangles, None)]
        bodies += [
            (placed, solid.triangles, solid.colour)
            for placed, solid in zip(picture.solids, drawing.solids, strict=True)
        ]
        for surface, triangles, fixed in bodies:
            corner, values_at = surface.points[triangles], surface.values[triangles]
            normal = _normals(corner, triangles)
            front = normal[:, 2] > 0.0
            corner = np.dstack([corner, values_at, np.repeat(normal[:, None], 3, axis=1)])[front]
            while fixed is None and 0 < len(corner) < FINE:
                corner = _halved(corner)
            light = AMBIENT + (1.0 - AMBIENT) * np.maximum(corner[:, 0, 4:] @ LAMP, 0.0)
            add(corner[:, [0, 1, 2, 2], :2], corner[..., 3].mean(axis=1), fixed, light)
            depth.append(corner[..., 2].mean(axis=1))
        order = np.argsort(np.concatenate(depth), kind="stable")
    else:
        edge = look.OUTLINE * reach
        for ribbon in (picture.casing, picture.rotor):
            rim, _ = _ribbon(replace(ribbon, sides=widened(ribbon.sides, edge, edge)))
            add(rim, np.full(len(rim), np.nan), look.INK, 1.0)
            add(*_ribbon(ribbon), COLOURS["casing"] if ribbon is picture.casing else None, 1.0)
        order = np.arange(sum(map(len, outlines)))
    length = look.metres_per_newton(drawing.largest_force, reach)
    notes = [f"{look.time_text(picture.time, drawing.record_step)}, {drawing.frame} frame"]
    notes.append(look.enlargement(drawing.exaggeration).replace("\n", " "))
    if drawing.largest_force:
        notes.append(f"longest arrow: {handy(drawing.largest_force, 'N', 3)} with friction")
    attributes: dict[str, Any] = {
        "label": f"{field.name} [{scale.unit}]",
        "low": scale.limits[0],
        "high": scale.limits[1],
        "colours": scale.shades(256),
        "notes": "\n".join(notes),
    }
    return xr.Dataset(
        {
            "outline": (("polygon", "corner", "axis"), np.concatenate(outlines)[order]),
            "value": ("polygon", np.concatenate(values)[order]),
            "shade": (("polygon", "rgb"), np.concatenate(shades)[order]),
            "arrow": (
                ("contact_node", "arrow_corner", "axis"),
                arrows(picture.tips, picture.forces, length, look.ARROW_WIDTH * reach),
            ),
        },
        attrs=attributes,
    )


def _normals(corner: Array, triangles: IntArray) -> Array:
    """Return the normals of the triangles of a body (triangle, 3), outward if its surface is closed
    and all triangles are in the same sense, else towards the viewer."""
    normal = unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    edges = np.concatenate([triangles, np.roll(triangles, -1, axis=1)]).reshape(2, -1).T
    if len(np.unique(edges, axis=0)) == len(np.unique(np.vstack([edges, edges[:, ::-1]]), axis=0)):
        volume = np.sum(corner[:, 0] * np.cross(corner[:, 1], corner[:, 2]))
        return np.asarray(normal * np.sign(volume))
    return np.asarray(normal * np.sign(normal[:, 2:]))


def _halved(corner: Array) -> Array:
    """Return triangles whose sides are halves of those of triangles (triangle, 3, quantity), with
    linear quantities, (4 triangles, 3, quantity)."""
    middle = 0.5 * (corner + np.roll(corner, -1, axis=1))
    parts = [(corner[:, n], middle[:, n], middle[:, n - 1]) for n in range(3)]
    corners = [np.stack(part, axis=1) for part in parts]
    return np.concatenate([*corners, middle])


def _ribbon(ribbon: Ribbon) -> tuple[Array, Array]:
    """Return both halves of the pieces of ribbons (polygon, 4, 2), and their values."""
    sides, found = ribbon.sides, ribbon.values
    middle = sides.mean(axis=2)
    corners, values = [], []
    for side in (0, 1):
        outer = sides[:, :, side]
        around = [outer[:, :-1], outer[:, 1:], middle[:, 1:], middle[:, :-1]]
        corners.append(np.stack(around, axis=2).reshape(-1, 4, 2))
        values.append(0.5 * (found[:, :-1, side] + found[:, 1:, side]).ravel())
    return np.concatenate(corners), np.concatenate(values)


def draw_flat(axes: Axes, stage: xr.Dataset) -> None:
    """Draw a stage from `flat_stage` in a panel, with its colour bar and contact forces."""
    shade = stage["shade"].values
    look_of: dict[str, Any] = {"facecolors": shade, "edgecolors": shade, "linewidths": 0.2}
    axes.add_collection(PolyCollection([*stage["outline"].values], rasterized=True, **look_of))
    axes.add_collection(PolyCollection([*stage["arrow"].values], facecolors=look.FORCE_COLOUR))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()
    scale = Normalize(stage.attrs["low"], stage.attrs["high"])
    bar = ScalarMappable(scale, ListedColormap(stage.attrs["colours"]))
    axes.figure.colorbar(
        bar, ax=axes, location="bottom", label=stage.attrs["label"], shrink=0.6, aspect=35, pad=0.02
    )
