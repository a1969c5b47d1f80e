"""A stage of beams, and the same stage as a wheel, as sectors or as blades given by matrices."""

from pathlib import Path
from typing import Any, Literal

import bladewhirl as bw

Kind = Literal["wheel", "sector", "blade"]

BLADES, MODES = 6, 12


def same_stage(kind: Kind, file: Path, **changes: Any) -> tuple[bw.Case, bw.Case]:
    """Return the case of a stage of beams that a closing oval casing pinches, and that of its
    superelement, which is written to a file. The arguments are further tables of both cases."""
    common: dict[str, Any] = {
        "casing": {
            "elements": 24,
            "support": 7.975e6,
            "clearance": 5e-4,
            "clearance_lobes": [
                {"lobes": 2, "amplitude": 2e-4},
                {"lobes": 1, "amplitude": 5e-5, "phase": 0.4},
            ],
            "closure": {"amount": 4e-4, "time_constant": 4e-3},
        },
        "excitation": {"type": "none"},
        "contact": {"friction": 0.05},
        "march": {
            "speed": "1200 rpm",
            "time_step": 2e-6,
            "record_step": 1e-4,
            "duration": 0.03,
        },
        **changes,
    }
    rigid = {"disk_kind": "rigid"} if kind == "blade" else {}
    beams = common | {
        "bladed_disk": {"blades": BLADES, "elements_per_blade": 3, **rigid},
        "shaft": {"clamped": kind != "wheel"},
        "reduction": {"fixed_interface_modes": MODES},
    }
    case = bw.case_from(beams)
    stage = bw.build_stage(case)
    bw.write_superelement(file, stage.to_superelement(kind))
    kept = MODES // BLADES if kind == "blade" else MODES
    solid = common | {
        "bladed_disk": {"superelement": {"file": str(file), "kind": kind, "copies": BLADES}},
        "shaft": {"clamped": kind != "wheel"},
        "damping": {"boundary_ratio": stage.case.damping.ratio},
        "reduction": {"fixed_interface_modes": kept, "boundary": "consistent"},
    }
    solid["march"] = common["march"] | {"speed": f"{stage.speed!r} rad/s"}
    return case, bw.case_from(solid)
