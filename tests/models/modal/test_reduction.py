"""Craig-Bampton reduction: exact where it must be, and as good as it is known to be elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
from stages import bladed_disk, disk_modes, tip_in_sector

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.modal.reduction import ReducedModes, craig_bampton, craig_bampton_basis


def tips_and_centre(disk: BladedDiskModel) -> IntArray:
    return np.concatenate([disk.tip_radial, disk.tip_tangential, disk.centre])


def reduce(disk: BladedDiskModel, count: int, *, dense: bool = False) -> ReducedModes:
    structure = replace(disk.structure, layout=None) if dense else disk.structure
    return craig_bampton(structure, tips_and_centre(disk), count, tip_in_sector(disk))


def fixed_interface_frequencies(disk: BladedDiskModel) -> FloatArray:
    """All frequencies with tips and centre held [rad/s], by one dense eigenproblem."""
    inside = np.setdiff1d(np.arange(disk.structure.size), tips_and_centre(disk))
    stiffness, mass = disk.structure.stiffness.toarray(), disk.structure.mass.toarray()
    square = la.eigh(
        stiffness[np.ix_(inside, inside)], mass[np.ix_(inside, inside)], eigvals_only=True
    )
    return np.asarray(np.sqrt(square))


@pytest.mark.parametrize(("blades", "count"), [(22, 110), (22, 50), (5, 8), (3, 4)])
def test_sector_by_sector_is_the_same_as_all_at_once(blades: int, count: int) -> None:
    disk = bladed_disk(blades=blades, elements=6)
    by_sectors, dense = reduce(disk, count), reduce(disk, count, dense=True)
    assert by_sectors.kept == dense.kept
    np.testing.assert_allclose(by_sectors.modes.frequency, dense.modes.frequency, rtol=1e-9)
    # The modes span the same space: any load is answered alike.
    load = np.random.default_rng(1).normal(size=disk.structure.size)
    answers = [
        r.modes.shapes @ ((r.modes.shapes.T @ load) / (1e6 + r.modes.frequency**2))
        for r in (by_sectors, dense)
    ]
    np.testing.assert_allclose(answers[0], answers[1], atol=1e-9 * np.abs(answers[1]).max())


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize(
    ("blades", "asked", "kept"),
    [(22, 110, 110), (22, 50, 51), (22, 60, 61), (22, 100, 101), (24, 110, 111)],
)
def test_a_degenerate_pair_is_never_cut(blades: int, asked: int, kept: int, dense: bool) -> None:
    disk = bladed_disk(blades=blades, elements=6, disk_thickness=0.03)
    reduction = reduce(disk, asked, dense=dense)
    assert reduction.kept == kept
    assert reduction.modes.count == 2 * blades + 2 + kept
    frequencies = fixed_interface_frequencies(disk)
    apart = np.diff(frequencies) > 1e-7 * frequencies[1:]
    assert apart[kept - 1]
    assert not apart[asked - 1 : kept - 1].any()  # and no more than it takes


def test_reduced_modes_are_normal_in_the_full_matrices() -> None:
    disk = bladed_disk()
    modes = reduce(disk, 110).modes
    mass = modes.shapes.T @ (disk.structure.mass @ modes.shapes)
    np.testing.assert_allclose(mass, np.eye(modes.count), atol=1e-10)
    stiffness = modes.shapes.T @ (disk.structure.stiffness @ modes.shapes)
    square = modes.frequency**2
    np.testing.assert_allclose(stiffness, np.diag(square), atol=1e-10 * square.max())
    # Rayleigh-Ritz: from above, and always better with more modes.
    full = disk_modes(disk, 92).frequency[:92]
    more = reduce(disk, 176).modes.frequency[:92]
    assert (modes.frequency[:92] >= full * (1.0 - 1e-10)).all()
    assert (more <= modes.frequency[:92] * (1.0 + 1e-10)).all()


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize(("blades", "kept"), [(5, 8), (4, 9), (6, 0)])
def test_static_shapes_and_fixed_interface_modes_span_the_reduced_structure(
    blades: int, kept: int, dense: bool
) -> None:
    disk = bladed_disk(blades=blades, elements=3)
    structure = replace(disk.structure, layout=None) if dense else disk.structure
    boundary = tips_and_centre(disk)
    inside = np.setdiff1d(np.arange(structure.size), boundary)
    reduction = reduce(disk, kept, dense=dense)
    basis = craig_bampton_basis(structure, boundary, reduction.kept)
    mass, stiffness = structure.mass, structure.stiffness
    static, fixed = basis[:, : len(boundary)], basis[:, len(boundary) :]
    np.testing.assert_array_equal(static[boundary], np.eye(len(boundary)))
    force = (stiffness @ static)[inside]
    np.testing.assert_allclose(force, 0.0, atol=1e-9 * stiffness.max())
    assert not fixed[boundary].any()
    np.testing.assert_allclose(fixed.T @ (mass @ fixed), np.eye(reduction.kept), atol=1e-10)
    squares = fixed_interface_frequencies(disk)[: reduction.kept] ** 2
    held = fixed.T @ (stiffness @ fixed)
    np.testing.assert_allclose(held, np.diag(squares), atol=1e-9 * squares.max(initial=1.0))
    actual = la.eigvalsh(basis.T @ (stiffness @ basis), basis.T @ (mass @ basis))
    np.testing.assert_allclose(np.sqrt(actual), reduction.modes.frequency, rtol=1e-8)


@pytest.mark.parametrize("tips", [slice(2), slice(None)], ids=["two tips", "half the centre"])
def test_a_boundary_must_be_alike_in_all_directions(tips: slice) -> None:
    disk = bladed_disk(blades=5, elements=3)
    boundary = np.append(disk.tip_radial[tips], disk.centre[:1])
    with pytest.raises(ValueError, match="same in all sectors and contain both"):
        craig_bampton(disk.structure, boundary, 4, tip_in_sector(disk))
