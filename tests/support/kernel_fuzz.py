"""Random stages marched by the kernel and by NumPy: `python tests/support/kernel_fuzz.py`.

A third of them has no symmetry and any sizes; a third are cyclic stages of a case; and a third are
blades with contact nodes that stick or slide in all directions, with or without mass, whose march
in NumPy is another one (`boundary_cases.plain`). Options are on and off by chance: loads, dampers,
springs between the bodies and under the shaft, bearings, Coriolis forces, signed sliding, tips that
turn, closing casings, coatings, blades that shorten, supports that fuse, and a speed that varies or
is free. Each stage has to agree to 1e-9 and, unless the speed is free, to keep the energy balance,
except where NumPy finds no contact forces. A stage is made from its number alone, so a finding is
repeated by `--first NUMBER --count 1`. Meant for a build with AddressSanitizer too, see
`.ci/sanitize`.
"""

import argparse
from dataclasses import replace
from typing import Any

import numpy as np
from boundary_cases import assert_plain, bladed, casing
from boundary_cases import coating as layers
from contact_cases import assert_same, ledger_residual, random_problem, thrown
from reference_march import Reference

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.closure import Closure
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.stage.bearings import Bearings
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem, FusedSupport
from bladewhirl.models.stage.foreshortening import Foreshortening
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.varying_speed import FreeSpeed, SpeedChange
from bladewhirl.models.stage.wall import WallClosure
from bladewhirl.models.stage.wall_coating import WallCoating
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.solvers.kernel import structs
from bladewhirl.solvers.march.central_difference import CentralDifference

STEPS = 60


def without_symmetry(number: int, random: np.random.Generator) -> ContactProblem:
    """Two bodies without any symmetry, of any sizes."""
    given = random_problem(
        number,
        tips=int(random.integers(1, 8)),
        nodes=int(random.integers(1, 12)),
        rotor_modes=int(random.integers(1, 40)),
        casing_modes=int(random.integers(0, 30)),
        speed=float(random.choice([-90.0, 0.0, 1.0, 30.0])),
        sliding=random.choice(["permanent", "signed"]),
        tip_rotation=bool(random.integers(2)),
    )
    rotor, casing = given.rotor, given.casing
    modes = len(rotor.frequency)
    if random.integers(2):
        skew, half = 10.0 * random.normal(size=(2, modes, modes))
        turning = skew - skew.T + 0.1 * half.T @ half
        rotor = replace(rotor, by_velocity=turning, circulation=float(random.choice([0.0, 2e3])))
    if random.integers(2):
        rotor = replace(rotor, anisotropy=1e3)
    free = given.speed != 0.0 and random.integers(2) == 0
    if free:
        rotor = replace(rotor, anisotropy=0.0, circulation=0.0)
    if random.integers(2):
        rows = int(random.integers(1, 4))
        rotor = replace(rotor, dampers=random.normal(size=(rows, modes)))
        casing = replace(casing, dampers=random.normal(size=(rows, len(casing.frequency))))
    loads = given.loads if random.integers(2) else ()
    given = replace(given, rotor=rotor, casing=casing, loads=loads)
    return driven(given, random) if free else given


def driven(given: ContactProblem, random: np.random.Generator) -> ContactProblem:
    """The problem with a free speed, unbalance, and by chance a damper in the static frame."""
    rotor, speed = given.rotor, given.speed
    modes, torque, loss = len(rotor.frequency), *random.normal(scale=50.0, size=2)
    change = SpeedChange(course=SpeedCourse.through([0.0], [speed], 0.0))
    drive = FreeSpeed(inertia=float(random.uniform(0.1, 2.0)), torque=torque, loss=abs(loss) / 90.0)
    if rotor.by_velocity is None:
        return replace(given, change=change, drive=drive, loads=())
    along, across = random.normal(scale=0.1, size=(2, modes))
    drive = replace(
        drive, along=along, across=across, inertia=drive.inertia + 2.0 * across @ across
    )
    if random.integers(2):
        damping = 300.0
        rotor = replace(rotor, dampers=np.sqrt(damping) * rotor.centre, circulation=damping * speed)
        drive = replace(drive, damping=damping)
    still = np.zeros(len(given.casing.frequency))
    loads = (
        Load(casing=still, rotor=speed**2 * along, by_square=speed**-2.0),
        Load(casing=still, rotor=across, constant=0.0, by_acceleration=-1.0),
    )
    change = replace(change, rotor=turning(given, random))
    return replace(given, rotor=rotor, loads=loads, change=change, drive=drive)


def turning(given: ContactProblem, random: np.random.Generator) -> Rotating[FloatArray]:
    """A rotor whose stiffness depends on the speed, with its Coriolis forces."""
    rotor, modes = given.rotor, len(given.rotor.frequency)
    assert rotor.by_velocity is not None
    half = random.normal(size=(modes, modes))
    return Rotating(
        mass=np.eye(modes),
        stiffness=np.diag(rotor.stiffness),
        gyroscopic=0.5 * (rotor.by_velocity - rotor.by_velocity.T) / (20.0 + abs(given.speed)),
        stiffness_speed=half + half.T,
        speed=given.speed,
    )


def cyclic_stage(random: np.random.Generator) -> ContactProblem:
    """The problem of a small case."""
    blades = int(random.integers(3, 10))
    case: dict[str, Any] = {
        "bladed_disk": {"blades": blades},
        "casing": {"elements": int(random.integers(max(4, blades), 26)), "support": 7.975e6},
        "reduction": {"fixed_interface_modes": int(random.integers(1, 5)) * blades},
        "rotation": {"effects": str(random.choice(["none", "full"]))},
        "contact": {
            "sliding": str(random.choice(["permanent", "signed"])),
            "tip_rotation": bool(random.integers(2)),
        },
        "excitation": {"type": str(random.choice(["casing-distortion", "none"]))},
    }
    if case["casing"]["elements"] >= 8 and random.integers(2):
        case["casing"]["clearance_lobes"] = [{"lobes": 2, "amplitude": 3e-4}]
    speed = str(random.choice(["held", "varying", "free", "free"]))
    if speed == "varying":
        case["march"] = {"speed_table": [[0.0, 0.9], [3e-5, 0.902], [6e-5, 0.9]]}
    if speed == "free":
        case["march"] = {"speed": 0.8, "drive": {"inertia": 0.1, "torque": 50.0, "loss": 0.05}}
        case["excitation"] = {"type": "imbalance", "unbalance": 0.05, "ramp": 0.0}
    if speed != "free" and random.integers(2):
        case["coupling"] = {"stiffness": 1e6, "modes": str(random.choice(["six", "all"]))}
    if random.integers(2):
        stiffness, damping = 1e7, 1e4
        case["shaft"] = {"stiffness": stiffness, "damping": damping}
        if case["rotation"]["effects"] == "full":
            case["shaft"]["damping_frame"] = "static"
            if speed != "free" and "coupling" not in case:
                case["shaft"]["stiffness_y"] = 0.7 * stiffness
    given = contact_problem(build_beams(Case.model_validate(case)))
    return thrown(given, 40.0, spread=0.5)


def with_nodes(random: np.random.Generator) -> ContactProblem:
    """Blades with contact nodes."""
    copies, nodes, modes = int(random.integers(1, 4)), int(random.integers(1, 5)), 8
    ring = casing(8, damping=float(random.choice([0.0, 0.01]))) if random.integers(2) else None
    layer, turning = None, None
    if ring is None and random.integers(2):
        tracks, arc = random.integers(0, 2, nodes).astype(np.float64), random.uniform(1e-3, 8e-3)
        layer = layers(tracks, float(arc), limit=float(random.choice([0.06, 0.9])))
    if random.integers(2):
        skew = random.normal(scale=200.0, size=(modes, modes))
        turning = skew - skew.T + 1e-3 * skew.T @ skew
    on_blades, on_ring = random.normal(size=copies * modes), np.zeros(0)
    if ring is not None:
        on_ring = random.normal(scale=100.0, size=len(ring.frequency))
    load = Load(rotor=30.0 * on_blades, casing=on_ring, frequency=2e3, ramp=1e-4, end=3e-4)
    return bladed(
        copies,
        nodes,
        massless=bool(random.integers(2)),
        ring=ring,
        coating=layer,
        by_velocity=turning,
        seed=int(random.integers(1000)),
        sliding=str(random.choice(["permanent", "full"])),
        speed=float(random.choice([-220.0, -0.5, 0.5, 150.0])),
        friction=float(random.choice([0.1, 0.4])),
        loads=(load,) * int(random.integers(2)),
    )


def closure(given: ContactProblem, dt: float, random: np.random.Generator) -> WallClosure:
    """A casing that closes within the steps, evenly or by a table."""
    share = np.column_stack([random.normal(1.0, 0.2, len(given.casing.nodal))] * 2) * [1.0, 0.1]
    lost = 1.5 * float(given.casing.clearance[:, 0].min())
    if random.integers(2):
        return WallClosure(course=Closure(amount=lost, time_constant=20 * dt), share=share)
    times = np.cumsum(random.uniform(1.0, 20.0, int(random.integers(1, 6))) * dt)
    rows = tuple((float(time), lost * float(random.uniform())) for time in times)
    return WallClosure(course=Closure(table=rows), share=share)


def coating(given: ContactProblem, random: np.random.Generator) -> WallCoating:
    """A soft coating of any number of rods, worn by chance at the start."""
    tips = len(given.rotor.tip_angle)
    rods = int(random.integers(4 * tips + 4, 400))  # tips at equal angles do not share any
    around = 2.0 * np.pi * given.casing.radius
    lost = float(given.casing.clearance[:, 0].min())
    return WallCoating(
        strain=random.uniform(0.0, 0.1, (1, rods)),
        axial=np.zeros(1),
        width=np.full(1, 0.1),
        track=np.zeros(tips, dtype=np.int64),
        footprint=random.uniform(0.5, 3.0, tips) * around / rods,
        radius=given.casing.radius,
        thickness=float(random.choice([0.3, 3.0])) * lost,
        young_modulus=1e4,
        yield_stress=10.0,
        hardening=1e3,
        limit=float(random.choice([0.2, 1.0])),
    )


def shortening(given: ContactProblem, random: np.random.Generator) -> Foreshortening:
    """Any quadratic forms that open gaps, or that also close them."""
    tips, modes = given.rotor.tip_radial.shape
    rows = random.normal(size=(tips, int(random.integers(1, 12)), modes))
    sign = random.choice([[0.0, 1.0], [1.0, 1.0], [-1.0, 1.0]], axis=0)
    frequency = float(random.choice([0.0, 1e4, 1e9]))
    return Foreshortening(
        rows=float(random.choice([0.3, 3.0])) * rows,
        sign=random.choice(sign, size=rows.shape[:2]),
        frequency=frequency,
    )


def fuse(given: ContactProblem, random: np.random.Generator) -> FusedSupport:
    """A support that may fuse within the steps; what follows is another march."""
    modes = len(given.rotor.frequency)
    one, force = np.eye(modes), random.normal(size=(2, modes))
    size = float(np.hypot(*(force @ given.start.rotor + 1e-3 * force @ given.start.rotor_velocity)))
    return FusedSupport(
        after=given,
        restriction=one,
        extension=one,
        force=force,
        constant=0.1 * size * random.normal(size=2),
        limit=size,
    )


def bearings(given: ContactProblem, random: np.random.Generator) -> Bearings:
    """Bearings of any matrices, some of them on supports that move alike along x and y."""
    count, modes = int(random.integers(1, 5)), len(given.rotor.frequency)
    of_casing = len(given.casing.frequency)
    support = np.zeros((count, of_casing), dtype=np.complex128)
    equal = of_casing > 1 and (given.casing.frequency[:2] == given.casing.frequency[0]).all()
    if equal and random.integers(2):
        support[0, :2] = 1.0, 1.0j
    stiffness, damping, rotor = complex_numbers(random, (3, count, max(modes, 2)))
    return Bearings(
        rotor=rotor[:, :modes],
        support=support,
        stiffness=1e3 * stiffness[:, :2],
        damping=10.0 * damping[:, :2],
    )


def complex_numbers(random: np.random.Generator, shape: tuple[int, ...]) -> ComplexArray:
    """Normally distributed numbers."""
    return np.asarray(random.normal(size=shape) + 1j * random.normal(size=shape))


def course(given: ContactProblem, dt: float, random: np.random.Generator) -> SpeedCourse:
    """A speed that rises and falls about that of the problem, and may pass zero."""
    times = np.cumsum(random.uniform(5.0, 30.0, 3)) * dt
    speeds = given.speed + random.normal(0.0, 10.0 + 0.5 * abs(given.speed), 3)
    return SpeedCourse.through(times.tolist(), speeds.tolist(), float(2.0 * dt))


def check(number: int) -> bool:
    """March the stage of a number in every way; return whether NumPy could."""
    random = np.random.default_rng([number, 33])
    if number % 3 == 2:
        try:
            assert_plain(with_nodes(random), 4e-6, 2 * STEPS)
        except ArithmeticError:
            return False
        return True
    if number % 3:
        given, dt = cyclic_stage(random), 1e-6
    else:
        given, dt = without_symmetry(number, random), 1e-4
    dt = min(dt, 0.5 * given.critical_time_step)
    coupled = given.rotor.by_velocity is not None
    varies = not coupled or (number % 3 == 0 and given.speed != 0.0)
    if random.integers(2):
        given = replace(given, closure=closure(given, dt, random))
    if random.integers(2):
        given = replace(given, coating=coating(given, random))
    if random.integers(2):
        given = replace(given, foreshortening=shortening(given, random))
    if given.change is None and random.integers(2) and varies:
        rotor = turning(given, random) if coupled else None
        if rotor is not None and random.integers(2):
            rotor = replace(rotor, stiffness_speed4=1e-4 * rotor.known("stiffness_speed") ** 2)
        change = SpeedChange(course=course(given, dt, random), rotor=rotor)
        given = replace(given, change=change)
    if random.integers(3) == 0:
        given = replace(given, bearings=bearings(given, random))
        dt = min(dt, 0.5 * given.critical_time_step)
    if random.integers(4) == 0:
        given = replace(given, fuse=fuse(given, random))
    every = int(random.integers(1, 9))
    plain = Reference(given, dt, every)
    try:
        reached, expected, reason = plain.advance(plain.init(), STEPS)
    except ArithmeticError:
        return False
    for cyclic in (True, False):
        fast = CentralDifference(given, dt, every, cyclic=cyclic)
        state, chunk, end = fast.advance(fast.init(), STEPS)
        assert end is reason
        if given.drive is None:
            assert_same(chunk, expected)
            assert ledger_residual(chunk) < 1e-10
        else:
            unknown = [name for name in vars(chunk) if name.endswith(("energy", "work"))]
            known = {name: getattr(chunk, name) for name in unknown}
            assert_same(chunk, replace(expected, **known))
        assert state.statistics.contact_steps == reached.statistics.contact_steps
        assert state.statistics.complementarity_residual < 1e-10
    return True


def main() -> None:
    """Check stages and print how many."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--count", type=int, default=2000)
    chosen = options.parse_args()
    structs.CACHE_LINE = 8  # nothing behind an array: a sanitizer sees where it ends
    agreed = 0
    for number in range(chosen.first, chosen.first + chosen.count):
        try:
            agreed += check(number)
        except Exception as error:
            raise SystemExit(f"stage {number}: {error}") from error
    print(f"{agreed} of {chosen.count} stages agree; NumPy finds no contact forces of the others")


if __name__ == "__main__":
    main()
