"""What a file of bladewhirl holds is looked at as it is read: damaged bytes, values that none has.

A run writes finite numbers of a physical size, and names of nodes that there are. Whatever else
comes from a disk that fails, or from an editor, is told by name instead of being computed with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields.netcdf import Reading, Values
from bladewhirl.solvers.march.schema import STATIC, Variable

MOST = 1e30
"""Numbers in SI units are smaller than this, and positive ones larger than its inverse."""

POSITIVE = (
    *("reference_frequency", "casing_radius", "tip_radius", "time_step", "record_step"),
    "yield_strength",
)
NUMBERS = (
    *(
        "format",
        "speed",
        "friction",
        "clamped",
        "steps",
        "complementarity_residual",
        "unsolved_steps",
    ),
    *("dt_over_critical", "wall_time", "us_per_step", *POSITIVE),
)
TEXTS = (
    *("title", "version", "symmetry", "case", "end_reason", "end_message"),
    *("over", "criterion", "window"),
)
"""Attributes of results and sweeps, which may lack some."""


class ResultError(UserError):
    """A path holds no result, or sweep, of bladewhirl."""


def reading(told: str, *, gaps: bool) -> Reading:
    """What reads variables of a file and looks at them; what is wrong ends in a `ResultError`.

    Args:
        told: the file, in messages.
        gaps: whether NaN stands for what is missing, as in a sweep.
    """

    def look(name: str, read: Callable[[], Values]) -> Values:
        try:
            values = read()
        except Exception as error:  # whatever HDF5 makes of damaged bytes
            raise ResultError(f"{told}: {name}: {error}") from None
        if values.dtype.kind == "f" and not sized(values, gaps):
            raise ResultError(
                f"{told}: expected finite numbers of {name}, the file was changed or damaged"
            )
        return values

    return look


def sized(values: Any, gaps: bool = False) -> bool:
    """Whether numbers are finite, or NaN with gaps, and of a size that quantities in SI have."""
    return bool(np.all((np.abs(values) < MOST) | (gaps & np.isnan(values))))


def attribute_fault(attributes: Mapping[str, Any]) -> str:
    """The first attribute that no result or sweep has, and what it should be; or nothing."""
    for name in NUMBERS:
        value = attributes.get(name, 1.0)
        number = np.ndim(value) == 0 and np.asarray(value).dtype.kind in "fiu"
        if not number or not sized(value) or (name in POSITIVE and not value > 1.0 / MOST):
            kind = "positive number" if name in POSITIVE else "finite number"
            return f"attribute {name!r} to be a {kind}, found {value!r}"
    for name in TEXTS:
        text = attributes.get(name, "")
        if not isinstance(text, str) or not _is_unicode(text):
            return f"attribute {name!r} to be text, found {text!r:.60}"
    return ""


def _is_unicode(text: str) -> bool:
    """Whether bytes on disk were UTF-8: h5py gives others as halves of surrogate pairs."""
    return not any("\ud800" <= letter <= "\udfff" for letter in text)


def value_fault(dataset: xr.Dataset) -> str:
    """The first array beside the histories with values that no stage has; empty if none."""
    nodes = dataset.sizes["rotor_node"]
    for name, variable in STATIC.items():
        if name in dataset and (expected := expectation(dataset[name].values, variable, nodes)):
            return f"{name!r} to be {expected}"
    ends = dataset["rotor_point"].values[dataset["rotor_line"].values]
    if not np.any(ends[:, 0] != ends[:, 1], axis=-1).all():
        return "'rotor_line' to join different places"
    angle = dataset["casing_angle"].values
    if not (np.all(np.diff(angle) > 0.0) and angle[-1] - angle[0] < 2.0 * np.pi):
        return "'casing_angle' to rise within one turn"
    return ""


def expectation(values: Any, variable: Variable, nodes: int = 0) -> str:
    """What the values of a variable should be; empty if they are."""
    if values.dtype.kind not in {"f": "f", "i": "iu", "s": "OUT"}[variable.kind[0]]:
        return "text" if variable.kind == "str" else "numbers"
    named = variable.labels if variable.kind == "str" else range(len(variable.labels))
    if variable.labels and not np.isin(values, np.array(list(named))).all():
        return f"one of {', '.join(map(str, named))}"
    match variable.values:
        case "positive":
            sound = values > 1.0 / MOST
        case "not negative":
            sound = values >= 0
        case "rotor_node":
            sound = (values >= 0) & (values < nodes)
        case "rotor_node or -1":
            sound = (values >= -1) & (values < nodes)
        case _:
            return ""
    return "" if np.all(sound) else variable.values
