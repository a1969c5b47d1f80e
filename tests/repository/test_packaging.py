"""The wheel holds every module (package-dir lists are not discovered); bounds were tried."""

import re
import tomllib
from importlib.metadata import metadata

from places import ROOT

PERMISSIVE = re.compile(r"\b(MIT|BSD|Apache|PSF|Python Software Foundation)\b")

FOLDERS = ("meshes", "models", "solvers", "postprocess", "studies")


def test_every_folder_with_code_is_a_declared_package() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {p.parent.relative_to(ROOT) for f in FOLDERS for p in (ROOT / f).rglob("*.py")}
    found = {"bladewhirl", *(".".join(["bladewhirl", *folder.parts]) for folder in folders)}
    assert found == set(config["packages"])
    assert config["package-dir"] == {
        "bladewhirl": "bladewhirl",
        **{f"bladewhirl.{folder}": folder for folder in FOLDERS},
    }


def test_lower_bounds_are_those_that_were_tried() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    bounds = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    tried = (ROOT / ".ci" / "lower-bounds.txt").read_text().splitlines()
    assert {re.sub(r"\[.*\]|,<.*", "", bound).replace(">=", "==") for bound in bounds} <= set(tried)


def test_dependencies_are_under_permissive_licences() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for bound in project["dependencies"]:
        name = re.split(r"[^\w.-]", bound)[0]
        told = metadata(name).json
        classifiers = [line for line in told.get("classifier", ()) if line.startswith("License")]
        text = str(told.get("license_expression") or classifiers or told["license"])
        assert PERMISSIVE.search(text), f"{name}: {text}"
        assert "GPL" not in text, f"{name}: {text}"
