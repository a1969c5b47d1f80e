"""A stage that runs up through its first critical speed, against an integration of the matrices of
the full bladed disk, without reduction and without central differences."""

import numpy as np
import scipy.linalg as la
from places import EXAMPLES

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.build import case_bladed_disk
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Chunk

END, DAMPER, UNBALANCE = 0.05, 2e3, 50e-3
CHANGES = {
    "bladed_disk.blades": 5,
    "bladed_disk.elements_per_blade": 2,
    "reduction.fixed_interface_modes": 35,
    "rotation.effects": "full",
    "damping.ratio": 0.01,
    "shaft.damping": DAMPER,
    "shaft.damping_frame": "static",
    "casing.clearance": "50 mm",
    "excitation": {"type": "imbalance", "unbalance": UNBALANCE, "ramp": 0.0},
    "march.record_step": "100 us",
    "march.duration": END,
    "march.speed_table": [["0 s", "6500 rpm"], [f"{END} s", "10000 rpm"]],
}


def test_the_orbit_is_that_of_all_degrees_of_freedom() -> None:
    case = bw.with_values(bw.read_case(EXAMPLES / "imbalance.toml"), CHANGES)
    stage = build_beams(case)
    speeds = bw.critical_speeds(case)["critical_speed"].sel(direction="forward", branch=1)
    critical = float(speeds.sel(stiffness=case.shaft.stiffness, method="nearest"))
    assert 7000.0 < critical < 9500.0
    problem = contact_problem(stage)

    def marched(dt: float) -> Chunk:
        scheme = CentralDifference(problem, dt, round(1e-4 / dt))
        return scheme.advance(scheme.init(), round(END / dt) + 1)[1]

    coarse, fine = marched(1e-6), marched(5e-7)
    assert not fine.contact_impulse.any()
    displacement = (4.0 * fine.rotor_displacement - coarse.rotor_displacement) / 3.0
    exact = full_orbit(case, stage.speed, stage.reference_frequency)
    moved = displacement @ problem.rotor.centre.T
    assert np.abs(exact).max() > 1e-3
    np.testing.assert_allclose(moved, exact, atol=1e-6 * np.abs(exact).max())


def full_orbit(case: bw.Case, base: float, reference: float) -> FloatArray:
    """Return the centre every 0.1 ms, by the exponentials of a Magnus series of fourth order, in
    displacements from the static state at the speed `base` [rad/s]."""
    disk = case_bladed_disk(case, clamped=False)
    given, centre = rotation_matrices(disk), disk.centre
    mass, stiffness, coriolis, stiffening, moving = (
        np.asarray(each.toarray())
        for each in (
            given.mass,
            given.stiffness,
            given.coriolis,
            given.known("stiffness_speed"),
            given.translated,
        )
    )
    grown = np.linalg.solve(stiffness - base**2 * moving, base**2 * given.loads[:, 0])
    square, modes = la.eigh(stiffness, mass)
    weighted = mass @ modes
    damping = (weighted * (2.0 * case.damping.ratio * np.sqrt(square))) @ weighted.T
    static, size = np.zeros_like(mass), len(mass)
    static[centre[0], centre[1]], static[centre[1], centre[0]] = -DAMPER, DAMPER
    damping[centre, centre] += DAMPER
    square, shapes = la.eigh(stiffness + base**2 * stiffening, mass)
    damping, coriolis, softened, static = (
        shapes.T @ each @ shapes for each in (damping, coriolis, stiffening, static)
    )
    pulled = shapes.T @ (given.loads[:, 0] + moving @ grown)
    swept = shapes.T @ (given.coriolis @ grown - given.loads[:, 1])
    rows = shapes[centre]
    course = case.march.course(reference)
    assert course is not None

    def system(time: float) -> FloatArray:
        speed, rate = float(course.speed(time)), float(course.acceleration(time))
        further = speed**2 - base**2
        matrix = np.zeros((2 * size + 1, 2 * size + 1))
        matrix[:size, size:-1] = np.eye(size)
        matrix[size:-1, :size] = -np.diag(square) - further * softened - rate * coriolis
        matrix[size:-1, :size] -= speed * static
        matrix[size:-1, size:-1] = -damping - 2.0 * speed * coriolis
        matrix[size:-1, -1] = further * pulled - rate * swept
        matrix[size:-1, -1] += UNBALANCE * (speed**2 * rows[0] - rate * rows[1])
        return matrix

    further = float(course.speed(0.0)) ** 2 - base**2
    state = np.zeros(2 * size + 1)
    state[:size] = np.linalg.solve(np.diag(square) + further * softened, further * pulled)
    state[-1], orbit, h, apart = 1.0, [rows @ state[:size]], 5e-5, np.sqrt(3.0) / 6.0
    for step in range(round(END / h)):
        one, other = (system((step + 0.5 + side * apart) * h) for side in (-1.0, 1.0))
        turning = np.sqrt(3.0) / 12.0 * h**2 * (other @ one - one @ other)
        state = la.expm(0.5 * h * (one + other) + turning) @ state
        if step % 2 == 1:
            orbit.append(rows @ state[:size])
    return np.array(orbit)
