"""Arguments of `mesh3d` that a mesh suggests, found from its geometry, groups and materials."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.plausible import MATERIAL
from bladewhirl.models.inputs.units import to_si
from bladewhirl.models.solids.groups import AXES
from bladewhirl.models.solids.materials import SYMBOLS, of_file, unit_scale
from bladewhirl.models.solids.positions import OUTERMOST, SHARE, nodes_where
from bladewhirl.models.solids.sectors import Bounds, Sector, find_bounds, find_sector, largest_gap
from bladewhirl.models.solids.wheels import equal_blades, goes_round
from bladewhirl.models.superelements.superelement import RADII

ROOTS, TIPS = ("root", "hub", "bore", "clamp", "fix"), ("tip", "contact", "shroud")
BLADES = ("blade", "airfoil", "aerofoil")
"""Parts of the names of groups that are probably clamped, that probably touch, and of blades."""

UNITS = (("m", "kg"), ("mm", "t"), ("mm", "kg"), ("mm", "g"), ("in", "slinch"), ("ft", "slug"))
"""Units of length and mass of decks, of which the first that makes materials plausible is taken."""

WIDE = 1.5
"""Largest distance of a material from the middle of plausible ones, in powers of ten, divided by
half their range."""

ROUND = 1e-5
"""Radii of nodes on a surface of revolution differ by less than this fraction of the largest."""

EQUAL = 0.05
"""Second moments of a wheel about two axes differ by less than this fraction."""

FEW = 5  #: number of contact nodes along the chord of a tip

UNKNOWN = "?"  #: placeholder of a value, which `mesh3d` refuses


class Proposal(NamedTuple):
    """Arguments of `mesh3d` that a mesh suggests."""

    options: dict[str, str | bool]
    """Value of each argument, as text unless it is a switch; `UNKNOWN` if it is not known."""
    notes: tuple[str, ...]  #: where the values come from, and what is not known


def proposed(mesh: VolumeMesh) -> Proposal:
    """Return the arguments of `mesh3d` that a mesh suggests.

    Args:
        mesh: mesh in the axes and the unit of its file.
    """
    notes: list[str] = []
    unit, mass_unit = _units(mesh, notes)
    axis, sector, wheel = _axis(mesh, unit, notes)
    placed = replace(mesh, points=mesh.points[:, AXES.get(axis, AXES["z"])])
    surfaces = _surfaces(mesh)
    options = dict[str, str | bool]()
    for key in SYMBOLS:
        values, reasons = of_file(mesh, key)
        if len(bare := np.flatnonzero(np.isnan(values))):
            options[key] = UNKNOWN
            why = reasons.get(int(bare[0]), "")
            notes.append(
                f"{key}: the file gives none to {len(bare)} cells" + f"; {why}" * bool(why)
            )
    options["clamped"] = _clamped(placed, axis, sector is not None or wheel, unit, surfaces, notes)
    named = _named(surfaces, TIPS)
    options["contact"] = named or (UNKNOWN if axis == UNKNOWN else OUTERMOST)
    touching = mesh.groups[named] if named else nodes_where(OUTERMOST, placed.points, "z")
    assert touching is not None
    blades = equal_blades(placed.points, touching) if wheel else 1
    if len(touching) // blades > FEW and (blades > 1 or not wheel) and axis != UNKNOWN:
        options["contacts"] = str(FEW)
    if (sector is not None or wheel) and (blade := _named(mesh.cell_groups, BLADES)):
        options["blade"] = blade
    if isinstance(sector, Sector):
        options |= _faces(mesh, sector)
    elif sector is not None:
        options["copies"] = UNKNOWN
    elif blades > 1:
        options["copies"] = str(blades)
        notes.append(f"copies: the mesh repeats after 1/{blades} of a turn")
    options |= {} if unit == "m" else {"length_unit": unit}
    if any(section.properties for section in mesh.sections) and (unit, mass_unit) != UNITS[0]:
        options["mass_unit"] = mass_unit
    options |= {} if axis == "z" else {"axis": axis}
    options["coriolis"] = True
    notes.append(
        "coriolis: a speed that varies needs Coriolis forces; without them studies take less time"
    )
    if mesh.ignored:
        notes.append(f"not read: {', '.join(mesh.ignored)}")
    return Proposal(options, tuple(notes))


def _axis(
    mesh: VolumeMesh, unit: str, notes: list[str]
) -> tuple[str, Sector | Bounds | None, bool]:
    """Return the axis of rotation, the faces of a sector about it, and whether the mesh is a whole
    wheel."""
    placed = {axis: replace(mesh, points=mesh.points[:, AXES[axis]]) for axis in AXES}
    sectors = {axis: found for axis, one in placed.items() if (found := find_sector(one))}
    with_bore = {axis: found for axis, found in sectors.items() if not found.on_axis}
    if len(sectors := with_bore or sectors) == 1:
        ((axis, sector),) = sectors.items()
        number = f"{len(sector.left)} nodes each"
        notes.append(
            f"copies: cut faces, {number}, match after 1/{sector.copies} of a turn about {axis}"
            + " and meet on it: the nodes there have to be clamped" * sector.on_axis
        )
        notes += filter(None, [sector.partly(placed[axis].points)])
        return axis, sector, False
    wheels = [axis for axis, one in placed.items() if _is_wheel(one)]
    if len(wheels) == 1:
        notes.append(f"axis: the mesh is a whole wheel about {wheels[0]}")
        return wheels[0], None, True
    bounds = {axis: near for axis, one in placed.items() if (near := find_bounds(one))}
    if bounds:
        axis = max(bounds, key=lambda one: bounds[one].share)
        missed = bounds[axis].missed(placed[axis].points, unit.replace(UNKNOWN, "units of length"))
        notes.append(f"copies: about {axis}, {missed}")
        return axis, bounds[axis], False
    round_ = [axis for axis, one in placed.items() if _is_round(one)]
    if len(round_) == 1:
        notes.append(f"axis: ends of the mesh are round about {round_[0]}; no cut faces match")
        return round_[0], None, False
    notes.append("axis: the geometry does not tell it; x, y or z, which must be that of the mesh")
    return UNKNOWN, None, False


def _is_wheel(mesh: VolumeMesh) -> bool:
    """Return whether the nodes are spread evenly about z."""
    x, y, _ = mesh.points.T
    radius = float(np.hypot(x, y).max())
    across = np.cov(x, y)
    unequal = max(abs(across[0, 0] - across[1, 1]), abs(across[0, 1])) / np.trace(across)
    centred = np.hypot(x.mean(), y.mean()) < EQUAL * radius
    return bool(centred and unequal < EQUAL and goes_round(mesh.points))


def _is_round(mesh: VolumeMesh) -> bool:
    """Return whether the nodes at the smallest or the largest radius about z, which is outside of
    the mesh, have three angles or more."""
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    angle = np.degrees(np.arctan2(mesh.points[:, 1], mesh.points[:, 0])).round(3)
    ends = (radius.min(), radius.max())
    close = [abs(radius - end) < ROUND * radius.max() for end in ends]
    ends_round = any(len(np.unique(angle[one])) > 2 for one in close)
    return ends_round and largest_gap(mesh.points) > np.pi


def _units(mesh: VolumeMesh, notes: list[str]) -> tuple[str, str]:
    """Return the units of length and mass of a mesh: those with which its radius and materials are
    plausible, and nearest to usual ones."""
    radius = float(abs(mesh.points).max())
    distances = dict[tuple[str, str], float]()
    for length, mass in UNITS:
        if not RADII[0] <= radius * to_si(f"1 {length}", "m") <= RADII[1]:
            continue
        decades = [0.0]
        for key, (least, most, _) in MATERIAL.items():
            scale = unit_scale(key, length, mass) / np.sqrt(least * most)
            half = np.log10(most / least) / 2.0
            for section in mesh.sections:
                if value := section.properties.get(key):
                    decades.append(abs(np.log10(scale * value)) / half)
        if max(decades) < WIDE:
            distances[length, mass] = max(decades)
    if not distances:
        notes.append("units: with none are radius and materials plausible")
        return UNKNOWN, UNKNOWN
    length, mass = min(distances, key=distances.__getitem__)
    if any(section.properties for section in mesh.sections):
        notes.append(f"units: {length} and {mass}, with which radius and materials are plausible")
    else:
        notes.append(f"units: {length}, with which the radius is plausible")
    return length, mass


def _surfaces(mesh: VolumeMesh) -> dict[str, IntArray]:
    """Return the groups of nodes that are not those of elements."""
    found = {}
    for name, nodes in mesh.groups.items():
        within = np.zeros(len(mesh.points), dtype=np.bool_)
        within[nodes] = True
        filled = [cells[within[cells].all(axis=1)].ravel() for _, cells in mesh.blocks]
        solid = len(np.unique(np.concatenate(filled))) > 0.5 * len(nodes)
        if len(nodes) and name not in mesh.cell_groups and not solid:
            found[name] = nodes
    return found


def _clamped(
    mesh: VolumeMesh,
    axis: str,
    turned: bool,
    unit: str,
    surfaces: Mapping[str, IntArray],
    notes: list[str],
) -> str:
    """Return the group or the condition of the nodes to clamp; `turned` for a sector or a wheel."""
    if mesh.held:
        notes.append(f"clamped: the nodes that the file holds, {mesh.held}")
        return mesh.held
    if named := _named(surfaces, ROOTS):
        return named
    if axis == UNKNOWN or unit == UNKNOWN:
        notes.append("clamped: no group or constraint of the file tells it")
        return UNKNOWN
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    limit = float(radius.min() + SHARE * np.ptp(radius))
    place = "bore" if turned else "root"
    notes.append(f"clamped: the nodes at the smallest radius, probably the {place}")
    inside = np.flatnonzero(radius < limit)
    alike = [name for name, nodes in surfaces.items() if np.array_equal(np.unique(nodes), inside)]
    return alike[0] if alike else f"r < {limit:.5g} {unit}"


def _faces(mesh: VolumeMesh, sector: Sector) -> dict[str, str]:
    """Return the groups of both cut faces if there are such, and the number of sectors."""
    names = {
        key: next((name for name, own in mesh.groups.items() if np.array_equal(own, nodes)), None)
        for key, nodes in (("left", sector.left), ("right", sector.right))
    }
    copies = {"copies": str(sector.copies)}
    if None in names.values():
        return copies
    return {key: str(name) for key, name in names.items()} | copies


def _named(groups: Iterable[str], parts: tuple[str, ...]) -> str:
    """Return the first group whose name contains one of the words; nothing without one."""
    return next((name for word in parts for name in groups if word in name.lower()), "")
