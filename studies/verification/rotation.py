"""Bladed disks with rotation effects, compared with closed-form solutions and with a reference:
independent finite elements (data/rotation.json)."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.modal.whirl_modes import whirl_modes
from bladewhirl.models.rotation.at_speed import speed_of_growth
from bladewhirl.models.rotation.matrices import axial_force, rotation_matrices
from bladewhirl.models.sections.rectangular import Section
from bladewhirl.models.structure.eigenproblems import damped_eigenvalues
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies
from bladewhirl.studies.verification.stages import bladed_disk, steel

STAGES = ("0.01", "0.03")
"""Stages of the reference results, named by the thickness of the disk's beams [m]."""

KEYS: dict[Effects, str] = {"none": "at_rest", "centrifugal": "no_coriolis", "full": "full"}


def known(stage: str) -> Any:
    """Return the reference values of a stage."""
    return reference("rotation")["stages"][stage]


@cache
def turning(stage: str) -> Structure:
    """Return the bladed disk of a stage with the matrices of its rotation."""
    return rotation_matrices(bladed_disk(disk_thickness=float(stage)))


@verifies(*STAGES)
def centrifugal_frequencies(stage: str) -> Pair:
    """Compare six frequencies of each nodal diameter, negative if unstable, with the reference."""
    expected, computed = [], []
    for row in known(stage)["speeds"]:
        structure = turning(stage).at(row["omega"], "centrifugal")
        if structure.layout is None:
            raise ValueError("expected a stage of equal sectors")
        for k, (mass, stiffness) in structure.layout.blocks(structure.mass, structure.stiffness):
            square = la.eigvalsh(stiffness, mass, subset_by_index=(0, 5))
            computed.append(np.sign(square) * np.sqrt(np.abs(square)) / (2 * np.pi))
            expected.append(row["centrifugal"][str(k)])
    return expected, computed


@verifies(*STAGES)
def travelling_waves(stage: str) -> Pairs:
    """Compare six frequencies of each nodal diameter and direction [Hz] with the reference. The
    largest growth rates are zero."""
    slow, fast = (tuple[list[Any], list[Any]](([], [])) for _ in range(2))
    growth = []
    for row in known(stage)["speeds"]:
        modes = whirl_modes(turning(stage).at(row["omega"], "full"))
        expected, computed = slow if row["ratio"] < 2.0 else fast
        for way in ("backward", "forward"):
            ways = np.isin(modes.direction, [way, "standing"])
            for k in range(12):
                frequencies = modes.frequency[(modes.nodal_diameter == k) & ways]
                computed.append(frequencies[:6] / (2 * np.pi))
                expected.append(row[way][str(k)])
        growth.append(np.abs(modes.growth).max())
    return {
        "whirling_waves": slow,
        "whirling_waves_past_the_critical_speed": fast,
        "undamped_waves": (np.zeros(len(growth)), growth),
    }


@verifies(*STAGES)
def tension(stage: str) -> Pairs:
    """Compare tip growth under dead and follower loads, and axial forces, with the reference.

    The exact axial force at the root of a blade is rho A Omega^2 (R^2 - r^2) / 2.
    """
    disk, matrices = bladed_disk(disk_thickness=float(stage)), turning(stage)
    sets, root = disk.mesh.line_sets, disk.mesh.node_sets["roots"][0]
    (line,) = [n for n in sets["blades"] if disk.mesh.lines[n, 0] == root]
    growth, forces = (tuple[list[Any], list[Any]](([], [])) for _ in range(2))
    for row in known(stage)["speeds"]:
        omega = row["omega"]
        linear = matrices.static_displacement(omega, follows=False)
        followed = matrices.static_displacement(omega)[disk.tip_radial]
        growth[0].append([[row["tip_growth"]] * 22, [row["tip_growth_softened"]] * 22])
        growth[1].append([linear[disk.tip_radial], followed])
        stations = np.array([0.0, 0.5, 1.0])
        force = axial_force(disk.model, disk.expansion @ linear, stations, omega=omega)
        mean = force @ np.array([1.0, 4.0, 1.0]) / 6.0
        pull = 7800.0 * 1e-3 * omega**2 * (0.5**2 - 0.05**2) / 2.0
        forces[0].append([*[row["spoke_force"]] * 22, *[row["rim_force"]] * 22, pull])
        forces[1].append([*mean[sets["spokes"]], *mean[sets["rim"]], force[line, 0]])
    return {"growth_of_tips": growth, "axial_forces": forces}


@verifies(*STAGES)
def critical_speeds(stage: str) -> Pair:
    """Compare with the reference the critical speed, and the speeds of engine orders for modes at
    rest, with centrifugal effects and with Coriolis forces."""
    row, matrices = known(stage), turning(stage)
    expected = [row["critical_speed"]]
    computed = [matrices.wave(1).synchronous(0)[0][0]]
    for order in row["engine_orders"]:
        for effects, key in KEYS.items():
            computed.append(matrices.wave(order["k"]).under(effects).synchronous(order["k"])[0][0])
            expected.append(order[key])
    return expected, np.array(computed) / (2 * np.pi * row["reference_hz"])


@verifies(*STAGES)
def speed_of_one_millimetre(stage: str) -> Pair:
    """Compare the speed at which tips grow by 1 mm, under the follower load, with the reference."""
    row, disk = known(stage), bladed_disk(disk_thickness=float(stage))
    speed = speed_of_growth(replace(disk, structure=turning(stage)), 1e-3)
    return row["growth_of_1mm"], speed / (2 * np.pi * row["reference_hz"])


@verifies(*STAGES)
def internal_damping(stage: str) -> Pairs:
    """Compare growth rate and frequency of the fastest growing k = 1 wave with the reference. Modal
    damping of the modes at rest rotates with the disk."""
    row, matrices = known(stage), turning(stage)
    block = matrices.wave(1)
    mass, stiffness = block.mass, block.stiffness
    square, modes = la.eigh(stiffness, mass)
    damping = mass @ modes @ np.diag(0.01 * np.sqrt(square)) @ modes.conj().T @ mass
    known_rates, fastest = np.array(row["growth_rates_xi_0.005"]), []
    for ratio in known_rates[:, 0]:
        omega = 2 * np.pi * row["reference_hz"] * ratio
        at_speed = damping + omega * block.known("gyroscopic"), block.stiffness_at(omega)
        exponents, _ = damped_eigenvalues(mass, *at_speed)
        fastest.append(exponents[exponents.real.argmax()])
    hertz = np.abs(np.imag(fastest)) / (2 * np.pi)
    return {
        "growth_by_internal_damping": (known_rates[:, 1], np.real(fastest)),
        "frequency_by_internal_damping": (np.abs(known_rates[:, 2]), hertz),
    }


@verifies(*STAGES)
def steady_answer(stage: str) -> Pair:
    """Compare the response to a constant force in the rotating frame with the reference, at speeds
    below and above the critical speed."""
    row, disk = known(stage), bladed_disk(disk_thickness=float(stage))
    force, computed = np.zeros(disk.structure.size), []
    force[disk.centre[0]] = 1.0
    for ratio, _, _ in row["steady_per_newton"]:
        omega = 2 * np.pi * row["reference_hz"] * ratio
        answer = spla.spsolve(turning(stage).stiffness_at(omega).tocsc(), force)
        computed.append([answer[disk.centre[0]], np.abs(answer[disk.tip_radial]).max()])
    return [known_answer[1:] for known_answer in row["steady_per_newton"]], computed


HUB, SHAFT = 0.05, 2e6  #: radius of the hub [m], and stiffness of a shaft spring [N/m]


def blades_on(
    blades: int, tip: float, section: Section, elements: int = 1, *, hub: float = 0.0, clamped: bool
) -> BladedDiskModel:
    """Return radial blades from the radius `hub` of a rigid disk to the radius `tip` [m]."""
    sketch = Sketch(blades)
    sketch.node("centre", 0.0, 0.0, shared=True)
    if hub:
        sketch.node("root", hub)
        sketch.link("centre", "root")
    sketch.node("tip", tip)
    sketch.member("blades", "root" if hub else "centre", "tip", section, elements=elements)
    sketch.set("centre", "centre")
    sketch.set("tips", "tip")
    return assemble_bladed_disk(sketch.build(), shaft_stiffness=SHAFT, clamped=clamped)


def cantilevers(delta: float, alpha: float, elements: int) -> tuple[BladedDiskModel, float]:
    """Return three blades on a rigid disk, and a time that makes frequencies dimensionless [s]."""
    length = HUB / delta
    section = steel(np.sqrt(12.0) * length / alpha)
    disk = blades_on(3, HUB + length, section, elements, hub=HUB, clamped=True)
    time = np.sqrt(section.line_mass * length**4 / section.bending_stiffness)
    return disk, float(time)


@verifies()
def flapwise_cantilevers() -> Pair:
    """Compare out-of-plane frequencies w_f with solutions by power series; w_f follows from the
    in-plane frequency w_c without Coriolis forces: w_f^2 = w_c^2 + Omega^2."""
    rows, computed = reference("rotation")["cantilevers"]["flapwise"], []
    for row in rows:
        disk, time = cantilevers(row["delta"], 1e3, 12)
        structure = rotation_matrices(disk).at(row["gamma"] / time, "centrifugal")
        lowest = la.eigvalsh(structure.stiffness.toarray(), structure.mass.toarray())[:6]
        squares = np.unique(np.round(lowest * time**2, 6))[:2]
        computed.append(np.sqrt(squares + row["gamma"] ** 2))
    return [row["flapwise"][:2] for row in rows], computed


@verifies()
def coriolis_cantilevers() -> Pair:
    """Compare in-plane frequencies of rotating cantilevers, whose bending and stretching Coriolis
    forces couple, with solutions by power series."""
    rows, computed = reference("rotation")["cantilevers"]["chordwise"], []
    for row in rows:
        disk, time = cantilevers(row["delta"], row["alpha"], 20)
        modes = whirl_modes(rotation_matrices(disk).at(row["gamma"] / time, "full"))
        computed.append(modes.frequency[modes.nodal_diameter == 0][:2] * time)
    return [row["frequencies"][:2] for row in rows], computed


@verifies()
def rigid_disk() -> Pair:
    """Compare the frequencies of a rigid disk in the static frame with sqrt(k/m)."""
    stiff = Section(width=0.1, thickness=0.1, young_modulus=1e15, density=7800.0)
    disk = blades_on(3, 0.3, stiff, clamped=False)
    computed: list[FloatArray] = []
    for omega in (30.0, 200.0):
        modes = whirl_modes(rotation_matrices(disk).at(omega, "full"))
        swinging = (modes.nodal_diameter == 1) & (modes.frequency < 1e3)
        chosen = modes.take(np.flatnonzero(swinging))
        computed.append(np.abs(chosen.static_frequency(omega)))
    return np.full((2, 2), np.sqrt(SHAFT / disk.model.mass)), computed


@verifies()
def rod() -> Pair:
    """Compare the elongation of a radial rod at 1500 rad/s with closed-form solutions."""
    section, omega = steel(0.01), 1500.0
    disk = blades_on(2, 0.5, section, 40, clamped=True)
    matrices = rotation_matrices(disk)
    kappa = omega * 0.5 * np.sqrt(section.line_mass / section.axial_stiffness)
    computed = [
        matrices.static_displacement(omega, follows=follows)[disk.tip_radial[0]] / 0.5
        for follows in (False, True)
    ]
    return [kappa**2 / 3.0, np.tan(kappa) / kappa - 1.0], computed
