"""No command that writes pictures or series replaces files of the user without --overwrite."""

from pathlib import Path

import pytest
from command_line import refusal


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
    refused = refusal(*words, "-o", target)
    assert refused.endswith("--overwrite replaces it)")
    assert theirs.read_text() == "precious"
    assert [path for path in folder.rglob("*") if path.is_file()] == [theirs]


@pytest.mark.parametrize("command", ["compare", "convergence", "mesh", "modes", "response", "run"])
def test_a_change_without_a_value_is_a_fault_of_the_option(tmp_path: Path, command: str) -> None:
    (tmp_path / "case.toml").write_text("")
    refused = refusal(command, tmp_path / "case.toml", "--set", "garbage")
    assert refused == "--set garbage: expected KEY=VALUE with a dotted key, such as march.speed=1.2"
