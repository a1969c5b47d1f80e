"""Verification of superelements: contact of massless nodes compared with closed-form solutions, two
models of the contact nodes of a blade of solid elements compared with each other, a wheel from one
of its sectors with the whole wheel, and stages of beams with the same stages as superelements."""

from functools import cache
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np

from bladewhirl.models.case.case import case_from
from bladewhirl.models.stage.build import contact_problem, steady_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.models.superelements.reduction import consistent, massless
from bladewhirl.models.superelements.superelement import Superelement
from bladewhirl.models.superelements.wheel import WheelOverSpeeds
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.studies.verification.bodies import marched, problem
from bladewhirl.studies.verification.case import Pair, Pairs, verifies

GAP, FLEXIBILITY, OMEGA = 1e-3, 1e-6, 100.0
STEP = 1e-6  #: time step of the blade [s]
TURNS, SPEED = 3, 628.0
COATING = {
    "thickness": 2e-3,
    "young_modulus": 1e9,
    "yield_stress": 1e7,
    "hardening": 5e7,
    "footprint": 0.01,
    "elements": 1440,
}
"""Abradable coating with arbitrary values."""


@verifies()
def rebound() -> Pairs:
    """March a mass of 1 kg on a spring that meets a wall through another spring at 1 m/s.

    The impulse is compared with the closed-form solution, and the force at every step with the
    penetration divided by the flexibility.
    """
    rotor = ReducedRotor.of_copies(
        frequency=np.array([[OMEGA]]),
        damping_ratio=np.zeros((1, 1)),
        contact=np.array([[1.0], [0.0], [0.0]]),
        compliance=FLEXIBILITY * np.eye(3)[None],
        angle=np.zeros((1, 1)),
        radius=np.array([0.5]),
        recess=np.zeros(1),
        tip_radius=0.5,
    )
    wall = ReducedCasing.rigid(np.column_stack([np.full(8, GAP), np.zeros(8)]), 0.5)
    given = problem(rotor, wall, start={"rotor_velocity": np.ones(1)})
    chunk = marched(given, 5e-6, 1200)
    rate = np.sqrt(OMEGA**2 + 1.0 / FLEXIBILITY)
    start = np.arcsin(GAP * OMEGA) / OMEGA
    centre, speed = GAP / FLEXIBILITY / rate**2, np.cos(OMEGA * start)
    swing, phase = np.hypot(speed / rate, GAP - centre), np.arctan2(speed / rate, GAP - centre)
    expected = 2.0 * swing * np.sin(phase) / rate - (GAP - centre) * 2.0 * phase / rate
    depth = np.maximum(0.0, chunk.rotor_displacement[:, 0] - GAP)
    return {
        "impulse_of_a_rebound": (expected / FLEXIBILITY, chunk.contact_impulse.sum()),
        "force_of_a_massless_node": (depth / FLEXIBILITY, -chunk.contact_force[:, 0, 0]),
    }


@cache
def twisted_blade() -> Superelement:
    """Return a twisted blade of hexahedra with nine contact nodes along its tip."""
    import meshio
    import skfem
    from skfem.io.meshio import to_meshio

    from bladewhirl.models.solids.blade import mesh3d

    axes = np.linspace(0, 1, 4), np.linspace(-0.5, 0.5, 5), np.linspace(-0.5, 0.5, 2)
    mesh: meshio.Mesh = to_meshio(skfem.MeshHex2.from_mesh(skfem.MeshHex.init_tensor(*axes)))
    span, chord, depth = mesh.points.T
    angle, thickness = 0.5 + 0.3 * span, 7e-3 * (1 - 0.4 * span)
    y = 0.05 * chord * np.sin(angle) + thickness * depth * np.cos(angle)
    z = 0.05 * chord * np.cos(angle) - thickness * depth * np.sin(angle)
    radius = 0.235 + 0.065 * span
    mesh.points = np.column_stack([np.sqrt(radius**2 - y**2), y, z])
    mesh.point_sets = {"root": np.flatnonzero(span < 1e-9), "tip": np.flatnonzero(span > 1 - 1e-9)}
    return mesh3d(mesh, young_modulus=2.1e11, poisson_ratio=0.3, density=7800.0, contacts=9)


def rub(*, by_massless: bool, dt: float) -> Chunk:
    """March the blade in an oval wall with friction against the slip velocity."""
    part = twisted_blade()
    reduced = massless(part, 30) if by_massless else consistent(part, 60, 30)
    ratio = np.where(np.arange(len(reduced.frequency)) < 30, 0.005, 0.05)
    grid = 2.0 * np.pi / 1024 * np.arange(1024)
    wave = 2.0 * (grid - part.contact_angle.mean()) + np.pi
    radius = float(part.contact_radius.max())
    slope = -2.4e-4 * np.sin(wave + np.pi) / radius
    wall = np.column_stack([1e-4 + 1.2e-4 * np.cos(wave + np.pi), slope])
    rotor = ReducedRotor.of_copies(
        frequency=reduced.frequency[None],
        damping_ratio=ratio[None],
        contact=reduced.contact,
        compliance=reduced.compliance[None] if by_massless else None,
        angle=part.contact_angle[None],
        radius=part.contact_radius,
        recess=np.zeros(part.contacts),
        tip_radius=radius,
    )
    casing = ReducedCasing.rigid(wall, radius)
    law: dict[str, Any] = {"speed": SPEED, "friction": 0.15, "sliding": "full"}
    given = problem(rotor, casing, **law, displacement_limit=0.05)
    return marched(given, dt, round(TURNS * 2.0 * np.pi / SPEED / dt), every=1000)


@verifies()
def rubs() -> Pairs:
    """Compare the impulse on nine massless nodes with that on nodes that have mass and damping, and
    with that at half the time step. The error of the energy balance is zero."""
    chunk, half = rub(by_massless=True, dt=STEP), rub(by_massless=True, dt=STEP / 2.0)
    reference = rub(by_massless=False, dt=STEP / 10.0)
    impulse = chunk.contact_impulse.sum()
    gained = chunk.normal_work + chunk.friction_work - chunk.damping_work
    error = np.abs(chunk.energy - chunk.energy[0] - gained).max()
    return {
        "contact_nodes_with_and_without_mass": (reference.contact_impulse.sum(), impulse),
        "half_the_time_step": (half.contact_impulse.sum(), impulse),
        "ledger_of_a_rub": (0.0, error / np.abs(chunk.friction_work).max()),
    }


@verifies()
def wheel_of_sectors() -> Pair:
    """Compare the static flexibilities of the contact nodes, computed from the modes and the
    residual flexibility of a sector, with those of the whole wheel.

    Each sector has a root and a tip. Springs join roots to the ground, to tips and to the roots of
    the next sectors.
    """
    sectors, ground, blade, rim = 7, np.diag([3e8, 2e8, 1e8]), np.diag([4e8, 2e7, 1e7]), 5e7
    pitch = 2.0 * np.pi / sectors
    turn = np.eye(3)
    turn[:2, :2] = [[np.cos(pitch), -np.sin(pitch)], [np.sin(pitch), np.cos(pitch)]]
    sector = np.block([[ground + blade, -blade], [-blade, blade]])
    whole = np.kron(np.eye(sectors), sector)
    for n in range(sectors):
        stretch = np.zeros((3, 6 * sectors))
        stretch[:, 6 * n : 6 * n + 3] = -np.eye(3)
        follower = 6 * ((n + 1) % sectors)
        stretch[:, follower : follower + 3] += turn  # in axes of the next sector
        whole += rim * stretch.T @ stretch
    stretch = np.hstack([-np.eye(3), np.zeros((3, 3)), np.eye(3)])
    stiffness = np.zeros((9, 9))
    stiffness[:6, :6] = sector
    values: dict[str, Any] = {
        "mass": np.diag([0.02] * 3 + [0.01] * 3 + [0.0] * 3),
        "stiffness": stiffness + rim * stretch.T @ stretch,
        "contact_position": np.array([[0.4, 0.0, 0.0]]),
        "contact_dofs": np.array([[3, 4, 5]]),
        "left_dofs": np.array([[0, 1, 2]]),
        "right_dofs": np.array([[6, 7, 8]]),
    }
    _, reduced = WheelOverSpeeds(Superelement(**values), sectors, 4).at(0.0)
    kept = (reduced.contact / reduced.frequency**2) @ reduced.contact.T
    tips = np.concatenate([6 * n + 3 + np.arange(3) for n in range(sectors)])
    return np.linalg.inv(whole)[np.ix_(tips, tips)].ravel(), (kept + reduced.compliance).ravel()


def exported(
    kind: str, *, coated: bool = False
) -> tuple[ContactProblem, ContactProblem, Chunk, Chunk]:
    """Return the contact problem of a stage of beams that a closing oval casing pinches, that of
    the same stage as superelements with mass at the contact nodes, and records of both over
    0.05 s."""
    blades, kept = 6, 12
    common: dict[str, Any] = {
        "casing": {
            "elements": 24,
            "support": 7.975e6,
            "clearance": 5e-4,
            "clearance_lobes": [{"lobes": 2, "amplitude": 2e-4}],
            "closure": {"amount": 4e-4, "time_constant": 0.02},
        },
        "excitation": {"type": "none"},
        "contact": {"friction": 0.05},
        "march": {"speed": "1200 rpm", "time_step": 2e-6},
    }
    if coated:
        common["casing"] |= {"support": 1e9, "coating": COATING}
        common["casing"]["closure"] = {"amount": 6e-4, "time_constant": 0.02}
    beams: dict[str, Any] = {"blades": blades, "elements_per_blade": 4}
    if kind == "blade":
        beams["disk_kind"] = "rigid"
    shaft = {"clamped": kind != "wheel"}
    reduction: dict[str, Any] = {"fixed_interface_modes": kept}
    given = common | {"bladed_disk": beams, "shaft": shaft, "reduction": reduction}
    stage = build_beams(case_from(given))
    of_beams = contact_problem(stage)
    if kind == "blade":
        reduction = {"fixed_interface_modes": kept // blades}
    with TemporaryDirectory() as folder:
        file = f"{folder}/part.npz"
        write_superelement(file, stage.to_superelement(cast(Any, kind)))
        copies = 1 if kind == "wheel" else blades
        table = {"file": file, "kind": kind, "copies": copies}
        given = common | {
            "bladed_disk": {"superelement": table},
            "damping": {"boundary_ratio": stage.case.damping.ratio},
            "reduction": reduction | {"boundary": "consistent"},
        }
        same = steady_problem(build_matrices(case_from(given)).at(of_beams.speed))
    dt = stage.case.march.time_step
    chunk, nodes = (marched(one, dt, round(0.05 / dt), every=250) for one in (of_beams, same))
    return of_beams, same, chunk, nodes


@verifies("wheel", "sector", "blade")
def exported_stage(kind: str) -> Pairs:
    """Compare all frequencies of a stage of beams, and the radial displacements of its tips, with
    those of its superelements."""
    of_beams, same, beams, nodes = exported(kind)
    tips = beams.rotor_displacement @ of_beams.rotor.tip_radial.T
    return {
        "frequencies_of_an_exported_stage": (
            np.sort(of_beams.rotor.frequency),
            np.sort(same.rotor.frequency),
        ),
        "march_of_an_exported_stage": (tips, nodes.contact_displacement[:, :, 0]),
    }


@verifies()
def wear_of_an_exported_stage() -> Pair:
    """Compare the volume removed from a coating by the tips of beams with that of a superelement,
    whose contact forces follow from the displacement at the end of each step."""
    _, _, beams, nodes = exported("wheel", coated=True)
    assert beams.coating is not None  # both walls have a coating
    assert nodes.coating is not None
    return beams.coating.wear_volume[-1], nodes.coating.wear_volume[-1]
