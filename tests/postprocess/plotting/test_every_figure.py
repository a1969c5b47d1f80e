"""Every figure of beams, one blade and a wheel, for both widths of print."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch

import bladewhirl as bw
from bladewhirl.models.case.file import with_values
from bladewhirl.postprocess.plotting.registry import RUN_FIGURES
from bladewhirl.postprocess.plotting.style import COLUMN_WIDTH, FULL_WIDTH, at_width
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

pytestmark = pytest.mark.pictures

EXAMPLES = Path(__file__).parents[3] / "examples"
COATING = {"thickness": 2e-3, "young_modulus": 1e9, "yield_stress": 1e6, "hardening": 5e6}
TIMING = {"type": "tip-timing", "name": "btt", "probes": [0.0], "sampling_rate": 80e6}
SENSORS = [TIMING, {"type": "wall", "angle": 1.0, "sampling_rate": 5e3}]

RUNS: dict[str, tuple[str, dict[str, Any]]] = {  # name: example, values
    "beams": (
        "casing_distortion",
        {
            "march.duration": 0.12,
            "casing.coating": COATING,
            "sensor": [*SENSORS, {"type": "centre"}],
        },
    ),
    "18 beams": ("casing_distortion", {"march.duration": 0.03, "bladed_disk.blades": 18}),
    "blade": ("twisted_blade", {"march.duration": 0.05, "sensor": [TIMING]}),
    "joints": (
        "shrouded_blade",
        {"march.duration": 0.05},
    ),
    "wheel": (
        "bladed_disk",
        {"march.duration": 0.015, "casing.coating": COATING, "sensor": SENSORS},
    ),
}
SAMPLE = [
    *(("beams", name) for name in ("gaps", "contact-angle", "stress", "all-blades")),
    *(("blade", name) for name in ("gaps", "forces", "contact-angle", "stress", "wear-lobes")),
    ("joints", "joints"),
    *(("wheel", name) for name in ("contact-nodes", "tips", "casing", "stress", "all-blades")),
]

STORED = {"gaps": "gap", "contact-nodes": "force", "casing": "radial", "wear-tracks": "recess"}
"""Variables whose values the colours or the line of a figure show."""


@cache
def figures(run: str) -> RunFigures:
    example, values = RUNS[run]
    case = with_values(bw.read_case(EXAMPLES / f"{example}.toml"), values)
    return RunFigures(march_in_memory(prepare(case))[0])


def drawn(run: str, name: str, width: float) -> tuple[Figure, xr.Dataset]:
    if name not in figures(run).kinds:
        pytest.skip("not of this run")
    try:
        with at_width(width):
            return figures(run).draw(name)
    except bw.ViewError as error:
        pytest.skip(str(error))


def check(run: str, name: str, width: float) -> None:
    figure, data = drawn(run, name, width)
    assert_legible(figure)
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if axis.get_label_text() == "blade":
                assert all(float(place).is_integer() for place in axis.get_majorticklocs())
                assert run != "blade"  # a single blade has a line over time or angle
    if name in STORED:
        stored = np.asarray(data[STORED[name]].values, dtype=float)
        stored = stored[-1] if name == "wear-tracks" else stored.T
        shown = [part for axes in figure.axes for part in axes.findobj(QuadMesh)]
        lines = [part for axes in figure.axes for part in axes.findobj(StepPatch)]
        values = shown[0].get_array() if shown else lines[0].get_data()[0]
        none = 0.0 if name == "contact-nodes" else np.nan  # white
        seen = np.ma.filled(np.ma.asarray(values, dtype=float), none).reshape(stored.shape)
        if not np.any(stored):  # no contact
            assert not np.any(seen)
            return
        factor = np.nanmax(np.abs(seen)) / np.nanmax(np.abs(stored))
        assert np.log10(factor) == pytest.approx(round(np.log10(factor)))  # a unit
        lowest = 0.0 if name == "gaps" else -np.inf  # rounding errors of a tip that touches
        np.testing.assert_allclose(seen, np.maximum(factor * stored, lowest))


@pytest.mark.parametrize(("run", "name"), SAMPLE)
def test_sample(run: str, name: str) -> None:
    check(run, name, COLUMN_WIDTH)


@pytest.mark.slow
@pytest.mark.parametrize("width", [COLUMN_WIDTH, FULL_WIDTH])
@pytest.mark.parametrize("name", RUN_FIGURES)
@pytest.mark.parametrize("run", RUNS)
def test_every_figure(run: str, name: str, width: float) -> None:
    check(run, name, width)
