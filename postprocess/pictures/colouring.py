"""Colouring of the stage in a picture, by a field of a result or by parts.

The values are true values, independent of the exaggeration of the picture. The two sides of beams
and of the wall have different values, because bending strains differ; both sides of a point of a
surface have the same value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import NamedTuple, get_args

import numpy as np
import xarray as xr
from matplotlib.colors import Colormap, ListedColormap, to_hex

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields import kinematics, rotation
from bladewhirl.postprocess.fields.enlarged import rounded_up
from bladewhirl.postprocess.fields.joint_nodes import JOINT_FIELDS, at_joint_nodes
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history
from bladewhirl.postprocess.fields.lost_blades import masked
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.points import Points, Recovered
from bladewhirl.postprocess.fields.strains import casing_strain_rows
from bladewhirl.postprocess.pictures.choices import Field
from bladewhirl.postprocess.pictures.solids import Solid
from bladewhirl.postprocess.plotting.style import COLOUR_MAPS, COLOURS, JOINT_STATES
from bladewhirl.postprocess.run.wear import coating_left, coating_of

PART_COLOURS = tuple(
    COLOURS[name] for name in ("k = 0", "other k", "suspension", "k = 1", "contact", "rest")
)
"""Colours of the parts of the rotor, used cyclically; the casing has its own colour."""
MAGNITUDES = ("displacement", "deformation", "velocity")  #: fields that are sizes of vectors


class Scale(NamedTuple):
    """Colour scale of the bladed disk or of the wall."""

    unit: str  #: "" for parts
    factor: float  #: from the SI unit to `unit`
    limits: tuple[float, float]  #: ends of the scale in `unit`
    colours: Colormap

    def shades(self, levels: int) -> list[str]:
        """Return `levels` colours of a field, or the colours of the parts, as #rrggbb."""
        levels = min(levels, self.colours.N)
        return [to_hex(shade) for shade in self.colours(np.linspace(0.0, 1.0, levels))]


@dataclass(frozen=True, kw_only=True)
class Colouring:
    """True values of a field in a picture; NaN where the field has no value. Bladed disk and wall
    have scales of their own, so that the larger values of one do not hide those of the other."""

    name: str  #: label of the scales, without unit
    points: Array  #: values of the points of the bladed disk (record, point, side)
    nodes: Array  #: values of the contact nodes (record, contact_node)
    casing: Array  #: values (record, station, side); the first station is not repeated at the end
    disk: Scale  #: of points and contact nodes
    wall: Scale  #: of the casing
    parts: Mapping[str, str] | None = None
    """Colours of parts, or of states of joints, by name, whose numbers are then the values; None
    for a field."""

    def shade(self, solid: Solid) -> Scale | str:
        """Return the scale or the colour of a solid."""
        scales = {"disk": self.disk, "wall": self.wall}
        return scales[solid.shows] if solid.shows else solid.colour

    @property
    def scales(self) -> dict[str, Scale]:
        """Scales of a field that have values, by their labels; without those whose values are zero
        everywhere."""
        values = {"rotor": (self.points, self.nodes), "wall": (self.casing,)}
        shown = [name for name, given in values.items() if _largest(*given)]
        scales = {"rotor": self.disk, "wall": self.wall}
        return {f"{name} [{scales[name].unit}]": scales[name] for name in shown}


def _largest(*values: Array) -> float:
    """Return the largest magnitude, in the SI unit."""
    return max(float(np.max(np.abs(v[np.isfinite(v)]), initial=0.0)) for v in values)


Wheel = tuple[xr.Dataset, Points]
"""Result of a wheel, and its points."""


class Values(NamedTuple):
    """True values of a field on a wheel, see `Colouring`."""

    points: Array
    nodes: Array
    casing: Array


def colouring(
    wheels: Sequence[Wheel],
    field: Field,
    records: IntArray,
    per_element: int,
    *,
    rotating: bool,
) -> Colouring:
    """Return the values of a field at some records, of several wheels one after another.

    Args:
        wheels: result of each wheel, and the points of its bladed disk.
        field: field, or "part" for the parts of the stage.
        records: numbers of the records.
        per_element: number of pieces of an element of the casing, or of a rigid wall.
        rotating: true for velocities in rotating axes, false for static axes.

    Raises:
        ViewError: the field does not exist, or the stage does not have it.
        ResultError: strain or stress is requested of a result of an old format without
            cross-sections.
    """
    if field not in get_args(Field):
        raise ViewError(f"colour must be one of {', '.join(get_args(Field))}, got {field!r}")
    if field == "part":
        return _parts(wheels, records, per_element)
    found = _described(*wheels[0], field)
    each = [_values(*wheel, field, records, per_element, rotating=rotating) for wheel in wheels]
    values, nodes, casing = (np.concatenate(parts, axis=1) for parts in zip(*each, strict=True))
    if not found.signed:
        casing = np.abs(casing)
    normalised = is_normalised(wheels[0][0])
    largest = _largest(values, nodes), _largest(casing)

    parts = None
    if field == "joint-state":
        parts = {f"joint {name}": shade for name, shade in JOINT_STATES.items()}

    def scale(amount: float, colours: str) -> Scale:
        if parts is not None:
            return _numbered(parts)
        unit, factor = ("m/s", 1.0) if field == "velocity" else handy_unit(amount, found.unit)
        if normalised:
            unit, factor = "\N{EN DASH}", 1.0 / (max(largest) or 1.0)
        end, colours = scale_end(factor * amount), "signed" if found.signed else colours
        limits = (-end if found.signed else 0.0, end)
        return Scale(unit, factor, limits, COLOUR_MAPS[colours])

    name = f"{found.name} / largest one" if normalised else found.name
    return Colouring(
        name=name if parts is not None or max(largest) else f"{name}:\nzero everywhere",
        points=values,
        nodes=nodes,
        casing=casing,
        disk=scale(largest[0], "magnitude"),
        wall=scale(largest[1], "wall"),
        parts=parts,
    )


def _described(dataset: xr.Dataset, points: Points, field: Field) -> Recovered:
    """Return name and unit of a field, and whether it has a sign.

    Raises:
        ViewError: the stage does not have the field.
    """
    found = Recovered(field.replace("-", " "), "m", signed=False)
    if field in points.recovered:
        return points.recovered[field]
    if field in MAGNITUDES:
        return found._replace(unit="m/s" if field == "velocity" else "m")
    if field == "gap":
        coated = has(dataset, "coating")
        return found._replace(name="gap to the coating" if coated else "gap at the tip")
    if field == "wear":
        return found._replace(name="removed depth")
    if field in JOINT_FIELDS:
        return found._replace(**JOINT_FIELDS[field]._asdict())
    shown = ", ".join((*MAGNITUDES, *points.recovered, "gap", "wear", "part", *JOINT_FIELDS))
    raise ViewError(
        f'colour = "{field}": a superelement has no strains of its surface, and stress only if'
        f" its file has stress_recovery; expected {shown}"
    )


def _values(
    dataset: xr.Dataset,
    points: Points,
    field: Field,
    records: IntArray,
    per_element: int,
    *,
    rotating: bool,
) -> Values:
    """Return the values of a field on a wheel; a further wheel has no stress, and one without
    contact nodes has no wall."""
    values = np.full((len(records), len(points.rest), 1), np.nan)
    nodes = np.full((len(records), dataset.sizes["contact_node"]), np.nan)
    if field in points.recovered:
        values = points.recovered[field].at(records)
    elif field in MAGNITUDES:
        values = _magnitudes(dataset, points, field, records, rotating)[..., None]
    elif field == "gap":
        gap = history(dataset, "gap", records)
        if has(dataset, "coating"):
            gap = gap - coating_left(dataset, records)
        nodes = masked(dataset.isel(time=records), gap)
    elif field in JOINT_FIELDS:
        nodes = at_joint_nodes(dataset, field, records)
    casing = np.zeros((len(records), 0, 2))
    if dataset.sizes["contact_node"]:
        casing = _casing(dataset, points, field, records, per_element, rotating)
    values = np.array(np.broadcast_to(values, (*values.shape[:2], 2)))
    gone = dataset["time"].values[records] >= points.lost_from
    values[np.ix_(gone, points.lost.astype(np.int64))] = np.nan
    return Values(values, nodes, casing)


def is_normalised(dataset: xr.Dataset) -> bool:
    """Return whether the amplitude of a motion is arbitrary, as that of a mode."""
    return bool(dataset.attrs.get("normalised", 0))


def _magnitudes(
    dataset: xr.Dataset, points: Points, field: str, records: IntArray, rotating: bool
) -> Array:
    """Return the magnitude of a vector field at all points (record, point): of the displacement, of
    the deformation (displacement without the motion of the centre), or of the velocity in the axes
    of the picture."""
    values, velocity = [], field == "velocity"
    motions = history(dataset, "rotor_displacement", records)
    rates = history(dataset, "rotor_velocity", records) if velocity else motions
    spins = rotation.speeds(dataset)[records] * (not rotating)
    for motion, rate, spin in zip(motions, rates, spins, strict=True):
        vectors = points.moved(motion)
        if field == "deformation":
            vectors[:, :2] -= points.centre @ motion
        if velocity:
            turning = spin * rotate(vectors[:, :2], np.pi / 2)
            vectors = points.moved(rate)
            vectors[:, :2] += turning
        values.append(np.linalg.norm(vectors, axis=1))
    return np.array(values)


def _casing(
    dataset: xr.Dataset,
    points: Points,
    field: str,
    records: IntArray,
    per_element: int,
    rotating: bool,
) -> Array:
    """Return the values on both sides of the wall; NaN for gaps, and, but for wear, on a rigid
    wall."""
    angle = kinematics.wall_angles(dataset, per_element)
    if field == "wear":
        thickness = coating_of(dataset).thickness
        depth = thickness * kinematics.track_strains(dataset, records, angle)
        if points.flat:
            depth = depth.max(axis=1)
        # In space, stations of one track after another.
        return _on_both_sides(depth.reshape(len(records), -1))
    if field in ("gap", *JOINT_FIELDS) or not has(dataset, "casing"):
        return np.full((len(records), len(angle), 2), np.nan)
    if field not in MAGNITUDES:
        ring = casing_strain_rows(dataset, per_element)
        strains = ring.at(history(dataset, "casing_displacement", records))
        modulus = dataset["casing_young_modulus"].values[:, None]
        shown = strains.at_surfaces(field, modulus)[:, :, :-1]
        return np.asarray(shown.reshape(len(records), len(angle), 2))
    rows = rotate(kinematics.casing_rows(dataset, angle), angle[:, None], axis=1)
    if field == "deformation":
        rows = rows - rows.mean(axis=0)
    values = kinematics.combine(history(dataset, "casing_displacement", records), rows)
    if field == "velocity":
        spin = (-1.0 if rotating else 0.0) * rotation.speeds(dataset)[records][:, None, None]
        rate = kinematics.combine(history(dataset, "casing_velocity", records), rows)
        values = rate + spin * rotate(values, np.pi / 2)
    return _on_both_sides(np.linalg.norm(values, axis=-1))


def _parts(wheels: Sequence[Wheel], records: IntArray, per_element: int) -> Colouring:
    """Return the colouring by parts: the parts of the rotor in mesh order, then the casing. A
    surface is one part."""
    shown = dict(zip(wheels[0][1].parts, cycle(PART_COLOURS)))
    part = np.concatenate([points.part for _, points in wheels])
    nodes = sum(dataset.sizes["contact_node"] for dataset, _ in wheels)
    stations = len(wheels) * len(kinematics.wall_angles(wheels[0][0], per_element))
    all_parts = shown | {"casing": COLOURS["casing"]}
    scale = _numbered(all_parts)
    return Colouring(
        name="part",
        points=np.tile(part[:, None].astype(np.float64), (len(records), 1, 2)),
        nodes=np.full((len(records), nodes), np.nan),
        casing=np.full((len(records), stations, 2), float(len(shown))),
        disk=scale,
        wall=scale,
        parts=all_parts,
    )


def _numbered(colours: Mapping[str, str]) -> Scale:
    """Return the scale of numbers from 0 on that stand for names with colours."""
    return Scale("", 1.0, (-0.5, len(colours) - 0.5), ListedColormap([*colours.values()]))


def _on_both_sides(values: Array) -> Array:
    return np.repeat(values[..., None], 2, axis=-1)


def scale_end(largest: float) -> float:
    """Return a round end for a colour scale that begins at 0, at least `largest`; the quarters of
    the scale are numbers with few digits."""
    return rounded_up(largest, (1, 1.2, 1.6, 2, 2.4, 3.2, 4, 5, 6, 8, 10)) if largest else 1.0
