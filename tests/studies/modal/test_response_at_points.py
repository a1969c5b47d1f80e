"""Engine orders that act on points of a superelement: few modes and the residual flexibility give
the static displacement of the contact nodes by a solution of all coordinates."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from long_cases import slow_except
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector, cantilever

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.forced import forced_rotor
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.superelements.mistuned import mistuned_wheel
from bladewhirl.models.superelements.superelement import Superelement, dense
from bladewhirl.models.superelements.wheel import whole_wheel
from bladewhirl.studies.modal.response import engine_orders

MODES, ORDER, SLOW = 4, 3, 0.05
COPIES = {"blade": 3, "sector": SECTORS, "wheel": SECTORS}
SPEED = 900.0  # rad/s, far below the first critical speed
LOAD: dict[str, Any] = {
    "type": "engine-order",
    "order": ORDER,
    "amplitude": 2.0,
    "direction": "25 deg",
}


def part_of(kind: str, mistuned: bool) -> Superelement:
    if kind == "blade":
        return bw.mesh3d(cantilever("hexahedron", (6, 2, 1)), **STEEL, coriolis=True)
    mesh = bladed_sector("hexahedron")
    blade = "r > 0.0899" if mistuned else None
    part = bw.mesh3d(mesh, **STEEL, **TIE, contacts=2, coriolis=True, blade=blade)
    return part if kind == "sector" else whole_wheel(part, SECTORS)


def between(part: Superelement, low: float, high: float) -> IntArray:
    assert part.points is not None
    radius = np.hypot(*part.points[:, :2].T)
    return np.flatnonzero((radius > low) & (radius < high))


def case(
    folder: Path, kind: str, part: Superelement, points: IntArray, *, effects: str, mistuned: bool
) -> tuple[bw.Case, FloatArray]:
    """The case, and the factor on the stiffness of each blade."""
    bw.write_superelement(folder / "part.npz", part)
    factor = np.ones(COPIES[kind])
    if mistuned:
        factor = 1.0 + 0.03 * np.random.default_rng(2).standard_normal(COPIES[kind])
    table = {"file": str(folder / "part.npz"), "kind": kind, "copies": COPIES[kind]}
    disk: dict[str, Any] = {"superelement": table}
    if mistuned:
        disk["mistuning"] = {"stiffness": factor.tolist()}
    given = {
        "bladed_disk": disk,
        "casing": {"type": "rigid"},
        "shaft": {"clamped": True} if kind != "blade" else {},
        "damping": {"ratio": 1e-3},
        "excitation": LOAD | ({"points": points.tolist()} if len(points) else {}),
        "march": {"speed": f"{SPEED} rad/s"},
        "rotation": {"effects": effects},
        "reduction": {"free_interface_modes": MODES},
    }
    return bw.case_from(given), factor


def structure(kind: str, part: Superelement, factor: FloatArray, effects: str) -> Superelement:
    """The blade, or the assembled wheel, at its speed."""
    if kind != "blade":
        part = part if kind == "wheel" else whole_wheel(part, SECTORS)
        if part.blade_stiffness is not None:
            part = mistuned_wheel(part, factor)
    return part.at(SPEED) if effects != "none" else part


def forces(kind: str, whole: Superelement, points: IntArray) -> ComplexArray:
    """Forces on the coordinates of each copy, from the places of the points, (copies, n)."""
    assert whole.points is not None
    copies = COPIES["blade"] if kind == "blade" else 1
    blades = 1 if kind == "blade" else SECTORS
    number = points
    if kind == "sector":
        count = len(whole.points) // SECTORS
        number = (points + count * np.arange(SECTORS)[:, None]).ravel()
    nodes = np.exp(1j * whole.contact_angle.reshape(blades, -1)).mean(axis=1)
    angle = np.arctan2(*whole.points[number, 1::-1].T)
    blade = np.abs(np.angle(np.exp(1j * angle)[:, None] / nodes)).argmin(axis=1)
    load = np.zeros((copies, whole.size), dtype=complex)
    rows = dense(whole.recovery).reshape(-1, 3, whole.size)
    for copy in range(copies):
        turned = np.angle(nodes) + 2.0 * np.pi * copy / copies
        for n, a, b in zip(number, angle + np.deg2rad(25.0), blade, strict=True):
            share = LOAD["amplitude"] / np.sum(blade == b)
            along = np.cos(a) * rows[n, 0] + np.sin(a) * rows[n, 1]
            load[copy] += share * np.exp(1j * ORDER * turned[b]) * along
    return load


def statically(stage: Matrices) -> tuple[ComplexArray, ComplexArray]:
    """Displacements of the contact nodes of each copy by the modes, and by what they leave out."""
    (load,) = engine_orders(stage.case)
    disk = forced_rotor(stage, [load])
    ((_, force),), ((_, rest),) = disk.forces.items(), disk.static.items()
    modal = force.reshape(stage.copies, -1) / stage.reduced.frequency**2
    return modal / stage.factor[:, None] @ stage.reduced.contact.T, rest


KINDS = [
    *(("blade", effects, mistuned) for effects, mistuned in (("none", True), ("full", False))),
    *(("sector", "none", mistuned) for mistuned in (False, True)),
    *(("sector", "full", mistuned) for mistuned in (False, True)),
    *(("wheel", effects, False) for effects in ("none", "full")),
]
QUICK = [("blade", "full", False), ("sector", "none", True), ("wheel", "none", False)]


@pytest.mark.parametrize(("kind", "effects", "mistuned"), slow_except(KINDS, *QUICK))
def test_forces_on_points_move_contact_nodes_as_statically(
    kind: str, effects: str, mistuned: bool, tmp_path: Path
) -> None:
    part = part_of(kind, mistuned)
    points = between(part, *((0.24, 0.26) if kind == "blade" else (0.105, 0.115)))
    assert len(points) >= 4
    given, factor = case(tmp_path, kind, part, points, effects=effects, mistuned=mistuned)
    whole = structure(kind, part, factor, effects)
    load, rows = forces(kind, whole, points), whole.contact_rows.toarray()
    of_copies = (factor if kind == "blade" else np.ones(1))[:, None]
    stiffness = dense(whole.stiffness)
    expected = np.linalg.solve(stiffness, load.T).T / of_copies @ rows.T
    modal, rest = statically(build_matrices(given))
    largest = np.abs(expected).max()
    # The residual flexibility of a wheel of unequal sectors is estimated from that of equal ones.
    most = 3e-3 if kind == "sector" and mistuned else 1e-8
    assert modal + rest == pytest.approx(expected, abs=most * largest)
    assert np.abs(modal - expected).max() > 0.03 * largest


@pytest.mark.parametrize("kind", COPIES)
def test_a_slow_response_is_that_of_all_coordinates(kind: str, tmp_path: Path) -> None:
    """At a twentieth of the first frequency; without the residual flexibility it is a per cent
    off or more."""
    part = part_of(kind, mistuned=False)
    points = between(part, *((0.24, 0.26) if kind == "blade" else (0.105, 0.115)))
    given, factor = case(tmp_path, kind, part, points, effects="none", mistuned=False)
    given = bw.with_values(given, {"damping.ratio": 1e-7})
    stage = build_matrices(given)
    w = SLOW * stage.reference_frequency
    whole = structure(kind, part, factor, "none")
    dynamic = dense(whole.stiffness) - w**2 * dense(whole.mass)
    moved = np.linalg.solve(dynamic, forces(kind, whole, points).T).T @ whole.contact_rows.T
    expected = moved.reshape(COPIES[kind], -1, 3).mean(axis=1).T
    found = bw.response(given, speeds=[f"{w / ORDER} rad/s"]).isel(speed=0)
    largest = np.abs(expected).max()
    for row, name in enumerate(("tip_radial", "tip_tangential")):
        # The four modes of a whole wheel have other nodal diameters than the load.
        most = SLOW**2 if kind == "wheel" else 1e-4
        assert found[name].values == pytest.approx(expected[row], abs=most * largest)
    modal = statically(stage)[0].reshape(COPIES[kind], -1, 3).mean(axis=1).T
    assert np.abs(modal[:2] - expected[:2]).max() > 0.01 * largest


@pytest.mark.parametrize(("kind", "effects", "mistuned"), slow_except(KINDS, *QUICK))
def test_forces_on_contact_nodes_are_those_on_the_same_points(
    kind: str, effects: str, mistuned: bool, tmp_path: Path
) -> None:
    part = part_of(kind, mistuned)
    assert part.points is not None
    apart = np.linalg.norm(part.points[:, None] - part.contact_position, axis=2)
    same = apart.argmin(axis=0)
    assert apart.min(axis=0).max() < 1e-9
    both = []
    for points in (same, np.zeros(0, dtype=np.int64)):
        given, _ = case(tmp_path, kind, part, points, effects=effects, mistuned=mistuned)
        data = bw.response(given).isel(speed=0)
        both.append(np.array([data["tip_radial"], data["tip_tangential"]]))
    assert both[0] == pytest.approx(both[1], abs=1e-10 * np.abs(both[1]).max())
