"""`import bladewhirl as bw`: its names, what they load, its tour, its version."""

import inspect
import re
import textwrap
import tomllib
from pathlib import Path

import pytest
from command_line import loaded
from places import DATA, ROOT

import bladewhirl as bw

GOLDEN = DATA / "public_names.txt"
"""Made by python -c "import bladewhirl; print(*dir(bladewhirl), sep='\\n')"."""

DOCUMENTS = [
    *(ROOT / "README.md", *(ROOT / "docs").glob("*.md")),
    *(path for path in (ROOT / "examples").glob("*") if path.suffix != ".npz"),
]


def test_public_names_change_on_purpose() -> None:
    assert dir(bw) == GOLDEN.read_text().split()
    assert sorted(bw.__all__) == dir(bw)


@pytest.mark.parametrize("name", bw.__all__)
def test_a_name_is_that_of_what_it_names(name: str) -> None:
    actual = getattr(bw, name)
    if name != "__version__":
        assert actual.__name__.rpartition(".")[2] == name
        assert inspect.getdoc(actual)


def test_the_tour_names_all() -> None:
    named = set(re.findall(r"`(\w+)`", bw.__doc__ or ""))
    assert set(bw.__all__) - {"__version__"} <= named


def test_its_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tour = bw.__doc__ or ""
    [code] = re.findall(r"::\n\n((?:    .*\n)+(?:\n(?:    .*\n)+)*)", tour)
    exec(compile(textwrap.dedent(code), "tour", "exec"))
    assert (tmp_path / "runs" / "first" / "my_orbit.png").is_file()


def test_nothing_is_loaded_before_it_is_used() -> None:
    door = loaded("import bladewhirl as bw; dir(bw); bw.__version__")
    case = loaded("import bladewhirl as bw; bw.case_from")
    assert {name for name in door if name.startswith("bladewhirl.")} == {"bladewhirl.threads"}
    assert "numpy" not in door
    assert case.isdisjoint({"_cffi_backend", "xarray", "matplotlib", "pyvista", "skfem"})


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_documents_use_the_front_door(document: Path) -> None:
    assert not re.search(r"(from|import) bladewhirl\.", document.read_text(encoding="utf-8"))


def test_the_version_is_one() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = (ROOT / "CITATION.cff").read_text()
    changes = (ROOT / "CHANGELOG.md").read_text()
    assert f"\nversion: {project['version']}\n" in citation
    [released, *_] = re.findall(r"^## \[([\d.]+)\] - \d{4}-\d{2}-\d{2}$", changes, re.MULTILINE)
    assert released == project["version"] == bw.__version__
