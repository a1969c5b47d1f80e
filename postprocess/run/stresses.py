"""Stresses in blades, disk and casing over time, and their extremes.

The stress of beams and of the casing is Young's modulus times the strain, see `strains`. It does
not include yielding, stress concentration where beams meet, and centrifugal stress. The stress at a
surface is the axial stress plus or minus the bending stress. That of superelements is the von Mises
stress, see `point_stresses`.

The stress at a point is split into its mean over the records and the alternating stress, the
largest deviation from the mean. For one component these are at least as severe as the middle and
half of the range: on the diagram of Haigh they move along the larger of two slopes. Those of solids
are the von Mises stress of the mean of the six components and the largest von Mises stress of their
deviation from it.
"""

from collections import deque
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.models.inputs.progress import tracked
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.by_blade import blade_count, blade_length
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.point_stresses import PointStresses, has_stresses, size_of
from bladewhirl.postprocess.fields.points import Points, contact_nodes, points_of
from bladewhirl.postprocess.fields.result import portions
from bladewhirl.postprocess.fields.strains import (
    Strains,
    casing_strain_rows,
    rotor_sections,
    rotor_strain_rows,
)
from bladewhirl.postprocess.fields.wheels import of_wheel, wheel_numbers
from bladewhirl.postprocess.fields.windows import in_window, span_starts
from bladewhirl.postprocess.plotting.axes import blade_axis
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    new_figure,
    side_by_side,
    styled,
    time_axis,
)
from bladewhirl.postprocess.plotting.titles import head

CASING_PIECES = 4
"""Number of pieces of a casing element. Strains are computed at the ends of the pieces, because
they are not linear in the element."""

PORTION_BYTES = 4e6  #: size of the strains computed in one matrix product [bytes]
CACHED_BYTES = 1e6
"""Size of the strains whose extremes are computed together [bytes]; it fits into the cache of a
processor core."""

NEAR = 0.1
"""Distance from the nearest contact node, divided by the length of a blade, up to which points of
solids are left out."""

COLUMNS = 1000  #: largest number of time spans of a curve; the largest value of a span is drawn
UNITS = {
    "axial_strain": "1",
    "axial_stress": "Pa",
    "bending_strain": "1",
    "bending_stress": "Pa",
    "largest_stress": "Pa",
    "smallest_stress": "Pa",
}
"""Histories of every member, with their units."""

PEAKS = {
    "peak_stress": "Pa",
    "peak_time": "s",
    "peak_radius": "m",
    "mean_stress": "Pa",
    "alternating_stress": "Pa",
    "split_radius": "m",
}
"""Extremes of every member, with their units."""

LIMITS = ("endurance", "strength")
"""Attributes with the lowest limits of the alternating and of the mean stress of the case [Pa]."""


class _Portion(Protocol):
    """Stresses of a body at a few records; points are sorted by members."""

    @property
    def size(self) -> Array:
        """Largest magnitude of the stress at a surface [Pa], (point, record)."""

    def sign(self, point: int, record: int) -> float:
        """Return the sign of the stress of this magnitude."""

    @property
    def deviation(self) -> Array:
        """Largest deviation of the stress from its mean over all records [Pa], (side, point)."""

    def extremes(self, starts: IntArray) -> dict[str, Array]:
        """Return histories of members (member, record) by their names in `UNITS`, from the first
        point of each member."""


class _BeamPortion(NamedTuple):
    """Axial strain and bending strain at the right surface of beams [1], (point, record), with
    their means over all records (point,) and Young's modulus (point, 1) [Pa]."""

    axial: Array
    bending: Array
    means: tuple[Array, Array]
    modulus: Array

    @property
    def size(self) -> Array:
        return np.asarray(self.modulus * (np.abs(self.axial) + np.abs(self.bending)))

    @property
    def deviation(self) -> Array:
        axial, bending = self.means
        sides = (
            (self.axial + self.bending, axial + bending),
            (self.axial - self.bending, axial - bending),
        )
        largest = [np.maximum(side.max(1) - mean, mean - side.min(1)) for side, mean in sides]
        return np.asarray(self.modulus[:, 0] * largest)

    def sign(self, point: int, record: int) -> float:
        return 1.0 if self.axial[point, record] >= 0 else -1.0

    def extremes(self, starts: IntArray) -> dict[str, Array]:
        bending = np.abs(self.bending)
        stress, bent = self.modulus * self.axial, self.modulus * bending
        return {
            "axial_strain": _largest(self.axial, starts),
            "axial_stress": _largest(stress, starts),
            "bending_strain": _maximum(bending, starts),
            "bending_stress": _maximum(bent, starts),
            "largest_stress": _maximum(stress + bent, starts),
            "smallest_stress": -_maximum(bent - stress, starts),
        }


class _SolidPortion(NamedTuple):
    """Von Mises stress at the surface of solids."""

    size: Array  #: (point, record) [Pa]
    deviation: Array  #: (1, point) [Pa]

    def sign(self, point: int, record: int) -> float:
        return 1.0

    def extremes(self, starts: IntArray) -> dict[str, Array]:
        return {"largest_stress": _maximum(self.size, starts)}


class _Body(NamedTuple):
    """Bladed disk or casing."""

    radius: Array  #: radius of each point in the undeformed body, sorted by members (point,) [m]
    starts: IntArray  #: first point of each member
    columns: IntArray  #: numbers of these members among those of both bodies
    mean: Array  #: mean over all records (side, point) [Pa]; nan where parts are lost
    portions: Iterator[tuple[slice, _Portion]]  #: records, and the stresses at them


def stress_history(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute the largest stresses and strains in every blade, every other part of the rotor and
    the casing.

    Args:
        result: result of a run.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (time, member); members are "blade 0" and so on, the other parts of the rotor,
        and "casing" if it is flexible. `axial_stress` [Pa] and `axial_strain` [1]: the value of
        largest magnitude in the member, signed. `bending_stress` [Pa] and `bending_strain` [1]: the
        largest magnitude at a surface. `largest_stress` and `smallest_stress` [Pa]: extremes at the
        surfaces. Over
        member only: `peak_stress` [Pa], the surface stress of largest magnitude at any time,
        signed, the time `peak_time` [s], and the radius of the point in the undeformed body,
        `peak_radius` [m]; `mean_stress` and `alternating_stress` [Pa], the split at the point, at
        the radius `split_radius` [m], with the largest `utilisation` of the limits
        `material.endurance` and `material.strength` or, without them, the largest sum of both; nan
        for lost members. Blades of a superelement whose file gives the recovery of stress have
        the von Mises stress at the surface as `largest_stress` and `peak_stress`, at points whose
        distance from contact nodes is more than a tenth of the length of a blade, with the stress
        of steady rotation if the case has effects of rotation; the other variables are nan.

    Raises:
        ViewError: the file of a superelement gives no recovery of stress.

    Example:
        ``stress_history(result)["largest_stress"].sel(member="blade 3").plot()``
    """
    dataset = in_window(result, start, end)
    names, bodies = _bodies(dataset)
    time = dataset["time"].values
    out = {name: np.full((len(time), len(names)), np.nan) for name in UNITS}
    peak = {name: np.zeros(len(names)) for name in PEAKS}
    for body in bodies:
        for records, portion in _noted(peak, body, dataset):
            for name, values in portion.extremes(body.starts).items():
                out[name][records, body.columns] = values.T
    plane = ("time", "member")
    return labelled(
        dataset,
        f"stresses, linear, {about(dataset)['measure']}",
        {
            **{name: (plane, values, UNITS[name]) for name, values in out.items()},
            **{name: ("member", values, PEAKS[name]) for name, values in peak.items()},
        },
        {"time": time, "member": names},
        blades=blade_count(dataset),
        **about(dataset),
    )


def known_peaks(dataset: xr.Dataset, *, casing: bool = True) -> xr.Dataset | None:
    """Return `peak_stresses`; None for a stage whose stresses are not known."""
    return peak_stresses(dataset, casing=casing) if has_stresses(dataset) else None


def peak_stresses(dataset: xr.Dataset, *, casing: bool = True) -> xr.Dataset:
    """Compute only the variables over members of `stress_history`, by their names in `PEAKS`, with
    or without those of a flexible casing."""
    names, bodies = _bodies(dataset, casing=casing)
    peak = {name: np.zeros(len(names)) for name in PEAKS}
    for body in bodies:
        deque(_noted(peak, body, dataset), maxlen=0)
    variables = {name: ("member", values) for name, values in peak.items()}
    return xr.Dataset(variables, {"member": names}, about(dataset))


def utilisation(mean: Array, alternating: Array, limits: Mapping[Any, float]) -> Array:
    """Return the utilisation a / e + max(m, 0) / s of the straight line of Goodman between the
    endurance limit e and the tensile strength s, for a mean stress m and an alternating stress a
    [Pa]; the margin is its reciprocal. A compressive mean stress has no effect. Without both limits
    in `limits` they are 1 Pa, so that the result is the largest tensile stress."""
    both = set(LIMITS) <= limits.keys()
    endurance, strength = (limits[name] if both else 1.0 for name in LIMITS)
    return alternating / endurance + np.maximum(mean, 0.0) / strength


def about(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the measure of the largest stress of the bladed disk, that of beam theory or the von
    Mises stress at the surface of solids, whether it has the stress of steady rotation, and the
    limits of the material that the case gives."""
    measures = "von Mises stress away from contact nodes", "beam theory"
    points = points_of(dataset, 1)
    return {
        "measure": measures[points.flat],
        "steady": int(points.recovered["stress"].steady),
        **{name: dataset.attrs[name] for name in LIMITS if name in dataset.attrs},
    }


def _bodies(dataset: xr.Dataset, *, casing: bool = True) -> tuple[list[str], list[_Body]]:
    """Return the names of the members of the bladed disk and of a casing, and the bodies."""
    points = points_of(dataset, 1)
    if "stress" not in points.recovered:
        raise ViewError("expected beams, or a superelement whose file has stress_recovery")
    rotor = _beams(dataset, points) if points.flat else _solid(dataset, points)
    used = np.unique(points.member[points.member >= 0])
    names = [points.members[number] for number in used]
    bodies = [rotor._replace(columns=np.searchsorted(used, rotor.columns))]
    if not (casing and has(dataset, "casing")):
        return names, bodies
    stations = CASING_PIECES + 1
    modulus = np.repeat(dataset["casing_young_modulus"].values, stations)[:, None]
    rings = [of_wheel(dataset, number) for number in wheel_numbers(dataset)]
    each = [casing_strain_rows(ring, CASING_PIECES) for ring in rings]
    kinds = zip(*each, strict=True)
    rows = Strains(*(np.concatenate([_flat(row) for row in kind]) for kind in kinds))
    radius = [ring.attrs["casing_radius"] for ring in rings]
    wall = _Body(
        np.repeat(radius, [stations * ring.sizes["casing_node"] for ring in rings]),
        np.zeros(1, dtype=np.int64),
        np.array([len(names)]),
        *_strains(dataset, "casing_displacement", rows, modulus),
    )
    return [*names, "casing"], [*bodies, wall]


def _beams(dataset: xr.Dataset, points: Points) -> _Body:
    """Return the bladed disk of beams."""
    first = len(points.rest) - points.thickness.size
    order = np.argsort(points.member[first:], kind="stable")
    members, starts = np.unique(points.member[first:][order], return_index=True)
    rows = Strains(*(_flat(row)[order] for row in rotor_strain_rows(dataset)))
    modulus = rotor_sections(dataset, "young_modulus", 1).reshape(-1, 1)[order]
    lost = np.flatnonzero(np.isin(order + first, points.lost))
    lost_parts = points.lost_from, lost
    mean, portions = _strains(dataset, "rotor_displacement", rows, modulus, lost_parts)
    radius = np.linalg.norm(points.rest[first:][order], axis=-1)
    return _Body(radius, starts, members, mean, portions)


def _solid(dataset: xr.Dataset, points: Points) -> _Body:
    """Return the surface of solids, without points near contact nodes, on which the stress of a
    fine mesh has no limit."""
    from scipy.spatial import KDTree  # long to load

    distance = KDTree(contact_nodes(dataset)).query(points.rest)[0]
    order = np.argsort(points.blade, kind="stable")
    order = order[distance[order] > NEAR * blade_length(dataset)]
    blades, starts = np.unique(points.blade[order], return_index=True)

    stresses = PointStresses(dataset)
    motion, force = (_mean(dataset, name) for name in ("rotor_displacement", "contact_force"))
    terms_of_mean = stresses.terms(motion[None], force[None])
    mean = size_of(terms_of_mean)
    mean[:, points.lost.astype(np.int64)] = np.nan

    def values() -> Iterator[tuple[slice, _Portion]]:
        for read in tracked("stresses", [*portions(dataset, stresses.together)]):
            records = np.arange(read.start, read.stop)
            terms = stresses.terms_at(records)
            size = stresses.at(records, terms)[:, order].T
            deviation = size_of(terms - terms_of_mean).max(axis=0, keepdims=True)
            yield read, _SolidPortion(size, deviation[:, order])

    radius = np.hypot(*points.rest[order, :2].T)
    return _Body(radius, starts, blades, mean[:, order], values())


def _mean(dataset: xr.Dataset, name: str) -> Array:
    """Return the mean of a history over all records, which is read portion by portion."""
    sums = [dataset[name].isel(time=read).values.sum(axis=0) for read in portions(dataset)]
    return np.asarray(np.sum(sums, axis=0) / dataset.sizes["time"])


def _flat(rows: Array) -> Array:
    """Return rows of elements and their stations as rows of points."""
    return np.asarray(rows.reshape(-1, rows.shape[-1]))


def _strains(
    dataset: xr.Dataset,
    history: str,
    rows: Strains,
    modulus: Array,
    lost: tuple[float, IntArray] = (np.inf, np.zeros(0, dtype=np.int64)),
) -> tuple[Array, Iterator[tuple[slice, _Portion]]]:
    """Return the mean stress of beams (side, point) [Pa] and, for a few records at a time, their
    strains.

    Args:
        dataset: a result.
        history: name of the variable with the modal displacements.
        rows: strains of the points for unit modal coordinates (point, mode).
        modulus: Young's modulus at the points (point, 1) [Pa].
        lost: time from which points are lost [s], and these points, whose strain is then zero.
    """
    middle = _mean(dataset, history)
    means = rows.axial @ middle, rows.bending @ middle
    mean = modulus[:, 0] * [means[0] + means[1], means[0] - means[1]]
    mean[:, lost[1]] = np.nan
    together, cached = (
        max(1, int(size / (8 * len(modulus)))) for size in (PORTION_BYTES, CACHED_BYTES)
    )

    def values() -> Iterator[tuple[slice, _Portion]]:
        for read in portions(dataset, together):
            coordinates = dataset[history].isel(time=read).values.T
            axial, bending = rows.axial @ coordinates, rows.bending @ coordinates
            gone = np.flatnonzero(dataset["time"].values[read] >= lost[0])
            axial[np.ix_(lost[1], gone)] = 0.0
            bending[np.ix_(lost[1], gone)] = 0.0
            for first in range(0, axial.shape[1], cached):
                part = slice(first, first + cached)
                records = slice(read.start + first, min(read.start + part.stop, read.stop))
                yield records, _BeamPortion(axial[:, part], bending[:, part], means, modulus)

    return mean, values()


def _maximum(values: Array, starts: IntArray) -> Array:
    """Return the largest value in each member (member, record), from values (point, record)."""
    return np.asarray(np.maximum.reduceat(values, starts, axis=0))


def _largest(values: Array, starts: IntArray) -> Array:
    """Return the value of largest magnitude in each member, signed, (member, record)."""
    high, low = _maximum(values, starts), np.minimum.reduceat(values, starts, axis=0)
    return np.where(high >= -low, high, low)


def _noted(
    peak: dict[str, Array], body: _Body, dataset: xr.Dataset
) -> Iterator[tuple[slice, _Portion]]:
    """Yield the portions of a body, and note the extremes of its members, see `PEAKS`."""
    time = dataset["time"].values
    alternating = np.zeros_like(body.mean)
    for records, portion in body.portions:
        _note_peaks(peak, body, time[records], portion)
        np.maximum(alternating, portion.deviation, out=alternating)
        yield records, portion
    alternating[np.isnan(body.mean)] = np.nan
    used = np.nan_to_num(utilisation(body.mean, alternating, about(dataset)), nan=-np.inf)
    ranges = pairwise([*body.starts, body.mean.shape[1]])
    for column, (first, end) in zip(body.columns, ranges, strict=True):
        side, point = np.unravel_index(used[:, first:end].argmax(), (len(used), end - first))
        place = side, first + point
        peak["mean_stress"][column] = body.mean[place]
        peak["alternating_stress"][column] = alternating[place]
        peak["split_radius"][column] = body.radius[place[1]]


def _note_peaks(peak: dict[str, Array], body: _Body, time: Array, portion: _Portion) -> None:
    """Update the peak stresses of the members of a body with a portion of records."""
    size = portion.size
    ranges = pairwise([*body.starts, len(size)])
    for column, (first, end) in zip(body.columns, ranges, strict=True):
        stress = size[first:end]
        point, record = np.unravel_index(int(stress.argmax()), stress.shape)
        if stress[point, record] <= abs(peak["peak_stress"][column]):
            continue
        sign = portion.sign(first + int(point), int(record))
        peak["peak_stress"][column] = sign * stress[point, record]
        peak["peak_time"][column] = time[record]
        peak["peak_radius"][column] = body.radius[first + point]


@styled
def plot_stress(history: xr.Dataset) -> Figure:
    """Draw the largest stress in blades, other parts and casing over time, and the extremes of the
    stress in every blade, from `stress_history`."""
    blades = int(history.attrs["blades"])
    figure = new_figure(width=FULL_WIDTH, height=0.065)
    over_time, *others = side_by_side(figure, min(blades, 2))
    size = np.fmax(history["largest_stress"].values, -history["smallest_stress"].values)
    unit, scale = handy_unit(float(size.max()), "Pa")
    _draw_time(over_time, history, scale * size, blades)
    over_time.set(ylabel=f"largest stress [{unit}]", ylim=(0, None))
    over_time.set_title("largest at any place")
    time_axis(over_time)
    for over_blades in others:
        _draw_blades(over_blades, history.isel(member=slice(0, blades)), scale)
        over_blades.set(ylabel=f"stress [{unit}]", title="extremes of each blade")
    what = "stress at surfaces by beam theory"
    if history.attrs["measure"] != "beam theory":
        what = f"{history.attrs['measure']} of blades"
        what += ", with that of steady rotation" if history.attrs["steady"] else ""
    head(figure, history, what)
    legends_below(figure, *(Group(entries_of(axes)) for axes in (over_time, *others)))
    return figure


LINES = (
    (COLOURS["k = 1"], "--"),
    (COLOURS["suspension"], "-."),
    (COLOURS["k = 0"], ":"),
    (COLOURS["contact"], (0, (5, 1, 1, 1, 1, 1))),
    (COLOURS["other k"], (0, (1, 1))),
)


def _draw_time(axes: Axes, history: xr.Dataset, size: Array, blades: int) -> None:
    """Draw the largest stress in each span of time, for all blades together and for each other
    member."""
    time = history["time"].values
    starts = span_starts(time, COLUMNS)
    shown = np.maximum.reduceat(size, starts, axis=0)
    at = time[np.append(starts[1:], len(time)) - 1]
    names = history["member"].values.astype(str)[blades:].tolist()
    for number, name in enumerate(name for name in names if name != "casing"):
        colour, dashes = LINES[number % len(LINES)]
        axes.plot(at, shown[:, blades + number], color=colour, linestyle=dashes, label=name)
    if "casing" in names:
        axes.plot(at, shown[:, -1], color=COLOURS["casing"], label="casing")
    axes.plot(at, shown[:, :blades].max(axis=1), color=COLOURS["rotor"], label="blades")


def _draw_blades(axes: Axes, history: xr.Dataset, scale: float) -> None:
    """Draw for every blade a bar from the smallest to the largest surface stress, and dashes at the
    smallest and largest axial stress."""
    blade = np.arange(history.sizes["member"])
    ends = [
        (scale * history[low].min("time").values, scale * history[high].max("time").values)
        for low, high in (("smallest_stress", "largest_stress"), ("axial_stress", "axial_stress"))
    ]
    bottom, top = np.fmin(ends[0][0], 0.0), np.fmax(ends[0][1], 0.0)
    axes.bar(blade, top - bottom, 0.8, bottom, color=COLOURS["rest"], label="at a surface")
    blade_axis(axes, len(blade))
    if history.attrs["measure"] != "beam theory":
        axes.set_ylim(0.0, 1.1 * top.max() or 1.0)
        return
    for axial, label in zip(ends[1], ("axial alone", None), strict=True):
        axes.plot(blade, axial, "_", markersize=4.0, color=COLOURS["k = 0"], label=label)
    reach = 1.1 * scale * float(abs(history["peak_stress"]).max()) or 1.0
    axes.set_ylim(-reach, reach)
    axes.axhline(0.0, color="black", linewidth=0.6)
