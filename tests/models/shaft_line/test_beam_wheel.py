"""Wheels of beams on a shaft line: in the plane as the stage of beams, in tilt as a rigid disk."""

from typing import Any

import numpy as np
import pytest

from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.elements.build import case_beam_model, case_bladed_disk
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.shaft_line.axial import axial_modes
from bladewhirl.models.shaft_line.beam_wheel import beam_wheel, rigid_mass
from bladewhirl.models.shaft_line.line import line_model
from bladewhirl.models.shaft_line.whirl import line_modes
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.superelements.hub import check_hub, rigid_motions

DISK: dict[str, Any] = {"blades": 8, "disk_radius": 0.1}
SPRING = 3.4e7
SHORT: dict[str, Any] = {"length": 0.01, "outer_diameter": 0.5, "elements": 1, "material": "light"}
LIGHT = {"name": "light", "young_modulus": 1e13, "density": 1e-6}
ON_SPRING: dict[str, Any] = {
    "segments": [SHORT],
    "bearings": [
        {"position": 0.0, "stiffness": SPRING / 2.0, "tilt_stiffness": 1e13},
        {"position": 0.01, "stiffness": SPRING / 2.0},
    ],
    "wheel": {"position": 0.005, "unknowns": "two"},
}
SHAFT: dict[str, Any] = {
    "segments": [{"length": 0.6, "outer_diameter": 0.08, "elements": 6}],
    "bearings": [{"position": z, "stiffness": 2e7, "damping": 2e3} for z in (0.0, 0.4)],
}


def on_line(disk: dict[str, Any], line: dict[str, Any], **material: Any) -> Case:
    return case_from(
        {"bladed_disk": disk, "shaft_line": line, "material": {"named": [LIGHT]} | material}
    )


@pytest.mark.parametrize("omega", [0.0, 300.0, -900.0])
def test_a_wheel_that_does_not_tilt_whirls_as_the_stage_of_beams(omega: float) -> None:
    line = line_model(on_line(DISK, ON_SPRING), abs(omega))
    found = line_modes(line, omega, 8).eigenvalue.imag
    alone = case_from({"bladed_disk": DISK, "shaft": {"stiffness": SPRING}})
    disk = rotation_matrices(case_bladed_disk(alone, clamped=False)).at(omega, "full")
    rotating = disk.wave(1).under("full").frequencies(omega).real
    np.testing.assert_allclose(found, np.sort(np.abs(rotating - omega))[:8], rtol=2e-7)


@pytest.mark.parametrize(
    "disk",
    [
        DISK,
        {"blades": 5, "taper": [{"width": 0.1}, {"width": 0.04}], "tip_mass": 0.3},
        {"blades": 6, "disk_kind": "rigid", "point_masses": [{"radius": 0.3, "mass": 0.1}]},
        {"blades": 7, "centre_line": [{"span": 1.0, "angle": "10 deg"}]},
    ],
    ids=["straight", "tapered", "rigid disk", "curved"],
)
def test_beams_are_a_rigid_body_on_motions_with_their_hub(disk: dict[str, Any]) -> None:
    case = case_from({"bladed_disk": disk})
    part, model = beam_wheel(case).part, case_beam_model(case)
    motions = rigid_motions(part)
    check_hub(part, motions)
    mass = motions.T @ (part.mass @ motions)
    np.testing.assert_allclose(mass, rigid_mass(model), rtol=0, atol=1e-9 * mass.max())
    assert mass[0, 0] == pytest.approx(model.mass, rel=1e-12)


def test_straight_blades_have_the_inertia_of_bars() -> None:
    """I_p = m L^2 / 3 and I_t = I_p / 2 + m w^2 / 12 of bars from the centre."""
    disk = {"blades": 6, "disk_kind": "spokes", "disk": {"width": 0.1, "thickness": 0.01}}
    case = case_from({"bladed_disk": disk})
    radius, width = case.tip_radius, 0.1
    mass = 6.0 * 7800.0 * width * 0.01 * radius
    rigid = rigid_mass(case_beam_model(case))
    polar = mass * radius**2 / 3.0
    assert rigid[5, 5] == pytest.approx(polar, rel=1e-9)
    assert rigid[3, 3] == pytest.approx(polar / 2.0 + mass * width**2 / 12.0, rel=1e-9)


@pytest.mark.parametrize("omega", [0.0, 800.0])
def test_stiff_beams_are_a_rigid_disk(omega: float) -> None:
    stiff = {"width": 0.1, "thickness": 0.01, "material": "stiff"}
    disk = DISK | {"blade": stiff, "disk": stiff}
    named = [LIGHT, {"name": "stiff", "young_modulus": 2.1e18, "density": 7800.0}]
    case = on_line(disk, SHAFT | {"wheel": {"position": 0.6}}, named=named)
    beams = line_model(case, omega)
    [wheel] = beams.wheels
    inertias = {
        "mass": wheel.mass,
        "polar_inertia": wheel.polar_inertia,
        "diametral_inertia": wheel.diametral_inertia,
    }
    rigid = line_model(case_from({"shaft_line": SHAFT | {"disks": [{"position": 0.6} | inertias]}}))
    mine, known = (line_modes(line, omega, 8) for line in (beams, rigid))
    np.testing.assert_allclose(mine.eigenvalue, known.eigenvalue, rtol=1e-6)
    assert mine.direction == known.direction
    torsion = axial_modes(beams, omega)
    shear, polar = 2.1e11 / 2.6, np.pi / 32.0 * 0.08**4
    square = shear * polar / 0.6 / (wheel.polar_inertia + 7800.0 * polar * 0.6 / 3.0)
    lowest = torsion.eigenvalue.imag[torsion.direction.index("torsional")]
    assert lowest == pytest.approx(np.sqrt(square), rel=1e-3)


@pytest.mark.parametrize(
    ("disk", "said"),
    [
        (DISK | {"mistuning": {"stiffness_spread": 0.01}}, "shaft_line.wheel.*equal blades"),
        (DISK | {"mistuning": {"mass": [1.01] + 7 * [1.0]}}, "shaft_line.wheel.*equal blades"),
        (
            DISK | {"disk_kind": "rim", "point_masses": [{"radius": 0, "mass": 5}]},
            "shaft_line.wheel.*springs between its nodes",
        ),
    ],
)
def test_blades_of_beams_that_differ_are_refused(disk: dict[str, Any], said: str) -> None:
    with pytest.raises(CaseError, match=said):
        line_model(on_line(disk, ON_SPRING))


def test_a_line_needs_the_table_of_its_wheel() -> None:
    with pytest.raises(CaseError, match=r"shaft_line.wheel.*not allowed without the wheel"):
        case_from({"shaft_line": SHAFT | {"wheel": {"position": 0.6}}})


def test_a_wheel_of_beams_is_not_marched() -> None:
    with pytest.raises(CaseError, match=r"shaft_line.wheel.*a wheel of solids in a march"):
        build_stage(on_line(DISK, SHAFT | {"wheel": {"position": 0.6}}))
