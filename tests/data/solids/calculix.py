"""Compute natural frequencies of a blade and a bladed disk with CalculiX; write calculix.json, and
matrices of a small rotating blade: matrices.inp with .sti, .mas and .dof.

Run in the root of the repository, with CalculiX (Debian package calculix-ccx; 2.20 was used):
PYTHONPATH=tests/support python tests/data/solids/calculix.py
"""

import json
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from solid_meshes import (
    RIGID_TIP,
    SECTORS,
    bladed_sector,
    cantilever,
    deck_text,
    half_cantilever,
    joined,
    node_set,
)

from bladewhirl.meshes.cells import CELL_TYPES
from bladewhirl.meshes.files.abaqus_faces import SOLIDS

SPEED = 1500.0
"""Speed of rotation [rad/s]."""

FACES = {
    4: ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    6: ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    8: (
        *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
        *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    ),
}
"""Corners of the faces S1, S2 and so on of the elements of CalculiX, by the number of corners."""

STEEL = """*MATERIAL, NAME=steel
*ELASTIC
210e9, 0.3
*DENSITY
7800.0
*SOLID SECTION, ELSET=all, MATERIAL=steel
"""


def sector_text(mesh, element: str) -> str:
    """Return a mesh with cyclic symmetry; the right face depends on the left one."""
    left, right = (set(mesh.point_sets[name].tolist()) for name in ("left", "right"))
    text = deck_text(mesh, element) + STEEL
    text += node_set("held", sorted(set(mesh.point_sets["root"].tolist()) - right))
    text += "*SURFACE, NAME=Sright, TYPE=NODE\nright,\n*SURFACE, NAME=Sleft\n"
    for number, cell in enumerate(mesh.cells[0].data.tolist(), 1):
        for face, corners in enumerate(FACES[len(CELL_TYPES[SOLIDS[element]].corners)], 1):
            if {cell[corner] for corner in corners} <= left:
                text += f"{number}, S{face}\n"
    text += "*TIE, NAME=faces, CYCLIC SYMMETRY, POSITION TOLERANCE=1e-5\nSright, Sleft\n"
    text += f"*CYCLIC SYMMETRY MODEL, N={SECTORS}, NGRAPH=1, TIE=faces\n0, 0, 0, 0, 0, 1\n"
    return text + "*BOUNDARY\nheld, 1, 3\n"


def steps(step: str, speed: float) -> str:
    """Return a step, after a static step under centrifugal forces."""
    load = f"*DLOAD\nall, CENTRIF, {speed**2!r}, 0, 0, 0, 0, 0, 1\n"
    if not speed:
        return f"*STEP\n{step}*END STEP\n"
    return f"*STEP\n*STATIC\n{load}*END STEP\n*STEP, PERTURBATION\n{step}*END STEP\n"


def frequencies(model: str, modes: str, speed: float) -> list[tuple[int, float]]:
    """Return the first numbers and the frequencies [Hz] of the table of eigenvalues."""
    with TemporaryDirectory() as folder:
        (Path(folder) / "job.inp").write_text(model + steps(f"*FREQUENCY\n{modes}", speed))
        subprocess.run(["ccx", "job"], cwd=folder, check=True, capture_output=True)
        table = (Path(folder) / "job.dat").read_text().split("P A R T I C I P A T I O N")
    words = [line.split() for part in table for line in part.splitlines()]
    actual = [one for one in words if len(one) in (5, 6) and one[0].isdigit() and one[-5].isdigit()]
    return [(int(one[0]), float(one[-2])) for one in actual]


LOADS = {
    "tip": "*CLOAD\ntip, 3, 10.0\n",
    "rotation": f"*DLOAD\nall, CENTRIF, {SPEED**2!r}, 0, 0, 0, 0, 0, 1\n",
}
"""Loads of static steps: 10 N along z on each node of the tip; steady rotation."""


def nodal_stress(element: str, load: str) -> list[list[float]]:
    """Return the stress xx, yy, zz, xy, yz and zx [Pa] at the nodes of the cantilever, from the
    file .frd, which has six digits."""
    model = deck_text(cantilever(SOLIDS[element], (8, 3, 1)), element) + STEEL
    step = f"*STEP\n*STATIC\n{LOADS[load]}*EL FILE\nS\n*END STEP\n"
    with TemporaryDirectory() as folder:
        (Path(folder) / "job.inp").write_text(f"{model}*BOUNDARY\nroot, 1, 3\n{step}")
        subprocess.run(["ccx", "job"], cwd=folder, check=True, capture_output=True)
        block = (Path(folder) / "job.frd").read_text().partition("STRESS")[2]
    rows = [line for line in block.partition("\n -3")[0].splitlines() if line[:3] == " -1"]
    return [[float(row[at : at + 12]) for at in range(13, 85, 12)] for row in rows]


content: dict = {"speed": SPEED, "sectors": SECTORS}
for kind, shape in SOLIDS.items():
    model = deck_text(cantilever(shape), kind) + STEEL + "*BOUNDARY\nroot, 1, 3\n"
    for key, speed in (("blade", 0.0), ("rotating blade", SPEED)):
        found = [value for _, value in frequencies(model, "10\n", speed)]
        content.setdefault(key, {})[kind] = found
mixed = joined(half_cantilever("wedge15", outer=False), half_cantilever("hexahedron20", outer=True))
model = deck_text(mixed, "C3D15", "C3D20R") + STEEL + "*BOUNDARY\nroot, 1, 3\n"
content["wedges and hexahedra"] = [value for _, value in frequencies(model, "10\n", 0.0)]
here = Path(__file__).parent
model = (here / "two_materials.inp").read_text() + "*BOUNDARY\nroot, 1, 3\n"
content["two materials"] = frequencies(model, "3\n", 0.0)[0][1]
model = deck_text(cantilever("hexahedron20"), "C3D20") + RIGID_TIP + STEEL
content["rigid tip"] = [
    value for _, value in frequencies(f"{model}*BOUNDARY\nroot, 1, 3\n", "8\n", 0.0)
]
for kind, shape in SOLIDS.items():
    if kind == "C3D8R":
        continue  # only parallelepipeds are read
    model = sector_text(bladed_sector(shape), kind)
    select = "20\n*SELECT CYCLIC SYMMETRY MODES, NMIN=0, NMAX=6\n"
    for key, speed in (("sector", 0.0), ("rotating sector", SPEED)):
        found = frequencies(model, select, speed)
        # Each wave appears twice, also where there is only one.
        content.setdefault(key, {})[kind] = [
            [value for number, value in found if number == k][::2] for k in range(7)
        ]
(here / "calculix.json").write_text(json.dumps(content, indent=1) + "\n")
loaded = ("C3D8I", "C3D10", "C3D15", "C3D20", "C3D20R")
stress = {load: {kind: nodal_stress(kind, load) for kind in loaded} for load in LOADS}
(here / "stress.json").write_text(json.dumps(stress) + "\n")
model = deck_text(cantilever("tetra", (2, 1, 1)), "C3D4") + STEEL + "*BOUNDARY\nroot, 1, 3\n"
with TemporaryDirectory() as folder:
    deck = Path(folder) / "matrices.inp"
    deck.write_text(model + steps("*FREQUENCY, SOLVER=MATRIXSTORAGE\n", SPEED))
    subprocess.run(["ccx", "matrices"], cwd=folder, check=True, capture_output=True)
    for suffix in (".inp", ".sti", ".mas", ".dof"):
        (here / "matrices").with_suffix(suffix).write_text(deck.with_suffix(suffix).read_text())
