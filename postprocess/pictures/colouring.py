"""Colouring of the stage in a picture, by a field of a result or by parts.

The values are true values, independent of the exaggeration of the picture. The two sides of beams
and of the wall have different values, because bending strains differ. A surface has a value at each
point.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import cycle
from typing import NamedTuple, get_args

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.colors import Colormap, ListedColormap, to_hex

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields import kinematics, rotation
from bladewhirl.postprocess.fields.blades import line_blades
from bladewhirl.postprocess.fields.by_blade import of_blades
from bladewhirl.postprocess.fields.enlarged import rounded_up
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history
from bladewhirl.postprocess.fields.nodes import copy_coordinates, point_blades, point_vectors
from bladewhirl.postprocess.fields.point_stresses import PointStresses, has_stresses
from bladewhirl.postprocess.fields.strains import (
    Strains,
    casing_strain_rows,
    rotor_sections,
    rotor_strain_rows,
)
from bladewhirl.postprocess.pictures.choices import Field
from bladewhirl.postprocess.plotting.style import COLOURS, LIT, SEQUENTIAL
from bladewhirl.postprocess.run.wear import coating_of

DIVERGING = "RdBu_r"  #: colour map of signed values, distinct for colour-blind readers
PART_COLOURS = tuple(
    COLOURS[name] for name in ("k = 0", "other k", "suspension", "k = 1", "contact", "rest")
)
"""Colours of the parts of the rotor, used cyclically; the casing has its own colour."""
MAGNITUDES = ("displacement", "deformation", "velocity")  #: fields that are sizes of vectors


class Stations(NamedTuple):
    """Numbers of straight pieces in drawn beams and in the drawn wall."""

    per_line: int  #: number of pieces of a beam
    per_element: int  #: number of pieces of an element of the casing


@dataclass(frozen=True, kw_only=True)
class Colouring:
    """True values of a field in a picture; NaN where the field has no value."""

    name: str  #: label of the scale, without unit
    unit: str  #: unit of the scale; "" for parts
    scale: float  #: factor from the SI unit to `unit`
    rotor: Array  #: values (record, line, station, side)
    surface: Array  #: values (record, point)
    casing: Array  #: values (record, station, side); the first station is not repeated at the end
    signed: bool = False  #: true if the scale contains negative values
    #: colours of parts by name; the values are then numbers of parts. None for a field
    parts: Mapping[str, str] | None = None

    @property
    def bodies(self) -> tuple[Array, Array, Array]:
        """Values of all bodies."""
        return self.rotor, self.surface, self.casing

    @property
    def colour_map(self) -> Colormap:
        """Colour map of a field, or the colours of the parts."""
        if self.parts is not None:
            return ListedColormap([*self.parts.values()])
        if self.signed:
            return matplotlib.colormaps[DIVERGING]
        return matplotlib.colormaps[LIT if self.surface.size else SEQUENTIAL]

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
    dataset: xr.Dataset, field: Field, records: IntArray, stations: Stations, rotating: bool
) -> Colouring:
    """Return the values of a field at some records; velocities are in rotating or static axes.

    Raises:
        ViewError: the field does not exist, or needs beams.
        ResultError: strain or stress is requested of a result of an old format without
            cross-sections.
    """
    if field not in get_args(Field):
        raise ViewError(f"colour must be one of {', '.join(get_args(Field))}, got {field!r}")
    if field == "part":
        return _parts(dataset, records, stations)
    if "rotor_line" in dataset:
        surface = np.zeros((len(records), 0))
        if field == "gap":
            rotor = _gap(dataset, records, stations)
        elif field == "wear":
            rotor = np.full(
                (len(records), len(dataset["rotor_line"]), stations.per_line + 1, 2), np.nan
            )
        elif field in MAGNITUDES:
            rotor = _beam_magnitude(dataset, field, records, stations, rotating)
        else:
            rotor = _beam_strain(dataset, field, records, stations)
    else:
        rotor = np.zeros((len(records), 0, stations.per_line + 1, 2))
        surface = _surface(dataset, field, records, rotating)
    casing = _casing(dataset, field, records, stations, rotating)
    if field == "stress" and "rotor_line" not in dataset:
        casing = np.abs(casing)  # beside the von Mises stress of the surface
    base = {"velocity": "m/s", "stress": "Pa"}.get(field, "m/m" if "strain" in field else "m")
    known = [np.abs(values[np.isfinite(values)]) for values in (rotor, surface, casing)]
    largest = float(max(np.max(values, initial=0.0) for values in known))
    unit, scale = ("m/s", 1.0) if field == "velocity" else handy_unit(largest, base)
    surfaces = "rotor_line" not in dataset
    names = {
        "stress": "von Mises stress" if surfaces else "surface stress",
        "gap": "gap to metal" if dataset.attrs.get("coating_thickness") else "gap at the tip",
        "wear": "removed depth",
    }
    return Colouring(
        name=names.get(field, field.replace("-", " ")),
        unit=unit,
        scale=scale,
        rotor=rotor,
        surface=surface,
        casing=casing,
        signed=field in ("axial-strain", "bending-strain") or (field == "stress" and not surfaces),
    )


def _beam_magnitude(
    dataset: xr.Dataset, field: str, records: IntArray, stations: Stations, rotating: bool
) -> Array:
    """Return the magnitude of a vector field of beams: of the displacement, of the deformation
    (displacement without the mean motion of the body), or of the velocity in the axes of the
    picture."""
    _, rows = kinematics.line_rows(dataset, stations.per_line)
    centre = dataset["rotor_shape"].values[int(dataset["centre_node"]), :2]
    beams = rows.reshape(-1, 2, rows.shape[-1])
    spin = (0.0 if rotating else 1.0) * rotation.speeds(dataset)[records]
    values = _magnitude(dataset, "rotor", field, records, beams, centre, spin)
    return _on_both_sides(values.reshape(len(records), *rows.shape[:2]))


def _magnitude(
    dataset: xr.Dataset,
    body: str,
    field: str,
    records: IntArray,
    shape: Array,
    mean: Array,
    spin: Array,
) -> Array:
    """Return the magnitude of a vector field of a body (record, point), whose axes turn at the
    speed `spin` (record,) [rad/s] in the axes of the picture. `shape` and `mean` are its
    displacements (point, 2, mode) and mean motion (2, mode) for unit modal coordinates."""
    shown = shape - mean if field == "deformation" else shape
    values = kinematics.combine(history(dataset, f"{body}_displacement", records), shown)
    if field == "velocity":
        rate = kinematics.combine(history(dataset, f"{body}_velocity", records), shown)
        values = rate + spin[:, None, None] * rotate(values, np.pi / 2)
    return np.asarray(np.linalg.norm(values, axis=-1))


def _surface(dataset: xr.Dataset, field: str, records: IntArray, rotating: bool) -> Array:
    """Return the values at all points of a surface, (record, point)."""
    if field == "wear":
        return np.full((len(records), len(point_blades(dataset))), np.nan)
    if field == "gap":
        gap = of_blades(dataset, history(dataset, "gap", records), np.minimum)
        return np.asarray(gap[:, point_blades(dataset)])
    if field == "stress" and has_stresses(dataset):
        stresses = PointStresses(dataset)
        return np.concatenate([stresses.at(np.array([record])) for record in records])
    if field not in MAGNITUDES:
        shown = ", ".join((*MAGNITUDES, "gap", "wear", "part"))
        raise ViewError(
            f'colour = "{field}": a superelement has no strains of its surface, and stress only if'
            f" its file has stress_recovery; expected {shown}"
        )
    values = []
    for record in records:
        spin = 0.0 if rotating else rotation.speeds(dataset)[record]
        at = np.array([record])
        motion = copy_coordinates(dataset, "rotor_displacement", at)[0]
        vectors = point_vectors(dataset, motion)
        if field == "deformation" and "centre_shape" in dataset:
            vectors[:, :2] -= motion.ravel() @ dataset["centre_shape"].values.T
        if field == "velocity":
            rate = point_vectors(dataset, copy_coordinates(dataset, "rotor_velocity", at)[0])
            rate[:, :2] += spin * rotate(vectors[:, :2], np.pi / 2)
            vectors = rate
        values.append(np.linalg.norm(vectors, axis=1))
    return np.array(values)


def _casing(
    dataset: xr.Dataset, field: str, records: IntArray, stations: Stations, rotating: bool
) -> Array:
    """Return the values on both sides of the wall; NaN for gaps, and, but for wear, on a rigid
    wall."""
    if field == "wear":
        thickness = coating_of(dataset).thickness
        angle = kinematics.wall_angles(dataset, stations.per_element)
        if "rotor_line" in dataset:
            depth = kinematics.coating_strain_at(dataset, records, angle)
        else:  # stations of one track after another
            depth = kinematics.track_strains(dataset, records, angle).reshape(len(records), -1)
        return _on_both_sides(thickness * depth)
    wall = (len(records), stations.per_element * dataset.sizes.get("casing_node", 1), 2)
    if field == "gap" or "casing_shape" not in dataset:
        return np.full(wall, np.nan)
    if field not in MAGNITUDES:
        ring = casing_strain_rows(dataset, stations.per_element)
        strains = ring.at(history(dataset, "casing_displacement", records))
        modulus = dataset["casing_young_modulus"].values[:, None]
        return _at_surfaces(strains, field, modulus)[:, :, :-1].reshape(wall)
    angle = kinematics.ring_angles(dataset, stations.per_element)
    rows = rotate(kinematics.casing_rows(dataset, angle), angle[:, None], axis=1)
    spin = (-1.0 if rotating else 0.0) * rotation.speeds(dataset)[records]
    return _on_both_sides(
        _magnitude(dataset, "casing", field, records, rows, rows.mean(axis=0), spin)
    )


def _beam_strain(dataset: xr.Dataset, field: str, records: IntArray, stations: Stations) -> Array:
    """Return axial or bending strain, or surface stress, of beams."""
    beams = rotor_strain_rows(dataset, stations.per_line)
    strains = beams.at(history(dataset, "rotor_displacement", records))
    modulus = rotor_sections(dataset, "young_modulus", stations.per_line)
    return _at_surfaces(strains, field, modulus)


def _at_surfaces(strains: Strains, field: str, modulus: Array) -> Array:
    """Return axial strain, bending strain or stress (record, element, station, side). The first
    side is the right side of beams and the inner side of the casing."""
    bend = strains.bending[..., None] * np.array([1.0, -1.0])
    axial = strains.axial[..., None] + 0.0 * bend
    if field == "bending-strain":
        return np.asarray(bend)
    if field == "axial-strain":
        return np.asarray(axial)
    return np.asarray(modulus[..., None] * (axial + bend))


def _gap(dataset: xr.Dataset, records: IntArray, stations: Stations) -> Array:
    """Return the gap at the tip of a blade for all stations of the blade; NaN on other parts."""
    gap, blade = history(dataset, "gap", records), line_blades(dataset)
    values = np.where(blade >= 0, gap[:, blade], np.nan)
    return _on_both_sides(np.repeat(values[:, :, None], stations.per_line + 1, axis=2))


def _parts(dataset: xr.Dataset, records: IntArray, stations: Stations) -> Colouring:
    """Return the colouring by parts: the parts of the rotor in mesh order, then the casing. A
    surface is one part."""
    part = dataset["rotor_part"].values.astype(str) if "rotor_part" in dataset else np.array([])
    names = list(dict.fromkeys(part)) or ["bladed disk"]
    number = np.array([names.index(name) for name in part], dtype=np.float64)
    shape = (len(records), len(part), stations.per_line + 1)
    points = dataset.sizes.get("copy", 0) * dataset.sizes.get("point", 0)
    wall = (len(records), stations.per_element * dataset.sizes.get("casing_node", 1))
    shown = {name or "other beams": colour for name, colour in zip(names, cycle(PART_COLOURS))}
    return Colouring(
        name="part",
        unit="",
        scale=1.0,
        rotor=_on_both_sides(np.broadcast_to(number[:, None], shape)),
        surface=np.zeros((len(records), points)),
        casing=_on_both_sides(np.full(wall, float(len(names)))),
        parts=shown | {"casing": COLOURS["casing"]},
    )


def _on_both_sides(values: Array) -> Array:
    return np.repeat(values[..., None], 2, axis=-1)


def scale_end(largest: float) -> float:
    """Return a round end for a colour scale that begins at 0, at least `largest`; the quarters of
    the scale are numbers with few digits."""
    return rounded_up(largest, (1, 1.2, 1.6, 2, 2.4, 3.2, 4, 5, 6, 8, 10)) if largest else 1.0
