"""Casings on springs and struts at angles: closed forms of rings, rods and beams."""

from typing import Literal

import numpy as np
import pytest
from places import EXAMPLES
from stages import CASING_REFERENCE, RADIUS, casing_modes, observed_order, ring, ring_moved, steel

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.file import read_case
from bladewhirl.models.elements.casing import ALONG, OUTWARD, ROTATION, spring, strut
from bladewhirl.models.modal.labels import structure_modes
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.studies.runs.properties import stage_properties

SECTION = steel(0.01)
EA, EI = SECTION.axial_stiffness, SECTION.bending_stiffness
MASS = SECTION.line_mass * 2.0 * np.pi * RADIUS


@pytest.mark.parametrize("shift", [0.0, 0.02, 0.1])
@pytest.mark.parametrize("n", [2, 3])
def test_soft_springs_split_pairs_by_rayleigh(n: int, shift: float) -> None:
    """Inextensible motion: modal mass of w = cos n theta is rho A pi R (1 + 1/n^2).

    2 n equal springs, n waves apart, all sit on crests of one mode of the pair and on nodes of
    the other, wherever the first one stands, in an element too.
    """
    stiffness = 200.0
    angles = shift + np.pi * np.arange(2 * n) / n
    held = ring(*(spring(angle, radial=stiffness, tangential=0.0) for angle in angles))
    free = casing_modes(40).frequency
    pair = free[[2 * n - 1, 2 * n]]
    modes = structure_modes(held.structure, CASING_REFERENCE, 12).frequency
    near = np.sort(modes[np.argsort(abs(modes - pair[0]))[:2]])
    modal_mass = SECTION.line_mass * np.pi * RADIUS * (1.0 + 1.0 / n**2)
    np.testing.assert_allclose(
        near**2 - pair[0] ** 2, [0.0, 2 * n * stiffness / modal_mass], rtol=2e-3, atol=0.02
    )


def test_soft_springs_carry_the_ring_as_a_rigid_body() -> None:
    """Three springs at 120 degrees: translations by 3 (k_r + k_t) / 2, rotation by 3 k_t R^2."""
    radial, tangential = 20.0, 5.0
    angles = 0.3 + 2.0 * np.pi * np.arange(3) / 3
    held = ring(*(spring(angle, radial=radial, tangential=tangential) for angle in angles))
    square = structure_modes(held.structure, CASING_REFERENCE, 3).frequency ** 2
    along = 1.5 * (radial + tangential) / MASS
    # With 40 elements the free ring's translations are at 0.166 rad/s.
    expected = sorted([3.0 * tangential / MASS, along + 0.166**2, along + 0.166**2])
    np.testing.assert_allclose(square, expected, rtol=2e-3)


@pytest.mark.parametrize("angle", [0.0, 0.05, 1.234, -2.0, 6.27])
@pytest.mark.parametrize("ends", ["pinned", "built-in"])
def test_a_strut_is_a_rod_or_a_beam(angle: float, ends: Literal["pinned", "built-in"]) -> None:
    """Energy of a ring moved as a whole: the strut's alone, of its end displacements."""
    length, inclination = 0.3, 0.4
    held = strut(angle, steel(0.02), length=length, inclination=inclination, ends=ends)
    casing, free = ring(held), ring()
    x, y, turn = 1.0e-3, -0.6e-3, 0.8e-3
    moved = ring_moved(casing, x, y, turn)
    extra = casing.structure.stiffness - free.structure.stiffness
    axis = np.array([np.cos(angle + inclination), np.sin(angle + inclination)])
    normal = np.array([-axis[1], axis[0]])
    foot = RADIUS * np.array([np.cos(angle), np.sin(angle)])
    end = np.array([x, y]) + turn * np.array([-foot[1], foot[0]])
    rod, bending = steel(0.02).axial_stiffness / length, steel(0.02).bending_stiffness
    energy = rod * (axis @ end) ** 2
    if ends == "built-in":
        across = normal @ end
        energy += 12 * bending / length**3 * across**2 + 12 * bending / length**2 * across * turn
        energy += 4 * bending / length * turn**2
    assert moved @ extra @ moved == pytest.approx(energy, rel=1e-4)
    np.testing.assert_allclose(held.reach, length * axis, rtol=1e-12)
    assert moved @ casing.structure.springs @ moved == pytest.approx(moved @ extra @ moved)


def test_masses() -> None:
    """A bar moved at one end has a third of its mass there, any way; its whole mass is weighed."""
    bar = strut(0.3, steel(0.02), length=0.3, inclination=0.4, ends="pinned")
    weight = 7800.0 * 0.3 * 0.02 * 0.1
    assert bar.weight == pytest.approx(weight)
    np.testing.assert_allclose(bar.mass[:2, :2], weight / 3 * np.eye(2), atol=1e-12)
    casing = ring(bar)
    moved = ring_moved(casing, 0.0, 1.0, 0.0)
    actual = moved @ casing.structure.mass @ moved
    assert actual == pytest.approx(MASS + weight / 3, rel=1e-5)
    assert casing.mass == pytest.approx(MASS + weight)


def test_a_built_in_strut_is_a_cantilever() -> None:
    """Under a force across it at its free end: L^3 / 3 EI, and the slope L^2 / 2 EI."""
    beam = strut(0.0, steel(0.02), length=0.3, inclination=0.0, ends="built-in")
    bending = steel(0.02).bending_stiffness
    moved = np.linalg.solve(beam.stiffness, np.eye(3)[ALONG])
    assert moved[OUTWARD] == 0.0
    assert moved[ALONG] == pytest.approx(0.3**3 / (3 * bending))
    assert moved[ROTATION] == pytest.approx(-(0.3**2) / (2 * bending))
    # One Hermite element: its lowest frequency is half a per cent above the cantilever's.
    square = np.linalg.eigvals(np.linalg.solve(beam.mass[1:, 1:], beam.stiffness[1:, 1:])).min()
    cantilever = 1.875104**2 * np.sqrt(bending / steel(0.02).line_mass) / 0.3**2
    assert np.sqrt(square) == pytest.approx(1.005 * cantilever, rel=1e-3)


def foot_errors(first: float, ends: Literal["pinned", "built-in"]) -> FloatArray:
    """Errors of eight frequencies with 40 and 80 elements on three struts, (2, 8)."""
    actual = []
    for elements in (40, 80, 240):
        struts = [
            strut(first + np.pi * a, steel(0.01), length=0.3, inclination=0.5, ends=ends)
            for a in (0.0, 0.6, 1.2)
        ]
        casing = ring(*struts, elements=elements)
        actual.append(structure_modes(casing.structure, CASING_REFERENCE, 8).frequency)
    return np.array(actual[:2]) / actual[2] - 1.0


@pytest.mark.parametrize(
    ("ends", "largest", "order"), [("pinned", 1e-3, 1.8), ("built-in", 1.2e-2, 0.9)]
)
def test_feet_inside_elements_converge(
    ends: Literal["pinned", "built-in"], largest: float, order: float
) -> None:
    """The force of a pinned foot costs little accuracy, the moment of a built-in foot 1 %."""
    errors = foot_errors(0.123, ends)
    assert errors[0].max() < largest
    assert observed_order(errors).min() > order


def test_supports_that_repeat_keep_the_cyclic_path() -> None:
    """As many as elements: the ring stays cyclic, and both ways give the same frequencies."""
    angles = 0.01 + 2.0 * np.pi * np.arange(20) / 20
    held = ring(*(spring(a, radial=1e6, tangential=1e5) for a in angles), elements=20)
    uneven = ring(*(spring(a, radial=1e6, tangential=1e5) for a in angles[:-1]), elements=20)
    assert held.structure.is_cyclic
    assert not uneven.structure.is_cyclic
    blocks = structure_modes(held.structure, CASING_REFERENCE).frequency
    matrices = held.structure.stiffness.toarray(), held.structure.mass.toarray()
    dense = np.sqrt(np.linalg.eigvals(np.linalg.solve(matrices[1], matrices[0])).real)
    np.testing.assert_allclose(blocks, np.sort(dense), rtol=1e-9)


def test_the_stage_knows_its_supports() -> None:
    """Struts of the example, in the arrays that pictures are drawn from."""
    case = read_case(EXAMPLES / "casing_on_struts.toml")
    stage = build_beams(case)
    arrays = stage.arrays
    assert list(arrays.support_kind) == ["spring"] * 2 + ["strut"] * 8
    struts = arrays.support_kind == "strut"
    radial = np.column_stack([np.cos(arrays.support_angle), np.sin(arrays.support_angle)])
    outward = np.sum(arrays.support_reach * radial, axis=1)
    np.testing.assert_allclose(np.linalg.norm(arrays.support_reach[struts], axis=1), 0.2)
    assert outward[struts].min() > 0.0
    np.testing.assert_array_equal(arrays.support_reach[~struts], 0.0)
    assert (arrays.support_radial_stiffness > 0.0).all()
    assert stage_properties(stage)["cyclic"] == {"bladed_disk": True, "casing": False}
    assert stage.casing_modes.frequency[0] > 0.0
    assert stage_properties(stage)["casing_mass"] > MASS
