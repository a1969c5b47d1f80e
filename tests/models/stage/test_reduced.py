"""`stage.reduced`: matrices with named degrees of freedom, and what a stage says of itself."""

import numpy as np
import pytest
import scipy.linalg as la
from stages import SMALL, stage

from bladewhirl.models.stage.beams import Beams

KINDS = {
    "even": "shaft.clamped=false",
    "clamped": "shaft.clamped=true",
    "mistuned": "bladed_disk.mistuning.stiffness=[1.0, 1.1, 0.95, 1.0, 1.2, 0.9]",
}


def damped(kind: str) -> Beams:
    return stage(*SMALL, KINDS[kind], "shaft.damping=30.0")


@pytest.mark.parametrize("kind", KINDS)
def test_its_modes_are_those_that_are_marched(kind: str) -> None:
    built = damped(kind)
    reduced = built.reduced
    assert len(reduced.names) == built.reduction.modes.count == len(set(reduced.names))
    np.testing.assert_allclose(reduced.frequencies, built.reduction.modes.frequency, rtol=1e-7)
    _, vectors = la.eigh(reduced.stiffness, reduced.mass)
    tips = [reduced.position(f"tip {blade} radial") for blade in range(6)]
    lowest = np.linalg.norm(vectors[tips, :6])  # of whole pairs: turns don't matter
    assert lowest == pytest.approx(np.linalg.norm(built.rotor.tip_radial[:, :6]), rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_static_answers_are_those_of_the_full_model(kind: str) -> None:
    """A force on a tip moves tips and centre as it does in full, exactly."""
    reduced, full = damped(kind).reduced, damped(kind).disk.structure
    place = reduced.position("tip 2 tangential")
    answer = np.linalg.solve(reduced.stiffness, np.eye(len(reduced.names))[place])
    force = np.zeros(full.size)
    force[damped(kind).disk.tip_tangential[2]] = 1.0
    exact = np.linalg.solve(full.stiffness.toarray(), force)
    moved = reduced.expand(answer[:, None])
    np.testing.assert_allclose(
        moved, damped(kind).disk.cartesian(exact[:, None]), rtol=1e-8, atol=1e-9 * abs(moved).max()
    )
    tip = damped(kind).disk.model.tips[0]  # on the +x axis: radial is x
    assert moved[tip, 0, 0] == pytest.approx(answer[reduced.position("tip 0 radial")])


def test_damping_is_modal_with_the_dampers_of_the_shaft() -> None:
    built = damped("even")
    reduced, rotor = built.reduced, built.rotor
    size = len(reduced.names)
    state = np.block(
        [
            [np.zeros((size, size)), np.eye(size)],
            [
                -np.linalg.solve(reduced.mass, reduced.stiffness),
                -np.linalg.solve(reduced.mass, reduced.damping),
            ],
        ]
    )
    drag = np.diag(2.0 * rotor.damping_ratio * rotor.frequency) + rotor.dampers.T @ rotor.dampers
    modal = np.block(
        [[np.zeros((size, size)), np.eye(size)], [-np.diag(rotor.frequency**2), -drag]]
    )
    slow = np.sort(la.eigvals(modal).real)[::-1][:12]
    np.testing.assert_allclose(np.sort(la.eigvals(state).real)[::-1][:12], slow, rtol=1e-6)


def test_matrices_can_be_read_by_name() -> None:
    reduced = damped("even").reduced
    data = reduced.to_xarray()
    first = data["stiffness"].sel(row="centre x", column="centre x")
    place = reduced.position("centre x")
    assert float(first) == reduced.stiffness[place, place] > 0.0
    assert data["mass"].attrs["units"] == "kg"
    modal = [name.startswith("fixed-interface") for name in reduced.names]
    np.testing.assert_allclose(reduced.mass[modal][:, modal], np.eye(sum(modal)), atol=1e-9)
    inside = data["stiffness"].sel(row="fixed-interface 3", column="tip 1 radial")
    assert abs(float(inside)) < 1e-6 * float(first)
    assert "centre x" not in damped("clamped").reduced.names


def test_a_stage_is_told_on_one_screen() -> None:
    messages = repr(damped("even"))
    assert len(messages.splitlines()) < 24
    assert max(map(len, messages.splitlines())) <= 100
    for words in (
        "6 blades",
        "6 equal sectors: cyclic path",
        "6 tip radial + 6 tip tangential + 2 centre + 21 fixed-interface = 35",
        "suspension",
        "% off the full model",
    ):
        assert words in messages, words
    assert repr(damped("even").reduced).startswith("ReducedDisk: 35 coordinates (12 tip, 2 centre")
