"""Frequencies over nodal diameter and over the stiffness of the shaft."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
import xarray as xr
from typer.testing import CliRunner, Result

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.modal.full_stage import ModalStage, modal_stage
from bladewhirl.solvers.stability.veering import shaft_veering
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.modal.veering import clamping_shifts, suspension_frequency, veering


@cache
def stage(stiffness: float = 3.4e7) -> ModalStage:
    return modal_stage(with_values(Case(), {"shaft.stiffness": stiffness}))


@cache
def diagrams() -> xr.Dataset:
    return veering(stage(), stiffnesses=np.geomspace(1e4, 1e11, 30))


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["veering", *map(str, arguments)])


def test_a_mass_on_a_spring_in_front_of_an_oscillator() -> None:
    """Two masses in closed form: m1 on the spring kappa, joined to m2 by k."""
    m1, m2, k = 2.0, 0.5, 300.0
    springs = np.array([1.0, 100.0, 1e4])
    stiffness = np.array([[k, -k], [-k, k]], dtype=np.complex128)
    mass = np.diag([m1, m2]).astype(np.complex128)
    found = shaft_veering(stiffness, mass, np.array([1.0 + 0j, 0.0]), springs=springs, branches=1)
    for kappa, frequency, share in zip(
        springs, found.frequency[:, 0], found.spring_share[:, 0], strict=True
    ):
        middle = (kappa + k) / m1 + k / m2
        square = (middle - np.sqrt(middle**2 - 4.0 * kappa * k / (m1 * m2))) / 2.0
        assert frequency == pytest.approx(np.sqrt(square), rel=1e-9)
        ratio = k / (k - m2 * square)  # of the second mass's motion to the first's
        energy = kappa + k * (ratio - 1.0) ** 2
        assert share == pytest.approx(kappa / energy, rel=1e-6)
    assert found.clamped == pytest.approx([np.sqrt(k / m2)])


def test_branches_are_the_frequencies_of_stages_built_with_that_stiffness() -> None:
    springs = np.array([1e5, 3.4e7, 5e9])
    found = veering(stage(), families=2, stiffnesses=springs)["branch_frequency"]
    for kappa, row in zip(springs, 2.0 * np.pi * found.values, strict=True):
        modes = stage(float(kappa)).free_modes
        first = modes.frequency[(modes.nodal_diameter == 1) & (modes.column == 1)]
        np.testing.assert_allclose(row, first[:5], rtol=1e-7)


def test_branches_rise_between_those_of_a_clamped_centre() -> None:
    """Interlacing: each branch stays between two neighbouring clamped frequencies."""
    found = diagrams()
    frequency, clamped = found["branch_frequency"].values, found["clamped_frequency"].values
    assert (np.diff(frequency, axis=0) > -1e-9 * frequency[1:]).all()
    assert (frequency <= clamped * (1 + 1e-9)).all()
    assert (frequency[:, 1:] >= clamped[:-1] * (1 - 1e-9)).all()
    np.testing.assert_allclose(frequency[-1, :3], clamped[:3], rtol=1e-3)
    # A soft shaft carries the disk as a rigid body: all the energy is in the springs.
    assert found["branch_spring_share"].values[0, 0] > 0.99


def test_clamped_frequencies_of_the_branches_are_those_of_the_clamped_stage() -> None:
    modes = stage().clamped_modes
    first = modes.frequency[(modes.nodal_diameter == 1) & (modes.column == 1)][:5]
    found = diagrams()["clamped_frequency"].values
    np.testing.assert_allclose(2.0 * np.pi * found, first, rtol=1e-9)


def test_clamping_changes_one_nodal_diameter_and_the_suspension_is_between_the_families() -> None:
    found = diagrams()
    shifts = clamping_shifts(found)
    assert shifts.pop(1) > 0.02
    assert set(shifts) == {0, *range(2, 12)}
    assert max(shifts.values()) < 1e-9
    assert suspension_frequency(found) == pytest.approx(2.5267, abs=5e-5)
    assert found.sizes["mode"] == 2 * 12 * 12 + 1


def test_a_full_dense_model_agrees_that_clamping_changes_one_nodal_diameter() -> None:
    free, clamped = (
        la.eigh(d.structure.stiffness.toarray(), d.structure.mass.toarray(), eigvals_only=True)
        for d in (stage().free_disk, stage().clamped_disk)
    )
    free, clamped = np.sqrt(free[:46]), np.sqrt(clamped[:44])
    common = [f for f in free if np.isclose(clamped, f, rtol=1e-8).any()]
    assert len(common) == 40  # 2 x 22 modes of two families less the two pairs with k = 1


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fan.toml").write_text(dumps_case(Case()), encoding="utf-8")
    result = run("fan.toml", "--families", "3", "--stiffnesses", "1e6:1e9")
    assert result.exit_code == 0, result.stderr
    assert "Suspension pair at 2.527 ω₁." in result.stdout
    folder = tmp_path / "fan-veering"
    assert {path.name for path in folder.iterdir()} == {
        f"{name}.{suffix}"
        for name in ("families", "first-families", "shaft")
        for suffix in ("png", "pdf", "nc")
    }
    with xr.open_dataset(folder / "shaft.nc") as data:
        np.testing.assert_allclose(data["stiffness"][[0, -1]], [1e6, 1e9])
    found = json.loads(run("fan.toml", "--json").stdout)
    assert len(found["modes"]) == 2 * 12 * 12 + 1
    assert found["modes"][0] == {
        "centre": "free",
        "family": "1F",
        "nodal_diameter": 1,
        "frequency_hz": pytest.approx(found["reference_frequency_hz"]),
        "normalised": 1.0,
    }


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--families", "0"], "--families 0: expected a whole number of one or more"),
        (["--stiffnesses", "0:1e9"], "--stiffnesses 0:1e9: expected a START above zero"),
        (
            ["--stiffnesses", "2e9:1e9"],
            "--stiffnesses 2e9:1e9: expected a STOP above the START of 2e+09",
        ),
        (["--stiffnesses", "soft"], "--stiffnesses soft: expected START:STOP, two numbers"),
    ],
)
def test_bad_input_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], line: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fan.toml").write_text(dumps_case(Case()), encoding="utf-8")
    result = run("fan.toml", *arguments)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"{line}\n")
    assert [path.name for path in tmp_path.iterdir()] == ["fan.toml"]


def test_a_disk_with_fewer_families_than_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    small = with_values(Case(), {"bladed_disk.blades": 3, "bladed_disk.elements_per_blade": 1})
    (tmp_path / "small.toml").write_text(dumps_case(small), encoding="utf-8")
    assert run("small.toml").exit_code == 0
