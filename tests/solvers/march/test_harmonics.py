"""Contact nodes of a wheel by harmonic, compared with dense matrices; equal and unequal blades."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_cases import assert_same
from symmetric_cases import write_parts

import bladewhirl as bw
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.packing.rotor import blade_columns
from bladewhirl.studies.runs.prepare import prepare

STEP = 5e-7


@pytest.fixture(scope="module")
def sector(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("parts")
    write_parts(folder)
    return folder / "sector.npz"


def wheel(sector: Path, sliding: str, effects: str, ring: bool) -> ContactProblem:
    """Twelve sectors, to which an oval wall comes."""
    casing: dict[str, Any] = {
        "type": "rigid",
        "clearance": 1e-4,
        "clearance_lobes": [{"lobes": 2, "amplitude": 8e-5}],
        "closure": {"amount": 6e-5, "time_constant": 2e-4},
    }
    if ring:
        section = {"width": 0.05, "thickness": 0.006}
        casing |= {"type": "ring", "elements": 48, "support": 2e7, "wall": section}
    case = {
        "bladed_disk": {"superelement": {"file": str(sector), "kind": "sector", "copies": 12}},
        "reduction": {"free_interface_modes": 4},
        "rotation": {"effects": effects},
        "casing": casing,
        "contact": {"friction": 0.1, "sliding": sliding},
        "damping": {"ratio": 0.01},
        "march": {"speed": "600 rad/s", "time_step": STEP, "duration": 1e-3, "record_step": 1e-5},
    }
    return prepare(bw.case_from(case)).problem


@pytest.mark.parametrize(
    ("sliding", "effects", "ring"),
    [
        pytest.param("permanent", "centrifugal", False, marks=pytest.mark.slow),
        ("permanent", "full", True),
        ("full", "centrifugal", True),
        ("full", "full", False),
    ],
)
def test_a_wheel_by_harmonic_moves_as_with_dense_matrices(
    sector: Path, sliding: str, effects: str, ring: bool
) -> None:
    given = wheel(sector, sliding, effects, ring)
    fast, dense = (CentralDifference(given, STEP, 20, cyclic=cyclic) for cyclic in (True, False))
    assert (fast.cyclic[0], dense.cyclic[0]) == (True, False)
    _, chunk, _ = fast.advance(fast.init(), 2001)
    _, expected, _ = dense.advance(dense.init(), 2001)
    assert expected.contact_impulse.any(axis=0).sum() > 3
    assert_same(chunk, expected, 1e-8)


def test_blades_of_different_motion_or_at_other_angles_have_no_columns(sector: Path) -> None:
    rotor = wheel(sector, "permanent", "centrifugal", ring=False).rotor
    found = blade_columns(rotor)
    assert found is not None
    blades, column = found
    assert blades == 12
    assert np.bincount(column, minlength=12).min() > 0
    softer = rotor.contact.copy()
    softer[0] *= 1.01
    assert blade_columns(replace(rotor, contact=softer)) is None
    moved = rotor.tip_angle.copy()
    moved[0] += 1e-3
    assert blade_columns(replace(rotor, tip_angle=moved)) is None
