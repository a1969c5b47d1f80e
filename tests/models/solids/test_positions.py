"""Groups of nodes by their positions."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_meshes import SECTORS, bladed_sector, cantilever

from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.solids.positions import nodes_where

STEEL: dict[str, Any] = {"young_modulus": "210 GPa", "poisson_ratio": 0.3, "density": 7800.0}

POINTS = np.random.default_rng(0).uniform(-1.0, 1.0, (500, 3)).round(2)
X, Y, Z = POINTS.T
R = np.hypot(X, Y)
ANGLE = np.degrees(np.arctan2(Y, X))


@pytest.mark.parametrize(
    ("text", "axis", "expected"),
    [
        ("r < 0.21", "z", R < 0.21),
        ("r>=210 mm", "z", R >= 0.21),
        ("-5 cm < z <= 300mm and x > .2", "z", (Z > -0.05) & (Z <= 0.3) & (X > 0.2)),
        ("0.5 <= x, y < -1e-1", "z", (X >= 0.5) & (Y < -0.1)),
        ("x = 0.5", "z", X == 0.5),
        ("r > 0.8", "x", np.hypot(Y, Z) > 0.8),
        ("-30 < angle < 45 deg", "z", (ANGLE > -30.0) & (ANGLE < 45.0)),
        ("angle < 10 and angle > 0", "y", abs(np.degrees(np.arctan2(X, Z)) - 5.0) < 5.0),
        ("outermost", "z", R >= R.max() - 0.01 * np.ptp(R)),
    ],
)
def test_conditions_choose_nodes(text: str, axis: str, expected: Any) -> None:
    assert 0 < np.count_nonzero(expected) < len(POINTS)
    nodes = nodes_where(text, POINTS, axis)
    assert nodes is not None
    assert np.array_equal(nodes, np.flatnonzero(expected))


def test_other_text_is_no_condition() -> None:
    for text in ("root", "r", "x and y", ""):
        assert nodes_where(text, POINTS, "z") is None


@pytest.mark.parametrize(
    "text", ["r <", "< 3", "r < 3 kg", "q < 3", "r < 1.2.3", "1 < r > 2 < 3", "x = = 2", "r << 2"]
)
def test_invalid_conditions_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        nodes_where(text, POINTS, "z")
    with pytest.raises(CaseError, match=r"clamped = .*: expected .* or a condition such as"):
        mesh3d(cantilever("tetra", (2, 1, 1)), **STEEL, clamped=text)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_sector_without_groups_is_cut_by_conditions(axis: str) -> None:
    mesh = bladed_sector("hexahedron20")
    expected = mesh3d(mesh, **STEEL, left="left", right="right", copies=SECTORS)
    mesh.points = mesh.points[:, {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[axis]]
    mesh.point_sets = {}
    part = mesh3d(
        mesh,
        **STEEL,
        clamped="r <= 50 mm",
        contact="r >= 149.9 mm",
        left="angle = -15 and r <= 0.09",
        right="angle = 15 deg and r <= 0.09",
        copies=SECTORS,
        axis=axis,
    )
    assert abs(part.stiffness - expected.stiffness).max() < 1e-9 * abs(expected.stiffness).max()
    assert str(part.left_dofs) == str(expected.left_dofs)
    assert part.contact_position == pytest.approx(expected.contact_position)


def test_the_outermost_nodes_of_a_blade_are_its_tip(tmp_path: Path) -> None:
    mesh = cantilever("tetra10")
    tip = mesh3d(mesh, **STEEL)
    part = mesh3d(mesh, **STEEL, contact="outermost", clamped="x = 0.2")
    assert np.array_equal(part.contact_dofs, tip.contact_dofs)
    with pytest.raises(CaseError, match='contact = "r > 1": expected a group with nodes'):
        mesh3d(mesh, **STEEL, contact="r > 1")
