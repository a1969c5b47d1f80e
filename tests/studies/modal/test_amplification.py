"""Amplification of the response by random patterns of blade stiffness."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer
from exported_stages import beams, exported
from places import EXAMPLES
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector

import bladewhirl as bw
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.beam_rotor import stiffness_of_blades
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.superelements import nodal_blocks
from bladewhirl.studies.modal.amplification import amplification_rows
from bladewhirl.studies.modal.response import largest

LOAD = {"type": "engine-order", "order": 2, "amplitude": 1.0}


def directly(case: bw.Case, draw: int, speeds: list[float], tuned: bw.Case) -> float:
    """The amplification of one pattern from two responses."""
    seed = {"bladed_disk.mistuning.seed": case.bladed_disk.mistuning.seed + draw}
    both = (
        largest(bw.response(each, speeds=speeds))[0]["amplitude"]
        for each in (bw.with_values(case, seed), tuned)
    )
    mistuned, equal = both
    return float(mistuned / equal)


def spread(seed: int = 4) -> dict[str, Any]:
    return {"bladed_disk.mistuning": {"stiffness_spread": 0.02, "seed": seed}}


DAMPED = {"stiffness": 2e7, "damping": 2e4}


def test_a_damped_resonance_is_named_by_its_peak() -> None:
    """Also if its natural frequency, 4357 rpm, is inside the range."""
    shaft = {"clamped": False, "stiffness": 2e7, "damping": 2e4}
    disk = {"blades": 8, "elements_per_blade": 2, "tip_radius": 0.4, "disk_radius": 0.07}
    case = bw.case_from(
        {
            "bladed_disk": disk,
            "shaft": shaft,
            "damping": {"ratio": 4e-3},
            "excitation": {"type": "engine-order", "order": 1, "amplitude": 10.0},
        }
    )
    (peak,) = bw.response(case, speeds=["4000 rpm", "5000 rpm"])["peak_rpm"].values
    for low, high in ((3544, 4400), (4440, 5000)):
        end = bw.response(case, speeds=[f"{n} rpm" for n in np.linspace(low, high, 9)])
        assert end["resonance_beyond"].values == pytest.approx(peak, rel=1e-4)


@pytest.mark.parametrize(
    ("effects", "shaft"),
    [
        pytest.param("none", None, marks=pytest.mark.slow),
        pytest.param("centrifugal", None, marks=pytest.mark.slow),
        pytest.param("full", None, marks=pytest.mark.slow),
        ("none", DAMPED),
        pytest.param("full", DAMPED, marks=pytest.mark.slow),
        pytest.param("full", DAMPED | {"damping_frame": "static"}, marks=pytest.mark.slow),
    ],
)
def test_patterns_of_beams_have_the_amplification_of_their_responses(
    effects: str, shaft: dict[str, Any] | None
) -> None:
    """With all modes, at any speed near the tuned peak; order 1 moves a shaft with dampers."""
    given: dict[str, Any] = {"damping": {"ratio": 2e-3}, "rotation": {"effects": effects}}
    given |= {"reduction": {}}  # all modes
    if shaft is None:
        tuned, ends = beams("sector", excitation=LOAD, **given), (0.4, 0.7, 7)
    else:
        tuned = beams("wheel", excitation=LOAD | {"order": 1}, shaft=shaft, **given)
        ends = (0.4, 1.3, 31)
    case, speeds = bw.with_values(tuned, spread()), np.linspace(*ends).tolist()
    data = bw.amplification(case, draws=5, speeds=speeds)
    compared = range(1 if effects == "full" and shaft is None else 5)  # others are slow
    expected = [directly(case, draw, speeds, tuned) for draw in compared]
    found = data["amplification"].values[0]
    assert found[: len(expected)] == pytest.approx(expected, rel=1e-4)
    assert np.ptp(found) > 0.05
    if shaft is None:
        assert (data["amplification"] < data.attrs["whitehead_bound"]).all()


@pytest.mark.slow
def test_patterns_of_an_exported_sector_have_the_amplification_of_their_responses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All patterns follow from one reduction, without motions of mistuned blades."""
    tuned = exported(
        beams("sector"),
        "sector",
        tmp_path,
        excitation=LOAD,
        damping={"ratio": 2e-3},
        reduction={"free_interface_modes": 6},
    )
    case, speeds = bw.with_values(tuned, spread()), np.linspace(0.4, 0.7, 16).tolist()
    reduced: list[bool] = []
    compute = nodal_blocks.sector_blocks

    def counted(*given: Any, **options: Any) -> Any:
        reduced.append(options["mistuned"])
        return compute(*given, **options)

    with monkeypatch.context() as patch:
        patch.setattr("bladewhirl.models.superelements.wheel.sector_blocks", counted)
        data = bw.amplification(case, draws=5, speeds=speeds)
    assert reduced == [False]
    expected = [directly(case, draw, speeds, tuned) for draw in range(5)]
    assert data["amplification"].values[0] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    ("effects", "order", "ends"),
    [
        ("none", 2, (0.45, 0.55, 41)),
        pytest.param("full", 3, (0.48, 0.56, 5), marks=pytest.mark.slow),
    ],
)
def test_patterns_of_sectors_have_the_amplification_of_their_responses(
    effects: str, order: int, ends: tuple[float, float, int], tmp_path: Path
) -> None:
    part = bw.mesh3d(
        bladed_sector("hexahedron"),
        **STEEL,
        **TIE,
        contacts=2,
        blade="r > 0.0899",
        coriolis=effects == "full",
    )
    bw.write_superelement(tmp_path / "part.npz", part)
    table = {"file": str(tmp_path / "part.npz"), "kind": "sector", "copies": SECTORS}
    tuned = bw.case_from(
        {
            "bladed_disk": {"superelement": table},
            "casing": {"type": "rigid"},
            "shaft": {"clamped": True},
            "damping": {"ratio": 2e-3},
            "excitation": LOAD | {"order": order},
            "rotation": {"effects": effects},
            "reduction": {"free_interface_modes": 8},
        }
    )
    case, speeds = bw.with_values(tuned, spread()), np.linspace(*ends).tolist()
    data = bw.amplification(case, draws=3, speeds=speeds)
    for draw in range(2):  # the tuned modes leave an error of 3e-5 in frequencies
        expected = directly(case, draw, speeds, tuned)
        assert data["amplification"].values[0, draw] == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["curved_blades", "shrouded_blades", "rim_disk"])
def test_stiffnesses_of_blades_add_up_to_that_of_mistuning(name: str) -> None:
    """On curved blades, on blades with shrouds, and on a disk with springs to its rim."""
    case = bw.read_case(EXAMPLES / f"{name}.toml", ["rotation.effects=none"])
    factors = 1.0 + 0.05 * np.random.default_rng(1).standard_normal(case.bladed_disk.count)
    mistuned = bw.with_values(case, {"bladed_disk.mistuning": {"stiffness": factors.tolist()}})
    equal, unequal = (build_beams(each).disk for each in (case, mistuned))
    change = unequal.structure.stiffness - equal.structure.stiffness
    pairs = zip(factors, stiffness_of_blades(equal), strict=True)
    found = sum((factor - 1.0) * own for factor, own in pairs)
    assert abs(change - found).max() < 1e-11 * abs(change).max()


@pytest.mark.slow
def test_percentiles_have_bands() -> None:
    case = bw.with_values(beams("sector", excitation=LOAD, damping={"ratio": 5e-3}), spread())
    data = bw.amplification(case, draws=200, speeds=np.linspace(0.4, 0.7, 31).tolist())
    (row,) = amplification_rows(data)
    values = np.sort(data["amplification"].values[0])
    assert row["median_band"][0] < row["median"] < row["median_band"][1]
    inside = (values >= row["median_band"][0]) & (values <= row["median_band"][1])
    assert 20 <= inside.sum() <= 40  # twice 1.96 standard deviations, sqrt(200) / 2 each
    assert row["p99_band"][1] == row["largest"] == values[-1]


def test_the_command_prints_percentiles(tmp_path: Path) -> None:
    case = bw.with_values(beams("sector", excitation=LOAD), spread())
    (tmp_path / "case.toml").write_text(bw.dumps_case(case), encoding="utf-8")
    words = ("response", tmp_path / "case.toml", "--draws", 20, "--speeds", "0.4:0.7:0.02")
    text = answer(*words, "-o", tmp_path / "out").output
    assert "Amplification by mistuning, 20 patterns" in text
    assert (tmp_path / "out" / "amplification.png").exists()


def test_an_amplitude_at_the_end_of_the_speeds_is_no_peak() -> None:
    """The error names the resonance; the table and the document of a response do too."""
    tuned = beams("sector", excitation=LOAD)
    (row,) = largest(bw.response(tuned, speeds=np.linspace(0.4, 0.7, 31).tolist()))
    assert row["place"] == "peak"
    case = bw.with_values(tuned, spread())
    for speeds in (np.linspace(0.3, 0.42, 13), np.linspace(0.62, 0.8, 13)):
        (end,) = largest(bw.response(tuned, speeds=speeds.tolist()))
        assert end["place"].startswith("end of the range, resonance at")
        assert end["resonance_rpm"] == pytest.approx(row["rpm"], rel=2e-3)
        with pytest.raises(UserError, match=rf"resonance at {end['resonance_rpm']:.0f} rpm"):
            bw.amplification(case, draws=2, speeds=speeds.tolist())
    at = row["speed"] + np.array([-1e-3, -5e-4, 0.0, 5e-4])
    with pytest.raises(UserError, match=r"speeds beyond .* \d+ of 20 patterns"):
        bw.amplification(case, draws=20, speeds=at.tolist())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({}, "expected bladed_disk.mistuning.stiffness_spread"),
        (spread() | {"excitation.order": [0, 2]}, "expected engine orders of 1 or more"),
    ],
)
def test_refusals(changes: dict[str, Any], message: str) -> None:
    case = bw.with_values(beams("sector", excitation=LOAD), changes)
    with pytest.raises(UserError, match=message):
        bw.amplification(case, draws=2, speeds=[0.4, 0.5, 0.6])


def test_separate_blades_are_refused(tmp_path: Path) -> None:
    case = bw.with_values(exported(beams("blade"), "blade", tmp_path, excitation=LOAD), spread())
    with pytest.raises(UserError, match=r'expected beams, or .*kind = "sector"'):
        bw.amplification(case, draws=2, speeds=[0.4, 0.5, 0.6])
