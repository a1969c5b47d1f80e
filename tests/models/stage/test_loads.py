"""Loads and initial values: closed forms, full statics, marches of a rigid rotor."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import Load
from bladewhirl.models.stage.loads import (
    excitation_loads,
    imbalance_force,
    initial_state,
    radial_mode,
    unbalance,
)
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.solvers.march.central_difference import CentralDifference

SUPPORT = 7.975e6
"""Casing support of the contact cases [N/m2]."""


@cache
def base(*values: tuple[str, object]) -> Stage:
    return build_stage(with_values(Case(), {"casing.support": SUPPORT, **dict(values)}))


def with_excitation(values: dict[str, object], stage_values: dict[str, object]) -> Stage:
    return base(*stage_values.items(), ("excitation", Frozen(values)))


class Frozen(dict[str, object]):
    """A table that can be the key of a cache."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self.items()))


def at(loads: tuple[Load, ...], time: float) -> tuple[FloatArray, FloatArray]:
    """Modal forces on rotor and casing at a time, by the definition of a load."""
    rotor, casing = 0.0 * loads[0].rotor, 0.0 * loads[0].casing
    for load in loads:
        factor = np.cos(load.frequency * time + load.phase) * (time < load.end)
        if time < load.ramp:
            factor *= 0.5 * (1.0 - np.cos(np.pi * time / load.ramp))
        rotor, casing = rotor + factor * load.rotor, casing + factor * load.casing
    return rotor, casing


def centre_force(stage: Stage, modal: FloatArray) -> FloatArray:
    """The force at the centre that a modal force stands for."""
    return np.asarray(np.linalg.lstsq(stage.rotor.centre.T, modal, rcond=None)[0])


def test_an_imbalance_closes_the_clearance_at_its_speed() -> None:
    """The centre stands on its springs alone: the force is k_o delta, 34.0 kN."""
    stage = with_excitation({"type": "imbalance"}, {"march.speed": 0.95})
    assert imbalance_force(stage) == pytest.approx(34.0e3, rel=1e-9)
    assert unbalance(stage) == pytest.approx(0.59, rel=1e-2)
    faster = with_excitation({"type": "imbalance"}, {"march.speed": 1.9})
    assert imbalance_force(faster) == pytest.approx(4 * 34.0e3, rel=1e-9)
    [load] = excitation_loads(stage)
    assert (load.ramp, load.end, load.frequency) == (0.2, np.inf, 0.0)
    static = load.rotor / stage.rotor.frequency**2
    np.testing.assert_allclose(stage.rotor.centre @ static, [1e-3, 0.0], atol=1e-12)
    outward = stage.rotor.tip_radial @ static
    assert int(outward.argmax()) == 0
    assert outward.max() == pytest.approx(1e-3, rel=1e-9)
    np.testing.assert_allclose(at(excitation_loads(stage), 0.1)[0], 0.5 * load.rotor)


def test_a_given_unbalance_is_taken_as_it_is() -> None:
    values: dict[str, object] = {"type": "imbalance", "unbalance": 0.25, "ramp": 0.0}
    stage = with_excitation(values, {"march.speed": "-100 rad/s"})
    assert unbalance(stage) == 0.25
    assert imbalance_force(stage) == pytest.approx(2500.0)
    force = centre_force(stage, at(excitation_loads(stage), 1.0)[0])
    np.testing.assert_allclose(force, [2500.0, 0.0], atol=1e-6)


def test_a_distortion_moves_the_ring_as_a_rigid_body_on_its_support() -> None:
    """k = 1 of an exact ring is a translation: omega^2 = support / (rho A), mass 2 pi R rho A."""
    stage = with_excitation({"type": "casing-distortion"}, {})
    [load] = excitation_loads(stage)
    line_mass = 7800.0 * 0.1 * 0.01
    amplitude = 1.0 / np.sqrt(2.0 * np.pi * 0.501 * line_mass)
    expected = amplitude * 3e4 / (SUPPORT / line_mass)
    assert expected == pytest.approx(5.9e-3, rel=0.01)
    field = stage.reduced_casing.nodal[:, 0] @ (load.casing / stage.casing_modes.frequency**2)
    np.testing.assert_allclose(
        field, expected * np.cos(stage.casing.mesh.angles), atol=1e-6 * expected
    )
    assert (load.end, load.ramp, load.frequency, load.phase) == (0.15, 0.0, 0.0, 0.0)
    assert not load.rotor.any()


@pytest.mark.parametrize("k", [2, 3, 7, 19, 20])
def test_a_distortion_of_more_nodal_diameters_is_a_cosine_of_inextensional_bending(k: int) -> None:
    """Ring without extension: omega^2 = E I k^2 (k^2 - 1)^2 / (rho A R^4 (k^2 + 1)) + support."""
    stage = base()
    number = radial_mode(stage, k)
    wall = stage.reduced_casing.nodal[:, 0, number]
    wave = np.cos(k * stage.casing.mesh.angles)
    np.testing.assert_allclose(wall, wall[0] * wave, atol=1e-9 * wall[0])
    assert wall[0] > 0.0
    line_mass, bending = 7.8, 2.1e11 * 0.1 * 0.01**3 / 12.0
    square = bending * (k * (k**2 - 1)) ** 2 / (line_mass * 0.501**4 * (k**2 + 1))
    exact = np.sqrt(square + SUPPORT / line_mass)
    # At k = 20 there are two elements a wave.
    tolerance = 0.02 if k < 10 else 0.15
    assert stage.casing_modes.frequency[number] == pytest.approx(exact, rel=tolerance)


def test_a_thick_ring_is_loaded_in_bending_though_stretching_is_lower() -> None:
    stage = base(("casing.wall.thickness", 0.3))
    k = 12
    number = radial_mode(stage, k)
    nodal = stage.reduced_casing.nodal[:, :, number]
    lowest = int(np.flatnonzero(stage.casing_modes.nodal_diameter == k)[0])
    assert number > lowest + 1
    assert np.sum(nodal[:, 0] ** 2) > np.sum(nodal[:, 2] ** 2)
    tangential = stage.reduced_casing.nodal[:, 2, lowest]
    assert np.sum(tangential**2) > np.sum(stage.reduced_casing.nodal[:, 0, lowest] ** 2)


def test_a_half_sine_pulse() -> None:
    values: dict[str, object] = {
        "type": "casing-distortion",
        "shape": "half-sine",
        "duration": 0.02,
        "modal_force": 100.0,
    }
    loads = excitation_loads(with_excitation(values, {}))
    for time in (0.0, 0.004, 0.01, 0.019, 0.0201):
        expected = 100.0 * np.sin(np.pi * time / 0.02) * (time < 0.02)
        assert at(loads, time)[1].max() == pytest.approx(expected, abs=1e-9)


def test_a_pulse_without_duration_is_none() -> None:
    for shape in ("rectangular", "half-sine"):
        values: dict[str, object] = {"type": "casing-distortion", "duration": 0.0, "shape": shape}
        assert excitation_loads(with_excitation(values, {})) == ()
    assert excitation_loads(base()) == ()


def test_a_harmonic_force_in_either_frame() -> None:
    """Turned back into static axes it is F cos(omega t) along x, at any time."""
    values: dict[str, object] = {"type": "harmonic", "force": 700.0, "frequency": 33.0}
    speed: dict[str, object] = {"march.speed": "-40 rad/s"}
    static = with_excitation({**values, "frame": "static"}, speed)
    rotating = with_excitation({**values, "frame": "rotating"}, speed)
    for time in (0.0, 0.0123, 0.4, 1.7):
        size = 700.0 * np.cos(2.0 * np.pi * 33.0 * time)
        force = centre_force(static, at(excitation_loads(static), time)[0])
        angle = -40.0 * time
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        np.testing.assert_allclose(turn @ force, [size, 0.0], atol=1e-8)
        force = centre_force(rotating, at(excitation_loads(rotating), time)[0])
        np.testing.assert_allclose(force, [size, 0.0], atol=1e-8)


RIGID: dict[str, object] = {
    "bladed_disk.blades": 4,
    "bladed_disk.elements_per_blade": 1,
    "bladed_disk.tip_radius": 0.1,
    "bladed_disk.blade.thickness": 0.05,
    "bladed_disk.disk.thickness": 0.05,
    "shaft.stiffness": 1e6,
    "casing.clearance": 0.04,
    "casing.elements": 8,
    "reduction.fixed_interface_modes": 4,
    "damping.ratio": 0.0,
    "march.speed": "300 rad/s",
}
"""A rotor far stiffer than its springs, far from its casing."""


def rigid_mass(stage: Stage) -> float:
    return float(stage.disk.properties.line_mass @ stage.disk.mesh.lengths)


def marched(stage: Stage, duration: float) -> tuple[FloatArray, FloatArray]:
    """Times and displacements of the centre, (records, 2)."""
    step = 1e-6
    scheme = CentralDifference(contact_problem(stage), step, 100)
    _, chunk, end = scheme.advance(scheme.init(), round(duration / step) + 1)
    assert end is None
    return chunk.time, chunk.rotor_displacement @ stage.rotor.centre.T


def test_a_rigid_rotor_under_a_static_harmonic_force() -> None:
    """m x'' + k x = F cos(omega t) R(-Omega t) e_x from rest, solved by hand."""
    values: dict[str, object] = {"type": "harmonic", "force": 700.0, "frequency": 33.0}
    stage = with_excitation(values, RIGID)
    time, found = marched(stage, 0.05)
    mass = rigid_mass(stage)
    natural = np.sqrt(1e6 / mass)
    expected = np.zeros_like(found)
    for rate in (300.0 + 66.0 * np.pi, 300.0 - 66.0 * np.pi):
        size = 0.5 * 700.0 / mass / (natural**2 - rate**2)
        expected[:, 0] += size * (np.cos(rate * time) - np.cos(natural * time))
        expected[:, 1] -= size * (np.sin(rate * time) - rate / natural * np.sin(natural * time))
    assert abs(expected).max() > 1e-4
    np.testing.assert_allclose(found, expected, atol=1e-4 * abs(expected).max())


def test_a_rigid_rotor_set_off_by_initial_values() -> None:
    """x(t) = x_0 cos(omega t) + v_0 / omega sin(omega t): all of the rotor moves together."""
    centre = {"displacement": np.array([1e-3, -2e-3]), "velocity": np.array([0.5, 0.8])}
    angles = 2.0 * np.pi * np.arange(4) / 4
    values: dict[str, object] = dict(RIGID)
    for name, (x, y) in centre.items():
        values[f"initial.centre_{name}"] = (float(x), float(y))
        values[f"initial.tip_{name}"] = tuple(
            (float(x * c + y * s), float(y * c - x * s))
            for c, s in zip(np.cos(angles), np.sin(angles), strict=True)
        )
    stage = base(*values.items())
    time, found = marched(stage, 0.05)
    natural = np.sqrt(1e6 / rigid_mass(stage))
    expected = np.cos(natural * time)[:, None] * centre["displacement"]
    expected += np.sin(natural * time)[:, None] * centre["velocity"] / natural
    # The rim is a polygon and roots turn with the rotor only nearly: shapes are rigid to 1e-4.
    np.testing.assert_allclose(found, expected, atol=2e-4 * abs(expected).max())


@pytest.mark.parametrize("clamped", [False, True])
def test_initial_values_are_met_by_the_static_shape(clamped: bool) -> None:
    rng = np.random.default_rng(3)
    tips, speeds = 1e-4 * rng.normal(size=(2, 22, 2))
    centre = (0.0, 0.0) if clamped else (2e-4, -3e-4)
    stage = base(
        ("shaft.clamped", clamped),
        ("initial.tip_displacement", tuple(map(tuple, tips.tolist()))),
        ("initial.tip_velocity", tuple(map(tuple, speeds.tolist()))),
        ("initial.centre_displacement", centre),
    )
    start, rotor = initial_state(stage), stage.rotor
    np.testing.assert_allclose(rotor.tip_radial @ start.rotor, tips[:, 0], atol=1e-12)
    np.testing.assert_allclose(rotor.tip_tangential @ start.rotor, tips[:, 1], atol=1e-12)
    np.testing.assert_allclose(rotor.centre @ start.rotor, centre, atol=1e-12)
    np.testing.assert_allclose(rotor.tip_radial @ start.rotor_velocity, speeds[:, 0], atol=1e-12)
    np.testing.assert_allclose(
        rotor.tip_tangential @ start.rotor_velocity, speeds[:, 1], atol=1e-12
    )
    np.testing.assert_allclose(rotor.centre @ start.rotor_velocity, 0.0, atol=1e-12)
    assert not start.casing.any()
    assert not start.casing_velocity.any()
    # The full model, held at the boundary and left to itself inside.
    stiffness = stage.disk.structure.stiffness.toarray()
    boundary = np.concatenate([*stage.boundary_sets.values()])
    inside = np.setdiff1d(np.arange(len(stiffness)), boundary)
    values = np.concatenate([tips[:, 0], tips[:, 1], [] if clamped else centre])
    expected = -np.linalg.solve(
        stiffness[np.ix_(inside, inside)], stiffness[np.ix_(inside, boundary)] @ values
    )
    field = stage.reduction.modes.shapes @ start.rotor
    np.testing.assert_allclose(field[inside], expected, atol=1e-7 * abs(expected).max())


def test_without_initial_values_a_march_starts_at_rest() -> None:
    start = initial_state(base())
    assert not any(x.any() for x in (start.rotor, start.rotor_velocity))
