"""Datasets of `modes`, `campbell` and `veering`: selection, units, files."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import bladewhirl as bw
from bladewhirl.models.modal.full_stage import modal_stage
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.postprocess.modal.campbell import drawn_part


@cache
def case(**changes: float) -> bw.Case:
    small = {
        "bladed_disk.blades": 7,
        "bladed_disk.elements_per_blade": 2,
        "casing.elements": 14,
        "reduction.fixed_interface_modes": 20,
    }
    return bw.with_values(bw.Case(), {**small, **changes})


@cache
def studies() -> dict[str, xr.Dataset]:
    stage = modal_stage(case())
    return {
        "modes": bw.modes(stage),
        "campbell": bw.campbell(stage),
        "veering": bw.veering(stage, stiffnesses=np.geomspace(1e6, 1e8, 3)),
    }


def test_modes_are_selected_by_their_coordinates() -> None:
    modes = studies()["modes"]
    free = modes.sel(body="bladed-disk", centre="free")
    pair = free.frequency.sel(family="1F", nodal_diameter=1)
    assert pair["pattern"].values.tolist() == ["cosine", "sine"]
    assert float(pair[0]) == float(pair[1]) == pytest.approx(modes.attrs["reference_frequency_hz"])
    assert free.sel(family="1F", nodal_diameter=0)["pattern"].values.tolist() == ["single"]
    np.testing.assert_array_equal(np.diff(free.number), 1)
    assert (np.diff(free.frequency) >= 0.0).all()
    stage = modal_stage(case())
    np.testing.assert_array_equal(
        modes.sel(body="casing").frequency, stage.casing_modes.frequency / (2 * np.pi)
    )


def test_the_suspension_has_its_energy_in_the_springs() -> None:
    disk = studies()["modes"].sel(body="bladed-disk")
    assert float(disk.spring_share.sel(family="suspension").min()) > 0.5
    assert "suspension" not in disk.sel(centre="clamped")["family"].values


def test_the_drawn_part_is_idempotent() -> None:
    once = drawn_part(studies()["campbell"])
    assert once.sizes["mode"] < studies()["campbell"].sizes["mode"]
    assert drawn_part(once).identical(once)


def test_veering_holds_the_modes_of_both_centres_once() -> None:
    modes, veering = studies()["modes"], studies()["veering"]
    for centre in ("free", "clamped"):
        one = veering.frequency.sel(centre=centre, family="2F", nodal_diameter=1)
        disk = modes.sel(body="bladed-disk", centre=centre)
        pair = disk.frequency.sel(family="2F", nodal_diameter=1)
        np.testing.assert_array_equal(pair, float(one))
    assert veering.branch_spring_share.sel(stiffness=1e6, branch=0).ndim == 0


@pytest.mark.parametrize("name", ["modes", "campbell", "veering"])
def test_every_variable_has_a_unit_and_can_be_saved(name: str, tmp_path: Path) -> None:
    data = studies()[name]
    silent = {str(key) for key, values in data.items() if "units" not in values.attrs}
    assert silent <= {"in_operating_range"}
    index = "coincidence" if name == "campbell" else "mode"
    data.reset_index(index).to_netcdf(tmp_path / "data.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "data.nc", engine="h5netcdf") as read:
        assert set(read.data_vars) == set(data.data_vars)


def test_a_case_and_its_reduced_stage_have_the_same_modes() -> None:
    assert bw.modes(case()).identical(studies()["modes"])
    assert bw.modes(build_stage(case())).identical(studies()["modes"])
    clamped = bw.modes(case(**{"shaft.clamped": True}))
    assert clamped.attrs["centre"] == "clamped"
    np.testing.assert_array_equal(clamped.frequency, studies()["modes"].frequency)
