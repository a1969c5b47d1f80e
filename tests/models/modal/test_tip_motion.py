"""What tips do in modes: rigid motions, and solids whose modes are known."""

from pathlib import Path

import numpy as np
import pytest
from solid_meshes import STEEL, cantilever

import bladewhirl as bw
from bladewhirl.models.modal.tip_motion import tip_motion

PLACES = np.array([[0.3, 0.01, -0.02], [0.3, 0.0, 0.0], [0.3, -0.01, 0.02]])
ALONG = np.array([0.0, -0.01, 0.02]) / np.hypot(0.01, 0.02)
ACROSS = np.array([0.0, 0.02, 0.01]) / np.hypot(0.01, 0.02)


@pytest.mark.parametrize(
    ("moved", "expected"),
    [
        (np.tile(ACROSS, (3, 1)), "flapwise"),
        (np.tile(1j * ALONG, (3, 1)), "edgewise"),
        (np.outer([-1.0, 0.0, 1.0], ACROSS), "torsion"),
        (np.outer([1.0, -2.0, 1.0], ACROSS), "chordwise"),
        (np.tile([1.0, 0.0, 0.0], (3, 1)), "radial"),
        (np.tile(ACROSS + ALONG + [1.0, 0.0, 0.0], (3, 1)), "mixed"),
    ],
)
def test_motions_of_a_chord(moved: np.ndarray, expected: str) -> None:
    assert tip_motion(PLACES, moved) == expected
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert tip_motion(PLACES @ turn.T, moved) == expected


def test_one_node_has_no_chord() -> None:
    assert tip_motion(PLACES[:1], np.array([[0.0, 1.0, 0.0]])) == ""


def test_modes_of_a_flat_blade(tmp_path: Path) -> None:
    """The second mode of a cantilever is bending along the chord, the fourth torsion."""
    part = bw.mesh3d(cantilever("hexahedron20", (6, 2, 1)), **STEEL, contacts=3)
    bw.write_superelement(tmp_path / "blade.npz", part)
    table = {"file": str(tmp_path / "blade.npz"), "copies": 4}
    modes = bw.modes(
        bw.case_from({"bladed_disk": {"superelement": table}, "casing": {"type": "rigid"}}), count=6
    )
    motions = ["flapwise", "edgewise", "flapwise", "torsion"]
    assert list(modes["tip_motion"].values[:4]) == motions
