"""The casing against closed forms of rings."""

from typing import Literal

import numpy as np
import pytest
import scipy.linalg as la
from stages import RADIUS, casing, casing_modes, steel

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.elements.casing import TANGENTIAL
from bladewhirl.models.modal.modes import families
from bladewhirl.studies.verification.rings import lowest


def squares(elements: int) -> FloatArray:
    """Eigenvalues of the free ring as they come, [rad2/s2]."""
    free = casing(elements).structure
    return np.asarray(la.eigh(free.stiffness.toarray(), free.mass.toarray(), eigvals_only=True))


def test_rigid_motions_of_the_free_ring() -> None:
    """A rotation is a field of the elements, a translation only nearly one."""
    elastic = squares(40)[3]
    assert np.abs(squares(40)[0]) < 1e-8 * elastic
    modes = casing_modes(40)
    assert families(modes, "casing", modes.sectors)[:5] == ["rigid"] * 3 + ["1F"] * 2
    np.testing.assert_array_equal(modes.nodal_diameter[:5], [0, 1, 1, 2, 2])
    assert modes.frequency[0] < 0.01
    np.testing.assert_allclose(modes.frequency[1:3], 0.166, atol=5e-4)
    # The rotation turns every node alike and lifts none.
    w, slope, u, strain = casing(40).nodal(modes.shapes[:, :1])[..., 0].T
    np.testing.assert_allclose(u, u[0], rtol=1e-6)
    np.testing.assert_allclose([w, slope, strain], 0.0, atol=1e-6 * abs(u[0]))


def test_on_a_stiff_support_only_rigid_motions_are_called_rigid() -> None:
    """The support holds more than half of the energy of the breathing motion too."""
    modes = casing_modes(40, 1e9)
    labels = families(modes, "casing", modes.sectors)
    rigid = [i for i, label in enumerate(labels) if label == "rigid"]
    assert [int(modes.nodal_diameter[i]) for i in rigid] == [0, 1, 1]
    breathing = np.flatnonzero(modes.nodal_diameter == 0)[1]
    assert labels[breathing] == "1F"
    assert 0.5 < modes.spring_share[breathing] < 0.6


@pytest.mark.parametrize("curvature", ["exact", "shallow"])
@pytest.mark.parametrize("support", [0.0, 7.975e6])
def test_holding_the_rotation_takes_one_motion_away(
    curvature: Literal["exact", "shallow"], support: float
) -> None:
    free = casing_modes(40, support, curvature, "free")
    held = casing_modes(40, support, curvature, "fixed")
    assert held.count == free.count - 1
    assert np.count_nonzero(held.nodal_diameter == 0) == 3
    rotation = np.flatnonzero(free.nodal_diameter == 0)[0]
    np.testing.assert_allclose(
        held.frequency, np.delete(free.frequency, rotation), rtol=1e-7, atol=1e-6
    )
    structure = casing(40, support, curvature, "fixed").structure
    turn = np.zeros(structure.size)
    turn[structure.node_dofs[:, TANGENTIAL]] = 1.0
    np.testing.assert_allclose(turn @ structure.mass @ held.shapes, 0.0, atol=1e-10)


def shallow_hertz(k: int) -> float:
    """Closed form for w = a cos(k theta), u = b sin(k theta) with change of curvature w''."""
    section = steel(0.01)
    stretch = section.axial_stiffness / RADIUS**2
    bend = section.bending_stiffness / RADIUS**4
    stiffness = np.array([[stretch + bend * k**4, stretch * k], [stretch * k, stretch * k**2]])
    lower = np.linalg.eigvalsh(stiffness / section.line_mass)[0]
    return float(np.sqrt(max(lower, 0.0)) / (2.0 * np.pi))


def test_shallow_ring() -> None:
    """Its translations are elastic: they bend it by w''."""
    modes = casing_modes(80, 0.0, "shallow", "fixed")
    for k in range(1, 8):
        assert lowest(modes, k) == pytest.approx(shallow_hertz(k), rel=1e-4)
    assert families(modes, "casing", modes.sectors)[:2] == ["1F", "1F"]


def test_nodal_values_of_a_wave() -> None:
    """w = cos 2 theta has dw/ds = -2 sin 2 theta / R, and u the amplitude of a bent ring."""
    modes = casing_modes(80)
    wave = np.flatnonzero(modes.nodal_diameter == 2)[0]
    angle = RingMesh(elements=80, radius=RADIUS).angles
    w, slope, u, strain = casing(80).nodal(modes.shapes[:, [wave]])[..., 0].T
    assert w[0] > 0.0
    np.testing.assert_allclose(w, w[0] * np.cos(2.0 * angle), atol=1e-9 * w[0])
    scale = w[0] / RADIUS
    np.testing.assert_allclose(slope, -2.0 * scale * np.sin(2.0 * angle), atol=1e-4 * scale)
    # Nearly inextensible: u' = -w / R, so u = -w[0] / 2 sin 2 theta.
    np.testing.assert_allclose(u, -0.5 * w[0] * np.sin(2.0 * angle), atol=1e-3 * w[0])
    np.testing.assert_allclose(strain, -scale * np.cos(2.0 * angle), atol=2e-3 * scale)
