"""Random stages marched by the kernel and by NumPy: `python tests/support/kernel_fuzz.py`.

Half of them have no symmetry and any sizes; half are cyclic stages of a case. Options of the march
are on and off by chance: loads, dampers, springs between the bodies and under the shaft, Coriolis
forces, signed sliding, tips that turn, closing casings, coatings, blades that shorten, and a speed
that varies. Each stage has to agree to 1e-9 and to keep the energy balance, except where NumPy
finds no contact forces. A stage is made from its number alone, so a finding is repeated by
`--first NUMBER --count 1`. Meant for a build with AddressSanitizer too, see `.ci/sanitize`.
"""

import argparse
from dataclasses import replace
from typing import Any

import numpy as np
from contact_cases import assert_same, ledger_residual, random_problem, thrown
from reference_march import Reference

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.closure import Closure
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import (
    ContactProblem,
    Foreshortening,
    WallClosure,
    WallCoating,
)
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.models.stage.varying_speed import SpeedChange
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
        skew, half = 30.0 * random.normal(size=(2, modes, modes))
        turning = skew - skew.T + 0.01 * half.T @ half
        rotor = replace(rotor, by_velocity=turning, circulation=float(random.choice([0.0, 2e3])))
    if random.integers(2):
        rotor = replace(rotor, anisotropy=1e3)
    if random.integers(2):
        rows = int(random.integers(1, 4))
        rotor = replace(rotor, dampers=random.normal(size=(rows, modes)))
        casing = replace(casing, dampers=random.normal(size=(rows, len(casing.frequency))))
    loads = given.loads if random.integers(2) else ()
    return replace(given, rotor=rotor, casing=casing, loads=loads)


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
    if random.integers(2):
        case["coupling"] = {"stiffness": 1e6, "modes": str(random.choice(["six", "all"]))}
    if random.integers(2):
        stiffness, damping = 1e7, 1e4
        case["shaft"] = {"stiffness": stiffness, "damping": damping}
        if case["rotation"]["effects"] == "full":
            case["shaft"]["damping_frame"] = "static"
            if "coupling" not in case:
                case["shaft"]["stiffness_y"] = 0.7 * stiffness
    given = contact_problem(build_stage(Case.model_validate(case)))
    return thrown(given, 40.0, spread=0.5)


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
    rods, tips = int(random.integers(8, 400)), len(given.rotor.tip_angle)
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


def course(given: ContactProblem, dt: float, random: np.random.Generator) -> SpeedCourse:
    """A speed that rises and falls about that of the problem, and may pass zero."""
    times = np.cumsum(random.uniform(5.0, 30.0, 3)) * dt
    speeds = given.speed + random.normal(0.0, 10.0 + 0.5 * abs(given.speed), 3)
    return SpeedCourse.through(times.tolist(), speeds.tolist(), float(2.0 * dt))


def check(number: int) -> bool:
    """March the stage of a number in every way; return whether NumPy could."""
    random = np.random.default_rng([number, 33])
    if number % 2:
        given, dt = cyclic_stage(random), 1e-6
    else:
        given, dt = without_symmetry(number, random), 1e-4
    dt = min(dt, 0.5 * given.critical_time_step)
    if random.integers(2):
        given = replace(given, closure=closure(given, dt, random))
    if random.integers(2):
        given = replace(given, coating=coating(given, random))
    if random.integers(2):
        given = replace(given, foreshortening=shortening(given, random))
    if given.rotor.by_velocity is None and random.integers(2):
        given = replace(given, change=SpeedChange(course=course(given, dt, random)))
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
        assert_same(chunk, expected)
        assert state.statistics.contact_steps == reached.statistics.contact_steps
        assert state.statistics.complementarity_residual < 1e-10
        assert ledger_residual(chunk) < 1e-10
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
