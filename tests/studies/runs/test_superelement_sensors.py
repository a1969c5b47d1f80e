"""Sensors of superelements: as those of beams where both exist, and gauges from a file."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported_stage import same_stage
from faults import fault
from rod_blade import blade, tables

import bladewhirl as bw
from bladewhirl.models.superelements.superelement import Superelement, dense
from bladewhirl.models.superelements.wheel import WheelOverSpeeds, whole_wheel
from bladewhirl.postprocess.fields.nodes import displacement
from bladewhirl.postprocess.fields.point_stresses import on_sectors
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.runs.sensor_files import check_gauges

LENGTH = 0.01  #: from the root to the first level of the rods [m]

RIG = [
    {"type": "tip-timing", "probes": ["20 deg", "200 deg"]},
    {"type": "centre", "angle": "30 deg", "quantity": "velocity"},
    {"type": "wall", "angle": "90 deg", "sampling_rate": "20 kHz"},
]


def test_a_wheel_has_the_signals_of_the_same_stage_of_beams(tmp_path: Path) -> None:
    beams, solid = (
        bw.sensors(march_in_memory(prepare(case))[0])
        for case in same_stage("wheel", tmp_path / "part.npz", sensor=RIG)
    )
    assert {*beams.data_vars} == {*solid.data_vars}
    for name, signal in beams.data_vars.items():
        largest = float(np.abs(signal).max())
        np.testing.assert_allclose(solid[name], signal, rtol=1e-6, atol=1e-6 * largest)


def gauged(folder: Path) -> Path:
    """A blade with gauges between the clamped root and the first level of two of its rods."""
    strains = np.zeros((2, 54))
    strains[0, 0] = strains[1, 3] = 1.0 / LENGTH
    bw.write_superelement(folder / "rods.npz", replace(blade(), strain_recovery=strains))
    return folder / "rods.npz"


@pytest.mark.slow
def test_gauges_of_a_file_are_strained_as_its_points_move(tmp_path: Path) -> None:
    rig: list[dict[str, Any]] = [{"type": "strain", "gauge": 1}]
    rig += [{"type": "strain", "gauge": 0, "blade": 2, "name": "one"}]
    run = bw.run(bw.case_from(tables(gauged(tmp_path), sensor=rig)), tmp_path / "run", frames=0)
    header = (run.directory / "strain-gauge-1.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.endswith("strain-gauge-1 blade 2 [um/m]")
    with run.open() as result:
        pushed = bw.sensors(result)
        signals = bw.sensors(result.assign(contact_force=0.0 * result["contact_force"]))
        assert np.abs(pushed["one"] - signals["one"]).max() > 0.0
        for number in range(3):  # points move as the modes do
            moved = displacement(result, 1, copy=number).sel(xyz="x").values
            strain = signals["strain-gauge-1"].sel(blade=number).values
            assert np.abs(strain).max() > 0.0
            np.testing.assert_allclose(strain, moved / LENGTH, rtol=1e-9, atol=1e-15)
        moved = displacement(result, 0, copy=2).sel(xyz="x").values
        np.testing.assert_allclose(signals["one"], moved / LENGTH, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(
    ("sensor", "expected"),
    [
        ({"type": "strain", "gauge": 2}, "gauge = 2: expected a gauge from 0 to 1 of each blade"),
        ({"type": "strain", "span": 0.1}, "span = 0.1: expected gauge in place of span"),
        (
            {"type": "strain", "span": 0.1, "gauge": 0},
            "one of span, element, gauge, point, position and group",
        ),
        ({"type": "wall", "angle": 0.0}, 'type = "wall": expected another type for a rigid wall'),
        ({"type": "centre"}, 'type = "centre": expected another type for blades without'),
    ],
)
def test_sensors_that_the_stage_does_not_have_are_refused(
    tmp_path: Path, sensor: dict[str, Any], expected: str
) -> None:
    def checked() -> None:
        check_gauges(prepare(bw.case_from(tables(gauged(tmp_path), sensor=[sensor]))))

    assert expected in fault(checked)


def test_gauges_of_a_sector_are_on_every_blade_of_the_wheel() -> None:
    """Both ways to a wheel: at each frequency, its modes strain each gauge as much."""
    ground, bending = np.diag([3e8, 2e8, 1e8]), np.diag([4e8, 2e7, 1e7])
    stretch = np.hstack([-np.eye(3), np.zeros((3, 3)), np.eye(3)])
    stiffness = np.zeros((9, 9))
    stiffness[:6, :6] = np.block([[ground + bending, -bending], [-bending, bending]])
    sector = Superelement(
        mass=np.diag([0.02] * 3 + [0.01] * 3 + [0.0] * 3),
        stiffness=stiffness + 5e7 * stretch.T @ stretch,
        contact_position=np.array([[0.4, 0.0, 0.0]]),
        contact_dofs=np.array([[3, 4, 5]]),
        left_dofs=np.array([[0, 1, 2]]),
        right_dofs=np.array([[6, 7, 8]]),
        strain_recovery=np.array([[0.0, -50.0, 0.0, 0.0, 50.0, 0.0, 0.0, 0.0, 0.0]]),
    )
    _, reduced = WheelOverSpeeds(sector, 4, 5).at(0.0)
    wheel = whole_wheel(sector, 4)
    scale = 1.0 / np.sqrt(wheel.mass.diagonal())
    squares, shapes = np.linalg.eigh(scale[:, None] * dense(wheel.stiffness) * scale)
    strained = dense(wheel.strain_recovery) @ (scale[:, None] * shapes)
    assert reduced.strains.shape == (4, 20)
    force = np.random.default_rng(1).standard_normal((4, 3))
    found = reduced.strains @ (reduced.contact.T @ force.ravel() / reduced.frequency**2)
    pushed = on_sectors(reduced.strains_by_force, np.arange(4)).reshape(4, -1) @ force.ravel()
    moved = np.linalg.solve(dense(wheel.stiffness), wheel.contact_rows.T @ force.ravel())
    expected = dense(wheel.strain_recovery) @ moved
    assert found + pushed == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())
    assert np.abs(found - expected).max() > 1e-4 * np.abs(expected).max()
    assert np.abs(reduced.strains).max() > 1.0
    for frequency in reduced.frequency:
        here = np.abs(reduced.frequency - frequency) < 1e-6 * frequency
        there = np.abs(np.sqrt(squares) - frequency) < 1e-6 * frequency
        assert (strained[:, there] ** 2).sum(axis=1) == pytest.approx(
            (reduced.strains[:, here] ** 2).sum(axis=1), rel=1e-6, abs=1e-6
        )
