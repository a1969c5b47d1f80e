"""Matrices of CalculiX: .inp with .sti, .mas and .dof.

CalculiX writes them in a step with *FREQUENCY, SOLVER=MATRIXSTORAGE. Each line of .sti and .mas has
row, column and value of one triangle; line i of .dof has node and direction of row i, such as 17.3.
Fixed displacements are left out; displacements that equations tie to others are eliminated.
"""

from pathlib import Path

import numpy as np

from bladewhirl.files import open_text, plain
from bladewhirl.meshes.files.abaqus_reader import read_abaqus
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import read_volume_mesh
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.imports.parts import ForeignPart
from bladewhirl.models.imports.tables import read_triplets
from bladewhirl.models.solids.surface import surface_triangles
from bladewhirl.models.superelements.containers import read_foreign
from bladewhirl.models.superelements.superelement import FIXED, SuperelementError


def read_calculix(path: Path, *, outside: bool = False) -> ForeignPart:
    """Read the matrices that CalculiX wrote for an input file, and the nodes and sets of this file.

    Args:
        path: path of the input file.
        outside: whether files that it names may be outside its folder.

    Raises:
        SuperelementError: a file is missing or invalid, or the files do not belong together.
    """
    try:
        deck = read_abaqus(path, outside=outside)
    except MeshFileError as error:
        raise SuperelementError(f"{path}: expected {error}") from None
    files = [path.with_suffix(suffix) for suffix in (".sti", ".mas", ".dof")]
    missing = [file.name for file in files if not file.is_file()]
    if missing:
        raise SuperelementError(
            f"{path}: expected {', '.join(missing)} in the same folder; CalculiX writes them in a"
            " step with *FREQUENCY, SOLVER=MATRIXSTORAGE"
        )
    kind = "lines of node and direction such as 17.3"
    entries = read_foreign(files[2], kind, lambda: _displacements(files[2]))
    stiffness, mass = (read_triplets(file, len(entries)) for file in files[:2])
    place = {number: row for row, number in enumerate(deck.points)}
    dofs = np.full((len(place), 3), FIXED, dtype=np.int64)
    for row, (node, direction) in enumerate(entries.tolist()):
        if node not in place or not 1 <= direction <= 3:
            raise SuperelementError(
                f"{files[2]}: expected displacements 1 to 3 of the nodes of {path.name}, got"
                f" {node}.{direction}; elements of solids only are read, not shells and beams"
            )
        dofs[place[node], direction - 1] = row
    return ForeignPart(
        source=f"{path.name} of CalculiX",
        mass=mass,
        stiffness=stiffness,
        numbers=np.array([*deck.points], dtype=np.int64),
        points=np.array([*deck.points.values()], dtype=np.float64),
        dofs=dofs,
        groups={
            name: np.array(sorted({place[node] for node in nodes if node in place}), dtype=np.int64)
            for name, nodes in deck.groups().items()
        },
        surface=_surface(path, outside=outside),
    )


def _displacements(path: Path) -> IntArray:
    """Return node and direction of each row, (rows, 2)."""
    with open_text(path) as stream:
        pairs = [word.split(".") for word in plain(stream.read()).split()]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _surface(path: Path, *, outside: bool) -> IntArray | None:
    """Return the nodes of the surface triangles; None without solids of supported elements."""
    try:
        mesh = read_volume_mesh(path, outside=outside)
    except MeshFileError:
        return None
    shown, triangles = surface_triangles(mesh)
    return np.asarray(mesh.rows[shown][triangles])
