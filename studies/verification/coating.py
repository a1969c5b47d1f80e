"""Abradable coating: a rod compared with closed-form solutions, lobes cut by prescribed motions,
and an oscillator over an oval coating compared with an exact event-driven solution."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.models.stage.wall_coating import WallCoating
from bladewhirl.postprocess.run.wear import lobe_shares
from bladewhirl.solvers.march.march import Chunk, CoatingRecords
from bladewhirl.studies.verification.bodies import (
    default_stage,
    ledger_residual,
    marched,
    point_mass,
    problem,
    small_rotor,
    wall,
)
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies

THICKNESS, MODULUS, YIELD, HARDENING = 5e-3, 1e9, 1e7, 5e7
HEAVY = 1e12  #: mass that contact does not slow down [kg]


def coating(rods: int, tips: int = 1, *, footprint: float = 1.0, **values: Any) -> WallCoating:
    """Return a coating on a casing with a radius of 1 m.

    Args:
        rods: number of rods.
        tips: number of tips.
        footprint: arc length under a tip, divided by that of a rod.
        values: values that replace the defaults.
    """
    arc = 2.0 * np.pi / rods
    defaults: dict[str, Any] = {
        "strain": np.zeros((1, rods)),
        "axial": np.zeros(1),
        "width": np.full(1, 1e-9),  # forces that a heavy tip does not feel
        "track": np.zeros(tips, dtype=np.int64),
        "footprint": np.full(tips, footprint * arc),
        "radius": 1.0,
        "thickness": THICKNESS,
        "young_modulus": MODULUS,
        "yield_stress": YIELD,
        "hardening": HARDENING,
        "limit": 0.9,
    }
    return WallCoating(**defaults | values)


def worn(chunk: Chunk) -> CoatingRecords:
    """Return the records of the coating of a march.

    Raises:
        ArithmeticError: the coating has no records.
    """
    if chunk.coating is None:
        raise ArithmeticError("expected a coating")
    return chunk.coating


def swinging(
    given: WallCoating,
    casing: ReducedCasing,
    *,
    amplitude: float,
    frequency: float,
    dt: float,
    speed: float = 0.0,
    phase: float = 0.0,
    angle: float = 0.0,
) -> ContactProblem:
    """Return a heavy tip, whose motion in the scheme is exactly amplitude * cos(frequency t +
    phase)."""
    omega = 2.0 / dt * np.sin(frequency * dt / 2.0)
    rotor = point_mass(HEAVY, omega, tip_angle=np.array([angle]))
    # The velocity from which x_{-1} = x_0 - dt v + dt^2 a / 2 of the scheme is exact.
    velocity = -np.sin(phase) * np.sin(frequency * dt) / dt
    start = {
        "rotor": np.array([amplitude * np.cos(phase) * HEAVY**0.5]),
        "rotor_velocity": np.array([amplitude * velocity * HEAVY**0.5]),
    }
    made = problem(rotor, casing, start=start, speed=speed)
    return replace(made, coating=given)


@verifies()
def single_rod() -> Pairs:
    """Press a rod twice to each of three depths, and compare with the closed-form solutions."""
    dt, steps = 1e-3, 1000
    given = coating(8)
    computed, dissipated, again, depths = [], [], [], np.array([4e-5, 2.5e-4, 1e-3])
    for depth in depths:
        motion = swinging(
            given,
            wall(1e-3 - depth),
            amplitude=-1e-3,
            frequency=2.0 * np.pi,
            dt=dt,
            angle=1.1 * given.arc,
        )
        chunk = worn(marched(motion, dt, 2 * steps, every=steps))
        computed.append(chunk.coating_strain.max())
        volume = float(given.arc * given.width[0]) * THICKNESS
        dissipated.append(chunk.wear_dissipated[-1] / volume)
        again.append(chunk.wear_volume[-1] / chunk.wear_volume[1] if computed[-1] else 1.0)
    beyond = MODULUS * depths / THICKNESS - YIELD
    strain = np.maximum(beyond, 0.0) / (MODULUS + HARDENING)
    loss = YIELD * strain + HARDENING * strain**2 / 2.0
    return {
        "strain_of_a_rod": (strain, computed),
        "loss_in_a_rod": (loss, dissipated),
        "shakedown_of_a_rod": (np.ones(3), again),
    }


@verifies("3/1", "5/1", "5/2", "7/3", "sqrt(7)")
def lobes_of_prescribed_motion(ratio: str) -> Pairs:
    """Compare recess and number of lobes with the reference, after a tip with prescribed motion has
    cut the coating in 60 revolutions; each time step covers one rod."""
    row = reference("abradable")["lobes"][ratio]
    rods, turns, dt = row["rods"], row["revolutions"], 1e-3
    given = coating(rods)
    speed = given.arc / dt
    motion = swinging(
        given,
        wall(-row["d0"]),
        amplitude=row["a"],
        frequency=row["omega_over_Omega"] * speed,
        phase=row["omega_over_Omega"] * given.arc / 2.0,
        dt=dt,
        speed=speed,
        angle=0.5 * given.arc,
    )
    recess = THICKNESS * worn(marched(motion, dt, rods * turns, every=rods)).coating_strain[-1, 0]
    removed = recess.mean() / row["mean_recess"]
    return {
        "recess_by_prescribed_motion": (
            [row["max_recess_m"], row["min_recess_m"]],
            [recess.max(), recess.min()],
        ),
        "area_by_prescribed_motion": (1.0, removed),
        "lobes_by_prescribed_motion": (
            row["dominant_harmonic"],
            int(np.argmax(lobe_shares(recess))) + 1,
        ),
    }


@cache
def oscillator(number: str, per_rod: int, turns: int) -> tuple[FloatArray, FloatArray]:
    """March an oscillator over an oval coating; return displacement and mean recess [m] after each
    revolution."""
    row = reference("abradable")["oscillator"][number]
    with_ = row["parameters"] | row["material"]
    rods, omega = with_["rods"], 2.0 * np.pi * with_["f0"]
    speed = omega / row["omega0_over_Omega"]
    dt = 2.0 * np.pi / speed / (rods * per_rod)
    nodes = rods // 8  # the clearance between nodes has an error of 1e-11 m
    angle = 2.0 * np.pi / nodes * np.arange(nodes)
    clearance = with_["c0"] - with_["c2"] * (1.0 - np.cos(2.0 * angle)) / 2.0
    slope = -with_["c2"] * np.sin(2.0 * angle)
    casing = replace(wall(0.0, nodes), clearance=np.stack([clearance, slope], axis=1))
    body = point_mass(with_["m"], omega, damping_ratio=np.array([with_["zeta"]]))
    made = problem(body, casing, speed=speed)
    given = coating(
        rods,
        width=np.full(1, with_["A"] / (2.0 * np.pi / rods)),
        thickness=with_["h0"],
        young_modulus=with_["E"],
        yield_stress=with_["sigma_y"],
        hardening=with_["H"],
    )
    every = rods * per_rod
    chunk = marched(replace(made, coating=given), dt, turns * every + 1, every=every)
    tip = chunk.rotor_displacement[1:, 0] * with_["m"] ** -0.5
    return tip, worn(chunk).wear_volume[1:] / (with_["A"] * rods)


@verifies()
def elastic_oscillator() -> Pair:
    """Compare the displacement after each of five revolutions without wear, extrapolated to a time
    step of zero."""
    exact = reference("abradable")["oscillator"]["1"]["x"]
    return exact, 2.0 * oscillator("1", 512, 5)[0] - oscillator("1", 256, 5)[0]


@verifies("2", "3", "4")
def worn_by_an_oscillator(number: str) -> Pair:
    """Compare the mean recess after the first revolution, and after the second in cases 2 and 3,
    extrapolated to a time step of zero. Later impacts depend on the smallest errors."""
    turns = 1 if number == "4" else 2
    exact = reference("abradable")["oscillator"][number]["mean_recess"][:turns]
    return exact, 2.0 * oscillator(number, 512, turns)[1] - oscillator(number, 256, turns)[1]


@verifies((3, 7), (4, 22), (5, 12), (2, 9), (7, 10), (11, 13))
def lobes_of_engine_orders(pair: tuple[int, int]) -> Pair:
    """Compare the number of lobes that tips cut under forces of one engine order with the order."""
    order, blades = pair
    dt, speed, rods = 1e-4, 20.0, 720
    angle = 2.0 * np.pi / blades * np.arange(blades)
    mass, omega = 1.0, 1.7 * order * speed
    # Blade n moves as cos(order (speed t + angle_n)): two loads, cosine and sine.
    loads = tuple(
        Load(
            rotor=1e-3 * omega**2 * wave / mass**0.5,
            casing=np.zeros(1),
            frequency=order * speed,
            phase=phase,
            ramp=0.3,
        )
        for wave, phase in ((np.cos(order * angle), 0.0), (np.sin(order * angle), np.pi / 2.0))
    )
    rotor = small_rotor(
        np.full(blades, omega),
        tips=blades,
        damping_ratio=np.full(blades, 0.1),
        tip_radial=np.eye(blades) * mass**-0.5,
        tip_angle=angle,
    )
    made = problem(rotor, wall(1e-3), loads=loads, speed=speed)
    soft = coating(
        rods, blades, footprint=4.0, width=np.full(1, 1e-3), young_modulus=1e6, yield_stress=1e3
    )
    chunk = marched(replace(made, coating=soft), dt, 20_000, every=20_000)
    return order, int(lobe_shares(worn(chunk).coating_strain[-1, 0]).argmax()) + 1


@verifies()
def rigid_limit() -> Pair:
    """Compare a nearly rigid coating (1000 GPa) with the rigid-plastic limit, in which the surface
    yields at a constant force: for a tip driven into the coating by a given distance, and for a
    mass that the coating stops."""
    dt, depth = 2e-7, 1e-3
    stiff = coating(8, young_modulus=1e12, hardening=0.0)
    motion = swinging(
        stiff,
        wall(1e-3 - depth),
        amplitude=-1e-3,
        frequency=2.0 * np.pi * 1e3,
        dt=dt,
        angle=1.1 * stiff.arc,
    )
    pressed = worn(marched(motion, dt, 5000, every=5000)).coating_strain.max()
    stopping = replace(stiff, width=np.full(1, 1e-4 / stiff.arc))  # a yield force of 1 kN
    mass = point_mass(1.0, tip_angle=1.1 * np.array([stiff.arc]))
    start = {"rotor_velocity": np.array([1.0])}
    thrown = replace(problem(mass, wall(0.0), start=start), coating=stopping)
    stopped = worn(marched(thrown, dt, 10_000, every=10_000)).coating_strain.max()
    return [depth, 0.5 * 1.0**2 / (YIELD * 1e-4)], [THICKNESS * pressed, THICKNESS * stopped]


@verifies()
def coating_ledger() -> Pair:
    """Compare with zero the error of the energy balance of a stage that cuts its coating."""
    changes: Mapping[str, Any] = {
        "reduction.fixed_interface_modes": 22,
        "casing.elements": 22,
        "casing.coating": {
            "thickness": 5e-3,
            "young_modulus": 1e9,
            "yield_stress": 1e6,
            "hardening": 5e7,
        },
        "initial.centre_velocity": [1.5, 0.7],
        "contact.friction": 0.2,
    }
    chunk = marched(default_stage(changes), 4e-6, 2500)
    if not worn(chunk).wear_volume[-1] > 0.0:
        raise ArithmeticError("expected wear")
    return 0.0, ledger_residual(chunk)
