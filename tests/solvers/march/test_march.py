"""The march in time: order, start, records, resuming, divergence."""

from dataclasses import replace

import numpy as np
import pytest
from contact_cases import (
    ledger_residual,
    problem,
    random_problem,
    run,
    small_rotor,
    stage_problem,
    wall,
)

from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import CHUNK_STEPS, EndReason, KernelState, joined, march
from bladewhirl.solvers.march.schema import HISTORY


def driven(ramp: float = 0.0) -> ContactProblem:
    """Two damped modes a body, under a harmonic load, out of reach of each other."""
    rotor = small_rotor(
        np.array([300.0, 700.0]),
        damping_ratio=np.array([0.02, 0.1]),
        tip_radial=np.array([[1.0, 0.5]]),
    )
    load = Load(
        rotor=np.array([40.0, -90.0]), casing=np.array([0.3]), ramp=ramp, frequency=450.0, phase=0.4
    )
    start = {
        "rotor": np.array([1e-3, -2e-4]),
        "rotor_velocity": np.array([-0.2, 0.5]),
        "casing": np.array([0.1]),
        "casing_velocity": np.array([0.2]),
    }
    return problem(rotor, wall(10.0), start=start, loads=(load,))


def test_start_agrees_with_initial_velocity_and_acceleration() -> None:
    """x_{-1} is such that the first velocity is the one given and x_1 the Taylor step."""
    given, dt = driven(), 1e-5
    _, chunk, _ = run(given, dt, 2)
    start, rotor, load = given.start, given.rotor, given.loads[0]
    np.testing.assert_array_equal(chunk.rotor_displacement[0], start.rotor)
    np.testing.assert_allclose(chunk.rotor_velocity[0], start.rotor_velocity, rtol=1e-9)
    np.testing.assert_allclose(chunk.casing_velocity[0], start.casing_velocity, rtol=1e-9)
    acceleration = (
        load.rotor * np.cos(load.phase)
        - 2.0 * rotor.damping_ratio * rotor.frequency * start.rotor_velocity
        - rotor.frequency**2 * start.rotor
    )
    first = start.rotor + dt * start.rotor_velocity + 0.5 * dt**2 * acceleration
    np.testing.assert_allclose(chunk.rotor_displacement[1], first, rtol=1e-12)


@pytest.mark.parametrize(
    ("load", "force_at_start"),
    [({"ramp": 0.1}, 0.0), ({"end": 0.0}, 0.0), ({"phase": np.pi / 3.0}, 0.5), ({}, 1.0)],
)
def test_start_knows_the_load_at_the_first_instant(
    load: dict[str, float], force_at_start: float
) -> None:
    rotor = small_rotor(np.array([100.0]), tip_radial=np.ones((1, 1)))
    force = Load(rotor=np.ones(1), casing=np.zeros(1), **load)
    dt = 1e-4
    _, chunk, _ = run(problem(rotor, wall(1.0), loads=(force,)), dt, 1)
    assert chunk.rotor_displacement[1, 0] == pytest.approx(
        0.5 * dt**2 * force_at_start, rel=1e-9, abs=1e-18
    )
    assert chunk.rotor_velocity[0, 0] == pytest.approx(0.0, abs=1e-15)


def test_a_load_ends_when_it_says() -> None:
    rotor = small_rotor(np.zeros(1), tip_radial=np.ones((1, 1)))
    force = Load(rotor=np.ones(1), casing=np.zeros(1), end=0.00995)
    _, chunk, _ = run(problem(rotor, wall(10.0), loads=(force,)), 1e-4, 300)
    # A free mass: it ends with the impulse of the force, half a step more at the start.
    np.testing.assert_allclose(chunk.rotor_velocity[-1, 0], 0.00995, rtol=0.01)
    np.testing.assert_allclose(np.diff(chunk.rotor_velocity[102:, 0]), 0.0, atol=1e-12)


@pytest.mark.parametrize("every", [7, 50])
def test_nothing_is_lost_between_records(every: int) -> None:
    given = random_problem(5)
    steps = 350
    _, fine, _ = run(given, 1e-4, steps)
    state, coarse, _ = run(given, 1e-4, steps, every=every)
    assert (fine.contact_impulse > 0.0).sum() > 100
    np.testing.assert_array_equal(coarse.step, np.arange(0, steps + 1, every))
    np.testing.assert_allclose(coarse.time, coarse.step * 1e-4)
    for name in ("contact_impulse", "friction_impulse", "contact_steps"):
        one_by_one = getattr(fine, name)[1:].reshape(-1, every, 4).sum(axis=1)
        np.testing.assert_allclose(getattr(coarse, name)[1:], one_by_one, rtol=1e-12)
    smallest = fine.gap[1:].reshape(-1, every, 4).min(axis=1)
    np.testing.assert_array_equal(coarse.gap[1:], smallest)
    for name in ("rotor_displacement", "rotor_velocity", "energy", "friction_work", "contacts"):
        np.testing.assert_array_equal(getattr(coarse, name), getattr(fine, name)[::every])
    assert state.statistics.steps == steps + 1
    touched = (fine.contact_impulse > 0.0).any(axis=1)
    assert state.statistics.contact_steps - 1 <= touched.sum() <= state.statistics.contact_steps


def stored(state: KernelState) -> KernelState:
    """The same state through bytes, as a file would hold it."""
    arrays = {
        name: np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)
        for name, array in state.arrays.items()
    }
    return KernelState(step=state.step, arrays=arrays)


@pytest.mark.parametrize("cyclic", [True, False])
def test_resuming_is_exact_to_the_last_bit(cyclic: bool) -> None:
    """At any step, on a record or between two, with a scheme made anew."""
    base = stage_problem(5, 8)
    given = replace(base, sliding="signed", tip_rotation=True)
    dt, every = 0.5 * base.critical_time_step, 13
    scheme = CentralDifference(given, dt, every, cyclic=cyclic)
    begin = scheme.init()
    whole_state, whole, end = scheme.advance(begin, 4000)
    assert end is None
    assert whole_state.statistics.contact_steps > 1000

    state, chunks = begin, []
    for steps in (1, 12, 13, 974, 2000, 1000):
        again = CentralDifference(given, dt, every, cyclic=cyclic)
        state, chunk, _ = again.advance(stored(state), steps)
        chunks.append(chunk)
    assert state.statistics == whole_state.statistics
    for name, expected in whole_state.arrays.items():
        np.testing.assert_array_equal(state.arrays[name], expected)
    for name, values in vars(joined(chunks)).items():
        np.testing.assert_array_equal(values, getattr(whole, name), err_msg=name)
    # The state that went in stays as it was.
    assert begin.step == 0
    np.testing.assert_array_equal(begin.arrays["rotor"], scheme.init().arrays["rotor"])


def test_march_yields_the_same_in_chunks() -> None:
    given, dt = driven(), 1e-5
    timing = Timing(time_step=dt, duration=1.24999, record_step=7 * dt)
    assert timing.steps % timing.record_every == 0
    scheme = CentralDifference(given, dt, timing.record_every)
    results = list(march(scheme, timing))
    assert len(results) == 3
    assert [end for _, _, end in results] == [None, None, EndReason.COMPLETED]
    assert all(chunk.records <= CHUNK_STEPS // 7 + 1 for _, chunk, _ in results)
    records = joined([chunk for _, chunk, _ in results])
    _, whole, _ = scheme.advance(scheme.init(), timing.steps + 1)
    np.testing.assert_array_equal(records.step, np.arange(0, 125_000, 7))
    for name, values in vars(records).items():
        np.testing.assert_array_equal(values, getattr(whole, name), err_msg=name)

    # From a state in the middle the rest comes out the same.
    rest = joined([chunk for _, chunk, _ in march(scheme, timing, results[0][0])])
    later = records.step > results[0][1].step[-1]
    np.testing.assert_array_equal(rest.rotor_displacement, records.rotor_displacement[later])


def test_records_without_the_casing_are_otherwise_the_same() -> None:
    """Also after records with it: the memory of records is used again."""
    scheme = CentralDifference(random_problem(5), 1e-4, 7)
    _, whole, _ = scheme.advance(scheme.init(), 350)
    scheme.records_casing = False
    _, chunk, _ = scheme.advance(scheme.init(), 350)
    assert whole.contact_impulse.any()
    for name, values in vars(whole).items():
        if name.startswith("casing"):
            assert getattr(chunk, name).shape == (len(whole.step), 0)
        else:
            np.testing.assert_array_equal(getattr(chunk, name), values, err_msg=name)


@pytest.mark.parametrize(
    ("steps", "every"), [(1050, 100), (99, 100), (1, 100), (CHUNK_STEPS + 1, 100)]
)
def test_the_last_step_is_recorded_wherever_it_falls(steps: int, every: int) -> None:
    """Steps after the last whole record are neither lost nor counted twice."""
    given, dt = driven(), 1e-5
    timing = Timing(time_step=dt, duration=steps * dt, record_step=every * dt)
    scheme = CentralDifference(given, dt, every)
    records = joined([chunk for _, chunk, _ in march(scheme, timing)])
    expected = [*range(0, steps, every), steps]
    np.testing.assert_array_equal(records.step, expected)
    fine = CentralDifference(given, dt, 1)
    _, each, _ = fine.advance(fine.init(), steps + 1)
    np.testing.assert_array_equal(records.rotor_velocity, each.rotor_velocity[records.step])
    np.testing.assert_allclose(
        records.contact_impulse.sum(axis=0), each.contact_impulse.sum(axis=0), rtol=1e-12
    )
    np.testing.assert_array_equal(records.contact_steps.sum(axis=0), each.contact_steps.sum(axis=0))
    np.testing.assert_array_equal(records.gap.min(axis=0), each.gap.min(axis=0))


def pushed_out(limit: float) -> ContactProblem:
    """A free mass pushed towards a wall far away."""
    rotor = small_rotor(np.zeros(1), tip_radial=np.ones((1, 1)))
    load = Load(rotor=np.ones(1), casing=np.zeros(1))
    return problem(rotor, wall(1e6), loads=(load,), displacement_limit=limit)


def test_divergence_ends_in_order() -> None:
    """Stopped at the limit: the last record is the last state within it."""
    dt, limit = 1e-3, 0.05
    given = pushed_out(limit)
    timing = Timing(time_step=dt, duration=10.0, record_step=0.01)
    scheme = CentralDifference(given, dt, timing.record_every)
    results = list(march(scheme, timing))
    state, chunk, end = results[-1]
    assert end is EndReason.DIVERGENT
    # t^2 / 2 = 0.05 m at 0.3162 s
    assert chunk.step[-1] == state.step == 316
    position = chunk.rotor_displacement[:, 0]
    np.testing.assert_allclose(position, 0.5 * chunk.time**2, rtol=1e-9, atol=1e-12)
    assert position[-1] <= limit < 0.5 * 0.317**2
    np.testing.assert_allclose(chunk.rotor_velocity[:-1, 0], chunk.time[:-1], atol=1e-12)
    assert (np.diff(chunk.step) > 0).all()
    assert ledger_residual(chunk) < 1e-10


def test_divergence_on_a_record_step_writes_one_record() -> None:
    _, chunk, end = run(pushed_out(0.05), 1e-3, 1000, every=4)
    assert end is EndReason.DIVERGENT
    np.testing.assert_array_equal(chunk.step, np.arange(0, 317, 4))


@pytest.mark.parametrize("size", [1e9, 1e100])
@pytest.mark.parametrize("casing", [False, True])
def test_a_force_beyond_all_bounds_leaves_finite_records(size: float, casing: bool) -> None:
    base = stage_problem(5, 8)
    load = Load(
        rotor=size * base.rotor.tip_radial.sum(axis=0) * (not casing),
        casing=size * base.casing.nodal[0, 0] * casing,
    )
    _, chunk, end = run(replace(base, loads=(load,)), 0.9 * base.critical_time_step, 500)
    assert end is EndReason.DIVERGENT
    assert chunk.records >= 1
    assert (
        np.abs(chunk.rotor_displacement @ base.rotor.tip_radial.T).max() <= base.displacement_limit
    )
    for name in HISTORY:
        assert np.isfinite(getattr(chunk, name)).all(), name


def test_bending_of_the_blades_is_a_displacement_too() -> None:
    """Looked at every hundred steps only: it grows slowly."""
    rotor = small_rotor(np.zeros(1), tip_tangential=np.ones((1, 1)))
    load = Load(rotor=np.ones(1), casing=np.zeros(1))
    given = problem(rotor, wall(1.0), loads=(load,), displacement_limit=0.05)
    _, chunk, end = run(given, 1e-3, 1000, every=100)
    assert end is EndReason.DIVERGENT
    assert 316 <= chunk.step[-1] <= 416


def test_time_steps_at_or_above_the_critical_one_are_refused() -> None:
    given = driven()
    limit = given.critical_time_step
    assert limit == pytest.approx(2.0 / 700.0)
    for dt in (limit, 1.5 * limit, float("nan")):
        with pytest.raises(ValueError, match=r"at or above the critical step 0\.00286 s"):
            CentralDifference(given, dt, 1)
    stable = run(given, 0.999 * limit, 3000)[1]
    assert np.abs(stable.rotor_displacement).max() < 1.0
