"""Marches with springs between rotor and casing: Eqs (8)-(10), against plain NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from contact_cases import ledger_residual, run, run_as_reference, thrown
from faults import faults
from stages import stage

from bladewhirl.models.case.case import Case
from bladewhirl.models.coupling.springs import CoupledEntries, CouplingModes
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.ring import flexible_ring
from bladewhirl.models.stage.superelement_springs import coupling_springs

COARSE = ("reduction.fixed_interface_modes=22", "casing.elements=20")
POINT = ("march.speed=1.17", "coupling.stiffness=500")
"""The paper's example point: Figs 11 and 14."""


def problem(*overrides: str) -> ContactProblem:
    """A coarse stage on the soft support of the modal work."""
    return contact_problem(stage(*COARSE, *POINT, *overrides))


def held(*overrides: str) -> CoupledEntries:
    """The modes that the springs of the stage couple."""
    coupled = stage(*COARSE, *POINT, *overrides).kept.coupled
    assert coupled is not None
    return coupled


def sideways(given: ContactProblem, speed: float = 10.0) -> ContactProblem:
    """The same stage, its shaft thrown at the casing with that speed [m/s]."""
    return thrown(given, speed * np.cos(given.rotor.tip_angle - 0.1))


STRONG = "coupling.stiffness=2e6"
"""Stiff enough to decide the motion within milliseconds."""


@pytest.mark.parametrize(
    ("kept", "coupled", "speed", "options"),
    [
        pytest.param(
            "six",
            "six",
            10.0,
            ("initial.centre_displacement=[2e-4, 1e-4]",),
            marks=pytest.mark.slow,
        ),
        ("six", "1F,casing", 10.0, ("coupling.pi=false",)),
        ("*:0,*:1,1F,casing", "all", 10.0, ("coupling.stiffness=2e4",)),
        ("six", "six", 20.0, ("coupling.amplitude=physical", "coupling.stiffness=1e8")),
    ],
)
def test_marches_as_written_out(
    kept: str, coupled: str, speed: float, options: tuple[str, ...]
) -> None:
    """Springs, contact, friction and the five terms of the energy against a plain march."""
    chosen = (
        STRONG,
        "bladed_disk.blades=6",
        f"reduction.modes={kept}",
        f"coupling.modes={coupled}",
        *options,
    )
    given = sideways(problem(*chosen), speed)
    dt, steps = min(1e-5, 0.5 * given.critical_time_step), 300
    state, chunk = run_as_reference(given, dt, steps)
    without = run(replace(given, springs=None), dt, steps)[1]
    change = np.abs(without.rotor_displacement - chunk.rotor_displacement).max()
    assert change > 1e-3 * np.abs(chunk.rotor_displacement).max()
    assert ledger_residual(chunk) < 1e-10
    assert state.statistics.complementarity_residual < 1e-10


@pytest.mark.slow
def test_a_single_mode_on_springs_marches_as_written_out() -> None:
    """A mode without partner does not turn: K* then pulsates, and its frequencies with it."""
    given = sideways(problem("reduction.modes=six", "bladed_disk.blades=6"))
    modes = CouplingModes(
        name=("pair", "single"),
        on_casing=np.array([True, False]),
        nodal_diameter=np.array([3, 3]),
        frequency=np.array([given.casing.frequency[0], given.rotor.frequency[2]]),
        amplitude=np.array([0.6, -0.3]),
        damping_ratio=np.zeros(2),
        paired=np.array([True, False]),
    )
    sizes = len(given.rotor.frequency), len(given.casing.frequency)
    springs = CoupledEntries(modes=modes, number=np.array([0, 2])).springs(2e6, *sizes)
    given = replace(given, springs=springs)
    run_as_reference(given, 1e-5, 400)
    angles = np.linspace(0.0, 2.0 * np.pi / 3.0, 40)
    squares = given.rotor.stiffness, given.casing.frequency**2
    whole = np.diag(np.concatenate(squares)[springs.places]) + springs.stiffness(angle=angles)
    highest = np.sqrt(np.linalg.eigvalsh(whole)[:, -1])
    assert highest == pytest.approx(springs.highest_frequency(*squares), rel=1e-9)


@pytest.mark.parametrize("size", [0.05, 2.0])  # most of the motion in the casing, or in the blades
def test_springs_of_blades_with_any_modes_have_one_highest_frequency(size: float) -> None:
    """The stiffest motion of both bodies on springs that are stiffer than the bodies."""
    tables = {"casing": {"elements": 12}, "coupling": {"stiffness": 1e13}}
    case, random = Case.model_validate(tables), np.random.default_rng(6)
    ring, outward = flexible_ring(case), size * random.normal(size=(4, 9))
    rotor, angle = random.uniform(0.0, 3e3, 9), 0.5 * np.pi * np.arange(4.0)
    springs = coupling_springs(case, outward, angle, ring)
    squares = rotor**2, ring.reduced_casing.frequency**2
    whole = np.diag(np.concatenate(squares)[springs.places])
    whole = whole + springs.stiffness(angle=np.linspace(0.0, 6.0, 40))
    highest = np.sqrt(np.linalg.eigvalsh(whole)[:, -1])
    assert highest == pytest.approx(springs.highest_frequency(*squares), rel=1e-9)


def test_amplitudes_are_those_of_tips_and_casing() -> None:
    chosen = "coupling.modes=all", "coupling.amplitude=physical"
    given, coupled = problem(*chosen), held(*chosen)
    modes = coupled.modes
    assert modes.entries > 20
    angle = 2.0 * np.pi * np.arange(20) / 20
    for entry, number in enumerate(coupled.number):
        k, a = modes.nodal_diameter[entry], modes.amplitude[entry]
        pair = [number, number + 1]
        if modes.on_casing[entry]:
            field, at = given.casing.nodal[:, 0, pair], angle
        else:
            field, at = given.rotor.tip_radial[:, pair], given.rotor.tip_angle
        assert field[:, 0] == pytest.approx(a * np.cos(k * at), abs=1e-6 * abs(a))
        if modes.paired[entry]:
            assert field[:, 1] == pytest.approx(a * np.sin(k * at), abs=1e-6 * abs(a))


def test_unit_amplitudes_keep_their_phase() -> None:
    paper = held("coupling.modes=all").modes.amplitude
    physical = held("coupling.modes=all", "coupling.amplitude=physical").modes.amplitude
    np.testing.assert_array_equal(paper, np.sign(physical))


@pytest.mark.parametrize("modes", ["six", "1F:1,suspension,casing:1,1F:11,casing:0,2F:0"])
def test_the_critical_step_is_that_of_the_coupled_bodies(modes: str) -> None:
    given = sideways(
        problem(f"reduction.modes={modes}", "coupling.modes=all", "coupling.stiffness=1e9"), 1e-3
    )
    alone = replace(given, springs=None).critical_time_step
    highest = max(
        np.linalg.eigvalsh(
            np.diag(np.concatenate([given.rotor.frequency, given.casing.frequency]) ** 2)
            + given.spring_stiffness(given.speed * time)
        )[-1]
        for time in np.linspace(0.0, 2.0 * np.pi / given.speed, 12)
    )
    critical = given.critical_time_step
    assert critical < 0.9 * alone
    assert critical == pytest.approx(2.0 / np.sqrt(highest), rel=1e-6)
    _, chunk, end = run(given, 0.999 * critical, 2000, every=100)
    assert end is None
    assert ledger_residual(chunk) < 1e-8


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (("coupling.modes=suspention",), "did you mean suspension?"),
        (
            ("coupling.modes=2F", "reduction.modes=six"),
            "modes that are coupled by springs and are also kept",
        ),
        (("shaft.clamped=true",), "coupling.modes"),
        (("march.time_step=1e-5", "coupling.stiffness=1e13"), "less than the critical step"),
    ],
)
def test_springs_that_make_no_sense(overrides: tuple[str, ...], expected: str) -> None:
    assert any(expected in line for line in faults(problem, *overrides))


@pytest.mark.parametrize("stiffness", [1e12, 1e30])
def test_springs_too_stiff_for_the_time_step_are_named(stiffness: float) -> None:
    """And those a little softer than the ones it names are marched."""
    [line] = faults(problem, f"coupling.stiffness={stiffness}")
    assert line.startswith(f"coupling.stiffness = {stiffness:.0e}".replace("+", ""))
    softer = float(line.partition("less than ")[2].partition(" N/m")[0])
    assert problem(f"coupling.stiffness={0.999 * softer}").critical_time_step > 1e-6
