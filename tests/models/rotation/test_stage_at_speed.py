"""The stage of Table 1 at speed: waves, growth, forces and critical speeds known independently."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse.linalg as spla
from stages import bladed_disk, oracle

from bladewhirl.models.case.rotation import Effects
from bladewhirl.models.rotation.axial_force import axial_force
from bladewhirl.models.rotation.eigenproblems import damped_eigenvalues
from bladewhirl.models.rotation.growth import speed_of_growth, static_displacement, tip_growth
from bladewhirl.models.rotation.matrices import RotationMatrices, rotation_matrices
from bladewhirl.models.rotation.waves import waves
from bladewhirl.models.rotation.whirl_modes import whirl_modes

STAGES = ["0.01", "0.03"]
RATIOS = [0.5, 1.05, 1.6, 2.5]
KEYS: dict[Effects, str] = {"none": "at_rest", "centrifugal": "no_coriolis", "full": "full"}


def known(stage: str) -> Any:
    return oracle("rotation")["stages"][stage]


@cache
def turning(stage: str) -> RotationMatrices:
    return rotation_matrices(bladed_disk(disk_thickness=float(stage)))


def at(stage: str, ratio: float) -> Any:
    (row,) = [row for row in known(stage)["speeds"] if row["ratio"] == ratio]
    return row


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("stage", STAGES)
def test_frequencies_with_tension_and_spin_softening(stage: str, ratio: float) -> None:
    row = at(stage, ratio)
    structure = turning(stage).at_speed(row["omega"], "centrifugal")
    assert structure.layout is not None
    for k, (mass, stiffness) in structure.layout.blocks(structure.mass, structure.stiffness):
        square = la.eigvalsh(stiffness, mass, subset_by_index=(0, 5))
        found = np.sign(square) * np.sqrt(np.abs(square)) / (2 * np.pi)
        np.testing.assert_allclose(found, row["centrifugal"][str(k)], rtol=1e-8)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("stage", STAGES)
def test_waves_with_coriolis_forces(stage: str, ratio: float) -> None:
    row = at(stage, ratio)
    modes = whirl_modes(turning(stage).at_speed(row["omega"], "full"))
    doubtful = (stage, ratio) == ("0.03", 2.5)  # k = 1: see the file
    for way in ("backward", "forward"):
        for k in range(12):
            ways = [way, "standing"]
            chosen = (modes.nodal_diameter == k) & np.isin(modes.direction, ways)
            found = modes.frequency[chosen][:6] / (2 * np.pi)
            rtol = 6e-7 if doubtful and k == 1 else 1e-7
            np.testing.assert_allclose(found, row[way][str(k)], rtol=rtol)
    assert np.abs(modes.growth).max() < 1e-6


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("stage", STAGES)
def test_growth_and_forces(stage: str, ratio: float) -> None:
    row, disk, matrices = at(stage, ratio), bladed_disk(disk_thickness=float(stage)), turning(stage)
    omega = row["omega"]
    linear = static_displacement(matrices, omega, follows=False)
    np.testing.assert_allclose(linear[disk.tip_radial], row["tip_growth"], rtol=1e-8)
    np.testing.assert_allclose(
        tip_growth(disk, matrices, omega), row["tip_growth_softened"], rtol=1e-8
    )
    ends = np.array([0.0, 0.5, 1.0])
    force = axial_force(disk.model, disk.expansion @ linear, ends, omega=omega)
    mean = force @ np.array([1.0, 4.0, 1.0]) / 6.0
    sets = disk.mesh.line_sets
    np.testing.assert_allclose(mean[sets["spokes"]], row["spoke_force"], rtol=1e-8)
    np.testing.assert_allclose(mean[sets["rim"]], row["rim_force"], rtol=1e-8)
    root = disk.mesh.node_sets["roots"][0]
    (line,) = [n for n in sets["blades"] if disk.mesh.lines[n, 0] == root]
    closed_form = 7800.0 * 1e-3 * omega**2 * (0.5**2 - 0.05**2) / 2.0
    assert force[line, 0] == pytest.approx(closed_form, rel=1e-8)


@pytest.mark.parametrize("stage", STAGES)
def test_critical_speeds_and_crossings(stage: str) -> None:
    row, matrices = known(stage), turning(stage)
    reference = 2 * np.pi * row["reference_hz"]
    first = waves(matrices, 1, "full").synchronous(0)[0]
    assert first / reference == pytest.approx(row["critical_speed"], rel=1e-8)
    for each in row["engine_orders"]:
        k = each["k"]
        for effects, key in KEYS.items():
            found = waves(matrices, k, effects).synchronous(k)[0] / reference
            assert found == pytest.approx(each[key], rel=1e-8), (k, effects)
    room = speed_of_growth(bladed_disk(disk_thickness=float(stage)), matrices, 1e-3)
    assert room / reference == pytest.approx(row["growth_of_1mm"], rel=1e-8)


@pytest.mark.parametrize("stage", STAGES)
def test_internal_damping_feeds_a_wave_past_its_critical_speed(stage: str) -> None:
    """Modal damping of the modes at rest, turning with the disk."""
    row, matrices = known(stage), turning(stage)
    structure = matrices.structure
    assert structure.layout is not None
    basis = structure.layout.basis(1)
    mass, stiffness, geometric, translated, coriolis = (
        (basis.conj().T @ each @ basis).toarray()
        for each in (
            structure.mass,
            structure.stiffness,
            matrices.geometric,
            matrices.mass,
            matrices.coriolis,
        )
    )
    square, modes = la.eigh(stiffness, mass)
    damping = mass @ modes @ np.diag(0.01 * np.sqrt(square)) @ modes.conj().T @ mass
    for ratio, growth, frequency in row["growth_rates_xi_0.005"]:
        omega = 2 * np.pi * row["reference_hz"] * ratio
        stiffness_at_speed = stiffness + omega**2 * (geometric - translated)
        found, _ = damped_eigenvalues(mass, damping + 2 * omega * coriolis, stiffness_at_speed)
        fastest = found[found.real.argmax()]
        assert fastest.real == pytest.approx(growth, abs=1e-6)
        assert abs(fastest.imag) / (2 * np.pi) == pytest.approx(abs(frequency), rel=1e-6)


@pytest.mark.parametrize("stage", STAGES)
def test_answer_to_a_constant_force_on_the_shaft(stage: str) -> None:
    row, disk, matrices = known(stage), bladed_disk(disk_thickness=float(stage)), turning(stage)
    force = np.zeros(disk.structure.size)
    force[disk.centre[0]] = 1.0
    for ratio, centre, tip in row["steady_per_newton"]:
        omega = 2 * np.pi * row["reference_hz"] * ratio
        answer = spla.spsolve(matrices.stiffness(omega).tocsc(), force)
        assert answer[disk.centre[0]] == pytest.approx(centre, rel=1e-8)
        assert np.abs(answer[disk.tip_radial]).max() == pytest.approx(tip, rel=1e-8)


@pytest.mark.parametrize("effects", ["none", "centrifugal", "full"])
def test_speeds_at_which_a_casing_wave_is_met(effects: Effects) -> None:
    """Each branch meets k Omega - omega_c where it has that frequency."""
    structure, reference = turning("0.01").structure, 2 * np.pi * known("0.01")["reference_hz"]
    assert structure.layout is not None
    for k, casing in ((1, 14.0), (2, 160.0), (3, 450.0)):
        found = waves(turning("0.01"), k, effects)
        speeds = found.meeting(casing, 3.0 * reference)
        assert len(speeds)
        for speed in speeds:
            frequency = k * speed - casing
            nearest = np.abs(found.frequencies(speed) - frequency).min()
            assert nearest < 1e-7 * frequency
        if effects == "none":
            (mass, stiffness) = found.mass, found.stiffness
            rest = np.sqrt(la.eigvalsh(stiffness, mass)) + casing
            np.testing.assert_allclose(speeds, rest[rest < 3.0 * k * reference] / k, rtol=1e-9)
        assert found.rank(speeds[0], k * speeds[0] - casing) == (0, True)


def test_past_its_critical_speed_a_forward_wave_is_met_as_a_backward_one() -> None:
    found = waves(turning("0.01"), 1, "full")
    omega = 2.5 * 2 * np.pi * known("0.01")["reference_hz"]
    lowest = found.frequencies(omega).real
    assert found.rank(omega, lowest[lowest > 0.0].min()) == (0, False)
