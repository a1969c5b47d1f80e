"""Contact of a wheel on a shaft line that is constant in rotating axes: against the unreduced
matrices of `plain_rotor`, and against marches."""

import json
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from command_line import answer
from plain_rotor import NU, RHO, E, Shaft, rotor
from solid_meshes import fan_sector, whole

import bladewhirl as bw
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.models.superelements.hub import inner_dofs
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.solvers.march.sudden_changes import make_scheme
from bladewhirl.solvers.periodic.corotating import (
    CorotatingContact,
    Structure,
    contact_states,
)
from bladewhirl.solvers.periodic.corotating import _deviations as deviations
from bladewhirl.studies.periodic.initial_states import of_corotating

SECTORS, HUB = 5, 3
SLOPE, CLEARANCE = 0.3, 2e-5
UNBALANCE, PHASE = 5e-3, 0.4
UNEQUAL = [[1e7, 0.0], [0.0, 2e7]]
SUPPORT = {"mass": 4.0, "stiffness": 5e7, "damping": 2e3}


@cache
def fan() -> Any:
    """A wheel of five blades with two contact nodes each."""
    steel: dict[str, Any] = {"young_modulus": E, "poisson_ratio": NU, "density": RHO}
    tied: dict[str, Any] = {"hub": "root", "hub_at": "-5 mm", "stress": False}
    return mesh3d(whole(fan_sector(SECTORS), SECTORS), **steel, **tied)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """File of the wheel."""
    path = tmp_path_factory.mktemp("rotor") / "wheel.npz"
    write_superelement(path, fan())
    return path


def rubbing(file: Path, line: dict[str, Any] | None = None, **changed: Any) -> Case:
    """A case of the wheel at the end of its shaft, in a cone."""
    bearings = [
        {"name": "rear", "position": 0.0, "stiffness": 2e7, "damping": 2e3},
        {"name": "front", "position": 0.4, "stiffness": 1e7, "damping": 1e3},
    ]
    shaft_line = {
        "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 3}],
        "bearings": bearings,
        "wheel": {"position": 0.6},
        "axial": {"position": 0.0, "stiffness": 5e7},
        "unbalance": [{"position": 0.2, "unbalance": UNBALANCE, "phase": PHASE}],
    }
    return case_from(
        {
            "material": {"young_modulus": E, "density": RHO},
            "bladed_disk": {"superelement": {"file": str(file), "copies": SECTORS}},
            "shaft_line": shaft_line | (line or {}),
            "casing": {"type": "rigid", "clearance": CLEARANCE, "slope": SLOPE},
            "contact": {"friction": 0.2},
            "reduction": {"free_interface_modes": 24},
            "march": {"speed": "900 rad/s", "time_step": 4e-6},
        }
        | changed
    )


def damped(
    file: Path, friction: float, damping_ratio: float, loss_time: float, *, support: bool = True
) -> Case:
    """The rub of a rotor with damping in wheel, shaft and bearings."""
    ends: list[dict[str, Any]] = [
        {"position": z, "stiffness": k, "damping": 2e4} for z, k in ((0.0, 2e7), (0.4, 1e7))
    ]
    if support:
        ends[0]["support"] = SUPPORT
    line = {
        "bearings": ends,
        "loss_time": loss_time,
        "wheel": {"position": 0.6, "damping_ratio": damping_ratio},
        "unbalance": [{"position": z, "unbalance": 1e-2} for z in (0.2, 0.6)],
    }
    return rubbing(file, line, contact={"friction": friction, "sliding": "full"})


def on(problem: ContactProblem, contact: CorotatingContact) -> ContactProblem:
    """A contact problem that starts with a constant contact."""
    return replace(problem, start=of_corotating(problem, contact)[0])


def marched(problem: ContactProblem, end: float, every: int, step: float = 4e-6) -> Chunk:
    """The records of a march."""
    scheme = make_scheme(problem, step, every)
    return scheme.advance(scheme.init(), round(end / step) + 1)[1]


def test_all_states_of_a_tilted_wheel_in_a_cone_are_those_of_the_unreduced_rotor(
    file: Path,
) -> None:
    """Each set of up to four tips in contact is tried with the whole matrices."""
    case, speed, friction = rubbing(file), 900.0, 0.2
    document = bw.periodic(case)
    shaft = Shaft(
        length=0.6,
        diameter=0.04,
        elements=3,
        bearings=((0, 2e7, 2e3), (2, 1e7, 1e3)),
        hub=HUB,
        axial=(0, 5e7),
    )
    wheel = fan()
    stiffness = rotor(shaft, wheel, speed)[2].toarray()
    size, inner = wheel.size - 6, inner_dofs(wheel)

    def column(node: int, way: int) -> int:
        place = 6 * node + way
        return int(size + place - (place > 5))

    number = np.zeros(wheel.size, dtype=int)
    number[inner] = np.arange(size)
    angle = np.arctan2(*wheel.contact_position[:, 1::-1].T)
    normal, along = np.zeros((2, len(angle), len(stiffness)))
    places = number[wheel.contact_dofs.reshape(-1, 3)]
    c, s = np.cos(SLOPE), np.sin(SLOPE)
    for tip, place in enumerate(places):
        cosine, sine = np.cos(angle[tip]), np.sin(angle[tip])
        normal[tip, place] = c * cosine, c * sine, -s
        along[tip, place] = -sine, cosine, 0.0
    push = np.zeros(len(stiffness))
    pull = UNBALANCE * speed**2 * np.exp(1j * PHASE)
    push[[column(1, 0), column(1, 1)]] = pull.real, pull.imag
    moved = np.linalg.solve(stiffness, np.column_stack([push, -(normal + friction * along).T]))
    recess = contact_problem(build_stage(case)).rotor.tip_recess
    gap, matrix = c * CLEARANCE + recess - normal @ moved[:, 0], -normal @ moved[:, 1:]
    known = []
    for count in range(1, 5):
        for touching in map(list, combinations(range(len(angle)), count)):
            force = np.zeros(len(angle))
            force[touching] = np.linalg.solve(matrix[np.ix_(touching, touching)], -gap[touching])
            if (force >= 0.0).all() and (gap + matrix @ force > -1e-12).all():
                known.append(force)
    found = document["normal_force"].values
    assert len(known) == len(found) == 3
    hub = [column(HUB, way) for way in range(6)]
    for force in known:
        (same,) = (n for n in range(3) if ((found[n] > 0.0) == (force > 0.0)).all())
        assert np.abs(found[same] - force).max() < 1e-8 * force.max()
        state = document.isel(speed=same)
        x = moved @ np.append(1.0, force)
        for ways in (slice(0, 2), slice(3, 5)):  # displacements and tilt
            own, other = state["shaft_displacement"].values[HUB, ways], x[hub[ways]]
            assert np.abs(own - other).max() < 1e-8 * np.abs(other).max()
        place = {node: complex(*x[[column(node, 0), column(node, 1)]]) for node in (0, 2)}
        assert state["bearing_amplitude"].values == pytest.approx(
            [abs(place[0]), abs(place[2])], rel=1e-8
        )


@pytest.mark.parametrize("support", [False, True])
def test_a_march_settles_onto_a_stable_state_and_stays_there(file: Path, support: bool) -> None:
    problem = contact_problem(build_stage(damped(file, 0.05, 0.2, 2e-4, support=support)))
    (state,) = contact_states(problem)
    assert state.stable
    assert np.count_nonzero(state.normal) == 2
    force = state.normal * np.sqrt(1.0 + problem.friction**2)
    for begun, end in ((problem, 0.36), (on(problem, state), 0.008)):
        chunk = marched(begun, end, 2000)
        pressed = np.linalg.norm(chunk.contact_force[-1], axis=1)
        moved = np.abs(chunk.rotor_displacement[-1] - state.rotor).max()
        assert np.abs(pressed - force).max() < 1e-6 * force.max()
        assert moved < 1e-6 * np.abs(state.rotor).max()


@pytest.mark.parametrize(("friction", "stable"), [(0.3, True), (0.5, False)])
def test_deviations_grow_in_a_march_as_the_eigenvalues_say(
    file: Path, friction: float, stable: bool
) -> None:
    """Between these friction coefficients an oscillation of the blades begins to grow."""
    problem = contact_problem(build_stage(damped(file, friction, 0.02, 1e-5)))
    contact, *_ = contact_states(problem)
    assert contact.stable == stable
    still, fading = deviations(problem, Structure.of_problem(problem), contact.normal)
    size, modes = len(still), len(contact.rotor)
    matrix = np.block([[np.zeros((size, size)), np.eye(size)], [-still, -fading]]).real
    values, vectors = la.eig(matrix)
    first = np.zeros(2 * size)
    first[size : size + modes] = vectors[size:, np.argmax(values.real)].real[:modes]
    first *= 1e-3 * np.abs(contact.rotor).max() / np.abs(first).max()
    begun, ends = on(problem, contact), []
    for velocity in (begun.start.rotor_velocity, first[size : size + modes]):
        kicked = replace(begun, start=replace(begun.start, rotor_velocity=velocity))
        ends.append(marched(kicked, 4e-3, 1000, 1e-6).rotor_displacement)
    expected = np.array([(la.expm(matrix * 1e-3 * n) @ first)[:modes] for n in range(5)])
    assert (np.linalg.norm(expected[-1]) > np.linalg.norm(expected[1])) != stable
    assert ends[1] - ends[0] == pytest.approx(expected, abs=0.02 * np.abs(expected).max())


def test_the_command_lists_states_bearings_and_blades(file: Path, tmp_path: Path) -> None:
    case, folder = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(bw.dumps_case(rubbing(file)))
    document = json.loads(answer("periodic", case, "--json", "-o", folder).stdout)
    assert document["bearings"] == ["rear", "front"]
    states = document["solutions"]
    assert sorted(state["tips"] for state in states) == [1, 2, 4]
    for state in states:
        pressed = np.flatnonzero(state["normal_force"])
        assert state["blades"] == sorted(set((pressed // 2).tolist()))
        amplitude, force = state["bearing_amplitude"], state["bearing_force"]
        stiff = np.abs([2e7 + 2e3 * 900j, 1e7 + 1e3 * 900j])
        assert force == pytest.approx(stiff * amplitude, rel=1e-12)
        tip = np.array(state["tip_displacement"])[pressed]
        assert np.cos(SLOPE) * tip[:, 0] - np.sin(SLOPE) * tip[:, 2] == pytest.approx(
            np.cos(SLOPE) * CLEARANCE, rel=0.05
        )  # and the growth of the tips by the rotation
        assert not state["stable"]
    assert (folder / "periodic.png").exists()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"gravity.acceleration": [0.0, -0.01]}, "the weight turns in rotating axes"),
        ({"casing.profile": {"harmonics": [{"lobes": 2, "amplitude": 1e-5}]}}, "not round"),
        (
            {
                "shaft_line.bearings": [
                    {"position": z, "stiffness": [[1e7, 0], [0, 2e7]]} for z in (0.0, 0.4)
                ]
            },
            "shaft_line.bearings.stiffness of '1' is not the same along x and y",
        ),
        ({"shaft_line.unbalance": []}, "no load acts on the bladed disk"),
    ],
)
def test_refusals_name_what_is_not_constant(
    changes: dict[str, Any], reason: str, file: Path
) -> None:
    with pytest.raises(bw.UserError, match=rf"{reason}.* a case without \[shaft_line\]"):
        bw.periodic(bw.with_values(rubbing(file), changes))


def test_a_line_without_blades_is_refused() -> None:
    line = {
        "segments": [{"length": 0.5, "outer_diameter": 0.05}],
        "bearings": [{"position": end, "stiffness": 1e7} for end in (0.0, 0.5)],
        "unbalance": [{"position": 0.5, "unbalance": 1e-3}],
    }
    with pytest.raises(bw.UserError, match="there are no blades"):
        bw.periodic(case_from({"shaft_line": line}))


def test_a_branch_over_friction_shows_where_stability_is_lost(file: Path, tmp_path: Path) -> None:
    """From a stable state; the models are built once."""
    case, folder = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(bw.dumps_case(damped(file, 0.1, 0.02, 1e-5)))
    over = ("periodic", case, "--over", "contact.friction=0.1:0.4", "--points", 4)
    document = json.loads(answer(*over, "--json", "-o", folder).stdout)
    assert document["ended"] == "reaches contact.friction = 0.4"
    kinds = [point["kind"] for point in document["points"]]
    place = kinds.index("Neimark-Sacker")
    before, at, after = document["points"][place - 1 : place + 2]
    assert before["stable"]
    assert not after["stable"]
    assert abs(at["growth_rate"]) < 1e-2 * after["growth_rate"]
    assert (folder / "branch.png").exists()


def test_two_stable_states_at_one_speed(file: Path) -> None:
    """A march stays on each of them, and leaves the unstable one for one of them."""
    line = {"loss_time": 2e-4, "wheel": {"position": 0.6, "damping_ratio": 0.05}}
    problem = contact_problem(build_stage(rubbing(file, line, contact={"friction": 0.05})))
    states = contact_states(problem)
    assert [state.stable for state in states] == [True, True, False]
    for state, end in zip(states, (0, 1, 1), strict=True):
        begun = replace(state, rotor=1.001 * state.rotor)
        chunk = marched(on(problem, begun), 0.12, 5000)  # deviations fade by 51 1/s
        apart = np.abs(chunk.rotor_displacement[-1] - states[end].rotor).max()
        assert apart < 1e-4 * np.abs(states[end].rotor).max()
