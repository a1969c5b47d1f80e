"""Stability of a stage whose blades differ: against Floquet theory, and as a command."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.file import case_from
from bladewhirl.models.coupling.springs import spring_factor
from bladewhirl.models.coupling.without_sectors import DenseModes, dense_modes
from bladewhirl.models.modal.full_stage import modal_stage
from bladewhirl.studies.commands.cli import app

CASE = """
[bladed_disk]
blades = 6
elements_per_blade = 3
mistuning = { stiffness = [1.0, 1.1, 0.95, 1.0, 1.2, 0.9] }
[casing]
elements = 16
"""


def few_modes() -> tuple[DenseModes, float]:
    """1F, suspension and the casing's k = 0, 1 of six unlike blades, damped; and the reference."""
    stiffness = [1.0, 1.1, 0.95, 1.0, 1.2, 0.9]
    tables: dict[str, Any] = {
        "bladed_disk": {
            "blades": 6,
            "elements_per_blade": 3,
            "mistuning": {"stiffness": stiffness},
        },
        "casing": {"elements": 16},
    }
    modal = modal_stage(case_from(tables))
    whole = dense_modes(modal, damping_ratio=0.002)
    rotor = np.isin(np.array(whole.family), ["1F", "suspension"])
    return whole.take(rotor, whole.casing_diameter <= 1), modal.reference_frequency


def monodromy(modes: DenseModes, speed: float, kappa: float) -> FloatArray:
    """Over one turn, with the casing in static axes and the rotor in its own."""
    rotor, size = len(modes.family), modes.size
    casing = np.repeat(modes.casing_frequency, 1 + (modes.casing_diameter > 0))
    frequency = np.concatenate([modes.rotor_frequency, casing])
    damping = 2.0 * modes.damping_ratio * frequency

    def rate(time: float, flat: FloatArray) -> FloatArray:
        state = flat.reshape(2 * size, -1)
        place, velocity = state[:size], state[size:]
        force = frequency[:, None] ** 2 * place + damping[:, None] * velocity
        first = rotor
        for i, k in enumerate(modes.casing_diameter.tolist()):
            count = 2 if k else 1
            turn = k * speed * time
            # Waves of the rotor, cos k (theta - Omega t), seen at static angles theta.
            seen = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            row = np.zeros((count, size))
            row[:, first : first + count] = modes.casing_amplitude[i] * np.eye(count)
            row[:, :rotor] = -(seen @ modes.waves[i])[:count] if k else -modes.waves[i, :1]
            force += spring_factor(k) * kappa * row.T @ (row @ place)
            first += count
        return np.concatenate([velocity, -force]).ravel()

    start = np.eye(2 * size).ravel()
    end = 2.0 * np.pi / speed
    solution = solve_ivp(rate, (0.0, end), start, method="DOP853", rtol=1e-10, atol=1e-12)
    return np.asarray(solution.y[:, -1].reshape(2 * size, 2 * size))


@pytest.mark.parametrize("speed", [1.06, 1.3])
def test_growth_agrees_with_floquet_theory(speed: float) -> None:
    modes, reference = few_modes()
    omega, kappa = speed * reference, 1e5
    multipliers = la.eigvals(monodromy(modes, omega, kappa))
    expected = np.sort(np.log(np.abs(multipliers))) * omega / (2.0 * np.pi)
    found = np.sort(la.eigvals(modes.state_matrix(omega, kappa)).real)
    np.testing.assert_allclose(found, expected, atol=1e-6 * omega)


def run(tmp_path: Path, *options: str) -> Any:
    path = tmp_path / "unlike.toml"
    path.write_text(CASE)
    return CliRunner().invoke(app, ["stability", str(path), *options])


def test_a_point(tmp_path: Path) -> None:
    options = ["--speed", "1.06", "--kappa", "1e5", "--modes", "1F,suspension,casing:0,casing:1"]
    ended = run(tmp_path, "--physical", "--damped", "--json", *options)
    point = json.loads(ended.stdout)
    modes, reference = few_modes()
    assert point["reference_frequency"] == pytest.approx(reference)
    assert len(point["eigenvalues"]) == 2 * modes.size
    assert point["growth_rate"] <= 0.0 or point["unstable"]


def test_a_chart(tmp_path: Path) -> None:
    folder = tmp_path / "chart"
    ended = run(
        tmp_path,
        *("--physical", "--speeds", "0.9:1.5:13", "--kappas", "0:2e5:3", "-o", str(folder)),
    )
    assert ended.exit_code == 0, ended.output
    assert "Largest growth rate" in ended.stdout
    assert (folder / "stability.png").is_file()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "expected --physical where blades differ"),
        (["--physical", "--modes", "9F"], "--modes 9F: expected one of six, all, casing"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(
    tmp_path: Path, options: list[str], message: str
) -> None:
    ended = run(tmp_path, "--speed", "1", "--kappa", "1", *options)
    assert ended.exit_code == 2 or message in str(ended.exception)
    assert message in ended.output + str(ended.exception)
