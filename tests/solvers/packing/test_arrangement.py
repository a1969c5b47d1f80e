"""Places of modes in what the kernel works on, and the arrays made for it."""

import numpy as np
import pytest
from contact_cases import random_problem, stage_problem

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.solvers.packing.arrangement import (
    CACHE_LINE,
    Arrangement,
    aligned,
    dense_arrangement,
)
from bladewhirl.solvers.packing.casing import pack_casing
from bladewhirl.solvers.packing.rotor import pack_rotor
from bladewhirl.solvers.packing.supports import pack_dampers, pack_springs


def arrangements(blades: int, elements: int, *, cyclic: bool) -> list[Arrangement]:
    given = stage_problem(blades, elements)
    return [pack(given, 1e-7, cyclic=cyclic)[0] for pack in (pack_rotor, pack_casing)]


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


def test_without_harmonics_each_mode_has_a_column() -> None:
    arrangement = dense_arrangement(20)
    assert arrangement.rows == 1
    np.testing.assert_array_equal(arrangement.entry, np.arange(20))
    assert arrangement.half == 0


@pytest.mark.parametrize("shape", [7, (3, 5), (0, 8)])
def test_arrays_start_on_a_cache_line(shape: int | tuple[int, ...]) -> None:
    found: FloatArray = aligned(shape)
    assert found.ctypes.data % CACHE_LINE == 0 or found.size == 0
    assert not found.any()


@pytest.mark.parametrize("cyclic", [True, False])
def test_sums_by_column_and_shapes_give_the_tips_motion(cyclic: bool) -> None:
    """Radial and tangential displacement of each tip, in the kernel's two stages."""
    given = stage_problem(5, 8)
    arrangement, arrays = pack_rotor(given, 1e-7, cyclic=cyclic)
    modal = np.random.default_rng(1).normal(size=len(given.rotor.frequency))
    x = arrangement.grid(modal)
    used, tips = len(arrays.shape), len(given.rotor.tip_angle)
    radial, tangential, crossed = (
        ((weight * x).sum(axis=0)[:used] @ shape)[:tips]
        for weight, shape in (
            (arrays.radial, arrays.shape),
            (arrays.tangential, arrays.shape),
            (arrays.crossed, arrays.cross_shape),
        )
    )
    np.testing.assert_allclose(radial, given.rotor.tip_radial @ modal, atol=1e-12)
    np.testing.assert_allclose(tangential + crossed, given.rotor.tip_tangential @ modal, atol=1e-12)


def test_what_a_stage_has_none_of_is_none() -> None:
    given = random_problem(1)
    rotor, casing = (pack(given, 1e-4, cyclic=False) for pack in (pack_rotor, pack_casing))
    places, bodies = (rotor[0], casing[0]), (rotor[1].body, casing[1].body)
    assert pack_dampers(given, bodies, places, 1e-4) is None
    assert pack_springs(given, places, 1e-4) is None
