"""Worn volume, impulse and dissipated energy do not depend on how a tip is divided."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_meshes import STEEL, cantilever
from symmetric_cases import marched

import bladewhirl as bw
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.coating import node_footprint, tip_thickness

LAYER = {"thickness": 1.5e-3, "young_modulus": 3e8, "yield_stress": 2e6, "hardening": 2e7}


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("parts")
    for contacts in (2, 3, 5):
        part = bw.mesh3d(cantilever("hexahedron20", (4, 4, 1)), **STEEL, contacts=contacts)
        bw.write_superelement(folder / f"{contacts}.npz", part)
    return folder


def case(parts: Path, contacts: int = 3, copies: int = 1, **changes: Any) -> dict[str, Any]:
    table = {"file": str(parts / f"{contacts}.npz"), "copies": copies}
    casing = {"type": "rigid", "clearance": 1e-4}
    casing |= {"clearance_lobes": [{"lobes": 2, "amplitude": 9e-5}]}
    casing |= {"closure": {"amount": 1e-4, "time_constant": 2e-3}, "coating": LAYER | changes}
    return {
        "bladed_disk": {"superelement": table},
        "reduction": {"free_interface_modes": 6},
        "casing": casing,
        "contact": {"friction": 0.0},
        "damping": {"ratio": 0.01},
        "march": {"speed": "600 rad/s", "time_step": 1e-6, "duration": 8e-3, "record_step": 1e-4},
    }


def measures(given: dict[str, Any]) -> list[float]:
    """Volume [m3], normal impulse [N s] and dissipated energy [J]."""
    result = marched(given)
    sums = result["contact_impulse"].values.sum()
    return [float(result[name][-1]) for name in ("wear_volume", "wear_dissipated")] + [float(sums)]


@pytest.mark.parametrize("changes", [{}, {"footprint": 3e-3}])
def test_wear_does_not_depend_on_the_number_of_contact_nodes(parts: Path, changes: Any) -> None:
    two, three, five = (measures(case(parts, n, **changes)) for n in (2, 3, 5))
    assert min(three) > 0.0
    assert three == pytest.approx(five, rel=0.01)
    assert two == pytest.approx(five, rel=0.03)


def test_wear_does_not_depend_on_the_number_of_rods(parts: Path) -> None:
    one = measures(case(parts))
    assert measures(case(parts, elements=3000)) == pytest.approx(one, rel=0.02)


def test_tracks_are_as_wide_and_footprints_as_long_as_the_tip(parts: Path) -> None:
    """A tip of 30 x 5 mm, staggered by 30 degrees."""
    for contacts in (2, 3, 5):
        coating = build_matrices(bw.case_from(case(parts, contacts))).coating
        assert coating is not None
        assert coating.width.sum() == pytest.approx(0.015)
        assert coating.footprint == pytest.approx(np.full(contacts, 0.01), rel=1e-2)
        assert coating.footprint @ coating.width == pytest.approx(0.03 * 0.005, rel=1e-3)
    part = bw.read_superelement(parts / "3.npz")
    thickness = tip_thickness(part, 1)
    assert thickness == pytest.approx(np.full(3, 0.01), rel=1e-2)
    assert part.triangles is not None
    inward = replace(part, triangles=part.triangles[:, ::-1])
    assert tip_thickness(inward, 1) == pytest.approx(thickness)


def test_nodes_in_one_track_share_the_thickness_of_the_tip(parts: Path) -> None:
    """Two nodes in each of two tracks, 2 mm apart, on a tip that is 10 mm thick along the arc."""
    part = bw.read_superelement(parts / "2.npz")
    given = bw.case_from(case(parts, 2))
    places = part.contact_position[[0, 0, 1, 1]] + 1e-3 * np.array(
        [[0.0, k, 0.0] for k in (-1, 1, -1, 1)]
    )
    four = replace(part, contact_position=places, contact_dofs=np.arange(12).reshape(4, 3))
    nowhere = np.zeros(4, dtype=np.int64)
    footprint = node_footprint(given, four, nowhere, tip_thickness(part, 1))
    assert footprint == pytest.approx(np.full(4, 0.005), rel=1e-2)


@pytest.mark.parametrize("copies", [2, 7])
def test_the_number_of_rods_is_the_same_for_each_blade(parts: Path, copies: int) -> None:
    coating = build_matrices(bw.case_from(case(parts, copies=copies))).coating
    assert coating is not None
    assert coating.strain.shape[1] % copies == 0


def test_a_stiff_coating_is_solved_and_acts_as_a_rigid_wall(parts: Path) -> None:
    """Rods that do not yield, from soft to almost rigid."""
    impulses = []
    for modulus in (1e9, 1e11, 1e12, 1e13, None):
        given = case(parts)
        given["march"] |= {"duration": 4e-3, "unsolved_share": 0.0}
        given["casing"]["closure"] = {"amount": 1e-4, "time_constant": 5e-3}
        given["casing"].pop("coating")
        if modulus is not None:
            rods = {"young_modulus": modulus, "yield_stress": 1e15, "footprint": 1e-3}
            given["casing"]["coating"] = {"thickness": 2e-3, "elements": 10000} | rods
        impulses.append(float(marched(given)["contact_impulse"].sum()))
    *soft, rigid = impulses
    errors = [abs(each / rigid - 1.0) for each in soft]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 0.1
    assert errors[-1] < 0.01
