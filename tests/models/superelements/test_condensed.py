"""Wheels on shaft springs, condensed for a range of speeds."""

from pathlib import Path

import numpy as np
import pytest
from exported_stages import beams, exported

import bladewhirl as bw
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.matrices import Matrices


def both(case: bw.Case) -> tuple[Matrices, ...]:
    """The stage of a case, reduced from the file and from the condensed wheel."""
    return build_matrices(case), build_matrices(case, condensed_from=10)


@pytest.mark.parametrize("speed", ["60 rad/s", "120 rad/s", "250 rad/s"])
def test_a_condensed_wheel_has_its_modes_and_flexibilities(speed: str, tmp_path: Path) -> None:
    case = exported(beams(rotation={"effects": "full"}), "wheel", tmp_path)
    exact, found = both(bw.with_values(case, {"march.speed": speed}))
    assert found.part.size < exact.part.size
    assert found.reduced.frequency == pytest.approx(exact.reduced.frequency, rel=1e-8)
    # Four modes can split a pair, whose directions are then those of the computation.
    flexible = [
        (each.reduced.contact / each.reduced.frequency**2) @ each.reduced.contact.T
        + each.reduced.compliance
        for each in (found, exact)
    ]
    assert flexible[0] == pytest.approx(flexible[1], abs=1e-7 * np.abs(flexible[1]).max())


@pytest.mark.slow
def test_a_wheel_above_its_critical_speed_is_condensed_for_the_range_too(
    tmp_path: Path,
) -> None:
    case = exported(beams(rotation={"effects": "full"}), "wheel", tmp_path)
    found = bw.critical_speeds(case, stiffnesses=np.array([case.shaft.stiffness]), branches=1)
    critical = found.critical_speed.sel(direction="forward").item() * np.pi / 30.0
    highest = 2.0 ** np.floor(
        np.log2(critical)
    )  # the next power of two is above the critical speed
    speed = f"{0.5 * (highest + critical)} rad/s"
    exact, again = both(bw.with_values(case, {"march.speed": speed}))
    assert again.part.size < exact.part.size
    assert again.reduced.frequency == pytest.approx(exact.reduced.frequency, rel=1e-8)
