"""Mitred joints of drawn beams."""

import numpy as np
import pytest
from synthetic_result import synthetic_result

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.mitres import mitred, mitres_of

THICK = 0.2


def ends_of(points: np.ndarray, lines: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    """Sides (line, end, side, 2) of straight beams with mitred joints."""
    line = points[lines]
    along = np.repeat(unit(np.diff(line, axis=1)), 2, axis=1)
    half = 0.5 * thickness[..., None] * rotate(along, np.pi / 2)
    sides = np.stack([line - half, line + half], axis=2)
    return mitred(sides, along, line, thickness, mitres_of(points, lines, thickness))


@pytest.mark.parametrize("flipped", [False, True])
def test_edges_of_a_ring_are_polygons_with_spokes_left_as_they_are(flipped: bool) -> None:
    """Eight chords and a spoke to each node: the outer edge is the octagon around the chords."""
    count = 8
    points = np.vstack([directions(2.0 * np.pi * np.arange(count) / count), [[0.0, 0.0]]])
    chords = np.column_stack([np.arange(count), (np.arange(count) + 1) % count])
    if flipped:
        chords[::2] = chords[::2, ::-1]
    spokes = np.column_stack([np.full(count, count), np.arange(count)])
    lines = np.vstack([chords, spokes])
    sides = ends_of(points, lines, np.full((len(lines), 2), THICK))
    radii = np.sort(np.linalg.norm(sides[:count], axis=-1), axis=-1)
    apart = 0.5 * THICK / np.cos(np.pi / count)
    np.testing.assert_allclose(radii[..., 0], 1.0 - apart)
    np.testing.assert_allclose(radii[..., 1], 1.0 + apart)
    at_nodes = np.linalg.norm(sides[count:, 1] - points[:count, None], axis=-1)
    np.testing.assert_allclose(at_nodes, 0.5 * THICK)  # across the spoke


def test_beams_of_other_thickness_and_sharp_corners_are_not_mitred() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.5], [1.2, 0.9]])
    one = np.array([[0, 1], [1, 2]])
    thickness = np.array([[THICK, THICK], [0.5 * THICK, 0.5 * THICK]])
    assert not mitres_of(points, one, thickness).before.line.size
    assert mitres_of(points, one, np.full((2, 2), THICK)).before.line.size == 1
    sharp = np.array([[0, 1], [1, 3]])
    assert not mitres_of(points, sharp, np.full((2, 2), THICK)).before.line.size


def test_ribbons_of_a_stage_meet_along_its_rim() -> None:
    stage = EnlargedStage(
        synthetic_result(records=5), np.array([3]), factor=None, pieces=3, per_element=2
    )
    mitres, sides = stage.body.mitres, stage.sides(0, stage.points(0), stage.wall(0))
    assert len(mitres.before.line) >= 22
    edges = [
        np.where(end.last[:, None, None], sides[end.line, -1], sides[end.line, 0]) for end in mitres
    ]
    flip = mitres.before.last == mitres.after.last
    edges[1][flip] = edges[1][flip][:, ::-1]
    np.testing.assert_allclose(edges[0], edges[1], atol=1e-12)
