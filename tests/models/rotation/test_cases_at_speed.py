"""Cases whose bladed disk feels that it turns: stages, clearances, calibration, refusals."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer
from stages import oracle

from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.file import loads, with_values
from bladewhirl.models.case.shaft import Rotation
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.loads import unbalance
from bladewhirl.models.structure.eigenproblems import damped_eigenvalues

WAYS = ("backward", "forward")
THIN = oracle("rotation")["stages"]["0.01"]


def turning(effects: str = "centrifugal", **tables: Any) -> Case:
    """The stage of Table 1 at 1.05."""
    return case_from(
        {
            "bladed_disk": {"disk": {"thickness": 0.01}},
            "march": {"speed": 1.05},
            "rotation": {"effects": effects},
            **tables,
        }
    )


def known(ratio: float) -> Any:
    (row,) = [row for row in THIN["speeds"] if row["ratio"] == ratio]
    return row


def test_the_table_goes_to_a_file_and_back() -> None:
    assert Case().rotation == Rotation(effects="none", clearance="hot")
    case = turning(rotation={"effects": "full", "clearance": "cold"})
    assert loads(dumps_case(case)) == case
    assert 'rotation     { effects = "full", clearance = "cold" }' in repr(case)
    assert "\n  rotation " not in repr(Case())


@pytest.mark.parametrize("ratio", [1.05, 1.6])
def test_the_reduction_at_speed(ratio: float) -> None:
    """On a basis found with K_Omega, as accurate as the reference found such a basis to be."""
    stage = build_beams(with_values(turning(), {"march.speed": ratio}))
    actual = stage.reduction.modes
    for k, frequencies in known(ratio)["centrifugal"].items():
        own = np.unique(np.round(actual.frequency[actual.nodal_diameter == int(k)], 9))[:1]
        np.testing.assert_allclose(own / (2 * np.pi), frequencies[:1], rtol=5e-6)
    assert stage.frequency_error["1F"] < 5e-6
    assert max(stage.frequency_error[f] for f in ("1F", "suspension", "2F")) < 7e-4
    assert stage.reference_frequency / (2 * np.pi) == pytest.approx(THIN["reference_hz"], rel=1e-8)


@pytest.mark.slow
def test_a_cold_clearance_is_what_growth_leaves() -> None:
    hot, cold = (
        build_beams(turning(rotation={"effects": "centrifugal", "clearance": state}))
        for state in ("hot", "cold")
    )
    np.testing.assert_array_equal(hot.rotor.tip_recess, 0.0)
    growth = known(1.05)["tip_growth_softened"]
    np.testing.assert_allclose(cold.rotor.tip_recess, -growth, rtol=1e-8)
    for stage in (hot, cold):  # a result says both
        np.testing.assert_array_equal(stage.arrays.tip_recess, stage.rotor.tip_recess)
        np.testing.assert_allclose(stage.arrays.tip_growth, growth, rtol=1e-8)
    case = with_values(cold.case, {"casing.clearance": 9e-5})
    with pytest.raises(CaseError, match="expected room for the growth of the tips"):
        build_beams(case)


@pytest.mark.slow
def test_imbalance_is_calibrated_with_the_stiffness_at_speed() -> None:
    """The force that brings a tip out by the clearance, by its radial displacement."""
    load = {"type": "imbalance", "clearance_speed": 1.05}
    (tip,) = [tip for ratio, _, tip in THIN["steady_per_newton"] if ratio == 1.05]
    for speed in (1.05, 0.5):  # of the march: that of the calibration counts
        stage = build_beams(turning(excitation=load, march={"speed": speed}))
        omega = 1.05 * stage.reference_frequency
        assert unbalance(stage) == pytest.approx(1e-3 / tip / omega**2, rel=1e-8)
    cold = {"effects": "centrifugal", "clearance": "cold"}
    stage = build_beams(turning(excitation=load, rotation=cold))
    room = 1e-3 - known(1.05)["tip_growth_softened"]
    assert unbalance(stage) == pytest.approx(room / tip / omega**2, rel=1e-8)


@pytest.mark.slow
def test_reduced_matrices_with_coriolis_forces() -> None:
    """Waves of the reduced model, and what internal damping does to the slowest of them."""
    reduced, row = build_beams(turning("full")).reduced, known(1.05)
    assert reduced.gyroscopic is not None
    assert abs(reduced.gyroscopic + reduced.gyroscopic.T).max() == 0.0
    waves = [row[way][str(k)][0] for k in range(1, 11) for way in ("backward", "forward")]
    waves += [row["backward"][str(k)][0] for k in (0, 11)]
    actual = reduced.frequencies[:22] / (2 * np.pi)
    np.testing.assert_allclose(actual, sorted(waves), rtol=7e-5)
    damped, _ = damped_eigenvalues(
        reduced.mass, reduced.damping + reduced.gyroscopic, reduced.stiffness
    )
    (growth,) = [growth for ratio, growth, _ in THIN["growth_rates_xi_0.005"] if ratio == 1.05]
    assert damped.real.max() == pytest.approx(growth, rel=2e-4)
    assert "gyroscopic" in reduced.to_xarray()
    assert "gyroscopic" not in build_beams(turning()).reduced.to_xarray()


@pytest.mark.slow
def test_a_march_knows_coriolis_forces_and_damping_of_the_modes_at_rest() -> None:
    """Past the critical speed it needs them."""
    assert contact_problem(build_beams(turning())).rotor.by_velocity is None
    stage = build_beams(turning("full"))
    actual = contact_problem(stage).rotor.by_velocity
    assert actual is not None
    rates, _ = damped_eigenvalues(np.eye(len(actual)), actual, np.diag(stage.rotor.stiffness))
    (growth,) = [growth for ratio, growth, _ in THIN["growth_rates_xi_0.005"] if ratio == 1.05]
    assert rates.real.max() == pytest.approx(growth, rel=2e-4)
    with pytest.raises(CaseError, match=r"march\.speed = 2\.2: expected less than 2\.10802"):
        build_beams(turning(march={"speed": 2.2}))


def listed_modes(case: Case, folder: Path, *options: str) -> dict[str, Any]:
    """What `bladewhirl modes --json` says."""
    file = folder / "case.toml"
    file.write_text(dumps_case(case), encoding="utf-8")
    actual: dict[str, Any] = json.loads(answer("modes", file, "--json", *options).stdout)
    return actual


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "static"), [(1.05, ["backward", "forward"]), (2.5, ["forward", "forward"])]
)
def test_whirling_modes_are_listed(ratio: float, static: list[str], tmp_path: Path) -> None:
    """1F and the suspension with k = 1; past the critical speed 1F's wave forward falls behind."""
    case = with_values(turning("full"), {"march.speed": ratio})
    listed = listed_modes(case, tmp_path)["bladed_disk"]
    for k in ("0", "1", "2", "11"):
        for way in ("backward", "forward"):
            own = [m for m in listed if m["nodal_diameter"] == int(k)]
            own = [m["frequency_hz"] for m in own if m["direction"] in (way, "standing")]
            np.testing.assert_allclose(own[:2], known(ratio)[way][k][:2], rtol=1e-7)
    first = [m for m in listed if m["nodal_diameter"] == 1 and m["family_at_rest"] == "1F"]
    rising = sorted(first[:2], key=lambda m: -m["frequency_hz"])
    assert [m["direction_static"] for m in rising] == static
    assert {m["direction"] for m in first[:2]} == ({"backward"} if ratio > 2.2 else set(WAYS))
    pair = [m for m in listed if m["family_at_rest"] == "suspension"]
    assert [m["direction_static"] for m in pair if m["direction"] == "backward"] == ["backward"]
    standing = [m for m in listed if m["nodal_diameter"] in (0, 11)]
    assert {m["direction_static"] for m in standing} == {"standing"}


def test_modes_of_unlike_sectors_whirl_too(tmp_path: Path) -> None:
    """A stage that is hardly mistuned has nearly the modes of the tuned one, by names and ways."""
    blades = {"blades": 6, "elements_per_blade": 4, "disk": {"thickness": 0.01}}
    tuned = turning("full", bladed_disk=blades)
    unlike = {"stiffness": [1.0, 1.0 + 1e-7, 1.0, 1.0, 1.0, 1.0]}
    lists = [
        listed_modes(case, tmp_path, "--count", "12")["bladed_disk"]
        for case in (tuned, with_values(tuned, {"bladed_disk.mistuning": unlike}))
    ]
    for one, other in zip(*lists, strict=True):
        assert one["frequency_hz"] == pytest.approx(other["frequency_hz"], rel=1e-6)
        assert one["family"] == other["family"]
        assert one["direction"] == other["direction"]


@pytest.mark.parametrize("ratio", [1.05, -1.05])
def test_a_result_has_the_waves_that_its_modes_make_up(ratio: float) -> None:
    """k = 1 and 3 against the full model; mirrored, they travel as they did."""
    arrays = build_beams(turning("full", march={"speed": ratio})).arrays
    for way in WAYS:
        for k in (1, 3):
            own = np.flatnonzero(arrays.rotor_nodal_diameter == k)[:6:2]
            actual = getattr(arrays, f"rotor_{way}_frequency")[own] / (2.0 * np.pi)
            np.testing.assert_allclose(actual, known(1.05)[way][str(k)][:3], rtol=3e-3)


@pytest.mark.slow
def test_the_error_of_the_reduction_is_that_of_its_waves() -> None:
    """At 1.05 backward and forward against the full model's, the other way round alike."""
    ahead, back = (build_beams(turning("full", march={"speed": x})) for x in (1.05, -1.05))
    arrays = ahead.arrays
    own = int(np.flatnonzero(arrays.rotor_nodal_diameter == 1)[0])
    error = max(
        abs(
            getattr(arrays, f"rotor_{way}_frequency")[own] / (2 * np.pi * known(1.05)[way]["1"][0])
            - 1
        )
        for way in WAYS
    )
    assert 0.0 < error <= ahead.frequency_error["1F"] < 1e-3
    assert back.frequency_error == pytest.approx(ahead.frequency_error, rel=1e-3)


@pytest.mark.slow
def test_past_its_critical_speed_a_forward_wave_is_negative() -> None:
    """The one that ends at its critical speed; Coriolis forces aside nothing has two ways."""
    arrays = build_beams(turning("full", march={"speed": 2.5})).arrays
    lowest, next_one = np.flatnonzero(arrays.rotor_nodal_diameter == 1)[[0, 2]]
    assert arrays.rotor_family[lowest] == "suspension"  # 1F at rest
    assert arrays.rotor_forward_frequency[lowest] < 0.0 < arrays.rotor_forward_frequency[next_one]
    none = build_beams(turning("centrifugal")).arrays
    np.testing.assert_array_equal(none.rotor_forward_frequency, none.rotor_frequency)


def test_blades_hardly_unlike_have_nearly_the_same_waves() -> None:
    blades = {"blades": 8, "elements_per_blade": 4, "disk": {"thickness": 0.01}}
    few = {"fixed_interface_modes": 40}
    alike, unlike = (
        build_beams(turning("full", bladed_disk=blades | mistuned, reduction=few)).arrays
        for mistuned in ({}, {"mistuning": {"stiffness": [1.0 + 1e-6] + [1.0] * 7}})
    )
    assert np.any(alike.rotor_backward_frequency > 1.1 * alike.rotor_forward_frequency)
    own = np.flatnonzero(unlike.rotor_nodal_diameter == 1)[:6]
    for way in WAYS:
        expected_values, actual = (
            getattr(each, f"rotor_{way}_frequency")[own] for each in (alike, unlike)
        )
        np.testing.assert_allclose(actual, expected_values, rtol=1e-5)
