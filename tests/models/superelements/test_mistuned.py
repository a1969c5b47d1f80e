"""Sectors and wheels whose blades differ in stiffness."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from exported_stages import BLADES, beams, exported
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector, cantilever

import bladewhirl as bw
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.superelements.mistuned import mistuned_wheel
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError, dense
from bladewhirl.models.superelements.wheel import whole_wheel

FACTORS = [1.04, 0.97, 1.01, 0.95, 1.02]


def of_disk(case: bw.Case, count: int) -> Any:
    found = bw.modes(case)
    return found.isel(mode=(found["centre"] == "clamped").values).isel(mode=slice(count))


@pytest.mark.slow
def test_a_mistuned_sector_has_the_modes_of_mistuned_beams(tmp_path: Path) -> None:
    tuned, factors = beams("sector"), {"bladed_disk.mistuning": {"stiffness": FACTORS}}
    expected = of_disk(bw.with_values(tuned, factors), 10)
    found = of_disk(bw.with_values(exported(tuned, "sector", tmp_path), factors), 10)
    assert found["frequency"].values == pytest.approx(expected["frequency"].values, rel=1e-8)
    without = of_disk(exported(tuned, "sector", tmp_path), 10)
    assert np.abs(found["frequency"].values / without["frequency"].values - 1.0).max() > 0.01
    pure = expected["purity"].values > 0.5  # of others, nodal diameters compete
    assert pure.any()
    same = found["nodal_diameter"].values == expected["nodal_diameter"].values
    assert same[pure].all()


@pytest.fixture(scope="module")
def sector() -> Superelement:
    mesh = bladed_sector("hexahedron")
    return mesh3d(mesh, **STEEL, **TIE, contacts=3, blade="r > 0.0899")


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "centrifugal"])
def test_a_mistuned_sector_of_solids_has_the_modes_of_its_wheel(
    effects: str, sector: Superelement, tmp_path: Path
) -> None:
    factors = 1.0 + 0.03 * np.random.default_rng(1).standard_normal(SECTORS)
    bw.write_superelement(tmp_path / "part.npz", sector)
    table = {"file": str(tmp_path / "part.npz"), "kind": "sector", "copies": SECTORS}
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": table, "mistuning": {"stiffness": factors.tolist()}},
            "casing": {"type": "rigid"},
            "shaft": {"clamped": True},
            "march": {"speed": "3000 rad/s"},
            "rotation": {"effects": effects},
            "reduction": {"free_interface_modes": 5},
        }
    )
    wheel = mistuned_wheel(whole_wheel(sector, SECTORS), factors)
    if effects != "none":
        wheel = wheel.at(3000.0, "centrifugal")
    squares = la.eigh(dense(wheel.stiffness), dense(wheel.mass), subset_by_index=[0, 29])[0]
    found = build_matrices(case)
    assert found.reduced.frequency[:30] == pytest.approx(np.sqrt(squares), rel=1e-7)
    rows = wheel.contact_rows.toarray()
    static = np.diag(rows @ np.linalg.solve(dense(wheel.stiffness), rows.T))
    modal = (found.reduced.contact**2 / found.reduced.frequency**2).sum(axis=1)
    flexible = modal + np.diag(found.reduced.compliance)
    assert flexible[::3].max() == pytest.approx(static[::3].max(), rel=1e-3)


def test_the_factor_of_a_blade_scales_its_stiffness_only() -> None:
    """Two blades of three coordinates each on a disk of one coordinate, by hand."""
    blade = np.array([[4.0, -1.0, 0.0], [-1.0, 5.0, -2.0], [0.0, -2.0, 6.0]])
    blades = np.zeros((7, 7))
    blades[:3, :3], blades[3:6, 3:6] = blade, blade
    angle = np.array([0.0, np.pi])
    wheel = Superelement(
        mass=np.eye(7),
        stiffness=blades + np.diag([0.0] * 6 + [9.0]),
        blade_stiffness=blades,
        contact_position=np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle]),
        contact_dofs=np.arange(6).reshape(2, 3),
    )
    found = mistuned_wheel(wheel, np.array([1.1, 0.7]))
    expected = np.diag([0.0] * 6 + [9.0])
    expected[:3, :3], expected[3:6, 3:6] = 1.1 * blade, 0.7 * blade
    assert dense(found.stiffness) == pytest.approx(expected, rel=1e-14)
    assert found.blade_stiffness is None


def test_blades_of_a_wheel_must_be_separate(sector: Superelement) -> None:
    wheel = whole_wheel(sector, SECTORS)
    joined = replace(wheel, blade_stiffness=wheel.stiffness)
    with pytest.raises(SuperelementError, match=r"blade_stiffness: .* blade 1 is part of another"):
        mistuned_wheel(joined, np.full(SECTORS, 1.1))


def test_mistuning_needs_the_stiffness_of_the_blades(tmp_path: Path) -> None:
    case = exported(beams("wheel"), "wheel", tmp_path)
    with pytest.raises(CaseError, match="expected a file with blade_stiffness"):
        bw.with_values(case, {"bladed_disk.mistuning": {"stiffness": FACTORS}})
    assert len(FACTORS) == BLADES


def test_a_blade_needs_elements() -> None:
    with pytest.raises(CaseError, match='blade = "r > 299 mm": expected all nodes of at least one'):
        mesh3d(cantilever("hexahedron"), **STEEL, blade="r > 299 mm")
