"""Elliptic whirl on unequal stationary bearings, against the equations in rotating axes."""

import numpy as np
import pytest
from stages import bladed_disk

from bladewhirl.models.coupling.equations import difference_of_axes
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.rotation.unequal_bearings import EllipticWaves, on_unequal_bearings
from bladewhirl.models.structure.eigenproblems import gyroscopic_eigen

HALF = 4e6  #: half the difference of the bearings [N/m]


@pytest.fixture(scope="module")
def matrices() -> Structure:
    return rotation_matrices(bladed_disk())


def elliptic(matrices: Structure, difference: float = HALF) -> EllipticWaves:
    layout = matrices.layout
    assert layout is not None
    along_x = layout.basis(1).conj().T[:, bladed_disk().centre[:1]].toarray().ravel()
    return on_unequal_bearings(matrices.wave(1), along_x, difference)


@pytest.mark.parametrize("omega", [0.0, 90.0, -250.0])
def test_motions_solve_the_equations_with_springs_that_vary_in_rotating_axes(
    matrices: Structure, omega: float
) -> None:
    """x = B a + conj(B a), a = b exp(i Omega t), at an instant, with its derivatives."""
    given, structure, time = elliptic(matrices), matrices, 0.0123
    static = given.static
    rates, fields = gyroscopic_eigen(
        static.mass, static.stiffness_at(omega), omega * static.known("gyroscopic")
    )
    assert structure.layout is not None
    basis, size = structure.layout.basis(1), len(given.mass)
    centre = np.eye(structure.size)[bladed_disk().centre[:2]]
    varying = HALF * difference_of_axes(centre, omega * time)
    for mode in (2 * size - 2, 2 * size - 1, 2 * size, 2 * size + 1):  # the lowest
        (p, q), rate = np.split(fields[:, mode], 2), rates[mode].real
        waves_of_b = [(omega + rate, p), (omega - rate, q.conj())]
        x, v, a = (
            2.0
            * (basis @ sum((1j * w) ** n * np.exp(1j * w * time) * f for w, f in waves_of_b)).real
            for n in range(3)
        )
        forces = matrices.stiffness_at(omega) @ x, omega * (matrices.gyroscopic @ v), varying @ x
        rest = structure.mass @ a + sum(forces)
        assert np.abs(rest).max() < 1e-7 * max(np.abs(each).max() for each in forces)
        assert np.abs(varying @ x).max() > 1e-4 * np.abs(forces[0]).max()


@pytest.mark.parametrize("omega", [60.0, 300.0, -300.0])
def test_equal_bearings_leave_the_waves_and_their_order(matrices: Structure, omega: float) -> None:
    equal, given = matrices.wave(1), elliptic(matrices, 1e-6)
    scale = np.abs(equal.frequencies(omega)).max()
    np.testing.assert_allclose(
        given.frequencies(omega), equal.frequencies(omega), atol=1e-9 * scale
    )
    np.testing.assert_allclose(given.spring_shares(omega), equal.spring_shares(omega), atol=1e-6)
    both = np.sort(np.append(equal.synchronous(0)[0], equal.synchronous(2)[0]))
    np.testing.assert_allclose(given.synchronous(0)[0], both, rtol=1e-7)
    np.testing.assert_allclose(given.synchronous(1)[0], np.repeat(equal.synchronous(1)[0], 2))


def test_a_motion_meets_the_casing_and_the_speed_at_its_frequency(
    matrices: Structure,
) -> None:
    given = elliptic(matrices)
    for speed in given.synchronous(0)[0][:2]:
        static = np.abs(given.frequencies(speed) - speed)
        assert np.abs(static - speed).min() < 1e-6 * speed
        w = given.frequencies(speed)[np.abs(static - speed).argmin()].real
        assert given.rank(speed, 0.0) == given.rank(speed, w)
    for speed in given.meeting(200.0, 400.0):
        assert np.abs(np.abs(given.frequencies(speed) - speed) - 200.0).min() < 1e-6 * 200.0
