"""The stage of Table 1 at speed: what `bladewhirl verify` leaves of waves, growth and forces."""

from __future__ import annotations

import numpy as np
import pytest
from stages import bladed_disk

from bladewhirl.models.rotation.axial_force import axial_force
from bladewhirl.models.rotation.growth import static_displacement, tip_growth
from bladewhirl.models.rotation.whirl_modes import whirl_modes
from bladewhirl.studies.verification.rotation import RATIOS, STAGES, known, turning


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("stage", STAGES)
def test_waves_neither_grow_nor_decay_and_blades_are_alike(stage: str, ratio: float) -> None:
    (row,) = [row for row in known(stage)["speeds"] if row["ratio"] == ratio]
    disk, matrices, omega = bladed_disk(disk_thickness=float(stage)), turning(stage), row["omega"]
    assert np.abs(whirl_modes(matrices.at_speed(omega, "full")).growth).max() < 1e-6
    linear = static_displacement(matrices, omega, follows=False)
    np.testing.assert_allclose(linear[disk.tip_radial], row["tip_growth"], rtol=1e-8)
    growth = tip_growth(disk, matrices, omega)
    np.testing.assert_allclose(growth, row["tip_growth_softened"], rtol=1e-8)
    ends = np.array([0.0, 0.5, 1.0])
    force = axial_force(disk.model, disk.expansion @ linear, ends, omega=omega)
    mean, sets = force @ np.array([1.0, 4.0, 1.0]) / 6.0, disk.mesh.line_sets
    np.testing.assert_allclose(mean[sets["spokes"]], row["spoke_force"], rtol=1e-8)
    np.testing.assert_allclose(mean[sets["rim"]], row["rim_force"], rtol=1e-8)


@pytest.mark.parametrize("stage", STAGES)
def test_a_root_carries_its_blade(stage: str) -> None:
    """rho A Omega^2 (R^2 - r^2) / 2."""
    disk, omega = bladed_disk(disk_thickness=float(stage)), 250.0
    linear = static_displacement(turning(stage), omega, follows=False)
    root = disk.mesh.node_sets["roots"][0]
    (line,) = [n for n in disk.mesh.line_sets["blades"] if disk.mesh.lines[n, 0] == root]
    force = axial_force(disk.model, disk.expansion @ linear, np.zeros(1), omega=omega)
    closed_form = 7800.0 * 1e-3 * omega**2 * (0.5**2 - 0.05**2) / 2.0
    assert force[line, 0] == pytest.approx(closed_form, rel=1e-8)
