"""Growth of parametrically coupled modes: Mathieu's equation, and the paper's coupled modes."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.coupling.springs import CoupledEntries, CouplingModes
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.solvers.stability.floquet import Floquet, floquet
from bladewhirl.solvers.stability.growth import coincidence_speeds, growth_rate
from bladewhirl.solvers.stability.zones import UnstableZones, unstable_zones
from bladewhirl.studies.modal.coupled_system import EvenSystem, couple
from bladewhirl.studies.verification.bodies import marched
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies

KAPPA = 500.0  #: stiffness of the coupling springs at the example point [N/m]
POINT = {"march.speed": 1.17, "coupling.stiffness": KAPPA, "reduction.modes": "six"}
"""The paper's example point, Figs 11 and 14."""

DAMPED = ("0.0", "0.005")
MATHIEU = {"a0": mathieu_a(0, 1.0), "b1": mathieu_b(1, 1.0), "a1": mathieu_a(1, 1.0)} | {
    "b2": mathieu_b(2, 1.0),
    "a2": mathieu_a(2, 1.0),
}
"""Stability limits a of x'' + (a - 2 q cos 2t) x = 0 at q = 1."""


@verifies(*MATHIEU)
def mathieu_border(name: str) -> Pair:
    """Compare a stability limit of the Mathieu equation with the characteristic value of SciPy."""
    trace, exact = (-2.0 if name[1] == "1" else 2.0), MATHIEU[name]

    def excess(a: float) -> float:
        computed = floquet(
            lambda times: (a - 2.0 * np.cos(2.0 * times))[:, None, None], period=np.pi
        )
        return float(np.trace(computed.monodromy)) - trace

    return exact, brentq(excess, exact - 0.1, exact + 0.1, xtol=1e-13)


@cache
def coupled(ratio: str) -> tuple[ContactProblem, CouplingModes]:
    """Return the paper's six modes at its example point, as a contact problem and with names."""
    push = {"initial.centre_velocity": [1e-6, 0.0], "damping.ratio": float(ratio)}
    given, coupling = on_springs(POINT | push)
    return given, coupling.modes


def on_springs(changes: dict[str, Any]) -> tuple[ContactProblem, CoupledEntries]:
    """Return the contact problem of the default case with changes, and its coupled modes."""
    stage = build_beams(with_values(Case(), changes))
    assert stage.kept.coupled is not None  # the coupling stiffness is not zero
    return contact_problem(stage), stage.kept.coupled


def late_growth(given: ContactProblem, steps: int) -> float:
    """Return the growth rate of a march after its first second [1/s]."""
    chunk = marched(given, 1e-5, steps, every=500)
    size, late = np.linalg.norm(chunk.rotor_displacement, axis=1), chunk.time > 1.0
    return float(np.polyfit(chunk.time[late], np.log(size[late]), 1)[0])


def monodromy(ratio: str) -> Floquet:
    """Return the Floquet analysis of the example point by direct integration."""
    given, modes = coupled(ratio)
    return floquet(
        lambda times: modes.equations.stiffness(given.speed * times, KAPPA),
        period=2.0 * np.pi / given.speed,
        damping=modes.equations.structure.damping,
    )


@verifies(*DAMPED)
def growth_rates(ratio: str) -> Pairs:
    """Compare growth rates by the monodromy matrix and by a march with the reference. Growth rates
    in the invariant frame of Eqs (16)-(21) equal those by the monodromy matrix.

    The growth rate is positive only with the factor pi of Eq. (8).
    """
    given, modes = coupled(ratio)
    exact, direct = reference("published")["growth_at_1.17_500"][ratio], monodromy(ratio).growth
    invariant = growth_rate(modes, speed=given.speed, kappa=KAPPA)
    return {
        "growth_by_monodromy": (exact, direct),
        "growth_in_the_invariant_frame": (direct, invariant),
        "growth_of_a_march": (exact, late_growth(given, 150_000)),
    }


@verifies()
def growth_without_pi() -> Pair:
    """Compare the growth rate by Eq. (9) as printed, without the factor pi, with zero."""
    given, modes = coupled("0.0")
    without = replace(modes, with_pi=False)
    return 0.0, growth_rate(without, speed=given.speed, kappa=KAPPA)


@verifies()
def monodromy_by_runge_kutta() -> Pair:
    """Compare the monodromy matrix, scaled by the reference frequency, with Runge-Kutta."""
    given, modes = coupled("0.005")
    size, damping = modes.size, modes.equations.structure.drag(0.0)

    def rate(time: float, state: FloatArray) -> FloatArray:
        x, v = state.reshape(2, size, 2 * size)
        stiffness = modes.equations.stiffness(given.speed * time, KAPPA)
        return np.concatenate([v, -stiffness @ x - damping @ v]).ravel()

    whole = np.eye(2 * size).ravel()
    end = solve_ivp(
        rate, (0.0, 2.0 * np.pi / given.speed), whole, method="DOP853", rtol=1e-12, atol=1e-12
    ).y[:, -1]
    scale = np.repeat([given.speed / 1.17, 1.0], size)
    turned = scale[:, None] / scale
    return turned * np.reshape(end, (2 * size, -1)), turned * monodromy("0.005").monodromy


@verifies()
def growth_of_a_march_at_speed() -> Pair:
    """Compare the growth rate of a march of the paper's six modes that includes rotation effects
    with that of the eigenvalues.

    The modes of the march are those of the stiffness at speed, which are coupled by Coriolis
    forces. The coupling springs of the eigenvalue problem are expressed in the modes of the stage
    at rest.
    """
    kappa = 1000.0
    changes = {"march.speed": 1.65, "coupling.stiffness": kappa, "damping.ratio": 0.005}
    push = {"reduction.modes": "six", "initial.centre_velocity": [1e-12, 0.0]}
    at_rest, coupling = on_springs(changes | push)
    case = with_values(Case(), changes | {"rotation.effects": "full"})
    system = couple(modal_model(case), modes="six", damped=True, with_pi=True, physical=False)
    assert isinstance(system, EvenSystem)
    omega = at_rest.speed
    names = ("gyroscopic", "stiffness_speed")
    modes = replace(coupling.modes, **{name: getattr(system.modes, name) for name in names})
    on_rotor = ~modes.on_casing
    part = modes.take(on_rotor)
    structure = replace(part.equations.structure, damping=None)
    stiffness, turning = map(
        part.over_entries, (structure.stiffness_at(omega), structure.drag(omega))
    )
    square, axes = np.linalg.eigh(stiffness.real)
    frequency = np.sign(square) * np.sqrt(np.abs(square))
    damping = axes.T @ np.diag(part.damping_rate) @ axes
    coriolis = axes.T @ turning.imag @ axes
    by_velocity = np.kron(damping, np.eye(2)) + np.kron(coriolis, [[0.0, -1.0], [1.0, 0.0]])
    rotor = replace(
        at_rest.rotor,
        frequency=np.repeat(frequency, 2),
        damping_ratio=np.zeros(2 * len(frequency)),
        by_velocity=by_velocity,
    )
    both, amplitude = modes.frequency.copy(), modes.amplitude.copy()
    both[on_rotor], amplitude[on_rotor] = frequency, axes.T @ amplitude[on_rotor]
    stiff = replace(coupling, modes=replace(coupling.modes, frequency=both, amplitude=amplitude))
    sizes = len(at_rest.rotor.frequency), len(at_rest.casing.frequency)
    turned = replace(at_rest, rotor=rotor, springs=stiff.springs(kappa, *sizes))
    return growth_rate(modes, speed=omega, kappa=kappa), late_growth(turned, 200_000)


def zones_at(kappa: float) -> tuple[CouplingModes, UnstableZones]:
    """Return the undamped modes of the example point and their zones for a stiffness [N/m]."""
    given, modes = coupled("0.0")
    unit = given.speed / 1.17
    return modes, unstable_zones(modes, kappas=np.array([kappa]), low=0.6 * unit, high=3.0 * unit)


@verifies()
def coincidences() -> Pair:
    """Compare the borders of zones for springs of 1e-6 N/m with the coincidence speeds of waves."""
    modes, zones = zones_at(1e-6)
    return sorted(coincidence_speeds(modes).values()), np.sort(zones.lower)


@verifies()
def narrow_zones() -> Pair:
    """Compare width and growth rate of narrow zones with their first-order terms in pi kappa."""
    modes, zones = zones_at(kappa := 1e-2)
    casing, *rotor = modes.frequency[np.argsort(~modes.on_casing, kind="stable")]
    width = 2.0 * np.pi * kappa / np.sqrt(casing * np.array(rotor))
    order = np.argsort(rotor)
    computed = np.concatenate([zones.upper - zones.lower, zones.growth])
    return np.concatenate([width[order], 0.25 * width[order]]), computed


@verifies()
def order_of_coupled_marches() -> Pair:
    """Compare the order of convergence of coupled marches, from three time steps, with 2."""
    given, _ = coupled("0.005")
    chunks = [marched(given, 0.2 / steps, steps, every=steps) for steps in (2000, 4000, 8000)]
    ends = [chunk.rotor_displacement[-1] for chunk in chunks]
    apart = [np.linalg.norm(a - b) for a, b in pairwise(ends)]
    return 2.0, np.log2(apart[0] / apart[1])
