"""The wheel holds every module (package-dir lists are not discovered); bounds were tried."""

import re
import tomllib

import licences
from places import ROOT

FOLDERS = ("meshes", "models", "solvers", "postprocess", "studies")


def test_every_folder_with_code_is_a_declared_package() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {p.parent.relative_to(ROOT) for f in FOLDERS for p in (ROOT / f).rglob("*.py")}
    actual = {"bladewhirl", *(".".join(["bladewhirl", *folder.parts]) for folder in folders)}
    assert actual == set(config["packages"])
    assert config["package-dir"] == {
        "bladewhirl": "bladewhirl",
        **{f"bladewhirl.{folder}": folder for folder in FOLDERS},
    }


def test_lower_bounds_are_those_that_were_tried() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    further = [bound for key in ("cluster", "nastran", "test") for bound in extras[key]]
    bounds = [*project["dependencies"], *further]
    bounds.remove("bladewhirl[cluster,nastran]")
    tried = (ROOT / ".ci" / "lower-bounds.txt").read_text().splitlines()
    assert {re.sub(r"\[.*\]|,<.*", "", bound).replace(">=", "==") for bound in bounds} <= set(tried)


def test_dependencies_and_theirs_are_under_permissive_licences() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    own = {re.split(r"[^\w.-]", bound)[0] for bound in project["dependencies"]}
    assert own < set(licences.dependencies())


def test_the_source_distribution_holds_what_tests_read() -> None:
    declared = (ROOT / "MANIFEST.in").read_text()
    for line in ("graft tests", "graft docs", "graft examples", "graft benchmarks", "graft .ci"):
        assert f"{line}\n" in declared
    for line in ("CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "SECURITY.md"):
        assert line in declared
