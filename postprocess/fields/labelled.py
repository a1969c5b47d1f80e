"""Datasets that analyses return: named dimensions, units, and the run that they are of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

ABOUT = ("speed", "reference_frequency")
"""Attributes of a result that everything derived from it keeps, both [rad/s]."""

COORDINATE_UNITS = {"time": "s", "edge": "s", "frequency": "rad/s", "angle": "rad"}


def labelled(
    source: xr.Dataset,
    title: str,
    variables: Mapping[str, tuple[str | tuple[str, ...], Any, str]],
    coordinates: Mapping[str, Any],
    **attributes: Any,
) -> xr.Dataset:
    """Return a Dataset with units, and with title and speeds of the run.

    Args:
        source: a result, or a Dataset derived from one.
        title: of the Dataset.
        variables: dimensions, values and unit of each.
        coordinates: values of each.
        attributes: beside the title and those of `ABOUT`.
    """
    units = {name: {"units": unit} for name, unit in COORDINATE_UNITS.items()}
    return xr.Dataset(
        {name: (over, values, {"units": unit}) for name, (over, values, unit) in variables.items()},
        coords={name: (name, values, units.get(name, {})) for name, values in coordinates.items()},
        attrs={
            "title": title,
            "case_title": source.attrs.get("case_title", source.attrs.get("title", "")),
            **{name: source.attrs[name] for name in ABOUT},
            **attributes,
        },
    )
