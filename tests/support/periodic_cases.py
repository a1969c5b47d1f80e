"""Oscillators and cases of a twisted blade that periodic motions are computed of."""

from typing import Any

import numpy as np
from places import ROOT

import bladewhirl as bw
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.marched import marched_stage
from bladewhirl.solvers.periodic.blade import Blade

KAPPA = 25.0


def oscillator(speed: float, force: float) -> Blade:
    """A mass on a spring, of unit frequency, with an elastic massless stop at the distance 1."""
    return Blade(
        stiffness=np.ones(1),
        damping=np.zeros((1, 1)),
        contact=np.array([[1.0], [0.0], [0.0]]),
        compliance=np.eye(3) / KAPPA,
        angle=np.zeros(1),
        radius=np.ones(1),
        recess=np.zeros(1),
        clearance=np.tile([1.0, 0.0], (8, 1)),
        wall_step=1.0,
        loads={1: np.array([force + 0j])},
        speed=speed,
        friction=0.0,
        full=False,
        lobes=1,
    )


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
    return marched_stage(case).contact_problem()


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
