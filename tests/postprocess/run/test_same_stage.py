"""A stage of beams, and the same stage as a superelement, have the same results."""

from dataclasses import asdict
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, get_args

import numpy as np
import pytest
import xarray as xr
from exported_stage import Kind, same_stage
from long_cases import slow_except

from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.pictures.appearance import shaft_trail
from bladewhirl.postprocess.plotting.registry import RUN_FIGURES
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.summary import Summary, summarise
from bladewhirl.postprocess.sweep.digest import digest
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps.layout import make_layout, march_extent

KINDS = get_args(Kind)

OWN = {
    *("wall_time", "us_per_step", "dt_over_critical", "complementarity_residual"),
    *("energy_residual", "gap_violation_max", "regime_criterion", "work", "reference_frequency"),
    *("shaft_lead", "lead_steadiness", "scenario"),  # of two opposite tips that touch, either one
    "stress_max",  # is known of beams
}
"""What each march has of its own, or knows more of."""

DRAWN = ("gaps", "forces", "contact-classes", "contact-angle", "casing")
"""Figures whose data are compared."""


@cache
def marched(kind: Kind) -> list[tuple[xr.Dataset, Summary, dict[str, Any]]]:
    """Result, summary and digest of both stages."""
    both = []
    with TemporaryDirectory() as folder:
        for case in same_stage(kind, Path(folder) / "part.npz"):
            prepared = prepare(case)
            result, report = march_in_memory(prepared)
            layout = make_layout(march_extent([case]), prepared.stage)
            both.append((result, summarise(result, report), digest(result, report, layout)))
    return both


def assert_alike(one: Any, other: Any, name: str) -> None:
    """Compare numbers to rounding errors, which grow in contact, and other values exactly."""
    if isinstance(one, dict):
        for key in one.keys() & other.keys():
            assert_alike(one[key], other[key], key)
    elif np.asarray(one).dtype.kind in "fi":
        known = np.where(np.isfinite(one), one, 0.0)
        largest = np.abs(known).max(initial=0.0)
        np.testing.assert_allclose(other, one, rtol=1e-6, atol=1e-6 * largest, err_msg=name)
    elif isinstance(one, list) and one and isinstance(one[0], dict):
        for first, second in zip(one, other, strict=True):
            assert_alike(first, second, name)
    else:
        assert np.array_equal(one, other), name


@pytest.mark.parametrize("kind", slow_except(KINDS, "wheel"))
def test_contact_nodes_have_the_same_variables(kind: Kind, tmp_path: Path) -> None:
    """Also in a result that is saved and opened again, which keeps what was stored."""
    (beams, _, _), (solid, _, _) = marched(kind)
    beams.to_netcdf(tmp_path / "beams.nc", engine="h5netcdf")
    solid.to_netcdf(tmp_path / "solid.nc", engine="h5netcdf")
    with open_result(tmp_path / "beams.nc") as one, open_result(tmp_path / "solid.nc") as other:
        for result in (beams, one):
            assert_alike(
                result["contact_displacement"].values, other["contact_displacement"].values, kind
            )
        moved = one["contact_displacement"]
        chosen = moved.isel(time=[2, 5, 3], contact_node=slice(None, None, 2), direction=1)
        np.testing.assert_array_equal(chosen, moved.values[[2, 5, 3], ::2, 1])
        assert {*beams.variables} == {*one.variables}
        assert {*solid.variables} == {*other.variables}


@pytest.mark.parametrize("kind", KINDS)
def test_summaries_are_the_same(kind: Kind) -> None:
    (_, beams, _), (_, solid, _) = marched(kind)
    assert beams.contact_impulse > 0.0
    known = {name for name, value in asdict(beams).items() if value is not None}
    given = {name for name, value in asdict(solid).items() if value is not None}
    for name in known & given - OWN:
        assert_alike(getattr(beams, name), getattr(solid, name), name)
    # Neither families of modes nor beams, whose stresses are known, nor the work of closing tips.
    lacking = {"strain_energy_final", "strain_energy_rest", "stress_max", "stress_split"}
    lacking |= {"drive_power", "drive_torque"}
    still = {"shaft_radius_max", "shaft_radius_final", "ripple_rms"}
    assert known - given == lacking | (still if kind != "wheel" else set())


@pytest.mark.parametrize("kind", KINDS)
def test_points_of_a_sweep_are_the_same(kind: Kind) -> None:
    (_, _, beams), (_, _, solid) = marched(kind)
    assert (kind == "wheel") == ("spectrum" in solid)
    names = beams.keys() & solid.keys() - OWN - {"stress_max"}  # files have no stresses
    # Of copies, the modes of the first; of their beams, those of all with nodal diameters.
    names -= {"natural_frequency", "natural_diameter"} if kind == "blade" else set()
    for name in names:
        one, other = beams[name], solid[name]
        if name.startswith("energy_") and name != "energy_residual":  # of groups of modes, or all
            one, other = one.sum(axis=-1), other.sum(axis=-1)
            if name == "energy_max":
                continue
        assert_alike(one, other, name)


@pytest.mark.parametrize("kind", slow_except(KINDS, "wheel"))
def test_figures_are_the_same(kind: Kind) -> None:
    (beams, _, _), (solid, _, _) = marched(kind)
    lacking = {"stress", "haigh", "energy-families"}
    if kind != "wheel":
        lacking |= {name for name, each in RUN_FIGURES.items() if "centre_shape" in each.needs}
        lacking -= {"run-up", "critical-orbits", "waterfall"}  # of a speed that varies
    ours, theirs = RunFigures(beams), RunFigures(solid)
    assert {*ours.names} - {*theirs.names} == lacking
    for name in DRAWN:
        one, other = (ours.draw(name)[1], theirs.draw(name)[1])
        for variable in one.data_vars.keys() & other.data_vars.keys():
            assert_alike(one[variable].values, other[variable].values, f"{name}: {variable}")


def test_pictures_are_the_same() -> None:
    """A surface in its wall is drawn where the beams are: tips, wall, and the orbit of a wheel."""
    (beams, _, _), (solid, _, _) = marched("wheel")
    records = np.array([100, 200, 300])
    drawn, other = (
        EnlargedStage(each, records, factor=30.0, pieces=1, per_element=3)
        for each in (beams, solid)
    )
    for index in range(len(records)):
        nodes, wall = drawn.contact_nodes(index), drawn.wall(index)
        assert np.abs(nodes - drawn.nodes).max() > 1e-4
        np.testing.assert_allclose(other.contact_nodes(index), nodes, atol=1e-8)
        np.testing.assert_allclose(other.wall(index), wall, atol=1e-8)
    for frame in ("static", "rotating"):
        one, same = (shaft_trail(each, records, frame) for each in (beams, solid))
        np.testing.assert_allclose(same[0], one[0], atol=1e-6)
        assert same[1] == one[1]
