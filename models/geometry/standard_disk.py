"""Sketch of the standard bladed disk, which is described by the `[bladed_disk]` table."""

from collections.abc import Callable, Collection
from itertools import pairwise

import numpy as np

from bladewhirl.meshes.line_mesh import points_along
from bladewhirl.meshes.plane import directions
from bladewhirl.models.case.bladed_disk import BladedDisk
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.sections.rectangular import QUANTITIES, Material, Section, along

FINE = 400  #: number of points along a curved centre line between which its angle is interpolated

FINE_STATIONS = 32
"""Number of points per element at which the taper of a part of a blade is sampled."""

BETWEEN = np.arange(1, 8) / 8.0
"""Positions along a curved part or an arc, from 0 to 1, at which it is sampled."""


ENDS = ("left", "right")
"""Ends of the part of a ring on a blade: on its clockwise and its counter-clockwise side."""


def ring_end(ring: int, side: str) -> str:
    """Return the name of the set of the ends on one side of a ring that joints cut."""
    return f"shroud {ring} {side}"


def bladed_disk_sketch(
    given: BladedDisk, material: Material, cut_rings: Collection[int] = ()
) -> Sketch:
    """Draw a bladed disk; the default table gives the bladed disk of the paper's Fig. 3(a).

    Each sector has one blade with elements of nearly equal length, whose tip is on the radial line
    of the sector, and the part of the disk below the blade. Node sets: ``tips``, ``roots``,
    ``centre``. Line sets: ``blades``, and ``spokes``, ``rim``, ``rings`` and ``shrouds`` if the
    disk has these parts.

    Args:
        given: table with sizes and parts.
        material: material of the case, with the named materials.
        cut_rings: numbers of the shrouds that are cut halfway between all blades; their ends are
            the node sets `ring_end`.

    Raises:
        CaseError: the radius of the centre line does not increase everywhere.
    """
    sketch = Sketch(given.blades, tip_radius=given.tip_radius)
    blade = _Blade(given)
    sketch.node("centre", 0.0, 0.0, shared=True)
    sketch.node("root", *blade.point(given.disk_radius))
    for name, radius in blade.inner.items():
        sketch.node(name, *blade.point(radius))
    sketch.node("tip", given.tip_radius)
    _draw_blades(sketch, given, blade, material)
    _draw_disk(sketch, given, blade, material)
    for i, shroud in enumerate(given.shrouds):
        if i in cut_rings:
            _draw_cut_ring(sketch, given, i, blade, material.section(shroud))
            continue
        node = blade.node_at(shroud.radius)
        _, angle = blade.polar(shroud.radius)
        on_arc = angle + 2.0 * np.pi / given.blades * BETWEEN
        sketch.member(
            f"shroud {i}",
            node,
            f"{node}+1",
            material.section(shroud),
            elements=shroud.elements,
            path=(shroud.radius * directions(on_arc)).tolist() if shroud.elements > 1 else (),
            part="shrouds",
            sectors=[b for b in range(given.blades) if b not in shroud.cuts],
        )
    for mass in given.point_masses:
        node = blade.node_at(mass.radius)
        sketch.mass(node, mass.mass, inertia=mass.inertia, sectors=mass.blades)
    if given.tip_mass:
        sketch.mass("tip", given.tip_mass)
    for name, node in (("centre", "centre"), ("tips", "tip"), ("roots", "root")):
        sketch.set(name, node)
    return sketch


def _draw_cut_ring(
    sketch: Sketch, given: BladedDisk, ring: int, blade: "_Blade", section: Section
) -> None:
    """Draw the parts of a cut ring on both sides of a blade."""
    shroud = given.shrouds[ring]
    node, (_, angle) = blade.node_at(shroud.radius), blade.polar(shroud.radius)
    half = np.pi / given.blades
    radius = shroud.radius * (1.0 if shroud.elements > 1 else float(np.cos(half)))
    for side, way in zip(ENDS, (-1.0, 1.0), strict=True):
        name = ring_end(ring, side)
        sketch.node(name, *(radius * directions(np.array(angle + way * half))).tolist())
        along_arc = shroud.radius * directions(angle + way * half * BETWEEN)
        sketch.member(
            f"{name} part",
            node,
            name,
            section,
            elements=-(-shroud.elements // 2),
            path=along_arc.tolist() if shroud.elements > 2 else (),
            part="shrouds",
        )
        sketch.set(name, name)


class _Blade:
    """The centre line of a blade, and the nodes along it."""

    def __init__(self, given: BladedDisk) -> None:
        self._root, self._span = given.disk_radius, given.tip_radius - given.disk_radius
        self.inner = {f"cut {i}": radius for i, radius in enumerate(given.cut_radii)}
        self._radius = {
            "centre": 0.0,
            "root": given.disk_radius,
            **self.inner,
            "tip": given.tip_radius,
        }
        self.is_curved = len(given.centre_line) > 1
        line = [(0.0, 0.0), *((point.span, point.angle) for point in given.centre_line)]
        self._angle: Callable[[float], float] = lambda span: 0.0
        if given.centre_line:
            from scipy.interpolate import CubicSpline  # long to load

            spans, angles = np.array(line).T
            radii = self._root + spans * self._span
            points = points_along(radii[:, None] * directions(angles), FINE)
            turned = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
            reached = (np.hypot(*points.T) - self._root) / self._span
            reached[0], reached[-1] = 0.0, 1.0
            if np.any(np.diff(reached) <= 0.0):
                expected = "a centre line whose radius increases all the way from root to tip"
                raise CaseError([Fault(key="bladed_disk.centre_line", expected=expected)])
            smooth = CubicSpline(reached, turned - turned[-1])  # the tip at angle zero
            self._angle = lambda span: float(smooth(span))

    def node_at(self, radius: float) -> str:
        """Return the name of the node at a radius that the case specifies."""
        return next(name for name, node_radius in self._radius.items() if node_radius == radius)

    def polar(self, radius: float, stretch: float = 1.0) -> tuple[float, float]:
        """Return radius [m] and angle [rad] of the point on the centre line at a given radius.

        Args:
            radius: radius of the point [m].
            stretch: length of the blade divided by that without mistuning.
        """
        return radius, self._angle(min(max((radius - self._root) / (stretch * self._span), 0), 1))

    def point(self, radius: float, stretch: float = 1.0) -> tuple[float, float]:
        """Return x and y [m] of the point of the centre line at a radius, see `polar`."""
        r, angle = self.polar(radius, stretch)
        return r * float(np.cos(angle)), r * float(np.sin(angle))

    def path(self, ends: tuple[float, float], stretch: float = 1.0) -> list[tuple[float, float]]:
        """Return points of the centre line between two radii [m]; none if the line is straight."""
        if not self.is_curved:
            return []
        return [self.point(ends[0] + s * (ends[1] - ends[0]), stretch) for s in BETWEEN]

    def shares(self, ends: tuple[float, float]) -> tuple[float, float]:
        """Convert two radii to positions from 0 at the root to 1 at the tip."""
        return (ends[0] - self._root) / self._span, (ends[1] - self._root) / self._span

    def pieces(self, elements: int) -> list[tuple[str, str, int]]:
        """Return end nodes and number of elements of each part between neighbouring nodes."""
        names = ["root", *self.inner, "tip"]
        lengths = np.diff([self._radius[name] for name in names])
        counts = np.ones(len(lengths), dtype=int)
        for _ in range(elements - len(lengths)):
            counts[np.argmax(lengths / counts)] += 1  # in the part with the longest elements
        return [(a, b, int(n)) for (a, b), n in zip(pairwise(names), counts, strict=True)]

    def radius(self, name: str, stretch: float = 1.0) -> float:
        """Return the radius of a node [m]; ``stretch``, a factor on the blade length, moves only
        the tip."""
        return self._root + stretch * self._span if name == "tip" else self._radius[name]


def _draw_blades(sketch: Sketch, given: BladedDisk, blade: _Blade, material: Material) -> None:
    blade_section = material.section(given.blade)
    taper = [
        material.section(given.blade.model_copy(update=row.model_dump(exclude_none=True)))
        for row in given.taper
    ]
    pieces = blade.pieces(given.elements_per_blade)
    names = ["blades", *(f"blades {i}" for i in range(1, len(pieces)))]
    for name, (first, second, elements) in zip(names, pieces, strict=True):
        ends = blade.radius(first), blade.radius(second)
        sketch.member(
            name,
            first,
            second,
            _piece_of(taper, blade.shares(ends), elements) or blade_section,
            elements=elements,
            path=blade.path(ends),
            part="blades",
        )
    stiffness, mass, length = (
        given.mistuning.factors(kind, given.blades) for kind in ("stiffness", "mass", "length")
    )
    for b in np.flatnonzero((stiffness != 1.0) | (mass != 1.0) | (length != 1.0)).tolist():
        if length[b] != 1.0:
            sketch.move(b, "tip", blade.radius("tip", length[b]))
            for node in blade.inner if given.centre_line else ():
                sketch.move(b, node, *blade.point(blade.radius(node), length[b]))
        for name, (first, second, _) in zip(names, pieces, strict=True):
            ends = blade.radius(first), blade.radius(second, length[b])
            sketch.change(
                *(b, name),
                stiffness=float(stiffness[b]),
                mass=float(mass[b]),
                path=blade.path(ends, length[b]) if length[b] != 1.0 else None,
            )


def _piece_of(taper: list[Section], ends: tuple[float, float], elements: int) -> list[Section]:
    """Return sections along a part of a blade: the given taper, if the part is the complete blade,
    otherwise the taper sampled at short distances."""
    if not taper or ends == (0.0, 1.0):
        return taper
    shares = np.linspace(*ends, FINE_STATIONS * elements + 1)
    return [
        Section(**dict(zip(QUANTITIES, column.tolist(), strict=True)))
        for column in along(taper, shares).T
    ]


def _draw_disk(sketch: Sketch, given: BladedDisk, blade: _Blade, material: Material) -> None:
    if given.disk_kind == "rigid":
        sketch.link("centre", "root")
        return
    disk_section = material.section(given.disk)
    if given.disk_kind == "rim":
        sketch.spring("root", "centre", radial=given.web_radial, tangential=given.web_tangential)
    else:
        rings = sorted(given.disk_rings, key=lambda ring: ring.radius)
        chain = ["centre", *(f"ring {i}" for i in range(len(rings))), "root"]
        for name, ring in zip(chain[1:], rings, strict=False):
            sketch.node(name, *blade.point(ring.radius))
        for i, (first, second) in enumerate(pairwise(chain)):
            sketch.member(
                f"spokes {i}" if i else "spokes", first, second, disk_section, part="spokes"
            )
        for name, ring in zip(chain[1:], rings, strict=False):
            sketch.member(f"{name} itself", name, f"{name}+1", material.section(ring), part="rings")
    if given.disk_kind != "spokes":
        sketch.member("rim", "root", "root+1", disk_section)
