"""Coupled modes in time, against the periodic equations and fields drawn point by point."""

from dataclasses import replace

import numpy as np
import pytest
from coupled_system import UNIT, six_modes
from scipy.integrate import solve_ivp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.solvers.stability.coupled_modes import (
    CoupledMotion,
    RadialShapes,
    coupled_modes,
    coupled_motion,
    modal_response,
    phase_rate,
    wave_coefficient,
)
from bladewhirl.solvers.stability.growth import growth_rate

SPEED, KAPPA = 1.17 * UNIT, 500.0
CLEARANCE = 1e-3

CASING, TIP, CENTRE = 0.2018, (0.010876, 0.10521), (0.010875, 0.10503)
"""Amplitudes of the casing, of tips and centre in 1F and suspension modes [kg^-1/2]."""


def shapes(blades: int = 22, stations: int = 40) -> RadialShapes:
    """Tips and casing that follow cosines, a centre that moves with them."""
    tip_angle = 2.0 * np.pi * np.arange(blades) / blades
    casing_angle = 2.0 * np.pi * np.arange(stations) / stations
    tips, casing = np.zeros((blades, 6)), np.zeros((stations, 6))
    centre = np.zeros((2, 6))
    casing[:, 0], casing[:, 1] = CASING * np.cos(casing_angle), CASING * np.sin(casing_angle)
    for first, tip, shaft in zip((2, 4), TIP, CENTRE, strict=True):
        tips[:, first], tips[:, first + 1] = tip * np.cos(tip_angle), tip * np.sin(tip_angle)
        centre[0, first] = centre[1, first + 1] = shaft
    return RadialShapes(
        centre=centre, tips=tips, tip_angle=tip_angle, casing=casing, casing_angle=casing_angle
    )


def growing_motion() -> CoupledMotion:
    mode = coupled_modes(six_modes(), speed=SPEED, kappa=KAPPA)[0]
    return coupled_motion(
        mode, time=np.linspace(0.0, 0.2, 2001), shapes=shapes(), clearance=CLEARANCE
    )


@pytest.mark.slow
@pytest.mark.parametrize("damping_ratio", [0.0, 0.01])
def test_response_obeys_the_periodic_equations(damping_ratio: float) -> None:
    modes = six_modes(damping_ratio)
    damping = modes.damping_rate[modes.entry]

    def rate(time: float, state: FloatArray) -> FloatArray:
        x, v = np.split(state, 2)
        k_t = modes.equations.stiffness(SPEED * time, KAPPA)
        return np.concatenate([v, -k_t @ x - damping * v])

    time = np.linspace(0.0, 0.03, 4)
    for mode in coupled_modes(modes, speed=SPEED, kappa=KAPPA):
        u, velocity = modal_response(mode, time)
        start = np.concatenate([u[0], velocity[0]])
        march = solve_ivp(
            rate, (0.0, time[-1]), start, "DOP853", t_eval=time, rtol=1e-11, atol=1e-11
        )
        assert march.y[:6].T == pytest.approx(u, abs=1e-7 * np.abs(u).max())
        assert march.y[6:].T == pytest.approx(velocity, abs=1e-7 * np.abs(velocity).max())


def test_modes_are_complete_and_the_growing_one_is_first() -> None:
    """Three types coexist: oscillatory, damped and divergent modes (claim 12)."""
    actual = coupled_modes(six_modes(), speed=SPEED, kappa=KAPPA)
    assert len(actual) == 6
    growth = np.array([mode.eigenvalue.real for mode in actual])
    assert growth[0] == pytest.approx(
        float(growth_rate(six_modes(), speed=SPEED, kappa=KAPPA)), rel=1e-9
    )
    assert growth[-1] == pytest.approx(-growth[0])
    assert growth[1:-1] == pytest.approx(0.0, abs=1e-9)


def test_waves_run_backward_on_the_rotor_and_forward_on_the_casing() -> None:
    """Claim 15: and growing backward whirl in the rotating frame is forward in the static one."""
    motion = growing_motion()
    assert motion.rotor_wave_speed == pytest.approx(-UNIT, rel=0.02)
    assert motion.whirl_speed == pytest.approx(motion.rotor_wave_speed, rel=1e-9)
    assert 0.0 < motion.casing_wave_speed < 0.3 * UNIT
    assert motion.whirl_speed_static == pytest.approx(motion.casing_wave_speed, rel=1e-9)
    assert motion.whirl_speed_static == pytest.approx(motion.whirl_speed + SPEED, rel=1e-9)
    radius = np.linalg.norm(motion.shaft, axis=1)
    growth = float(growth_rate(six_modes(), speed=SPEED, kappa=KAPPA))
    assert np.log(radius[-1] / radius[0]) / 0.2 == pytest.approx(growth, rel=1e-6)


def test_clearance_closes_at_the_end_and_where_it_is_said_to() -> None:
    motion = growing_motion()
    theta = np.linspace(0.0, 2.0 * np.pi, 100_000, endpoint=False)
    for record in (0, 700, 2000):
        v_c, v_s, u_c, u_s, o_c, o_s = motion.displacement[record]
        alpha = theta - SPEED * motion.time[record]
        gap = CLEARANCE + CASING * (v_c * np.cos(theta) + v_s * np.sin(theta))
        gap -= (TIP[0] * u_c + TIP[1] * o_c) * np.cos(alpha)
        gap -= (TIP[0] * u_s + TIP[1] * o_s) * np.sin(alpha)
        expected = theta[np.argmin(gap)]
        angle = motion.smallest_clearance_angle[record]
        assert np.angle(np.exp(1j * (angle - expected))) == pytest.approx(0.0, abs=1e-4)
        assert gap.min() == pytest.approx(CLEARANCE - np.abs(motion.stretch[record]), abs=1e-12)
    assert gap.min() == pytest.approx(0.0, abs=1e-12)


def test_shaft_keeps_its_angle_to_the_smallest_clearance() -> None:
    motion = growing_motion()
    x, y = motion.shaft_static.T
    lead = np.arctan2(y, x) - motion.smallest_clearance_angle
    assert np.exp(1j * motion.shaft_lead) == pytest.approx(np.exp(1j * lead))
    assert np.ptp(motion.shaft_lead) < 1e-6
    assert np.degrees(motion.shaft_lead[0]) == pytest.approx(-105.8, abs=0.5)


def test_waves_of_more_nodal_diameters_move_no_shaft() -> None:
    modes = replace(six_modes(), nodal_diameter=np.full(3, 2))
    mode = coupled_modes(modes, speed=0.5 * SPEED, kappa=KAPPA)[0]
    one = shapes()
    tip_angle, casing_angle = 2.0 * one.tip_angle, 2.0 * one.casing_angle
    two = replace(
        one,
        centre=np.zeros((2, 6)),
        tips=np.stack([f(tip_angle) * a for a in (0, *TIP) for f in (np.cos, np.sin)], axis=-1),
        casing=np.stack(
            [f(casing_angle) * a for a in (CASING, 0, 0) for f in (np.cos, np.sin)], axis=-1
        ),
    )
    motion = coupled_motion(mode, time=np.linspace(0.0, 0.2, 500), shapes=two, clearance=CLEARANCE)
    assert motion.nodal_diameter == 2
    assert np.all(motion.shaft == 0.0)
    # The crest on the rotor moves by half of its phase, and meets the casing's.
    assert motion.rotor_wave_speed == pytest.approx(-0.5 * UNIT, rel=0.02)
    assert motion.rotor_wave_speed + 0.5 * SPEED == pytest.approx(motion.casing_wave_speed)
    assert CLEARANCE == pytest.approx(np.abs(motion.stretch[-1]))
    angle = motion.smallest_clearance_angle
    closing = -(motion.stretch * np.exp(-2j * angle)).real  # at that angle, and half a turn on
    assert closing == pytest.approx(np.abs(motion.stretch))
    assert np.polyfit(motion.time, angle, 1)[0] == pytest.approx(motion.casing_wave_speed, rel=0.02)


def test_mode_that_leaves_the_clearance_alone_is_refused() -> None:
    mode = coupled_modes(six_modes(), speed=SPEED, kappa=KAPPA)[0]
    still = replace(shapes(), tips=np.zeros((22, 6)), casing=np.zeros((40, 6)))
    with pytest.raises(ValueError, match="does not change the clearance"):
        coupled_motion(mode, time=np.linspace(0.0, 0.1, 9), shapes=still, clearance=CLEARANCE)


@pytest.mark.parametrize(("count", "k"), [(22, 0), (22, 3), (22, 11), (21, 10)])
def test_wave_coefficient_of_a_known_field(count: int, k: int) -> None:
    angle = 2.0 * np.pi * np.arange(count) / count
    single = k in (0, count / 2)
    exact = 0.7 if single else 0.7 * np.exp(0.4j)
    field = (exact * np.exp(-1j * k * angle)).real + 5.0 * np.cos(2.0 * angle)
    assert wave_coefficient(field, angle, k) == pytest.approx(exact, abs=1e-14)


def test_phase_rate_of_a_spiral() -> None:
    time = np.linspace(0.0, 3.0, 200)
    assert phase_rate(time, np.exp((0.4 - 9.0j) * time)) == pytest.approx(-9.0)
