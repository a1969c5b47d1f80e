"""Foreshortening of blades: the beams of a blade, and quadratic forms with few terms."""

import numpy as np
import pytest
from places import EXAMPLES

from bladewhirl.models.case.file import read_case
from bladewhirl.models.elements.foreshortening import blade_beams, drawback, fewest_terms
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams


@pytest.mark.parametrize(
    ("name", "root", "changes"),
    [
        ("imbalance", 0.05, []),
        ("curved_blades", 0.05, []),
        ("shrouded_fan", 0.08, []),
        ("packets", 0.05, []),
    ],
)
def test_a_blade_reaches_from_tip_to_root(name: str, root: float, changes: list[str]) -> None:
    stage = build_beams(read_case(EXAMPLES / f"{name}.toml", changes))
    model = stage.disk.model
    for tip in model.tips:
        beams = blade_beams(model, int(tip))
        ends = model.mesh.lines[beams.lines]
        ends[~beams.outward] = ends[~beams.outward, ::-1]
        assert ends[-1, 1] == tip
        assert ends[0, 0] == beams.root
        assert np.array_equal(ends[1:, 0], ends[:-1, 1])
        assert np.hypot(*model.mesh.points[beams.root]) == pytest.approx(root)


def test_few_terms_give_the_form() -> None:
    random = np.random.default_rng(3)
    rows, signs = random.normal(size=(9, 30)), np.array([1.0] * 6 + [-1.0] * 3)
    rows[4:6] = rows[:2]  # seven terms are enough
    weight = random.uniform(1.0, 100.0, 30)
    fewer, kept, _ = fewest_terms(rows, signs, weight, 1e-12)
    assert fewer.shape == (7, 30)
    np.testing.assert_allclose(
        fewer.T @ (kept[:, None] * fewer), rows.T @ (signs[:, None] * rows), atol=1e-12 * 1e4
    )


def test_a_blade_bent_to_a_parabola_draws_back_by_the_closed_form() -> None:
    """w = y (s / L)^2 on a straight blade of length L: int w'^2 / 2 ds = 2 y^2 / (3 L)."""
    case = read_case(EXAMPLES / "imbalance.toml")
    disk, blade, height = build_beams(case).disk, 3, 0.02
    beams = blade_beams(disk.model, int(disk.model.tips[blade]))
    mesh, root = disk.mesh, disk.mesh.points[beams.root]
    length = np.linalg.norm(mesh.points[disk.model.tips[blade]] - root)
    along = (mesh.points[disk.model.tips[blade]] - root) / length
    place = (mesh.points - root) @ along
    fields = disk.cartesian(np.eye(disk.structure.size))  # of unit coordinates
    target = np.zeros(fields.shape[:2])
    for node in np.unique(mesh.lines[beams.lines]):
        rise = height * (place[node] / length) ** 2
        target[node] = (
            *(rise * np.array([-along[1], along[0]])),
            2.0 * rise / max(place[node], 1e-9),
        )
    bent = np.linalg.lstsq(fields.reshape(-1, disk.structure.size), target.ravel(), rcond=None)[0]
    rows, signs = drawback(disk, np.asarray(bent[:, None], np.float64), blade, around=False)
    drawn = 0.5 * signs @ rows[:, 0] ** 2
    assert drawn == pytest.approx(2.0 * height**2 / (3.0 * length), rel=1e-9)


@pytest.mark.parametrize("around", [False, True])
def test_the_form_of_a_problem_is_the_drawback_of_its_fields(around: bool) -> None:
    changes = ["contact.foreshortening=true", f"contact.tip_rotation={str(around).lower()}"]
    case = read_case(EXAMPLES / "curved_blades.toml", changes)
    stage = build_beams(case)
    given = contact_problem(stage).foreshortening
    assert given is not None
    modes = stage.reduction.modes
    x = np.random.default_rng(0).normal(size=modes.count) / modes.frequency
    for blade in (0, 7):
        rows, signs = drawback(stage.disk, modes.shapes @ x[:, None], blade, around=around)
        exact = 0.5 * signs @ rows[:, 0] ** 2
        assert given.opening(x)[blade] == pytest.approx(exact, rel=1e-6)
