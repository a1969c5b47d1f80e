"""Branches over a key of a case: Dataset, file, command."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from periodic_cases import case

import bladewhirl as bw
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.studies.sweeps.axes import _numeric_keys as numeric_keys

CLOSURE = "casing.closure.amount"
SMALL = {"march.speed": "7500 rpm"}  #: a rub without folds


@pytest.mark.slow
def test_a_branch_has_the_motions_of_single_values(tmp_path: Path) -> None:
    folder = tmp_path / "b"
    data = bw.branch(case(**SMALL), CLOSURE, "0.099 mm", "0.1 mm", points=2, directory=folder)
    assert data.attrs["ended"] == "reaches casing.closure.amount = 0.1 mm"
    assert data["parameter"].values[[0, -1]] == pytest.approx([0.099, 0.1])
    last = data.isel(point=-1)
    alone = bw.periodic(case(**SMALL)).isel(speed=0)
    assert float(last["impulse_per_revolution"]) == pytest.approx(
        float(alone["impulse_per_revolution"]), rel=1e-2
    )
    largest = np.hypot(last["multiplier_real"], last["multiplier_imaginary"])[0]
    assert float(largest) == pytest.approx(float(abs(alone["multipliers"][0])), abs=0.03)
    with xr.open_dataset(folder / "branch.nc") as stored:
        for name in ("parameter", "normal_force", "contact_displacement"):
            assert (stored[name].values == data[name].values).all()


class Stopped(Exception):
    """An interruption."""


def test_an_interrupted_branch_is_continued(tmp_path: Path) -> None:
    own, ends, folder = case(**SMALL), ("0.098 mm", "0.1 mm"), tmp_path / "b"
    whole = bw.branch(own, CLOSURE, *ends, points=4, instants=64)

    def stop(share: float, done: int) -> None:
        if done == 3:
            raise Stopped

    with pytest.raises(Stopped):
        bw.branch(own, CLOSURE, *ends, points=4, instants=64, directory=folder, progress=stop)
    with xr.open_dataset(folder / "branch.nc") as begun:
        assert begun.sizes["point"] == 3
    rest = bw.resume_branch(folder)
    assert rest.attrs["ended"] == whole.attrs["ended"]
    assert rest["parameter"].values[:3] == pytest.approx(whole["parameter"].values[:3])
    expected = np.interp(
        rest["parameter"].values, whole["parameter"].values, whole["impulse_per_revolution"].values
    )
    assert rest["impulse_per_revolution"].values == pytest.approx(expected, rel=5e-3)
    again = bw.resume_branch(folder)
    assert (again["parameter"].values == rest["parameter"].values).all()


LOADED: dict[str, Any] = {
    **SMALL,
    "reduction.free_interface_modes": 4,
    "casing.slope": "3 deg",
    "excitation": {"type": "engine-order", "order": 3, "amplitude": "3 N"},
}
"""A case with many keys; the wall alone has a period of half a turn, with the load it has one."""
RING = {
    "casing.type": "ring",
    "casing.elements": 24,
    "casing.support": "20 N/mm2",
    "casing.wall": {"width": "60 mm", "thickness": "8 mm"},
    "bladed_disk.superelement.copies": 2,
    "damping.ratio": 0.05,
}


@pytest.mark.parametrize(
    ("changes", "key", "start", "stop"),
    [
        (SMALL, "contact.friction", 0.0, 0.05),
        (LOADED, "excitation.amplitude", "3 N", "0 N"),
    ],
)
def test_a_branch_passes_changes_of_the_unknowns_and_of_the_period(
    changes: Any, key: str, start: Any, stop: Any
) -> None:
    """Without friction, no direction of sliding is unknown."""
    data = bw.branch(case(**changes), key, start, stop, points=1, instants=64)
    assert data.attrs["ended"].startswith(f"reaches {key}")
    assert (data["residual"] < 1e-6).all()
    assert np.diff(data["impulse_per_revolution"].values).any()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "down_to"), [(LOADED, (0.0, 1.01)), ({**LOADED, **RING}, (1.01,))]
)
def test_every_key_that_holds_a_number_is_swept_or_refused(
    tmp_path: Path, changes: Any, down_to: Any
) -> None:
    own, origin, followed = case(**changes), tmp_path / "b", 0
    bw.branch(own, "march.speed", "7500 rpm", "7501 rpm", points=1, instants=64, directory=origin)
    for key, _ in numeric_keys(own):
        value = value_at(own, path_of(key))
        if isinstance(value, float) and value:
            ranges = [(value, factor * value) for factor in down_to]
        else:
            ranges = [(0.0, 1e-3)]
        for start, stop in ranges:
            try:
                data = bw.branch(own, key, start, stop, points=1, instants=64, origin=origin)
            except UserError:
                continue
            assert data.attrs["ended"].startswith(f"reaches {key}"), key
            followed += 1
    assert followed > 15


@pytest.mark.slow
def test_a_branch_begins_with_the_last_point_of_another(tmp_path: Path) -> None:
    """The large rub at 7000 rpm is reached from a smaller clearance."""
    first = tmp_path / "first"
    bw.branch(case(), CLOSURE, "0.1 mm", "0.0995 mm", points=2, directory=first)
    with h5py.File(first / "branch.nc", "r+") as file:
        del file.attrs["periods"]  # files of earlier versions have motions of one period
    second = bw.branch(
        case(**{CLOSURE: "0.0995 mm"}),
        "march.speed",
        "7000 rpm",
        "7010 rpm",
        points=2,
        origin=first,
    )
    assert float(second["impulse_per_revolution"][0]) > 30.0


@pytest.mark.slow
def test_a_branch_begins_with_the_last_period_of_a_run(tmp_path: Path) -> None:
    own = case(**SMALL, **{"march.duration": "0.2 s"})
    bw.run(own, tmp_path / "run", frames=0)
    begun = bw.branch(own, "march.speed", "7500 rpm", "7510 rpm", points=1, origin=tmp_path / "run")
    alone = bw.periodic(own)
    assert float(begun["impulse_per_revolution"][0]) == pytest.approx(
        float(alone["impulse_per_revolution"][0]), rel=1e-2
    )


@pytest.mark.slow
def test_the_command_prints_and_draws(tmp_path: Path) -> None:
    file, folder, over = tmp_path / "case.toml", tmp_path / "out", f"{CLOSURE}=0.0997mm:0.1mm"
    file.write_text(bw.dumps_case(case(**SMALL)))
    printed = answer("periodic", file, "--over", over, "--points", 1, "-o", folder).stdout
    assert "reaches casing.closure.amount = 0.1 mm" in printed
    assert (folder / "branch.png").exists()
    assert "already exists" in refusal("periodic", file, "--over", over, "-o", folder)


@pytest.mark.slow
def test_the_command_resumes(tmp_path: Path) -> None:
    folder = tmp_path / "b"
    bw.branch(case(**SMALL), CLOSURE, "0.0997 mm", "0.1 mm", points=1, directory=folder)
    document = json.loads(answer("periodic", "--resume", folder, "--json").stdout)
    assert document["points"][-1]["parameter"] == pytest.approx(0.1)
    assert document["points"][0]["kind"] == "none"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--over", "march.speed=5000rpm"], "expected KEY=START:STOP"),
        (["--over", "march.speed=5000rpm:6"], "same unit"),
        (["--over", "casing.type=1:2"], "a key of the case that holds a number"),
        (["--over", "march.speed=-7000 rpm:6000 rpm"], "expected a range without the speed 0"),
        (["--over", "march.speed=1:2", "--speeds", "1"], "not allowed with --over"),
        (["--points", "3"], "not allowed"),
        (["--over", "casing.clearance=1 mm:0.9 mm", "--points", 2], "no contact"),
    ],
)
def test_refusals(tmp_path: Path, words: Any, message: str) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case()))
    assert message in refusal("periodic", file, *words, "-o", tmp_path / "out")


@pytest.mark.slow
def test_a_branch_of_blades_in_a_flexible_ring() -> None:
    ring = {
        "casing.type": "ring",
        "casing.support": "20 N/mm2",
        "casing.wall": {"width": "60 mm", "thickness": "8 mm"},
        "bladed_disk.superelement.copies": 2,
        "damping.ratio": 0.05,
    }
    own = case(**ring)
    data = bw.branch(own, "march.speed", "7000 rpm", "7040 rpm", points=2, instants=64)
    assert data.attrs["ended"] == "reaches march.speed = 7040 rpm"
    alone = bw.periodic(own).isel(speed=0)
    assert float(data["impulse_per_revolution"][0]) == pytest.approx(
        float(alone["impulse_per_revolution"]), rel=2e-2
    )
    largest = np.hypot(data["multiplier_real"], data["multiplier_imaginary"])[0].max()
    assert float(largest) == pytest.approx(float(abs(alone["multipliers"][0])), abs=0.03)
