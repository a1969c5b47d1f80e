"""`bladewhirl verify`: its table is complete, and fails where a reference is wrong.

All cases are computed elsewhere: by the documentation, whose page on verification has the table,
and with the long ones by `bladewhirl verify --full` in `.ci/nightly`.
"""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from places import ROOT
from typer.testing import CliRunner

from bladewhirl.studies.commands import checks
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.verification.case import CASES, Pair, VerificationCase, reference, rows
from bladewhirl.studies.verification.table import SUBJECTS, cases

DEFAULT = cases()


def test_the_table_is_complete() -> None:
    assert len(DEFAULT) >= 45
    assert {case.subject for case in DEFAULT} == set(SUBJECTS)
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)
    assert {name.partition("[")[0] for name in names} == set(rows())
    assert all(case.source and case.quantity and case.tolerance >= 0.0 for case in CASES)


def test_every_file_of_references_has_an_origin() -> None:
    files = list((ROOT / "studies" / "verification" / "data").glob("*.json"))
    assert len(files) >= 8
    assert all(len(reference(file.stem)["origin"]) > 40 for file in files)


def verified(*options: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(app, ["verify", "rings", *options])
    return done.exit_code, done.stdout, done.stderr


def test_the_command_prints_one_document(tmp_path: Path) -> None:
    page = tmp_path / "verification.html"
    code, out, err = verified("--json", "--html", str(page))
    document = json.loads(out)
    assert code == 0
    assert document["passed"] is True
    assert {type(document["version"]), type(document["cases"])} == {str, list}
    expected: dict[str, Any] = {
        "name": str,
        "subject": str,
        "quantity": str,
        "source": str,
        "unit": str,
        "values": int,
        "reference": float,
        "ours": float,
        "error": float,
        "tolerance": float,
        "measure": str,
        "seconds": float,
        "passed": bool,
    }
    for row in document["cases"]:
        assert {key: type(value) for key, value in row.items()} == expected
    assert f"Wrote {page}" in err
    assert page.read_text(encoding="utf-8").count("NAFEMS R0015") == 3


def test_the_table_in_markdown_and_on_a_terminal() -> None:
    code, out, _ = verified("--markdown")
    assert code == 0
    assert out.startswith("## Rings\n\n|  | quantity |")
    assert out.count("\n| pass |") == len(cases(["rings"]))
    code, out, _ = verified()
    assert code == 0
    assert f"{len(cases(['rings']))} of {len(cases(['rings']))} cases pass" in out


def test_a_wrong_reference_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    known = reference("published")["nafems_ring_hz"]
    monkeypatch.setitem(known, "3", 1.01 * known["3"])
    code, out, _ = verified("--json")
    document = json.loads(out)
    assert code == 1
    assert document["passed"] is False
    failed = [row["name"] for row in document["cases"] if not row["passed"]]
    assert failed == ["rings.nafems_ring[3]"]


def made(pair: Pair) -> VerificationCase:
    """A case of that reference and ours that is in no table."""
    return replace(DEFAULT[0], measure="relative", tolerance=0.1, compute=lambda: pair)


@pytest.mark.parametrize("ours", [float("nan"), float("inf"), 2.0])
def test_what_is_no_number_fails(ours: float) -> None:
    outcome = made(([1.0, 1.0], [1.0, ours])).run()
    assert not outcome.passed
    assert outcome.values == 2


def test_shapes_must_agree() -> None:
    case = made(([1.0, 1.0], 1.0))
    with pytest.raises(ValueError, match=r"shapes \(2,\) and \(1,\)"):
        case.run()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--json", "--markdown"], "--json, --markdown: omit one of them"),
        (["--html", "table.txt"], ".html"),
        (["bearings"], "bearings: expected one of the subjects modes, rings"),
    ],
)
def test_requests_that_make_no_sense(options: list[str], expected: str) -> None:
    code, _, err = verified(*options)
    assert code == 2
    assert expected in err


def test_help_names_all_subjects() -> None:
    assert set(SUBJECTS) <= set(re.findall(r"\w+", checks.verify.__doc__ or ""))
