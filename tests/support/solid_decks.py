"""Decks and matrices of solids that are spoiled by `fuzz.py`, and how they are read."""

import contextlib
import io
import json
import random
import shutil
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pyvista
import scipy.io as sio
import scipy.sparse as sp
from places import DATA
from solid_meshes import cantilever, deck_text
from written_decks import GROUPS, WRITERS, rounded

import bladewhirl as bw
from bladewhirl.models.inputs.errors import Hint, UserError
from bladewhirl.studies.commands.cli import main

Spoil = Callable[[bytes, random.Random], bytes]

STEEL: dict[str, Any] = {"young_modulus": "210 GPa", "poisson_ratio": 0.3, "density": 7800.0}
MATERIAL = """*MATERIAL, NAME=steel
*ELASTIC
2.1e11, 0.3
*DENSITY
7800
"""
SECTION = "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"
TURNED = """*ASSEMBLY, NAME=A
*INSTANCE, NAME=B-1, PART=B
0., 0., 0.1
0., 0., 0., 0., 0., 1., 30.
*END INSTANCE
*NODE
1, 0.4, 0, 0
*NSET, NSET=reference
1
*NSET, NSET=tip, INSTANCE=B-1
tip
*SURFACE, NAME=face
B-1.all, S4
*COUPLING, REF NODE=1, SURFACE=face
*KINEMATIC
1, 3
*END ASSEMBLY
"""


class SolidMakers:
    """Spoiled decks and matrices, by number; the good ones are made once, in a folder.

    Args:
        base: the folder.
        spoil: function that spoils the bytes of a file.
    """

    def __init__(self, base: Path, spoil: Spoil) -> None:
        self._base, self._spoil = base, spoil

    def prepare(self, kind: str) -> None:
        """Make the files that inputs of a kind begin with, and load the modules that read them."""
        warnings.simplefilter("ignore", Hint)
        good = self._base / "good"
        good.mkdir()
        mesh, quadratic = cantilever("hexahedron", (2, 1, 1)), cantilever("tetra10", (1, 1, 1))
        text = deck_text(mesh, "C3D8I")
        if kind == "inp":
            (good / "deck.inp").write_text(text + MATERIAL + SECTION)
            parts = f"*PART, NAME=B\n{text}{SECTION}*END PART\n{TURNED}{MATERIAL}"
            (good / "parts.inp").write_text(parts)
            nodes, rest = text.split("*ELEMENT", 1)
            (good / "nodes.txt").write_text(nodes.split("\n", 1)[1])
            (good / "include.inp").write_text(f"*NODE, INPUT=nodes.txt\n*ELEMENT{rest}")
            (good / "quadratic.inp").write_text(deck_text(quadratic, "C3D10"))
        elif kind == "msh":
            faces = mesh.cells[0].data[[0, 1]][:, [[0, 3, 7, 4], [1, 2, 6, 5]]][[0, 1], [0, 1]]
            cells = [("hexahedron", mesh.cells[0].data), ("quad", faces)]
            tags = [np.array([7, 7]), np.array([2, 3])]
            data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
            grouped = meshio.Mesh(mesh.points, cells, cell_data=data)
            grouped.field_data |= {"root": np.array([2, 2]), "tip": np.array([3, 2])}
            for name, binary in (("text", False), ("binary", True)):
                grouped.write(good / f"{name}.msh", file_format="gmsh22", binary=binary)
            shutil.copy(DATA / "solids" / "blade.msh", good)
        elif kind == "vtu":
            sets = {k: np.isin(np.arange(len(mesh.points)), v) for k, v in mesh.point_sets.items()}
            whole = {name: inside.astype(int) for name, inside in sets.items()}
            meshio.Mesh(mesh.points, mesh.cells, point_data=whole).write(good / "meshio.vtu")
            rows = np.column_stack([np.full(2, 8), mesh.cells[0].data]).ravel()
            grid = pyvista.UnstructuredGrid(rows, np.full(2, 12), mesh.points)
            grid.point_data.update(sets)
            grid.field_data["note"] = ["a", "b"]
            for name, binary in (("text", False), ("binary", True)):
                grid.save(good / f"{name}.vtu", binary=binary)
        elif f".{kind}" in WRITERS:
            for name, cell in (("first", "hexahedron"), ("second", "tetra10")):
                WRITERS[f".{kind}"](good / name, rounded(cell, (2, 1, 1)))
        elif kind == "calculix":
            for file in (DATA / "solids").glob("matrices.*"):
                shutil.copy(file, good)
        else:
            _write_matrices(good)
        for number in range(9):  # good ones first, which load all modules
            words = getattr(self, kind)(random.Random(number), self._base / "none", good)
            with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
                run(words)

    def inp(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """A deck of Abaqus or CalculiX with other bytes in it or in a file that it includes."""
        deck = self._spoiled(chance, folder, ".inp", good, also=("nodes.txt",))
        return self._mesh3d(deck, chance)

    def msh(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """A mesh of Gmsh with other bytes."""
        return self._mesh3d(self._spoiled(chance, folder, ".msh", good), chance)

    def vtu(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """A mesh of VTK with other bytes."""
        return self._mesh3d(self._spoiled(chance, folder, ".vtu", good), chance)

    def cdb(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """A deck of Ansys with other bytes."""
        return self._mesh3d(self._spoiled(chance, folder, ".cdb", good), chance)

    def bdf(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """Bulk data of Nastran with other bytes."""
        return self._mesh3d(self._spoiled(chance, folder, ".bdf", good), chance)

    def med(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """A mesh of Code_Aster with other bytes."""
        return self._mesh3d(self._spoiled(chance, folder, ".med", good), chance)

    def calculix(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """Input and matrices of CalculiX, of which one file has other bytes."""
        self._spoiled(chance, folder, chance.choice((".inp", ".sti", ".mas", ".dof")), good)
        return ["import", str((good or folder) / "matrices.inp"), "--contact", "tip"]

    def matrices(self, chance: random.Random, folder: Path, good: Path | None = None) -> list[str]:
        """Matrices with a table of nodes, of which one file has other bytes."""
        self._spoiled(chance, folder, chance.choice((".mtx", ".csv", ".txt")), good)
        kind, place = chance.choice(("mtx", "txt")), good or folder
        words = ["import", f"{place}/k.{kind}", "--mass", f"{place}/m.{kind}"]
        return [*words, "--nodes", f"{place}/nodes.csv", "--contact", "tip", "--clamped", "root"]

    def _spoiled(
        self,
        chance: random.Random,
        folder: Path,
        suffix: str,
        good: Path | None,
        also: tuple[str, ...] = (),
    ) -> Path:
        """Copy the good files into a folder and spoil one; return the path of a deck."""
        files = sorted((self._base / "good").glob(f"*{suffix}"))
        chosen = chance.choice(files)
        if good is not None:
            return chosen
        for file in (self._base / "good").iterdir():
            shutil.copy(file, folder)
        other = also if chance.random() < 0.2 and chosen.name.startswith("include") else ()
        target = folder / chance.choice(other or (chosen.name,))
        target.write_bytes(self._spoil(target.read_bytes(), chance))
        return folder / chosen.name

    def _mesh3d(self, deck: Path, chance: random.Random) -> list[str]:
        if chance.random() < 0.2:
            return ["mesh", str(deck)]
        given: dict[str, Any] = {"length_unit": "mm", **STEEL} if deck.name == "blade.msh" else {}
        if deck.name not in ("deck.inp", "parts.inp") and deck.suffix not in (".cdb", ".bdf"):
            given |= STEEL
        given |= GROUPS.get(deck.suffix, {})
        return ["bw.mesh3d", str(deck), json.dumps(given)]


def run(words: list[str]) -> None:
    """Give a command, or make and inspect a superelement of a mesh of solids by `bw.mesh3d`."""
    if words[0] != "bw.mesh3d":
        sys.argv = ["bladewhirl", *words]
        main()
        return
    warnings.simplefilter("ignore", Hint)
    try:
        part = bw.mesh3d(words[1], **json.loads(words[2]))
    except UserError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    print(part, abs(part.stiffness).max() > 0.0)


def _write_matrices(good: Path) -> None:
    mesh = cantilever("tetra", (2, 1, 1))
    part = bw.mesh3d(mesh, **STEEL, clamped=None)
    for name, matrix in (("k", part.stiffness), ("m", part.mass)):
        entries = sp.coo_array(matrix)
        sio.mmwrite(good / f"{name}.mtx", entries)
        rows = zip(entries.row + 1, entries.col + 1, entries.data, strict=True)
        (good / f"{name}.txt").write_text("".join(f"{i} {j} {v:.17g}\n" for i, j, v in rows))
    lines = ["node,x,y,z,group"]
    for node, (x, y, z) in enumerate(mesh.points.tolist()):
        groups = [name for name, nodes in mesh.point_sets.items() if node in nodes]
        lines.append(f"{node + 1},{x},{y},{z},{' '.join(groups)}")
    (good / "nodes.csv").write_text("\n".join(lines))
