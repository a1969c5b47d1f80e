"""Waves of a wheel with joints against all blades assembled in global axes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
from joint_cases import BLADES, blade, tables

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.surfaces import axes
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.matrices import Matrices


def wheel(folder: Path, **joint: object) -> JointedWheel:
    stage = build_stage(bw.case_from(tables(folder, **joint)))
    assert isinstance(stage, Matrices)
    return jointed_wheel(stage)


def assembled() -> FloatArray:
    """Frequencies of all blades with common joint nodes, of which rotations stay free."""
    part = blade()
    mass, stiffness = np.asarray(part.mass), np.asarray(part.stiffness)
    size = len(mass)
    ties = []
    for j in range(BLADES):
        rows = np.zeros((DIRECTIONS, BLADES * size))
        for node, of_blade, sign in ((0, (j + 1) % BLADES, 1.0), (1, j, -1.0)):
            a = 2.0 * np.pi * of_blade / BLADES
            c, s = np.cos(a), np.sin(a)
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            rows[:, of_blade * size + part.contact_dofs[node]] += sign * turn
        ties.append(rows)
    free = la.null_space(np.vstack(ties))
    k, m = (la.block_diag(*[each] * BLADES) for each in (stiffness, mass))
    squares = la.eigh(free.T @ k @ free, free.T @ m @ free, eigvals_only=True)
    return np.asarray(np.sqrt(squares))


def test_waves_have_the_frequencies_of_all_blades_with_common_nodes(tmp_path: Path) -> None:
    part, given = blade(), wheel(tmp_path, normal=[0.3, 1.0, -0.4])
    squares, shapes = la.eigh(np.asarray(part.stiffness), np.asarray(part.mass))
    rows = part.contact_rows @ shapes
    turned = axes(np.array([0.3, 1.0, -0.4]) / np.linalg.norm([0.3, 1.0, -0.4])).T
    every = replace(
        given,
        stiffness=np.tile(squares, (BLADES, 1)),
        damping=np.zeros((BLADES, len(squares), len(squares))),
        contact=np.vstack([turned @ rows[:3], -turned @ rows[3:6]])[None],
        compliance=np.zeros((1, 6, 1, 6)),
    )
    found = []
    for k in range(BLADES):
        free = la.null_space(every.joined(k, every.wave(k).rows))
        found.append(np.sqrt(la.eigvalsh((free.conj().T * squares) @ free)))
    assert np.sort(np.concatenate(found)) == pytest.approx(assembled(), rel=1e-8)


def test_a_preload_is_the_sum_of_the_static_forces(tmp_path: Path) -> None:
    given = wheel(tmp_path, preload="300 N")
    assert given.gap[0] < 0.0
    stiff = 1.0 / given.flexibility(0, 0.0)[0, 0].real
    assert -given.gap[0] * stiff == pytest.approx(300.0)


def test_all_blades_have_the_flexibility_of_their_waves(tmp_path: Path) -> None:
    given = wheel(tmp_path)
    rows, residual = given.all_blades
    values = given.values
    squares = given.stiffness.ravel()
    static = (residual + rows / squares @ rows.T).reshape(BLADES, values, BLADES, values)
    for k in range(BLADES):
        turn = np.exp(-2j * np.pi * k / BLADES * np.arange(BLADES))
        wave = np.einsum("a,aibj,b->ij", turn, static, turn.conj()) / BLADES
        assert wave == pytest.approx(given.flexibility(k, 0.0), rel=1e-9, abs=1e-15)


def test_a_joint_opens_by_the_static_displacements_of_the_rotation(tmp_path: Path) -> None:
    part = blade()
    load = np.zeros(len(part.mass))
    load[part.contact_dofs[0]] = [0.0, -2e-4, 1e-4]  # of 1 rad/s
    load[part.contact_dofs[1]] = [0.0, -1e-4, 3e-4]
    file = tmp_path / "loaded.npz"
    bw.write_superelement(file, replace(part, centrifugal_load=load))
    own = tables(tmp_path, overclosure=1e-5, opening_by_speed=True)
    own["bladed_disk"]["superelement"]["file"] = str(file)
    stage = build_stage(bw.case_from(own))
    assert isinstance(stage, Matrices)
    moved = stage.speed**2 * np.linalg.solve(np.asarray(part.stiffness), load)
    at = (part.contact_rows @ moved).reshape(-1, 3)
    opened = (at[0] - at[1]) @ [0.0, np.cos(np.pi / 6.0), 0.5]
    assert jointed_wheel(stage).gap == pytest.approx([opened - 1e-5])
    with pytest.raises(bw.CaseError, match="centrifugal_load"):
        wheel(tmp_path, opening_by_speed=True)
