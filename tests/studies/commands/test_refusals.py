"""No command that writes pictures or series replaces files of the user without --overwrite."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from bladewhirl.studies.commands.cli import app

RUNNER = CliRunner()


@pytest.mark.parametrize(
    ("command", "file"),
    [
        (["render", "RUN", "--png"], "mine.png"),
        (["plot", "RUN", "orbit"], "orbit.png"),
        (["export", "RUN", "--frames", "2"], "mesh.vtu"),
    ],
)
def test_a_file_that_is_not_listed_stays(
    run: Path, tmp_path: Path, command: list[str], file: str
) -> None:
    folder = tmp_path / "mine"
    theirs = folder / file
    theirs.parent.mkdir(parents=True)
    theirs.write_text("precious")
    target = theirs if command[0] == "render" else folder
    words = [str(run) if word == "RUN" else word for word in command]
    refused = RUNNER.invoke(app, [*words, "-o", str(target)])
    assert refused.exit_code == 2
    assert refused.stderr.splitlines()[-1].endswith("--overwrite replaces it)")
    assert theirs.read_text() == "precious"
    assert [path for path in folder.rglob("*") if path.is_file()] == [theirs]
