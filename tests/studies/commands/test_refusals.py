"""No command that writes pictures or series replaces files of the user without --overwrite."""

from pathlib import Path

import pytest
from places import EXAMPLES
from typer.testing import CliRunner

from bladewhirl.studies.commands.cli import app

RUNNER = CliRunner()
SMALL = ("--set", "bladed_disk.blades=5", "--set", "bladed_disk.elements_per_blade=2")


@pytest.mark.parametrize(
    ("command", "file"),
    [
        (["render", "RUN", "--png"], "mine.png"),
        (["plot", "RUN", "orbit"], "orbit.png"),
        (["show", "CASE", "--png"], "mine.png"),
        (["export", "RUN", "--frames", "2"], "mesh.vtu"),
        (["report", "RUN"], "mine.html"),
        (["veering", "CASE", *SMALL], "families.png"),
    ],
)
def test_a_file_that_is_not_listed_stays(
    run: Path, tmp_path: Path, command: list[str], file: str
) -> None:
    folder = tmp_path / "mine"
    theirs = folder / file
    theirs.parent.mkdir(parents=True)
    theirs.write_text("precious")
    places = {"RUN": str(run), "CASE": str(EXAMPLES / "imbalance.toml")}
    target = folder if command[0] in ("export", "plot", "veering") else theirs
    words = [places.get(word, word) for word in command]
    refused = RUNNER.invoke(app, [*words, "-o", str(target)])
    assert refused.exit_code == 2
    assert refused.stderr.splitlines()[-1].endswith("--overwrite replaces it)")
    assert theirs.read_text() == "precious"
    assert [path for path in folder.rglob("*") if path.is_file()] == [theirs]


@pytest.mark.parametrize("command", ["export", "render"])
def test_more_frames_than_records(run: Path, tmp_path: Path, command: str) -> None:
    arguments = ["--frames", str(10**20), "--from", "0.1", "--to", "0.103"]
    target = tmp_path / ("page.html" if command == "render" else "series")
    done = RUNNER.invoke(app, [command, str(run), *arguments, "-o", str(target)])
    assert done.exit_code == 0, done.stderr
    assert ": 4 " in done.stdout
