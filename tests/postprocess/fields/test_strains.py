"""Strains against beam theory: closed forms, motions without strain; `verify sensors` compares
those of beams with the statics of a force on a tip."""

import numpy as np
import pytest
import scipy.sparse.linalg as spla
import stages
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.models.elements.casing import RADIAL, RADIAL_SLOPE
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.strains import casing_strain_rows, rotor_strain_rows

THICKNESS, WIDTH, YOUNG = 0.01, 0.1, 2.1e11


def test_rigid_motions_strain_nothing() -> None:
    rows = rotor_strain_rows(synthetic.synthetic_result(records=2), 3)
    for strain in rows:
        np.testing.assert_allclose(strain[..., :3], 0.0, atol=1e-12)
        assert np.abs(strain[..., 3]).max() >= 0.0
    assert np.abs(rows.bending[..., 3]).max() > 0.1


def ring(elements: int, curvature: str, shape: Array) -> xr.Dataset:
    """The ring of the reference results with given nodal values as its only mode."""
    made = stages.casing(elements)
    return xr.Dataset(
        {
            "casing_angle": ("casing_node", made.mesh.angles),
            "casing_thickness": ("casing_node", np.full(elements, THICKNESS)),
            "casing_curvature": ((), curvature),
            "casing_shape": (("casing_node", "casing_component", "casing_mode"), shape),
        },
        attrs={"casing_radius": made.mesh.radius},
    )


def test_ring_under_uniform_pressure() -> None:
    """Only stretched, by w / R, where w (E A / R^2 + support) is the pressure per length."""
    support, pressure = 2e6, 4e4
    made = stages.casing(24, support)
    length, radius = made.mesh.element_length, made.mesh.radius
    load = np.zeros(made.structure.size)
    load[made.structure.node_dofs[:, RADIAL]] = pressure * length  # slopes of both sides cancel
    assert made.structure.node_dofs[0, RADIAL_SLOPE] >= 0
    answer = spla.spsolve(made.structure.stiffness.tocsc(), load)
    rows = casing_strain_rows(ring(24, "exact", made.nodal(answer[:, None])), 3)
    moved = pressure / (YOUNG * WIDTH * THICKNESS / radius**2 + support)
    np.testing.assert_allclose(rows.axial, moved / radius, rtol=1e-9)
    np.testing.assert_allclose(rows.bending, 0.0, atol=1e-9 * moved / radius)


def wave(elements: int, k: int) -> Array:
    """Inextensional wave w = cos k theta, u = -sin k theta / k: nodal values of one mode."""
    angle, radius = 2 * np.pi * np.arange(elements) / elements, 0.501
    c, s = np.cos(k * angle), np.sin(k * angle)
    return np.column_stack([c, -k * s / radius, -s / k, -c / radius])[:, :, None]


@pytest.mark.parametrize(("curvature", "number"), [("exact", 3.0), ("shallow", 4.0)])
def test_an_oval_ring_bends(curvature: str, number: float) -> None:
    """kappa = -(k^2 - 1) w / R^2, shallow -k^2 w / R^2; no stretch."""
    errors = []
    for elements in (20, 40, 80):
        rows = casing_strain_rows(ring(elements, curvature, wave(elements, 2)), 4)
        angle = 2 * np.pi / elements * (np.arange(elements)[:, None] + np.linspace(0, 1, 5))
        expected = -number * np.cos(2 * angle) / 0.501**2 * THICKNESS / 2
        scale = np.abs(expected).max()
        errors.append(np.abs(rows.bending[..., 0] - expected).max() / scale)
        assert np.abs(rows.axial).max() < 0.02 * (20 / elements) ** 3
    assert errors[-1] < 3e-3  # (k h)^2 / 12, times 4 / 3 for the exact ring
    assert np.all(stages.observed_order(np.array(errors)) > 1.8)  # of second derivatives of cubics


def test_a_turned_ring_has_no_strain_and_a_shifted_one_hardly_any() -> None:
    turned = np.zeros((20, 4, 1))
    turned[:, 2] = 1.0
    for strain in casing_strain_rows(ring(20, "exact", turned), 3):
        np.testing.assert_allclose(strain, 0.0, atol=1e-11)
    oval, shifted = (
        np.abs(casing_strain_rows(ring(80, "exact", wave(80, k)), 3).bending).max() for k in (2, 1)
    )
    assert shifted < 1e-3 * oval
