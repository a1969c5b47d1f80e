"""Equations of a shaft line: statics, whirl, critical speeds, unbalance response, sag."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg as la

from bladewhirl.models.case.case import case_from
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.shaft_line.elements import cowper
from bladewhirl.models.shaft_line.line import LineModel, line_model
from bladewhirl.models.shaft_line.whirl import (
    line_critical_speeds,
    line_modes,
    sag,
    unbalance_response,
)

E, RHO, G0 = 2.1e11, 7800.0, 9.81
SHAFT: dict[str, Any] = {"length": 1.0, "outer_diameter": 0.05, "elements": 8}
DISK: dict[str, Any] = {
    "position": 0.4,
    "mass": 20.0,
    "polar_inertia": 0.3,
    "diametral_inertia": 0.16,
}
ENDS = tuple({"position": z, "stiffness": 2e7, "damping": 3e2} for z in (0.0, 1.0))
UNEQUAL = (
    {"position": 0.1, "stiffness": [[2e7, 1e6], [-2e6, 1e7]], "damping": [[2e3, 80.0], [0.0, 5e2]]},
    {
        "position": 0.9,
        "stiffness": 3e7,
        "damping": 1e3,
        "support": {"mass": 12.0, "stiffness": [[6e7, 0.0], [0.0, 3e7]], "damping": 2e3},
    },
)


def line_of(**tables: Any) -> LineModel:
    """Equations of a line with defaults for the parts that are not given."""
    line = {"segments": [SHAFT], "disks": [DISK], "bearings": ENDS} | tables
    gravity = {"gravity": {"acceleration": [0.0, -G0]}}
    return line_model(case_from({"shaft_line": line} | gravity))


def test_a_force_on_a_cantilever_bends_and_shears_it_exactly() -> None:
    """F L^3 / (3 E I) + F L / (kappa G A) at the end, with one element."""
    held = {"position": 0.0, "stiffness": 1e14, "tilt_stiffness": 1e14}
    line = line_of(segments=[SHAFT | {"elements": 1}], disks=[], bearings=[held])
    force = np.zeros(line.size, dtype=complex)
    force[2 * line.node(1.0)] = 1.0
    moved = np.linalg.solve(line.shaft_stiffness + line.stiffness[0], force)[2]
    inertia, area = np.pi * 0.05**4 / 64.0, np.pi * 0.05**2 / 4.0
    sheared = cowper(0.0, 0.3) * E / 2.6 * area
    assert moved.real == pytest.approx(1.0 / (3.0 * E * inertia) + 1.0 / sheared, rel=1e-9)


def test_a_tapered_segment_is_a_shaft_of_many_steps() -> None:
    taper = SHAFT | {"end_outer_diameter": 0.08, "elements": 16}
    edges = np.linspace(0.05, 0.08, 65)
    steps = [
        {"length": 1.0 / 64.0, "outer_diameter": float(d), "elements": 1}
        for d in 0.5 * (edges[1:] + edges[:-1])
    ]
    one, many = (line_modes(line_of(segments=s), 300.0, 6) for s in ([taper], steps))
    assert one.eigenvalue.imag == pytest.approx(many.eigenvalue.imag, rel=5e-4)


@pytest.mark.parametrize("bearings", [ENDS, UNEQUAL])
def test_the_mirror_image_whirls_the_other_way(bearings: Any) -> None:
    """Reversing the speed and the cross terms mirrors all eigenvalues, modes and responses."""

    def mirrored(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: mirrored(item) for key, item in value.items()}
        if isinstance(value, list):
            (xx, xy), (yx, yy) = value
            return [[xx, -xy], [-yx, yy]]
        return value

    unbalance = [{"position": 0.4, "unbalance": 1e-3, "phase": 0.4, "couple": 1e-4}]
    back = [{**unbalance[0], "phase": -0.4}]
    one = line_of(bearings=bearings, unbalance=unbalance)
    other = line_of(bearings=[mirrored(each) for each in bearings], unbalance=back)
    modes, images = line_modes(one, 400.0, 8), line_modes(other, -400.0, 8)
    assert images.eigenvalue == pytest.approx(modes.eigenvalue, rel=1e-9)
    assert images.direction == modes.direction
    motion = unbalance_response(one, 400.0)
    image = unbalance_response(other, -400.0)
    # z = f e^(i W t) + b e^(-i W t) becomes its conjugate
    assert image[0] == pytest.approx(motion[0].conj(), rel=1e-9, abs=1e-15)
    assert image[1] == pytest.approx(motion[1].conj(), rel=1e-9, abs=1e-15)


def test_internal_damping_makes_forward_whirl_grow_above_the_critical_speed() -> None:
    """On rigid bearings, s^2 + t w^2 (s - i W) + w^2 = 0 for a disk without rotary inertia on a
    massless shaft with the loss time t."""
    light = {"young_modulus": E, "density": 1e-3}
    loss, rigid = 1e-5, [{"position": z, "stiffness": 1e13} for z in (0.0, 1.0)]
    disk = DISK | {"position": 0.5, "polar_inertia": 0.0, "diametral_inertia": 0.0}
    table = {"segments": [SHAFT], "disks": [disk], "bearings": rigid, "loss_time": loss}
    line = line_model(case_from({"material": light, "shaft_line": table}))
    w = line.reference_frequency
    for ratio in (0.5, 0.99, 1.01, 2.0):
        omega = ratio * w
        modes = line_modes(line, omega, 2)
        forward = np.roots([1.0, loss * w**2, w**2 - 1j * loss * w**2 * omega])
        expected = forward[forward.imag.argmax()]
        mine = modes.eigenvalue[modes.direction.index("forward")]
        assert mine == pytest.approx(expected, rel=1e-6)
        assert (mine.real > 0.0) == (ratio > 1.0)


def test_critical_speeds_of_a_round_line_are_roots_of_its_synchronous_equations() -> None:
    """K f = W^2 (M - P) f for forward whirl and K f = W^2 (M + P) f for backward whirl."""
    bearings = [{"position": z, "stiffness": 2e7} for z in (0.0, 1.0)]
    line = line_of(bearings=bearings)
    stiffness = (line.shaft_stiffness + line.stiffness[0]).real
    found = line_critical_speeds(line, 8)
    for direction, sign in (("forward", -1.0), ("backward", 1.0)):
        squares = la.eigvals(stiffness, line.mass + sign * line.polar)
        real = squares[(np.abs(squares.imag) < 1e-6 * np.abs(squares)) & (squares.real > 0.0)]
        expected = np.sort(np.sqrt(real.real))
        mine = found.speed[np.equal(found.direction, direction)]
        assert len(mine) >= 2
        assert mine == pytest.approx(expected[: len(mine)], rel=1e-9)


def test_an_unbalance_turns_a_rigid_rotor_about_its_centre_of_mass_far_above() -> None:
    """Far above all critical speeds of its soft bearings, a stiff rotor moves by -m e / m."""
    stiff = SHAFT | {"outer_diameter": 0.2}
    soft = [{"position": z, "stiffness": 1e3, "damping": 1.0} for z in (0.0, 1.0)]
    unbalance = [{"position": 0.5, "unbalance": 1e-3, "phase": 0.3}]
    disk = DISK | {"position": 0.5}
    line = line_of(segments=[stiff], disks=[disk], bearings=soft, unbalance=unbalance)
    left, right = unbalance_response(line, 100.0)
    moving = np.zeros(line.size)
    moving[::2] = 1.0
    mass = moving @ line.mass @ moving
    expected = -1e-3 * np.exp(0.3j) / mass
    assert left[2 * line.node(0.5)] == pytest.approx(expected, rel=2e-3)
    assert np.abs(right).max() < 1e-9 * np.abs(left).max()


def test_a_couple_works_on_the_tilt_of_its_node() -> None:
    """On a rigid motion that moves by z and tilts by 1, which strains nothing."""
    unbalance = [{"position": 0.4, "unbalance": 1e-3, "couple": 2e-5, "couple_phase": 0.3}]
    line = line_of(bearings=UNEQUAL, unbalance=unbalance)
    rigid = np.ones(line.size)
    rigid[::2][: len(line.position)] = line.position
    strained = np.abs(line.shaft_stiffness @ rigid).max()
    assert strained < 1e-9 * np.abs(line.shaft_stiffness).max()
    force = line.unbalance_force(line.table.unbalance)
    assert rigid @ force == pytest.approx(0.4e-3 + 2e-5 * np.exp(0.3j), rel=1e-12)


def test_the_response_follows_from_integration_in_time() -> None:
    """The steady motion satisfies the equations of motion at any instant."""
    unbalance = [{"position": 0.4, "unbalance": 1e-3, "phase": 0.4, "couple": 2e-5}]
    line, omega, t = line_of(bearings=UNEQUAL, unbalance=unbalance), 350.0, 0.0123
    left, right = unbalance_response(line, omega)
    turn = np.exp(1j * omega * t)
    z = left * turn + right / turn
    rate = 1j * omega * (left * turn - right / turn)
    polar = line.polar @ rate
    inner = line.shaft_stiffness @ z + line.stiffness[0] @ z + line.stiffness[1] @ z.conj()
    damped = line.damping[0] @ rate + line.damping[1] @ rate.conj() - 1j * omega * polar
    force = omega**2 * line.unbalance_force(line.table.unbalance) * turn
    rest = line.mass @ (-(omega**2) * z) + damped + inner - force
    assert np.abs(rest).max() < 1e-8 * np.abs(force).max()


@pytest.mark.parametrize("omega", [0.0, 300.0])
def test_bearings_carry_the_weight(omega: float) -> None:
    """Forces and moments of bearings and weights are in balance, whatever the bearings."""
    line = line_of(bearings=UNEQUAL)
    forces = line.bearing_force(sag(line, omega), np.zeros(line.size, dtype=complex))
    mass = RHO * np.pi / 4.0 * 0.05**2
    assert forces.sum() == pytest.approx(1j * G0 * (20.0 + mass), rel=1e-8)
    moment = (forces * np.array([0.1, 0.9])).sum()
    assert moment == pytest.approx(1j * G0 * (20.0 * 0.4 + mass * 0.5), rel=1e-8)


def test_only_internal_damping_turns_the_sag_sideways() -> None:
    plain, lossy = line_of(), line_of(loss_time=1e-4)
    at_rest, turning = sag(plain, 0.0), sag(plain, 500.0)
    assert turning == pytest.approx(at_rest, rel=1e-9, abs=1e-15)
    middle = 2 * lossy.node(0.4)
    aside = sag(lossy, 500.0)[middle] - turning[middle]
    assert aside.real > 1e-3 * abs(turning[middle])  # down and, for W > 0, to +x


@pytest.mark.parametrize(
    ("tables", "key"),
    [
        ({"bearings": [{"position": 0.2, "stiffness": 1e7}]}, "shaft_line.bearings"),
        ({"bearings": [{"position": 2.0, "stiffness": 1e7}]}, "shaft_line.bearings[0].position"),
        ({"segments": []}, "shaft_line.segments"),
        ({"segments": [SHAFT | {"inner_diameter": 0.05}]}, "shaft_line.segments[0].inner_diameter"),
        ({"disks": [DISK | {"polar_inertia": 0.4}]}, "shaft_line.disks[0].polar_inertia"),
        ({"unbalance": [{"position": 0.2}]}, "shaft_line.unbalance[0].unbalance"),
    ],
)
def test_a_line_that_is_not_held_or_not_possible_is_refused(tables: Any, key: str) -> None:
    with pytest.raises(CaseError) as error:
        line_of(**tables)
    assert key in {fault.key for fault in error.value.faults}
