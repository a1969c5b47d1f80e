"""`bladewhirl compare`: every contact scheme on one case, as a table, a document and a figure."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_run import SMALL
from typer.testing import CliRunner, Result

from bladewhirl.studies.commands.cli import app

SCHEMES = ["central-difference", "moreau-jean", "penalty"]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("compare")
    (path / "case.toml").write_text(SMALL)
    return path


def compare(place: Path, *arguments: str) -> Result:
    short = ["--set", "march.duration=0.004", "--set", "march.record_step=2e-5"]
    return CliRunner().invoke(app, ["compare", str(place / "case.toml"), *short, *arguments])


def test_the_schemes_agree_on_what_the_stage_does(place: Path) -> None:
    done = compare(place, "--json")
    assert done.exit_code == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["title"] == "A few blades"
    rows = document["schemes"]
    assert [row["scheme"] for row in rows] == SCHEMES
    assert [row["end_time"] for row in rows] == pytest.approx([0.004] * 3)
    first, impacts, springs = rows
    assert first["distance"] == 0.0
    assert first["impulse"] > 0.0
    for other in (impacts, springs):
        assert 0.0 < other["distance"] < 0.2
        assert other["impulse"] == pytest.approx(first["impulse"], rel=0.2)
        assert other["tip_displacement"] == pytest.approx(first["tip_displacement"], rel=0.2)
    # What pushes back elastically has to be pushed in; multipliers let nothing through.
    assert springs["penetration"] > 1e3 * first["penetration"]
    assert all(row["ledger"] < 0.05 for row in rows)
    assert all(row["step_cost"] > 0.0 for row in rows)


def test_table_and_figure(place: Path) -> None:
    done = compare(place, "-o", str(place / "out"))
    assert done.exit_code == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines() if line.strip()]
    assert lines[1] == ["quantity", *SCHEMES]
    assert lines[3] == ["end", "[ms]", "4", "4", "4"]
    assert {path.name for path in (place / "out").iterdir()} >= {"schemes.nc", "schemes.png"}
    with xr.open_dataset(place / "out" / "schemes.nc") as data:
        assert data["energy"].sizes == {"scheme": 3, "time": 201}
        assert np.isfinite(data["energy"]).all()
        printed = next(line for line in lines if line[0] == "normal")[-3:]
        last = data["impulse"].isel(time=-1).values
        np.testing.assert_allclose([float(word) for word in printed], last, rtol=1e-3)
    refused = compare(place, "-o", str(place / "out"))
    assert refused.exit_code == 2
    assert refused.stderr == f"{place / 'out'}: already exists; --overwrite writes into it\n"


def test_faults_of_one_scheme_are_reported(place: Path) -> None:
    refused = compare(place, "--set", "contact.penalty_stiffness=1e13")
    assert refused.exit_code == 2
    assert refused.stderr.startswith("--set: contact.penalty_stiffness = 1e13: expected less (")
