"""Wheels of solids on a shaft line, compared with the whole rotor in rotating axes."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from long_cases import slow_except
from plain_rotor import NU, RHO, E, Shaft, eigenvalues, rotor
from scipy.sparse.linalg import spsolve
from solid_meshes import fan_sector, grid_mesh, whole

from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.shaft_line.axial import axial_modes
from bladewhirl.models.shaft_line.hub_waves import hub_waves
from bladewhirl.models.shaft_line.line import line_model
from bladewhirl.models.shaft_line.orders import moves_line, order_motion
from bladewhirl.models.shaft_line.whirl import line_modes, sag
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.superelements.file import write_superelement

SECTORS = 5
TIE: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
STEEL: dict[str, Any] = {"young_modulus": E, "poisson_ratio": NU, "density": RHO}
SOLID: dict[str, Any] = {**STEEL, "stress": False, "hub": "root", "hub_at": "-5 mm"}

SHAFT = Shaft(
    length=0.6,
    diameter=0.04,
    elements=3,
    bearings=((0, 2e7, 2e3), (2, 1e7, 1e3)),
    hub=3,
    axial=(0, 5e7),
)
LINE: dict[str, Any] = {
    "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 3}],
    "bearings": [
        {"position": 0.0, "stiffness": 2e7, "damping": 2e3},
        {"position": 0.4, "stiffness": 1e7, "damping": 1e3},
    ],
    "wheel": {"position": 0.6},
    "axial": {"position": 0.0, "stiffness": 5e7},
}


@cache
def fan(kind: str) -> Any:
    sector = fan_sector(SECTORS)
    if kind == "sector":
        return mesh3d(sector, **SOLID, **TIE)
    return mesh3d(whole(sector, SECTORS), **SOLID)


def case_of(folder: Path, part: Any, omega: float = 0.0, **line: Any) -> Case:
    write_superelement(folder / "fan.npz", part)
    return case_from(
        {
            "material": {"young_modulus": E, "density": RHO},
            "bladed_disk": {"superelement": {"file": str(folder / "fan.npz")}},
            "shaft_line": LINE | line,
            "gravity": {},
            "march": {"speed": f"{omega} rad/s"},
        }
    )


@pytest.mark.parametrize(
    ("kind", "omega"),
    [
        pytest.param("sector", 0.0, marks=pytest.mark.slow),
        pytest.param("wheel", 300.0, marks=pytest.mark.slow),
        ("sector", 900.0),
    ],
)
def test_a_fan_whirls_as_in_the_whole_rotor(kind: str, omega: float, tmp_path: Path) -> None:
    """Nodal diameters 0 and 1 with blades, damped bearings and an axial spring."""
    line = line_model(case_of(tmp_path, fan(kind), omega))
    modes, axial = line_modes(line, omega), axial_modes(line, omega)
    mine: list[tuple[str, Any]] = [*zip(modes.direction, modes.eigenvalue, strict=True)]
    mine += [("axial", value) for value in axial.eigenvalue]
    whole_rotor = eigenvalues(SHAFT, fan("wheel"), omega, 1500j, 16)
    assert len(whole_rotor) >= 8
    assert {"backward", "axial"} < {whirl for whirl, _ in whole_rotor}
    for whirl, value in whole_rotor:
        alike = {whirl} if omega or whirl == "axial" else {"forward", "backward"}
        own = np.array([each for name, each in mine if name in alike])
        assert abs(own - value).min() < 1e-9 * abs(value), (whirl, value)


UNEQUAL = [
    {"position": 0.0, "stiffness": [[2e7, 3e6], [-1e6, 1e7]], "damping": [[2e3, 0.0], [0.0, 5e2]]},
    {
        "position": 0.4,
        "stiffness": 1e7,
        "damping": 1e3,
        "support": {"mass": 5.0, "stiffness": [[4e7, 0.0], [0.0, 2e7]]},
    },
]


@pytest.mark.parametrize(
    "bearings",
    [pytest.param(LINE["bearings"], marks=pytest.mark.slow), UNEQUAL],
    ids=["round", "unequal"],
)
def test_rotor_of_a_stiff_thin_wheel_is_that_of_a_rigid_disk(bearings: Any, tmp_path: Path) -> None:
    def disk(place: Any) -> Any:
        r, theta = 0.03 + 0.17 * place[:, 0], 2.0 * np.pi / SECTORS * place[:, 1]
        return np.stack([r * np.cos(theta), r * np.sin(theta), 0.004 * place[:, 2]], axis=1)

    faces: dict[str, Any] = {
        "root": lambda place: place[:, 0] == 0.0,
        "tip": lambda place: (place[:, 0] == 1.0) & (place[:, 1] == 0.5) & (place[:, 2] == 0.5),
        "left": lambda place: place[:, 1] == 0.0,
        "right": lambda place: place[:, 1] == 1.0,
    }
    mesh = grid_mesh((2, 2, 1), disk, "hexahedron27", **faces)
    stiff = {**SOLID, "young_modulus": 1e6 * E, "hub_at": None}
    part = mesh3d(mesh, **stiff, **TIE)
    found = hub_waves(part, 0.0)
    mass, tilting = found[1].mass[0, 0].real, found[1].mass[1, 1].real
    rigid = {
        "position": 0.6,
        "mass": mass,
        "polar_inertia": found[0].mass[1, 1].real,
        "diametral_inertia": tilting,
    }
    for omega in (0.0, 400.0, 2000.0):
        second = {"position": 0.2, "superelement": {"file": str(tmp_path / "fan.npz")}}
        two = {"bearings": bearings, "wheels": [second]}
        solid = line_modes(line_model(case_of(tmp_path, part, omega, **two)), omega, 6)
        tables = {key: value for key, value in LINE.items() if key not in ("wheel", "axial")}
        tables |= {"bearings": bearings}
        own = {
            "shaft_line": tables | {"disks": [rigid, rigid | {"position": 0.2}]},
            "material": {"young_modulus": E},
        }
        plain = line_modes(line_model(case_from(own)), omega, 6)
        assert solid.direction[2:] == plain.direction[2:]
        assert solid.eigenvalue == pytest.approx(plain.eigenvalue, rel=3e-5)


def test_determinant_of_shaft_in_static_and_wheel_in_rotating_axes(tmp_path: Path) -> None:
    """The dynamic stiffness of the shaft at s + i Omega plus that of the wheel at s is singular."""
    omega = 700.0
    line = line_model(case_of(tmp_path, fan("sector"), omega))
    bare = {key: LINE[key] for key in ("segments", "bearings")}
    wave, shaft = line.wheels[0].whirling, line_model(case_from({"shaft_line": bare}))
    line_forms = shaft.forms(omega)
    wheel_forms = wave.mass, wave.drag(omega), wave.stiffness_at(omega)
    modes = line_modes(line, omega, 6)
    node = [2 * shaft.node(0.6), 2 * shaft.node(0.6) + 1]
    for whirl, value in zip(modes.direction, modes.eigenvalue, strict=True):
        static = value if whirl == "forward" else value.conj()  # of z

        at_speed = zip((static, static - 1j * omega), (line_forms, wheel_forms), strict=True)
        hub = [
            la.inv(la.inv(stiffness + s * drag + s**2 * mass)[np.ix_(rows, rows)])
            for (s, (mass, drag, stiffness)), rows in zip(at_speed, (node, [0, 1]), strict=True)
        ]
        size = np.sqrt(sum(abs(np.diag(each)) for each in hub))
        assert abs(la.det(sum(hub) / np.outer(size, size))) < 1e-6


def test_a_turning_fan_hangs_with_its_weight_on_the_bearings(tmp_path: Path) -> None:
    """Without the static displacement of the blades, by which their centre of mass moves."""
    part = mesh3d(fan_sector(SECTORS), **SOLID, **TIE, stiffening="stress")
    line = line_model(case_of(tmp_path, part, 600.0))
    forces = line.bearing_force(sag(line, 600.0), np.zeros(line.size, dtype=complex))
    mass = RHO * np.pi / 4.0 * 0.04**2 * 0.6
    [wheel] = line.wheels
    of_wheel, arm = wheel.whirling.mass[0, :2].real
    assert forces.sum() == pytest.approx(9.81j * (of_wheel + mass), rel=1e-8)
    moment = 9.81j * (of_wheel * 0.6 + arm + mass * 0.3)
    assert (forces * np.array([0.0, 0.4])).sum() == pytest.approx(moment, rel=1e-8)


def test_the_case_may_state_the_number_of_sectors(tmp_path: Path) -> None:
    given = case_of(tmp_path, fan("sector"))
    unknown = replace(fan("sector"), sectors=None)
    write_superelement(tmp_path / "unknown.npz", unknown)
    own = {"file": str(tmp_path / "unknown.npz"), "copies": SECTORS}
    tables = given.model_dump(exclude_defaults=True)
    stated = case_from({"bladed_disk": {"superelement": own}, "shaft_line": tables["shaft_line"]})
    expected = line_modes(line_model(given), 0.0, 4).eigenvalue
    assert line_modes(line_model(stated), 0.0, 4).eigenvalue == pytest.approx(expected, rel=1e-12)
    few = {"bladed_disk": {"superelement": own | {"copies": 2}}}
    with pytest.raises(CaseError, match="sectors: expected at least 3"):
        line_model(case_from(few | {"shaft_line": tables["shaft_line"]}))


def test_a_hub_of_two_unknowns_does_not_tilt(tmp_path: Path) -> None:
    """Without blades that bend, the tilt is that of the shaft alone."""
    two = line_model(
        case_of(tmp_path, fan("sector"), wheel={"position": 0.6, "unknowns": "two"}, axial=None)
    )
    four = line_model(
        case_of(tmp_path, fan("sector"), wheel={"position": 0.6, "unknowns": "four"}, axial=None)
    )
    assert two.size == four.size
    node = 2 * two.node(0.6) + 1
    assert node not in two.wheels[0].unknowns
    assert len(axial_modes(four, 0.0).eigenvalue) == 0
    assert line_modes(two, 0.0, 1).eigenvalue.imag > line_modes(four, 0.0, 1).eigenvalue.imag


def test_either_of_two_wheels_may_be_that_of_the_bladed_disk(tmp_path: Path) -> None:
    found = []
    for first, other in ((0.6, 0.3), (0.3, 0.6)):
        second = {"position": other, "superelement": {"file": str(tmp_path / "fan.npz")}}
        tables = {"wheel": {"position": first}, "wheels": [second]}
        line = line_model(case_of(tmp_path, fan("sector"), 400.0, **tables))
        axial = axial_modes(line, 400.0)
        found.append([line_modes(line, 400.0, 12).eigenvalue, axial.eigenvalue[:6]])
    for one, swapped in zip(*found, strict=True):
        assert one == pytest.approx(swapped, rel=1e-9)


SECOND: dict[str, Any] = {"position": 0.2, "superelement": {"file": "fan.npz"}}


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"wheel": {"position": 0.7}}, "shaft_line.wheel.position"),
        ({"wheel": {"position": 0.6, "unknowns": "four"}}, "shaft_line.axial"),
        ({"drive_position": -1.0}, "shaft_line.drive_position"),
        ({"wheels": [SECOND | {"position": 0.9}]}, "shaft_line.wheels[0].position"),
        ({"wheels": [SECOND, SECOND]}, "shaft_line.wheels[1].position"),
        ({"wheels": [SECOND | {"position": 0.6}]}, "shaft_line.wheels[0].position"),
        ({"axial": {"position": 3.0, "stiffness": 1e7}}, "shaft_line.axial.position"),
    ],
)
def test_wheels_off_the_shaft_or_at_one_place_are_refused(
    change: Any, key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CaseError) as error:
        case_of(tmp_path, fan("sector"), **change)
    assert [fault.key for fault in error.value.faults] == [key]


def test_a_march_of_further_wheels_alone_is_refused(tmp_path: Path) -> None:
    further = {"position": 0.6, "superelement": {"file": str(tmp_path / "fan.npz")}}
    write_superelement(tmp_path / "fan.npz", fan("sector"))
    line = {key: LINE[key] for key in ("segments", "bearings")} | {"wheels": [further]}
    with pytest.raises(CaseError, match=r"shaft_line.wheels = .*: expected none without"):
        build_stage(case_from({"shaft_line": line}))


def test_a_file_without_hub_is_refused(tmp_path: Path) -> None:
    clamped = mesh3d(fan_sector(SECTORS), **STEEL, **TIE, stress=False)
    with pytest.raises(CaseError, match=r"superelement.file.*: expected a file with hub_dofs"):
        case_of(tmp_path, clamped)
    still = mesh3d(fan_sector(SECTORS), **SOLID, **TIE, stiffening=None)
    with pytest.raises(CaseError, match=r"expected stiffness_speed, by which"):
        line_model(case_of(tmp_path, still, 100.0))
    uneven = fan_sector(SECTORS)
    mesh = whole(uneven, SECTORS)
    blade = mesh.points[:, 0] > 0.1
    mesh.points[blade, 2] *= 1.05
    with pytest.raises(CaseError, match="expected equal blades"):
        line_model(case_of(tmp_path, mesh3d(mesh, **SOLID)))


@pytest.mark.parametrize("order", slow_except([4, 5, 6, 9, 1], 5, 1))
def test_forces_on_blades_move_the_whole_rotor(order: int, tmp_path: Path) -> None:
    """Orders of nodal diameter 0 and 1 of five blades, forward and backward."""
    omega, load = 300.0, EngineOrder(order=(order,), amplitude=10.0, phase=0.3, direction=0.4)
    line = line_model(case_of(tmp_path, fan("sector"), omega))
    assert moves_line(line, order)
    ours = order_motion(line, omega, load, order)
    wheel = fan("wheel")
    mass, drag, stiffness = rotor(SHAFT, wheel, omega)
    rate, size = order * omega, wheel.size - 6
    angle = wheel.contact_angle
    blade = np.rint(angle * SECTORS / (2.0 * np.pi)) * 2.0 * np.pi / SECTORS
    rows = wheel.contact_rows.toarray().reshape(-1, 3, wheel.size)
    along = np.cos(0.4) * rows[:, 0] + np.sin(0.4) * rows[:, 1]
    shares = 10.0 * SECTORS / len(angle) * np.exp(1j * (order * blade + 0.3))
    on_wheel = np.delete(shares @ along, wheel.hub_dofs)
    force = np.concatenate([on_wheel, np.zeros(mass.shape[0] - size)])
    dynamic = sp.csc_array(stiffness + 1j * rate * drag - rate**2 * mass)
    moved = spsolve(dynamic, force)
    hub = size + 6 * SHAFT.hub - 1
    first = np.flatnonzero(abs(np.angle(np.exp(1j * angle))) < np.pi / SECTORS)
    inner = np.delete(rows[first, :2].mean(axis=0), wheel.hub_dofs, axis=1)
    assert not rows[first][:, :, wheel.hub_dofs].any()
    tip = inner @ moved[:size]
    if (order + 1) % SECTORS == 0 or order % SECTORS == 0:
        assert ours.tip[0] == pytest.approx(tip, rel=1e-7)
    else:
        assert ours.tip[0] == pytest.approx(tip.conj(), rel=1e-7)
    assert abs(ours.tip[1]).max() < 1e-12 * abs(tip).max()
    x, y, z = moved[hub : hub + 3]
    node = line.node(0.6)
    if order % SECTORS == 0:
        assert ours.axial == pytest.approx(z, rel=1e-7)
        assert ours.torsion == pytest.approx(moved[hub + 5], rel=1e-7)
    else:
        largest = abs(ours.forward[node]) + abs(ours.backward[node])
        assert largest == pytest.approx(np.hypot(abs(x), abs(y)) / np.sqrt(2.0), rel=1e-7)
    assert not moves_line(line, 2)
