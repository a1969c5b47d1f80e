"""Runs that survive: killed, refused, made longer, overwritten, begun twice."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from faults import fault
from small_run import COMMAND, RECORDED, SMALL, assert_same_bits, broken_off, small

import bladewhirl as bw
from bladewhirl.solvers.march.checkpoint import CHECKPOINT_NAME
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.studies.runs.folder import check_free
from bladewhirl.studies.runs.run import locked, resume


def long(**values: object) -> bw.Case:
    """Return the small case with a duration of 0.1 s."""
    return small(**{"march.duration": 0.1, **values})


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that nothing disturbed."""
    return bw.run(long(), tmp_path_factory.mktemp("whole") / "run", frames=0).directory


@pytest.mark.slow
def test_a_run_broken_off_goes_on_to_the_same_bits(whole: Path, tmp_path: Path) -> None:
    broken_off(long(), tmp_path / "run", 20_000)
    with bw.open_result(tmp_path / "run") as left:
        assert left.attrs["end_reason"] == "unfinished"
        assert 0 < left.sizes["time"] < 1001
    done = resume(tmp_path / "run", frames=0)
    assert done.end_reason == "completed"
    assert done.summary.steps == 50_000
    assert_same_bits(whole, tmp_path / "run")


@pytest.mark.slow
@pytest.mark.parametrize("duration", [0.05, 0.05003])
def test_a_finished_run_is_made_longer(whole: Path, tmp_path: Path, duration: float) -> None:
    """Also one whose last record is one that a longer run does not make."""
    bw.run(long(**{"march.duration": duration}), tmp_path / "run", frames=3)
    resume(tmp_path / "run", ["march.duration=0.1"], frames=2)
    assert_same_bits(whole, tmp_path / "run")
    assert len([*(tmp_path / "run" / "vtk" / "frames").iterdir()]) == 8


def test_only_the_duration_may_change(whole: Path, tmp_path: Path) -> None:
    with pytest.raises(bw.UserError, match=r"only march\.duration may change"):
        resume(whole, ["march.speed=1.2"])
    with pytest.raises(
        bw.UserError, match=r"march\.duration: expected at least 0\.1 s, the time already"
    ):
        resume(whole, ["march.duration=0.05"])
    assert bw.read_case(whole / "case.toml").march.duration == 0.1
    (tmp_path / "case.toml").write_text(SMALL)
    for content in (b"", b"nonsense", b"PK\x03\x04"):
        (tmp_path / "checkpoint.npz").write_bytes(content)
        with pytest.raises(
            bw.UserError, match=r"checkpoint\.npz: expected the state at the end of a run"
        ):
            resume(tmp_path)


def changed_checkpoint(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    with np.load(folder / CHECKPOINT_NAME) as archive:
        content = dict(archive)
    change(content)
    np.savez(folder / CHECKPOINT_NAME, **content)


STATE = "state.arrays.rotor"


@pytest.mark.parametrize(
    "change",
    [
        lambda content: content.pop("digest"),
        lambda content: content.pop("state.step"),
        lambda content: content.pop(STATE),
        lambda content: content.update({STATE: np.full_like(content[STATE], np.nan)}),
        lambda content: content.update({STATE: content[STATE] + 1e-12}),
        lambda content: content.update({STATE: content[STATE][:-1]}),
        lambda content: content.update({STATE: content[STATE].astype(np.float32)}),
        lambda content: content.update({STATE: np.array("text")}),
        lambda content: content.update({"state.more": np.zeros(3)}),
        lambda content: content.update({"state.step": np.array(10**6)}),
        lambda content: content.update({"state.step": np.array([1, 2])}),
        lambda content: content.update({"records": np.array(3)}),
        lambda content: content.update({"records": np.array(-3)}),
        lambda content: content.update({"records": np.array(10**9)}),
        lambda content: content.update({"wall_time": np.array(np.nan)}),
    ],
)
def test_a_changed_checkpoint_is_refused_in_one_line(
    whole: Path, tmp_path: Path, change: Callable[[dict[str, Any]], object]
) -> None:
    for name in ("case.toml", CHECKPOINT_NAME):
        shutil.copy(whole / name, tmp_path)
    changed_checkpoint(tmp_path, change)
    line = fault(resume, tmp_path, ["march.duration=0.2"])
    assert line.startswith(f"{tmp_path / CHECKPOINT_NAME}: expected the state at the end of a run")
    assert {path.name for path in tmp_path.iterdir()} == {"case.toml", CHECKPOINT_NAME}


@pytest.mark.slow
def test_a_checkpoint_of_more_records_than_the_result_is_refused(
    whole: Path, tmp_path: Path
) -> None:
    bw.run(long(**{"march.duration": 0.05}), tmp_path / "run", frames=0)
    shutil.copy(whole / CHECKPOINT_NAME, tmp_path / "run")
    line = fault(resume, tmp_path / "run", ["march.duration=0.2"], frames=0)
    assert "result.nc: expected the 1001 records of the checkpoint" in line
    (tmp_path / "run" / CHECKPOINT_NAME).unlink()
    os.mkfifo(tmp_path / "run" / CHECKPOINT_NAME)
    assert "it is not a regular file" in fault(resume, tmp_path / "run")


@pytest.mark.slow
def test_a_run_that_overwrites_and_is_broken_off_leaves_the_old_one(tmp_path: Path) -> None:
    """It follows no links, and says what is left of an earlier one."""
    out, elsewhere, old = (tmp_path / name for name in ("run", "elsewhere", "run.old"))
    short = {"march.duration": 1e-3}
    bw.run(long(title="old", **short), out, frames=2)
    (out / "vtk").rename(elsewhere)
    (out / "vtk").symlink_to(elsewhere)
    linked = sorted(elsewhere.rglob("*"))
    before = (out / "result.nc").read_bytes()
    broken_off(long(title="new"), out, 20_000, overwrite=True)
    assert (out / "result.nc").read_bytes() == before
    old.mkdir()
    with pytest.raises(bw.UserError, match=rf"^{old}: this folder exists and has files of an ea"):
        bw.run(long(title="new", **short), out, frames=0, overwrite=True)
    old.rmdir()
    bw.run(long(title="new", **short), out, frames=0, overwrite=True)
    assert bw.read_case(out / "case.toml").title == "new"
    assert (out / "vtk").is_symlink()
    assert sorted(elsewhere.rglob("*")) == linked
    assert {path.name for path in tmp_path.iterdir()} == {"run", "elsewhere"}


def test_a_folder_between_its_first_files_is_not_stuck(tmp_path: Path) -> None:
    out, short = tmp_path / "run", long(**{"march.duration": 1e-3})
    broken_off(short, out, 0)
    (out / "provenance.json").unlink()
    check_free(out, overwrite=True)


def test_two_runs_do_not_share_a_folder(whole: Path, tmp_path: Path) -> None:
    with locked(tmp_path), pytest.raises(bw.UserError, match="is in use"), locked(tmp_path):
        pytest.fail("two have the lock")
    assert not [*tmp_path.iterdir()]
    with locked(whole), pytest.raises(bw.UserError, match="is in use"):
        resume(whole, ["march.duration=0.2"], frames=0)


@pytest.mark.slow
def test_a_refused_write_is_one_line_and_what_was_recorded_stays(tmp_path: Path) -> None:
    case = long(**{"march.duration": 0.2})
    whole = bw.run(case, tmp_path / "whole", frames=0).directory
    (tmp_path / "case.toml").write_text(bw.dumps_case(case))
    size = (whole / RESULT_NAME).stat().st_size * 3 // 4
    limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size})); "
    arguments = ["run", str(tmp_path / "case.toml"), "-o", str(tmp_path / "run"), "--frames", "0"]
    ended = subprocess.run(
        [sys.executable, "-c", limit + COMMAND, *arguments], capture_output=True, text=True
    )
    assert ended.returncode == 2, ended.stderr
    assert ended.stderr.splitlines() == [f"{tmp_path / 'run'}: cannot be written (File too large)"]
    with bw.open_result(tmp_path / "run") as left:
        assert left.sizes["time"] > 0
    resume(tmp_path / "run", frames=0)
    assert_same_bits(whole, tmp_path / "run")


def flushed(whole: Path, folder: Path) -> h5py.File:
    """Open a copy of a result, as it is when 400 of its records are vouched for."""
    shutil.copy(whole / RESULT_NAME, folder)
    file = h5py.File(folder / RESULT_NAME, "r+")
    file.attrs.modify("steps", np.int64(20_000))
    return file


def assert_begins(folder: Path, whole: Path) -> None:
    """Assert that a result has the first 400 records of another, and that of the start."""
    with bw.open_result(folder) as left, bw.open_result(whole) as right:
        assert left.sizes["time"] == 401
        for name in RECORDED:
            np.testing.assert_array_equal(left[name].values, right[name].values[:401])


def test_a_header_longer_than_what_was_vouched_for_is_read_up_to_there(
    whole: Path, tmp_path: Path
) -> None:
    """As a kill in mid-write leaves it: lengths that promise records which never came."""
    with flushed(whole, tmp_path) as file:
        for number, name in enumerate(RECORDED):
            file[name].resize(1200 - number, axis=0)
            file[name][401:] = 0
    assert_begins(tmp_path, whole)


def test_pieces_of_a_write_that_a_kill_cut_off_are_never_asked_for(
    whole: Path, tmp_path: Path
) -> None:
    """A kill within a flush: lengths are on disk and where their pieces lie, the pieces aren't."""
    with flushed(whole, tmp_path) as file:
        piece = file["time"].chunks[0]
        for name in RECORDED:
            file[name].resize(2 * piece, axis=0)
        file["time"][piece:] = 1.0
        at = file["time"].id.get_chunk_info_by_coord((piece,)).byte_offset
    os.truncate(tmp_path / RESULT_NAME, at)
    assert_begins(tmp_path, whole)
