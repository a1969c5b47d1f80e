"""A stage in words: its sizes, and what holds it and hangs on it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.beam_sections import rotor_sections
from bladewhirl.postprocess.fields.fields import Array
from bladewhirl.postprocess.plotting.units import length_unit


def size_words(dataset: xr.Dataset) -> list[str]:
    """Number of blades, radius and clearance, in words."""
    clearance = dataset["clearance"].values
    return [
        f"{dataset.sizes['blade']} blades",
        f"tip radius {_length(float(dataset.attrs['tip_radius']))}",
        f"clearance {_range(clearance)}",
    ]


def thickness_words(dataset: xr.Dataset, part: str) -> str:
    """Thickness of a part, or the range of it."""
    if part == "casing":
        return _range(dataset["casing_thickness"].values)
    names = dataset["rotor_part"].values.astype(str)
    own = names == ("" if part == "other beams" and part not in names else part)
    return _range(rotor_sections(dataset, "thickness", 1)[own])


def holding_words(dataset: xr.Dataset) -> list[str]:
    """What holds the bodies and hangs on them, in words; springs and dampers as they are drawn,
    those along the wall beside those across it.
    """
    lines = [*_shaft(dataset), "casing: " + (", ".join(_casing(dataset)) or "free")]
    masses = _numbers(dataset, "point_mass")
    if len(masses):
        lines.append(f"{count(len(masses), 'point mass')}, {masses.sum():.4g} kg")
    for name, what in (("rotor_spring", "spring"), ("rotor_link", "rigid link")):
        number = len(_numbers(dataset, name))
        if number:
            lines.append(f"{count(number, what)} on the bladed disk")
    return lines


def _shaft(dataset: xr.Dataset) -> Iterator[str]:
    """What carries the centre."""
    if int(dataset.attrs["clamped"]):
        yield "centre held"
        return
    damped = _numbers(dataset, "shaft_damping") > 0
    yield ", ".join(["shaft: 2 springs", *_some(damped, "damper")])
    stiffness = _numbers(dataset, "shaft_stiffness")
    if np.unique(stiffness).size > 1:
        yield "of " + " and ".join(_stiffness(each) for each in stiffness) + ","
        static = str(dataset["shaft_frame"].values) == "static"
        yield "standing still" if static else "turning with the disk"


def _casing(dataset: xr.Dataset) -> Iterator[str]:
    """What holds the casing."""
    if float(dataset["casing_foundation"]) > 0:
        yield "elastic support"
    strut = _numbers(dataset, "support_kind").astype(str) == "strut"
    sprung, damped = (
        np.array([_numbers(dataset, f"support_{way}_{what}") for way in ("radial", "tangential")])
        > 0
        for what in ("stiffness", "damping")
    )
    yield from _some(sprung[:, ~strut], "spring")
    yield from _some(strut, "strut")
    yield from _some(np.append(damped[:, ~strut], damped[:, strut].any(axis=0)), "damper")


def _numbers(dataset: xr.Dataset, name: str) -> NDArray[Any]:
    """Values of a variable; none where a stage has none."""
    return dataset[name].values if name in dataset else np.zeros(0)


def _some(which: NDArray[np.bool_], what: str) -> list[str]:
    number = int(np.count_nonzero(which))
    return [count(number, what)] if number else []


def _stiffness(stiffness: float) -> str:
    """A stiffness with three figures in N/m, kN/m or MN/m."""
    for unit, size in (("MN/m", 1e6), ("kN/m", 1e3)):
        if stiffness >= size:
            return f"{stiffness / size:.3g} {unit}"
    return f"{stiffness:.3g} N/m"


def count(number: int, what: str) -> str:
    """A number of things."""
    plural = "es" if what.endswith("s") else "s"
    return f"{number} {what}{plural if number != 1 else ''}"


def _range(lengths: Array) -> str:
    low, high = float(lengths.min()), float(lengths.max())
    if high - low <= 1e-9 * high:
        return _length(high)
    unit, scale = length_unit(high)
    return f"{scale * low:.3g} to {scale * high:.3g} {unit}"


def _length(length: float) -> str:
    unit, scale = length_unit(length)
    return f"{scale * length:.4g} {unit}"
