"""Colouring of the stage in a picture, by a field of a result or by parts.

The values are true values, independent of the exaggeration of the picture. The two sides of beams
and of the wall have different values, because bending strains differ; both sides of a point of a
surface have the same value.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import cycle
from typing import get_args

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.colors import Colormap, ListedColormap, to_hex

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields import kinematics, rotation
from bladewhirl.postprocess.fields.enlarged import rounded_up
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history
from bladewhirl.postprocess.fields.lost_blades import masked
from bladewhirl.postprocess.fields.points import Points, Recovered
from bladewhirl.postprocess.fields.strains import casing_strain_rows
from bladewhirl.postprocess.pictures.choices import Field
from bladewhirl.postprocess.plotting.style import COLOURS, LIT, SEQUENTIAL
from bladewhirl.postprocess.run.wear import coating_of

DIVERGING = "RdBu_r"  #: colour map of signed values, distinct for colour-blind readers
PART_COLOURS = tuple(
    COLOURS[name] for name in ("k = 0", "other k", "suspension", "k = 1", "contact", "rest")
)
"""Colours of the parts of the rotor, used cyclically; the casing has its own colour."""
MAGNITUDES = ("displacement", "deformation", "velocity")  #: fields that are sizes of vectors


@dataclass(frozen=True, kw_only=True)
class Colouring:
    """True values of a field in a picture; NaN where the field has no value."""

    name: str  #: label of the scale, without unit
    unit: str  #: unit of the scale; "" for parts
    scale: float  #: factor from the SI unit to `unit`
    points: Array  #: values of the points of the bladed disk (record, point, side)
    nodes: Array  #: values of the contact nodes (record, contact_node)
    casing: Array  #: values (record, station, side); the first station is not repeated at the end
    lit: bool = False  #: true if the bladed disk is a lit surface
    signed: bool = False  #: true if the scale contains negative values
    #: colours of parts by name; the values are then numbers of parts. None for a field
    parts: Mapping[str, str] | None = None

    @property
    def bodies(self) -> tuple[Array, Array, Array]:
        """Values of all bodies."""
        return self.points, self.nodes, self.casing

    @property
    def colour_map(self) -> Colormap:
        """Colour map of a field, or the colours of the parts."""
        if self.parts is not None:
            return ListedColormap([*self.parts.values()])
        if self.signed:
            return matplotlib.colormaps[DIVERGING]
        return matplotlib.colormaps[LIT if self.lit else SEQUENTIAL]

    def colours(self, levels: int) -> list[str]:
        """Return `levels` colours of the colour map, or the colours of the parts, as #rrggbb."""
        if self.parts is not None:
            return [*self.parts.values()]
        return [to_hex(shade) for shade in self.colour_map(np.linspace(0.0, 1.0, levels))]

    @property
    def limits(self) -> tuple[float, float]:
        """Ends of the colour scale in `unit`."""
        if self.parts is not None:
            return (-0.5, len(self.parts) - 0.5)
        end = scale_end(self.scale * self.largest)
        return (-end if self.signed else 0.0, end)

    @property
    def largest(self) -> float:
        """Largest magnitude of the values, in the SI unit."""
        sizes = [np.abs(values[np.isfinite(values)]) for values in self.bodies]
        return float(max(np.max(size, initial=0.0) for size in sizes))


def colouring(
    dataset: xr.Dataset,
    points: Points,
    field: Field,
    records: IntArray,
    per_element: int,
    *,
    rotating: bool,
) -> Colouring:
    """Return the values of a field at some records.

    Args:
        dataset: a result.
        points: points of the bladed disk.
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
    none = np.full((len(records), len(points.rest), 1), np.nan)
    nodes = np.full((len(records), dataset.sizes["contact_node"]), np.nan)
    coated = dataset.attrs.get("coating_thickness")
    found = Recovered(field.replace("-", " "), "m", signed=False)
    if field == "part":
        return _parts(dataset, points, records, per_element)
    if field in points.recovered:
        found = points.recovered[field]
        values = found.at(records)
    elif field in MAGNITUDES:
        found = found._replace(unit="m/s" if field == "velocity" else "m")
        values = _magnitudes(dataset, points, field, records, rotating)[..., None]
    elif field == "gap":
        found = found._replace(name="gap to metal" if coated else "gap at the tip")
        nodes = masked(dataset.isel(time=records), history(dataset, "gap", records))
        values = none
    elif field == "wear":
        found, values = found._replace(name="removed depth"), none
    else:
        shown = ", ".join((*MAGNITUDES, *points.recovered, "gap", "wear", "part"))
        raise ViewError(
            f'colour = "{field}": a superelement has no strains of its surface, and stress only if'
            f" its file has stress_recovery; expected {shown}"
        )
    casing = _casing(dataset, points, field, records, per_element, rotating)
    if not found.signed:
        casing = np.abs(casing)
    made = Colouring(
        name=found.name,
        unit="",
        scale=1.0,
        points=np.broadcast_to(values, (*values.shape[:2], 2)),
        nodes=nodes,
        casing=casing,
        lit=not points.flat,
        signed=found.signed,
    )
    if is_normalised(dataset):
        name, scale = f"{found.name} / largest one", 1.0 / (made.largest or 1.0)
        return replace(made, name=name, unit="\N{EN DASH}", scale=scale)
    unit, scale = ("m/s", 1.0) if field == "velocity" else handy_unit(made.largest, found.unit)
    return replace(made, unit=unit, scale=scale)


def is_normalised(dataset: xr.Dataset) -> bool:
    """Return whether the amplitude of a motion is arbitrary, as that of a mode."""
    return bool(dataset.attrs.get("normalised", 0))


def _magnitudes(
    dataset: xr.Dataset, points: Points, field: str, records: IntArray, rotating: bool
) -> Array:
    """Return the magnitude of a vector field at all points (record, point): of the displacement, of
    the deformation (displacement without the motion of the centre), or of the velocity in the axes
    of the picture."""
    values = []
    for record in records:
        motion = dataset["rotor_displacement"][record].values
        vectors = points.moved(motion)
        if field == "deformation":
            vectors[:, :2] -= points.centre @ motion
        if field == "velocity":
            spin = 0.0 if rotating else rotation.speeds(dataset)[record]
            rate = points.moved(dataset["rotor_velocity"][record].values)
            rate[:, :2] += spin * rotate(vectors[:, :2], np.pi / 2)
            vectors = rate
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
    if field == "gap" or "casing_shape" not in dataset:
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


def _parts(dataset: xr.Dataset, points: Points, records: IntArray, per_element: int) -> Colouring:
    """Return the colouring by parts: the parts of the rotor in mesh order, then the casing. A
    surface is one part."""
    shown = dict(zip(points.parts, cycle(PART_COLOURS)))
    part = np.broadcast_to(points.part[:, None], (len(records), len(points.part), 2))
    stations = len(kinematics.wall_angles(dataset, per_element))
    return Colouring(
        name="part",
        unit="",
        scale=1.0,
        points=part.astype(np.float64),
        nodes=np.full((len(records), dataset.sizes["contact_node"]), np.nan),
        casing=np.full((len(records), stations, 2), float(len(shown))),
        lit=not points.flat,
        parts=shown | {"casing": COLOURS["casing"]},
    )


def _on_both_sides(values: Array) -> Array:
    return np.repeat(values[..., None], 2, axis=-1)


def scale_end(largest: float) -> float:
    """Return a round end for a colour scale that begins at 0, at least `largest`; the quarters of
    the scale are numbers with few digits."""
    return rounded_up(largest, (1, 1.2, 1.6, 2, 2.4, 3.2, 4, 5, 6, 8, 10)) if largest else 1.0
