"""The compiled march against the reference in plain NumPy, step for step, on all kinds of stage."""

from dataclasses import replace
from itertools import cycle, product
from typing import Literal

import numpy as np
import pytest
from contact_cases import assert_same, random_problem, run_as_reference, stage_problem, thrown
from kernel_fuzz import check
from long_cases import slow_except
from places import EXAMPLES
from reference_march import Reference

from bladewhirl.models.case.file import read_case
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import joined
from bladewhirl.solvers.packing import rotor

STAGES: dict[str, tuple[str, ...]] = {
    "casing distortion, clamped": ("casing_distortion",),
    "backward": ("casing_distortion", "contact.sliding=signed", "march.speed=-1.05"),
    "springs and truncated modes": ("coupled_modes",),
    "shroud": ("shrouded_fan",),
    "mistuned, with Coriolis forces": ("mistuned_blades", "rotation.effects=full"),
    "unequal bearings with dampers": ("unequal_bearings",),
}


@pytest.mark.parametrize(
    ("kind", "cyclic"),
    slow_except(product(STAGES, [True, False]), *zip(STAGES, cycle([True, False]), strict=False)),
)
def test_every_kind_of_stage_marches_as_the_reference(kind: str, cyclic: bool) -> None:
    name, *changes = STAGES[kind]
    base = contact_problem(build_beams(read_case(EXAMPLES / f"{name}.toml", changes)))
    given = thrown(base, 40.0, spread=0.5)  # they touch within the steps marched
    dt = min(1e-6, 0.5 * given.critical_time_step)
    assert cyclic or not any(CentralDifference(given, dt, 1, cyclic=False).cyclic)
    state, _ = run_as_reference(given, dt, 120, cyclic=cyclic)
    assert state.statistics.complementarity_residual < 1e-10


@pytest.mark.parametrize("blades", [16, 22])
@pytest.mark.parametrize("sliding", ["permanent", "signed"])
def test_tips_on_a_quarter_of_the_circle_march_as_the_reference(
    blades: int, sliding: Literal["permanent", "signed"], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the tips of rotors with many blades; here the rotors are smaller, to save time."""
    monkeypatch.setattr(rotor, "FOLDED", 6)
    given = replace(thrown(stage_problem(blades), 40.0, spread=0.5), sliding=sliding)
    folded = CentralDifference(given, 1e-6, 1)._rotor.fold
    assert len(folded) > blades
    state, chunk = run_as_reference(given, 1e-6, 120)
    assert chunk.contact_steps.any()
    assert state.statistics.complementarity_residual < 1e-10


# 61009: tips draw back, and no mode has nodal diameter 0. 40 further ones: .ci/run, with sanitizers
@pytest.mark.parametrize("number", slow_except([*range(20), 61009], *range(7), 61009))
def test_random_stages_march_as_the_reference(number: int) -> None:
    """With all that a march can have: Coriolis forces, dampers, springs, closures, coatings ..."""
    assert check(number)


@pytest.mark.parametrize("every", [1, 7])
def test_records_and_resuming_are_those_of_the_compiled_march(every: int) -> None:
    given, dt = random_problem(5), 1e-4
    fast, plain = CentralDifference(given, dt, every), Reference(given, dt, every)
    _, chunk, _ = fast.advance(fast.init(), 150)
    _, expected, _ = plain.advance(plain.init(), 150)
    assert_same(chunk, expected)
    middle, first, _ = plain.advance(plain.init(), 60)
    _, rest, _ = plain.advance(middle, 90)
    assert_same(joined([first, rest]), expected, 0.0)


def test_a_tip_at_whole_turns_is_under_the_node_that_it_is_at() -> None:
    """Rounding makes a turn whole a step before the tip's place does; the clearance is an ellipse.

    With 24,000 steps a revolution, as at 2500 rpm and 1 us, that is so after three of them.
    """
    case = read_case(EXAMPLES / "elliptical_clearance.toml", ["excitation={type='none'}"])
    dt, each = 1e-6, 24_000
    given = replace(contact_problem(build_beams(case)), speed=2.0 * np.pi / (each * dt))
    fast = CentralDifference(given, dt, 1)
    for turns in range(1, 60):
        before = replace(fast.init(), step=turns * each - 4)
        _, chunk, _ = fast.advance(before, 8)
        assert np.abs(np.diff(chunk.gap[1:], n=2, axis=0)).max() < 1e-9, f"{turns} turns"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_tip_near_a_node_of_the_casing_has_the_gap_of_the_reference(seed: int) -> None:
    """At speeds that are ratios of whole numbers, both ways, after up to thousands of revolutions.

    There rounding decides which element a tip is under; the wall must be the same either way.
    """
    case = read_case(EXAMPLES / "elliptical_clearance.toml", ["excitation={type='none'}"])
    base, dt = contact_problem(build_beams(case)), 1e-6
    tips, nodes, rng = (
        len(base.rotor.tip_radial),
        len(base.casing.nodal),
        np.random.default_rng(seed),
    )
    for _ in range(20):
        between = tips * int(rng.integers(1, 200))  # steps from node to node: tips stop on them
        way = rng.choice([-1.0, 1.0])
        given = replace(base, speed=way * 2.0 * np.pi / (nodes * between * dt))
        fast, plain = CentralDifference(given, dt, 1), Reference(given, dt, 1)
        turns = int(rng.integers(1, 2000))
        start = (turns * tips + int(rng.integers(tips))) * nodes * between // tips - 2
        _, chunk, _ = fast.advance(replace(fast.init(), step=start), 4)
        _, expected, _ = plain.advance(replace(plain.init(), step=start), 4)
        where = f"{way:+g} turns in {nodes * between} steps, from step {start}"
        np.testing.assert_allclose(chunk.gap, expected.gap, atol=1e-9, err_msg=where)
