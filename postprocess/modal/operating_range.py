"""Operating range of a Campbell diagram, in multiples of the reference frequency."""

import numpy as np
import xarray as xr

UNKNOWN = (float("nan"), float("nan"))  #: operating range that the user did not give


def operating_range(data: xr.Dataset) -> tuple[float, float] | None:
    """Return the ends of the operating range of `campbell`; None if the user gave none."""
    low, high = data.attrs["operating_range"]
    return None if np.isnan(low) else (low, high)
