"""Points at one place."""

import numpy as np
import pytest

from bladewhirl.meshes import coincident
from bladewhirl.meshes.coincident import near_pairs, places_of


@pytest.mark.parametrize("most", [0, coincident.MOST_PAIRS])
def test_pairs_are_those_within_the_distance(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coincident, "MOST_PAIRS", most)
    points, others = np.random.default_rng(0).random((2, 40, 3))
    apart = np.linalg.norm(points[:, None] - others, axis=2)
    pairs = near_pairs(points, others, 0.3)
    assert {*map(tuple, pairs.tolist())} == {*zip(*np.nonzero(apart <= 0.3), strict=True)}
    assert 0 < len(pairs) < apart.size
    assert near_pairs(points, others + 10.0, 0.3).shape == (0, 2)


@pytest.mark.parametrize("most", [0, coincident.MOST_PAIRS])
def test_places_go_through_other_points(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coincident, "MOST_PAIRS", most)
    along = np.array([5.0, 0.0, 0.9, 7.0, 1.8, 5.2])
    assert places_of(along[:, None] * [1.0, 0.0, 0.0], 1.0).tolist() == [0, 1, 1, 2, 1, 0]
