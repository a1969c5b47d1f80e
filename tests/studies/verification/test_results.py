"""Energy and work of a run in the paper's six modes, found anew from its `result.nc` alone."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.postprocess.run.summary import energy_residual
from bladewhirl.studies.verification.results import recorded, rows

pytestmark = pytest.mark.usefixtures("pictures_unsaved")

KAPPA = 1e6


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    coupled = {"modes": "six", "amplitude": "physical", "stiffness": KAPPA}
    return recorded(
        reduction__modes="six",
        damping__ratio=0.005,
        excitation__type="imbalance",
        march__duration=0.006,
        **{f"coupling__{key}": value for key, value in coupled.items()},
    )


def displacements(result: xr.Dataset, body: str) -> FloatArray:
    """Modal displacements by step, (steps, modes)."""
    return np.asarray(result[f"{body}_displacement"].values)


def test_energy_is_that_of_both_bodies_and_the_springs(result: xr.Dataset) -> None:
    dt, speed = result.attrs["time_step"], result.attrs["speed"]
    energy = np.zeros(result.sizes["time"] - 1)
    for body in ("rotor", "casing"):
        x, w = displacements(result, body), result[f"{body}_frequency"].values
        energy += 0.5 * ((np.diff(x, axis=0) / dt) ** 2 + w**2 * x[1:] * x[:-1]).sum(axis=1)
    # One wave round each body, A exp(i theta); springs join them where they were a step before.
    angle, tips = result["tip_angle"].values, result["tip_node"].values
    x, y = result["rotor_shape"].values[tips, :2].transpose(1, 0, 2)
    outward = x * np.cos(angle)[:, None] + y * np.sin(angle)[:, None]
    wall = result["casing_shape"].values[:, 0]
    around = 2.0 * np.pi * np.arange(len(wall)) / len(wall)

    def wave(field: FloatArray, at: FloatArray) -> ComplexArray:
        return np.asarray(field @ np.exp(-1j * at) * 2.0 / len(at))

    on_casing = wave(displacements(result, "casing") @ wall.T, around)
    on_rotor = wave(displacements(result, "rotor") @ outward.T, angle)
    turned = np.exp(-1j * speed * result["time"].values[:-1])
    before, after = on_casing[:-1] - turned * on_rotor[:-1], on_casing[1:] - turned * on_rotor[1:]
    springs = 0.5 * KAPPA * np.pi * (before.conj() * after).real
    assert springs.max() > 1e-2 * energy.max()
    found = result["energy"].values[1:]
    np.testing.assert_allclose(energy + springs, found, rtol=1e-9, atol=1e-9 * found.max())


def test_what_the_bodies_gain_is_the_work_of_all_forces(result: xr.Dataset) -> None:
    assert energy_residual(result) < 1e-9
    radial, tangential, on_wall, along_wall = rows(result)
    normal, friction = (result[f"{name}_impulse"].values[2:] for name in ("contact", "friction"))
    assert normal.any()
    moved = [
        (x[2:] - x[:-2]) / (2.0 * result.attrs["time_step"])
        for x in (displacements(result, "rotor"), displacements(result, "casing"))
    ]
    for name, impulse, rotor, casing in (
        ("normal", normal, radial, on_wall),
        ("friction", friction, tangential, along_wall),
    ):
        closing = np.einsum("tbm,tm->tb", casing[2:], moved[1]) - moved[0] @ rotor.T
        found = np.diff(result[f"{name}_work"].values)[1:]
        expected = (impulse * closing).sum(axis=1)
        np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(found).max())
