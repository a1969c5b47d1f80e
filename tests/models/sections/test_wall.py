"""Walls whose section varies along the ring: perturbation theory, limits, masses, convergence."""

import numpy as np
import pytest
from places import EXAMPLES
from stages import CASING_REFERENCE, RADIUS, casing_modes, observed_order, ring, steel

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import case_from
from bladewhirl.models.case.file import loads, read_case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.elements.build import case_casing
from bladewhirl.models.elements.casing import TANGENTIAL, CasingModel
from bladewhirl.models.modal.labels import structure_modes
from bladewhirl.models.sections.wall import Arc, Lobe, RingProfile, Wall
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.studies.runs.properties import stage_properties


def frequencies(casing: CasingModel, count: int = 12) -> FloatArray:
    """Lowest frequencies but for the rigid motions [rad/s]."""
    return structure_modes(casing.structure, CASING_REFERENCE, count + 3).frequency[3:]


def mass(casing: CasingModel) -> float:
    """Mass of the ring by its matrix [kg]: of a field that moves every point by one."""
    one = np.zeros(casing.structure.size)
    one[casing.structure.node_dofs[:, TANGENTIAL]] = 1.0
    return float(one @ casing.structure.mass @ one)


@pytest.mark.parametrize("k", [2, 3, 4])
def test_lobes_of_twice_the_nodal_diameter_split_its_pair(k: int) -> None:
    """First-order perturbation of the inextensible ring, w = cos k theta and k u = -sin k theta.

    With thickness t (1 + e cos 2 k theta) stiffness changes by 3 e / 2 of itself, up for the
    cosine and down for the sine, mass by e (k^2 - 1) / (2 (k^2 + 1)).
    """
    e = 1e-3
    profile = RingProfile(mean=0.01, lobes=(Lobe(lobes=2 * k, amplitude=e * 0.01, phase=0.0),))
    uniform = casing_modes(80)
    [low, high] = frequencies(ring(wall=Wall(section=steel(0.01), thickness=profile), elements=80))[
        2 * k - 4 : 2 * k - 2
    ]
    base = uniform.frequency[uniform.nodal_diameter == k][0]
    split = 0.5 * e * (1.5 - 0.5 * (k**2 - 1) / (k**2 + 1))
    assert high / base - 1.0 == pytest.approx(split, rel=0.01)
    assert low / base - 1.0 == pytest.approx(-split, rel=0.01)


def test_other_lobes_leave_pairs_together_to_first_order() -> None:
    profile = RingProfile(mean=0.01, lobes=(Lobe(lobes=3, amplitude=1e-5, phase=0.4),))
    actual = frequencies(ring(wall=Wall(section=steel(0.01), thickness=profile), elements=48), 4)
    np.testing.assert_allclose(actual[::2], actual[1::2], rtol=5e-6)


def test_an_arc_all_around_is_a_wall_of_its_section() -> None:
    thick = Arc(start=0.3, end=0.3 + 2.0 * np.pi, thickness=0.02, young_modulus=1e11, density=3e3)
    covered = ring(wall=Wall(section=steel(0.01), arcs=(thick,)))
    assert covered.structure.is_cyclic
    section = steel(0.02)
    bare = ring(wall=Wall(section=section))
    ratio = np.sqrt(1e11 / 2.1e11 * 7800.0 / 3e3)
    np.testing.assert_allclose(frequencies(covered), ratio * frequencies(bare), rtol=1e-9)


@pytest.mark.parametrize("start", [0.0, np.pi / 4, 0.123, 6.2, -0.5])
def test_masses_are_exact(start: float) -> None:
    """Wherever the arc begins, also across the x axis."""
    arc = Arc(start=start, end=start + 0.7, thickness=0.03, width=0.15)
    profile = RingProfile(mean=0.01, lobes=(Lobe(lobes=3, amplitude=2e-3, phase=1.0),))
    casing = ring(wall=Wall(section=steel(0.01), thickness=profile, arcs=(arc,)))
    angle = np.linspace(start + 0.7, start + 2.0 * np.pi, 200_001)
    plain = np.trapezoid(profile.value(angle) * 0.1, angle)
    exact = 7800.0 * RADIUS * (plain + 0.7 * 0.03 * 0.15)
    # The blend at an end takes the varying thickness at one point for the whole stretch.
    assert mass(casing) == pytest.approx(exact, rel=1e-5)
    length = casing.mesh.element_length
    assert casing.properties.line_mass.sum() * length == pytest.approx(mass(casing), rel=1e-12)
    plain_wall = ring(wall=Wall(section=steel(0.01), arcs=(arc,)))
    assert mass(plain_wall) == pytest.approx(
        7800.0 * RADIUS * ((2.0 * np.pi - 0.7) * 1e-3 + 0.7 * 0.0045), rel=1e-12
    )


def errors(wall: Wall, counts: tuple[int, ...]) -> FloatArray:
    """Errors of the lowest frequencies against a fine mesh, (meshes, modes)."""
    fine = frequencies(ring(wall=wall, elements=160))
    return np.array([frequencies(ring(wall=wall, elements=n)) / fine - 1.0 for n in counts])


def test_smooth_walls_and_arcs_that_end_at_nodes_converge_with_the_fourth_power() -> None:
    profile = RingProfile(mean=0.01, lobes=(Lobe(lobes=2, amplitude=3e-3, phase=0.5),))
    smooth = observed_order(errors(Wall(section=steel(0.01), thickness=profile), (20, 40)))
    assert smooth.min() > 3.7
    arc = Arc(start=np.pi / 4, end=3 * np.pi / 4, thickness=0.02)
    at_nodes = errors(Wall(section=steel(0.01), arcs=(arc,)), (20, 40))
    assert observed_order(at_nodes).min() > 3.7


def test_arcs_that_end_inside_elements_are_right_to_a_per_cent() -> None:
    arc = Arc(start=0.7, end=2.5, thickness=0.02)
    actual = np.abs(errors(Wall(section=steel(0.01), arcs=(arc,)), (20, 40)))
    assert actual[1].max() < 2e-2
    assert actual[1].max() < 0.7 * actual[0].max()


@pytest.mark.slow
def test_nothing_jumps_as_an_arc_grows() -> None:
    """Steps a fourth as long change the frequencies by about a fourth each; a jump would stay."""
    largest = []
    for steps in (8, 32):
        ends = np.linspace(0.40, 0.40 + 0.5 * np.pi / 40, steps + 1)  # a quarter of an element
        arcs = [Arc(start=0.1, end=end, thickness=0.02) for end in ends]
        actual = [frequencies(ring(wall=Wall(section=steel(0.01), arcs=(arc,))), 2) for arc in arcs]
        largest.append(np.abs(np.diff(actual, axis=0)).max())
    assert largest[1] < 0.5 * largest[0]


def test_stations_give_the_thickness_between_them() -> None:
    rows = [
        {"angle": f"{a} deg", "thickness": t} for a, t in ((300, 0.02), (60, 0.008), (90, 0.01))
    ]
    case = case_from({"casing": {"thickness_stations": rows}})
    profile = case.casing.thickness_profile
    angle = np.deg2rad([300.0, 0.0, 60.0, 75.0, 90.0, 195.0, 330.0, 690.0])
    expected = [0.02, 0.014, 0.008, 0.009, 0.01, 0.015, 0.017, 0.017]
    np.testing.assert_allclose(profile.value(angle), expected, rtol=1e-12)
    thickness = case_casing(case).properties.thickness
    assert thickness.min() == pytest.approx(0.008, rel=0.05)
    assert thickness.max() == pytest.approx(0.02, rel=0.05)
    assert loads(dumps_case(case)) == case


def test_a_fixed_rotation_stays_out_of_an_uneven_ring() -> None:
    """No mode turns the ring as a whole, weighed by its uneven mass; the others stay."""
    wall = Wall(section=steel(0.01), arcs=(Arc(start=0.0, end=1.0, thickness=0.03),))
    free = structure_modes(ring(wall=wall).structure, CASING_REFERENCE)
    held = ring(wall=wall, rotation="fixed")
    modes = structure_modes(held.structure, CASING_REFERENCE)
    assert modes.count == free.count - 1
    one = np.zeros(held.structure.size)
    one[held.structure.node_dofs[:, TANGENTIAL]] = 1.0
    np.testing.assert_allclose(one @ held.structure.mass @ modes.shapes, 0.0, atol=1e-9)
    np.testing.assert_allclose(modes.frequency[2:], free.frequency[3:], rtol=1e-8)


def test_the_stage_has_the_wall_of_its_case() -> None:
    """Dense where the ring is uneven; drawn and weighed with its true section."""
    case = read_case(EXAMPLES / "stiffened_casing.toml")
    stage = build_beams(case)
    assert not stage.casing_modes.is_cyclic
    assert stage.reduction.modes.is_cyclic
    assert stage_properties(stage)["cyclic"] == {"bladed_disk": True, "casing": False}
    assert stage_properties(stage)["casing_mass"] == pytest.approx(mass(stage.casing), rel=1e-12)
    thickness = stage.arrays.casing_thickness
    angle = np.rad2deg(stage.casing.mesh.angles + np.pi / 40)
    stiff = ((angle > 45) & (angle < 135)) | ((angle > 225) & (angle < 315))
    assert thickness[stiff] == pytest.approx(0.025)
    assert thickness[~stiff].max() < 0.0125
