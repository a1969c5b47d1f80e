"""Fewer points for pictures."""

import numpy as np
import pytest
from solid_meshes import cantilever

from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.points import with_fewer_points
from bladewhirl.models.superelements.superelement import Superelement, dense


@pytest.fixture(scope="module")
def blade() -> Superelement:
    mesh = cantilever("hexahedron20", (20, 6, 1))
    return mesh3d(mesh, young_modulus=2.1e11, poisson_ratio=0.3, density=7800.0)


def area(part: Superelement) -> float:
    assert part.points is not None
    assert part.triangles is not None
    a, b, c = np.moveaxis(part.points[part.triangles], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def test_fewer_points_keep_shape_and_displacements(blade: Superelement) -> None:
    needed = [3, 7, 8]
    some, shown = with_fewer_points(blade, 150, needed)
    assert 75 < some.point_count <= 150 + len(needed)
    assert set(needed) <= set(shown.tolist())
    assert some.points == pytest.approx(blade.points[shown])  # type: ignore[index]
    field = np.random.default_rng(0).standard_normal(blade.size)
    moved = (dense(blade.recovery) @ field).reshape(-1, 3)
    assert (dense(some.recovery) @ field).reshape(-1, 3) == pytest.approx(moved[shown])
    stress = (dense(blade.stress_recovery) @ field).reshape(-1, 6)
    assert (dense(some.stress_recovery) @ field).reshape(-1, 6) == pytest.approx(stress[shown])
    assert some.young_modulus == pytest.approx(np.full(len(shown), 2.1e11))
    assert area(some) == pytest.approx(area(blade), rel=1e-9)  # edges and corners are kept


def test_few_points_stay_as_they_are(blade: Superelement) -> None:
    same, shown = with_fewer_points(blade, blade.point_count, [])
    assert same is blade
    assert shown.tolist() == list(range(blade.point_count))
