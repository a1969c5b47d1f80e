"""The bladed disk against independent frame programs."""

import numpy as np
import pytest
from stages import bladed_disk, oracle, translation

SPRING = 3.4e7


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
