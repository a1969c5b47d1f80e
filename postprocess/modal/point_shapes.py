"""Mode shapes of a bladed disk that is given by points and surface triangles, and of its casing."""

from dataclasses import replace
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial import KDTree

from bladewhirl.meshes.coincident import places_of
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.models.modal.labels import Body
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.whirl_modes import WhirlModes
from bladewhirl.postprocess.modal.mode_shapes import DRAWN, PURE, mode_title
from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, LIT, new_figure, styled

MOST = 20_000
"""Largest number of triangles of a picture; larger surfaces are drawn as points."""

SAME = 1e-6  #: largest distance of nodes at one place, by the size of the surface
COLUMNS = 3  #: largest number of panels side by side
SHARE_OF_PITCH = 0.25  #: largest displacement that is drawn, by the distance of neighbouring tips
ZOOM = 1.5  #: factor by which the panels of matplotlib in space are filled better
ELEVATION, AZIMUTH = 55.0, -60.0  #: direction of the view [degrees]
DARKEST = 0.3  #: share of the colour that a surface loses which is seen from its edge

SMOOTH = 8000  #: number of pieces up to which triangles are divided

LARGEST_DOT = 100.0  #: size of a drawn point times the root of the number of points [pt2]


def point_shapes(model: ModalModel, numbers: IntArray) -> xr.Dataset:
    """Return the shapes of some modes of a bladed disk with points, and the number of `blades` that
    the points belong to.

    Args:
        model: bladed disk whose `points` are not None.
        numbers: numbers of the modes among its listed modes.
    """
    listed, shapes = model.listed_modes, model.points(numbers)
    assert shapes is not None
    motions = model.tip_motions(listed)
    values: dict[str, Any] = {
        "rotor_frequency": ("rotor_mode", listed.frequency[numbers], {"units": "rad/s"}),
        "rotor_nodal_diameter": ("rotor_mode", listed.nodal_diameter[numbers]),
        "rotor_purity": ("rotor_mode", listed.purity[numbers]),
        "rotor_family": ("rotor_mode", [listed.family[i] for i in numbers]),
        "rotor_tip_motion": ("rotor_mode", [motions[i] for i in numbers]),
        "point": (("points", "axis"), shapes.position, {"units": "m"}),
        "triangle": (("triangles", "corner"), shapes.triangle),
        "point_shape": (
            ("rotor_mode", "points", "axis"),
            shapes.displacement.real,
            {"units": "kg^-1/2", "long_name": "displacement for unit modal coordinates"},
        ),
    }
    copies, blades = len(shapes.stage.copy_angle), 1 + int(shapes.stage.blade.max())
    return xr.Dataset(values, attrs=_attributes(model) | {"blades": 1 if copies > 1 else blades})


def point_arrays(model: ModalModel, body: Body, numbers: IntArray) -> StageArrays:
    """Return the arrays of a bladed disk with points, with some modes of one body; the other body
    has one mode, which stays at rest.

    The bladed disk is one copy with the points of its modes: the whole structure, or one of several
    separate blades.

    Args:
        model: bladed disk whose `points` are not None.
        body: body whose modes are taken.
        numbers: number of a single mode, numbers of the cosine and the sine mode of a pair, or
            number of a whirling mode, which has two fields.
    """
    disk = numbers if body == "bladed-disk" else np.zeros(1, dtype=np.int64)
    shapes, listed = model.points(disk), model.listed_modes
    assert shapes is not None
    fields = shapes.displacement.real
    if isinstance(listed, WhirlModes):
        fields = np.concatenate([fields, -shapes.displacement.imag])
    stage, position = shapes.stage, shapes.position
    first = stage.blade == 0 if len(stage.copy_angle) > 1 else np.full(len(stage.blade), True)
    radius, angle = stage.contact_radius[first], stage.tip_angle[first]
    nodes = np.column_stack([radius[:, None] * directions(angle), stage.axial_position[first]])
    moved = fields[:, KDTree(position).query(nodes)[1]]
    names = ("blade", "node", "tip_angle", "contact_radius", "axial_position", "tip_recess")
    walls: dict[str, Any] = {}
    if model.casing is not None:
        wall = numbers if body == "casing" else np.zeros(1, dtype=np.int64)
        walls = {
            "casing_frequency": model.casing_modes.frequency[wall],
            "casing_nodal_diameter": model.casing_modes.nodal_diameter[wall],
            "casing_family": tuple(model.casing_modes.family[i] for i in wall),
            "casing_shape": model.casing.nodal(model.casing_modes.fields(wall)),
        }
    return replace(
        stage,
        **{name: getattr(stage, name)[first] for name in names},
        stress_shape=np.zeros(0),
        stress_by_force=np.zeros(0),
        steady_stress=np.zeros(0),
        copy_stiffness=np.zeros(0),
        **walls,
        rotor_frequency=np.resize(listed.frequency[disk], len(fields)),
        rotor_nodal_diameter=np.resize(listed.nodal_diameter[disk], len(fields)),
        contact_shape=np.moveaxis(rotate(moved, -angle), 0, -1),
        copy_angle=np.zeros(1),
        point=position,
        point_shape=np.moveaxis(fields, 0, -1),
        centre_shape=np.zeros(0),
        gauge_shape=np.zeros(0),
        gauge_by_force=np.zeros(0),
    )


def casing_shapes(model: ModalModel, numbers: IntArray) -> xr.Dataset:
    """Return the shapes of some modes of a flexible casing, as `plot_mode_shapes` draws them."""
    casing, modes = model.casing, model.casing_modes
    assert casing is not None
    values: dict[str, Any] = {
        "casing_frequency": ("casing_mode", modes.frequency[numbers], {"units": "rad/s"}),
        "casing_nodal_diameter": ("casing_mode", modes.nodal_diameter[numbers]),
        "casing_purity": ("casing_mode", modes.purity[numbers]),
        "casing_family": ("casing_mode", [modes.family[i] for i in numbers]),
        "casing_angle": ("casing_node", casing.mesh.angles, {"units": "rad"}),
        "casing_shape": (
            ("casing_node", "casing_component", "casing_mode"),
            casing.nodal(modes.fields(numbers)),
        ),
    }
    radius = {"casing_radius": casing.mesh.radius}
    return xr.Dataset(values, attrs=_attributes(model) | radius)


def _attributes(model: ModalModel) -> dict[str, Any]:
    return {
        "case": model.case.title,
        "reference_frequency": model.reference_frequency,
        "rotation": "clockwise" if model.speed < 0.0 else "counter-clockwise",
    }


def facing_triangles(points: FloatArray, triangles: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the triangles that face the viewer (seen, 3), and the cosine of the angle between the
    normal of each and the view (seen,).

    If the surface is not closed, or its triangles have no common orientation, all are returned.

    Args:
        points: points of the surface (point, 3).
        triangles: points of each triangle (triangle, 3).
    """
    height, angle = np.radians([ELEVATION, AZIMUTH])
    view = np.append(np.cos(height) * directions(angle), np.sin(height))
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    facing = unit(np.cross(b - a, c - a)) @ view
    place = places_of(points, SAME * np.ptp(points))  # faces of sectors have nodes at one place
    sides = place[triangles][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    there, back = (np.unique(one, axis=0) for one in (sides, sides[:, ::-1]))
    if len(there) < len(sides) or not np.array_equal(there, back):
        return triangles, np.abs(facing)
    facing *= np.sign(np.sum(a * np.cross(b, c)))  # outward: the volume inside is positive
    seen = facing > 0.0
    return triangles[seen], facing[seen]


def _divided(corners: FloatArray) -> FloatArray:
    """Return triangles divided into four until there are enough for smooth colours, those of a
    triangle one after another; `corners` are places and displacements, (triangle, 3, 6)."""
    while 0 < 4 * len(corners) <= SMOOTH:
        a, b, c = np.moveaxis(corners, 1, 0)
        d, e, f = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = [np.stack(part, axis=1) for part in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))]
        corners = np.stack(parts, axis=1).reshape(-1, *corners.shape[1:])
    return corners


@styled
def plot_point_shapes(data: xr.Dataset, body: Body = "bladed-disk") -> Figure:
    """Draw mode shapes from `point_shapes` side by side: displaced surfaces, coloured by
    displacement; surfaces of many triangles as points. The body is always the bladed disk."""
    modes = data.sizes["rotor_mode"]
    rows = -(-modes // COLUMNS)
    columns = -(-modes // rows)
    figure = new_figure(width=FULL_WIDTH, height=0.03 + rows * (0.8 * FULL_WIDTH / columns))
    rest, triangles = data["point"].values, data["triangle"].values
    middle = 0.5 * (rest.max(axis=0) + rest.min(axis=0))
    reach = 0.5 * np.ptp(rest, axis=0).max()
    pitch = 2.0 * np.pi / data.attrs["blades"] if data.attrs["blades"] > 1 else np.inf
    largest = reach * min(DRAWN, SHARE_OF_PITCH * pitch)  # neighbours do not reach each other
    dot = np.clip(LARGEST_DOT / np.sqrt(len(rest)), 0.5, 6.0)
    colours, norm = matplotlib.colormaps[LIT], Normalize(0.0, 1.0)
    panels = []
    for mode in range(modes):
        axes: Any = figure.add_subplot(rows, columns, mode + 1, projection="3d")
        panels.append(axes)
        row = data.isel(rotor_mode=mode)
        moved = row["point_shape"].values
        size = np.linalg.norm(moved, axis=1)
        share = size / size.max()
        drawn = rest + largest / size.max() * moved
        if 0 < len(triangles) <= MOST:
            seen, facing = facing_triangles(drawn, triangles)
            pieces = _divided(np.column_stack([drawn, moved / size.max()])[seen])
            faces = colours(norm(np.linalg.norm(pieces[..., 3:].mean(axis=1), axis=1)))
            light = 1.0 - DARKEST * (1.0 - facing)
            faces[:, :3] *= np.repeat(light, len(pieces) // len(seen))[:, None]
            look = {"facecolors": faces, "edgecolors": faces, "linewidths": 0.2}  # without seams
            look["clip_on"] = False  # a panel may be smaller than its body
            axes.add_collection3d(Poly3DCollection(pieces[..., :3], **look))
        else:
            axes.scatter(*drawn.T, c=colours(norm(share)), s=dot, linewidths=0.0, rasterized=True)
        bounds = [(centre - reach, centre + reach) for centre in middle]
        axes.set(xlim=bounds[0], ylim=bounds[1], zlim=bounds[2])
        axes.set_box_aspect((1.0, 1.0, 1.0), zoom=ZOOM)
        axes.view_init(elev=ELEVATION, azim=AZIMUTH)
        axes.set_axis_off()
        k, purity = int(row["rotor_nodal_diameter"]), float(row["rotor_purity"])
        hertz = float(row["rotor_frequency"]) / (2.0 * np.pi)
        name = mode_title(str(row["rotor_family"].values), k, purity if k >= 0 else 1.0)
        share_of_k = f"\nk = {k}: {100 * purity:.0f} %" if 0 <= k and purity < PURE else ""
        lines = [
            name,
            str(row["rotor_tip_motion"].values),
            f"{hertz:#.4g}".rstrip(".") + f" Hz{share_of_k}",
        ]
        axes.set_title("\n".join(filter(None, lines)))
    figure.colorbar(
        matplotlib.cm.ScalarMappable(norm, colours),
        ax=panels,
        location="right",
        label="displacement / largest one [–]",
        shrink=0.8,
        aspect=20,
        ticks=[0.0, 0.5, 1.0],
    )
    shown = f"Modes, rotating frame; rotation is {data.attrs['rotation']}"
    shown += "; deflections are not to scale"
    complete(figure, data, shown)
    return figure
