"""Validate result and sweep files while reading, so that damage ends in one line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.solvers.march.schema import STATIC, Variable

MOST = 1e30  #: bound of plausible magnitudes in SI units; its inverse is that of positive ones
POSITIVE = "reference_frequency casing_radius tip_radius time_step record_step yield_strength"
NUMBERS = (
    "format speed friction clamped steps complementarity_residual unsolved_steps "
    "dt_over_critical wall_time us_per_step"
)
TEXTS = "title version symmetry case end_reason end_message over criterion window"
"""Attributes of results and sweeps; some may be missing."""


class ResultError(UserError):
    """A path holds no result, or sweep, of bladewhirl."""


def plausible(values: Any, *, gaps: bool = False) -> bool:
    """Return whether numbers are finite and below `MOST`, or NaN where gaps are allowed."""
    return bool(np.all((np.abs(values) < MOST) | (gaps & np.isnan(values))))


def attribute_fault(attributes: Mapping[str, Any]) -> str:
    """Describe the first invalid attribute; empty if there is none."""
    for name in (*POSITIVE.split(), *NUMBERS.split()):
        value = np.asarray(attributes.get(name, 1.0))
        kind = "positive" if name in POSITIVE.split() else "finite"
        valid = value.ndim == 0 and value.dtype.kind in "fiu" and plausible(value)
        if not valid or (kind == "positive" and not value > 1.0 / MOST):
            return f"attribute {name!r} to be a {kind} number, found {attributes[name]!r}"
    for name in TEXTS.split():
        text = attributes.get(name, "")
        # h5py returns bytes that are not UTF-8 as halves of surrogate pairs.
        if not isinstance(text, str) or any("\ud800" <= letter <= "\udfff" for letter in text):
            return f"attribute {name!r} to be text, found {text!r:.60}"
    return ""


def value_fault(dataset: xr.Dataset) -> str:
    """Describe the first invalid array that does not depend on time; empty if there is none."""
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
    """Describe valid values of a variable; empty if the values are valid."""
    if values.dtype.kind not in {"f": "f", "i": "iu", "s": "OUT"}[variable.kind[0]]:
        return "text" if variable.kind == "str" else "numbers"
    labels = variable.labels if variable.kind == "str" else range(len(variable.labels))
    if variable.labels and not np.isin(values, np.array(list(labels))).all():
        return f"one of {', '.join(map(str, labels))}"
    match variable.values:
        case "positive":
            valid = values > 1.0 / MOST
        case "not negative":
            valid = values >= 0
        case "rotor_node":
            valid = (values >= 0) & (values < nodes)
        case "rotor_node or -1":
            valid = (values >= -1) & (values < nodes)
        case _:
            return ""
    return "" if np.all(valid) else variable.values
