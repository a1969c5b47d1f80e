"""Reduction of superelements to modes and contact nodes."""

from dataclasses import replace

import numpy as np
import pytest
from solid_meshes import STEEL
from symmetric_cases import leaning_blade

import bladewhirl as bw
from bladewhirl.models.inputs.progress import listening
from bladewhirl.models.superelements import solver
from bladewhirl.models.superelements.frequencies import lowest_frequencies
from bladewhirl.models.superelements.reduction import (
    Root,
    consistent,
    massless,
    root_at_rest,
    root_of,
)
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError, dense
from bladewhirl.models.superelements.wheel import WheelOverSpeeds, whole_wheel

STIFFNESS = (3e8, 2e7, 1e7)  #: of the springs along x, y and z [N/m]


def chain(nodes: int, *, clamped: bool = True, angle: float = 0.3) -> Superelement:
    """Return a chain of masses on springs along a radius, with the last mass as contact node."""
    size = 3 * nodes
    stiffness = np.zeros((size, size))
    for along, k in enumerate(STIFFNESS):
        for node in range(nodes):
            i = 3 * node + along
            stiffness[i, i] += k if node or clamped else 0.0
            if node:
                stiffness[i - 3, i - 3] += k
                stiffness[i, i - 3] = stiffness[i - 3, i] = -k
    return Superelement(
        mass=0.01 * np.eye(size),
        stiffness=stiffness,
        contact_position=np.array([[0.4 * np.cos(angle), 0.4 * np.sin(angle), 0.01]]),
        contact_dofs=np.array([[size - 3, size - 2, size - 1]]),
    )


def test_static_flexibility_is_exact_for_any_number_of_modes() -> None:
    part = chain(20)
    rows = part.contact_rows.toarray()
    static = rows @ np.linalg.solve(part.stiffness, rows.T)
    for modes in (3, 25):
        reduced = massless(part, modes)
        kept = (reduced.contact / reduced.frequency**2) @ reduced.contact.T
        assert kept + reduced.compliance == pytest.approx(static, rel=1e-10, abs=1e-16)
    assert static[2, 2] == pytest.approx(20 / STIFFNESS[2])
    some, compared = consistent(part, 9, 5), massless(part, 12)
    assert some.frequency[:3] == pytest.approx(compared.frequency[:3], rel=1e-3)
    stretched = (some.contact / some.frequency**2) @ some.contact.T
    assert stretched == pytest.approx(static, rel=1e-9, abs=1e-16)  # constraint modes are exact


def test_modes_of_other_speeds_keep_the_static_flexibility_exact() -> None:
    """Displacements of contact nodes and strains under forces on the contact nodes."""
    random = np.random.default_rng(5)
    part = replace(chain(20), strain_recovery=random.normal(size=(2, 60)))
    stiffer = part.stiffness + 1e7 * np.diag(random.uniform(size=60))
    reduced = massless(part, 9, others=[replace(part, stiffness=stiffer)])
    assert len(reduced.frequency) > 9
    rows = part.contact_rows.toarray()
    moved = np.linalg.solve(part.stiffness, rows.T)
    on_modes = (reduced.contact / reduced.frequency**2).T
    found = reduced.contact @ on_modes + reduced.compliance
    assert found == pytest.approx(rows @ moved, rel=1e-8, abs=1e-16)
    strained = reduced.strains @ on_modes + reduced.strains_by_force[0]
    expected = part.strain_recovery @ moved
    assert strained == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


def test_the_cost_of_a_large_superelement_is_told_before_and_its_progress(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(solver, "LARGE", 5)
    steps: list[tuple[int, int]] = []
    with listening(lambda _, done, total, __: steps.append((done, total))):
        massless(chain(20), 3)
    assert "Large superelement: 60 coordinates take about" in caplog.text
    assert steps == sorted(steps)
    assert 0 < steps[-1][0] <= steps[-1][1]
    monkeypatch.setattr(solver, "memory", lambda: 1e3)
    with pytest.raises(SuperelementError, match="expected a smaller superelement: 60"):
        massless(chain(20), 3)


def test_rigid_modes_are_left_out_of_the_flexibility() -> None:
    free, clamped = chain(20, clamped=False), chain(20)
    reduced = massless(free, 12)
    assert reduced.frequency[:3] == pytest.approx(0.0, abs=1.0)
    assert reduced.frequency[3] > 1e3
    all_modes = consistent(free, 57, 12)
    left_out = all_modes.contact[:, 12:] / all_modes.frequency[12:]
    assert reduced.compliance == pytest.approx(left_out @ left_out.T, rel=1e-6, abs=1e-16)
    assert massless(clamped, 12).frequency[0] > 1e3


def test_a_consistent_boundary_with_all_modes_has_the_frequencies_of_the_structure() -> None:
    part = chain(8)
    reduced = consistent(part, part.size - 3, 5)
    hertz = lowest_frequencies(part.mass, part.stiffness, part.size)
    assert reduced.frequency / (2 * np.pi) == pytest.approx(hertz, rel=1e-9)
    assert not reduced.compliance.any()


def test_impossible_reductions_are_refused() -> None:
    part = chain(4)
    with pytest.raises(SuperelementError, match="fewer free-interface modes than 10"):
        massless(chain(4, angle=np.pi / 2), 10)  # the soft springs are radial
    with pytest.raises(SuperelementError, match="at most 11 modes of 12 coordinates"):
        massless(part, 12)
    with pytest.raises(SuperelementError, match="at most 9 fixed-interface modes"):
        consistent(part, 10, 5)
    loose = 0.0 * part.stiffness
    with pytest.raises(SuperelementError, match="no motion without stiffness except rigid ones"):
        massless(replace(part, stiffness=loose), 3)
    soft = part.stiffness - 1e8 * np.diag([0.0] * 9 + [1.0, 0.0, 0.0])
    with pytest.raises(SuperelementError, match="not indefinite"):
        massless(replace(part, stiffness=soft), 3)


def ring(sectors: int) -> tuple[Superelement, Superelement]:
    """Return a wheel of equal chains, joined by springs at their middles, and one of its sectors.

    Both have nodes at the root, in the middle and at the tip of each sector.
    """
    pitch = 2.0 * np.pi / sectors
    one = chain(3, angle=0.0)
    whole = np.kron(np.eye(sectors), one.stiffness)
    turn = np.array(
        [[np.cos(pitch), -np.sin(pitch), 0], [np.sin(pitch), np.cos(pitch), 0], [0, 0, 1.0]]
    )
    for n in range(sectors):
        here, there = 9 * n + 3 + np.arange(3), 9 * ((n + 1) % sectors) + 3 + np.arange(3)
        # In axes of each sector, the next middle moves by R u.
        stretch = np.zeros((3, 9 * sectors))
        stretch[:, here], stretch[:, there] = -np.eye(3), turn
        whole += 4e7 * stretch.T @ stretch
    # The sector has a second middle node, without mass, which is that of the next sector.
    stretch = np.zeros((3, 12))
    stretch[:, 3:6], stretch[:, 9:] = -np.eye(3), np.eye(3)
    stiffness = np.zeros((12, 12))
    stiffness[:9, :9] = one.stiffness
    sector = replace(
        one,
        mass=np.diag([0.01] * 9 + [0.0] * 3),
        stiffness=stiffness + 4e7 * stretch.T @ stretch,
        left_dofs=np.array([[3, 4, 5]]),
        right_dofs=np.array([[9, 10, 11]]),
    )
    angles = pitch * np.arange(sectors)
    wheel = Superelement(
        mass=0.01 * np.eye(9 * sectors),
        stiffness=whole,
        contact_position=0.4 * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]),
        contact_dofs=np.full((sectors, 3), -1),
    )
    return wheel, sector


@pytest.mark.parametrize("sectors", [5, 6])
def test_a_wheel_from_a_sector_is_the_whole_wheel(sectors: int) -> None:
    wheel, sector = ring(sectors)
    nodes, reduced = WheelOverSpeeds(sector, sectors, 4).at(0.0)
    whole = np.sqrt(np.linalg.eigvalsh(wheel.stiffness / 0.01))
    lowest = reduced.frequency[: 2 * sectors]
    assert lowest == pytest.approx(whole[: 2 * sectors], rel=1e-9)
    nearest = np.abs(whole[:, None] - reduced.frequency).min(axis=0)
    assert nearest.max() < 1e-9 * whole[-1]
    tips = np.concatenate([9 * n + 6 + np.arange(3) for n in range(sectors)])
    static = np.linalg.inv(wheel.stiffness)[np.ix_(tips, tips)]
    kept = (reduced.contact / reduced.frequency**2) @ reduced.contact.T
    assert kept + reduced.compliance == pytest.approx(static, rel=1e-9, abs=1e-16)
    moved = wheel.contact_position + np.array([0.0, 0.0, 0.01])
    assert nodes.contact_position == pytest.approx(moved, abs=1e-15)
    # The assembled wheel has the same static flexibility, and the matrices of velocities.
    coriolis = np.kron(np.eye(4), [[0.0, -0.02, 0.0], [0.02, 0.0, 0.0], [0.0, 0.0, 0.0]])
    coriolis[9:] = 0.0  # the node on the right face has no mass
    assembled = whole_wheel(replace(sector, damping=sector.mass, gyroscopic=coriolis), sectors)
    rows = assembled.contact_rows
    flexibility = rows @ np.linalg.solve(dense(assembled.stiffness), rows.toarray().T)
    assert np.sort(np.linalg.eigvalsh(flexibility)) == pytest.approx(
        np.sort(np.linalg.eigvalsh(kept + reduced.compliance)), rel=1e-9
    )
    assert dense(assembled.damping) == pytest.approx(dense(assembled.mass))
    whole_coriolis = np.kron(np.eye(3 * sectors), coriolis[:3, :3])
    assert dense(assembled.gyroscopic) == pytest.approx(whole_coriolis, abs=1e-15)
    # In the modes of the wheel, these matrices give nearly the response of the assembled wheel.
    fast, damped = 20.0 * coriolis, 30.0 * np.asarray(sector.mass)
    turning = whole_wheel(replace(sector, damping=damped, gyroscopic=fast), sectors)
    _, modal = WheelOverSpeeds(replace(sector, damping=damped, gyroscopic=fast), sectors, 8).at(0.0)
    w = 0.6 * whole[0]
    matrices = (turning.stiffness, turning.damping, turning.gyroscopic, turning.mass)
    stiffness, loss, skew, inertia = map(dense, matrices)
    system = stiffness + 1j * w * (loss + 3000.0 * skew) - w**2 * inertia
    expected = rows @ np.linalg.solve(system, rows.toarray().T)
    assert modal.damping is not None
    assert modal.gyroscopic is not None
    squares = np.diag(modal.frequency**2 - w**2)
    answers = [
        modal.compliance
        + modal.contact
        @ np.linalg.solve(
            squares + 1j * w * (modal.damping + turn), modal.contact.T.astype(complex)
        )
        for turn in (3000.0 * modal.gyroscopic, -3000.0 * modal.gyroscopic)
    ]
    right, wrong = (np.abs(answer - expected).max() / np.abs(expected).max() for answer in answers)
    assert right < 0.001
    assert wrong > 0.05


def test_damping_of_large_structures_follows_from_their_lowest_modes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The root of the stiffness at rest, on few modes at a speed that changes their shapes."""
    part = bw.mesh3d(leaning_blade((3, 1, 1)), **STEEL, coriolis=True)
    turning = part.at(1500.0)
    exact = consistent(turning, 10, 10, root_at_rest(part)).root
    on_shapes = consistent(turning, 10, 10, root_on(part)).root
    monkeypatch.setattr("bladewhirl.models.superelements.reduction.ALL_MODES", 100)
    found = consistent(turning, 10, 10, root_at_rest(part)).root
    assert exact is not None
    assert found is not None
    assert on_shapes is not None
    assert np.diag(found) == pytest.approx(np.diag(exact), rel=2e-3)
    assert on_shapes[0, 0] > 1.5 * exact[0, 0]  # what the stiffness on the shapes alone gives


def root_on(part: Superelement) -> Root:
    return lambda shapes: np.asarray(root_of(shapes.T @ (part.stiffness @ shapes)))
