"""Interaction map of a sweep: stored values, zero as white, and speeds of resonances."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from legible import assert_legible
from long_cases import slow_except
from matplotlib.collections import PolyCollection, QuadMesh
from synthetic_result import SPEED, resting, synthetic_result
from synthetic_sweep import synthetic_sweep

import bladewhirl as bw
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.style import at_width
from bladewhirl.postprocess.run.extremes import largest_force
from bladewhirl.postprocess.run.stresses import peak_stresses
from bladewhirl.postprocess.sweep.figures import SweepFigures

pytestmark = pytest.mark.pictures

SPEEDS, CLEARANCES = (60.0, 80.0, 100.0), (1e-3, 2e-3)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Points with contact at the lower speeds; one point at rest, one that failed."""
    motions = [
        synthetic_result(records=40, shaft_radius=2e-5 * speed, speed=speed)
        for speed in SPEEDS
        for _ in CLEARANCES
    ]
    motions[3] = resting(records=40, speed=SPEED)
    given = [*motions[:-1], None]
    over = {"march.speed": SPEEDS, "casing.clearance": CLEARANCES}
    units = {"march.speed": "rad/s", "casing.clearance": "m"}
    return synthetic_sweep(tmp_path_factory.mktemp("sweeps") / "sweep", over, given, units=units)


def _shown(mesh: Any) -> Any:
    """Return the values of the cells of a map that are not masked."""
    return np.ma.compressed(mesh.get_array())


@pytest.mark.parametrize("width", slow_except([0.085, 0.17], 0.085))
def test_what_is_drawn_is_what_is_stored(folder: Path, width: float) -> None:
    with bw.open_sweep(folder) as sweep, at_width(width):
        figure, data = SweepFigures(sweep).draw("interaction")
    assert_legible(figure)
    one = synthetic_result(records=40, shaft_radius=2e-3, speed=100.0)
    at = data.isel(line=0).sel(march_speed=100.0, casing_clearance=1e-3)
    assert float(at["contact_force_max"]) == largest_force(one)["force"] > 0.0
    peaks = np.abs(peak_stresses(one)["peak_stress"].values[:22])
    assert float(at["stress_max"]) == pytest.approx(peaks.max())
    assert "wear_volume" not in data  # no point has a coating
    assert np.isnan(data["stress_max"].isel(line=0).sel(march_speed=100.0, casing_clearance=2e-3))
    maps: list[Any] = [
        mesh
        for axes in figure.axes
        for mesh in axes.collections
        if isinstance(mesh, (QuadMesh, PolyCollection)) and mesh.get_array() is not None
    ]
    for name in ("contact_force_max", "stress_max"):
        stored = data[name].values.ravel()
        some = stored[stored > 0.0]
        shown = [_shown(mesh) for mesh in maps]
        assert any(
            each.size == some.size and np.allclose(each / each.max(), some / some.max())
            for each in shown
        ), name
    nothing = int((data["contact_force_max"].values == 0.0).sum())
    white = [mesh for mesh in maps if np.all(_shown(mesh) == 0.0)]
    assert nothing > 0
    assert np.ma.compressed(white[0].get_array()).size == nothing


def test_resonances_are_where_an_order_meets_a_frequency(folder: Path) -> None:
    with bw.open_sweep(folder) as sweep:
        data = SweepFigures(sweep).draw("interaction")[1]
    frequency = 75.0 / (2 * np.pi)  # of the first blade family
    np.testing.assert_allclose(data["resonance_frequency"], frequency)
    assert data["resonance_order"].values.tolist() == [1, 1]  # for each clearance
    assert data["resonance_across"].values.tolist() == [0, 1]
    np.testing.assert_allclose(data["resonance_at"], 75.0)


def test_a_sweep_over_one_key_has_no_map(tmp_path: Path) -> None:
    motions = [synthetic_result(records=40)]
    made = synthetic_sweep(tmp_path / "sweep", {"march.speed": (SPEED,)}, motions)
    with bw.open_sweep(made) as sweep, pytest.raises(ViewError, match="has only one"):
        SweepFigures(sweep).draw("interaction")
