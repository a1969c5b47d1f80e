"""Beam elements against textbook matrices and closed forms."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from plain_frame import beam_mass, beam_stiffness

from bladewhirl.models.elements.assembly import curved_beams, straight_beams
from bladewhirl.models.elements.forms import curved_stiffness, mass, straight_stiffness

EA, EI, RHO_A = 3.0, 5.0, 7.0
U, DU, W, DW = range(4)  # order of a curved beam's DoF at a node


@pytest.mark.parametrize("length", [1e-3, 0.045, 2.0, 300.0])
def test_straight_beam_is_the_textbook_one(length: float) -> None:
    one = straight_beams(np.array([length]), np.array([[0, 1]]), 2)
    order = one.node_dofs.ravel()
    actual = one.matrix(straight_stiffness, EA=np.array([EA]), EI=np.array([EI])).toarray()
    expected = beam_stiffness(EA, EI, length)
    np.testing.assert_allclose(actual[np.ix_(order, order)], expected, rtol=1e-11, atol=0.0)
    actual = one.matrix(mass, rho_A=np.array([RHO_A])).toarray()
    np.testing.assert_allclose(
        actual[np.ix_(order, order)], beam_mass(RHO_A, length), rtol=1e-11, atol=0.0
    )


def test_elements_of_many_lengths_keep_their_own_matrices() -> None:
    """One Hermite element object used for two lengths is silently wrong in scikit-fem."""
    lengths = np.array([0.3, 2.0, 1e-3, 0.7])
    beams = straight_beams(lengths, np.arange(8).reshape(4, 2), 8)
    values = np.array([1.0, 2.0, 3.0, 4.0])
    actual = beams.matrix(straight_stiffness, EA=values, EI=10.0 * values).toarray()
    for i, (length, value) in enumerate(zip(lengths, values, strict=True)):
        order = beams.node_dofs[2 * i : 2 * i + 2].ravel()
        expected = beam_stiffness(value, 10.0 * value, length)
        np.testing.assert_allclose(actual[np.ix_(order, order)], expected, rtol=1e-11)


def hermite(length: float) -> list[Polynomial]:
    """Cubics with one of value and slope at 0, value and slope at the end equal to one."""
    s = Polynomial([0.0, 1.0])
    x = s / length
    return [1 - 3 * x**2 + 2 * x**3, s * (1 - x) ** 2, 3 * x**2 - 2 * x**3, s * (x**2 - x)]


@pytest.mark.parametrize("shallow", [False, True])
def test_curved_beam_against_its_energy_in_polynomials(shallow: bool) -> None:
    length, radius = 0.4, 0.7
    zero = Polynomial([0.0])
    # Fields (u, w) of each DoF, in the order u, u', w, w' of both nodes.
    cubics = hermite(length)
    fields = [
        (cubic, zero) if kind == "u" else (zero, cubic)
        for pair in (cubics[:2], cubics[2:])
        for kind in "uw"
        for cubic in pair
    ]

    def integral(p: Polynomial) -> float:
        whole = p.integ()
        return float(whole(length) - whole(0.0))

    size = len(fields)
    stiffness, inertia = np.zeros((size, size)), np.zeros((size, size))
    for i, (u, w) in enumerate(fields):
        for j, (v, z) in enumerate(fields):
            strains = [f.deriv() + g / radius for f, g in ((u, w), (v, z))]
            bends = [
                g.deriv(2) - (0.0 if shallow else 1.0) * f.deriv() / radius
                for f, g in ((u, w), (v, z))
            ]
            inertia[i, j] = integral(u * v + w * z)
            stiffness[i, j] = integral(EA * strains[0] * strains[1] + EI * bends[0] * bends[1])

    one = curved_beams(np.array([length]), np.array([[0, 1]]), 2)
    order = np.ix_(one.node_dofs.ravel(), one.node_dofs.ravel())
    ones = np.ones(1)
    curvature = ones / radius
    bend = 0.0 * curvature if shallow else curvature
    actual = one.matrix(
        curved_stiffness, EA=EA * ones, EI=EI * ones, curvature=curvature, bend=bend
    ).toarray()
    np.testing.assert_allclose(actual[order], stiffness, rtol=1e-12, atol=1e-12 * stiffness.max())
    actual = one.matrix(mass, rho_A=RHO_A * ones).toarray()
    np.testing.assert_allclose(actual[order], RHO_A * inertia, rtol=1e-12, atol=1e-15)
