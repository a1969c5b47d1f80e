"""The table of studies and kinds of stages: each study is tried on a small stage of each kind."""

import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import skfem
from meshio import Mesh
from skfem.io.meshio import to_meshio

import bladewhirl as bw
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.models.superelements.superelement import Superelement
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.shaft_line import reports

BLADES = 3
SECTOR = (-0.5, -0.15, 0.15, 0.5)  #: angles of a sector over that between two blades
KINDS = ("beams", "copies of a blade", "sector", "wheel", "wheel with a hub", "shaft line")
BORE = "r < 0.101"  #: nodes of the bore
ROTATING = {"rotation": {"effects": "full"}}
STIFFNESS = np.array([1e7])  #: of a shaft [N/m]
ORDER = {"type": "engine-order", "order": 1}
WALL = {
    "type": "rigid",
    "clearance": 1e-4,
    "profile": {"harmonics": [{"lobes": BLADES, "amplitude": 2e-4}]},
}
COATING = {
    "thickness": 5e-3,
    "young_modulus": 1e9,
    "yield_stress": 1e6,
    "hardening": 1e7,
    "footprint": 5e-3,
}

DRIVEN = {"march": {"speed": "600 rpm", "drive": {"inertia": 1.0}}}
LINE = {
    "shaft_line": {
        "segments": [{"length": 0.5, "outer_diameter": 0.05}],
        "bearings": [{"position": end, "stiffness": [[1e7, 0], [0, 1e7]]} for end in (0.0, 0.5)],
    }
}

WITH_WHEEL = {
    "shaft_line": {
        **LINE["shaft_line"],
        "wheel": {"position": 0.5},
        "unbalance": [{"position": 0.5, "unbalance": 0.01}],
    },
    "casing": {"type": "rigid", "clearance": 1e-4},
}

Tables = Mapping[str, Mapping[str, Any]]

ROWS: dict[str, tuple[Callable[[bw.Case], object], Tables]] = {
    "`modes`": (bw.modes, {}),
    "`campbell`": (lambda case: bw.campbell(case, families=1, speeds=(0.0, 0.5)), ROTATING),
    "`critical-speeds`": (lambda case: bw.critical_speeds(case, stiffnesses=STIFFNESS), ROTATING),
    "`veering`": (lambda case: bw.veering(case, families=1, stiffnesses=STIFFNESS), {}),
    "`response`": (lambda case: bw.response(case, speeds=[0.5]), {"excitation": ORDER}),
    "`stability`": (lambda case: bw.stability(case, speed=0.9, kappa=10.0), {}),
    "`periodic`, wall that is not round": (bw.periodic, {"casing": WALL}),
    "`periodic`, imbalance": (
        bw.periodic,
        {
            "excitation": {"type": "imbalance", "clearance_speed": 0.5},
            "casing": {"type": "rigid", "clearance": 1e-4},
            "contact": {"friction": 0.0},
            "march": {"speed": 0.55},
        },
    ),
    "`run`, `sweep`": (prepare, {}),
    'with `excitation.type = "imbalance"`': (prepare, {"excitation": {"type": "imbalance"}}),
    "with `bladed_disk.mistuning`": (
        prepare,
        {"bladed_disk": {"mistuning": {"stiffness_spread": 0.01}}},
    ),
    "with `casing.coating`": (prepare, {"casing": {"coating": COATING}}),
    "with `contact.foreshortening`": (prepare, {"contact": {"foreshortening": True}}),
    "with `march.speed_table`": (
        prepare,
        {**ROTATING, "march": {"speed_table": [[0, "600 rpm"], [1, "700 rpm"]]}},
    ),
    "with `march.drive`": (prepare, DRIVEN),
    "with `march.drive` and rotation effects": (prepare, {**ROTATING, **DRIVEN}),
    "with `[blade_loss]`": (prepare, {"blade_loss": {"blade": 1, "time": 5e-4}}),
    "with `shaft.fuse_force`": (
        prepare,
        {"shaft": {"fuse_force": 1e4, "fused_stiffness": 1e6}},
    ),
}
"""Commands and what a march may contain: the function that is tried, and the tables of its case."""


def table() -> str:
    """Return a Markdown table of the studies that each kind of stage takes."""
    taken = [taken_by(kind) for kind in KINDS]
    rows = [[name, *("yes" if name in names else "–" for names in taken)] for name in ROWS]
    head = ["study", *KINDS]
    return "".join(f"| {' | '.join(row)} |\n" for row in [head, ["---"] * len(head), *rows])


def taken_by(kind: str) -> set[str]:
    """Return the names of the studies that a kind of stage takes."""
    if kind == "shaft line":  # its own functions, by the names of commands
        lines = {name for name in ROWS if hasattr(reports, name.strip("`").replace("-", "_"))}
        with tempfile.TemporaryDirectory() as scratch:
            wheel = {**_disk("wheel with a hub", Path(scratch), "full"), **WITH_WHEEL}
            kinds = (LINE, wheel)
            return lines | {name for name in ROWS if any(_accepts(name, one) for one in kinds)}
    with tempfile.TemporaryDirectory() as scratch, warnings.catch_warnings():
        warnings.simplefilter("ignore", Hint)
        # A superelement with Coriolis forces is that of one speed, unless effects of rotation act.
        turning, still = (_disk(kind, Path(scratch), effects) for effects in ("full", "none"))
        return {
            name
            for name, (_, tables) in ROWS.items()
            if _accepts(name, turning if "rotation" in tables else still)
        }


def _accepts(name: str, disk: Tables) -> bool:
    """Return whether a study accepts a stage, given by the tables of its bladed disk."""
    tried, tables = ROWS[name]
    given = {key: {**disk.get(key, {}), **tables.get(key, {})} for key in {*disk, *tables}}
    if "shaft_line" in disk:
        given.pop("rotation", None)  # a line has these effects without the table
        if tried is bw.periodic:
            given.pop("excitation", None)  # unbalances of the line are imbalances
    try:
        tried(bw.case_from(given))
    except bw.UserError:
        return False
    return True


def _disk(kind: str, folder: Path, effects: str) -> Tables:
    """Return the tables of a small stage with a bladed disk of a kind; a superelement is written
    into a folder, with Coriolis forces for the rotation effects "full"."""
    beams: Tables = {
        "bladed_disk": {"blades": BLADES, "elements_per_blade": 2},
        "reduction": {"fixed_interface_modes": 2 * BLADES},
        "casing": {"elements": 6},
        "march": {"time_step": 2e-7, "record_step": 2e-5, "duration": 1e-3},
    }
    if kind == "beams":
        return beams
    part = _solid(kind, coriolis=effects == "full")
    file = folder / f"{effects}.npz"
    bw.write_superelement(file, part)
    source = {"file": str(file), "kind": "wheel" if "wheel" in kind else kind.split()[-1]}
    return {
        **beams,
        "bladed_disk": {"superelement": {**source, "copies": BLADES}},
        "reduction": {"free_interface_modes": 8 if "wheel" in kind else 2},
    }


def _solid(kind: str, *, coriolis: bool) -> Superelement:
    """Return a superelement of hexahedra."""
    of_kind: dict[str, dict[str, Any]] = {
        "copies of a blade": {"mesh": _mesh(SECTOR[1:3])},
        "sector": {"mesh": _mesh(SECTOR), "left": "angle = -60", "right": "angle = 60"},
        "wheel": {"mesh": _mesh(SECTOR, BLADES)},
        "wheel with a hub": {"mesh": _mesh(SECTOR, BLADES), "clamped": None, "hub": BORE},
    }
    if kind != "copies of a blade":
        of_kind[kind] |= {"copies": BLADES, "blade": "r > 0.15"}
    given: dict[str, Any] = {
        "clamped": BORE,
        **of_kind[kind],
        "contact": "outermost",
        "coriolis": coriolis,
    }
    return bw.mesh3d(**given, young_modulus=210e9, poisson_ratio=0.3, density=7800.0)


def _mesh(angles: Sequence[float], sectors: int = 1) -> Mesh:
    """Return a mesh of blades of hexahedra on a ring: angles over that between two blades, from the
    middle of a blade."""
    around = np.unique([sector + angle for sector in range(sectors) for angle in angles])
    grid = skfem.MeshHex.init_tensor(np.array([0.1, 0.15, 0.22, 0.3]), around, np.array([0, 0.02]))
    radius, place, _ = grid.p[:, grid.t].mean(axis=1)
    between = (radius > 0.15) & (abs(place - place.round()) > SECTOR[2])
    mesh = to_meshio(grid.remove_elements(np.flatnonzero(between)))
    r, a, z = mesh.points.T
    a = a * 2 * np.pi / BLADES
    mesh.points = np.column_stack([r * np.cos(a), r * np.sin(a), z])
    return mesh
