"""What holds for stages of any size: structures, reduction and march together."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from contact_cases import ledger_residual, random_problem, run, stage_problem
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_frame import frame_frequencies
from stages import bladed_disk, disk_modes, tip_in_sector

from bladewhirl.models.modal.reduction import craig_bampton

BLADES = st.integers(3, 12)
ELEMENTS = st.integers(1, 4)
THICKNESS = st.floats(0.002, 0.06)


@pytest.mark.slow
@settings(max_examples=20)
@given(blades=st.integers(3, 24), elements=ELEMENTS, thickness=THICKNESS)
def test_frequencies_are_those_of_a_plain_frame(
    blades: int, elements: int, thickness: float
) -> None:
    disk = bladed_disk(blades=blades, elements=elements, disk_thickness=thickness)
    modes = disk_modes(disk)
    assert modes.is_cyclic
    assert modes.count == disk.structure.size == 3 * blades * (elements + 1) + 2
    np.testing.assert_allclose(modes.frequency, frame_frequencies(disk, 3.4e7), rtol=1e-8)
    assert set(modes.nodal_diameter.tolist()) == set(range(blades // 2 + 1))


@pytest.mark.slow
@settings(max_examples=20)
@given(blades=BLADES, elements=ELEMENTS, clamped=st.booleans(), data=st.data())
@pytest.mark.parametrize("dense", [False, True])
def test_reduction_keeps_statics_and_only_raises_frequencies(
    dense: bool, blades: int, elements: int, clamped: bool, data: st.DataObject
) -> None:
    """The whole field that answers forces on the boundary is exact, however few modes are kept."""
    disk = bladed_disk(blades=blades, elements=elements, clamped=clamped)
    boundary = np.concatenate([disk.tip_radial, disk.tip_tangential, disk.centre])
    internal = disk.structure.size - len(boundary)
    count = data.draw(st.integers(0, internal))
    structure = replace(disk.structure, layout=None) if dense else disk.structure
    reduction = craig_bampton(structure, boundary, count, tip_in_sector(disk))
    assert count <= reduction.kept <= min(count + 1, internal)
    modes = reduction.modes
    assert modes.count == len(boundary) + reduction.kept
    full = disk_modes(disk).frequency[: modes.count]
    assert (modes.frequency >= full * (1.0 - 1e-8)).all()
    forces = np.eye(disk.structure.size)[:, boundary]
    exact = spla.splu(disk.structure.stiffness.tocsc()).solve(forces)
    actual = modes.shapes @ ((modes.shapes.T @ forces) / modes.frequency[:, None] ** 2)
    np.testing.assert_allclose(actual, exact, atol=1e-10 * np.abs(exact).max())


@settings(max_examples=25)
@given(
    seed=st.integers(0, 10**6),
    tips=st.integers(1, 20),
    modes=st.integers(1, 12),
    friction=st.floats(0.0, 0.1),
    speed=st.floats(-300.0, 300.0),
    sliding=st.sampled_from(["permanent", "signed"]),
    tip_rotation=st.booleans(),
)
def test_contact_is_complementary_and_energy_accounted_for(
    seed: int,
    tips: int,
    modes: int,
    friction: float,
    speed: float,
    sliding: Literal["permanent", "signed"],
    tip_rotation: bool,
) -> None:
    """Any tips, any modes: more tips than modes give a singular W."""
    given = random_problem(
        seed,
        tips=tips,
        rotor_modes=modes,
        friction=friction,
        speed=speed,
        sliding=sliding,
        tip_rotation=tip_rotation,
    )
    state, chunk, _ = run(given, 1e-4, 400)
    assert state.statistics.lcp_failures == 0
    assert state.statistics.complementarity_residual < 1e-10
    assert ledger_residual(chunk) < 1e-8
    touched = chunk.contact_impulse > 0.0
    np.testing.assert_array_equal(touched, chunk.contact_steps > 0)
    assert (chunk.contact_impulse >= 0.0).all()
    scale = max(np.abs(chunk.gap).max(), 1e-3)
    assert chunk.gap.min() > -1e-10 * scale
    assert np.abs(chunk.gap[touched]).max(initial=0.0) < 1e-10 * scale
    if sliding == "permanent":
        drag = np.sign(speed) * friction * chunk.contact_impulse
        np.testing.assert_allclose(chunk.friction_impulse, drag, rtol=1e-12)


@settings(max_examples=8)
@given(blades=st.sampled_from([4, 8]), data=st.data())
def test_a_load_turned_by_sectors_turns_the_motion(blades: int, data: st.DataObject) -> None:
    """An inward force on the casing over one blade or another: blades and nodes are all alike."""
    turn = data.draw(st.integers(1, blades - 1))
    base = stage_problem(blades, 8)
    nodal, load = base.casing.nodal, base.loads[0]
    dt = 0.5 * base.critical_time_step
    chunks = [
        run(
            replace(base, loads=(replace(load, casing=-2e5 * nodal[node, 0]),)), dt, 1500, every=50
        )[1]
        for node in (0, turn * 8 // blades)
    ]
    tips = [chunk.rotor_displacement @ base.rotor.tip_radial.T for chunk in chunks]
    scale = np.abs(tips[0]).max()
    assert chunks[0].contact_steps.sum() > 0
    expected = np.roll(tips[0], turn, axis=1)
    np.testing.assert_allclose(tips[1], expected, atol=1e-7 * scale, rtol=0.0)
    np.testing.assert_allclose(chunks[1].energy, chunks[0].energy, rtol=1e-6)
