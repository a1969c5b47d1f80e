"""The stage as pyvista's objects."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.paraview.blocks import stage_blocks


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result(elements=2)


def test_parts_by_name_at_the_nearest_record(result: xr.Dataset) -> None:
    blocks = stage_blocks(result, 0.1004)
    assert blocks.keys() == ["rotor", "casing", "contact", "supports"]
    np.testing.assert_array_equal(blocks["contact"]["gap"], result["gap"].values[100])
    assert blocks["rotor"].area > 0
    assert "surface_stress" in blocks["casing"].point_data
    lines = stage_blocks(result, 0.1, surface=False)
    assert lines.keys() == ["rotor", "casing", "contact", "supports"]
    assert lines["rotor"].n_cells == result.sizes["rotor_line"]


def test_moved_by_a_factor(result: xr.Dataset) -> None:
    rest, moved = (stage_blocks(result, 0.1, factor=factor) for factor in (0.0, 20.0))
    for name in rest.keys():
        shift = moved[name].points - rest[name].points
        np.testing.assert_allclose(shift, moved[name]["warp"], atol=1e-6)
        assert np.abs(shift).max() > 1e-3
