"""Rotational symmetry of line meshes: found whatever the numbering, refused where there is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.symmetry import rotational_sectors, symmetric_points

SECTORS = 7


def wheel() -> tuple[FloatArray, IntArray, IntArray]:
    """Leaning blades of two lines on spokes, a rim, a shroud: points, lines, tips; centre last."""
    turns = np.exp(2j * np.pi * np.arange(SECTORS) / SECTORS)
    sector = np.array([0.2, 0.5 + 0.1j, 1.0 + 0.3j])  # root, middle, tip
    places = np.append((turns[:, None] * sector).ravel(), 0.0)
    root, middle, tip = np.arange(3 * SECTORS).reshape(-1, 3).T
    centre = np.full(SECTORS, 3 * SECTORS)
    pairs = [(centre, root), (root, middle), (middle, tip), (root, np.roll(root, -1))]
    lines = np.vstack([np.column_stack(pair) for pair in [*pairs, (tip, np.roll(tip, -1))]])
    return np.column_stack([places.real, places.imag]), lines, tip


@given(seed=st.integers(0, 2**32 - 1))
def test_sectors_are_found_in_any_numbering(seed: int) -> None:
    points, lines, tips = wheel()
    rng = np.random.default_rng(seed)
    number = rng.permutation(len(points))  # new number of each node
    shuffled = np.empty_like(points)
    shuffled[number] = points * (1.0 + 1e-9 * rng.normal(size=points.shape))
    lines = rng.permuted(rng.permutation(number[lines]), axis=1)
    actual = rotational_sectors(shuffled, lines, number[tips], int(number[-1]))
    assert actual is not None
    assert actual.shape == (SECTORS, 3)
    assert set(actual.ravel()) == set(range(len(points))) - {number[-1]}
    assert all(number[tip] in sector for tip, sector in zip(tips, actual, strict=True))
    even = symmetric_points(shuffled, actual)
    assert np.abs(even - shuffled).max() < 1e-8
    places = even[actual] @ [1.0, 1.0j]
    turns = np.exp(2j * np.pi * np.arange(SECTORS) / SECTORS)[:, None]
    np.testing.assert_allclose(places, places[:1] * turns, atol=1e-15)


@pytest.mark.parametrize("change", ["tip moved", "line missing", "off centre", "crossed", "back"])
def test_no_sectors_where_one_differs(change: str) -> None:
    points, lines, tips = wheel()
    match change:
        case "tip moved":
            points[5] += [0.0, 1e-4]
        case "line missing":
            lines = lines[:-1]
        case "off centre":
            points = points + np.array([0.1, 0.0])
        case "crossed":
            lines[-1] = [2, 8]
        case "back":
            tips = tips[::-1].copy()
    assert rotational_sectors(points, lines, tips, len(points) - 1) is None


def test_two_blades_are_no_cyclic_structure() -> None:
    points = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]])
    lines = np.array([[0, 2], [1, 2]])
    assert rotational_sectors(points, lines, np.array([0, 1]), 2) is None
