"""Beams and wall as boxes: their volume, how they move, and the stress at their surfaces."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.paraview.boxes import Boxes, casing_boxes, rotor_boxes
from bladewhirl.postprocess.paraview.parts import StageParts

WIDTH, BLADE = 0.1, 0.010  # of the synthetic stage [m]
RIGID = np.array([3e-3, -1e-3])
FACES = [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]]


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result(records=3)


def volume(boxes: Boxes) -> float:
    """Volume inside the faces of hexahedra, as VTK numbers them, by the divergence theorem."""
    corner = boxes.points()[boxes.cells()[:, FACES].reshape(-1, 4)]
    middle = corner.mean(axis=1)
    area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]) / 2
    return float(np.sum(middle * area) / 3)


def corners(result: xr.Dataset, boxes: Boxes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Displacement of the corners (corner, 2) at the first record, in the body's axes."""
    return np.asarray(boxes.vectors(result, "displacement", np.array([0]))[0])


def test_beams_fill_their_volume(result: xr.Dataset) -> None:
    ends = result["rotor_point"].values[result["rotor_line"].values]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    expected = np.sum(length * result["rotor_thickness"].values) * WIDTH
    assert volume(rotor_boxes(result)) == pytest.approx(expected, rel=1e-12)


def test_the_wall_fills_its_volume(result: xr.Dataset) -> None:
    inner = synthetic.TIP_RADIUS + synthetic.CLEARANCE
    expected = np.pi * ((inner + 0.010) ** 2 - inner**2) * WIDTH
    coarse, fine = (abs(volume(casing_boxes(result, n)) / expected - 1) for n in (200, 800))
    assert fine < 1e-4
    assert coarse / fine == pytest.approx(16, rel=0.01)  # chords: second order


def test_a_rotor_that_moves_as_a_whole(result: xr.Dataset) -> None:
    boxes = rotor_boxes(result)
    shifted = synthetic.resting(rotor_displacement=[*RIGID, 0, 0, 0])
    np.testing.assert_allclose(corners(shifted, boxes) - RIGID, 0, atol=1e-15)
    turned = corners(synthetic.resting(rotor_displacement=[0, 0, 1e-3, 0, 0]), boxes)
    x, y, _ = boxes.points().T
    np.testing.assert_allclose(turned, 1e-3 * np.column_stack([-y, x]), atol=1e-15)


def test_a_casing_that_moves_as_a_whole(result: xr.Dataset) -> None:
    shifted = corners(synthetic.resting(casing_displacement=[*RIGID, 0, 0]), casing_boxes(result))
    np.testing.assert_allclose(shifted - RIGID, 0, atol=2e-8)  # cubics follow a circle


@pytest.mark.parametrize("surface", [False, True])
def test_stress_at_the_surfaces_of_a_bent_blade(surface: bool) -> None:
    bent = synthetic.resting(rotor_displacement=[0, 0, 0, 1e-3, 0])
    parts = StageParts(bent, np.array([0]), surface=surface, rotating=True)
    rotor = next(parts.grids())["rotor"]
    pieces = 3 if surface else 2
    shape = (bent.sizes["rotor_line"], pieces, 4 if surface else 1)
    blade = np.flatnonzero(bent["rotor_part"].values == "blades")[:4]  # on +x, bent towards +y
    stress = rotor.point_data["surface_stress"].reshape(shape)[blade]
    span = synthetic.TIP_RADIUS - synthetic.DISK_RADIUS
    share = (rotor.points[:, 0].reshape(shape)[blade] - synthetic.DISK_RADIUS) / span
    curvature = 1e-3 * 3 * (1 - share) / span**2
    right = synthetic.YOUNG_MODULUS * BLADE / 2 * curvature  # the side on -y is pulled
    size = right.max()
    sides = np.array([1, -1, -1, 1]) if surface else np.zeros(1)  # of lines there is no side
    expected = right * sides if surface else np.abs(right)
    np.testing.assert_allclose(
        np.abs(stress) if not surface else stress, expected, atol=1e-6 * size
    )
    if surface:
        y = rotor.points[:, 1].reshape(shape)[blade]
        np.testing.assert_array_equal(np.sign(y), -sides + 0 * y)
    np.testing.assert_allclose(
        rotor.point_data["bending_strain"].reshape(shape)[blade],
        right / synthetic.YOUNG_MODULUS,
        atol=1e-6 * size / synthetic.YOUNG_MODULUS,
    )
