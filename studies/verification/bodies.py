"""Small bodies with known motions, their time integration, and the error of the energy balance."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load, at_rest
from bladewhirl.models.stage.reduced_rotor import ReducedRotor, contact_rows
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.solvers.march.sudden_changes import make_scheme

FAR = 1e3  #: displacement limit that is never reached [m]


def small_rotor(frequency: FloatArray, tips: int = 1, **rows: Any) -> ReducedRotor:
    """Return an undamped rotor with tips at angle 0; `rows` replaces values of fields, or
    `tip_radial` and `tip_tangential`, which are zero by default."""
    modes = len(frequency)
    still = np.zeros((tips, modes))
    moved = [rows.pop(name, still) for name in ("tip_radial", "tip_tangential")]
    body = ReducedRotor(
        frequency=frequency,
        damping_ratio=np.zeros(modes),
        contact=contact_rows(moved[0], moved[1], still),
        centre=np.zeros((2, modes)),
        tip_angle=np.zeros(tips),
        tip_radius=1.0,
        tip_recess=np.zeros(tips),
        contact_radius=np.ones(tips),
        column=np.full(modes, -1),
        dampers=np.zeros((0, modes)),
    )
    return replace(body, **rows)


def point_mass(mass: float, frequency: float = 0.0, **rows: Any) -> ReducedRotor:
    """Return a rotor with one tip: a mass [kg] that moves radially on a spring to ground. Its
    frequency without contact is `frequency` [rad/s]."""
    return small_rotor(np.array([frequency]), tip_radial=np.array([[mass**-0.5]]), **rows)


def small_casing(
    frequency: FloatArray, clearance: float = 0.0, nodes: int = 4, **rows: Any
) -> ReducedCasing:
    """Return an undamped casing with a radius of 1 m; `rows` replaces values of fields."""
    modes = len(frequency)
    body = ReducedCasing(
        frequency=frequency,
        damping_ratio=np.zeros(modes),
        nodal=np.zeros((nodes, 4, modes)),
        clearance=np.tile([clearance, 0.0], (nodes, 1)),
        radius=1.0,
        column=np.full(modes, -1),
        dampers=np.zeros((0, modes)),
    )
    return replace(body, **rows)


def wall(clearance: float, nodes: int = 4) -> ReducedCasing:
    """Return a rigid casing with one mode of zero shape."""
    return small_casing(np.ones(1), clearance, nodes)


def problem(
    rotor: ReducedRotor,
    casing: ReducedCasing,
    *,
    start: Mapping[str, FloatArray] | None = None,
    loads: tuple[Load, ...] = (),
    speed: float = 0.0,
    friction: float = 0.0,
    sliding: Literal["permanent", "signed", "full"] = "permanent",
    tip_rotation: bool = False,
    displacement_limit: float = FAR,
) -> ContactProblem:
    """Return a contact problem; by default without friction, at zero speed and starting from
    rest."""
    return ContactProblem(
        rotor=rotor,
        casing=casing,
        speed=speed,
        friction=friction,
        sliding=sliding,
        tip_rotation=tip_rotation,
        displacement_limit=displacement_limit,
        loads=loads,
        start=replace(at_rest(rotor, casing), **(start or {})),
    )


def ledger_residual(chunk: Chunk) -> float:
    """Return the largest error of the energy balance, relative to the largest term."""
    work = chunk.external_work + chunk.normal_work + chunk.friction_work + chunk.coupling_work
    mismatch = (chunk.energy - chunk.energy[0]) - (work - chunk.damping_work)
    works = ("external", "normal", "friction", "damping", "coupling")
    terms = [chunk.energy, *(getattr(chunk, f"{name}_work") for name in works)]
    return float(np.abs(mismatch).max() / np.abs(terms).max())


def default_stage(changes: Mapping[str, Any]) -> ContactProblem:
    """Return the contact problem of the default case with changes, by dotted key."""
    return contact_problem(build_beams(with_values(Case(), changes)))


class Bar:
    """Free radial bar of linear elements with consistent mass, described by all its modes."""

    def __init__(
        self, *, length: float, area: float, young_modulus: float, density: float, elements: int
    ) -> None:
        h = length / elements
        size = elements + 1
        diagonal = np.full(size, 2.0)
        diagonal[[0, -1]] = 1.0
        beside = np.ones(elements)
        stiffness = np.diag(diagonal) - np.diag(beside, 1) - np.diag(beside, -1)
        mass = np.diag(2.0 * diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
        square, shapes = la.eigh(
            young_modulus * area / h * stiffness, density * area * h / 6.0 * mass
        )
        square[0] = 0.0  # exact value of the rigid-body motion
        self.mass = density * area * length
        self.frequency = np.sqrt(square)
        self.shapes = shapes
        self.rigid = shapes.T @ (density * area * h / 6.0 * mass @ np.ones(size))
        self.time_step = 0.9 * 2.0 / self.frequency[-1]

    def as_rotor(self) -> ReducedRotor:
        """Return the bar as a rotor, whose tip is the outer end of the bar."""
        return small_rotor(self.frequency, tip_radial=self.shapes[-1:])

    def as_casing(self, gap: float) -> ReducedCasing:
        """Return the bar as a casing, whose nodes all move as the inner end of the bar."""
        nodal = np.zeros((4, 4, len(self.frequency)))
        nodal[:, 0] = self.shapes[0]
        return small_casing(self.frequency, gap, nodal=nodal)


def marched(given: ContactProblem, dt: float, steps: int, *, every: int = 1) -> Chunk:
    """March from step 0 to `steps`; return a record of every `every`-th step."""
    made = make_scheme(given, dt, every)
    return made.advance(made.init(), steps + 1)[1]
