"""Design curve of joints: peaks over the speed at values of a key, and the smallest of them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from joint_cases import tables
from scipy.optimize import brentq

import bladewhirl as bw
from bladewhirl.models.case.template import dumps_case
from bladewhirl.studies.joints.peaks import peak
from bladewhirl.studies.verification.joints import RATIO, SOFT, oscillator


def one_harmonic(limit: float) -> float:
    """Largest amplitude over frequency of a mass with a Jenkins damper by one harmonic, for a force
    of 1: at resonance it does the work of friction and damping."""
    stiff = 2.0 / SOFT

    def missing(x: float) -> float:
        slips = np.arccos(1.0 - 2.0 * limit / (stiff * x))
        added = stiff / np.pi * (slips - 0.5 * np.sin(2.0 * slips))
        rubbed = 4.0 * limit * (x - limit / stiff) / np.pi
        return float(rubbed + 2.0 * RATIO * np.sqrt(1.0 + added) * x**2 - x)

    return float(brentq(missing, 1.0001 * limit / stiff, 500.0))


@pytest.mark.parametrize(
    ("limit", "of_page"),
    [
        pytest.param(0.7854, 44.215, marks=pytest.mark.slow),
        pytest.param(1.2, 16.323, marks=pytest.mark.slow),
        (1.5, 15.210),
        pytest.param(3.0, 20.014, marks=pytest.mark.slow),
    ],
)
def test_peaks_with_a_jenkins_damper_are_those_of_its_closed_form(
    limit: float, of_page: float
) -> None:
    exact = one_harmonic(limit)
    assert exact == pytest.approx(of_page, rel=1e-4)
    speeds = np.linspace(0.98, 1.12, 8).tolist()
    found = peak(lambda speed: oscillator(speed, limit, SOFT, RATIO), speeds)
    assert found.place == "peak"
    assert found.amplitude == pytest.approx(exact, rel=8e-3)  # the motion has more harmonics


def case(folder: Path) -> bw.Case:
    own: Any = tables(folder, preload="30 N") | {
        "reduction": {"free_interface_modes": 8},
        "damping": {"ratio": 0.02},
    }
    own["excitation"]["amplitude"] = 2.0
    return bw.case_from(own)


SPEEDS = ("--speeds", "3600 rpm:4400 rpm:200 rpm")


def test_peaks_of_joints_that_stick_are_those_of_the_linear_limit(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(case(tmp_path)))
    over = ("--over", "joint.shroud.preload=100 N:200 N", "--points", "3")
    shown = answer("periodic", file, *over, *SPEEDS, "-o", tmp_path / "out", "--json")
    document = json.loads(shown.stdout)
    stuck, rows = document["linear_limits"]["stuck"], document["points"]
    assert [row["parameter"] for row in rows] == pytest.approx([100.0, 150.0, 200.0])
    for row in rows:
        assert row["amplitude"] == pytest.approx(stuck["amplitude"], rel=1e-4)
        assert row["speed_rpm"] == pytest.approx(stuck["speed_rpm"], rel=1e-3)
    assert document["smallest_peak"] in rows
    assert (tmp_path / "out" / "design.png").exists()


@pytest.mark.slow
def test_the_smallest_peak_is_below_those_of_the_linear_limits(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(case(tmp_path)))
    over = ("--over", "joint.shroud.preload=3 N:100 N", "--points", "3")
    document = json.loads(answer("periodic", file, *over, *SPEEDS, "--json").stdout)
    least, limits = document["smallest_peak"], document["linear_limits"]
    assert least["parameter"] < 100.0
    assert least["amplitude"] == min(row["amplitude"] for row in document["points"])
    assert least["amplitude"] < 0.8 * min(limit["amplitude"] for limit in limits.values())


def test_speeds_with_a_key_are_refused_without_joints(tmp_path: Path) -> None:
    own = tables(tmp_path)
    del own["joint"]
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(bw.case_from(own)))
    over = ("--over", "casing.clearance=1 mm:2 mm", "--speeds", "3000 rpm:4000 rpm:500 rpm")
    assert "[[joint]]" in refusal("periodic", file, *over)
