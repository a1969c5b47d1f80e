"""Drawing of a whole rotor in an oblique view: shaft, disks, wheels, bearings, supports, orbits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from scipy.spatial import ConvexHull

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.shaft_line import ShaftLine
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled

DEPTH = complex(-0.4, -0.28)  #: picture of a unit length along x; y points up, z to the right
SIDES = 49  #: number of points of a circle
GROUND = 1.35  #: distance of the ground from the axis, as a multiple of the largest radius
FILLS: Mapping[str, str] = {"shaft": "#B9C0C8", "disk": "#7F9DB9", "wheel": "#C9D7E4"}
EDGE = "#30363D"


@dataclass(frozen=True, kw_only=True)
class Rotor:
    """What is drawn of a shaft line, undeformed."""

    title: str
    position: FloatArray  #: position of each node along z [m], (nodes,)
    radius: FloatArray  #: outer radii of the elements at both ends [m], (nodes - 1, 2)
    disks: tuple[tuple[float, float, float], ...]  #: position, radius and thickness [m]
    wheels: tuple[tuple[float, float], ...]  #: position and radius of the tips [m]
    bearings: tuple[tuple[str, float, bool], ...]  #: name, position, whether it has a support
    unbalance: tuple[tuple[float, float], ...]  #: position and phase

    @property
    def largest(self) -> float:
        """Largest radius [m]."""
        others = [radius for _, radius, *_ in (*self.disks, *self.wheels)]
        return float(max([self.radius.max(), *others]))

    def node(self, position: float) -> int:
        """Return the node at a position [m]."""
        return int(np.abs(self.position - position).argmin())


def rotor_of(
    table: ShaftLine,
    position: FloatArray,
    *,
    title: str,
    wheels: Sequence[tuple[float, float]] = (),
) -> Rotor:
    """Return what is drawn of a shaft line with nodes at positions [m] and wheels, see `Rotor`;
    disks are uniform cylinders of their mass and moments of inertia."""
    start, radii = table.start, list[FloatArray]()
    middle = (position[1:] + position[:-1]) / 2.0
    for segment in table.segments:
        first, end = segment.outer_diameter / 2.0, start + segment.length
        last = (segment.end_outer_diameter or segment.outer_diameter) / 2.0
        for element in np.flatnonzero((middle > start) & (middle < end)):
            share = (position[element : element + 2] - start) / segment.length
            radii.append(first + (last - first) * share)
        start = end
    disks = []
    for disk in table.disks:
        square = 2.0 * disk.polar_inertia / disk.mass
        rest = 12.0 * disk.diametral_inertia / disk.mass - 3.0 * square
        size = float(np.sqrt(square)), float(np.sqrt(max(rest, 0.0)))
        disks.append((disk.position + disk.offset, *size))
    names = zip(table.named(), table.bearings, strict=True)
    return Rotor(
        title=title,
        position=position,
        radius=np.array(radii),
        disks=tuple(disks),
        wheels=tuple(wheels),
        bearings=tuple((name, row.position, row.support is not None) for name, row in names),
        unbalance=tuple((row.position, row.phase) for row in table.unbalance),
    )


@styled
def plot_rotor(rotor: Rotor) -> Figure:
    """Draw a rotor at rest, with positions along its axis."""
    figure = new_figure(width=FULL_WIDTH, height=0.09)
    axes = figure.add_subplot()
    still = np.zeros(len(rotor.position), np.complex128)
    draw_rotor(
        axes,
        rotor,
        deflection=still,
        slope=still,
        support=np.zeros(len(rotor.bearings), np.complex128),
        angle=0.0,
    )
    axes.axis("on")
    axes.grid(visible=False)
    axes.spines[["left", "right", "top"]].set_visible(False)
    axes.tick_params(left=False, labelleft=False)
    axes.set_xlabel("position along the shaft [m]")
    figure.suptitle(rotor.title)
    legends_below(figure, Group(entries_of(axes)))
    return figure


def draw_rotor(
    axes: Axes,
    rotor: Rotor,
    *,
    deflection: ComplexArray,
    slope: ComplexArray,
    support: ComplexArray,
    angle: float,
) -> None:
    """Draw a rotor with displacements that are already enlarged.

    Args:
        axes: where to draw.
        rotor: the rotor.
        deflection: displacement x + i y of each node [m], (nodes,).
        slope: slopes of the axis in the planes of x and y, (nodes,).
        support: displacement of the support of each bearing [m], (bearings,).
        angle: angle of the rotation [rad].
    """
    ground = -GROUND * rotor.largest
    for number, (name, place, has_support) in enumerate(rotor.bearings):
        node = rotor.node(place)
        foot = -0.6 * rotor.largest + support[number].imag if has_support else ground
        at = seen(place, deflection[node])
        below = seen(place, 1j * foot + (support[number].real if has_support else 0.0))
        _spring(axes, at, below, 0.012 * np.ptp(rotor.position))
        if has_support:
            _spring(axes, below, seen(place, 1j * ground), 0.012 * np.ptp(rotor.position))
            look: dict[str, Any] = {
                "color": COLOURS["casing"],
                "markersize": 6.0,
                "label": "mass of a support",
            }
            axes.plot(below.real, below.imag, "s", **look)
        _ground(axes, seen(place, 1j * ground), 0.04 * np.ptp(rotor.position))
        label = seen(place, 1j * ground)
        axes.annotate(
            name,
            (label.real, label.imag),
            xytext=(0.0, -6.0),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=7,
        )
    for _, paint in sorted(_solids(rotor), key=lambda each: each[0]):
        paint(axes, deflection, slope)
    for place, phase in rotor.unbalance:
        node = rotor.node(place)
        reach = max(_radius_at(rotor, place), rotor.radius.max())
        mark = seen(place, deflection[node] + reach * np.exp(1j * (angle + phase)))
        of_mark: dict[str, Any] = {
            "color": COLOURS["k = 1"],
            "markersize": 4.0,
            "label": "unbalance",
        }
        axes.plot(mark.real, mark.imag, "o", zorder=5, **of_mark)
    axes.set(aspect="equal")
    axes.axis("off")
    room = 0.5 * rotor.largest
    ends = [(place, thickness) for place, _, thickness in rotor.disks]
    first = min([rotor.position[0], *(place - thickness / 2.0 for place, thickness in ends)])
    last = max([rotor.position[-1], *(place + thickness / 2.0 for place, thickness in ends)])
    axes.set_xlim(first - room, last + room)
    axes.set_ylim(1.3 * ground, 2.7 * room)


def seen(along: Any, across: Any) -> Any:
    """Return positions in the picture of positions z [m] and x + i y [m]."""
    return along + across.real * DEPTH + 1j * np.imag(across)


def _radius_at(rotor: Rotor, place: float) -> float:
    near = [radius for z, radius, *_ in (*rotor.disks, *rotor.wheels) if abs(z - place) < 1e-6]
    return max(near, default=0.0)


def _solids(rotor: Rotor) -> list[tuple[float, Any]]:
    """Return the position of each cylinder and a function that draws it."""
    circle = np.exp(2j * np.pi * np.arange(SIDES) / (SIDES - 1))
    solids: list[tuple[float, Any]] = []

    def cylinder(ends: Any, radii: Any, nodes: Any, fill: str) -> Any:
        def paint(axes: Axes, deflection: ComplexArray, slope: ComplexArray) -> None:
            rims = []
            for z, radius, node in zip(ends, radii, nodes, strict=True):
                arm = z - rotor.position[node]
                rim = radius * circle
                tilted = z - (rim * slope[node].conjugate()).real
                rims.append(seen(tilted, deflection[node] + arm * slope[node] + rim))
            both = np.concatenate(rims)
            flat = np.column_stack([both.real, both.imag])
            hull = flat[ConvexHull(flat, qhull_options="QJ").vertices]
            axes.add_patch(Polygon(hull, facecolor=fill, edgecolor=EDGE, linewidth=0.4))
            cap = np.column_stack([rims[-1].real, rims[-1].imag])
            axes.add_patch(Polygon(cap, facecolor=fill, edgecolor=EDGE, linewidth=0.4, alpha=0.85))

        return paint

    for element, radii in enumerate(rotor.radius):
        nodes = element, element + 1
        ends = rotor.position[[*nodes]]
        solids.append((float(ends.mean()), cylinder(ends, radii, nodes, FILLS["shaft"])))
    for kind, rows in (("disk", rotor.disks), ("wheel", [(*row, 0.0) for row in rotor.wheels])):
        for place, radius, thickness in rows:
            half = max(thickness, 0.02 * radius) / 2.0
            node = rotor.node(place)
            ends = place + np.array([-half, half])
            paint = cylinder(ends, (radius, radius), (node, node), FILLS[kind])
            solids.append((place + 1e-9, paint))
    return solids


def _spring(axes: Axes, top: complex, bottom: complex, width: float) -> None:
    """Draw a spring between two points of the picture."""
    share = np.array([0.0, 0.2, 0.27, 0.37, 0.47, 0.57, 0.67, 0.74, 1.0])
    aside = width * np.array([0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 1.0, 0.0, 0.0])
    points = top + (bottom - top) * share + aside
    axes.plot(points.real, points.imag, color=COLOURS["suspension"], linewidth=1.0, zorder=0)


def _ground(axes: Axes, at: complex, width: float) -> None:
    """Draw the ground at a point of the picture."""
    line = at + width * np.array([-1.0, 1.0])
    axes.plot(line.real, line.imag, color=EDGE, linewidth=1.0)
    for place in np.linspace(-0.8, 1.0, 6):
        tick = at + width * place + np.array([0.0, -0.25 - 0.25j]) * width
        axes.plot(tick.real, tick.imag, color=EDGE, linewidth=0.5)
