"""True values by which a picture is coloured, against closed forms."""

from typing import Any

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.pictures.choices import Field
from bladewhirl.postprocess.pictures.colouring import Colouring, colouring

RECORDS = np.array([0, 1])
SHIFT: dict[str, Any] = {
    "rotor_displacement": (3e-3, 4e-3, 0, 0, 0),
    "casing_displacement": (1e-3, 0, 0, 0),
}


def coloured(result: xr.Dataset, field: Field, *, rotating: bool = True) -> tuple[Colouring, Array]:
    """Colouring, and the values of beams in it (record, line, station, side)."""
    points = points_of(result, 2)
    colours = colouring([(result, points)], field, RECORDS, 9, rotating=rotating)
    beams = np.array([points.stations(values) for values in colours.points])
    lines, nodes = result.sizes["rotor_line"], result.sizes["casing_node"]
    assert beams.shape == (2, lines, 3, 2)
    assert colours.casing.shape == (2, nodes * 9, 2)
    return colours, beams


def test_magnitudes_of_motion() -> None:
    colours, beams = coloured(
        synthetic.resting(rotor_velocity=(3.0, 4.0, 0, 0, 0), casing_velocity=(1, 0, 0, 0)),
        "velocity",
    )
    np.testing.assert_allclose(beams, 5.0)
    np.testing.assert_allclose(colours.casing, 1.0, rtol=1e-5)
    assert (colours.disk.unit, colours.disk.limits) == ("m/s", (0.0, 5.0))
    assert (colours.wall.unit, colours.wall.limits) == ("m/s", (0.0, 1.0))  # a scale of its own
    assert [*colours.scales] == ["rotor [m/s]", "wall [m/s]"]


def test_a_velocity_is_the_rate_in_the_axes_of_the_picture() -> None:
    """A shaft that stands still in rotating axes turns with them, by Omega r, and a casing that
    stands aside turns back when seen from the rotor.
    """
    for rotating, rotor, casing in ((False, 5e-3, 0.0), (True, 0.0, 1e-3)):
        colours, beams = coloured(synthetic.resting(**SHIFT), "velocity", rotating=rotating)
        np.testing.assert_allclose(beams, synthetic.SPEED * rotor)
        np.testing.assert_allclose(colours.casing, synthetic.SPEED * casing, rtol=1e-5)


def test_deformation_is_displacement_beyond_a_shift() -> None:
    colours, beams = coloured(synthetic.resting(**SHIFT), "deformation")
    np.testing.assert_allclose(beams, 0.0, atol=1e-15)
    np.testing.assert_allclose(colours.casing, 0.0, atol=1e-8)  # cubics follow a circle
    bent = SHIFT | {"rotor_displacement": (3e-3, 4e-3, 0, 1e-4, 0)}
    bent["casing_displacement"] = (1e-3, 0, 2e-4, 0)
    colours, beams = coloured(synthetic.resting(**bent), "deformation")
    assert (beams.max(), colours.casing.max()) == pytest.approx((1e-4, 2e-4), rel=1e-3)


def test_bending_is_opposite_at_the_two_sides() -> None:
    result = synthetic.resting(rotor_displacement=(0, 0, 0, 1e-3, 0))
    colours, beams = coloured(result, "bending-strain")
    blade = int(np.flatnonzero(result["rotor_part"].values == "blades")[0])  # on +x, to +y
    curvature = 1e-3 * 3 / (synthetic.TIP_RADIUS - synthetic.DISK_RADIUS) ** 2  # at its root
    right = 0.010 / 2 * curvature
    np.testing.assert_allclose(beams[0, blade, 0], [right, -right], rtol=1e-9)
    low, high = colours.disk.limits
    assert low == -high
    assert high >= colours.disk.factor * np.abs(beams).max()
    _, stress = coloured(result, "stress")
    np.testing.assert_allclose(stress[0, blade, 0, 0], synthetic.YOUNG_MODULUS * right)
    np.testing.assert_allclose(coloured(result, "axial-strain")[1], 0.0, atol=1e-12)


def test_every_contact_node_has_its_gap() -> None:
    """What has no gap is not coloured: neither beams nor the wall."""
    result = synthetic.synthetic_result(records=2)
    colours, beams = coloured(result, "gap")
    np.testing.assert_array_equal(colours.nodes, result["gap"].values)
    assert np.isnan(beams).all()
    assert np.isnan(colours.casing).all()


def test_unknown_fields_are_refused() -> None:
    with pytest.raises(
        ViewError, match="colour must be one of displacement, deformation, velocity"
    ):
        coloured(synthetic.resting(), "heat")  # type: ignore[arg-type]
