"""Shaft lines compared with published rotors and with the rotor of another program, and wheels of
solids with rigid bodies."""

from functools import cache
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import scipy.linalg as la

from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.shaft_line.hub_waves import hub_waves
from bladewhirl.models.shaft_line.line import LineModel, line_model
from bladewhirl.models.shaft_line.whirl import line_modes, unbalance_response
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.line import LineStage
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.models.superelements.hub import (
    NEEDED,
    WAVES,
    hub_freed,
    hub_of,
    inner_dofs,
    of_all_sectors,
    rigid_motions,
)
from bladewhirl.models.superelements.superelement import Superelement
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.periodic.corotating import contact_states
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies

RPM = np.pi / 30.0

FRISWELL: dict[str, Any] = {"young_modulus": 211e9, "density": 7810.0}
LALANNE: dict[str, Any] = {"young_modulus": 200e9, "density": 7800.0}


def line_of(material: dict[str, Any], **tables: Any) -> LineModel:
    """Return the equations of a line."""
    return line_model(case_from({"material": material, "shaft_line": tables}))


def steel_disk(position: float, diameter: float) -> dict[str, float]:
    """Return a disk of 70 mm thickness on a shaft of 50 mm, of the material of the rotors of
    Friswell and others."""
    outer, inner, thickness = diameter, 0.05, 0.07
    mass = FRISWELL["density"] * np.pi / 4.0 * (outer**2 - inner**2) * thickness
    polar = mass * (outer**2 + inner**2) / 8.0
    diametral = polar / 2.0 + mass * thickness**2 / 12.0
    return {
        "position": position,
        "mass": mass,
        "polar_inertia": polar,
        "diametral_inertia": diametral,
    }


FRISWELL_ROTORS: dict[str, Any] = {
    "5.9.9": {
        "disks": [steel_disk(1.5, 0.35)],
        "bearings": [{"position": z, "stiffness": 1e7} for z in (0.0, 1.0)],
    },
    "5.9.1": {
        "disks": [steel_disk(0.5, 0.28), steel_disk(1.0, 0.35)],
        "bearings": [{"position": z, "stiffness": 1e6} for z in (0.0, 1.5)],
    },
}


@verifies("5.9.9", "5.9.1")
def friswell(example: str) -> Pairs:
    """Compare frequencies at rest and at 4,000 rpm [rad/s]."""
    shaft = {
        "length": 1.5,
        "outer_diameter": 0.05,
        "elements": 6,
        "poisson_ratio": 211.0 / (2.0 * 81.2) - 1.0,
    }
    line = line_of(FRISWELL, segments=[shaft], **FRISWELL_ROTORS[example])
    known = reference("shaft")["friswell"][example]
    return {
        name: (known[name], line_modes(line, omega).eigenvalue.imag[: len(known[name])])
        for name, omega in (("friswell_at_rest", 0.0), ("friswell_turning", 4000.0 * RPM))
    }


def three_disks(stiffness: tuple[float, float], damping: tuple[float, float]) -> LineModel:
    """Return the rotor of Lalanne and Ferraris with bearings of these values along x and y."""
    inertias = (14.58013, 0.1232021, 0.06463858), (45.94579, 0.9763481, 0.4977461)
    keys = ("position", "mass", "polar_inertia", "diametral_inertia")
    rows = zip((0.2, 0.5, 1.0), (*inertias, (55.13495, 1.171618, 0.6023493)), strict=True)
    return line_of(
        LALANNE,
        segments=[{"length": 1.3, "outer_diameter": 0.1, "elements": 13}],
        disks=[dict(zip(keys, (z, *values), strict=True)) for z, values in rows],
        bearings=[
            {
                "position": z,
                "stiffness": np.diag(stiffness).tolist(),
                "damping": np.diag(damping).tolist(),
            }
            for z in (0.0, 1.3)
        ],
        unbalance=[{"position": 0.5, "unbalance": 0.05}],
    )


PSEUDO_MODES = 12  #: number of modes at rest on which the source computes frequencies at speed


@verifies()
def lalanne() -> Pairs:
    """Compare frequencies [Hz] at rest and at 30,000 rpm, and damping ratios at rest; at speed also
    on as few modes at rest as the source takes."""
    known = reference("shaft")["lalanne"]
    line = three_disks((7e7, 5e7), (700.0, 500.0))
    still, turning = (line_modes(line, omega, 4).eigenvalue for omega in (0.0, 30000.0 * RPM))
    mass, _, stiffness = line.matrices(0.0)
    few = la.eigh(stiffness, mass)[1][:, :PSEUDO_MODES]
    mass, damping, stiffness = (few.T @ each @ few for each in line.matrices(30000.0 * RPM))
    rates = la.eigvals(np.block([[0.0 * mass, np.eye(len(mass))], [-stiffness, -damping]]))
    on_few = np.sort(np.abs(rates))[: 2 * len(turning) : 2]
    return {
        "lalanne_pseudo_modal": (known["turning"], on_few / (2.0 * np.pi)),
        "lalanne_at_rest": (known["at_rest"], np.abs(still) / (2.0 * np.pi)),
        "lalanne_damping": (known["damping"], -still.real / np.abs(still)),
        "lalanne_turning": (known["turning"], np.abs(turning) / (2.0 * np.pi)),
    }


@verifies()
def lalanne_unbalance() -> Pair:
    """Compare the amplitudes along x and y at the middle disk [m] at 15,000 rpm."""
    line = three_disks((5e7, 7e7), (5e3, 7e3))
    left, right = unbalance_response(line, 15000.0 * RPM)
    place = 2 * line.node(0.5)
    along, across = left[place] + right[place].conj(), left[place] - right[place].conj()
    return reference("shaft")["lalanne"]["unbalance"], [abs(along), abs(across)]


@verifies()
def spinning_shaft() -> Pair:
    """Compare the split of the first mode of a pinned shaft at 10,000 rad/s, divided by the
    frequency at rest."""
    line = line_of(
        LALANNE,
        segments=[{"length": 0.9, "outer_diameter": 0.05, "elements": 20}],
        bearings=[{"position": z, "stiffness": 1e11} for z in (0.0, 0.9)],
    )
    still, turning = (line_modes(line, omega, 2).eigenvalue.imag for omega in (0.0, 1e4))
    at_rest, *split = reference("shaft")["spinning"]
    return np.array(split) / at_rest, turning / still


RUN_UP_STEP, RUN_UP_END = 2.5e-6, 7.95
"""Time step and duration of the run-up [s]."""


@verifies()
def run_up() -> Pairs:
    """Compare the largest square of the displacement of a disk in a run-up through its critical
    speeds [m2], and its instant [s]."""
    known, place, length = reference("shaft")["run_up"], 0.133, 0.4
    case = case_from(
        {
            "material": LALANNE,
            "shaft_line": {
                "segments": [{"length": length, "outer_diameter": 0.02, "elements": 6}],
                "disks": [
                    {
                        "position": place,
                        "mass": 16.47,
                        "polar_inertia": 0.1861,
                        "diametral_inertia": 0.09427,
                    }
                ],
                "bearings": [
                    {"position": 0.0, "stiffness": 1e10},
                    {"position": length, "stiffness": 1e10},
                    {
                        "position": 2.0 * place,
                        "stiffness": [[2e5, 0.0], [0.0, 5e5]],
                        "damping": [[40.0, 0.0], [0.0, 100.0]],
                    },
                ],
                "unbalance": [{"position": place, "unbalance": 1.5e-5}],
                "modes": 8,
            },
            "march": {
                "speed_table": [[0.0, "0 rpm"], [12.0, "5000 rpm"]],
                "speed_blend": 0.0,
                "time_step": RUN_UP_STEP,
            },
        }
    )
    stage = build_stage(case)
    assert isinstance(stage, LineStage)
    scheme = CentralDifference(contact_problem(stage), RUN_UP_STEP, 40)
    chunk = scheme.advance(scheme.init(), round(RUN_UP_END / RUN_UP_STEP) + 1)[1]
    x, y = chunk.shaft_displacement[:, stage.line.node(place), :2].T
    square = x**2 + y**2
    most = int(square.argmax())
    return {
        "run_up_square": (known["square"], square[most]),
        "run_up_instant": (known["instant"], chunk.time[most]),
    }


@verifies()
def stepped_rotor() -> Pair:
    """Compare eigenvalues of a stepped hollow rotor on three unequal bearings with cross terms and
    a support, at four speeds, with those of the same elements in another program; the entries are
    decay rates and frequencies [rad/s], each divided by the absolute value of the eigenvalue."""
    known = reference("shaft")["stepped"]
    line = line_of({"young_modulus": 210e9, "density": 7800.0}, **known["shaft_line"])
    expected, computed = [], []
    for speed, values in known["eigenvalues"].items():
        theirs = np.array(values)
        ours = line_modes(line, float(speed), len(theirs)).eigenvalue
        size = np.hypot(*theirs.T)[:, None]
        expected.append(theirs / size)
        computed.append(np.stack([ours.real, ours.imag], axis=1) / size)
    return np.array(expected), np.array(computed)


SECTORS = 8


@cache
def ring(young_modulus: float, thickness: float) -> Superelement:
    """Return a sector of a ring of solids of 60 to 400 mm in diameter."""
    import meshio
    import skfem
    from skfem.io.meshio import to_meshio

    from bladewhirl.models.solids.blade import mesh3d

    axes = np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 3), np.linspace(0.0, 1.0, 2)
    mesh: meshio.Mesh = to_meshio(skfem.MeshHex2.from_mesh(skfem.MeshHex.init_tensor(*axes)))
    along, around, across = mesh.points.T
    radius, angle = 0.03 + 0.17 * along, 2.0 * np.pi / SECTORS * around
    mesh.points = np.column_stack(
        [radius * np.cos(angle), radius * np.sin(angle), thickness * across]
    )
    groups = {
        "bore": along < 1e-9,
        "rim": (along > 1.0 - 1e-9) & (abs(around - 0.5) < 1e-9),
        "left": around < 1e-9,
        "right": around > 1.0 - 1e-9,
    }
    mesh.point_sets = {name: np.flatnonzero(inside) for name, inside in groups.items()}
    tie: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    return mesh3d(
        mesh,
        young_modulus=young_modulus,
        poisson_ratio=0.3,
        density=7800.0,
        hub="bore",
        contact="rim",
        stiffening="stress",
        stress=False,
        **tie,
    )


@verifies()
def patch_tests() -> Pairs:
    """Compare the matrices of a wheel with those of a rigid body, and sum up the forces on it while
    it turns about an axis that is tilted and displaced in static axes."""
    part = ring(2.1e11, 0.04)
    motions = rigid_motions(part)
    forms = {
        name: of_all_sectors(motions.T @ (matrix @ motions), SECTORS)
        for name, matrix in part.given(("mass", *NEEDED)).items()
    }
    mass = forms["mass"]
    total, polar, tilting = mass[0, 0], mass[5, 5], mass[3, 3]
    plane = np.array([[0.0, -1.0], [1.0, 0.0]])
    coriolis = np.zeros((6, 6))
    coriolis[:2, :2], coriolis[3:5, 3:5] = 2.0 * total * plane, (2.0 * tilting - polar) * plane
    still = np.diag([-total, -total, 0.0, polar - tilting, polar - tilting, 0.0])
    expected = np.array([coriolis, still]) / total
    field = motions @ WAVES[1].conj()
    turning = part.known("stiffness_speed") @ field
    forces = turning - 1j * part.known("gyroscopic") @ field - part.mass @ field
    tie = transformation(hub_freed(part), SECTORS, SECTORS - 1)
    inner = inner_dofs(part)
    balance = [tie.conj().T @ one[inner] for one in (forces, turning)]
    hub = WAVES[1].T @ forces[hub_of(part)] / total
    error = np.array([abs(balance[0]).max() / abs(balance[1]).max(), abs(hub).max()])
    return {
        "rigid_wheel": (expected, np.array([forms[name] for name in NEEDED]) / total),
        "free_wheel": (np.zeros(2), error),
    }


@verifies()
def solid_wheel() -> Pair:
    """Compare six frequencies at 0, 4,000 and 20,000 rpm [rad/s]."""
    part = ring(2.1e17, 0.004)
    waves = hub_waves(part, 0.0)
    disk = {
        "position": 0.6,
        "mass": waves[1].mass[0, 0].real,
        "polar_inertia": waves[0].mass[1, 1].real,
        "diametral_inertia": waves[1].mass[1, 1].real,
    }
    tables: dict[str, Any] = {
        "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 6}],
        "bearings": [{"position": z, "stiffness": 2e7} for z in (0.0, 0.4)],
    }
    material = {"young_modulus": 2.1e11, "density": 7800.0}
    with TemporaryDirectory() as folder:
        file = f"{folder}/wheel.npz"
        write_superelement(file, part)
        case = {"bladed_disk": {"superelement": {"file": file}}, "material": material}
        line = tables | {"wheel": {"position": 0.6}}
        solid = line_model(case_from(case | {"shaft_line": line}), 20000.0 * RPM)
    rigid = line_of(material, **tables, disks=[disk])
    speeds = np.array([0.0, 4000.0, 20000.0]) * RPM
    known, ours = (
        np.array([line_modes(one, omega, 6).eigenvalue.imag for omega in speeds])
        for one in (rigid, solid)
    )
    return known, ours


STIFF = 2.1e15  #: Young's modulus of a wheel and a shaft that are almost rigid [Pa]
HELD, LOST = 1e6, 200.0  #: stiffness and damping of both bearings [N/m, N s/m]
CLEARANCE, ECCENTRICITY, FRICTION = 1e-3, 3e-4, 0.2  #: [m], of the mass [m], coefficient
LENGTH, RUBS = 0.6, (600.0, 700.0)  #: length of the shaft [m], speeds [rad/s]


def jeffcott(file: str, omega: float, unbalance: float, phase: float) -> Case:
    """Return the case of a wheel in the middle of a shaft without mass, in a rigid wall."""
    ends = [{"position": z, "stiffness": HELD / 2, "damping": LOST / 2} for z in (0.0, LENGTH)]
    middle = {"position": LENGTH / 2}
    return case_from(
        {
            "bladed_disk": {"superelement": {"file": file}},
            "material": {"young_modulus": STIFF, "density": 1e-3},
            "shaft_line": {
                "segments": [{"length": LENGTH, "outer_diameter": 0.04, "elements": 2}],
                "bearings": ends,
                "wheel": middle | {"unknowns": "two"},
                "unbalance": [middle | {"unbalance": unbalance, "phase": phase}],
            },
            "casing": {"type": "rigid", "clearance": CLEARANCE},
            "contact": {"friction": FRICTION},
            "reduction": {"free_interface_modes": 12},
            "march": {"speed": f"{omega} rad/s"},
        }
    )


@verifies()
def jeffcott_rub() -> Pairs:
    """Compare all constant rubs of the first tip of a Jeffcott rotor above its critical speed with
    the roots of its equations; at the second speed there are two.

    With the dynamic stiffness k and the damping d of the bearings, |k c + lambda (1 + i mu)| = m e
    Omega^2, and small deviations y of the tip along the wall satisfy m y'' + (d + 2 mu m Omega) y'
    + (Re k + mu d Omega) y = 0.
    """
    part, turn = ring(STIFF, 0.004), 1.0 + 1j * FRICTION
    motions = rigid_motions(part)
    mass = float(of_all_sectors(motions.T @ (part.mass @ motions), SECTORS)[0, 0])
    force, growth = list[list[float]](), list[list[float]]()
    with TemporaryDirectory() as folder:
        file = f"{folder}/wheel.npz"
        write_superelement(file, part)
        for omega in RUBS:
            still, drag = HELD - mass * omega**2, LOST + 2.0 * FRICTION * mass * omega
            moved, push = (still + 1j * omega * LOST) * CLEARANCE, mass * ECCENTRICITY * omega**2
            middle = 2.0 * (moved * turn.conjugate()).real
            roots = np.roots([abs(turn) ** 2, middle, abs(moved) ** 2 - push**2])
            along = np.roots([mass, drag, still + FRICTION * LOST * omega])
            for root in roots[roots > 0.0]:
                phase = float(np.angle(moved + root * turn)) + np.pi / SECTORS  # of a tip
                case = jeffcott(file, omega, mass * ECCENTRICITY, phase)
                found = contact_states(contact_problem(build_stage(case), steps=False))
                (one,) = (each for each in found if each.normal[0] and not each.normal[3:].any())
                force.append([root, one.normal.sum()])
                growth.append([along.real.max(), one.rates[0].real])
    known, ours = (np.transpose(each) for each in (force, growth))
    return {"rub_force": (known[0], known[1]), "rub_growth": (ours[0], ours[1])}
