"""Loads and initial values: closed forms, full statics, marches of a rigid rotor."""

import numpy as np
import pytest
from stages import stage

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.excitations import excitation_loads, radial_mode
from bladewhirl.models.stage.loads import (
    imbalance_force,
    initial_state,
    unbalance,
)
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.varying_speed import Rotation

SUPPORT = 7.975e6
"""Casing support of the contact cases [N/m2]."""


def on_support(*overrides: str) -> Beams:
    return stage(f"casing.support={SUPPORT}", *overrides)


def at(loads: tuple[Load, ...], time: float) -> tuple[FloatArray, FloatArray]:
    """Modal forces on rotor and casing at a time, by the definition of a load."""
    rotor, casing = 0.0 * loads[0].rotor, 0.0 * loads[0].casing
    for load in loads:
        factor = np.cos(load.frequency * time + load.phase) * (time < load.end)
        if time < load.ramp:
            factor *= 0.5 * (1.0 - np.cos(np.pi * time / load.ramp))
        rotor, casing = rotor + factor * load.rotor, casing + factor * load.casing
    return rotor, casing


def centre_force(given: Beams, modal: FloatArray) -> FloatArray:
    """The force at the centre that a modal force stands for."""
    return np.asarray(np.linalg.lstsq(given.rotor.centre.T, modal, rcond=None)[0])


def test_an_imbalance_has_an_angle_and_follows_a_speed_that_varies() -> None:
    turned = ("excitation.type=imbalance", "excitation.unbalance=0.2", "excitation.phase=0.7")
    stage = on_support(*turned)
    centre, force = stage.rotor.centre, 0.2 * stage.speed**2
    [load] = excitation_loads(stage)
    np.testing.assert_allclose(
        load.rotor, force * (np.cos(0.7) * centre[0] + np.sin(0.7) * centre[1]), atol=1e-9 * force
    )
    varying = on_support(*turned, "march.speed_table=[[0.0, 0.5], [1.0, 1.5]]")
    outward, around = excitation_loads(varying)
    speed, rate = 0.8 * varying.speed, 30.0
    acting = sum(
        each.amplitude(1.0, Rotation(0.0, speed, rate), varying.speed) * each.rotor
        for each in (outward, around)
    )
    mass = 0.2 * np.exp(0.7j)
    inertia = mass * (speed**2 - 1j * rate)  # minus m times the acceleration of e exp(i psi)
    expected = inertia.real * centre[0] + inertia.imag * centre[1]
    np.testing.assert_allclose(acting, expected, atol=1e-9 * np.abs(expected).max())


def test_an_imbalance_closes_the_clearance_at_its_speed() -> None:
    """The centre stands on its springs alone: the force is k_o delta, 34.0 kN."""
    slow, fast = (on_support("excitation.type=imbalance", f"march.speed={v}") for v in (0.95, 1.9))
    assert imbalance_force(slow) == pytest.approx(34.0e3, rel=1e-9)
    assert unbalance(slow) == pytest.approx(0.59, rel=1e-2)
    assert imbalance_force(fast) == pytest.approx(4 * 34.0e3, rel=1e-9)
    [load] = excitation_loads(slow)
    assert (load.ramp, load.end, load.frequency) == (0.2, np.inf, 0.0)
    static = load.rotor / slow.rotor.frequency**2
    np.testing.assert_allclose(slow.rotor.centre @ static, [1e-3, 0.0], atol=1e-12)
    outward = slow.rotor.tip_radial @ static
    assert int(outward.argmax()) == 0
    assert outward.max() == pytest.approx(1e-3, rel=1e-9)
    np.testing.assert_allclose(at((load,), 0.1)[0], 0.5 * load.rotor)


def test_a_given_unbalance_is_taken_as_it_is() -> None:
    load = 'excitation={type="imbalance", unbalance=0.25, ramp=0.0}'
    given = on_support(load, "march.speed=-100 rad/s")
    assert unbalance(given) == 0.25
    assert imbalance_force(given) == pytest.approx(2500.0)
    force = centre_force(given, at(excitation_loads(given), 1.0)[0])
    np.testing.assert_allclose(force, [2500.0, 0.0], atol=1e-6)


BALANCED = 'balance={grade="G 6.3", mass="100 kg", speed="3000 rpm"}'


@pytest.mark.parametrize(
    ("given", "size", "degrees"),
    [
        ('unbalance="590 g mm", phase="30 deg"', 5.9e-4, 30.0),
        (f"{BALANCED}, blade=3", 6.3e-3 * 100.0 / (100.0 * np.pi), 3 * 360.0 / 22),
        ('unbalance="1 g m", blade=3, phase="-20 deg"', 1e-3, 3 * 360.0 / 22 - 20.0),
    ],
)
def test_an_imbalance_points_where_it_is_said_to(given: str, size: float, degrees: float) -> None:
    made = on_support(f'excitation={{type="imbalance", {given}}}', "march.speed=1.1")
    (load,) = excitation_loads(made)
    angle = np.radians(degrees)
    force = size * made.speed**2 * np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(centre_force(made, load.rotor), force, atol=1e-9 * abs(force).max())
    assert unbalance(made) == pytest.approx(size, rel=1e-12)


def test_the_clearance_closes_at_the_blade_of_an_imbalance_and_opposite_ones_cancel() -> None:
    one = '{type="imbalance", clearance_speed=0.95, blade=5}'
    given = on_support(f"excitation={one}", "march.speed=0.95")
    outward = given.rotor.tip_radial @ (excitation_loads(given)[0].rotor / given.rotor.frequency**2)
    assert int(outward.argmax()) == 5
    assert outward.max() == pytest.approx(1e-3, rel=1e-9)
    two = ", ".join(f'{{type="imbalance", unbalance=0.1, phase={phase}}}' for phase in (1.0, -1.0))
    assert unbalance(on_support(f"excitation=[{two}]")) == pytest.approx(
        0.2 * np.cos(1.0), rel=1e-12
    )


def test_a_distortion_moves_the_ring_as_a_rigid_body_on_its_support() -> None:
    """k = 1 of an exact ring is a translation: omega^2 = support / (rho A), mass 2 pi R rho A."""
    given = on_support("excitation.type=casing-distortion")
    [load] = excitation_loads(given)
    line_mass = 7800.0 * 0.1 * 0.01
    amplitude = 1.0 / np.sqrt(2.0 * np.pi * 0.501 * line_mass)
    expected = amplitude * 3e4 / (SUPPORT / line_mass)
    assert expected == pytest.approx(5.9e-3, rel=0.01)
    field = given.reduced_casing.nodal[:, 0] @ (load.casing / given.casing_modes.frequency**2)
    np.testing.assert_allclose(
        field, expected * np.cos(given.casing.mesh.angles), atol=1e-6 * expected
    )
    assert (load.end, load.ramp, load.frequency, load.phase) == (0.15, 0.0, 0.0, 0.0)
    assert not load.rotor.any()


@pytest.mark.parametrize("k", [2, 3, 7, 19, 20])
def test_a_distortion_of_more_nodal_diameters_is_a_cosine_of_inextensional_bending(k: int) -> None:
    """Ring without extension: omega^2 = E I k^2 (k^2 - 1)^2 / (rho A R^4 (k^2 + 1)) + support."""
    given = on_support()
    number = radial_mode(given, k)
    wall = given.reduced_casing.nodal[:, 0, number]
    wave = np.cos(k * given.casing.mesh.angles)
    np.testing.assert_allclose(wall, wall[0] * wave, atol=1e-9 * wall[0])
    assert wall[0] > 0.0
    line_mass, bending = 7.8, 2.1e11 * 0.1 * 0.01**3 / 12.0
    square = bending * (k * (k**2 - 1)) ** 2 / (line_mass * 0.501**4 * (k**2 + 1))
    exact = np.sqrt(square + SUPPORT / line_mass)
    # At k = 20 there are two elements a wave.
    tolerance = 0.02 if k < 10 else 0.15
    assert given.casing_modes.frequency[number] == pytest.approx(exact, rel=tolerance)


def test_a_thick_ring_is_loaded_in_bending_though_stretching_is_lower() -> None:
    thick, k = on_support("casing.wall.thickness=0.3"), 12
    number = radial_mode(thick, k)
    lowest = int(np.flatnonzero(thick.casing_modes.nodal_diameter == k)[0])
    assert number > lowest + 1
    size = np.sum(thick.reduced_casing.nodal**2, axis=0)  # of w, w', u, u' by mode
    assert size[0, number] > size[2, number]
    assert size[2, lowest] > size[0, lowest]


def test_a_half_sine_pulse() -> None:
    pulse = 'type="casing-distortion", shape="half-sine", duration=0.02, modal_force=100.0'
    loads = excitation_loads(on_support(f"excitation={{{pulse}}}"))
    for time in (0.0, 0.004, 0.01, 0.019, 0.0201):
        expected = 100.0 * np.sin(np.pi * time / 0.02) * (time < 0.02)
        assert at(loads, time)[1].max() == pytest.approx(expected, abs=1e-9)


def test_a_pulse_without_duration_is_none() -> None:
    for shape in ("rectangular", "half-sine"):
        pulse = f'type="casing-distortion", duration=0.0, shape="{shape}"'
        assert excitation_loads(on_support(f"excitation={{{pulse}}}")) == ()
    assert excitation_loads(on_support()) == ()


HARMONIC = 'excitation={type="harmonic", force=700.0, frequency=33.0}'


def test_a_harmonic_force_in_either_frame() -> None:
    """Turned back into static axes it is F cos(omega t) along x, at any time."""
    static, rotating = (
        on_support(HARMONIC, f"excitation.frame={frame}", "march.speed=-40 rad/s")
        for frame in ("static", "rotating")
    )
    for time in (0.0, 0.0123, 0.4, 1.7):
        size = 700.0 * np.cos(2.0 * np.pi * 33.0 * time)
        force = centre_force(static, at(excitation_loads(static), time)[0])
        angle = -40.0 * time
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        np.testing.assert_allclose(turn @ force, [size, 0.0], atol=1e-8)
        force = centre_force(rotating, at(excitation_loads(rotating), time)[0])
        np.testing.assert_allclose(force, [size, 0.0], atol=1e-8)


@pytest.mark.slow
def test_excitations_of_a_list_act_together_and_a_list_of_one_changes_nothing() -> None:
    tables = [
        '{type = "casing-distortion"}',
        '{type = "engine-order", order = 4}',
        '{type = "imbalance", unbalance = 0.2}',
        '{type = "imbalance", unbalance = 0.3}',
    ]
    together = on_support(f"excitation=[{','.join(tables)}]")
    alone = [excitation_loads(on_support(f"excitation=[{table}]")) for table in tables]
    singles = [excitation_loads(on_support(f"excitation={table}")) for table in tables]
    for loads in (alone, singles):
        each = [load for part in loads for load in part]
        for load, other in zip(excitation_loads(together), each, strict=True):
            np.testing.assert_array_equal(load.rotor, other.rotor)
            np.testing.assert_array_equal(load.casing, other.casing)
            assert (load.end, load.ramp, load.frequency) == (other.end, other.ramp, other.frequency)
    assert unbalance(together) == 0.5


@pytest.mark.parametrize("clamped", [False, True])
def test_initial_values_are_met_by_the_static_shape(clamped: bool) -> None:
    rng = np.random.default_rng(3)
    tips, speeds = 1e-4 * rng.normal(size=(2, 22, 2))
    centre = (0.0, 0.0) if clamped else (2e-4, -3e-4)
    given = on_support(
        f"shaft.clamped={str(clamped).lower()}",
        f"initial.tip_displacement={tips.tolist()}",
        f"initial.tip_velocity={speeds.tolist()}",
        f"initial.centre_displacement={[*centre]}",
    )
    start, rotor = initial_state(given), given.rotor
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
    stiffness = given.disk.structure.stiffness.toarray()
    boundary = np.concatenate([*given.boundary_sets.values()])
    inside = np.setdiff1d(np.arange(len(stiffness)), boundary)
    values = np.concatenate([tips[:, 0], tips[:, 1], [] if clamped else centre])
    expected = -np.linalg.solve(
        stiffness[np.ix_(inside, inside)], stiffness[np.ix_(inside, boundary)] @ values
    )
    field = given.reduction.modes.shapes @ start.rotor
    np.testing.assert_allclose(field[inside], expected, atol=1e-7 * abs(expected).max())
