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
from bladewhirl.postprocess.fields.by_blade import blade_starts
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.wheels import with_surfaces
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.choices import Field
from bladewhirl.postprocess.pictures.colouring import Scale
from bladewhirl.postprocess.pictures.drawing import Drawing, Ribbon, arrows, number_places, widened
from bladewhirl.postprocess.plotting.style import OUTLINE

LAMP = unit(np.array([-0.35, 0.5, 0.8]))  #: direction to the lamp, in the axes of the picture
LEVELS = 128  #: number of colours of a scale
FINE = 4000  #: triangles of a surface are halved until there are as many
MOST_NUMBERS = 12  #: largest number of blades that are numbered
AMBIENT = 0.55  #: brightness of a surface that the lamp does not reach


def flat_stage(dataset: xr.Dataset, record: int, colour: Field) -> xr.Dataset:
    """Return the stage at a record as polygons, the farthest first.

    Returns:
        Dataset: `outline` (polygon, corner, axis) [m] as drawn, `value` (polygon,) of the field in
        the unit of its scale, nan without a value, and `shade` (polygon, rgb), the colour; `arrow`
        (contact_node, arrow_corner, axis) [m], outlines of contact forces; `number_place`
        (numbered, axis) [m], beside the tips that are seen; for the scales of
        rotor and wall, named by their labels, `limits` (scale, end) and `colours` (scale, level).
        The attribute `notes` is a text.
    """
    dataset = with_surfaces(dataset)
    drawing = Drawing(dataset, np.array([record]), colour=colour)
    picture, field = drawing.picture(0), drawing.colouring
    reach = max(drawing.reach())
    outlines, values, shades = [], [], []

    def add(corners: Array, found: Array, scale: Scale | str, light: Array | float) -> None:
        """Add polygons of corners (polygon, 4, 2) with values of the field, or a fixed colour."""
        if isinstance(scale, str):
            found, face = np.full(len(corners), np.nan), np.tile(to_rgb(scale), (len(corners), 1))
        else:
            found = scale.factor * found
            face = scale.colours(Normalize(*scale.limits)(np.nan_to_num(found)))[:, :3]
            face[np.isnan(found)] = to_rgb(look.NO_VALUE)
        outlines.append(corners)
        values.append(found)
        shades.append(face * np.reshape(light, (-1, 1)))

    if drawing.solids:
        depth = []
        for surface, solid in zip(picture.solids, drawing.solids, strict=True):
            corner, values_at = (each[solid.triangles] for each in surface)
            normal, scale = _normals(corner, solid.triangles), field.shade(solid)
            front = normal[:, 2] > 0.0
            corner = np.dstack([corner, values_at, np.repeat(normal[:, None], 3, axis=1)])[front]
            while not isinstance(scale, str) and 0 < len(corner) < FINE:
                corner = _halved(corner)
            light = AMBIENT + (1.0 - AMBIENT) * np.maximum(corner[:, 0, 4:] @ LAMP, 0.0)
            add(corner[:, [0, 1, 2, 2], :2], corner[..., 3].mean(axis=1), scale, light)
            depth.append(corner[..., 2].mean(axis=1))
        order = np.argsort(np.concatenate(depth), kind="stable")
    else:
        edge = look.OUTLINE * reach
        for ribbon, scale in ((picture.casing, field.wall), (picture.rotor, field.disk)):
            rim, none = _ribbon(replace(ribbon, sides=widened(ribbon.sides, edge, edge)))
            add(rim, none, look.INK, 1.0)
            add(*_ribbon(ribbon), scale, 1.0)
        order = np.arange(sum(map(len, outlines)))
    length = look.metres_per_newton(drawing.largest_force, reach)
    notes = [f"{look.time_text(picture.time, drawing.record_step)}, {drawing.frame} frame"]
    notes.append(look.enlargement(drawing.exaggeration).replace("\n", " "))
    if drawing.largest_force:
        notes.append(f"longest arrow: {handy(drawing.largest_force, 'N', 3)} with friction")
    scales = field.scales
    if not scales:
        notes.append(field.name.replace("\n", " "))
    return xr.Dataset(
        {
            "outline": (("polygon", "corner", "axis"), np.concatenate(outlines)[order]),
            "value": ("polygon", np.concatenate(values)[order]),
            "shade": (("polygon", "rgb"), np.concatenate(shades)[order]),
            "limits": (("scale", "end"), np.reshape([s.limits for s in scales.values()], (-1, 2))),
            "colours": (
                ("scale", "level"),
                np.reshape([one.shades(LEVELS) for one in scales.values()], (len(scales), -1)),
            ),
            "arrow": (
                ("contact_node", "arrow_corner", "axis"),
                arrows(picture.tips, picture.forces, length, look.ARROW_WIDTH * reach),
            ),
            "number_place": (
                ("numbered", "axis"),
                number_places(picture, blade_starts(dataset), reach),
            ),
        },
        {"scale": [f"{field.name}, {label}" for label in scales]},
        {"notes": "\n".join(notes)},
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
    """Draw a stage from `flat_stage` in a panel, with its contact forces, and the colour bars of
    rotor and wall side by side below it."""
    shade = stage["shade"].values
    look_of: dict[str, Any] = {"facecolors": shade, "edgecolors": shade, "linewidths": 0.2}
    axes.add_collection(PolyCollection([*stage["outline"].values], rasterized=True, **look_of))
    axes.add_collection(PolyCollection([*stage["arrow"].values], facecolors=look.FORCE_COLOUR))
    places = stage["number_place"].values
    for blade in range(0, len(places), -(-len(places) // MOST_NUMBERS)) if len(places) > 1 else ():
        if np.isfinite(places[blade]).all():
            x, y = places[blade]
            axes.text(x, y, str(blade), ha="center", va="center", path_effects=OUTLINE)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()
    count = stage.sizes["scale"]
    for number, name in enumerate(stage["scale"].values):
        colours = ListedColormap(stage["colours"].values[number].tolist())
        shown = ScalarMappable(Normalize(*stage["limits"].values[number]), colours)
        box = axes.inset_axes((number / count + 0.05, -0.04, 1.0 / count - 0.1, 0.025))
        axes.figure.colorbar(shown, cax=box, orientation="horizontal", label=str(name))
        box.locator_params(axis="x", nbins=5)
