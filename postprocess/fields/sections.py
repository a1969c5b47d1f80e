"""Sections of the rotor's beams along their lines, from a result."""

from __future__ import annotations

from typing import Literal

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array

Quantity = Literal["thickness", "width", "young_modulus"]


def rotor_sections(dataset: xr.Dataset, name: Quantity, pieces: int) -> Array:
    """Thickness or width [m] or Young's modulus [Pa] at the ends of that many equal pieces of
    every beam, (rotor_line, pieces + 1).
    """
    middle, change = dataset[f"rotor_{name}"].values, dataset[f"rotor_{name}_change"].values
    return np.asarray(middle[:, None] + change[:, None] * np.linspace(-0.5, 0.5, pieces + 1))
