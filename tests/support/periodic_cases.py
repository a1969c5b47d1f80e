"""Cases of a twisted blade whose periodic motions are computed."""

from typing import Any

import numpy as np
from places import ROOT

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.marched import marched_stage


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
