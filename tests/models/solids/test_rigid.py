"""Rigid bodies of decks among the nodes of a solid."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from solid_meshes import CALCULIX, RIGID_TIP, STEEL, cantilever, deck_text

from bladewhirl.models.inputs.errors import CaseError, Hint
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.frequencies import lowest_frequencies
from bladewhirl.models.superelements.superelement import Superelement

COUPLINGS = {
    "rigid body": RIGID_TIP,
    "two parts of one body": "*NSET, NSET=one\n1000\n*NODE\n1000, 9, 9, 9\n"
    "*SURFACE, NAME=face, TYPE=NODE\ntip\n*COUPLING, REF NODE=one, SURFACE=face\n*KINEMATIC\n"
    "*KINEMATIC COUPLING, REF NODE=1000\ntip, 1, 3\n",
}


def made(folder: Path, coupling: str, **given: object) -> Superelement:
    deck = folder / "deck.inp"
    deck.write_text(deck_text(cantilever("hexahedron20"), "C3D20") + coupling)
    arguments = {"contact": "0.249 < x < 0.251", **STEEL, **given}
    return mesh3d(deck, **arguments)


@pytest.mark.parametrize("coupling", COUPLINGS.values(), ids=COUPLINGS)
def test_frequencies_of_a_blade_with_a_rigid_tip_are_those_of_calculix(
    tmp_path: Path, coupling: str
) -> None:
    with pytest.warns(Hint, match="stiffness at speed is left out: .* rigid bodies"):
        part = made(tmp_path, coupling)
    actual = lowest_frequencies(part.mass, part.stiffness, 8)
    assert actual == pytest.approx(CALCULIX["rigid tip"], rel=1e-6)


def test_a_free_blade_with_a_rigid_tip_resists_no_rigid_motion(tmp_path: Path) -> None:
    part = made(tmp_path, RIGID_TIP, clamped=None)
    values = np.linalg.eigvalsh(sp.csr_array(part.stiffness).toarray())
    assert abs(values[:6]).max() < 1e-9 * values[-1] < 1e-3 * values[6]


def test_nodes_on_a_line_turn_about_two_axes(tmp_path: Path) -> None:
    edge = "*NSET, NSET=edge\n1\n2\n3\n*RIGID BODY, NSET=edge, REF NODE=2\n"
    part = made(tmp_path, edge, clamped=None)
    free = made(tmp_path, "", clamped=None)
    assert free.stiffness.shape[0] - part.stiffness.shape[0] == 9 - 5


@pytest.mark.parametrize(
    ("coupling", "given", "expected"),
    [
        (RIGID_TIP, {"contact": "tip"}, "contact: .* outside of \\*RIGID BODY; 13 of 13 belong"),
        (RIGID_TIP, {"clamped": "x > 0.299 and y > 0"}, "clamped: .* or none of them; 6 of 13"),
        (f"{RIGID_TIP}*RIGID BODY, NSET=tip, REF NODE=1001\n", {}, "belong to one rigid body"),
        (RIGID_TIP, {"speed": 10.0}, "speed = 10.0: .* without rigid bodies"),
    ],
)
def test_what_a_rigid_body_cannot_be_is_refused(
    tmp_path: Path, coupling: str, given: dict[str, object], expected: str
) -> None:
    with pytest.raises(CaseError, match=expected):
        made(tmp_path, coupling, **given)
