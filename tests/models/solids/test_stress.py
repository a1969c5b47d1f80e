"""Stress at the surface of solids: uniform strain, beam theory, CalculiX, steady rotation."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from places import ROOT
from solid_meshes import CALCULIX, STEEL, bladed_sector, cantilever, deck, grid_mesh

from bladewhirl.meshes.files.abaqus_faces import SOLIDS
from bladewhirl.meshes.files.volumes import read_volume_mesh
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.solids.assembly import Solid
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.solids.materials import Materials
from bladewhirl.models.solids.stress import nodal_stress
from bladewhirl.models.solids.surface import surface_triangles
from bladewhirl.models.superelements.superelement import Superelement

STRESS = json.loads((ROOT / "tests" / "data" / "solids" / "stress.json").read_text())
"""Stress at the nodes of a cantilever [Pa] by CalculiX; calculix.py made the file."""


@pytest.mark.parametrize("name", SOLIDS)
def test_uniform_strain_has_uniform_stress(name: str, tmp_path: Path) -> None:
    """In every element, also on curved cells: the stress by the law of Hooke."""
    kind = SOLIDS[name]
    mesh = cantilever(kind, (2, 2, 1)) if name == "C3D8R" else bladed_sector(kind)
    volumes = read_volume_mesh(deck(tmp_path, mesh, name))
    cells = sum(len(each) for _, each in volumes.blocks)
    materials = Materials(np.full(cells, 2e11), np.full(cells, 0.3), np.full(cells, 7800.0))
    solid = Solid(volumes, materials)
    nodes = np.arange(len(volumes.points))
    gradient = 1e-3 * np.random.default_rng(2).standard_normal((3, 3))
    moved = np.zeros((solid.size, 3))
    moved[: len(nodes)] = volumes.points @ gradient.T
    strain = 0.5 * (gradient + gradient.T)
    law = 2e11 / 1.3 * (strain + 0.3 / 0.4 * np.trace(strain) * np.eye(3))
    expected = law[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
    found = nodal_stress(solid, nodes, materials).rows @ moved.ravel()
    everywhere = np.tile(expected, (len(nodes), 1))
    assert found.reshape(-1, 6) == pytest.approx(everywhere, abs=1e-9 * abs(expected).max())


def bent(part: Superelement, force: float) -> FloatArray:
    """Stress at the points under a force along z, equal parts of which act on the contact nodes,
    (points, 6)."""
    load = np.zeros(part.size)
    load[part.contact_dofs[:, 2]] = force / part.contacts
    return loaded(part, load)


def loaded(part: Superelement, load: FloatArray) -> FloatArray:
    """Stress at the points under a load on the coordinates, (points, 6)."""
    moved = spl.spsolve(sp.csc_array(part.stiffness), load)
    return np.asarray(part.stress_recovery @ moved).reshape(-1, 6)


def test_stress_of_a_cantilever_is_that_of_beam_theory() -> None:
    """A bar of 100 x 10 x 4 mm along y under a force of 50 N along z, at both surfaces."""

    def shape(place: Any) -> Any:
        return place[:, [1, 0, 2]] * [0.01, 0.1, 0.004] + [0.0, 0.2, -0.002]

    mesh = grid_mesh(
        *((20, 2, 2), shape, "hexahedron20"),
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
    )
    part = mesh3d(mesh, **STEEL | {"poisson_ratio": 0.0})
    stress = bent(part, 50.0)
    assert part.points is not None
    _, y, z = part.points.T
    inside = (y > 0.22) & (y < 0.28) & np.isclose(abs(z), 0.002)
    assert inside.sum() > 20
    expected = -50.0 * (0.3 - y) * z / (0.01 * 0.004**3 / 12.0)
    assert stress[inside, 1] == pytest.approx(expected[inside], rel=0.02)
    assert abs(stress[inside][:, [0, 2, 3, 5]]).max() < 0.02 * abs(expected).max()


@pytest.mark.parametrize("load", STRESS)
def test_stress_of_a_cantilever_is_that_of_calculix(load: str, tmp_path: Path) -> None:
    """At all nodes of the surface, to 5e-5 of the largest of them: under forces on the tip, and in
    steady rotation."""
    for name, rows in STRESS[load].items():
        path = deck(tmp_path, cantilever(SOLIDS[name], (8, 3, 1)), name)
        part = mesh3d(path, **STEEL, stiffening=None, mass_quadrature="reduced")
        shown, _ = surface_triangles(read_volume_mesh(path))
        expected = np.array(rows)[shown]
        if load == "tip":
            stress = bent(part, 10.0 * part.contacts)
        else:
            assert part.centrifugal_load is not None
            stress = loaded(part, CALCULIX["speed"] ** 2 * part.centrifugal_load)
        assert stress == pytest.approx(expected, abs=5e-5 * abs(expected).max()), name


def test_stress_where_materials_meet_is_that_of_the_stiffest() -> None:
    """A bar along x of two materials in the same plane state of strain: each side has its stress,
    and the nodes between them that of the stiffer one."""
    mesh = grid_mesh((4, 1, 1), lambda place: place, "hexahedron20")
    volumes = read_volume_mesh(mesh)
    young_modulus = np.array([1e11, 1e11, 3e11, 3e11])
    materials = Materials(young_modulus, np.zeros(4), np.full(4, 1e3))
    solid, nodes = Solid(volumes, materials), np.arange(len(volumes.points))
    found = nodal_stress(solid, nodes, materials)
    moved = np.zeros_like(volumes.points)
    moved[:, 0] = 1e-3 * volumes.points[:, 0]
    expected = np.where(volumes.points[:, 0] < 0.5 - 1e-9, 1e11, 3e11)
    assert found.young_modulus == pytest.approx(expected)
    stress = (found.rows @ moved.ravel()).reshape(-1, 6)
    assert stress[:, 0] == pytest.approx(1e-3 * expected)
    assert abs(stress[:, 1:]).max() < 1e-6 * stress.max()
