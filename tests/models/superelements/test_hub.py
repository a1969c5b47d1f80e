"""Wheels and sectors with a hub that tilts."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io as sio
import scipy.linalg as la
import scipy.sparse as sp
from solid_meshes import STEEL, fan_sector, whole

import bladewhirl as bw
from bladewhirl.meshes.files.volumes import read_volume_mesh
from bladewhirl.models.imports.inspection import inspect
from bladewhirl.models.inputs.errors import CaseError, Hint
from bladewhirl.models.solids.assembly import Solid, stiffness_by_rotation
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.solids.materials import materials_of
from bladewhirl.models.solids.rigid import free_displacements
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.file import read_superelement, write_superelement
from bladewhirl.models.superelements.hub import (
    WAVES,
    check_hub,
    of_all_sectors,
    rigid_body,
    rigid_motions,
    without_tilt,
)
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

SECTORS = 5
SPARSE = ("_data", "_indices", "_indptr", "_shape")
SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def sector(**given: Any) -> Any:
    tie: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    return mesh3d(fan_sector(SECTORS), **STEEL, **tie, stress=False, **{"hub": "root", **given})


def wheel(**given: Any) -> Any:
    mesh = whole(fan_sector(SECTORS), SECTORS)
    return mesh3d(mesh, stress=False, **{**STEEL, "hub": "root", **given})


def forms(part: Superelement) -> dict[str, Any]:
    motions, sectors = rigid_motions(part), part.sectors or 1
    names = ("mass", "gyroscopic", "stiffness_speed")
    return {
        name: of_all_sectors(motions.T @ (matrix @ motions), sectors)
        for name, matrix in part.given(names).items()
    }


def test_matrices_of_a_rigid_body_are_those_of_its_particles() -> None:
    """u = d + phi x X + phi x (phi x X) / 2 in the kinetic energy of a turning frame."""
    rng = np.random.default_rng(4)
    mass, gyroscopic, stiffness = np.zeros((3, 6, 6))
    plane = np.diag([1.0, 1.0, 0.0])
    for m, place in zip(rng.random(5), rng.standard_normal((5, 3)), strict=True):
        move = np.hstack([np.eye(3), np.cross(np.eye(3), place).T])
        mass += m * move.T @ move
        gyroscopic += 2.0 * m * move.T @ SPIN @ move
        stiffness -= m * move.T @ plane @ move
        pull = plane @ place
        product = np.outer(place, pull)
        stiffness[3:, 3:] -= m * ((product + product.T) / 2.0 - place @ pull * np.eye(3))
    body = rigid_body(mass)
    assert body["gyroscopic"] == pytest.approx(gyroscopic, abs=1e-13)
    assert body["stiffness_speed"] == pytest.approx(stiffness, abs=1e-13)


@pytest.mark.parametrize("stiffening", ["stress", "prestress"])
@pytest.mark.parametrize("made", [sector, wheel])
def test_a_wheel_is_a_rigid_body_on_the_motions_of_its_hub(made: Any, stiffening: str) -> None:
    found = forms(made(stiffening=stiffening, hub_at="-5 mm"))
    mass, arm = found["mass"][0, 0], found["mass"][0, 4]
    polar, tilting = found["mass"][5, 5], found["mass"][3, 3]
    still = np.diag([-mass, -mass, 0.0, polar - tilting, polar - tilting, 0.0])
    still[0, 4] = still[4, 0] = -arm
    still[1, 3] = still[3, 1] = arm
    assert found["stiffness_speed"] == pytest.approx(still, abs=1e-10 * mass)
    drag = np.zeros((6, 6))
    drag[:2, :2] = 2.0 * mass * SPIN[:2, :2]
    drag[3:5, 3:5] = (2.0 * tilting - polar) * SPIN[:2, :2]
    drag[[0, 1], [3, 4]], drag[[3, 4], [0, 1]] = 2.0 * arm, -2.0 * arm
    assert found["gyroscopic"] == pytest.approx(drag, abs=1e-10 * mass)


def test_sectors_and_the_whole_wheel_have_one_rigid_body() -> None:
    one, all_of_it = forms(sector()), forms(wheel())
    for name, matrix in one.items():
        assert matrix == pytest.approx(all_of_it[name], abs=1e-11 * one["mass"][0, 0])


@pytest.mark.parametrize("motion", [0, 1], ids=["translation", "tilt"])
def test_a_free_wheel_stays_where_it_is_pushed_or_tilted(motion: int) -> None:
    """At rest in static axes, exp(-i Omega t) in rotating ones; without the tie it does not."""
    part = wheel(stiffening="stress")
    field = rigid_motions(part) @ WAVES[1][:, motion].conj()
    assert abs(part.stiffness @ field).max() < 1e-12 * abs(part.stiffness).max()
    turning = part.stiffness_speed @ field
    balance = turning - 1j * part.gyroscopic @ field - part.mass @ field
    assert abs(balance).max() < 1e-10 * abs(turning).max()
    by_hub = abs((part.stiffness_speed @ field)[part.hub_dofs[3:]])
    untied = sp.lil_array(part.stiffness_speed)
    untied[part.hub_dofs[3:], part.hub_dofs[3:]] = 0.0
    assert motion == 0 or abs(untied.tocsr() @ field - turning).max() > 0.1 * by_hub.max()


def test_a_free_rigid_wheel_nutates_and_nothing_grows() -> None:
    """Eigenvalues at 1 rad/s: -i three times, and i (I_p / I_t - 1)."""
    wave = WAVES[1].conj()
    found = {name: wave.conj().T @ one @ wave / 2.0 for name, one in forms(wheel()).items()}
    mass, one = found["mass"], np.eye(2)
    stiffness, drag = (la.solve(mass, found[name]) for name in ("stiffness_speed", "gyroscopic"))
    values = la.eigvals(np.block([[0.0 * one, one], [-stiffness, -drag]]))
    tilting = (mass[1, 1] - abs(mass[0, 1]) ** 2 / mass[0, 0]).real
    polar = forms(wheel())["mass"][5, 5]
    expected = [-1.0, -1.0, -1.0, polar / tilting - 1.0]
    assert np.sort(values.imag) == pytest.approx(expected, abs=1e-6)  # a triple one has 8 digits
    assert abs(values.real).max() < 1e-6
    assert np.poly(values) == pytest.approx(np.poly(1j * np.array(expected)), abs=1e-10)


def test_a_hub_without_the_matrix_of_the_tie_is_refused() -> None:
    part = wheel()
    loose = sp.lil_array(part.stiffness_speed)
    loose[part.hub_dofs[3], part.hub_dofs[3]] *= 0.9
    with pytest.raises(SuperelementError, match=r"stiffness_speed: .* matrix of the tie missing"):
        inspect(replace(part, stiffness_speed=loose.tocsr()))
    for name, factor in (("gyroscopic", 0.5), ("stiffness_speed", 2.0)):
        other: Any = replace(part, **{name: factor * getattr(part, name)})
        with pytest.raises(SuperelementError, match=f"{name}: expected that of a rigid wheel"):
            check_hub(other, rigid_motions(other))


def test_imported_matrices_get_the_hub_of_mesh3d(tmp_path: Path) -> None:
    mesh = read_volume_mesh(fan_sector(SECTORS))
    materials = materials_of(mesh, STEEL, "m", None)
    solid = Solid(mesh, materials)
    stiffness, mass, root = solid.stiffness(), solid.mass(), mesh.groups["root"]
    held = sector(hub=None, clamped="root")
    select = free_displacements(solid.size, solid.points, root, [])[1]
    tie = select @ transformation(held, SECTORS, 0)
    changes: Any = stiffness_by_rotation(solid, stiffness, mass, tie, "prestress")
    for name, speed in (("still", 0.0), ("half", 500.0), ("full", 1000.0)):
        matrix = sp.coo_matrix(stiffness + speed**2 * changes[0] + speed**4 * changes[1])
        sio.mmwrite(tmp_path / f"{name}.mtx", matrix, precision=17)
    sio.mmwrite(tmp_path / "m.mtx", sp.coo_matrix(sp.kron(mass, np.eye(3))), precision=17)
    rows = ["node,x,y,z,group"]
    for node, place in enumerate(mesh.points.tolist()):
        groups = " ".join(name for name, nodes in mesh.groups.items() if node in nodes)
        rows.append(",".join([str(node + 1), *map(repr, place), groups]))
    (tmp_path / "nodes.csv").write_text("\n".join(rows) + "\n")
    given: dict[str, Any] = {"contact": "tip", "left": "left", "right": "right", "hub": "root"}
    given |= {"mass": tmp_path / "m.mtx", "nodes": tmp_path / "nodes.csv", "copies": SECTORS}
    at: dict[Any, Any] = {500.0: tmp_path / "half.mtx", 1000.0: tmp_path / "full.mtx"}
    found = bw.import_superelement(tmp_path / "still.mtx", at=at, **given)
    expected = sector()
    for name, tolerance in (("mass", 1e-12), ("gyroscopic", 1e-12), ("stiffness_speed", 1e-9)):
        ours, theirs = getattr(found, name), getattr(expected, name)
        assert abs(ours - theirs).max() < tolerance * abs(theirs).max()
    with pytest.warns(Hint, match="stiffness_speed missing"):
        bw.import_superelement(tmp_path / "still.mtx", **given)


def test_a_hub_is_written_read_and_converted(tmp_path: Path) -> None:
    part = sector(hub_at="-5 mm")
    write_superelement(tmp_path / "fan.npz", part)
    again: Any = read_superelement(tmp_path / "fan.npz")
    assert np.array_equal(again.hub_dofs, part.hub_dofs)
    assert again.hub_position.tolist() == [0.0, 0.0, -0.005]
    with np.load(tmp_path / "fan.npz") as file:
        content = dict(file)
    hub = part.hub_dofs[3:]
    unit = np.ones(part.size)
    unit[hub] = 1e3
    turn = sp.diags_array(unit)
    content["recovery"] = (part.recovery @ turn).toarray()
    for name in ("mass", "stiffness", "gyroscopic", "stiffness_speed", "stiffness_speed4"):
        content[name] = (turn @ getattr(part, name) @ turn).toarray() / 1e3
    content = {key: one for key, one in content.items() if not key.endswith(SPARSE)}
    for name in ("contact_position", "hub_position", "points"):
        content[name] = 1e3 * content[name]
    for name in ("centrifugal_load", "euler_load"):
        content[name] = unit * content[name]
    np.savez(tmp_path / "mm.npz", **content, length_unit="mm", mass_unit="t")
    converted = read_superelement(tmp_path / "mm.npz")
    for name in ("mass", "stiffness_speed", "recovery"):
        ours, theirs = (sp.csr_array(getattr(one, name)) for one in (converted, part))
        assert abs(ours - theirs).max() < 1e-12 * abs(theirs).max()


def test_a_hub_that_does_not_tilt_is_a_centre_or_held() -> None:
    moving, held = without_tilt(wheel()), without_tilt(sector())
    assert moving.centre_dofs is not None
    assert moving.size == wheel().size - 4
    assert held.centre_dofs is None
    assert held.size == sector(hub=None, clamped="root").size
    clamped = sector(hub=None, clamped="root", coriolis=True)
    assert abs(held.gyroscopic - clamped.gyroscopic).max() < 1e-15


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"clamped": "tip"}, "clamped = .tip.: expected none with hub"),
        ({"speed": 10.0}, "speed = 10.0: expected 0 with hub"),
        ({"hub_at": "here"}, "hub_at = .here.: expected a position"),
        ({"hub": "bore"}, "hub = .bore.: expected a group of nodes"),
        ({"hub": "tip"}, "contact: expected nodes that are not clamped"),
    ],
)
def test_invalid_hubs_are_refused(given: dict[str, Any], expected: str) -> None:
    with pytest.raises(CaseError, match=expected):
        wheel(**given)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"hub_position": None}, "both hub_dofs and hub_position"),
        (
            {"hub_position": np.array([0.01, 0.0, 0.0])},
            "hub_position: expected a point on the axis",
        ),
        ({"hub_dofs": np.arange(5)}, r"hub_dofs: expected whole numbers \(6,\)"),
        ({"hub_dofs": np.arange(6)}, "contact_dofs: .* that are not those of the hub"),
        ({"centre_dofs": np.array([7, 8])}, "hub_dofs or centre_dofs, not both"),
    ],
)
def test_invalid_arrays_of_hubs_are_refused(change: dict[str, Any], expected: str) -> None:
    part = replace(
        wheel(),
        contact_dofs=np.array([[0, 1, 2]] * SECTORS)[:1],
        contact_position=wheel().contact_position[:1],
    )
    with pytest.raises(SuperelementError, match=expected):
        replace(part, **change)
