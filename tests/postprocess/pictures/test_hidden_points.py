"""Points behind surfaces, and smooth parts of surfaces."""

import numpy as np
import pytest
import pyvista

from bladewhirl.postprocess.pictures.solids import behind, normals, smooth_parts


def test_a_point_behind_a_triangle_is_hidden() -> None:
    corners = np.array(
        [[[0, 0, 1], [1, 0, 1], [0, 1, 2]], [[3, 3, 9], [3, 4, 9], [3, 5, 9]]], float
    )
    points = np.array([[0.2, 0.2, 1.0], [0.2, 0.2, 1.15], [0.8, 0.8, 0.0], [0.2, 0.2, 1.5]])
    # The plane of the first triangle is at 1.2 above the points; the second is seen from its edge.
    assert behind(points, [corners], 0.1).tolist() == [True, False, False, False]
    assert behind(points, [corners], 0.0).tolist() == [True, True, False, False]
    assert behind(np.array([[3.0, 4.0, 0.0]]), [corners], 0.0).tolist() == [False]


def test_a_tube_has_smooth_sides_and_flat_ends() -> None:
    cylinder = pyvista.Cylinder(direction=(0, 0, 1), resolution=60).triangulate()
    triangles = cylinder.regular_faces[:, ::-1]  # as seen from inside
    smooth, origin = smooth_parts(np.asarray(cylinder.points, float), triangles)
    points = np.asarray(cylinder.points, float)[origin]
    outward = normals(points, smooth)
    used = np.isin(np.arange(len(points)), smooth)  # others are at places of these
    side, end = (used & (seen(np.abs(outward[:, 2]), 0.5)) for seen in (np.less, np.greater))
    assert np.any(side)
    assert np.any(end)
    radial = points[side, :2] / np.linalg.norm(points[side, :2], axis=1)[:, None]
    assert outward[side, :2] == pytest.approx(radial, abs=0.06)  # within half of an angle of 6 deg
    assert outward[end, 2] == pytest.approx(np.sign(points[end, 2]), abs=1e-6)
