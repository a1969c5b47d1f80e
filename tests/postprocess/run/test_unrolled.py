"""The casing unrolled: extremes at each place against a plain loop, and what is drawn."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from long_cases import slow_except
from matplotlib.collections import QuadMesh
from matplotlib.patches import StepPatch
from three_runs import KINDS, Kind, run_of

from bladewhirl.postprocess.plotting.style import at_width
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.unrolled import unrolled, whole_run

pytestmark = pytest.mark.pictures


@pytest.mark.parametrize("kind", KINDS)
def test_places_have_seen_the_extremes_of_a_plain_loop(kind: Kind) -> None:
    run = run_of(kind)
    found = unrolled(run)
    time, sectors = run["time"].values, found.sizes["sector"]
    axial = found["axial"].values
    gap, force = (
        np.full((len(axial), count), empty)
        for count, empty in ((sectors, np.inf), (found.sizes["blade"], 0.0))
    )
    tip, z, blades = (run[name].values for name in ("tip_angle", "axial_position", "blade"))
    gaps, impulse = run["gap"].values, run["contact_impulse"].values
    for record in range(1, len(time)):
        turned = run.attrs["speed"] * 0.5 * (time[record] + time[record - 1])
        for node in range(run.sizes["contact_node"]):
            track = int(abs(axial - z[node]).argmin())
            angle = (tip[node] + turned) % (2 * np.pi)
            sector, blade = int(angle / (2 * np.pi) * sectors), int(blades[node])
            gap[track, sector] = min(gap[track, sector], max(gaps[record, node], 0.0))
            pushed = impulse[record, node] / (time[record] - time[record - 1])
            force[track, blade] = max(force[track, blade], pushed)
    seen = whole_run(found)
    np.testing.assert_array_equal(seen["gap"], np.where(np.isinf(gap), np.nan, gap))
    np.testing.assert_allclose(seen["blade_force"], force)
    assert float(seen["force"].max()) == pytest.approx(force.max())
    assert float(found["time"][-1]) == time[-1]
    if kind == "wheel":
        assert "wear" not in found
    else:
        worn = run["coating_strain"].values[-1] * {"beams": 1e-3, "blade": 2e-3}[kind]
        np.testing.assert_allclose(found["wear"][-1], worn)
        assert worn.max() > 0.0


@pytest.mark.parametrize("width", slow_except([0.085, 0.17], 0.085))
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_drawn_is_what_is_stored(kind: Kind, width: float) -> None:
    with at_width(width):
        figure, data = RunFigures(run_of(kind)).draw("unrolled")
    assert_legible(figure)
    seen = whole_run(data)
    drawn = [
        np.asarray(patch.get_data()[0]) if isinstance(patch, StepPatch) else patch.get_array()
        for axes in figure.axes
        for patch in (*axes.patches, *axes.collections)
        if isinstance(patch, (StepPatch, QuadMesh))
    ]
    for name in {"gap", "force", "wear"} & {*map(str, seen)}:
        assert any(_same(values, seen[name]) for values in drawn), name
    if kind == "wheel":
        assert any(_same(values, seen["blade_force"]) for values in drawn)


def _same(drawn: Any, stored: xr.DataArray) -> bool:
    """Return whether values are the stored ones, except for a unit."""
    known = np.ma.filled(np.ma.masked_invalid(drawn).ravel(), 0.0)
    values = np.nan_to_num(stored.values.ravel())
    if known.shape != values.shape:
        return False
    factor = known.max() / (values.max() or 1.0)
    unit = np.isclose(factor, [0.0, *(10.0**n for n in (-3, 0, 3, 6))], rtol=1e-12, atol=0.0)
    return bool(np.allclose(known, factor * values) and unit.any())
