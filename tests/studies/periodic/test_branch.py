"""Branches over a key of a case: Dataset, file, command."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from periodic_cases import case

import bladewhirl as bw
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.solvers.periodic.blade import Blade
from bladewhirl.studies.periodic.origins import motion_of
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


def stopped(folder: Path, after: int, own: Any, *branch: Any, **options: Any) -> None:
    """Leave a branch in a folder that was interrupted after some points."""

    def stop(share: float, done: int) -> None:
        if done >= after:
            raise Stopped

    with pytest.raises(Stopped):
        bw.branch(own, *branch, directory=folder, progress=stop, **options)


def test_an_interrupted_branch_is_continued_to_the_last_bit(tmp_path: Path) -> None:
    over, folder = (CLOSURE, "0.098 mm", "0.1 mm"), tmp_path / "b"
    whole = bw.branch(case(**SMALL), *over, points=4, instants=64)
    for after in (1, 3):
        stopped(folder, after, case(**SMALL), *over, points=4, instants=64, overwrite=True)
        with h5netcdf.File(folder / "branch.nc", "r+") as file:  # killed while it wrote a point
            file.resize_dimension("point", file.dimensions["point"].size + 1)
            file.variables["kind"][-1] = 1.0
        rest = bw.resume_branch(folder)
        assert rest.drop_attrs().identical(whole.drop_attrs())
        assert rest.attrs["ended"] == whole.attrs["ended"]
        again = bw.resume_branch(folder)
        assert (again["parameter"].values == rest["parameter"].values).all()


@pytest.mark.slow
def test_an_interrupted_branch_has_the_same_folds(tmp_path: Path) -> None:
    """Interrupted before, between and behind two folds, at which steps are short."""
    own = case(**{"casing.closure": None, "casing.clearance": "0.25 mm"})
    over = "march.speed", "6600 rpm", "7700 rpm"
    options: dict[str, Any] = {"points": 14, "instants": 128}
    whole = bw.branch(own, *over, **options)
    folds = np.flatnonzero(whole["kind"].values == 1)
    assert len(folds) == 2
    for after in (folds[0] - 1, folds[0] + 2, folds[1] + 2):
        folder = tmp_path / str(after)
        stopped(folder, int(after), own, *over, **options)
        assert bw.resume_branch(folder).drop_attrs().identical(whole.drop_attrs())


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a branch that was interrupted."""
    folder = tmp_path_factory.mktemp("begun") / "b"
    stopped(folder, 2, case(**SMALL), CLOSURE, "0.098 mm", "0.1 mm", points=2, instants=64)
    return folder


def test_every_variable_of_a_branch_has_a_unit(begun: Path) -> None:
    with xr.open_dataset(begun / "branch.nc") as stored:
        units = {name: each.attrs["units"] for name, each in stored.variables.items()}
    assert {units[name] for name in ("parameter", "shift", "heading")} == {"mm"}
    assert all(units.values())


def test_amplitudes_of_harmonics_have_the_mean_square_of_the_motion(begun: Path) -> None:
    """That of a cosine is half of its squared amplitude."""
    with xr.open_dataset(begun / "branch.nc") as stored:
        moved, amplitude = stored["contact_displacement"], stored["amplitude"]
        square = amplitude.isel(order=0) ** 2 + 0.5 * (amplitude[:, 1:] ** 2).sum("order")
        expected = (moved**2).mean("instant").values
    np.testing.assert_allclose(square.values, expected, rtol=1e-3, atol=1e-3 * expected.max())


@pytest.mark.parametrize(
    "words",
    [
        ("--set", "contact.friction=0.2"),
        ("-o", "elsewhere"),
        ("--points", 3),
        ("--blade", 1),
        ("--periods", 2),
        ("--from", "elsewhere"),
        ("--overwrite",),
    ],
)
def test_options_that_do_not_change_a_branch_are_refused(begun: Path, words: Any) -> None:
    assert f"{words[0]}: not allowed with --resume" in refusal(
        "periodic", "--resume", begun, *words
    )


def damaged(folder: Path, begun: Path, change: Any) -> Path:
    """A copy of the folder of a branch with a changed file."""
    shutil.copytree(begun, folder)
    change(folder / "branch.nc")
    return folder


def without(name: str) -> Any:
    def change(file: Path) -> None:
        with h5py.File(file, "r+") as h5:
            del (h5 if name in h5 else h5.attrs)[name]

    return change


def holding(name: str, value: Any) -> Any:
    def change(file: Path) -> None:
        with h5py.File(file, "r+") as h5:
            if name in h5:
                h5[name][...] = value
            else:
                h5.attrs[name] = value

    return change


@pytest.mark.parametrize(
    "change",
    [
        *map(without, ("parameter", "kind", "normal_force", "tangent_force", "key", "start")),
        holding("key", 3.0),
        holding("key", "casing.type"),
        holding("start", "soon"),
        holding("stop", np.nan),
        holding("points", "many"),
        holding("points", 0),
        holding("kind", 1.0),
        holding("normal_force", np.nan),
        holding("parameter", 1e300),
        lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
        lambda file: file.write_bytes(b"no branch"),
        lambda file: (file.parent / "case.toml").unlink(),
        lambda file: (file.parent / "case.toml").write_text("[march]\nspeed = 3\n"),
    ],
)
def test_a_damaged_branch_is_refused_in_one_line(tmp_path: Path, begun: Path, change: Any) -> None:
    folder = damaged(tmp_path / "b", begun, change)
    assert str(folder) in refusal("periodic", "--resume", folder)


def test_a_branch_or_run_of_another_stage_is_no_start(tmp_path: Path, begun: Path) -> None:
    """With another number of contact nodes, also if it is a multiple."""
    run = tmp_path / "run"
    bw.run(case(**SMALL, **{"march.duration": "1 ms"}), run, frames=0)
    own = replace(Blade.of_problem(contact_problem(build_stage(case(**SMALL)))), lobes=1)
    for nodes in (1, 2, 10):
        other = replace(own, angle=np.zeros(nodes))
        for folder in (begun, run):
            with pytest.raises(UserError, match=f"has 5 contact nodes .*expected {nodes} "):
                motion_of(folder, other, 0)
    with pytest.raises(UserError, match="has 0 contact nodes on blade 1; expected 5"):
        motion_of(run, own, 1)


def test_a_branch_without_contact_leaves_nothing(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case()))
    over, folder = "casing.clearance=1 mm:0.9 mm", tmp_path / "out"
    message = refusal("periodic", file, "--over", over, "--points", 2, "-o", folder)
    assert "casing.clearance from 1 to 0.9 mm: no contact" in message
    assert not folder.exists()


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
        pytest.param(LOADED, "excitation.amplitude", "3 N", "0 N", marks=pytest.mark.slow),
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
