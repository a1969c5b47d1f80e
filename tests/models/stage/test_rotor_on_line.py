"""A wheel on its shaft line, marched in the modes of the rotor, against the whole rotor integrated
with the unreduced matrices of `plain_rotor`."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from contact_cases import ledger_residual
from plain_rotor import NU, RHO, SPIN, E, Shaft, rotor
from scipy.integrate import solve_ivp
from solid_meshes import fan_sector, whole

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.rotor_on_line import RotorOnLine
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.models.superelements.hub import inner_dofs, rigid_motions
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Chunk

SECTORS, NODES, HUB = 5, 4, 3
STEEL: dict[str, Any] = {
    **{"young_modulus": E, "poisson_ratio": NU, "density": RHO, "stress": False},
    **{"hub": "root", "hub_at": "-5 mm"},
}
SHAFT = Shaft(length=0.6, diameter=0.04, elements=3, bearings=(), hub=HUB, axial=(0, 5e7))
UNBALANCE, GRAVITY = 2e-3, 9.81
SPRINGS = np.array([[[2e7, 3e6], [-1e6, 1e7]], [[1e7, 0.0], [0.0, 1.4e7]]])
DAMPERS = np.array([[[2e3, 0.0], [0.0, 5e2]], [[1e3, 100.0], [-50.0, 700.0]]])
PLACES = (0, 2)  #: nodes of the bearings
BEARINGS = [
    {"position": 0.2 * node, "stiffness": spring.tolist(), "damping": damper.tolist()}
    for node, spring, damper in zip(PLACES, SPRINGS, DAMPERS, strict=True)
]
SPEED = 900.0  #: fastest speed [rad/s]
HIGHEST = 2e5  #: highest frequency of the modes in which the whole rotor is integrated [rad/s]


@cache
def fan() -> Any:
    """A wheel of five blades, in one piece."""
    return mesh3d(whole(fan_sector(SECTORS), SECTORS), **STEEL)


@cache
def fan_sector_part() -> Any:
    """Its sector."""
    faces: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    return mesh3d(fan_sector(SECTORS), **STEEL, **faces)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the files of wheel and sector."""
    place = tmp_path_factory.mktemp("rotor")
    write_superelement(place / "wheel.npz", fan())
    write_superelement(place / "sector.npz", fan_sector_part())
    return place


def fan_case(folder: Path, march: dict[str, Any], kind: str = "wheel", **changed: Any) -> Case:
    """A case of the wheel on the line."""
    line = {
        "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 3}],
        "bearings": BEARINGS,
        "wheel": {"position": 0.6},
        "axial": {"position": 0.0, "stiffness": 5e7},
        "unbalance": [{"position": 0.6, "unbalance": UNBALANCE}],
    }
    copies = {"copies": SECTORS} if kind == "wheel" else {}
    return case_from(
        {
            "material": {"young_modulus": E, "density": RHO},
            "bladed_disk": {"superelement": {"file": str(folder / f"{kind}.npz"), **copies}},
            "shaft_line": line | changed.pop("shaft_line", {}),
            "casing": {"type": "rigid", "clearance": 0.05},
            "reduction": {"free_interface_modes": 120},
            "march": march,
        }
        | changed
    )


def stage_of(case: Case) -> RotorOnLine:
    """The stage of a wheel on its line."""
    stage = build_stage(case)
    assert isinstance(stage, RotorOnLine)
    return stage


def marched(stage: RotorOnLine, step: float, end: float, every: int = 10) -> Chunk:
    """The records of a march."""
    scheme = CentralDifference(contact_problem(stage), step, every)
    return scheme.advance(scheme.init(), round(end / step) + 1)[1]


def column(node: int, way: int) -> int:
    """Number of a displacement of a node of the shaft in `plain_rotor`, whose rotation about the
    axis at the first node is left out."""
    place = 6 * node + way
    return int(fan().size) - 6 + place - (place > 5)


class Whole:
    """The whole rotor on its lowest modes at `SPEED`, in rotating axes."""

    def __init__(self) -> None:
        mass, _, stiffness = self._at(SPEED)
        squares, shapes = la.eigh(stiffness, mass)
        self.shapes = shapes[:, squares < HIGHEST**2]
        self.still = self._on(self._at(0.0)[2])
        self.gyroscopic = self._on(self._at(1.0)[1])
        other = [(self._on(self._at(speed)[2]) - self.still) / speed**2 for speed in (1e3, 2e3)]
        self.fourth = (other[1] - other[0]) / 3e6  # of K_1 + Omega^2 K_2
        self.square = other[0] - 1e6 * self.fourth
        wheel, hub = fan(), column(HUB, 0) + np.arange(6)
        place = np.zeros(wheel.size, dtype=int)
        place[inner_dofs(wheel)], place[wheel.hub_dofs] = np.arange(wheel.size - 6), hub
        uniform = np.zeros((len(mass), 2))
        uniform[: wheel.size - 6] = rigid_motions(wheel)[inner_dofs(wheel), :2]
        for node in range(NODES):
            for way in range(2):
                uniform[column(node, way), way] = 1.0
        self.uniform = self.shapes.T @ (mass @ uniform)
        along, euler = np.zeros((2, len(mass)))
        along[place], euler[place] = wheel.centrifugal_load, wheel.euler_load
        turned = np.zeros(len(mass))
        for node in range(1, NODES):
            turned[column(node, 5)] = 1.0
        turned[: wheel.size - 6] = 0.0
        rods = np.zeros(len(mass))  # Euler forces of the rods between nodes, of which one is held
        inertia = RHO * np.pi * 0.04**4 / 32.0 * 0.2
        for node, share in ((1, 1.0), (2, 1.0), (3, 0.5)):
            rods[column(node, 5)] = inertia * share
        self.along, self.euler = self.shapes.T @ along, self.shapes.T @ (euler - rods)

    def _at(self, omega: float) -> list[FloatArray]:
        return [np.asarray(each.toarray()) for each in rotor(SHAFT, fan(), omega)]

    def _on(self, matrix: FloatArray) -> FloatArray:
        return np.asarray(self.shapes.T @ matrix @ self.shapes)

    def nodes(self, x: FloatArray) -> FloatArray:
        """Displacements x and y of the nodes of the shaft in rotating axes, (nodes, 2)."""
        rows = [[column(node, way) for way in range(2)] for node in range(NODES)]
        return np.asarray((self.shapes @ x)[rows])

    def motion(self, turned: Any, end: float) -> FloatArray:
        """Deflections of the nodes in static axes at an instant, from a line that is not bent, for
        angle, speed and acceleration of the rotation by time."""
        count = len(self.along)
        ends = [self.shapes[[column(node, 0), column(node, 1)]] for node in PLACES]

        def rate(time: float, state: FloatArray) -> FloatArray:
            angle, speed, acceleration = turned(time)
            turn = np.cos(angle) * np.eye(2) + np.sin(angle) * SPIN
            x, v = np.split(state, 2)
            square = speed**2
            stiffness = self.still + square * (self.square + square * self.fourth)
            force = square * self.along + acceleration * self.euler - stiffness @ x
            force = force - self.gyroscopic @ (speed * v + 0.5 * acceleration * x)
            force = force + self.uniform @ (turn.T @ [0.0, -GRAVITY])
            at_hub = self.shapes[[column(HUB, 0), column(HUB, 1)]]
            force = force + UNBALANCE * at_hub.T @ [square, -acceleration]
            for rows, spring, damper in zip(ends, SPRINGS, DAMPERS, strict=True):
                place, moved = rows @ x, rows @ v + speed * SPIN @ (rows @ x)
                pull = spring @ (turn @ place) + damper @ (turn @ moved)
                force = force - rows.T @ (turn.T @ pull)
            return np.concatenate([v, force])

        start, square = np.zeros(2 * count), turned(0.0)[1] ** 2
        stiffness = self.still + square * (self.square + square * self.fourth)
        start[:count] = np.linalg.solve(stiffness, square * self.along)
        found = solve_ivp(rate, (0.0, end), start, method="DOP853", rtol=1e-9, atol=1e-15)
        return np.asarray(self.nodes(found.y[:count, -1]) @ la.expm(turned(end)[0] * SPIN).T)


@pytest.mark.parametrize(
    ("kind", "march"),
    [
        ("sector", {"speed": "900 rad/s"}),
        ("wheel", {"speed_table": [[0.0, "800 rad/s"], [0.004, "900 rad/s"]]}),
    ],
    ids=["constant", "varying"],
)
def test_the_march_is_the_motion_of_the_unreduced_rotor(
    kind: str, march: dict[str, Any], folder: Path
) -> None:
    """Unequal bearings with cross terms, unbalance and gravity on an unbent line."""
    end = 0.002
    stage = stage_of(fan_case(folder, march, kind, gravity={"start": "unbent"}))
    course = stage.case.march.course(stage.reference_frequency)

    def turned(time: float) -> tuple[float, float, float]:
        if course is None:
            return stage.speed * time, stage.speed, 0.0
        each = course.angle(time), course.speed(time), course.acceleration(time)
        return float(each[0]), float(each[1]), float(each[2])

    exact = Whole().motion(turned, end)
    found = [marched(stage, step, end) for step in (1e-6, 5e-7)]
    moved = [chunk.shaft_displacement[-1, :, :2] for chunk in found]
    assert max(map(ledger_residual, found)) < 1e-9
    corrected = moved[1] + (moved[1] - moved[0]) / 3.0  # second order in the step
    scale = np.abs(exact).max()
    assert np.abs(moved[1] - exact).max() < 5e-5 * scale
    assert np.abs(corrected - exact).max() < 5e-5 * scale
