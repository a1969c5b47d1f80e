"""`bladewhirl compare`: every contact scheme on one case, as a table, a document and a figure."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from small_run import SMALL

SCHEMES = ["central-difference", "moreau-jean", "penalty"]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("compare")
    (path / "case.toml").write_text(SMALL)
    return path


def compare(place: Path, *arguments: object) -> list[object]:
    short = ["--set", "march.duration=0.004", "--set", "march.record_step=2e-5"]
    return ["compare", place / "case.toml", *short, *arguments]


def test_the_schemes_agree_on_what_the_stage_does(place: Path) -> None:
    document = json.loads(answer(*compare(place, "--json")).stdout)
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


@pytest.mark.slow
def test_table_and_figure(place: Path) -> None:
    done = answer(*compare(place, "-o", place / "out"))
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
    refused = refusal(*compare(place, "-o", place / "out"))
    assert refused == f"{place / 'out'}: already exists; --overwrite writes into it"
