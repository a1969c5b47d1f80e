"""Commands that refuse their input in one line, and leave the files of the user as they are."""

import shlex
import tomllib
from pathlib import Path

import pytest
from command_line import refusal
from places import DATA, EXAMPLES
from small_run import SMALL
from synthetic_result import synthetic_result

REFUSED = tomllib.loads((DATA / "refusals.toml").read_text(encoding="utf-8"))

TEXTS = {
    "small.toml": SMALL,
    "few.toml": "bladed_disk = { blades = 5, elements_per_blade = 2 }\n",
    "extreme.toml": "bladed_disk = { blades = 5, elements_per_blade = 2 }\n"
    "casing.elements = 20\nreduction.fixed_interface_modes = 10\n",
    "table.csv": "march.speed\n1.1\n",
    "result.nc": "broken",
    "bad.msh": "nonsense",
}


@pytest.fixture(scope="module")
def files(run: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Files by their names in commands."""
    folder = tmp_path_factory.mktemp("files")
    for name, text in TEXTS.items():
        (folder / name).write_text(text)
    (folder / "one").mkdir()
    synthetic_result(records=1).to_netcdf(folder / "one" / "result.nc", engine="h5netcdf")
    return {
        "FAN": EXAMPLES / "fan_stage.toml",
        "RUN": run,
        "BROKEN": folder,
        "ONE": folder / "one",
        **{name.split(".")[0].upper(): folder / name for name in TEXTS},
    }


@pytest.mark.parametrize(("command_line", "expected"), REFUSED.items(), ids=REFUSED)
def test_bad_input_is_one_line(
    files: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command_line: str,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, path in files.items():
        command_line = command_line.replace(f" {name}", f" {path}")
    folders = files["RUN"], files["BROKEN"]
    before = [sorted(folder.rglob("*")) for folder in folders]
    assert expected in refusal(*shlex.split(command_line))
    assert [sorted(folder.rglob("*")) for folder in folders] == before
    assert not [*tmp_path.iterdir()]


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
