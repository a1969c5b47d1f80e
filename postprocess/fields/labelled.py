"""Datasets returned by analyses: named dimensions, units, and the title and speeds of the run."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

#: attributes of a result that are copied to every Dataset derived from the result, both [rad/s]
ABOUT = ("speed", "reference_frequency")
SPEED_RANGE = ("lowest_speed", "highest_speed")
"""Further attributes of a result if the speed varies [rad/s]."""
LOSS = "blade_loss"  #: attribute of a result that names the blades that are lost, if any
COORDINATE_UNITS = {"time": "s", "edge": "s", "frequency": "rad/s", "angle": "rad"}


def labelled(
    source: xr.Dataset,
    title: str,
    variables: Mapping[str, tuple[str | tuple[str, ...], Any, str]],
    coordinates: Mapping[str, Any],
    **attributes: Any,
) -> xr.Dataset:
    """Return a Dataset with units, with a title, and with attributes copied from the run.

    Args:
        source: a result, or a Dataset derived from one.
        title: title of the Dataset.
        variables: dimensions, values and unit of each variable.
        coordinates: values of each coordinate.
        attributes: attributes in addition to the title, the title of the case, and `ABOUT`.
    """
    units = {name: {"units": unit} for name, unit in COORDINATE_UNITS.items()}
    return xr.Dataset(
        {name: (over, values, {"units": unit}) for name, (over, values, unit) in variables.items()},
        coords={name: (name, values, units.get(name, {})) for name, values in coordinates.items()},
        attrs={
            "title": title,
            "case_title": source.attrs.get("case_title", source.attrs.get("title", "")),
            **{name: source.attrs[name] for name in ABOUT},
            **{name: source.attrs[name] for name in (*SPEED_RANGE, LOSS) if name in source.attrs},
            **attributes,
        },
    )
