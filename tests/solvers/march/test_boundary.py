"""March of structures with many contact nodes, against plain NumPy: walls, rings and coatings."""

from itertools import cycle, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from boundary_cases import advanced, assert_plain, bladed, casing, coating, rubbing
from long_cases import slow_except

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import EndReason


def turning() -> FloatArray:
    """A matrix of forces due to velocities, with losses."""
    drawn = np.random.default_rng(5).standard_normal((8, 8))
    return np.asarray(300.0 * (drawn - drawn.T) + 20.0 * drawn @ drawn.T)


def pressed(copies: int, modes: int = 0) -> tuple[Load, ...]:
    """Loads on the blades, and on the modes of a ring: with a ramp, and from the start on."""
    random = np.random.default_rng(9)
    blades, ring = 30.0 * random.standard_normal((copies, 8)), 100.0 * random.standard_normal(modes)
    times = {"frequency": 2e3, "phase": 0.3, "ramp": 5e-4, "end": 8e-4}
    return (
        Load(rotor=blades.ravel(), casing=ring, **times),
        Load(rotor=0.5 * blades[::-1].ravel(), casing=-ring, end=3e-4, phase=0.2),
    )


KINDS: dict[str, dict[str, Any]] = {
    "wall": {"loads": pressed(2)},
    "wall, full sliding, backward": {"sliding": "full", "speed": -220.0},
    "wall, Coriolis forces": {"sliding": "full", "by_velocity": turning()},
    "ring": {"ring": casing(8), "loads": pressed(2, len(casing(8).frequency))},
    "ring, full sliding": {"ring": casing(8, damping=0.01), "sliding": "full"},
    "coating": {"coating": coating(np.array([0.0, 0.0, 1.0]), 4e-3, limit=0.06)},
}


@pytest.mark.parametrize(
    ("kind", "massless"),
    slow_except(product(KINDS, [True, False]), *zip(KINDS, cycle([True, False]), strict=False)),
)
def test_the_compiled_march_is_that_of_plain_numpy(kind: str, massless: bool) -> None:
    problem = bladed(2, 3, massless=massless, **KINDS[kind])
    dt, steps = 4e-6, 150 if "coating" in kind else 250
    chunk = assert_plain(problem, dt, steps)
    assert (chunk.contact_force[:, :, 0] < 0.0).any(axis=0).sum() > 2
    assert (np.abs(chunk.axial_impulse).max() > 0.0) == (problem.sliding == "full")
    if chunk.coating is None:
        return
    assert (chunk.coating.coating_strain[-1] > 0.0).any(axis=1).all()
    soft, whole = (
        each.sum(axis=0) for each in (chunk.coating.coating_impulse, chunk.contact_impulse)
    )
    assert (soft < 0.99 * whole).any()  # metal


@pytest.mark.parametrize(
    "problem", [bladed(2, 4, sliding="full"), rubbing()], ids=["wall", "coating"]
)
def test_records_do_not_depend_on_their_distance_and_a_march_can_be_split(
    problem: ContactProblem,
) -> None:
    dt = 4e-6
    fine, coarse = advanced(problem, dt, 400), advanced(problem, dt, 400, 20)
    assert np.array_equal(coarse.rotor_displacement, fine.rotor_displacement[::20])
    assert coarse.contact_impulse.sum(axis=0) == pytest.approx(fine.contact_impulse.sum(axis=0))
    scheme = CentralDifference(problem, dt, 20)
    state, _, _ = scheme.advance(scheme.init(), 150)
    state, none, _ = scheme.advance(state, 5)  # without a record
    assert none.records == 0
    _, rest, _ = scheme.advance(state, 246)
    assert np.array_equal(rest.rotor_displacement[-1], coarse.rotor_displacement[-1])
    assert np.array_equal(rest.energy[-1], coarse.energy[-1])
    if rest.coating is not None and fine.coating is not None:
        assert rest.coating.wear_volume[-1] == fine.coating.wear_volume[-1]
        assert np.array_equal(rest.coating.coating_strain[-1], fine.coating.coating_strain[-1])


@pytest.mark.parametrize("massless", [False, True])
@pytest.mark.parametrize("way", [0, 1, 2])
def test_displacements_of_nodes_are_limited_in_every_direction(way: int, massless: bool) -> None:
    """The second of two copies moves in one direction only, without contact."""
    rotor = ReducedRotor.of_copies(
        frequency=np.full((2, 1), 900.0),
        damping_ratio=np.zeros((2, 1)),
        contact=np.eye(3)[:, [way]],
        compliance=np.tile(1e-9 * np.eye(3), (2, 1, 1)) if massless else None,
        angle=np.array([[0.0], [np.pi]]),
        radius=np.full(1, 0.3),
        recess=np.zeros(1),
        tip_radius=0.3,
    )
    free = bladed(
        *(2, 1),
        rotor=rotor,
        casing=ReducedCasing.rigid(np.tile([1.0, 0.0], (64, 1)), 0.3),
        start=Start.of_rotor(np.zeros(2), 1.1e-3 * 900.0 * np.eye(2)[1], 0),
        displacement_limit=1.05e-3,
    )
    scheme = CentralDifference(free, 1e-6, 10)
    state, chunk, end = scheme.advance(scheme.init(), 5000)
    assert end is EndReason.DIVERGENT
    after = np.arcsin(1.05 / 1.1) / 900.0
    assert after - 1e-6 < state.step * 1e-6 < after + 1.01e-4
    assert np.abs(chunk.contact_displacement[-1, 1, way]) == pytest.approx(1.05e-3, rel=0.03)
    arrays = SimpleNamespace(node=[0, 0], blade=[0, 1])
    who, how = chunk.beyond(free, arrays, 1e-6)  # type: ignore[arg-type]
    assert who == "blade 1"
    assert how.endswith(f" m {['radially', 'tangentially', 'axially'][way]})")


def test_a_march_ends_at_the_displacement_limit_and_refuses_long_steps() -> None:
    """A blade whose node has no mass: its highest frequency is that of the node held fast."""
    problem = bladed(1, 1, displacement_limit=5e-5)
    scheme = CentralDifference(problem, 1e-6, 10)
    state, chunk, end = scheme.advance(scheme.init(), 1000)
    assert end is EndReason.DIVERGENT
    assert state.step < 60
    assert chunk.contact_displacement[-1, 0, 0] <= 5e-5
    rotor = problem.rotor
    assert rotor.compliance is not None
    held = rotor.contact.T @ np.linalg.inv(rotor.compliance[0]) @ rotor.contact
    highest = np.linalg.eigvalsh(np.diag(rotor.frequency**2) + held)[-1]
    assert problem.critical_time_step == pytest.approx(2.0 / np.sqrt(highest))
    with pytest.raises(ValueError, match="at or above the critical step"):
        CentralDifference(problem, 1e-4, 1)
