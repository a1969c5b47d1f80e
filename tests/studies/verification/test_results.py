"""Energy of a run in the paper's six modes, found anew from its `result.nc` alone."""

from __future__ import annotations

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.verification.results import SMALL

KAPPA = 1e6


def displacements(result: xr.Dataset, body: str) -> FloatArray:
    """Modal displacements by step, (steps, modes)."""
    return np.asarray(result[f"{body}_displacement"].values)


def test_energy_is_that_of_both_bodies_and_the_springs() -> None:
    changes = {
        **SMALL,
        "initial.centre_velocity": [1.5, 0.7],
        "reduction.modes": "six",
        "coupling": {"modes": "six", "amplitude": "physical", "stiffness": KAPPA},
        "excitation.type": "imbalance",
        "march.duration": 0.006,
    }
    result, _ = march_in_memory(prepare(with_values(Case(), changes)))
    assert result["contact_impulse"].values.any()
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
