"""Coupled modes that mix nodal diameters, against those of one each, Floquet theory and by hand."""

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
from places import EXAMPLES
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.coupling.equations import CoupledEquations
from bladewhirl.models.coupling.stage_modes import stage_modes
from bladewhirl.models.coupling.stage_waves import coupled_waves, standing_obstacles
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.solvers.stability.floquet import coupled_floquet, exponents
from bladewhirl.solvers.stability.growth import growth_rate
from bladewhirl.studies.commands.cli import app

RUNNER = CliRunner()
SMALL = {
    "bladed_disk.blades": 6,
    "bladed_disk.elements_per_blade": 3,
    "casing.elements": 16,
    "reduction.fixed_interface_modes": 20,
}
RIB = {"casing.stiffened_arcs": [{"start": 0.0, "end": 1.5707963267948966, "thickness": 0.02}]}


@cache
def tuned(blades: int = 6) -> ModalModel:
    """The paper's stage, of fewer blades and elements."""
    return modal_model(with_values(Case(), SMALL | {"bladed_disk.blades": blades}))


def uneven(changes: Mapping[str, object]) -> ModalModel:
    """The same with something that breaks its symmetry."""
    return modal_model(with_values(Case(), SMALL | dict(changes)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("modes", "speed", "kappa", "physical", "blades"),
    [
        ("six", 1.17, 500.0, False, 6),
        ("six", 0.8, 2000.0, True, 6),
        ("all", 0.8, 2000.0, False, 6),
        ("all", 1.1, 500.0, True, 7),
    ],
)
def test_on_an_even_stage_it_is_the_same(
    modes: str, speed: float, kappa: float, physical: bool, blades: int
) -> None:
    modal = tuned(blades)
    kappa *= 100.0 if physical else 1.0
    even = stage_modes(modal, damping_ratio=0.005)
    even = even if modes == "all" else even.six_modes()
    even = even if physical else even.with_unit_amplitudes()
    system = coupled_waves(modal, modes=modes, damped=True, physical=physical)
    assert system.structure.size == even.modes.size
    omega = speed * modal.reference_frequency
    turns = coupled_floquet(even.modes, speed=omega, kappa=kappa)
    expected = max(float(turn.growth) for turn in turns)
    exact = float(growth_rate(even.modes, speed=omega, kappa=kappa))
    assert system.turning is not None
    periodic = replace(system, turning=None)
    for waves in (system, periodic) if modes == "six" else (system,):
        growth = exponents(waves, speed=omega, kappa=kappa).real.max()
        assert growth == pytest.approx(expected, abs=1e-9 * omega)
        assert growth == pytest.approx(exact, abs=1e-8 * omega)


def by_angles(system: CoupledEquations, angle: float, kappa: float) -> FloatArray:
    """kappa times the integral of (w - u)^2, static angle by angle."""
    stiffness = system.structure.stiffness
    count = 400
    for theta in 2.0 * np.pi * np.arange(count) / count:
        row = np.zeros(system.structure.size)
        for k, casing, rotor in zip(system.harmonics, system.casing, system.rotor, strict=True):
            row += np.array([np.cos(k * theta), np.sin(k * theta)]) @ casing
            alpha = k * (theta - angle)
            row -= np.array([np.cos(alpha), np.sin(alpha)]) @ rotor
        stiffness += kappa * 2.0 * np.pi / count * np.outer(row, row)
    return stiffness


def test_modes_of_an_uneven_casing_are_coupled_by_all_their_waves() -> None:
    system = coupled_waves(uneven(RIB), modes="all", damped=False, physical=True)
    waves = np.linalg.norm(system.casing[:, :, -1], axis=1)
    assert np.count_nonzero(waves > 1e-3 * waves.max()) > 2
    for angle in (0.0, 0.7):
        np.testing.assert_allclose(
            system.stiffness(np.array([angle]), 3e4)[0],
            by_angles(system, angle, 3e4),
            rtol=1e-9,
            atol=1e-6,
        )


def test_a_slightly_uneven_stage_is_near_the_even_one() -> None:
    """And so for bladed disk and casing alike."""
    small = {"casing.springs": [{"angle": 0.3, "radial": 10.0}], "shaft.stiffness_y": 3.4001e7}
    modal = uneven(small)
    assert not modal.beams.structure.is_cyclic
    assert not modal.casing.structure.is_cyclic
    omega = 1.17 * modal.reference_frequency
    even = stage_modes(tuned(), damping_ratio=0.0).six_modes().with_unit_amplitudes().modes
    system = coupled_waves(modal, modes="six", damped=False, physical=False)
    growth = exponents(system, speed=omega, kappa=500.0).real.max()
    assert growth == pytest.approx(
        float(growth_rate(even, speed=omega, kappa=500.0)), abs=0.02 * omega
    )


def test_bearings_that_stand_still_excite_whirl_at_the_suspension_frequency() -> None:
    """b^4 - 4 w^2 b^2 = (d/m)^2 of a rigid rotor that turns at w."""
    mass, natural, swing = 2.0, 100.0, 2e3
    system = CoupledEquations(
        name=("x", "y"),
        structure=Rotating(
            mass=np.eye(2), stiffness=natural**2 * np.eye(2), damping=np.zeros((2, 2))
        ),
        harmonics=np.zeros(0, dtype=np.int64),
        casing=np.zeros((0, 2, 2)),
        rotor=np.zeros((0, 2, 2)),
        centre=np.eye(2) / np.sqrt(mass),
        anisotropy=swing,
        turning=None,
    )
    stiffness = mass * system.stiffness(np.array([0.0, 0.5 * np.pi]), kappa=0.0)
    mean = mass * natural**2
    for at, swung in zip(stiffness, (swing, -swing), strict=True):  # stiffer along static x
        assert at == pytest.approx(np.diag([mean + swung, mean - swung]))
    roots = np.roots([1.0, 0.0, -4.0 * natural**2, 0.0, -((swing / mass) ** 2)])
    growth = exponents(system, speed=natural, kappa=0.0).real.max()
    assert growth == pytest.approx(np.abs(roots.imag).max(), rel=1e-6)
    assert exponents(system, speed=1.3 * natural, kappa=0.0).real.max() < 1e-6


def test_dampers_are_in_the_damping_matrix() -> None:
    """Without springs between the bodies: eigenvalues of M, D and K alone."""
    changes = {
        "casing.springs": [{"angle": 1.0, "radial": 1e6, "radial_damping": 3e3}],
        "shaft.damping": 2e3,
    }
    modal = uneven(changes)
    assert standing_obstacles(modal, damped=True)
    system = coupled_waves(modal, modes="all", damped=True, physical=True)
    size = system.structure.size
    stiffness = system.structure.stiffness
    state = np.block(
        [[np.zeros((size, size)), np.eye(size)], [-stiffness, -system.structure.drag(0.0)]]
    )
    exact = la.eigvals(state)
    actual = exponents(system, speed=0.9 * modal.reference_frequency, kappa=0.0)
    np.testing.assert_allclose(np.sort(actual.real), np.sort(exact.real), atol=1e-4)
    undamped = coupled_waves(modal, modes="all", damped=False, physical=True)
    assert not undamped.structure.drag(0.0).any()
    assert exact.real.min() < -0.005 * np.sqrt(system.structure.stiffness.max())


@pytest.mark.parametrize("speed", [1.06, 1.3])
@pytest.mark.slow
def test_rotating_axes_hold_unlike_blades_still(speed: float) -> None:
    """Eigenvalues in these axes are the Floquet exponents of a turn in static and rotating ones."""
    stiffness = [1.0, 1.1, 0.95, 1.0, 1.2, 0.9]
    modal = uneven({"bladed_disk.mistuning": {"stiffness": stiffness}, "damping.ratio": 0.002})
    system = coupled_waves(
        modal, modes="1F,suspension,casing:0,casing:1", damped=True, physical=True
    )
    assert system.name == ("casing k=0", "casing k=1", "1F", "suspension")
    omega, kappa = speed * modal.reference_frequency, 1e5
    size = system.structure.size

    def rate(time: float, flat: FloatArray) -> FloatArray:
        place, velocity = flat.reshape(2, size, -1)
        stiffness = system.stiffness(np.array([omega * time]), kappa)[0]
        return np.ravel([velocity, -stiffness @ place - system.structure.drag(0.0) @ velocity])

    period = 2.0 * np.pi / omega
    turn = solve_ivp(
        rate, (0.0, period), np.eye(2 * size).ravel(), method="DOP853", rtol=1e-10, atol=1e-12
    ).y[:, -1]
    multipliers = la.eigvals(turn.reshape(2 * size, 2 * size))
    expected = np.sort(np.log(np.abs(multipliers))) / period
    actual = np.sort(exponents(system, speed=omega, kappa=kappa).real)
    np.testing.assert_allclose(actual, expected, atol=1e-6 * omega)


def test_a_stage_that_nothing_holds_still_has_no_state_matrix() -> None:
    system = coupled_waves(uneven(RIB), modes="six", damped=False, physical=True)
    assert system.state_matrix(0.0, 500.0).shape == (2 * system.structure.size,) * 2
    with pytest.raises(ValueError, match="no frame makes the equations of this stage autonomous"):
        system.state_matrix(1.0, 500.0)


@pytest.mark.slow
def test_what_a_frame_holds_still() -> None:
    assert not standing_obstacles(tuned(), damped=True)
    bearings = {"shaft.stiffness_y": 1e7, "shaft.frame": "static"}
    assert standing_obstacles(uneven(bearings), damped=False)
    assert not standing_obstacles(uneven(bearings | {"shaft.clamped": True}), damped=False)
    assert not standing_obstacles(uneven({"shaft.damping": 10.0}), damped=False)
    assert standing_obstacles(uneven({"shaft.damping": 10.0}), damped=True)
    assert standing_obstacles(uneven(RIB), damped=False)


@pytest.mark.slow
def test_the_command_looks_at_one_point(tmp_path: Path) -> None:
    case = str(EXAMPLES / "stiffened_casing.toml")
    point = ["--speed", "1.17", "--kappa", "500", "--physical"]
    result = RUNNER.invoke(app, ["stability", case, *point, "--json"])
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert len(document["eigenvalues"]) == 12
    assert document["growth_rate"] == pytest.approx(max(v[0] for v in document["eigenvalues"]))
    for arguments, said in (
        (["--physical"], "--speed, --kappa and --physical compute a single point"),
        (point[:-1], "expected --physical"),
        ([*point, "-o", str(tmp_path / "none")], "can be drawn only if each mode has one"),
        ([*point, "--modes", "1F:77"], "--modes 1F:77: "),
    ):
        result = RUNNER.invoke(app, ["stability", case, *arguments])
        assert result.exit_code == 2
        assert said in result.stderr
        assert len(result.stderr.splitlines()) == 1


@pytest.mark.slow
def test_the_command_charts_unlike_blades(tmp_path: Path) -> None:
    case, folder = str(EXAMPLES / "mistuned_blades.toml"), tmp_path / "chart"
    grid = ["--speeds", "0.9:1.5:0.6", "--kappas", "0:2e5:2e5"]
    result = RUNNER.invoke(app, ["stability", case, "--physical", *grid, "-o", str(folder)])
    assert result.exit_code == 0, result.output
    assert "largest growth rate" in result.stdout
    assert (folder / "stability.png").is_file()
    for arguments, said in (
        ([], "where blades differ"),
        (["--physical", "--modes", "1F"], "--modes 1F: expected modes of both bodies"),
        (["--physical", "--modes", "99F"], "--modes 99F: families of the bladed disk are"),
    ):
        result = RUNNER.invoke(app, ["stability", case, "--speed", "1", "--kappa", "1", *arguments])
        assert result.exit_code == 2
        assert said in result.stderr
        assert len(result.stderr.splitlines()) == 1
