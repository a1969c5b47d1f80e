"""Cyclic symmetry; frequencies of wheels are compared with CalculiX in the tests of solids."""

from dataclasses import replace

import numpy as np
import pytest
from solid_meshes import SECTORS, bladed_sector, wheel_frequencies

from bladewhirl.meshes.coincident import places_of
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.superelement import FIXED, Superelement, SuperelementError
from bladewhirl.models.superelements.wheel import WheelOverSpeeds, whole_wheel


@pytest.fixture(scope="module")
def free() -> Superelement:
    """Return a sector of a free wheel, of which every node has three displacements in order."""
    return mesh3d(
        bladed_sector("hexahedron"),
        young_modulus=2.1e11,
        poisson_ratio=0.3,
        density=7800.0,
        clamped=None,
        left="left",
        right="right",
        copies=SECTORS,
    )


def test_rigid_motions_have_their_nodal_diameters_and_no_stiffness(free: Superelement) -> None:
    """A translation (1, i, 0) of the whole wheel has nodal diameter +1, as
    exp(i alpha) R (1, i, 0) = (1, i, 0)."""
    assert free.right_dofs is not None
    x = bladed_sector("hexahedron").points
    nodes = len(x)
    rigid = {
        (1, "translation"): np.tile([1.0, 1j, 0.0], nodes),
        (-1, "translation"): np.tile([1.0, -1j, 0.0], nodes),
        (0, "translation"): np.tile([0.0, 0.0, 1.0], nodes),
        (0, "rotation"): np.cross([0.0, 0.0, 1.0], x).ravel(),
        (1, "rotation"): np.cross([1.0, 1j, 0.0], x).ravel(),
    }
    for (k, _), motion in rigid.items():
        for diameter in (-1, 0, 1, 2):
            tie = transformation(free, SECTORS, diameter)
            reduced = free.projected(tie, ("mass", "stiffness"))
            kept = np.setdiff1d(np.arange(free.size), free.right_dofs)
            tied = np.abs(tie @ motion[kept] - motion).max() < 1e-9
            assert tied == (diameter == k)
            if tied:
                force = reduced["stiffness"] @ motion[kept]
                assert np.abs(force).max() < 1e-9 * abs(reduced["stiffness"]).max()
                energy = (motion[kept].conj() @ reduced["mass"] @ motion[kept]).real
                assert energy == pytest.approx((motion.conj() @ free.mass @ motion).real)


def test_the_surface_of_a_wheel_is_closed_without_faces_between_sectors(
    free: Superelement,
) -> None:
    wheel = whole_wheel(free, SECTORS)
    assert wheel.points is not None
    assert wheel.triangles is not None
    assert free.triangles is not None
    place = places_of(wheel.points, 1e-9)[wheel.triangles]
    edges = np.sort(place[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}
    assert len(place) < SECTORS * len(free.triangles)


def test_matrices_are_hermitian_and_real_where_waves_stand(free: Superelement) -> None:
    for k in range(SECTORS // 2 + 1):
        tie = transformation(free, SECTORS, k)
        stiffness = tie.conj().T @ free.stiffness @ tie
        assert np.iscomplexobj(stiffness) == (0 < k < SECTORS // 2)
        difference = stiffness - stiffness.conj().T
        assert abs(difference).max() < 1e-12 * abs(stiffness).max()
    waves = wheel_frequencies(free, SECTORS, 5, [2, -2, 2 - SECTORS])
    assert waves[1:] == pytest.approx(waves[[0, 0]], rel=1e-9)


def test_what_is_not_a_sector_is_refused(free: Superelement) -> None:
    assert free.left_dofs is not None
    changed = free.left_dofs.copy()
    changed[0, 0] = FIXED
    for part, expected in (
        (replace(free, left_dofs=None, right_dofs=None), "expected a sector, with left_dofs"),
        (replace(free, left_dofs=free.right_dofs), "expected different nodes on both faces"),
        (replace(free, left_dofs=changed), "expected the same fixed components on both faces"),
    ):
        with pytest.raises(SuperelementError, match=expected):
            transformation(part, SECTORS, 1)


def test_a_free_sector_is_refused_in_one_line(free: Superelement) -> None:
    """Its rigid modes have frequencies of rounding errors, which must not be divided by."""
    with pytest.raises(SuperelementError, match=r"^expected a sector without rigid modes .*$"):
        WheelOverSpeeds(free, SECTORS, 10).at(0.0)
