"""A wheel on its shaft line, marched in the modes of the rotor, against the whole rotor integrated
with the unreduced matrices of `plain_rotor`."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from contact_cases import ledger_residual
from plain_rotor import NU, RHO, SPIN, E, Shaft, rotor
from scipy.integrate import solve_ivp
from solid_meshes import fan_sector, whole

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.shaft_line.rotor import wheel_with_hub
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.damaged_rotor import in_sector_axes
from bladewhirl.models.stage.excitations import excitation_loads
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.rotor_on_line import RotorOnLine
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.models.superelements.hub import inner_dofs, remaining_dofs, rigid_motions
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.solvers.march.sudden_changes import make_scheme

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
HIGHEST = 5e5  #: highest frequency of the modes in which the whole rotor is integrated [rad/s]

MANY: dict[str, Any] = {"reduction": {"free_interface_modes": 160}}
"""Modes with frequencies up to 4e5 rad/s, which sudden forces excite in the whole rotor, too."""


@cache
def fan() -> Any:
    """A wheel of five blades, in one piece."""
    return mesh3d(whole(fan_sector(SECTORS), SECTORS), **STEEL)


@cache
def fan_sector_part() -> Any:
    """Its sector."""
    faces: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    return mesh3d(fan_sector(SECTORS), **STEEL, **faces)


@cache
def damaged() -> Any:
    """The wheel without its blade at the angle 0."""
    gone = "r > 79.9 mm and -30 < angle < 30"
    return mesh3d(whole(fan_sector(SECTORS), SECTORS), **STEEL, lost=gone)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the files of wheel and sector."""
    place = tmp_path_factory.mktemp("rotor")
    write_superelement(place / "wheel.npz", fan())
    write_superelement(place / "damaged.npz", damaged())
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
    copies = {"copies": SECTORS} if kind != "sector" else {}
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
    scheme = make_scheme(contact_problem(stage), step, every)
    return scheme.advance(scheme.init(), round(end / step) + 1)[1]


FREE: dict[str, Any] = {
    "casing": {"type": "rigid", "clearance": 0.5},
    "shaft_line": {"unbalance": []},
    "reduction": {"free_interface_modes": 40},
}


def without_bearings(stage: RotorOnLine, start: Start) -> Any:
    """The contact problem of a rotor whose bearings exert no forces."""
    problem = contact_problem(stage)
    assert problem.bearings is not None
    nothing = 0.0 * problem.bearings.stiffness
    free = replace(problem.bearings, stiffness=nothing, damping=nothing)
    return replace(problem, bearings=free, start=start)


class Whole:
    """The whole rotor of a wheel on its lowest modes at a speed, in rotating axes."""

    def __init__(self, wheel: Any, speed: float) -> None:
        self.wheel = wheel
        self.mass, _, stiffness = self._at(speed)
        squares, shapes = la.eigh(stiffness, self.mass)
        self.shapes = shapes[:, squares < HIGHEST**2]
        self.given, self.at_square = squares[: self.shapes.shape[1]], speed**2
        self.still = self._on(self._at(0.0)[2])
        self.gyroscopic = self._on(self._at(1.0)[1])
        other = [(self._on(self._at(one)[2]) - self.still) / one**2 for one in (1e3, 2e3)]
        self.fourth = (other[1] - other[0]) / 3e6  # of K_1 + Omega^2 K_2
        self.square = other[0] - 1e6 * self.fourth
        hub = self.column(HUB, 0) + np.arange(6)
        place = np.zeros(wheel.size, dtype=int)
        place[inner_dofs(wheel)], place[wheel.hub_dofs] = np.arange(wheel.size - 6), hub
        uniform = np.zeros((len(self.mass), 2))
        uniform[: wheel.size - 6] = rigid_motions(wheel)[inner_dofs(wheel), :2]
        for node in range(NODES):
            for way in range(2):
                uniform[self.column(node, way), way] = 1.0
        self.uniform = self.shapes.T @ (self.mass @ uniform)
        along, euler = np.zeros((2, len(self.mass)))
        along[place], euler[place] = wheel.centrifugal_load, wheel.euler_load
        inertia = RHO * np.pi * 0.04**4 / 32.0 * 0.2  # of the rods between two nodes
        for node, share in ((1, 1.0), (2, 1.0), (3, 0.5)):
            euler[self.column(node, 5)] -= inertia * share
        self.along, self.euler = self.shapes.T @ along, self.shapes.T @ euler

    def column(self, node: int, way: int) -> int:
        """Number of a displacement of a node of the shaft in `plain_rotor`, whose rotation about
        the axis at the first node is left out."""
        place = 6 * node + way
        return int(self.wheel.size) - 6 + place - (place > 5)

    def deflection(self, node: int) -> FloatArray:
        """Rows of the displacements x and y of a node, (2, modes)."""
        return np.asarray(self.shapes[[self.column(node, 0), self.column(node, 1)]])

    def _at(self, omega: float) -> list[FloatArray]:
        return [np.asarray(each.toarray()) for each in rotor(SHAFT, self.wheel, omega)]

    def _on(self, matrix: FloatArray) -> FloatArray:
        return np.asarray(self.shapes.T @ matrix @ self.shapes)

    def steady(self, speed: float) -> FloatArray:
        """Static state at a speed without displacement of the bearings, and no velocity."""
        square = speed**2
        stiffness = self.still + square * (self.square + square * self.fourth)
        found = np.linalg.solve(stiffness, square * self.along)
        return np.concatenate([found, np.zeros_like(found)])

    def motion(self, turned: Any, times: tuple[float, float], start: FloatArray) -> FloatArray:
        """Coordinates and velocities at the second time, for angle, speed and acceleration of the
        rotation by time."""
        ends, at_hub = [self.deflection(node) for node in PLACES], self.deflection(HUB)

        def rate(time: float, state: FloatArray) -> FloatArray:
            angle, speed, acceleration = turned(time)
            turn = np.cos(angle) * np.eye(2) + np.sin(angle) * SPIN
            x, v = np.split(state, 2)
            square = speed**2
            force = square * self.along + acceleration * self.euler - self.given * x
            if change := square - self.at_square:
                twice = square + self.at_square
                force = force - change * (self.square @ x + twice * (self.fourth @ x))
            force = force - self.gyroscopic @ (speed * v + 0.5 * acceleration * x)
            force = force + self.uniform @ (turn.T @ [0.0, -GRAVITY])
            force = force + UNBALANCE * at_hub.T @ [square, -acceleration]
            for rows, spring, damper in zip(ends, SPRINGS, DAMPERS, strict=True):
                place, moved = rows @ x, rows @ v + speed * SPIN @ (rows @ x)
                pull = spring @ (turn @ place) + damper @ (turn @ moved)
                force = force - rows.T @ (turn.T @ pull)
            return np.concatenate([v, force])

        found = solve_ivp(rate, times, start, method="DOP853", rtol=1e-8, atol=1e-11)
        return np.asarray(found.y[:, -1])

    def nodes(self, state: FloatArray, angle: float) -> FloatArray:
        """Deflections of the nodes in static axes, (nodes, 2)."""
        x = np.split(state, 2)[0]
        moved = np.array([self.deflection(node) @ x for node in range(NODES)])
        return np.asarray(moved @ la.expm(angle * SPIN).T)


@pytest.mark.parametrize(
    ("kind", "march"),
    [
        ("sector", {"speed": "900 rad/s"}),
        pytest.param(
            "wheel",
            {"speed_table": [[0.0, "800 rad/s"], [0.004, "900 rad/s"]]},
            marks=pytest.mark.slow,
        ),
    ],
    ids=["constant", "varying"],
)
def test_the_march_is_the_motion_of_the_unreduced_rotor(
    kind: str, march: dict[str, Any], folder: Path
) -> None:
    """Unequal bearings with cross terms, unbalance and gravity on an unbent line."""
    end = 0.002
    start: dict[str, Any] = {"gravity": {"start": "unbent"}}
    stage = stage_of(fan_case(folder, march, kind, **start, **MANY))
    course = stage.case.march.course(stage.reference_frequency)

    def turned(time: float) -> tuple[float, float, float]:
        if course is None:
            return stage.speed * time, stage.speed, 0.0
        each = course.angle(time), course.speed(time), course.acceleration(time)
        return float(each[0]), float(each[1]), float(each[2])

    plain = Whole(fan(), stage.speed)
    state = plain.motion(turned, (0.0, end), plain.steady(turned(0.0)[1]))
    exact = plain.nodes(state, turned(end)[0])
    found = [marched(stage, step, end) for step in (1e-6, 5e-7)]
    moved = [chunk.shaft_displacement[-1, :, :2] for chunk in found]
    assert max(map(ledger_residual, found)) < 1e-9
    corrected = moved[1] + (moved[1] - moved[0]) / 3.0  # second order in the step
    scale = np.abs(exact).max()
    assert np.abs(moved[1] - exact).max() < 1e-5 * scale
    assert np.abs(corrected - exact).max() < 1e-5 * scale


def remaining(part: Any) -> Any:
    """A damaged wheel without the coordinates of what it lost."""
    kept = remaining_dofs(part)
    number = np.full(part.size + 1, -1)
    number[kept] = np.arange(len(kept))
    select = sp.csr_array(sp.eye_array(part.size))[:, kept]
    dofs = {name: number[getattr(part, name)] for name in ("contact_dofs", "hub_dofs")}
    return replace(part, **part.projected(select), **dofs)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [600.0, 1800.0])
def test_the_loss_of_a_blade_is_that_of_the_unreduced_rotor(speed: float, folder: Path) -> None:
    """Below and above the first critical speed, with the moment of a blade that leans forward."""
    lost_at, end, step = 2e-4, 1.2e-3, 5e-7
    loss = {"blade": 4, "time": lost_at, "damaged": {"file": str(folder / "damaged.npz")}}
    march = {
        **{"speed": f"{speed} rad/s", "time_step": step, "duration": end},
        "displacement_limit": 1.0,
    }
    case = fan_case(folder, march, gravity={"start": "unbent"}, blade_loss=loss, **MANY)
    chunk = marched(stage_of(case), step, end)

    def turned(time: float) -> tuple[float, float, float]:
        return speed * time, speed, 0.0

    plain, after = Whole(fan(), speed), Whole(remaining(damaged()), speed)
    state = plain.motion(turned, (0.0, lost_at), plain.steady(speed))
    kept = np.searchsorted(
        inner_dofs(fan()), np.setdiff1d(remaining_dofs(damaged()), fan().hub_dofs)
    )
    kept = np.concatenate([kept, np.arange(fan().size - 6, len(plain.mass))])
    moved = (plain.shapes @ np.split(state, 2)[0], plain.shapes @ np.split(state, 2)[1])
    start = np.concatenate([after.shapes.T @ (after.mass @ each[kept]) for each in moved])
    exact = after.nodes(after.motion(turned, (lost_at, end), start), speed * end)
    found = chunk.shaft_displacement[-1, :, :2]
    assert np.abs(found - exact).max() < 2e-5 * np.abs(exact).max()
    assert ledger_residual(chunk) < 1e-9
    assert not chunk.contact_force.any()


def test_a_damaged_wheel_must_fit_the_case(folder: Path) -> None:
    march = {"speed": "900 rad/s", "time_step": 1e-6, "duration": 1e-3}
    few = {"free_interface_modes": 12}
    loss: dict[str, Any] = {"blade": 3, "time": 1e-4}
    with pytest.raises(CaseError, match=r"blade_loss.damaged: expected the file of the damaged"):
        fan_case(folder, march, blade_loss=loss)
    loss["damaged"] = {"file": str(folder / "damaged.npz")}
    with pytest.raises(CaseError, match=r"blade_loss.blade = .*the damaged wheel lacks: 4"):
        contact_problem(stage_of(fan_case(folder, march, blade_loss=loss, reduction=few)))
    loss["damaged"] = {"file": str(folder / "sector.npz")}
    with pytest.raises(CaseError, match=r"blade_loss.damaged.file = .*coordinates of the whole"):
        contact_problem(stage_of(fan_case(folder, march, blade_loss=loss, reduction=few)))
    loss["damaged"] = {"file": str(folder / "damaged.npz")}  # made from another mesh
    with pytest.raises(CaseError, match=r"damaged.file = .*in their order: some"):
        contact_problem(stage_of(fan_case(folder, march, "sector", blade_loss=loss, reduction=few)))


def damaged_sector() -> Any:
    """The wheel of sectors without the blade of the first one."""
    faces: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    return mesh3d(fan_sector(SECTORS), **STEEL, **faces, lost="r > 79.9 mm and -30 < angle < 30")


def test_what_remains_of_a_wheel_of_sectors_has_its_matrices_away_from_the_loss() -> None:
    whole_one = wheel_with_hub(fan_sector_part(), SECTORS)
    rest = in_sector_axes(damaged_sector(), whole_one, SECTORS)
    each = (whole_one.size - 6) // SECTORS
    away = np.arange(2 * each, 4 * each)  # coordinates of two sectors that do not touch the first
    for name in ("mass", "gyroscopic", "stiffness"):
        own, left = (getattr(one, name).toarray()[away][:, away] for one in (whole_one, rest))
        np.testing.assert_allclose(left, own, rtol=0, atol=1e-12 * np.abs(own).max())
    np.testing.assert_array_equal(whole_one.hub_dofs, rest.hub_dofs)
    assert (
        rest.mass.diagonal()[whole_one.contact_dofs].any(axis=1).tolist()
        == [False] * 2 + [True] * 8
    )


@pytest.mark.slow
def test_the_loss_of_a_blade_of_a_sector_is_that_of_the_wheel_in_one_piece(folder: Path) -> None:
    write_superelement(folder / "damaged_sector.npz", damaged_sector())
    march = {"speed": "600 rad/s", "time_step": 5e-7, "duration": 6e-4}
    found = []
    for kind, name, blade in (("wheel", "damaged", 4), ("sector", "damaged_sector", 0)):
        file = {"file": str(folder / f"{name}.npz")}
        loss = {"blade": blade, "time": 2e-4, "damaged": file}
        case = fan_case(folder, march, kind, blade_loss=loss, gravity={"start": "unbent"}, **MANY)
        found.append(marched(stage_of(case), 5e-7, 6e-4).shaft_displacement)
    one, other = found
    assert np.abs(one - other).max() < 1e-8 * np.abs(one).max()


def test_a_wheel_pressed_into_a_cone_is_in_balance(folder: Path) -> None:
    """Without rotation and friction, under a large acceleration across the axis: forces of walls,
    bearings, axial spring and masses, and their moments about the start of the shaft."""
    acceleration = np.array([900.0, -3000.0])
    bearings = [
        {"position": 0.0, "stiffness": 2e7, "damping": 2e4},
        {"position": 0.4, "stiffness": 1e7, "damping": 1e4},
    ]
    line = {"bearings": bearings, "unbalance": [], "loss_time": 2e-4}
    line |= {"wheel": {"position": 0.6, "damping_ratio": 0.2}}
    stage = stage_of(
        fan_case(
            folder,
            {"speed": "0 rad/s"},
            shaft_line=line,
            gravity={"start": "unbent", "acceleration": acceleration.tolist()},
            casing={"type": "rigid", "clearance": 2e-4, "slope": 0.3},
            contact={"friction": 0.0},
            reduction={"free_interface_modes": 24},
        )
    )
    chunk = marched(stage, 5e-6, 0.35, 1000)
    assert ledger_residual(chunk) < 1e-10
    radial, tangential, along = chunk.contact_force[-1].T
    touching = radial < 0.0
    assert 0 < np.count_nonzero(touching) < len(radial)
    np.testing.assert_allclose(along[touching] / -radial[touching], np.tan(0.3), rtol=1e-9)
    angle, radius = stage.angle.ravel(), stage.part.contact_radius
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    z = 0.6 + stage.part.contact_position[:, 2] + 0.005
    turn = radial + 1j * tangential
    force = np.stack([(turn * np.exp(1j * angle)).real, (turn * np.exp(1j * angle)).imag, along])
    wheel, shaft = stage.line.wheels[0], RHO * np.pi / 4.0 * 0.04**2 * 0.6
    weight = (wheel.mass + shaft) * acceleration
    held, places = chunk.bearing_force[-1], np.array([0.0, 0.4])
    total = force[:2].sum(axis=1) + held.sum(axis=0) + weight
    assert np.abs(total).max() < 1e-4 * np.abs(weight).max()
    spring = -5e7 * chunk.shaft_displacement[-1, 0, 2]
    assert abs(spring + along.sum()) < 0.01 * along.sum()  # its vibration decays slowly
    arm = wheel.mass * (0.6 + wheel.offset) + shaft * 0.3
    about_y = (z * force[0] - x * along).sum() + places @ held[:, 0] + arm * acceleration[0]
    about_x = (y * along - z * force[1]).sum() - places @ held[:, 1] - arm * acceleration[1]
    assert max(abs(about_x), abs(about_y)) < 1e-4 * arm * np.abs(acceleration).max()
    tilt = chunk.shaft_displacement[-1, HUB, 3:5]
    assert np.abs(tilt).min() > 1e-5


def test_a_free_tilted_rotor_keeps_its_momentum_about_the_axis(folder: Path) -> None:
    """Without bearings and with a free speed, which the tilt changes; the drive has an inertia."""
    march = {"speed": "600 rad/s", "drive": {"inertia": 0.02}, "displacement_limit": 1.0}
    stage = stage_of(fan_case(folder, march, **FREE))
    rigid = np.flatnonzero(stage.rotor.frequency < 0.0)
    arm = np.linspace(-0.3, 0.3, NODES)[:, None] * [1.0, 0.0] + [0.0, 1.0]
    tilted = (0.02 + 0.01j) * arm
    rows = stage.line_nodes[:, :, rigid].reshape(-1, len(rigid))
    rows, moved = (
        np.concatenate([each.real, each.imag]) for each in (rows, tilted.ravel().astype(complex))
    )
    start = stage.rotor_rest
    start[rigid] = np.linalg.lstsq(rows, moved)[0]
    begin = Start.of_rotor(start, stage.rotor_rest, 0)
    scheme = make_scheme(without_bearings(stage, begin), 2e-6, 100)
    chunk = scheme.advance(scheme.init(), 10001)[1]
    momentum = chunk.angular_momentum
    assert np.ptp(chunk.rotation_speed) > 1e-4 * stage.speed
    assert np.ptp(momentum) < 1e-10 * abs(momentum[0])
    total = chunk.energy + chunk.rotor_energy
    assert np.ptp(total) < 1e-5 * abs(total[0])  # Coriolis forces half a step late, see `speed.h`
    assert not list(stage.own_hints())
    (hint,) = stage_of(fan_case(folder, march | {"drive": {"inertia": 0.0}}, **FREE)).own_hints()
    assert hint.startswith("march.drive.inertia = 0 kg m2")


@pytest.mark.parametrize(
    ("march", "size", "tolerance"),
    [
        pytest.param({}, 1e-3, 1e-10, marks=pytest.mark.slow),
        ({"drive": {"inertia": 0.02}}, 1e-8, 2e-10),
    ],
    ids=["constant", "free"],
)
def test_a_free_vibrating_rotor_keeps_its_momentum_across_the_axis(
    march: dict[str, Any], size: float, tolerance: float, folder: Path
) -> None:
    """In static axes, from the unreduced matrices: B^T (M z' - i W P z) for the translation and the
    tilt, P B = 2 M B + G B J. A free speed changes with the motion, whose second order linear
    equations lack: its motion is small."""
    step = 8e-6
    march = march | {"speed": "600 rad/s", "time_step": step, "record_step": step}
    march |= {"displacement_limit": 10.0}
    wheel = mesh3d(whole(fan_sector(SECTORS), SECTORS), **STEEL, stiffening="stress")
    write_superelement(folder / "stress.npz", wheel)
    stage = stage_of(fan_case(folder, march, "stress", **FREE))
    mass, gyroscopic = stage.part.mass, stage.part.gyroscopic
    rigid, shapes = stage.on_line.rigid, stage.reduced.shapes
    assert rigid is not None
    assert shapes is not None
    assert gyroscopic is not None
    away = rigid - shapes @ np.linalg.lstsq(shapes, rigid)[0]
    assert np.linalg.norm(away) < 1e-12 * np.linalg.norm(rigid)
    tilt, thrown = rigid @ [1.0, 0.5, 1.0, -0.3], rigid @ [30.0, -20.0, 100.0, 70.0]
    place, rate = (shapes.T @ (mass @ each) for each in (tilt, thrown))
    rate[:12] += 100.0 * np.random.default_rng(1).standard_normal(12)  # blades and shaft vibrate
    begin = Start.of_rotor(size * place, size * rate, 0)
    scheme = make_scheme(without_bearings(stage, begin), step, 1)
    chunk = scheme.advance(scheme.init(), 1001)[1]
    moved, turns = chunk.rotor_displacement, np.full(1000, stage.speed)
    if stage.case.march.drive is not None:
        turns = 0.5 * (chunk.rotation_speed[1:] + chunk.rotation_speed[:-1])
    angle = step * np.concatenate([[0.0], np.cumsum(turns)])
    motion = (rigid[:, 0::2] + 1j * rigid[:, 1::2]).T
    inert, across = motion @ (mass @ shapes), motion @ (gyroscopic @ shapes)
    turned = np.exp(1j * angle)[:, None]
    place, spun = turned * (moved @ inert.T), turned * (moved @ (2.0 * inert + 1j * across).T)
    momentum = np.diff(place, axis=0) / step - 0.5j * turns[:, None] * (spun[1:] + spun[:-1])
    changes = np.abs(momentum - momentum[0]).max(axis=0) / np.abs(momentum[0])
    assert (changes < tolerance).all()
    assert (np.abs(np.diff(momentum, axis=0)) > 0.0).any()


def test_supports_move_beside_a_flexible_casing(folder: Path) -> None:
    """Masses of supports under the forces of bearings, springs and dampers, in a rub."""
    bearings = [
        dict(row, support={"mass": 4.0, "stiffness": 5e7, "damping": 1e3}) for row in BEARINGS
    ]
    casing = {"type": "ring", "elements": 20, "clearance": 1e-4, "support": "20 N/mm2"}
    case = fan_case(
        folder,
        {"speed": "600 rad/s", "time_step": 1e-6, "duration": 5e-3},
        shaft_line={"bearings": bearings},
        casing=casing | {"wall": {"width": "60 mm", "thickness": "6 mm"}},
        contact={"sliding": "full"},
        reduction={"free_interface_modes": 40},
        gravity={},
        excitation=[
            {"type": "harmonic", "force": 50.0},
            {"type": "casing-distortion", "modal_force": 100.0, "nodal_diameter": 2},
        ],
    )
    stage = stage_of(case)
    pushed, *_, struck = (load for load in excitation_loads(stage))
    assert struck.casing[: stage.casing_modes.count].any()
    assert not struck.casing[stage.casing_modes.count :].any()
    np.testing.assert_allclose(pushed.rotor, 25.0 * stage.rotor.centre[0], rtol=1e-9, atol=1e-9)
    chunk = marched(stage, 1e-6, 5e-3, 2)
    assert ledger_residual(chunk) < 1e-9
    assert chunk.casing_displacement.shape[1] == stage.casing_modes.count
    assert chunk.contact_force.any()
    assert np.abs(chunk.casing_displacement[-1]).max() > 0.0
    # the support feels its bearing and its own spring and damper: acceleration by differences
    place, force = chunk.support_displacement[:, 0], chunk.bearing_force[:, 0]
    step = 2e-6
    rate = (place[2:] - place[:-2]) / (2.0 * step)
    curve = (place[2:] - 2.0 * place[1:-1] + place[:-2]) / step**2
    own = 4.0 * curve + 1e3 * rate + 5e7 * place[1:-1] + force[1:-1]
    own[:, 1] += 4.0 * GRAVITY
    assert np.abs(own).max() < 5e-4 * np.abs(force).max()


def two_wheels(
    folder: Path, first: float, walls: dict[float, dict[str, Any]], **changed: Any
) -> Case:
    """A line with a fan in one piece at 0.6 m and one of sectors at 0.3 m, one of which is that of
    [bladed_disk]; walls by positions."""
    files = {0.6: "wheel", 0.3: "sector"}
    (other,) = files.keys() - {first}
    own = {"file": str(folder / f"{files[other]}.npz"), "copies": SECTORS}
    further = {"position": other, "superelement": own, "casing": walls[other]}
    line = {"wheel": {"position": first}, "wheels": [further], "unbalance": []}
    tables: dict[str, Any] = {
        "casing": {"type": "rigid"} | walls[first],
        "contact": {"friction": 0.1, "sliding": "full"},
        "reduction": {"free_interface_modes": 60},
        "gravity": {"start": "unbent", "acceleration": [2000.0, -9000.0]},
    }
    march = {"speed": "600 rad/s", "time_step": 1e-6, "duration": 3e-3}
    return fan_case(folder, march, files[first], shaft_line=line, **tables | changed)


WALLS: dict[float, dict[str, Any]] = {
    0.6: {"clearance": 1e-4, "slope": 0.2},
    0.3: {"clearance": 5e-5, "radius": 0.1601},
}


def ring(thickness: str, **more: Any) -> dict[str, Any]:
    """A flexible ring."""
    wall = {"width": "60 mm", "thickness": thickness}
    return {"type": "ring", "support": "20 N/mm2", "wall": wall} | more


STRUT = {"length": "100 mm", "thickness": "5 mm", "inclination": "20 deg"}
RINGS: dict[float, dict[str, Any]] = {
    0.6: ring("6 mm", clearance=1e-4, slope=0.2, struts=[STRUT | {"angle": "70 deg"}]),
    0.3: ring("4 mm", clearance=6e-5),
}


# the last of 120 is one of four of equal frequency
@pytest.mark.slow
@pytest.mark.parametrize(("walls", "modes"), [(WALLS, 60), (WALLS, 120), (RINGS, 60)])
def test_each_of_two_wheels_rubs_its_own_wall_whichever_is_first(
    walls: dict[float, dict[str, Any]], modes: int, folder: Path
) -> None:
    reduction = {"free_interface_modes": modes}
    found = dict[float, list[FloatArray]]()
    for first in (0.6, 0.3):
        stage = stage_of(two_wheels(folder, first, walls, reduction=reduction))
        chunk = marched(stage, 1e-6, 3e-3)
        assert ledger_residual(chunk) < 1e-9
        own, other = np.split(chunk.contact_force, [stage.part.wheel_nodes[0]], axis=1)
        found[first] = [own, other][:: 1 if first == 0.6 else -1]
        assert len(stage.blade_angle[0]) == stage.case.blades_at_walls == 2 * SECTORS
        at = [np.ptp(each) for each in np.split(stage.axial_position, [stage.part.wheel_nodes[0]])]
        assert abs(np.ptp(stage.axial_position) - 0.3) < at[0] + 1e-9
    for one, swapped in zip(*found.values(), strict=True):
        assert one.any()
        np.testing.assert_allclose(one, swapped, rtol=0, atol=1e-5 * np.abs(one).max())


def test_rings_of_several_wheels_follow_each_other(folder: Path) -> None:
    stage = stage_of(two_wheels(folder, 0.6, RINGS, reduction={"free_interface_modes": 12}))
    problem, nodes = contact_problem(stage), len(stage.blade) // 2
    first, other = np.split(problem.casing.clearance[:, 0], 2)  # normal to the walls
    np.testing.assert_allclose(first, 1e-4 * np.cos(0.2))
    np.testing.assert_allclose(other, 6e-5)
    assert problem.rotor.wall.tolist() == stage.arrays.wheel.tolist() == [0] * nodes + [1] * nodes
    assert stage.arrays.casing_wheel.tolist() == [0] * 40 + [1] * 40
    np.testing.assert_allclose(np.diff(stage.arrays.ring_radius[[0, -1]]), 6e-5 - 1e-4)
    own = np.split(stage.arrays.casing_shape, 2)
    assert not np.any(np.any(own[0], axis=(0, 1)) & np.any(own[1], axis=(0, 1)))
    assert stage.clearance_key(2 * nodes - 1) == "shaft_line.wheels.0.casing.clearance"


def test_points_of_a_further_wheel_move_as_its_contact_nodes(folder: Path) -> None:
    stage = stage_of(two_wheels(folder, 0.6, RINGS, reduction={"free_interface_modes": 12}))
    arrays = stage.arrays
    own = np.flatnonzero(arrays.wheel == 1)
    angle, axial = arrays.tip_angle[own], arrays.axial_position[own]
    outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    nodes = np.column_stack([arrays.contact_radius[own, None] * outward, axial])
    apart = np.linalg.norm(nodes[:, None] - arrays.further_point, axis=-1)
    assert apart.min(axis=1).max() < 1e-12
    moved = arrays.further_point_shape[apart.argmin(axis=1)]
    radial = np.einsum("nd,ndm->nm", outward, moved[:, :2])
    expected = arrays.contact_shape[own]
    np.testing.assert_allclose(radial, expected[:, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(moved[:, 2], expected[:, 2], rtol=0, atol=1e-12)
    assert set(arrays.further_point_wheel) == {1}
    assert arrays.further_triangle.max() == len(arrays.further_point) - 1


def test_walls_of_several_wheels_are_round_and_of_one_type(folder: Path) -> None:
    with pytest.raises(CaseError, match=r'wheels\[0\].casing.type = "rigid": expected "ring", as'):
        two_wheels(folder, 0.6, WALLS, casing={"type": "ring", "clearance": 1e-4})
    other = RINGS | {0.3: RINGS[0.3] | {"elements": 24}}
    with pytest.raises(CaseError, match=r"wheels\[0\].casing.elements = 24: not allowed here"):
        two_wheels(folder, 0.6, other)
    lobes = {
        "type": "rigid",
        "clearance": 1e-4,
        "clearance_lobes": [{"lobes": 2, "amplitude": 1e-5}],
    }
    with pytest.raises(CaseError, match=r"casing.clearance_lobes.*: not allowed with"):
        two_wheels(folder, 0.6, WALLS, casing=lobes)
    inside = WALLS | {0.3: {"clearance": 0.0, "radius": 0.15}}
    with pytest.raises(
        CaseError, match=r"shaft_line.wheels\[0\].casing.clearance = .*wall at t = 0"
    ):
        contact_problem(stage_of(two_wheels(folder, 0.6, inside)))
