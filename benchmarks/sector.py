"""Time and memory until a large sector is ready to march: `python benchmarks/sector.py`.

The sector is one of 36 of a bladed disk, meshed with hexahedra of 20 nodes and reduced integration
(C3D20R). By default it has 70,935 displacements, 68,856 of them free. It is reduced for all nodal
diameters by one process per core, without the cache of reduced sectors. CalculiX 2.20 gives the
frequencies of nodal diameters 0 to 8 with the same seven digits, in 37 minutes on one core.

`--thick` takes one of 90 sectors of a thick ring in place of it, with 58,680 free displacements and
9,240 of them on each cut face, and compares the modes of ten nodal diameters with a script of SciPy
that factorises once for each nodal diameter.
"""

import argparse
import resource
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.sparse.linalg import eigsh

import bladewhirl as bw
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.sector import Sector
from bladewhirl.studies.runs.prepare import prepare

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))
from solid_meshes import STEEL, deck_text, grid_mesh

SECTORS, THICK = 36, 90  #: number of sectors of the bladed disk, and of the thick ring
MODES, DIAMETERS = 6, 10  #: number of modes of each nodal diameter, and of nodal diameters compared


def place(unit: np.ndarray) -> np.ndarray:
    """Return positions in the sector of points in the unit cube, (n, 3): a ring of radii 150 to
    190 mm that holds a twisted blade up to 250 mm."""
    radius = 0.15 + 0.1 * unit[:, 0]
    blade = np.maximum(radius - 0.19, 0.0)
    angle = 2.0 * np.pi / SECTORS * (unit[:, 1] - 0.5) * (1.0 - 5.0 * blade) - blade
    z = 0.02 * (unit[:, 2] - 0.5) * (1.0 - 5.0 * blade) + blade * (unit[:, 1] - 0.5)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)


def in_ring(unit: np.ndarray) -> np.ndarray:
    """Return positions in a sector of a thick ring of points in the unit cube, (n, 3)."""
    radius, angle = 0.15 + 0.1 * unit[:, 0], 2.0 * np.pi / THICK * (unit[:, 1] - 0.5)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.08 * unit[:, 2]], axis=1)


def compare(boxes: tuple[int, int, int]) -> None:
    """Print processor time, memory and frequencies of ten nodal diameters of a thick ring."""
    mesh = grid_mesh(
        *(boxes, in_ring, "hexahedron20", lambda centre: True),
        root=lambda unit: unit[:, 0] == 0.0,
        tip=lambda unit: unit[:, 0] == 1.0,
        left=lambda unit: unit[:, 1] == 0.0,
        right=lambda unit: unit[:, 1] == 1.0,
    )
    part = bw.mesh3d(
        mesh, **STEEL, contacts=3, left="left", right="right", copies=THICK, clamped="root",
        contact="tip", stiffening=None, stress=False,
    )  # fmt: skip
    assert part.left_dofs is not None
    print(f"{part.size} coordinates, {part.left_dofs.size} on each face")

    def own() -> list[np.ndarray]:
        sector = Sector(part, THICK, modes=MODES, loads=0, rigid=False)
        return [*sector.each_wave(lambda k: sector.wave(k).lowest(MODES)[0], range(DIAMETERS))]

    def scipy() -> list[np.ndarray]:
        found = []
        for k in range(DIAMETERS):
            tie = transformation(part, THICK, k)
            stiffness, mass = (
                (tie.conj().T @ matrix @ tie).tocsc() for matrix in (part.stiffness, part.mass)
            )
            found.append(eigsh(stiffness, MODES, mass, sigma=0.0, return_eigenvectors=False))
        return found

    for name, compute in {"bladewhirl": own, "SciPy": scipy}.items():
        start = time.process_time()
        hertz = np.sqrt(np.sort(np.array(compute()), axis=1)[:, 0]) / (2.0 * np.pi)
        used, memory = time.process_time() - start, resource.getrusage(resource.RUSAGE_SELF)
        print(
            f"{name}: {used:.1f} s of processor time, at most {memory.ru_maxrss / 1e6:.2f} GB so"
            f" far; lowest family: {hertz.min():.7g} to {hertz.max():.7g} Hz",
            flush=True,
        )


def main() -> None:
    """Mesh, assemble and reduce the sector; print times, memory and frequencies."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--boxes", type=int, nargs=3)
    parser.add_argument("--thick", action="store_true")
    given = parser.parse_args()
    if given.thick:
        compare(tuple(given.boxes or (40, 4, 25)))
        return
    boxes = given.boxes or (40, 21, 10)
    mesh = grid_mesh(
        *(tuple(boxes), place, "hexahedron20"),
        lambda centre: centre[0] < 0.4 or 1 / 3 < centre[1] < 2 / 3,
        root=lambda unit: unit[:, 0] == 0.0,
        tip=lambda unit: unit[:, 0] == 1.0,
        left=lambda unit: (unit[:, 1] == 0.0) & (unit[:, 0] <= 0.4 + 1e-9),
        right=lambda unit: (unit[:, 1] == 1.0) & (unit[:, 0] <= 0.4 + 1e-9),
    )
    with TemporaryDirectory() as folder:
        deck, file = Path(folder) / "sector.inp", Path(folder) / "sector.npz"
        deck.write_text(deck_text(mesh, "C3D20R"))
        start = time.perf_counter()
        part = bw.mesh3d(
            deck, **STEEL, contacts=5, left="left", right="right", copies=SECTORS,
            stiffening=None, stress=False,
        )  # fmt: skip
        made = time.perf_counter()
        print(f"{3 * len(mesh.points)} displacements; superelement after {made - start:.1f} s")
        bw.write_superelement(file, part)
        table = {"file": str(file), "kind": "sector", "copies": SECTORS}
        case = bw.case_from(
            {
                "bladed_disk": {"superelement": table},
                "reduction": {"free_interface_modes": 6},
                "casing": {"type": "rigid"},
                "march": {"speed": "3000 rpm", "duration": "1 ms", "time_step": "1 us"},
            }
        )
        rotor = prepare(case).problem.rotor
    ready = time.perf_counter() - made
    users = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
    memory = sum(resource.getrusage(user).ru_maxrss for user in users) / 1e6
    hertz = np.sort(rotor.frequency)[:SECTORS] / (2.0 * np.pi)
    print(f"ready to march after {ready:.0f} s, at most {memory:.1f} GB")
    print(f"lowest family: {hertz[0]:.7g} to {hertz[-1]:.7g} Hz")


if __name__ == "__main__":
    main()
