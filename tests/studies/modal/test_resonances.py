"""Resonances with waves of the wall and engine orders, with free and with held tips."""

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
from command_line import answer
from exported_stages import BLADES, beams, exported

import bladewhirl as bw
from bladewhirl.models.case.applied_orders import applied_orders
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.studies.modal.resonances import margin, met_wave

CURVED = {
    "bladed_disk": {
        "blades": BLADES,
        "elements_per_blade": 4,
        "centre_line": [{"span": 0.5, "angle": "6 deg"}, {"span": 1.0, "angle": "20 deg"}],
    }
}


def curved(**tables: object) -> bw.Case:
    load = {"type": "engine-order", "order": [2, 4], "amplitude": 1.0}
    return beams("sector", **(CURVED | {"excitation": load} | tables))


@pytest.mark.parametrize(
    ("order", "expected"), [(2, (2, 1)), (3, (2, -1)), (4, (1, -1)), (5, (0, 1)), (11, (1, 1))]
)
def test_orders_are_aliased(order: int, expected: tuple[int, int]) -> None:
    """exp(i r theta) at five blades is exp(i k theta), or exp(-i k theta)."""
    assert met_wave(order, 5) == expected
    k, sign = expected
    theta = 2.0 * np.pi * np.arange(5) / 5
    assert np.exp(1j * order * theta) == pytest.approx(np.exp(1j * sign * k * theta))


def test_bands_of_beams_lie_between_free_and_held_tips() -> None:
    case = curved()
    diagram, stage = bw.campbell(case, families=3), build_beams(case)
    structure, radial = stage.disk.structure, stage.disk.tip_radial
    kept = np.setdiff1d(np.arange(structure.size), radial)
    matrices = [each.toarray() for each in (structure.stiffness, structure.mass)]
    free, held = (
        np.sqrt(la.eigvalsh(*(matrix[np.ix_(rows, rows)] for matrix in matrices)))
        for rows in (np.arange(structure.size), kept)
    )
    assert diagram.sizes["resonance"] >= 3
    for n in range(diagram.sizes["resonance"]):
        row = diagram.isel(resonance=n)
        order = int(row["resonance_order"])
        for name, frequencies in (("free", free), ("held", held)):
            w = order * float(row[f"resonance_{name}_rpm"]) * np.pi / 30.0
            assert np.abs(frequencies / w - 1.0).min() < 1e-6
    ratio = diagram["resonance_held"] / diagram["resonance_free"]
    assert float(ratio.max()) > 1.2
    assert float(ratio.min()) >= 1.0


@pytest.mark.parametrize("kind", ["sector", "blade", "wheel"])
def test_superelements_have_the_bands_of_their_beams(kind: str, tmp_path: Path) -> None:
    disk = {"disk_kind": "rigid"} if kind == "blade" else {}
    own = beams(kind, **{"bladed_disk": CURVED["bladed_disk"] | disk})  # type: ignore[arg-type]
    nodes = exported(own, kind, tmp_path)  # type: ignore[arg-type]
    first, second = (bw.campbell(each, orders=[2, 4], families=2) for each in (own, nodes))
    assert first.sizes["resonance"] == second.sizes["resonance"] >= 2
    for name in ("resonance_free_rpm", "resonance_held_rpm"):
        assert second[name].values == pytest.approx(first[name].values, rel=1e-6)


def test_the_table_is_sorted_by_margin(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(curved()), encoding="utf-8")
    words = ("campbell", file, "--operating", "0.2:0.24", "--orders", "3")
    document = json.loads(answer(*words, "--json").stdout)
    margins = [row["margin"] for row in document["resonances"]]
    assert margins == sorted(margins)
    assert {row["source"] for row in document["resonances"]} == {"engine order", "given"}


def test_margins() -> None:
    assert margin(1.0, 1.2, (1.1, 2.0)) == 0.0
    assert margin(1.0, 1.2, (2.0, 3.0)) == pytest.approx(0.4)
    assert margin(4.0, float("nan"), (2.0, 3.0)) == pytest.approx(1.0 / 3.0)
    assert np.isnan(margin(1.0, 1.2, (float("nan"), float("nan"))))


def test_orders_of_the_case() -> None:
    lobes = {"casing.clearance_lobes": [{"lobes": 2, "amplitude": "0.1 mm"}]}
    case = bw.with_values(curved(), lobes)
    assert applied_orders(case.casing, case.excitations.values()) == {
        2: "wall, engine order",
        4: "engine order",
    }


def test_unequal_blades_have_no_bands() -> None:
    case = bw.with_values(curved(), {"bladed_disk.mistuning": {"stiffness_spread": 0.02}})
    assert modal_model(case).disk_modes.count
    assert "resonance" not in bw.campbell(case).dims
    with pytest.raises(UserError, match="campbell: orders: expected equal sectors"):
        bw.campbell(case, orders=[3])


def test_speeds_to_avoid_lie_in_or_near_the_operating_range(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(bw.dumps_case(curved(rotation={"effects": "full"})), encoding="utf-8")
    words = (
        "campbell",
        case,
        "--families",
        2,
        "--speeds",
        "0:3",
        "--operating",
        "0.4:1.5",
        "--json",
    )
    document = json.loads(answer(*words).stdout)
    rows = document["speeds_to_avoid"]
    low, high = (60.0 * document["reference_frequency_hz"] * each for each in (0.4, 1.5))
    ends = [
        (min(r["free_rpm"], r["held_rpm"]), max(r["free_rpm"], r["held_rpm"]))
        for r in document["resonances"]
    ]
    ends += [(row["speed_rpm"],) * 2 for row in document["coincidences"]]
    ends += [(row["rpm"],) * 2 for row in document["critical_speeds"]]
    near = sorted(end for end in ends if end[0] <= 1.2 * high and end[1] >= 0.8 * low)
    found = [(row["from_rpm"], row["to_rpm"]) for row in rows if row["to_rpm"] is not None]
    assert len(near) > 2
    assert np.array(sorted(found)) == pytest.approx(np.array(near))
    assert {row["cause"].split()[0] for row in rows} >= {"order"}
    for row in rows:
        inside = row["from_rpm"] <= high and (row["to_rpm"] or np.inf) >= low
        assert (row["margin"] == 0.0) == inside
    assert [row["margin"] for row in rows] == sorted(row["margin"] for row in rows)


def test_without_speeds_to_avoid_there_is_a_sentence_and_no_empty_table(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(bw.dumps_case(curved()), encoding="utf-8")
    words = ("--speeds", "0:0.1", "--operating", "0.001:0.002", "-o", tmp_path / "found")
    printed = answer("campbell", case, *words).stdout
    assert "No speeds to avoid, to 20% from the operating range." in printed
    assert "cause" not in printed
