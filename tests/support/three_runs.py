"""Short runs with contact of the three kinds of stages: beams, one 3D blade, a wheel of solids."""

from functools import cache
from pathlib import Path
from typing import Literal

import xarray as xr

import bladewhirl as bw
from bladewhirl.models.case.file import loads, with_values
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

EXAMPLES = Path(__file__).parents[2] / "examples"
KINDS = ("beams", "blade", "wheel")

Kind = Literal["beams", "blade", "wheel"]

BEAMS = """
title = "A few blades that cut a coating"
bladed_disk = { blades = 6, elements_per_blade = 2 }
casing.elements = 12
casing.support = 7.975e6
casing.clearance = 5e-4
casing.coating = { thickness = 1e-3, young_modulus = 1e8, yield_stress = 1e5, hardening = 1e5 }
reduction.fixed_interface_modes = 10
excitation = { type = "casing-distortion", modal_force = 30000, duration = "5 ms" }
march = { speed = 0.4, time_step = 2e-6, record_step = 1e-4, duration = 0.02 }
material = { endurance = "250 MPa", strength = "900 MPa" }
"""


@cache
def run_of(kind: Kind) -> xr.Dataset:
    """Return the result of a short run; it must not be changed."""
    if kind == "beams":
        case = loads(BEAMS)
    else:
        name, duration = {"blade": ("twisted_blade", 0.04), "wheel": ("bladed_disk", 0.004)}[kind]
        case = bw.read_case(EXAMPLES / f"{name}.toml")
        case = with_values(case, {"march.duration": duration})
    result, _ = march_in_memory(prepare(case))
    assert result["contact_impulse"].sum() > 0.0
    return result
