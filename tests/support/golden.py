"""Numbers of the paper's cases, marched for a short while: `python tests/support/golden.py`.

Rewrites tests/data/golden.json, which a test compares with; it is to change only where the model is
meant to. The march is short so that rounding has not yet grown into other motions.
"""

import json

from places import DATA

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.studies.paper.trials import CASES
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

FILE = DATA / "golden.json"
SHORT = {"march.duration": 0.03}

GOLDEN: dict[str, Case] = {
    "modal": with_values(CASES["modal"], {"initial.centre_velocity": (1.0, 0.0)}),
    "distortion": CASES["distortion"],
    "imbalance": with_values(CASES["imbalance"], {"excitation.ramp": 0.01}),
    "coupled": with_values(
        CASES["modal"],
        {
            "initial.centre_velocity": (1.0, 0.0),
            "coupling.stiffness": 500.0,
            "reduction.modes": "six",
        },
    ),
}
"""Those of the paper, set in motion early enough to touch within the time."""


def numbers(case: Case) -> dict[str, float]:
    """What a short march of a case gives."""
    prepared = prepare(with_values(case, SHORT))
    result, _ = march_in_memory(prepared)
    return {
        "reference_frequency": prepared.stage.reference_frequency,
        "smallest_gap": float(result["gap"].min()),
        "impulse": float(result["contact_impulse"].sum()),
        "friction_work": float(result["friction_work"][-1]),
        "external_work": float(result["external_work"][-1]),
        "energy": float(result["energy"][-1]),
    }


if __name__ == "__main__":
    found = {name: numbers(case) for name, case in GOLDEN.items()}
    FILE.write_text(json.dumps(found, indent=2) + "\n")
