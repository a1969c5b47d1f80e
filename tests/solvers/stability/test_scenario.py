"""Contact scenarios: where contact is and which whirl friction drives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.solvers.stability.scenario import (
    mode_scenario,
    motion_scenario,
    shaft_lead,
    smallest_clearance_angle,
)

TIME = np.linspace(0.0, 1.0, 400)


def whirl(rate: float, radius: float = 1e-3) -> FloatArray:
    return radius * np.column_stack([np.cos(rate * TIME), np.sin(rate * TIME)])


@given(turn=st.floats(-3.0, 3.0), share=st.floats(0.0, 0.99))
def test_contact_is_on_the_shafts_side_while_the_casing_moves_less(
    turn: float, share: float
) -> None:
    wave = np.exp(1j * turn)
    actual = mode_scenario(shaft=0.9 * wave, rotor=wave, casing=share * wave)
    assert actual.kind == "standard"
    assert actual.lead == pytest.approx(0.0, abs=1e-9)


@given(turn=st.floats(-3.0, 3.0), share=st.floats(1.01, 50.0))
def test_contact_is_opposite_when_the_casing_moves_more(turn: float, share: float) -> None:
    wave = np.exp(1j * turn)
    actual = mode_scenario(shaft=0.9 * wave, rotor=wave, casing=share * wave)
    assert actual.kind == "inverted"
    assert abs(actual.lead) == pytest.approx(np.pi)


def test_contact_is_opposite_when_the_tips_move_against_the_centre() -> None:
    actual = mode_scenario(shaft=1e-3, rotor=-2e-4, casing=0.0)
    assert actual.kind == "inverted"
    assert abs(actual.lead) == pytest.approx(np.pi)


def test_the_smallest_clearance_is_where_a_search_along_the_circle_finds_it() -> None:
    shaft, rotor, casing = 0.3 - 0.2j, 0.4 - 0.1j, -0.7 + 0.9j
    angle = np.linspace(-np.pi, np.pi, 100_001)
    gap = 2.0 + np.real((casing - rotor) * np.exp(-1j * angle))
    nearest = smallest_clearance_angle(gap[None], angle)[0]
    actual = mode_scenario(shaft=shaft, rotor=rotor, casing=casing)
    turned = np.angle(np.exp(1j * (np.angle(shaft) - nearest)))
    assert actual.lead == pytest.approx(turned, abs=1e-4)


@pytest.mark.parametrize(("offset", "kind"), [(0.0, "standard"), (np.pi, "inverted")])
@pytest.mark.parametrize("shift", [0.0, 0.3, -0.5])
@pytest.mark.parametrize("rate", [-40.0, 25.0])
def test_a_motion_is_told_apart_and_its_phase_shift_measured(
    offset: float, kind: str, shift: float, rate: float
) -> None:
    noise = 0.2 * np.random.default_rng(0).standard_normal(len(TIME))
    place = rate * TIME - offset - shift + noise - noise.mean()
    actual = motion_scenario(shaft=whirl(rate), clearance_angle=place)
    assert actual.kind == kind
    assert np.angle(np.exp(1j * (actual.lead - offset))) == pytest.approx(shift, abs=0.01)
    assert 0.9 < actual.steadiness < 1.0


def test_the_frame_does_not_matter() -> None:
    turned = 300.0 * TIME
    rotating = motion_scenario(shaft=whirl(-40.0), clearance_angle=-40.0 * TIME + 0.2)
    static = motion_scenario(shaft=whirl(260.0), clearance_angle=-40.0 * TIME + turned + 0.2)
    assert static.lead == pytest.approx(rotating.lead) == pytest.approx(-0.2)


def test_contact_all_round_has_no_scenario() -> None:
    actual = motion_scenario(shaft=whirl(40.0), clearance_angle=np.linspace(0.0, 200.0, 400))
    assert actual.kind == "unsteady"


def test_only_instants_with_weight_count() -> None:
    place = np.where(TIME < 0.5, 40.0 * TIME, 40.0 * TIME + np.pi)
    actual = motion_scenario(
        shaft=whirl(40.0), clearance_angle=place, weight=(TIME < 0.5).astype(float)
    )
    assert actual.kind == "standard"
    assert actual.steadiness == pytest.approx(1.0)


def test_a_shaft_at_rest_has_no_direction() -> None:
    still = whirl(40.0)
    still[:10] = 0.0
    lead = shaft_lead(still, 40.0 * TIME)
    assert np.isnan(lead[:10]).all()
    np.testing.assert_allclose(lead[10:], 0.0, atol=1e-9)
    assert motion_scenario(shaft=still, clearance_angle=40.0 * TIME).steadiness == pytest.approx(1)
    with pytest.raises(ValueError, match="does not move"):
        motion_scenario(shaft=np.zeros((5, 2)), clearance_angle=np.zeros(5))


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize(("lead", "kind"), [(0.45, "standard"), (-0.55, "inverted")])
def test_size_and_unit_do_not_matter(size: float, lead: float, kind: str) -> None:
    turn = np.exp(1j * np.pi * lead)
    of_mode = mode_scenario(shaft=1e-6 * size * turn, rotor=3.0 * size, casing=2.0 * size)
    of_motion = motion_scenario(
        shaft=whirl(40.0, size),
        clearance_angle=40.0 * TIME - np.pi * lead,
        weight=np.full(len(TIME), 1e-3 / len(TIME)),
    )
    for actual in (of_mode, of_motion):
        assert actual.kind == kind
        assert actual.steadiness == pytest.approx(1.0)
        assert actual.lead == pytest.approx(np.pi * lead)
    with pytest.raises(ValueError, match="shaft does not move"):
        mode_scenario(shaft=1e-10 * size, rotor=size, casing=0.0)
    with pytest.raises(ValueError, match="move by the same amount"):
        mode_scenario(shaft=size, rotor=size, casing=(1.0 + 1e-10) * size)


def test_modes_without_a_scenario_are_refused() -> None:
    with pytest.raises(ValueError, match="shaft does not move"):
        mode_scenario(shaft=0.0, rotor=1.0, casing=0.0)
    with pytest.raises(ValueError, match="move by the same amount"):
        mode_scenario(shaft=1.0, rotor=1.0, casing=1.0)
