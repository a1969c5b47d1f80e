"""`bladewhirl run` and `bladewhirl.run`: what a run leaves, refuses, and how it ends."""

import json
import re
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from small_run import SMALL, small
from typer.testing import CliRunner

import bladewhirl as bw
from bladewhirl.models.inputs.errors import Hint, UserError
from bladewhirl.solvers.march.march import CHUNK_STEPS
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.runs.folder import check_free
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

RUNNER = CliRunner()

FILES = [
    *("case.toml", "checkpoint.npz", "energy.nc", "energy.png", "manifest.json"),
    *("orbit.nc", "orbit.png", "provenance.json", "result.nc", "summary.json"),
]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


def test_files_of_a_run(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(path.parent)
    arguments = ["run", path.name, "--frames", "2", "--json"]
    done = answer(*arguments)
    out = path.parent / "runs" / "small"
    assert done.stdout == (out / "summary.json").read_text()
    refused = refusal(*arguments)
    assert refused == (
        "runs/small: already exists; --overwrite (in Python overwrite=True) replaces the run in it,"
        " -o names another folder"
    )
    assert sorted(entry.name for entry in out.iterdir()) == [*FILES, "vtk"]
    assert len(list((out / "vtk" / "frames").iterdir())) == 8
    assert bw.read_case(out / "case.toml") == bw.read_case(path)
    provenance = json.loads((out / "provenance.json").read_text())
    assert provenance["dependencies"]["numpy"] == np.__version__
    assert {"bladewhirl", "date", "python", "platform"} < provenance.keys()
    assert "pytest" not in provenance["dependencies"]
    summary = json.loads((out / "summary.json").read_text())
    assert summary["steps"] == 5000
    assert summary["end_time"] == pytest.approx(0.01)
    assert summary["energy_residual"] < 1e-8
    assert summary["complementarity_residual"] < 1e-10
    assert max(summary["contact_share"]) > 0.0
    assert summary["wall_time"] == pytest.approx(1e-6 * summary["us_per_step"] * 5000)
    with xr.open_dataset(out / "result.nc") as result:
        assert result.sizes["time"] == 101
        np.testing.assert_allclose(result["time"], 1e-4 * np.arange(101), atol=1e-12)
        case = bw.read_case(path)
        assert result.attrs["case"] == bw.dumps_case(case)
        assert (result.attrs["end_reason"], result.attrs["end_message"]) == ("completed", "")
        assert result.attrs["steps"] == 5000
        assert result.attrs["casing_radius"] == pytest.approx(0.501)
        stage = bw.build_stage(case)
        assert result.attrs["speed"] == stage.speed
        assert result.attrs["reference_frequency"] == stage.reference_frequency
        assert result["contact_steps"].sum() > 0
        normal = result["contact_impulse"].values
        assert normal.min() >= 0.0
        np.testing.assert_allclose(result["friction_impulse"], 0.1 * normal)  # permanent sliding
    first = meshio.read(out / "vtk" / "frames" / "rotor_00000.vtu")
    assert len(first.points) == 2 * result.sizes["rotor_line"]


@pytest.mark.slow
def test_from_python_to_a_dataset(path: Path) -> None:
    reports: list[tuple[str, int, int]] = []
    case = bw.with_values(
        bw.read_case(path), {"march.duration": 0.1, "excitation.modal_force": 10.0}
    )
    run = bw.run(
        case, path.parent / "out", frames=5, progress=lambda *report: reports.append(report)
    )
    assert run.end_reason == "completed"
    assert run.summary.regime == "no-contact"
    assert reports[-2:] == [("marching", 50_000, 50_000), ("writing", 50_000, 50_000)]
    assert len(reports) > 2
    assert reports == sorted(reports)
    assert "5 frames over 4.3 revolutions" in run.hints[0]
    screen = repr(run).splitlines()
    assert len(screen) < 40
    assert screen[0].split() == ["regime", "no-contact"]
    assert "summary.json" in repr(run)
    assert screen[-1] == f"Hint: {run.hints[0]}."
    assert Path(run) == run.directory
    with run.open() as result:
        assert result["gap"].min() > 0.0
        assert bw.shaft_orbit(result)["radius"].max() == 0.0  # nobody touched the shaft


def test_coarse_records_hold_sums_and_minima() -> None:
    """Records ten times as far apart hold the sums and minima of the finer ones."""
    one, two = (
        march_in_memory(prepare(small(**{"march.record_step": step})))[0] for step in (1e-4, 1e-3)
    )
    for name in ("contact_impulse", "friction_impulse", "contact_steps"):
        sums = one[name].values[1:].reshape(10, 10, -1).sum(axis=1)
        assert sums.any()
        np.testing.assert_allclose(two[name].values[1:], sums, rtol=1e-12, atol=1e-15)
    smallest = one["gap"].values[1:].reshape(10, 10, -1).min(axis=1)
    np.testing.assert_array_equal(two["gap"].values[1:], smallest)
    for name in ("rotor_displacement", "casing_velocity", "energy", "friction_work"):
        np.testing.assert_array_equal(two[name].values, one[name].values[::10])


@pytest.mark.slow
def test_divergence_is_a_result(path: Path) -> None:
    out = path.parent / "out"
    values = ["--set", "march.displacement_limit=1e-4", "--set", "march.duration=0.1"]
    late = ["--frames", "4", "--from", "90 ms"]
    done = answer("run", path, "-o", out, "--json", *late, *values)
    assert "Hint: no ParaView series: window" in done.stderr
    summary = json.loads(done.stdout)
    assert summary["regime"] == "divergent"
    assert summary["end_time"] < 0.05
    message = done.stderr.splitlines()[0]
    assert message.startswith("the casing at ")  # the push moves it, and no blade, so far
    assert "passed march.displacement_limit = 0.0001 m at" in message
    assert re.search(r" s \([-0-9.e]+ m (radially|tangentially)\); ", message)
    assert "damping" in message  # a remedy
    with xr.open_dataset(out / "result.nc") as result:
        assert result.attrs["end_reason"] == "divergent"
        assert result.attrs["end_message"] == message
        assert result["time"][-1] == summary["end_time"]
        for variable in result.variables.values():
            assert variable.dtype.kind != "f" or np.isfinite(variable.values).all()


def test_a_casing_that_goes_too_far_is_named_not_a_blade() -> None:
    values = {"excitation.modal_force": 3e5, "march.displacement_limit": 0.01}
    result, _ = march_in_memory(prepare(small(**values)))
    message = result.attrs["end_message"]
    match = re.match(
        r"the casing at (\S+)° passed march.displacement_limit = 0.01 m at \S+ s"
        r" \((\S+) m radially\)",
        message,
    )
    assert match, message
    wall = result["casing_shape"].values[:, 0] @ result["casing_displacement"].values[-1]
    worst = int(np.abs(wall).argmax())
    assert float(match[1]) == pytest.approx(float(np.degrees(result["casing_angle"][worst])))
    assert float(match[2]) == pytest.approx(float(wall[worst]), rel=1e-3)


@pytest.mark.slow
def test_a_window_of_the_run_seen_from_the_rotor(path: Path) -> None:
    out = path.parent / "out"
    window = ["--from", "2 ms", "--to", "0.004", "--frames", "3", "--rotating"]
    answer("run", path, "-o", out, *window)
    index = (out / "vtk" / "series.pvd").read_text()
    assert re.findall(r'timestep="([^"]+)" part="0"', index) == ["0.002", "0.003", "0.004"]
    frames = [meshio.read(out / "vtk" / "frames" / f"rotor_0000{i}.vtu") for i in range(3)]
    np.testing.assert_array_equal(frames[0].points, frames[2].points)  # the rotor stays


def quick(**values: object) -> bw.Case:
    return small(**{"march.duration": 1e-4, **values})


def test_overwriting_replaces_a_run_and_nothing_else(tmp_path: Path) -> None:
    out = tmp_path / "out"
    bw.run(quick(), out, frames=2)
    before = (out / "result.nc").read_bytes()
    with pytest.raises(UserError, match=r"march\.time_step"):
        bw.run(quick(**{"march.time_step": 1e-4}), out, overwrite=True)
    assert (out / "result.nc").read_bytes() == before
    for name in ("notes.txt", "vtk/state.pvsm", "animation.gif"):
        (out / name).write_text("mine")
    with pytest.raises(UserError, match="already exists; --overwrite"):
        bw.run(quick(), out)
    bw.run(quick(title="second"), out, frames=0, overwrite=True)
    assert bw.read_case(out / "case.toml").title == "second"
    kept = sorted(str(entry.relative_to(out)) for entry in out.rglob("*"))
    assert kept == sorted([*FILES, "animation.gif", "notes.txt", "vtk", "vtk/state.pvsm"])


def test_only_runs_are_overwritten(tmp_path: Path) -> None:
    foreign, file, empty = tmp_path / "foreign", tmp_path / "file", tmp_path / "empty"
    foreign.mkdir()
    (foreign / "result.nc").write_text("precious")
    file.write_text("precious")
    empty.mkdir()
    for path in (foreign, file):
        with pytest.raises(UserError, match="already exists"):
            bw.run(quick(), path)
    with pytest.raises(UserError, match="expected an empty folder or the folder of a run"):
        bw.run(quick(), foreign, overwrite=True)
    with pytest.raises(UserError, match="expected a folder to overwrite, found a file"):
        bw.run(quick(), file, overwrite=True)
    assert file.read_text() == (foreign / "result.nc").read_text() == "precious"
    check_free(empty, overwrite=False)


def test_where_nothing_can_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    out = tmp_path / "file" / "deep" / "out"
    with pytest.raises(UserError) as error:
        bw.run(quick(), out)
    assert [*error.value.lines] == [f"{out}: cannot be written (Not a directory)"]


@pytest.mark.slow
def test_a_disk_without_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is seen before the march where it can be, and ends a march in order."""
    free = [10**7]
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=free.pop()))
    monkeypatch.setattr("bladewhirl.studies.runs.recorded_march.FLUSH_TIME", 0.0)
    long = quick(**{"march.duration": 100.0})
    with pytest.raises(UserError, match="MB of free space on the disk, found 10 MB"):
        bw.run(long, tmp_path / "deep" / "out")
    assert not [*tmp_path.iterdir()]
    free[:] = [10**6, *[10**12] * 3]
    with pytest.raises(UserError, match="expected 4 MB of free space on the disk, found 1 MB"):
        bw.run(long, tmp_path / "out")
    with xr.open_dataset(tmp_path / "out" / "result.nc") as result:
        assert result.attrs["end_reason"] == "unfinished"
        assert result.sizes["time"] == 2 * CHUNK_STEPS // 50


def test_ctrl_c_finishes_what_was_recorded(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[int] = []

    @contextmanager
    def interrupting(label: str) -> Iterator[Callable[..., None]]:
        def update(done: int, total: int, *, label: str = "", text: str = "") -> None:
            if label == "marching" and done and not sent:
                sent.append(done)
                signal.raise_signal(signal.SIGINT)

        yield update

    monkeypatch.setattr("bladewhirl.studies.commands.marches.progress_bar", interrupting)
    out = path.parent / "out"
    arguments = ["--set", "march.duration=3", "--frames", "3"]
    done = RUNNER.invoke(app, ["run", str(path), "-o", str(out), *arguments])
    assert done.exit_code == 130, done.stderr
    assert done.stderr.splitlines()[0].startswith("interrupted at ")
    assert done.stderr.splitlines()[-1] == f"bladewhirl run --resume {out} finishes the run"
    assert "regime" in done.stdout
    assert sorted(entry.name for entry in out.iterdir()) == [*FILES, "vtk"]
    summary = json.loads((out / "summary.json").read_text())
    with xr.open_dataset(out / "result.nc") as result:
        assert result.attrs["end_reason"] == "interrupted"
        assert result.attrs["steps"] == summary["steps"] == round(summary["end_time"] / 2e-6)
        assert 3.0 > result["time"][-1] == summary["end_time"] > 0.0


@pytest.mark.slow
def test_a_path_is_read_and_implausible_values_are_warned_of(path: Path) -> None:
    path.write_text(bw.dumps_case(quick(**{"contact.friction": 30.0})))
    with pytest.warns(Hint, match=r"contact.friction = 30.0: expected at most 2 for dry metals"):
        done = bw.run(path, path.parent / "run", frames=0)
    assert done.summary.steps > 0


def test_hints_are_printed_before_the_march_and_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "case.toml").write_text(
        "[bladed_disk]\nblades = 5\nelements_per_blade = 2\n[casing]\nsupport = 8e6\n"
        '[contact]\nfriction = 3.0\n[march]\nduration = "2 ms"\n'
    )
    words = ["run", str(tmp_path / "case.toml"), "-o", str(tmp_path / "out"), "--frames", "0"]

    def stop(*given: object) -> None:
        raise UserError("stopped before the march")

    with monkeypatch.context() as patch:
        patch.setattr("bladewhirl.studies.runs.run._march_and_sum_up", stop)
        early = CliRunner().invoke(app, words).stderr
    assert early.index("contact.friction = 3.0") < early.index("stopped before the march")
    again = CliRunner().invoke(app, [*words, "--overwrite"]).stderr
    assert again.count("contact.friction = 3.0") == 1
