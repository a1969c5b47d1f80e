"""Responses with joints in their linear limits against all blades assembled in global axes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from joint_cases import BLADES, blade, tables

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.joints.limits import LIMITS

ORDER, RATIO, FORCE = 2, 2e-3, 5.0
MISTUNED = [1.0, 1.03, 0.98, 1.01, 0.97, 1.02, 0.99]
NORMAL = np.array([0.3, 1.0, -0.4]) / np.linalg.norm([0.3, 1.0, -0.4])


def assembled(omega: float, held: tuple[int, ...], factors: list[float]) -> FloatArray:
    """Complex tangential displacements of the tips of all blades, in which the relative
    displacements of the joint nodes along the normal or in all directions are zero."""
    part, size = blade(), blade().size
    mass, stiffness = np.asarray(part.mass), np.asarray(part.stiffness)
    squares, shapes = la.eigh(stiffness, mass)
    left = mass @ shapes
    damping = (left * 2.0 * RATIO * np.sqrt(squares)) @ left.T
    w, turn = ORDER * omega, 2.0 * np.pi / BLADES * np.arange(BLADES)
    dynamic = la.block_diag(
        *[s * stiffness + 1j * w * np.sqrt(s) * damping - w**2 * mass for s in factors]
    )
    tip = part.contact_dofs[2]
    force = np.zeros((BLADES, size), dtype=np.complex128)
    force[:, tip[1]] = FORCE * np.exp(1j * ORDER * turn)
    axes = np.linalg.qr(np.column_stack([NORMAL, np.eye(3)[:, :2]]))[0].T  # normal first
    half, rows = np.pi / BLADES, np.zeros((BLADES, len(held), BLADES, size))
    for j in range(BLADES):
        for node, at, sign in ((0, (j + 1) % BLADES, 1.0), (1, j, -1.0)):
            a = -half if node == 0 else half  # of the node on its blade
            c, s = np.cos(a), np.sin(a)
            cylindrical = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
            rows[j][:, at, part.contact_dofs[node]] += sign * (axes @ cylindrical)[list(held)]
    flat = rows.reshape(-1, BLADES * size)
    saddle = np.block([[dynamic, flat.T], [flat, np.zeros((len(flat), len(flat)))]])
    right = np.concatenate([force.ravel(), np.zeros(len(flat))])
    return np.asarray(
        np.linalg.solve(saddle, right)[: BLADES * size].reshape(force.shape)[:, tip[1]]
    )


@pytest.mark.parametrize("factors", [[1.0] * BLADES, MISTUNED])
def test_limits_are_those_of_all_blades_assembled(tmp_path: Path, factors: list[float]) -> None:
    own: Any = tables(tmp_path, normal=NORMAL.tolist()) | {"damping": {"ratio": RATIO}}
    del own["joint"][0]["angle"]
    own["excitation"] = {"type": "engine-order", "order": ORDER, "amplitude": FORCE}
    if factors is MISTUNED:
        own["bladed_disk"]["mistuning"] = {"stiffness": factors}
    speeds = ["4700 rpm", "3807 rpm"]  # not ascending: no search of peaks
    data = bw.response(bw.case_from(own), speeds=speeds)
    for n, rpm in enumerate(data["rpm"].values):
        for name, held in LIMITS.items():
            found = data["tip_tangential"].sel(limit=name).isel(speed=n).values
            expected = assembled(rpm * np.pi / 30.0, held, factors)
            assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()


def test_blades_that_stick_to_a_damper_are_joined_by_its_mass(tmp_path: Path) -> None:
    own: Any = tables(tmp_path, kind="wedge", wedge={"mass": "1 kg", "axial": "free"})
    del own["joint"][0]["angle"]
    given = bw.case_from(own)
    light, heavy = (
        bw.response(bw.with_values(given, {"joint.shroud.wedge.mass": mass}))
        for mass in ("1e-6 kg", "1 kg")
    )
    tied = bw.response(bw.case_from(tables(tmp_path)))
    found = [one["tip_tangential"].sel(limit="stuck").values for one in (light, heavy, tied)]
    assert np.abs(found[0] - found[2]).max() < 1e-4 * np.abs(found[2]).max()
    assert np.abs(found[1] - found[2]).max() > 0.1 * np.abs(found[2]).max()
