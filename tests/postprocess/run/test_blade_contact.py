"""Contact over blade, casing and time: rubbing patterns by hand, and what maps must not lose."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.windows import late_part, select_window
from bladewhirl.postprocess.run.blade_contact import (
    contact_classes,
    contact_maps,
    contact_span,
    plot_forces,
    plot_gaps,
    share_limit,
)
from bladewhirl.postprocess.run.casing_contact import (
    all_and_last_turns,
    casing_contact,
    plot_casing_contact,
)
from bladewhirl.postprocess.run.contact_side import contact_phase, plot_contact_phase
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.sweep.digest import late_motion

STEPS = 1000  # a record, of the synthetic result


def rubbing(steps: NDArray[np.int64]) -> xr.Dataset:
    """A result whose blades touch for that many steps (record, blade) before each record."""
    result = synthetic.synthetic_result(records=len(steps), blades=steps.shape[1])
    result["contact_steps"] = ("time", "contact_node"), steps
    return result


class TestClasses:
    def test_permanent_intermittent_and_free_blades(self) -> None:
        steps = np.zeros((101, 22), dtype=np.int64)
        steps[1:, 0] = STEPS  # always
        steps[2::2, 1] = STEPS  # every other record
        steps[50, 2] = 1  # once, for one step
        classes = contact_classes(rubbing(steps))
        expected = ["permanent", "intermittent", "intermittent", *["free"] * 19]
        assert classes.contact_class.values.tolist() == expected
        np.testing.assert_allclose(classes.share[:4], [1.0, 0.5, 1e-5, 0.0], rtol=1e-12)


class TestMaps:
    @pytest.mark.parametrize("columns", [1, 7, 100, 1000])
    def test_spans_lose_neither_impulse_nor_the_smallest_gap(self, columns: int) -> None:
        result = synthetic.synthetic_result(shaft_radius=1.2e-3)
        maps = contact_maps(result, columns)
        assert maps.sizes["time"] == min(columns, 400)
        length = np.diff(maps.edge)[:, None]
        for name, impulse in (("force", "contact_impulse"), ("friction", "friction_impulse")):
            total = np.sum(length * maps[name].values, axis=0)
            np.testing.assert_allclose(total, result[impulse][1:].sum("time"), rtol=1e-9)
        np.testing.assert_array_equal(maps.gap.min("time"), result.gap[1:].min("time"))
        touched = (result.contact_steps[1:] > 0).any("time")
        np.testing.assert_array_equal((maps.share > 0).any("time"), touched)

    @pytest.mark.parametrize("columns", [3, 50, 100])
    def test_one_step_in_contact_is_no_span_of_contact(self, columns: int) -> None:
        steps = np.zeros((101, 22), dtype=np.int64)
        steps[50, 0], steps[1:, 1] = 1, STEPS
        share = contact_maps(rubbing(steps), columns).share
        assert 0.0 < share[:, 0].max() <= 1.0 / STEPS
        np.testing.assert_allclose(share[:, 1], 1.0, rtol=1e-12)

    @pytest.mark.parametrize("shaft_radius", [0.0, 1.5e-3])
    def test_maps_can_be_drawn_with_and_without_contact(self, shaft_radius: float) -> None:
        maps = contact_maps(synthetic.synthetic_result(shaft_radius=shaft_radius))
        gaps, forces = plot_gaps(maps), plot_forces(maps)
        assert "mm" in gaps.axes[-1].get_ylabel()
        assert len(gaps.axes) == (3 if shaft_radius else 2)  # no scale of contact without any
        assert "N]" in forces.axes[1].get_ylabel()
        for figure in (gaps, forces):
            assert figure.axes[0].get_ylim() == (-0.5, 21.5)


class TestPhase:
    @staticmethod
    def pressed(side: float, records: int = 401) -> xr.Dataset:
        """Rigid circle of the shaft, contact at that angle before it, shared by three blades."""
        result = synthetic.synthetic_result(records=records, bending=0.0, shaft_radius=0.8e-3)
        orbit = shaft_orbit(result)["rotating"].values
        at = np.arctan2(orbit[:, 1], orbit[:, 0]) - side
        apart = np.angle(np.exp(1j * (result.tip_angle.values - at[:, None])))
        push = np.clip(1.0 - np.abs(apart) / 0.6, 0.0, None)
        result["contact_impulse"] = ("time", "contact_node"), push
        result["gap"] = ("time", "contact_node"), 1e-3 * (1.0 - push)
        return result

    @pytest.mark.parametrize(
        ("side", "scenario"), [(0.0, "standard"), (0.4, "standard"), (np.pi, "inverted")]
    )
    def test_the_side_of_contact_gives_the_scenario(self, side: float, scenario: str) -> None:
        result = self.pressed(side)
        phases = contact_phase(result)
        assert phases.attrs["scenario"] == scenario
        lead = np.exp(1j * (phases.shaft_lead.values - side))
        # Mean direction of the contacts: better than the pitch of the blades, 0.29 rad.
        assert np.abs(np.angle(lead)).max() < 0.02
        assert phases.attrs["steadiness"] > 0.99

    def test_the_onset_counts_for_no_scenario_of_a_run_or_a_sweep(self) -> None:
        result, onset = self.pressed(0.4), self.pressed(np.pi)
        early = result["time"].values < 0.6 * result["time"].values[-1]
        for name in ("contact_impulse", "gap"):
            result[name][early] = onset[name].values[early]
        figure, phases = RunFigures(result).draw("contact-phase")
        late = late_part(result)
        of_sweep = late_motion(late, shaft_orbit(late))
        assert phases.attrs["scenario"] == of_sweep["scenario"] == "standard"
        assert phases.attrs["lead"] == of_sweep["shaft_lead"] == pytest.approx(0.4, abs=0.02)
        assert "standard contact, shaft ahead by 23°" in figure.axes[1].get_xlabel()
        assert phases["time"].values[0] == 0.0  # all of it is drawn
        end = result["time"].values[-1]
        early_phases = contact_phase(select_window(result, 0.0, 0.5 * end))
        assert early_phases.attrs["scenario"] == "inverted"

    def test_phases_are_those_of_the_static_circle(self) -> None:
        result = synthetic.synthetic_result()
        phases = contact_phase(result)
        turned = (synthetic.SPEED - 70.0) * result.time.values
        np.testing.assert_allclose(np.exp(1j * phases.shaft_phase), np.exp(1j * turned), atol=1e-12)

    def test_a_shaft_at_rest_has_no_phase(self) -> None:
        result = synthetic.synthetic_result(shaft_radius=0.0)
        phases = contact_phase(result)
        assert phases.attrs["scenario"] == "at rest"
        assert np.isnan(phases.shaft_phase).all()
        assert "at rest" in plot_contact_phase(phases).axes[1].get_xlabel()

    def test_equal_gaps_have_no_smallest(self) -> None:
        result = self.pressed(0.4)
        for name in ("contact_impulse", "gap"):
            result[name][:5] = result[name][:5] * 0.0
        result["gap"][:5] += 1e-3 + 1e-11 * np.arange(result.sizes["contact_node"])
        phases = contact_phase(result)
        for name in ("smallest_clearance_phase", "shaft_lead"):
            assert np.isnan(phases[name][:5]).all()
            assert phases[name][5:].notnull().all()


@pytest.mark.parametrize(
    ("touching", "limits"),
    [([], (0.0, 0.1)), ([3], (0.029, 0.041)), ([8, 9], (0.078, 0.1)), ([0, 9], (0.0, 0.1))],
)
def test_an_axis_of_time_follows_brief_contact(
    touching: list[int], limits: tuple[float, float]
) -> None:
    spans = np.isin(np.arange(10), touching)
    assert contact_span(np.linspace(0.0, 0.1, 11), spans) == pytest.approx(limits)


@pytest.mark.parametrize(
    ("shares", "limit"), [([0.0], 100.0), ([0.004, 0.07], 10.0), ([0.2], 20.0), ([0.4], 100.0)]
)
def test_a_scale_of_shares_follows_small_shares(shares: list[float], limit: float) -> None:
    assert share_limit(xr.DataArray(shares)) == pytest.approx(limit)


def rubbing_blade(speed: float) -> xr.Dataset:
    """A result whose first blade touches half of the time."""
    result = synthetic.synthetic_result(speed=speed)
    steps = np.zeros(result["gap"].shape, dtype=np.int64)
    steps[:, 0] = round(0.5 * result.attrs["record_step"] / result.attrs["time_step"])
    result["contact_steps"] = ("time", "contact_node"), steps
    return result


@pytest.mark.parametrize("speed", [200.0, -200.0])
def test_the_mark_of_one_blade_goes_round_with_the_rotor(speed: float) -> None:
    contact = casing_contact(rubbing_blade(speed))
    at = np.array([np.nanargmax(line) for line in contact.share.values])
    angle = (at + 0.5) * 2 * np.pi / contact.sizes["sector"]
    middle = (contact.time_edge.values[1:] + contact.time_edge.values[:-1]) / 2
    apart = np.angle(np.exp(1j * (angle - speed * middle)))
    assert np.abs(apart).max() < 2 * np.pi / 22
    assert np.nanmax(contact.share) == pytest.approx(0.5)


def test_at_rest_a_blade_rubs_its_own_sector() -> None:
    contact = casing_contact(rubbing_blade(0.0))
    share = contact.share.mean("time")
    assert share.sizes["sector"] == 22
    np.testing.assert_allclose(share, [0.5, *[0.0] * 21], rtol=1e-9, atol=1e-12)


def test_the_last_revolutions_of_a_long_run_are_drawn_apart() -> None:
    long = synthetic.synthetic_result(speed=200.0, records=601)  # 19 revolutions
    contact = all_and_last_turns(long)
    turned = 200.0 * np.ptp(contact["last_time_edge"].values) / (2 * np.pi)
    assert turned == pytest.approx(8.0, abs=0.05)
    assert len(plot_casing_contact(contact).axes) == 3
