"""A stage of beams, and the same stage as a superelement."""

from pathlib import Path
from typing import Any, Literal

import bladewhirl as bw

Kind = Literal["wheel", "sector", "blade"]

BLADES = 5


def beams(kind: Kind = "wheel", **tables: Any) -> bw.Case:
    """Return a small case of beams that can be exported as a superelement of a kind."""
    disk: dict[str, Any] = {"blades": BLADES, "elements_per_blade": 2}
    if kind == "blade":
        disk["disk_kind"] = "rigid"
    given: dict[str, Any] = {
        "bladed_disk": disk,
        "shaft": {"stiffness": 2e7, "clamped": kind != "wheel"},
        "casing": {"elements": 20, "support": 7.975e6},
        "reduction": {"fixed_interface_modes": 10},
        "march": {"speed": 0.6, "time_step": 1e-6},
    }
    return bw.case_from(given | tables)


def exported(case: bw.Case, kind: Kind, folder: Path, **tables: Any) -> bw.Case:
    """Return the case of a stage of beams as a superelement, in a file in a folder."""
    file = folder / f"{kind}.npz"
    bw.write_superelement(file, bw.build_stage(case).to_superelement(kind))
    table = {"file": str(file), "kind": kind, "copies": BLADES}
    shaft = case.shaft.model_dump(exclude_defaults=True, exclude={"clamped"})
    given = case.model_dump(exclude_none=True, include={"casing", "march", "rotation"})
    given |= {
        "bladed_disk": {"superelement": table},
        "reduction": {"free_interface_modes": 4},
        **({"shaft": shaft} if kind == "wheel" else {}),
    }
    return bw.case_from(given | tables)
