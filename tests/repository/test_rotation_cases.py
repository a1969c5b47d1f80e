"""The page on the paper's cases with rotation effects: rows of its table, marched again."""

import csv
from pathlib import Path

import pytest

import bladewhirl as bw

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "seconds"), [("casing_distortion", 1.5), ("imbalance", 3.0)])
def test_the_march_at_1_05_with_all_effects_is_as_the_page_says(
    case: str, seconds: float, tmp_path: Path
) -> None:
    with (ROOT / "docs" / "rotation_cases.csv").open(encoding="utf-8") as file:
        (row,) = [
            row
            for row in csv.DictReader(file)
            if (row["case"], row["effects"], row["speed"]) == (case, "full", "1.05")
        ]
    changes = {"rotation.effects": "full", "march.speed": 1.05, "march.duration": seconds}
    marched = bw.with_values(bw.read_case(ROOT / "examples" / f"{case}.toml"), changes)
    summary = bw.run(marched, tmp_path / "run", frames=0).summary
    assert summary.regime == row["regime"]
    assert summary.end_time == pytest.approx(float(row["end_time"]), rel=0.02)
    frequency = summary.whirl_frequency_rotating
    assert (frequency or 0.0) == pytest.approx(float(row["whirl_frequency"]), abs=1.0)
