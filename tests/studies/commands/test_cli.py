"""The command line: new case files, and errors of the user's in one line each."""

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from command_line import loaded, refusal
from long_cases import slow_except
from places import EXAMPLES
from small_run import COMMAND
from typer import Exit
from typer.main import get_command
from typer.testing import CliRunner

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.progress import tracked
from bladewhirl.models.superelements import solver
from bladewhirl.studies.commands import cli, marches, show, terminal
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.commands.terminal import interruptible, progress_bar
from bladewhirl.studies.modal import campbell, modes, response, stability_report
from bladewhirl.studies.runs.columns import Column, table

RUNNER = CliRunner()


def test_new_writes_the_default_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for arguments in (["new"], ["new", "--force", "-o", "case.toml"]):
        assert RUNNER.invoke(app, arguments).exit_code == 0
        assert read_case("case.toml") == Case()


def test_faults_are_lines_on_standard_error(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text('title = 3\n[march]\nspeed = "[red]3[/red] kg"')
    result = RUNNER.invoke(app, ["show", str(path)])
    assert (result.exit_code, result.stdout) == (2, "")
    lines = result.stderr.splitlines()
    assert lines[0] == f"{path}: title = 3: expected text"
    assert lines[1].startswith(f'{path}: march.speed = "[red]3[/red] kg": expected a number')
    assert len(lines) == 2


@pytest.mark.parametrize("ctrl_c", [signal.default_int_handler, signal.SIG_IGN])
def test_sigterm_ends_a_command_as_ctrl_c_does(
    monkeypatch: pytest.MonkeyPatch, ctrl_c: signal.Handlers
) -> None:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    monkeypatch.setattr(cli, "app", lambda: signal.raise_signal(signal.SIGTERM))
    try:
        signal.signal(signal.SIGINT, ctrl_c)
        with pytest.raises(KeyboardInterrupt):
            cli.main()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_a_command_that_is_stopped_names_no_folder_that_is_not_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for folder, text in (
        (tmp_path, "interrupted; it continues"),
        (tmp_path / "out", "interrupted; nothing is written"),
        (None, "interrupted; nothing is written"),
    ):
        with pytest.raises(Exit), interruptible("it continues", folder):
            raise KeyboardInterrupt
        assert capsys.readouterr().err.strip() == text


@pytest.mark.parametrize("writes", [True, False])
def test_an_interrupted_branch_continues_only_if_it_wrote_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writes: bool
) -> None:
    earlier = tmp_path / "out" / "branch.nc"  # of an earlier branch, which is to be replaced
    earlier.parent.mkdir()
    earlier.touch()
    os.utime(earlier, (0, 0))

    def interrupted(*_: object, **__: object) -> None:
        if writes:
            earlier.write_bytes(b"points")
        raise KeyboardInterrupt

    monkeypatch.setattr("bladewhirl.studies.periodic.branches.branch", interrupted)
    case = EXAMPLES / "shrouded_blade.toml"
    over = "joint.shroud.preload=25 N:1600 N"
    words = ["periodic", str(case), "--over", over, "-o", str(earlier.parent), "--overwrite"]
    done = RUNNER.invoke(app, words)
    continues = f"bladewhirl periodic --resume {earlier.parent} continues"
    assert done.stderr.strip() == f"interrupted; {continues if writes else 'nothing is written'}"
    assert done.exit_code == terminal.INTERRUPTED


def test_workers_end_with_their_parent_before_they_load_anything() -> None:
    assert "numpy" not in loaded("import bladewhirl.studies.runs.interrupts")


def bladewhirl(
    *arguments: str, cwd: Path | None = None, output: str = os.devnull
) -> subprocess.CompletedProcess[str]:
    """Give a command in a process of its own, with an output that takes ASCII only."""
    with Path(output).open("w") as stream:
        return subprocess.run(
            [sys.executable, "-c", COMMAND, *arguments],
            stdout=subprocess.PIPE if output == os.devnull else stream,
            stderr=subprocess.PIPE,
            text=True,
            cwd=cwd,
            env={**os.environ, "PYTHONIOENCODING": "ascii"},
        )


def test_the_installed_entry_point(tmp_path: Path) -> None:
    (tmp_path / "case.toml").touch()
    refused = bladewhirl("new", cwd=tmp_path)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr == "case.toml: already exists; --force overwrites it\n"
    assert bladewhirl("--version").stdout.startswith("bladewhirl ")
    assert RUNNER.invoke(app, ["frobnicate"]).exit_code == 2


def test_every_parameter_is_described() -> None:
    commands = get_command(app).commands  # type: ignore[attr-defined]
    assert len(commands) == len(app.registered_commands)
    for command in commands.values():
        assert "Args:" not in command.help
        assert all(parameter.help for parameter in command.params)


@pytest.mark.parametrize(
    ("command", "text"), [("periodic", "With [[joint]], and"), ("mesh3d", "for [blade_loss]; or")]
)
def test_help_keeps_names_of_tables(command: str, text: str) -> None:
    shown = RUNNER.invoke(app, [command, "--help"], env={"COLUMNS": "2000"}, terminal_width=2000)
    assert text in " ".join(shown.stdout.split())


def test_help_loads_nothing_heavy() -> None:
    modules = loaded(
        "import typer.testing, bladewhirl.studies.commands.cli as cli\n"
        "for arguments in (['--help'], ['new', '--help'], ['nonsense']):\n"
        "    typer.testing.CliRunner().invoke(cli.app, arguments)\n"
    )
    assert modules.isdisjoint({"numpy", "scipy", "pint", "_cffi_backend", "xarray", "pyvista"})
    own = {name.removeprefix("bladewhirl.") for name in modules if name.startswith("bladewhirl.")}
    # Figures are listed by `plot --help`; errors take the standard library only.
    small = {
        "threads",
        "postprocess.plotting.registry",
        "postprocess.pictures.choices",
        "models.inputs.errors",
        "models.inputs.progress",
    }
    rooms = {
        "postprocess",
        "postprocess.plotting",
        "postprocess.pictures",
        "models",
        "models.inputs",
    }
    assert all(name.startswith("studies") for name in own - small - rooms)


def test_a_job_without_a_terminal_writes_a_line_each_tenth(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with progress_bar("job", lines="points") as update:
        for done in range(201):
            update(done, 200, failed=done // 200)
    lines = capsys.readouterr().err.splitlines()
    numbers = range(0, 201, 20)
    assert [line.partition(" of 200 points")[0] for line in lines] == [*map(str, numbers)]
    assert lines[-1] == "200 of 200 points, 1 failed"


def test_full_standard_output() -> None:
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    ended = bladewhirl("--version", output="/dev/full")
    expected = "standard output: cannot be used (No space left on device)\n"
    assert (ended.returncode, ended.stderr) == (2, expected)


def test_a_pipe_is_no_case(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "case.toml")
    line = refusal("show", tmp_path / "case.toml")
    assert line.endswith("expected a readable file (it is not a regular file)")


def test_a_terminal_shows_progress_from_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the command, of the reductions and other computations inside it, and of its jobs."""
    shown: list[tuple[str, int, int]] = []

    class Bar(terminal._Bar):
        def show(self, label: str, done: int = 0, total: int = 0, text: str = "") -> None:
            super().show(label, done, total, text)
            shown.append((label, done, total))

    monkeypatch.setattr(terminal, "_Bar", Bar)
    with progress_bar("preparing"):
        assert shown == [("preparing", 0, 0)]
        solver.announce(10, 2, 3)
        solver.MatrixPencil(np.eye(10), np.eye(10)).solve(np.ones((10, 1)))
        expected = solver.lanczos_vectors(2) + 3
        with progress_bar("marching") as update:
            update(3, 7)
        assert [*tracked("figures", "ab")] == ["a", "b"]
    reducing = ("reducing the superelement", 0, expected)
    assert shown[1:3] == [reducing, (reducing[0], 1, expected)]
    assert shown[3:6] == [("marching", 0, 0), ("marching", 3, 7), (reducing[0], 0, 0)]
    assert shown[6:9] == [("figures", 0, 2), ("figures", 1, 2), ("preparing", 0, 0)]


@pytest.mark.parametrize("command", slow_except(["modes", "campbell"], "modes"))
def test_a_bar_on_a_terminal_leaves_the_output_as_it_is(tmp_path: Path, command: str) -> None:
    """Standard error is a terminal, standard output is a file."""
    end, terminal_side = os.openpty()
    case = tmp_path / "case.toml"
    case.write_text("[bladed_disk]\nblades = 3\n")
    arguments = [sys.executable, "-c", COMMAND, command, str(case), "--json"]
    with (
        (tmp_path / "output").open("wb") as output,
        subprocess.Popen(arguments, stdout=output, stderr=terminal_side),
    ):
        os.close(terminal_side)
        seen = b""
        with suppress(OSError):  # the other side is closed
            while read := os.read(end, 100_000):
                seen += read
        os.close(end)
    assert json.loads((tmp_path / "output").read_text())
    assert b"working" in seen


@pytest.mark.parametrize(
    "columns",
    [
        (*modes.COLUMNS, *modes.AT_SPEED),
        campbell.COINCIDENCES,
        campbell.CRITICAL_SPEEDS,
        response.PEAKS,
        show.NODES,
        (marches.TIME_STEP, *marches.REFINEMENT),
        stability_report.ZONES,
    ],
)
def test_tables_of_80_columns_lose_no_heading_and_no_unit(
    columns: tuple[Column, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    values = {"": "backward", "d": 12}
    row = {column.key: values.get(column.form[-1:], -1.2345e-7) for column in columns}
    terminal.emit(None, table([row], columns), json=False)
    printed = capsys.readouterr().out
    assert "…" not in printed
    head, line = printed.split("─")[0], printed.rsplit("─")[-1]
    headings = [column for column in columns if column.heading]
    for column in headings:
        assert set(column.heading.split()) <= set(head.split())
        assert column.text(row) in line
