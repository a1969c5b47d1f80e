"""Physical fields against closed forms that do not come from the package."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.fields import kinematics
from bladewhirl.postprocess.fields.enlarged import EnlargedStage


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result()


@pytest.mark.parametrize(
    ("frames", "start", "end", "records"),
    [
        (5, 0.1, 0.3, [100, 150, 200, 250, 300]),
        (3, 0.0104, 0.0130, [10, 12, 13]),  # the nearest records
        (5000, None, None, range(401)),  # each record once
        (2, 0.3, 3.0, [300, 400]),  # the run ended early
    ],
)
def test_frames_are_spread_evenly_between_the_ends(
    result: xr.Dataset, frames: int, start: float | None, end: float | None, records: list[int]
) -> None:
    np.testing.assert_array_equal(kinematics.frame_records(result, frames, start, end), records)


@pytest.mark.parametrize(
    ("frames", "start", "end"),
    [(0, None, None), (10**9, None, None), (5, 0.3, 0.2), (5, 0.5, 0.6), (5, -1, 0.1)],
)
def test_frames_that_are_refused(
    result: xr.Dataset, frames: int, start: float | None, end: float | None
) -> None:
    with pytest.raises(ValueError, match=r"must be|expected a start"):
        kinematics.frame_records(result, frames, start, end)


def test_hint_only_below_24_frames_a_revolution(result: xr.Dataset) -> None:
    revolution = 2 * np.pi / synthetic.SPEED  # 78.5 records
    coarse = kinematics.frame_records(result, 10, 0.0, revolution)
    fine = kinematics.frame_records(result, 26, 0.0, revolution)
    hint = kinematics.sampling_hint(result, coarse)
    assert hint is not None
    assert "10 frames over 1.0 revolutions" in hint
    assert kinematics.sampling_hint(result, fine) is None
    still = result.assign_attrs(speed=0.0)
    assert kinematics.sampling_hint(still, coarse) is None


def test_radial_part_is_zero_at_the_centre(result: xr.Dataset) -> None:
    points = result["rotor_point"].values
    translation = result["rotor_shape"].values[:, :2, 0]  # along x
    radial = kinematics.radial_part(translation, points)
    assert radial[int(result.centre_node)] == 0.0
    np.testing.assert_allclose(radial[result.tip_node], np.cos(result.tip_angle), atol=1e-14)


class TestCasing:
    def test_interpolation_is_exact_for_a_cubic(self, result: xr.Dataset) -> None:
        angle_of_node = result.casing_angle.values
        radius = result.attrs["casing_radius"]
        cubic = np.polynomial.Polynomial([0.3, -2.0, 5.0, -3.0])  # of s, in metres
        s = radius * angle_of_node
        data = np.column_stack([cubic(s), cubic.deriv()(s), -2 * cubic(s), -2 * cubic.deriv()(s)])
        one_mode = result.drop_dims("casing_mode").assign(
            casing_shape=(("casing_node", "casing_component", "casing_mode"), data[:, :, None])
        )
        inside = np.linspace(0.0, angle_of_node[-1], 301)  # the last element closes the ring
        rows = kinematics.casing_rows(one_mode, inside)[:, :, 0]
        np.testing.assert_allclose(rows[:, 0], cubic(radius * inside), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(rows[:, 1], -2 * rows[:, 0], rtol=1e-12)

    def test_ovalisation_converges_at_fourth_order(self) -> None:
        angle = np.linspace(-7.0, 9.0, 1001)  # any angle is on the ring
        errors = []
        for elements in (10, 20, 40):
            ring = synthetic.synthetic_result(casing_elements=elements, records=2)
            w, u = np.moveaxis(kinematics.casing_rows(ring, angle)[:, :, 2], 1, 0)
            errors.append(
                [np.abs(w - np.cos(2 * angle)).max(), np.abs(u + np.sin(2 * angle) / 2).max()]
            )
        # |f''''| h^4 / 384 bounds the error of a cubic Hermite interpolant.
        bound = 2**4 * (2 * np.pi / np.array([10, 20, 40])) ** 4 / 384
        assert np.all(np.array(errors)[:, 0] <= bound)
        orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
        assert np.all(np.abs(orders - 4.0) < 0.15)

    def test_clearance_is_linear_between_nodes_and_closes(self, result: xr.Dataset) -> None:
        node = result.casing_angle.values
        lobed = result.assign(clearance=("casing_node", 1e-3 + 1e-4 * np.arange(len(node))))
        step = node[1]
        between = kinematics.clearance_at(lobed, np.array([0.0, 2.25 * step, -0.5 * step]))
        np.testing.assert_allclose(between, [1e-3, 1.225e-3, 2.95e-3])


def test_contact_force_pushes_inward_and_drags_backward(result: xr.Dataset) -> None:
    pushed = result.copy(deep=True)
    pushed["contact_impulse"][:] = 0.0
    pushed["friction_impulse"][:] = 0.0
    pushed["contact_impulse"][30, 4] = 0.5
    pushed["friction_impulse"][30, 4] = 0.05
    force = kinematics.contact_forces(pushed, np.array([29, 30]))[..., :2]
    assert not force[0].any()
    angle = float(result.tip_angle[4]) + synthetic.SPEED * float(result.time[30])
    outward, forward = [np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]
    assert force[1, 4] @ outward == pytest.approx(-0.5 / synthetic.RECORD_STEP)
    assert force[1, 4] @ forward == pytest.approx(-0.05 / synthetic.RECORD_STEP)
    assert np.count_nonzero(force[1].any(axis=1)) == 1


def test_beams_between_nodes_follow_their_cubic(result: xr.Dataset) -> None:
    points, rows = kinematics.line_rows(result, 7)
    blades = result.rotor_part.values == "blades"
    x, y = np.moveaxis(points[blades], -1, 0)
    angle = np.round(np.arctan2(y, x) / (2 * np.pi / 22)) * (2 * np.pi / 22)
    xi = (np.hypot(x, y) - synthetic.DISK_RADIUS) / (synthetic.TIP_RADIUS - synthetic.DISK_RADIUS)
    bending = xi**2 * (3 - xi) / 2 * np.cos(angle)
    expected = np.stack([-np.sin(angle) * bending, np.cos(angle) * bending], axis=-1)
    np.testing.assert_allclose(rows[blades][..., 3], expected, atol=1e-13)
    everywhere = np.stack([-points[..., 1], points[..., 0]], axis=-1)  # a rigid rotation
    np.testing.assert_allclose(rows[..., 2], everywhere, atol=1e-15)


def test_the_drawn_wall_closes_with_the_casing(result: xr.Dataset) -> None:
    closing = result.assign_attrs(case='casing.closure = { table = [["0 s", 0], ["1 s", "1 mm"]] }')
    records = np.array([0, 100])
    first, later = (
        EnlargedStage(data, records, factor=10.0, pieces=1, per_element=1).wall(1)
        for data in (result, closing)
    )
    lost = 10.0 * 1e-3 * result["time"].values[100]
    inner = np.linalg.norm(first[:, 0], axis=1) - np.linalg.norm(later[:, 0], axis=1)
    np.testing.assert_allclose(inner, lost, rtol=0.05)  # seen from the shifted centre
