"""The bladed disk against independent frame programs."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from stages import bladed_disk, oracle, translation

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel

SPRING = 3.4e7
CLAMPING = pytest.mark.parametrize("clamped", [False, True], ids=["free", "clamped"])


def static(disk: BladedDiskModel, dof: int) -> FloatArray:
    """Displacement of every node along x, y and its rotation under a unit force, (nodes, 3)."""
    force = np.zeros((disk.structure.size, 1))
    force[dof] = 1.0
    return disk.cartesian(spla.splu(disk.structure.stiffness.tocsc()).solve(force))[..., 0]


@CLAMPING
def test_static_stiffnesses_of_the_literature_stage(clamped: bool) -> None:
    expected = oracle("disk_static")["clamped" if clamped else "free"]
    disk = bladed_disk(clamped=clamped)
    tips, roots = disk.mesh.node_sets["tips"], disk.mesh.node_sets["roots"]
    x, y, rotation = range(3)

    field = static(disk, int(disk.tip_tangential[0]))
    found = {
        "tip0_tangential_stiffness": 1.0 / field[tips[0], y],
        "tip0_rotation_per_tangential_force": field[tips[0], rotation],
        "tip11_y_per_tangential_force": field[tips[11], y],
        "tip0_radial_stiffness": 1.0 / static(disk, int(disk.tip_radial[0]))[tips[0], x],
        "root0_tangential_stiffness": 1.0
        / static(disk, int(disk.structure.node_dofs[roots[0], 1]))[roots[0], y],
    }
    for name, value in found.items():
        assert value == pytest.approx(expected[name], rel=1e-8), name
    np.testing.assert_allclose(
        field[tips[1], [x, y]], expected["tip1_xy_per_tangential_force"], rtol=1e-8
    )
    if not clamped:
        centre = static(disk, int(disk.centre[0]))[disk.mesh.node_sets["centre"][0]]
        assert 1.0 / centre[x] == pytest.approx(expected["centre_x_stiffness"], rel=1e-8)


@pytest.mark.parametrize("case", oracle("disk_harmonic")["response"], ids=lambda c: c["f_hz"])
def test_harmonic_response_to_an_unbalance(case: dict[str, float]) -> None:
    """Mass and stiffness together, across two resonances."""
    disk = bladed_disk()
    square = (2.0 * np.pi * case["f_hz"]) ** 2
    force = np.zeros((disk.structure.size, 1))
    force[disk.centre[0]] = oracle("disk_harmonic")["unbalance"] * square
    dynamic = disk.structure.stiffness - square * disk.structure.mass
    field = disk.cartesian(spla.splu(dynamic.tocsc()).solve(force))[..., 0]
    tips, centre = disk.mesh.node_sets["tips"], disk.mesh.node_sets["centre"][0]
    found = [field[centre, 0], field[tips[0], 0], field[tips[5], 0], field[tips[5], 1]]
    names = ("centre_x", "tip0_x", "tip5_x", "tip5_y")
    np.testing.assert_allclose(found, [case[name] for name in names], rtol=1e-7)


@pytest.mark.parametrize("angle", [0.0, 1.0, np.pi / 2.0])
def test_a_rigid_translation_moves_all_mass_and_strains_only_the_springs(angle: float) -> None:
    disk = bladed_disk()
    field = translation(disk, np.cos(angle), np.sin(angle))
    weight = oracle("disk_modes")["stage"]["mass"]
    assert disk.model.mass == pytest.approx(weight, rel=1e-12)
    assert field @ (disk.structure.mass @ field) == pytest.approx(weight, rel=1e-12)
    assert field @ (disk.structure.springs @ field) == pytest.approx(SPRING, rel=1e-12)
    assert field @ (disk.structure.stiffness @ field) == pytest.approx(SPRING, rel=1e-6)


def test_tips_and_centre() -> None:
    disk = bladed_disk(blades=5, elements=2)
    np.testing.assert_allclose(disk.tip_angles, 2.0 * np.pi * np.arange(5) / 5, atol=1e-15)
    assert len(disk.centre) == 2
    assert bladed_disk(blades=5, elements=2, clamped=True).centre.size == 0
    # A radial and a tangential displacement of tip 1 come out along and across its blade.
    for dofs, turn in ((disk.tip_radial, 0.0), (disk.tip_tangential, np.pi / 2.0)):
        unit = np.zeros((disk.structure.size, 1))
        unit[dofs[1]] = 1.0
        moved = disk.cartesian(unit)[disk.mesh.node_sets["tips"][1], :2, 0]
        assert moved @ [1.0, 1.0j] == pytest.approx(np.exp(1j * (2.0 * np.pi / 5 + turn)))
