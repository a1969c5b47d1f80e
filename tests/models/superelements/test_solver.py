"""Sparse factorisation, and modes and static displacements that follow from it, compared with the
dense matrices of LAPACK."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from solid_meshes import SECTORS, bladed_sector, cantilever

from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.cholesky import Cholesky
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.dense_pencil import DensePencil
from bladewhirl.models.superelements.reduction import massless, rigid_limit
from bladewhirl.models.superelements.sector import CondensedWave, Sector, TiedWave, Wave
from bladewhirl.models.superelements.solver import MatrixPencil
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError, dense
from bladewhirl.models.superelements.wheel import WheelOverSpeeds

steel = partial(mesh3d, young_modulus=2.1e11, poisson_ratio=0.3, density=7800.0)


@pytest.fixture(scope="module")
def blade() -> Superelement:
    """Return a blade of 1,170 coordinates, clamped at its root."""
    return steel(cantilever("hexahedron20", (14, 3, 1)))


@pytest.fixture(scope="module")
def sector() -> Superelement:
    """Return a sector of 546 coordinates, of which 105 are on each face."""
    mesh = bladed_sector("hexahedron20")
    return steel(mesh, contacts=3, speed=800.0, left="left", right="right", copies=SECTORS)


def test_a_factor_solves_and_leaves_the_schur_complement(blade: Superelement) -> None:
    matrix = sp.csr_array(blade.stiffness)
    loads = np.random.default_rng(1).standard_normal((blade.size, 3))
    factor = Cholesky.of(matrix)
    assert factor.entries < 0.5 * blade.size**2  # it is sparse
    expected = la.solve(dense(matrix), loads)
    assert factor.solve(loads) == pytest.approx(expected, rel=1e-7, abs=1e-9 * abs(expected).max())
    last = np.arange(7, blade.size, 40)
    inner = np.setdiff1d(np.arange(blade.size), last)
    bordered = Cholesky.of(matrix, last)
    a, b, c = (dense(matrix[i][:, j]) for i, j in ((inner, inner), (inner, last), (last, last)))
    schur = c - b.T @ la.solve(a, b, assume_a="pos")
    assert bordered.schur == pytest.approx(schur, rel=1e-8, abs=1e-9 * abs(schur).max())
    eliminated, left_over = bordered.forward(loads)
    solution = bordered.backward(eliminated, la.solve(schur, left_over))
    assert solution == pytest.approx(expected, rel=1e-6, abs=1e-8 * abs(expected).max())


def test_separate_parts_and_dense_matrices_are_factorised() -> None:
    rng = np.random.default_rng(2)
    blocks = [one @ one.T + np.eye(len(one)) for n in (1, 300, 4) for one in (rng.random((n, n)),)]
    matrix = la.block_diag(*blocks)
    loads = rng.standard_normal((len(matrix), 2))
    assert matrix @ Cholesky.of(sp.csr_array(matrix)).solve(loads) == pytest.approx(loads, abs=1e-9)


def test_matrices_that_are_not_positive_definite_are_refused() -> None:
    matrix = sp.diags_array([[1.0, 2.0, -1e-3]], offsets=[0])
    with pytest.raises(la.LinAlgError, match="not positive definite"):
        Cholesky.of(sp.csr_array(matrix))


@pytest.mark.parametrize("pencil", [MatrixPencil, DensePencil])
def test_motions_without_mass_have_no_modes(pencil: type[MatrixPencil | DensePencil]) -> None:
    squares, _ = pencil(np.eye(3), np.diag([1.0, 2.0, 0.0])).lowest(3)
    assert squares == pytest.approx([0.5, 1.0])
    with pytest.raises(SuperelementError, match=r"^mass: expected a positive definite matrix$"):
        pencil(np.eye(3), np.diag([1.0, 2.0, -1.0])).lowest(2)


def test_dense_matrices_have_the_modes_and_static_displacements_of_sparse_ones() -> None:
    chain = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(60, 60)).toarray()
    chain[0, 0] = chain[-1, -1] = 1.0  # one rigid mode
    mass, loads = np.diag(np.linspace(1.0, 2.0, 60)), np.eye(60)[:, :2]
    one, other = (pencil(chain, mass, 1e-6) for pencil in (MatrixPencil, DensePencil))
    squares, shapes = other.lowest(12)
    assert squares == pytest.approx(one.lowest(12)[0], rel=1e-8, abs=1e-12)
    assert shapes.T @ mass @ shapes == pytest.approx(np.eye(12), abs=1e-10)
    moved = one.static(loads, one.lowest(12)[1])
    assert other.static(loads, shapes) == pytest.approx(moved, abs=1e-8 * abs(moved).max())


@pytest.mark.parametrize("count", [1, 12, 60])
def test_the_lowest_modes_are_those_of_dense_matrices(blade: Superelement, count: int) -> None:
    squares, shapes = MatrixPencil(blade.stiffness, blade.mass).lowest(count)
    expected, vectors = la.eigh(
        dense(blade.stiffness), dense(blade.mass), subset_by_index=[0, count - 1]
    )
    assert squares == pytest.approx(expected, rel=1e-8)
    assert shapes.T @ (blade.mass @ shapes) == pytest.approx(np.eye(count), abs=1e-10)
    assert abs(np.diag(vectors.T @ (blade.mass @ shapes))) == pytest.approx(1.0, abs=1e-8)


def test_equal_frequencies_are_all_found() -> None:
    """Twenty equal chains of masses have modes of twenty equal frequencies."""
    one = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(40, 40))
    stiffness = sp.kron(sp.eye_array(20), one)
    squares, _ = MatrixPencil(sp.csr_array(stiffness), sp.eye_array(800)).lowest(50)
    waves = np.pi * np.array([1, 2, 3]) / 41
    expected = np.repeat(4.0 * np.sin(waves / 2.0) ** 2, 20)[:50]
    assert squares == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(("count", "whole"), [(1, 4), (4, 4), (5, 8), (38, 40)])
def test_no_group_of_equal_frequencies_is_cut(count: int, whole: int) -> None:
    pencil = MatrixPencil(np.diag(np.repeat(np.arange(1.0, 11.0), 4)), np.eye(40))
    squares, shapes = pencil.lowest_groups(count)
    assert squares == pytest.approx(np.repeat(np.arange(1.0, 11.0), 4)[:whole], rel=1e-8)
    assert shapes.shape == (40, whole)


def test_a_free_blade_has_six_rigid_modes_and_a_finite_residual_flexibility() -> None:
    mesh = cantilever("hexahedron20")
    free = steel(mesh, clamped=None, contacts=3)
    reduced = massless(free, 20)
    assert np.count_nonzero(reduced.frequency**2 < rigid_limit(free)) == 6
    squares, shapes = la.eigh(dense(free.stiffness), dense(free.mass))
    higher = free.contact_rows @ shapes[:, 20:] / np.sqrt(squares[20:])
    expected = higher @ higher.T
    assert reduced.compliance == pytest.approx(expected, rel=1e-6, abs=1e-7 * abs(expected).max())
    with pytest.raises(SuperelementError, match="no motion without stiffness except rigid ones"):
        massless(free, 4)  # two rigid motions are left


@pytest.mark.parametrize("rigid", [False, True])
@pytest.mark.parametrize(("large", "wave_type"), [(2000, CondensedWave), (10, TiedWave)])
def test_waves_of_a_sector_are_those_of_dense_matrices(
    sector: Superelement,
    rigid: bool,
    large: int,
    wave_type: type[Wave],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    count, rows = 15, sector.contact_rows
    loads = np.eye(sector.size)[:, :4]

    def computed(k: int) -> tuple[Any, Any, Any]:
        wave = cyclic.wave(k)
        squares, shapes = wave.lowest(count)
        forces = wave.tie.conj().T @ loads
        return squares, wave.tie @ shapes, rows @ wave.tie @ wave.static(forces, shapes)

    monkeypatch.setattr("bladewhirl.models.superelements.sector.LARGE_FACE", large)
    cyclic = Sector(sector, SECTORS, modes=count, loads=4, rigid=rigid)
    assert isinstance(cyclic.wave(1), wave_type)
    diameters = 0, 2, SECTORS // 2
    for k, found in zip(diameters, cyclic.each_wave(computed, diameters), strict=True):
        squares, fields, moved = found
        tie = transformation(sector, SECTORS, k)
        block = sector.projected(tie, ("mass", "stiffness"))
        stiffness, mass = block["stiffness"].toarray(), block["mass"].toarray()
        expected, vectors = la.eigh(stiffness, mass)
        assert squares == pytest.approx(expected[:count], rel=1e-9)
        among = (tie @ vectors[:, :count]).conj().T @ (sector.mass @ fields)
        assert among.conj().T @ among == pytest.approx(np.eye(count), abs=1e-8)
        higher = vectors[:, count:] / np.sqrt(expected[count:])
        static = (rows @ tie @ higher) @ (tie @ higher).conj().T @ loads
        assert moved == pytest.approx(static, rel=1e-7, abs=1e-8 * abs(static).max())


def test_faults_of_a_sector_end_in_one_line(sector: Superelement) -> None:
    soft = replace(sector, stiffness=sector.stiffness - 1e-3 * sp.eye_array(sector.size) * 1e12)
    with pytest.raises(SuperelementError, match=r"^expected .* not indefinite$"):
        WheelOverSpeeds(soft, SECTORS, 5).at(0.0)
    coupling = sp.coo_array(([1e3, 1e3], ([0, 3], [3, 0])), shape=sector.mass.shape)
    light = replace(sector, mass=sector.mass + coupling)
    with pytest.raises(SuperelementError, match=r"^mass: expected a positive definite matrix$"):
        WheelOverSpeeds(light, SECTORS, 5).at(0.0)
    with pytest.raises(SuperelementError, match=r"fewer than .* free-interface modes"):
        WheelOverSpeeds(sector, SECTORS, 5000).at(0.0)
