"""Datasets of `modes`, `campbell` and `veering`: selection, units, files."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import answer
from rod_blade import blade, tables

import bladewhirl as bw
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.postprocess.modal.campbell import drawn_part
from bladewhirl.solvers.stability.growth import eigenvalues
from bladewhirl.studies.modal.coupled_system import EvenSystem, couple
from bladewhirl.studies.modal.stability_chart import _branch_names


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
    stage = modal_model(case())
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
    stage = modal_model(case())
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
    assert bw.modes(build_beams(case())).identical(studies()["modes"])
    clamped = bw.modes(case(**{"shaft.clamped": True}))
    assert clamped.attrs["centre"] == "clamped"
    np.testing.assert_array_equal(clamped.frequency, studies()["modes"].frequency)


def test_modes_of_a_superelement_include_its_coriolis_forces(tmp_path: Path) -> None:
    """The reference is the quadratic eigenproblem of all coordinates."""
    part = blade()
    skew = np.random.default_rng(1).standard_normal(part.mass.shape) * 1e-3
    skew -= skew.T
    bw.write_superelement(file := tmp_path / "part.npz", replace(part, gyroscopic=skew))
    given: Any = tables(file)
    omega = 2.0 * np.pi * 100.0  # 6000 rpm
    flexibility = np.linalg.inv(np.asarray(part.mass))
    size, zero = part.size, np.zeros(part.mass.shape)
    top = np.hstack([-omega * flexibility @ skew, -flexibility @ np.asarray(part.stiffness)])
    values = np.linalg.eigvals(np.vstack([top, np.hstack([np.eye(size), zero])])).imag
    exact = np.sort(values)[size:][:10] / (2.0 * np.pi)
    case = bw.case_from(given)
    modes = bw.modes(case, count=10)
    assert modes.frequency.values == pytest.approx(exact, rel=1e-6)
    at_rest = bw.modes(bw.with_values(case, {"march.speed": 0.0}), count=10)
    assert abs(at_rest.frequency.values / exact - 1.0).max() > 1e-3
    first = at_rest.normalised_frequency.sel(body="bladed-disk", number=1)
    assert first.item() == pytest.approx(1.0)
    (tmp_path / "case.toml").write_text(bw.dumps_case(case), encoding="utf-8")
    rows = json.loads(answer("modes", tmp_path / "case.toml", "--count", 10, "--json").stdout)
    assert [row["frequency_hz"] for row in rows["bladed_disk"]] == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("wrong", [[], [-1.0], [0.0, 1.0], [2e6, 1e6], [np.nan], "soft", 3e7])
def test_stiffnesses_of_the_shaft_are_positive_and_ascending(wrong: Any) -> None:
    turning = bw.with_values(case(), {"rotation.effects": "full"})
    for study in (bw.veering, bw.critical_speeds):
        with pytest.raises(bw.UserError, match=r"^stiffnesses: expected positive stiffnesses"):
            study(turning, stiffnesses=wrong)


@pytest.mark.parametrize(("key", "wrong"), [("speed", []), ("kappa", [-1.0]), ("kappa", [2, 1])])
def test_axes_of_a_chart_are_ascending(key: str, wrong: Any) -> None:
    with pytest.raises(bw.UserError, match=f"^stability: {key}: expected one or more numbers"):
        bw.stability(case(), **{"speed": [0.9, 1.1], "kappa": [0.0, 1e3], key: wrong})


def test_branches_over_the_shaft_have_the_family_of_their_frequency_in_hertz() -> None:
    given = case()
    over = bw.veering(given, stiffnesses=np.array([given.shaft.stiffness]))
    modes = bw.modes(given).sel(body="bladed-disk", centre="free", nodal_diameter=1)
    for name, family in (("suspension", "suspension"), ("1F", "1F"), ("2F", "2F")):
        expected = modes["frequency"].values[modes["family"].values == family][0]
        own = over["branch_frequency"].values[0, over["branch_family"].values == name]
        assert own == pytest.approx(expected, rel=1e-6)


def test_branches_of_coupled_modes_are_named_by_their_sense_in_space() -> None:
    """A wave of the rotor at w turns forward at w + k Omega: in axes at half the speed of the rotor
    relative to it, at w + k Omega / 2, and backward at w - k Omega / 2."""
    system = couple(modal_model(case()), modes="six", damped=False, with_pi=True, physical=False)
    assert isinstance(system, EvenSystem)
    omega = 0.5 * system.reference
    spectrum = eigenvalues(system.modes, speed=omega, kappa=0.0)
    names = _branch_names(system.modes, omega, spectrum)
    for name, frequency, k, on_casing in zip(
        system.modes.name,
        system.modes.frequency,
        system.modes.nodal_diameter,
        system.modes.on_casing,
        strict=True,
    ):
        if on_casing or not k:
            continue
        for way, sign in (("forward", 1.0), ("backward", -1.0)):
            found = np.abs(spectrum[names == f"{name}, {way}"].imag)
            assert found == pytest.approx(frequency + sign * 0.5 * k * omega, rel=1e-6), (name, way)
