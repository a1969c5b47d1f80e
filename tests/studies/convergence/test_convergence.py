"""Convergence in time step and modes: measured orders, what the command leaves, bad input."""

import json
import shutil
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from exported_stage import Kind, same_stage
from long_cases import slow_except
from shaft_line_case import line_case

import bladewhirl as bw
from bladewhirl.models.case.file import loads, with_values
from bladewhirl.models.stage.build import build_stage
from bladewhirl.studies.convergence.study import (
    TIME_STEP,
    default_modes,
    default_time_steps,
    mode_convergence,
    observed_order,
    time_step_convergence,
)
from bladewhirl.studies.sweeps.cache import RunStore

SMALL = (
    "bladed_disk.blades=6",
    "casing.elements=12",
    "casing.support=7.975e6",
    "reduction.fixed_interface_modes=12",
    "initial.centre_velocity=[0.5, 0.0]",
    "march.duration=20 ms",
    "march.record_step=1e-4",
    "march.time_step=4e-6",
)


def small(*overrides: str) -> bw.Case:
    """A shaft that is thrown at a casing."""
    return loads("", overrides=[*SMALL, *overrides])


CLOSE = small("casing.clearance=0.2 mm")
SHORT = small("march.duration=5 ms")
KINDS = get_args(Kind)
MODES_KEPT = "reduction.fixed_interface_modes"
STEPS = [1e-5, 5e-6, 2.5e-6]
MODES = [6, 12, 24]


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> RunStore:
    """All marches, made at once: a worker takes seconds to start."""
    store = RunStore(directory=tmp_path_factory.mktemp("marches"), workers=1)
    steps = [with_values(CLOSE, {TIME_STEP: step}) for step in STEPS]
    store.make(steps)
    assert not store.failures
    return store


@pytest.mark.parametrize("change", [[8.0, 2.0, 3.0], [1.0, 3.0, 2.0], [1.0, 0.0, 0.0]])
def test_differences_that_rise_and_fall_have_no_order(change: list[float]) -> None:
    assert np.isnan(observed_order(np.array([4.0, 2.0, 1.0, 0.5]), np.array([*change, np.nan])))


@pytest.mark.parametrize("order", [-1.0, 1.0, 2.0])
@pytest.mark.parametrize("size", [[4.0, 3.0, 1.0, 0.5], [4.0, 1.0, 0.5], [4.0, 2.0, 1.0, 0.5]])
def test_the_order_is_found_whatever_the_steps(size: list[float], order: float) -> None:
    steps = np.array(size)
    error = 0.3 * steps**order
    change = np.abs(np.append(np.diff(error), np.nan))
    assert observed_order(steps, change) == pytest.approx(order, abs=1e-6)


def test_orders_before_and_in_contact(store: RunStore) -> None:
    data = time_step_convergence(CLOSE, STEPS, store)
    assert 0.0 < data.attrs["free_until"] < 5e-3
    assert data.attrs["free_order"] == pytest.approx(2.0, abs=0.2)
    impulse = data["contact_impulse"].values
    assert (impulse > 0.0).all()
    error = np.abs(impulse - impulse[-1]) / impulse[-1]
    np.testing.assert_allclose(data["impulse_error"], error)
    assert error.max() < 0.05
    assert set(data["regime"].values) == {"sustained"}


@pytest.mark.slow
def test_modes(store: RunStore) -> None:
    store.make([with_values(small(), {MODES_KEPT: count}) for count in MODES])
    data = mode_convergence(small(), MODES, store)
    assert data["kept"].values.tolist() == [6, 12, 24]
    assert data["distance"].values[-1] == 0.0
    assert (data["distance"].values[:-1] > 0.0).all()
    assert (np.diff(data["frequency_error"].values) < 0.0).all()
    assert len(set(data["regime"].values)) == 1
    assert data.attrs["motion_converged"] == 1


def test_default_time_steps_and_modes() -> None:
    stage = build_stage(small())
    assert default_modes(stage) == [5, 7, 10, 12, 14]
    for more, steps in (
        ("march.time_step=1e-5", [1e-5, 5e-6]),
        ("march.duration=20 ms", [4e-6, 2e-6]),  # 1e-4 s is no multiple of 1.6e-5 and 8e-6 s
        ("march.record_step=8e-5", [8e-6, 4e-6, 2e-6]),
    ):
        assert default_time_steps(build_stage(small(more))) == pytest.approx(steps)


@pytest.mark.parametrize(
    "kind",
    slow_except(KINDS, "blade"),
)
def test_every_stage_converges(kind: Kind, tmp_path: Path) -> None:
    """A stage of beams and its superelement depend on the time step in the same way."""
    march = {"speed": "1200 rpm", "time_step": 2e-6, "record_step": 1e-4, "duration": 0.01}
    both = same_stage(kind, tmp_path / "part.npz", march=march)
    store = RunStore(directory=tmp_path / "marches", workers=1)
    ours, theirs = (time_step_convergence(case, [4e-6, 2e-6], store) for case in both)
    assert float(ours["contact_impulse"].min()) > 0.0
    for name in ("radius_max", "contact_impulse", "distance", "impulse_error"):
        np.testing.assert_allclose(theirs[name], ours[name], rtol=1e-3)
    key, used = build_stage(both[1]).basis
    data = mode_convergence(both[1], [used - 1, used], store)
    assert data.attrs["key"] == key
    assert 0.0 < float(data["distance"][0]) < 1.0
    with pytest.raises(bw.UserError, match=f"{key} = 1000: expected"):
        mode_convergence(both[1], [used, 1000], store)


def test_a_shaft_line_converges_with_the_square_of_the_step(tmp_path: Path) -> None:
    case, store = line_case(), RunStore(directory=tmp_path, workers=1)
    steps = time_step_convergence(case, [2e-5, 1e-5, 5e-6], store)
    assert steps.attrs["displacement_order"] == pytest.approx(2.0, abs=0.1)
    counts = default_modes(build_stage(case))
    assert counts == [2, 4, 5, 6, 7]
    modes = mode_convergence(case, counts, store)
    assert modes.attrs["key"] == "shaft_line.modes"
    assert float(modes["distance"][-2]) < 0.1 * float(modes["distance"][0])


def test_a_march_that_cannot_be_made(store: RunStore) -> None:
    with pytest.raises(bw.UserError, match=r"march\.time_step = 0\.0001: .*critical"):
        time_step_convergence(small(), [1e-4, 5e-5], store)


@pytest.mark.slow
def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, store: RunStore) -> None:
    """In a folder where the marches are, as after an interruption."""
    store.make([with_values(SHORT, {TIME_STEP: 2e-6}), with_values(SHORT, {MODES_KEPT: 6}), SHORT])
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(bw.dumps_case(SHORT), encoding="utf-8")
    runs = Path("small-convergence") / "runs"
    runs.mkdir(parents=True)
    for step, count in ((4e-6, 12), (2e-6, 12), (4e-6, 6)):
        path = store.path(with_values(SHORT, {TIME_STEP: step, MODES_KEPT: count}))
        shutil.copy(path, runs)
    options = ("--time-steps", "4us, 2e-6", "--modes", "12,6", "--workers", "1")
    given = ("convergence", "small.toml", *options)
    assert "order in the time step" in answer(*given, "--overwrite").stdout
    folder = Path("small-convergence")
    assert {path.name for path in folder.iterdir()} == {
        "runs",
        "convergence.json",
        *(f"{name}.{kind}" for name in ("time-step", "modes") for kind in ("png", "nc")),
    }
    assert len(list((folder / "runs").glob("*.nc"))) == 3  # 4 us with 12 modes is in both
    document = json.loads((folder / "convergence.json").read_text())
    assert document["time_steps"]["time_step"] == [4e-6, 2e-6]
    assert document["time_steps"]["displacement_order"] is None
    assert document["modes"]["modes"] == [6, 12]
    with xr.open_dataset(folder / "modes.nc") as data:
        assert data["regime"].values.tolist() == document["modes"]["regime"]
    refusal(*given)
    assert json.loads(answer(*given, "--overwrite", "--json").stdout) == document
