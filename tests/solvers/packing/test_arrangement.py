"""Places of modes in what the kernel works on, and the arrays made for it."""

import numpy as np
import pytest
from contact_cases import stage_problem

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.structure.dft import real_dft
from bladewhirl.solvers.kernel.structs import CACHE_LINE, aligned
from bladewhirl.solvers.packing.arrangement import Arrangement, Harmonics
from bladewhirl.solvers.packing.casing import pack_casing
from bladewhirl.solvers.packing.rotor import DIRECTIONS, blade_columns, pack_rotor


def arrangements(blades: int, elements: int, *, cyclic: bool) -> list[Arrangement]:
    given = stage_problem(blades, elements)
    rotor, _ = pack_rotor(given, 1e-7, blade_columns(given.rotor) if cyclic else None)
    casing, _ = pack_casing(given.casing, [], 1e-7, cyclic=cyclic, friction=0.1)
    return [rotor, casing]


@pytest.mark.parametrize("cyclic", [True, False])
@pytest.mark.parametrize(("blades", "elements"), [(22, 40), (5, 8), (21, 41)])
def test_what_is_packed_is_read_back(blades: int, elements: int, cyclic: bool) -> None:
    for arrangement in arrangements(blades, elements, cyclic=cyclic):
        modes = len(arrangement.entry)
        assert len(np.unique(arrangement.entry)) == modes
        values = np.random.default_rng(0).normal(size=(3, modes))
        packed = arrangement.pack(values)
        assert packed.shape == (3, arrangement.rows * arrangement.columns)
        np.testing.assert_array_equal(arrangement.unpack(packed), values)
        assert np.count_nonzero(packed) == values.size  # the rest is zero
        grid = arrangement.grid(values[0])
        np.testing.assert_array_equal(grid.ravel(), packed[0])


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize("fold", [True, False])
@pytest.mark.parametrize("points", [3, 8, 9, 14])
def test_columns_stand_by_parity_and_across_from_their_partners(
    points: int, fold: bool, alone: bool
) -> None:
    harmonics = Harmonics(points, fold=fold, unit=4, alone=alone)
    columns = np.arange(points)
    diameter = (columns + 1) // 2
    chosen = np.repeat(columns, 1 + columns % 3)  # up to three modes a column
    arrangement = harmonics.arrangement(harmonics.place[chosen])
    half = arrangement.half
    assert half % 4 == 0
    assert arrangement.parts == (2 if fold and points % 2 == 0 else 1)
    assert arrangement.columns == 2 * half
    assert arrangement.rows == 3
    np.testing.assert_array_equal(arrangement.entry % (2 * half), harmonics.place[chosen])
    parts = [set(arrangement.columns_of(part)) for part in range(arrangement.parts)]
    assert sum(map(len, parts)) == len(set.union(*parts)) <= 2 * half
    for part, own in enumerate(parts):
        mine = diameter % 2 == part if arrangement.parts == 2 else np.full(points, fill_value=True)
        assert set(harmonics.place[mine]) <= own
    paired = (0 < diameter) & (2 * diameter < points)
    cosines = columns[paired & (columns % 2 == 1)]
    assert np.all(harmonics.place[cosines] < half)
    np.testing.assert_array_equal(harmonics.place[cosines + 1], harmonics.place[cosines] + half)
    if alone:
        across = (harmonics.place[~paired] + half) % (2 * half)
        assert not set(across) & set(harmonics.place)
    np.testing.assert_allclose(harmonics.shape[:, harmonics.place], real_dft(points))
    assert np.linalg.norm(harmonics.shape) == pytest.approx(np.sqrt(points))  # the rest is zero


@pytest.mark.parametrize("shape", [7, (3, 5), (0, 8)])
def test_arrays_start_on_a_cache_line(shape: int | tuple[int, ...]) -> None:
    actual: list[FloatArray] = [aligned(shape) for _ in range(20)]
    assert all(each.ctypes.data % CACHE_LINE == 0 or each.size == 0 for each in actual)
    assert not np.any(actual)


@pytest.mark.parametrize("cyclic", [True, False])
def test_sums_by_column_and_shapes_give_the_tips_motion(cyclic: bool) -> None:
    """The components of the displacement of each tip, in the kernel's two stages."""
    given = stage_problem(5, 8)
    arrangement, arrays = pack_rotor(given, 1e-7, blade_columns(given.rotor) if cyclic else None)
    modal = np.random.default_rng(1).normal(size=len(given.rotor.frequency))
    x, tips = arrangement.grid(modal), len(given.rotor.tip_angle)
    expected = (given.rotor.contact @ modal).reshape(tips, DIRECTIONS).T
    if cyclic:
        sums = (arrays.own * x).sum(axis=1), (arrays.across * x).sum(axis=1)
        by_column = sums[0] + np.roll(sums[1], arrangement.half, axis=1)
        found = (by_column[:, : len(arrays.shape)] @ arrays.shape)[:, :tips]
    else:
        found = np.einsum("m,dmt->dt", modal, arrays.columns)
    np.testing.assert_allclose(found, expected, atol=1e-12)
