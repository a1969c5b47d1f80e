"""Cyclic symmetry: the real DFT, one-sector blocks, nodal diameters, travelling waves."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stages import bladed_disk, casing, disk_modes

from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.cyclic import (
    SectorLayout,
    evenly_spaced,
    is_pair,
    nodal_diameters,
    wave_parts,
    wave_shares,
)
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.modal.labels import structure_modes
from bladewhirl.models.structure.dft import nodal_diameter_of, real_dft


@cache
def structures() -> dict[str, Structure]:
    """Cyclic structures, by name."""
    actual = {
        "22": bladed_disk(blades=22, elements=2).structure,
        "5": bladed_disk(blades=5, elements=3).structure,
        "4, clamped": bladed_disk(blades=4, elements=2, clamped=True).structure,
    }
    return actual | {f"casing of {n}": casing(n, 1e5).structure for n in (3, 4, 21)}


STRUCTURES = pytest.mark.parametrize("structure", structures().values(), ids=structures())


def layout_of(structure: Structure) -> SectorLayout:
    assert structure.layout is not None
    return structure.layout


@given(sectors=st.integers(3, 60))
def test_columns_of_the_dft_hold_one_nodal_diameter(sectors: int) -> None:
    basis = real_dft(sectors)
    alpha = 2.0 * np.pi / sectors
    held = [nodal_diameter_of(column) for column in range(sectors)]
    for column, k in enumerate(held):
        spectrum = np.abs(np.fft.fft(basis[:, column]))
        np.testing.assert_allclose(spectrum[np.arange(sectors) % sectors == k], spectrum.max())
        wave = np.cos(k * alpha * np.arange(sectors))
        if is_pair(k, sectors) and column == 2 * k:
            wave = np.sin(k * alpha * np.arange(sectors))
        np.testing.assert_allclose(basis[:, column], wave / np.linalg.norm(wave), atol=1e-13)
    # Every double harmonic up to floor((N - 1) / 2), for odd N too.
    assert max(k for k in held if is_pair(k, sectors)) == (sectors - 1) // 2
    assert sorted(set(held)) == list(nodal_diameters(sectors))


@pytest.mark.parametrize("sectors", [3, 5, 8, 22])
@pytest.mark.parametrize("first", [0, 1])
def test_the_centre_moves_in_one_nodal_diameter(sectors: int, first: int) -> None:
    """x_n = a (cos n alpha, -sin n alpha), Eqs (11)-(13) with the right constant.

    Counting sectors from n = 0 gives a sqrt(N/2) (1, 0) and a sqrt(N/2) (0, -1); from n = 1 both
    are turned by alpha.
    """
    alpha, amplitude = 2.0 * np.pi / sectors, 0.7
    angle = alpha * (first + np.arange(sectors))
    seen = amplitude * np.column_stack([np.cos(angle), -np.sin(angle)])
    actual = real_dft(sectors).T @ seen
    turn = first * alpha
    size = amplitude * np.sqrt(sectors / 2.0)
    np.testing.assert_allclose(
        actual[1], size * np.array([np.cos(turn), -np.sin(turn)]), atol=1e-13
    )
    np.testing.assert_allclose(
        actual[2], size * np.array([-np.sin(turn), -np.cos(turn)]), atol=1e-13
    )
    np.testing.assert_allclose(np.delete(actual, [1, 2], axis=0), 0.0, atol=1e-13)


@given(count=st.integers(1, 40), first=st.floats(0.0, 6.0))
def test_parts_of_waves_are_their_factors(count: int, first: float) -> None:
    """Of a field a_k cos k theta + b_k sin k theta, wherever the equal angles begin."""
    k = np.array(nodal_diameters(count))
    theta = first + 2.0 * np.pi * np.arange(count) / count
    turn = np.where([is_pair(j, count) for j in k], 1.0 + k**2, k * first)
    a, b = np.cos(3.0 + k) * [np.cos(turn), np.sin(turn)]
    phase = np.multiply.outer(theta, k)
    field = np.cos(phase) * a + np.sin(phase) * b
    whole = wave_parts(field.sum(axis=1, keepdims=True), theta, k)
    np.testing.assert_allclose(whole[:, :, 0], np.column_stack([a, b]), atol=1e-12)
    each = wave_parts(field, theta, k)
    np.testing.assert_allclose(each[:, 0], np.diag(a), atol=1e-12)
    np.testing.assert_allclose(each[:, 1], np.diag(b), atol=1e-12)


def of_all_parts() -> SectorLayout:
    """Five sectors of two, and a centre that may rotate, before them."""
    return SectorLayout(sector_dofs=np.arange(3, 13).reshape(5, 2), centre_dofs=np.arange(3))


@pytest.mark.parametrize(
    "layout",
    [*(layout_of(each) for each in structures().values()), of_all_parts()],
    ids=[*structures(), "all parts"],
)
def test_bases_of_the_nodal_diameters_are_complete_and_turn_into_themselves(
    layout: SectorLayout,
) -> None:
    bases = {k: layout.basis(k).toarray() for k in nodal_diameters(layout.sectors)}
    pairs = [basis.conj() for k, basis in bases.items() if is_pair(k, layout.sectors)]
    whole = np.hstack([*bases.values(), *pairs])
    assert whole.shape == (layout.size, layout.size)
    np.testing.assert_allclose(whole.conj().T @ whole, np.eye(layout.size), atol=1e-12)
    turn, alpha = layout.turn(), 2.0 * np.pi / layout.sectors
    for k, basis in bases.items():
        np.testing.assert_allclose(turn @ basis, np.exp(-1j * k * alpha) * basis, atol=1e-12)


@pytest.mark.parametrize("count", [1, 5, 22])
def test_angles_are_even_from_any_start_in_order(count: int) -> None:
    angles = np.mod(2.0 * np.pi * np.arange(count) / count + 6.1, 2.0 * np.pi)
    assert evenly_spaced(angles)
    if count > 1:
        assert not evenly_spaced(angles[::-1])
        assert not evenly_spaced(angles + np.array([1e-6, *np.zeros(count - 1)]))


@STRUCTURES
def test_modes_found_by_sectors_are_modes(structure: Structure) -> None:
    modes = structure_modes(structure, (0, 1))
    assert modes.is_cyclic
    assert modes.count == structure.size
    mass = modes.shapes.T @ (structure.mass @ modes.shapes)
    np.testing.assert_allclose(mass, np.eye(modes.count), atol=1e-10)
    stiffness = modes.shapes.T @ (structure.stiffness @ modes.shapes)
    top = modes.frequency[-1] ** 2
    np.testing.assert_allclose(stiffness, np.diag(modes.frequency**2), atol=1e-10 * top)
    np.testing.assert_allclose(modes.purity, 1.0, atol=1e-10)


def slightly_mistuned(disk: BladedDiskModel) -> Structure:
    """The disk with a tip heavier by a part in 1e7 of all its entries."""
    nudge = disk.structure.mass.copy().tolil()
    for dof in (disk.tip_radial[0], disk.tip_tangential[0]):
        nudge[dof, dof] *= 1.0 + 1e-7
    return replace(disk.structure, mass=nudge.tocsr())


def test_symmetry_is_found_not_assumed() -> None:
    disk = bladed_disk(elements=4)
    assert disk.structure.is_cyclic
    assert not slightly_mistuned(disk).is_cyclic
    # Springs of unequal stiffness break it too, and a matrix the sectors do not share.
    uneven = disk.structure.springs.copy().tolil()
    uneven[disk.centre[0], disk.centre[0]] *= 1.001
    assert not replace(disk.structure, springs=uneven.tocsr()).is_cyclic


@pytest.mark.parametrize(("blades", "elements"), [(2000, 1), (3, 3000)])
@pytest.mark.slow
def test_rounding_of_many_points_breaks_no_symmetry(blades: int, elements: int) -> None:
    """Lines are short beside the radius, whose last digit turns and stretches them."""
    disk = bladed_disk(blades=blades, elements=elements)
    assert disk.structure.is_cyclic
    assert not slightly_mistuned(disk).is_cyclic


@pytest.mark.parametrize("stiffness", [1e-2, 30.0])
def test_a_soft_spring_at_one_tip_breaks_symmetry(stiffness: float) -> None:
    """Beside beams whose entries reach 1e10 N/m."""
    disk = bladed_disk(elements=4)
    held = disk.structure.stiffness.copy().tolil()
    held[disk.tip_tangential[0], disk.tip_tangential[0]] += stiffness
    assert not replace(disk.structure, stiffness=held.tocsr()).is_cyclic


def test_shares_of_a_field_of_several_waves() -> None:
    layout = SectorLayout(sector_dofs=np.arange(7)[:, None], centre_dofs=np.full(3, -1))
    angle = 2.0 * np.pi * np.arange(7) / 7
    field = 1.0 + 3.0 * np.cos(2.0 * angle + 0.4) + np.sin(3.0 * angle)
    shares = wave_shares(field[:, None], np.ones(7), layout)[:, 0]
    np.testing.assert_allclose(shares, [1 / 6, 0.0, 3 / 4, 1 / 12], atol=1e-15)


def test_centre_counts_as_one_nodal_diameter_and_its_rotation_as_none() -> None:
    layout = SectorLayout(
        sector_dofs=np.arange(10).reshape(5, 2), centre_dofs=np.array([10, 11, 12])
    )
    shares = wave_shares(np.eye(13)[:, 10:], np.arange(1.0, 14.0), layout)
    np.testing.assert_allclose(shares, [[0, 0, 1], [1, 1, 0], [0, 0, 0]], atol=1e-15)


@pytest.mark.parametrize("k", [1, 2, 3])
def test_a_forward_wave_turns_with_the_rotation(k: int) -> None:
    """Re(p exp(i(k theta - omega t))): after omega t = k alpha it has moved on by one sector."""
    disk = bladed_disk(blades=7, elements=2)
    layout = layout_of(disk.structure)
    modes = disk_modes(disk)
    cosine = np.flatnonzero(modes.column == 2 * k - 1)[0]
    sine = np.flatnonzero(modes.column == 2 * k)[0]

    def forward(phase: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        wave = np.cos(phase) * modes.shapes[:, cosine] + np.sin(phase) * modes.shapes[:, sine]
        return np.asarray(wave)

    size = np.abs(modes.shapes[:, cosine]).max()
    turned = layout.turn() @ forward(0.0)
    np.testing.assert_allclose(forward(2.0 * np.pi * k / 7), turned, atol=1e-9 * size)
    assert np.abs(forward(-2.0 * np.pi * k / 7) - turned).max() > 0.1 * size


def test_phases_of_pairs_are_set_by_the_tip_of_blade_0() -> None:
    disk = bladed_disk(blades=8, elements=3)
    modes = disk_modes(disk)
    radial = modes.shapes[disk.tip_radial[0]]
    tangential = modes.shapes[disk.tip_tangential[0]]
    cosine = modes.column % 2 == 1
    sine = (modes.column % 2 == 0) & (modes.column > 0) & (modes.column < 7)
    pairs = cosine & (modes.column < 7)
    assert (radial[pairs] > 0.0).all()
    # The disk has a mirror through blade 0: cosines leave its tip on the blade's axis.
    scale = np.abs(modes.shapes).max(axis=0)
    np.testing.assert_allclose(radial[sine] / scale[sine], 0.0, atol=1e-9)
    np.testing.assert_allclose(tangential[pairs] / scale[pairs], 0.0, atol=1e-9)
