"""Licences of the installed dependencies, from their metadata."""

import re
import tomllib
from importlib.metadata import distribution

from blocks import ROOT
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PERMISSIVE = re.compile(r"\b(MIT|BSD|Apache|PSF|Python Software Foundation|ISC)\b")
OTHERS = {"certifi": "Mozilla Public License 2.0"}
"""Other allowed licences: certifi's licence only requires that changes of certifi are published."""


def dependencies() -> dict[str, str]:
    """Return the licences of direct and indirect dependencies, by name of the package."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    waiting, seen = [Requirement(each) for each in project["dependencies"]], set[str]()
    while waiting:
        requirement = waiting.pop()
        for extra in ("", *requirement.extras):
            if (name := f"{canonicalize_name(requirement.name)}[{extra}]") not in seen:
                seen.add(name)
                listed = map(Requirement, distribution(requirement.name).requires or ())
                waiting += [
                    one
                    for one in listed
                    if one.marker is None or one.marker.evaluate({"extra": extra})
                ]
    return {name: _licence(name) for name in sorted({name.partition("[")[0] for name in seen})}


def _licence(name: str) -> str:
    metadata = distribution(name).metadata.json
    listed = [line for line in metadata.get("classifier", ()) if line.startswith("License ::")]
    named = metadata.get("license_expression") or "; ".join(listed) or metadata.get("license", "")
    text = str(named).replace("License :: OSI Approved :: ", "")
    if name in OTHERS and OTHERS[name] in text:
        return text
    if "GPL" in text or not PERMISSIVE.search(text):
        raise ValueError(f"{name}: expected a permissive licence, not {text!r}")
    return text


def table() -> str:
    """Return a Markdown table of dependencies with installed version and licence."""
    rows = "\n".join(
        f"| {name} | {distribution(name).version} | {licence} |"
        for name, licence in dependencies().items()
    )
    return f"| package | here | licence |\n|---|---|---|\n{rows}\n"
