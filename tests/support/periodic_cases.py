"""Cases of a twisted blade whose periodic motions are computed."""

from dataclasses import replace
from typing import Any

import numpy as np
from places import ROOT

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.periodic.blade import Blade
from bladewhirl.solvers.periodic.contact import Motion
from bladewhirl.solvers.periodic.search import periodic_motion


def twisted_blade(speed: str, sliding: str, friction: float, closure: str) -> ContactProblem:
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": {"file": str(ROOT / "examples" / "twisted_blade.npz")}},
            "reduction": {"free_interface_modes": 20},
            "damping": {"ratio": 0.01},
            "casing": {
                "type": "rigid",
                "clearance": "0.35 mm",
                "closure": {"amount": closure, "time_constant": "1 ms"},
                "profile": {"harmonics": [{"lobes": 2, "amplitude": "0.27 mm"}]},
            },
            "contact": {"friction": friction, "sliding": sliding},
            "march": {"speed": speed, "time_step": "1 us"},
        }
    )
    return contact_problem(build_stage(case))


BLADE = {"superelement": {"file": str(ROOT / "examples" / "twisted_blade.npz")}}


def case(**changes: Any) -> bw.Case:
    """A closing oval wall that a twisted blade touches twice a turn."""
    tables: dict[str, Any] = {
        "bladed_disk": BLADE,
        "reduction": {"free_interface_modes": 20},
        "damping": {"ratio": 0.01},
        "casing": {
            "type": "rigid",
            "clearance": "0.35 mm",
            "closure": {"amount": "0.1 mm", "time_constant": "1 ms"},
            "profile": {"harmonics": [{"lobes": 2, "amplitude": "0.27 mm"}]},
        },
        "contact": {"friction": 0.05, "sliding": "full"},
        "march": {
            "speed": "7000 rpm",
            "time_step": "1 us",
            "duration": "0.4 s",
            "record_step": "20 us",
        },
    }
    return bw.with_values(bw.case_from(tables), changes)


def rub(problem: ContactProblem) -> Motion:
    """The periodic motion of a blade, with contact forces and, as far as there are loads, with
    forces of each engine order that are not zero."""
    blade = Blade.of_problem(problem)
    orders = {round(abs(load.frequency / problem.speed)) for load in problem.loads}
    assert orders == {order for order, force in blade.loads.items() if np.any(force)}
    motion = periodic_motion(blade)
    assert motion.touches
    return motion


def marched(
    problem: ContactProblem, motion: Motion, step: float, periods: int, start: Any = None
) -> Any:
    """Records once a period of a march that starts on a periodic motion, or with other modal
    displacements and velocities."""
    blade = motion.grid.blade
    displacement, velocity = motion.modes[:, 0] if start is None else start
    steps = round(blade.period / step)
    closed = replace(
        problem,
        closure=None,
        casing=replace(problem.casing, clearance=blade.clearance),
        start=replace(problem.start, rotor=displacement, rotor_velocity=velocity),
    )
    scheme = CentralDifference(closed, blade.period / steps, steps)
    _, chunk, end = scheme.advance(scheme.init(), steps * periods + 1)
    assert end is None
    return chunk


def states(problem: ContactProblem, chunk: Any) -> FloatArray:
    """States of the modes at records, with the same unit for displacements and velocities."""
    return np.hstack([chunk.rotor_displacement * problem.rotor.frequency, chunk.rotor_velocity])


def growth(problem: ContactProblem, motion: Motion, step: float, settled: int) -> float:
    """Magnitude of the leading multiplier of a march that has settled for some periods: the largest
    eigenvalue of the changes of its state after a period by small changes before it."""
    w, kick = problem.rotor.frequency, 1e-5 * np.abs(motion.modes[1]).max()
    q, v = motion.modes[:, 0]
    if settled:
        chunk = marched(problem, motion, step, settled)
        q, v = chunk.rotor_displacement[-1], chunk.rotor_velocity[-1]
    changes = np.vstack([np.zeros(2 * len(w)), kick * np.eye(2 * len(w))])
    after = [
        states(
            problem,
            marched(problem, motion, step, 1, (q + each[: len(w)] / w, v + each[len(w) :])),
        )[-1]
        for each in changes
    ]
    return float(np.abs(np.linalg.eigvals((np.array(after[1:]) - after[0]).T / kick)).max())


def decay(state: FloatArray, rate: float = 0.8) -> float:
    """Larger magnitude of the two multipliers of a sequence of states that decays, by linear
    prediction, (states, components); `rate` is about this magnitude."""
    weight = (
        rate ** -np.arange(len(state) - 1.0)[:, None]
    )  # late states count as much as early ones
    early, middle, late = (
        ((state[:-1] - state[-1]) * weight)[k : k + 26].ravel() for k in (12, 13, 14)
    )
    ahead = np.linalg.lstsq(np.stack([middle, early], axis=1), late, rcond=None)[0]
    return float(rate * np.abs(np.roots([1.0, *-ahead])).max())
