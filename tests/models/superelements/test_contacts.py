"""Contact nodes at one place: on both faces of a sector, or twice in a file."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rod_blade import blade
from solid_meshes import grid_mesh

import bladewhirl as bw
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.superelements.contacts import with_single_contacts
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError
from bladewhirl.solvers.march.march import KernelState, Statistics
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

SECTORS = 6


def sector(steps: int = 2, **choice: Any) -> Superelement:
    """Return a sector of a ring whose outer surface is as wide as the pitch."""

    def shape(place: Any) -> Any:
        r, theta = 0.1 + 0.1 * place[:, 0], 2.0 * np.pi / SECTORS * place[:, 1]
        return np.stack([r * np.cos(theta), r * np.sin(theta), 0.01 * place[:, 2]], axis=1)

    mesh = grid_mesh(
        *((2, steps, 1), shape, "hexahedron"),
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
        once=lambda place: (place[:, 0] == 1.0) & (place[:, 1] < 1.0),
        left=lambda place: place[:, 1] == 0.0,
        right=lambda place: place[:, 1] == 1.0,
    )
    given: dict[str, Any] = {
        "young_modulus": 2.1e11,
        "poisson_ratio": 0.3,
        "density": 7800.0,
    } | choice
    faces: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    return bw.mesh3d(mesh, **given, **faces)


def case(file: Path, part: Superelement, clearance: float = 2e-4, **march: Any) -> Any:
    bw.write_superelement(file, part)
    return bw.case_from(
        {
            "bladed_disk": {
                "superelement": {"file": str(file), "kind": "sector", "copies": SECTORS}
            },
            "reduction": {"free_interface_modes": 4},
            "casing": {
                "type": "rigid",
                "clearance": clearance,
                "closure": {"amount": 1e-4, "time_constant": 1e-4},
                "profile": {"harmonics": [{"lobes": 2, "amplitude": 1.6e-4}]},
            },
            "march": {
                "speed": "6000 rpm",
                "time_step": 2e-6,
                "duration": 1e-3,
                "record_step": 1e-4,
                **march,
            },
        }
    )


def test_a_node_on_both_faces_of_a_sector_touches_once(tmp_path: Path) -> None:
    twice, once = sector(6), sector(6, contact="once")
    assert np.array_equal(twice.contact_position, once.contact_position)
    assert np.array_equal(twice.contact_dofs, once.contact_dofs)
    assert len(twice.contact_position) == 6 * 2
    angle = np.sort(sector(6, contacts=3).contact_angle)
    steps = np.diff([*angle, angle[0] + 2.0 * np.pi / SECTORS])
    assert steps == pytest.approx(np.pi / 9.0)  # also from the last node to the next sector
    assert sector(6, contacts=12).contacts == 12
    with pytest.raises(CaseError, match="a whole number from 1 to 12, all nodes"):
        sector(6, contacts=13)


def doubled(part: Superelement, apart: float) -> Superelement:
    """Return a sector whose contact nodes on the left face are also listed on the right face, at a
    distance [m] from their places."""
    assert part.left_dofs is not None
    assert part.right_dofs is not None
    left = [row.tolist() for row in part.left_dofs]
    partner = {row: n for n, row in enumerate(map(tuple, left))}
    rows = [n for n, dofs in enumerate(part.contact_dofs) if tuple(dofs) in partner]
    chosen = [partner[tuple(part.contact_dofs[n])] for n in rows]
    place = part.contact_position[rows]
    angle = np.arctan2(place[:, 1], place[:, 0]) + 2.0 * np.pi / SECTORS - apart / 0.2
    radius = np.hypot(place[:, 0], place[:, 1])
    moved = np.stack([radius * np.cos(angle), radius * np.sin(angle), place[:, 2]], axis=1)
    return replace(
        part,
        contact_position=np.concatenate([part.contact_position, moved]),
        contact_dofs=np.concatenate([part.contact_dofs, part.right_dofs[chosen]]),
    )


def test_a_file_with_nodes_on_both_faces_is_marched_with_one_of_each(tmp_path: Path) -> None:
    part = sector()
    file = case(tmp_path / "twice.npz", doubled(part, 0.0))
    assert file.bladed_disk.superelement.part.contacts == 4
    stage = build_matrices(file)
    assert stage.part.contacts == 4 * SECTORS
    assert "2 contact nodes of the file are left out" in next(stage.own_hints())
    result, report = march_in_memory(prepare(file))
    expected, _ = march_in_memory(prepare(case(tmp_path / "once.npz", part)))
    assert report["unsolved_steps"] == 0
    assert float(expected["contact_impulse"].sum()) > 0.0
    assert result["contact_impulse"].values == pytest.approx(expected["contact_impulse"].values)


@pytest.mark.slow
@pytest.mark.parametrize(("unsolved", "share"), [(2, 1e-3), (2, 0.1), (1, 1e-3)])
def test_unsolved_steps_are_an_error_or_the_first_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unsolved: int, share: float
) -> None:
    found: Any = {"lcp_failures": unsolved, "first_unsolved": 7, "unsolved_impulse": 1e-3}
    statistics = property(lambda state: Statistics(steps=state.step, **found))
    monkeypatch.setattr(KernelState, "statistics", statistics)
    given = case(tmp_path / "part.npz", sector(), 1e-3, unsolved_share=share, duration=2e-3)
    text = f"contact problem of {unsolved} of 1000 steps was not solved: check for contact nodes"
    if unsolved > share * 1000:
        with pytest.raises(CaseError, match=f"march.unsolved_share = 0.001: expected .* {text}"):
            bw.run(given, tmp_path / "run", frames=0)
        assert [path.name for path in tmp_path.iterdir()] == ["part.npz"]
        allowed = case(tmp_path / "part.npz", sector(), 1e-3, unsolved_share=1.0)
        bw.run(allowed, tmp_path / "run", frames=0)
        before = {path: path.stat().st_mtime_ns for path in (tmp_path / "run").iterdir()}
        with pytest.raises(CaseError, match=text):
            bw.run(given, tmp_path / "run", frames=0, overwrite=True)
        assert {path: path.stat().st_mtime_ns for path in (tmp_path / "run").iterdir()} == before
        assert {path.name for path in tmp_path.iterdir()} == {"part.npz", "run"}
        return
    run = bw.run(given, tmp_path / "run", frames=0)
    first = " ".join(repr(run).split())
    assert first.startswith(f"The {text.split(':')[0]} (first at 14 µs, residual 0; ")
    assert "of the impulse): check for contact nodes" in first


def test_contact_nodes_at_one_place_are_kept_once_on_each_blade() -> None:
    part = blade()
    place = part.contact_position.copy()
    place[2] = place[0] + 1e-9
    again = with_single_contacts(replace(part, contact_position=place), "blade", 1)
    assert np.array_equal(again.contact_dofs, part.contact_dofs[:2])
    assert with_single_contacts(part, "blade", 1) is part
    # Blades of a wheel meet at the middle of their pitch.
    angle = np.array([-np.pi / 2.0, 0.0, np.pi / 2.0, np.pi / 2.0, np.pi, 1.5 * np.pi])
    ring = np.asarray(0.3 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1), float)
    dofs = np.concatenate([part.contact_dofs, part.contact_dofs - 9])
    wheel = replace(part, contact_position=ring, contact_dofs=dofs)
    kept = with_single_contacts(wheel, "wheel", 2)
    assert np.array_equal(kept.contact_dofs, dofs[[0, 1, 3, 4]])
    ring[5, 2] = 2e-3
    with pytest.raises(SuperelementError, match="1 of 6 are at the place of others, on some"):
        with_single_contacts(replace(wheel, contact_position=ring), "wheel", 2)
