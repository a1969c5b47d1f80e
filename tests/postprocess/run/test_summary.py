"""The summary of a run: ledger, regimes, contact, and what is written."""

import io
import json
import re
import tracemalloc
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from long_cases import slow_except
from numpy.typing import NDArray
from places import ROOT
from rich.console import Console

from bladewhirl.postprocess.energy.growth_rates import (
    Windows,
    fit_growth,
    longest_half_period,
    windowed_amplitude,
)
from bladewhirl.postprocess.energy.regimes import Regime, classify
from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.energy.works import drive_work
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.run.measures import MEASURES, energy_residual
from bladewhirl.postprocess.run.stresses import stress_history
from bladewhirl.postprocess.run.summary import Summary, summarise
from bladewhirl.postprocess.run.summary_table import (
    summary_rows,
    unsolved_share,
)
from bladewhirl.postprocess.run.wear import wear_summary
from bladewhirl.solvers.march.schema import CONVERGENCE, SUMMARY, SWEEP
from bladewhirl.studies.runs.columns import facts

Array = NDArray[np.float64]


@pytest.fixture
def result() -> xr.Dataset:
    """A shaft that whirls in a circle of 0.8 mm; tips touch."""
    return synthetic.synthetic_result()


class TestSummarise:
    def test_figures_of_the_closed_form_motion(self, result: xr.Dataset) -> None:
        summary = summarise(result, synthetic.REPORT)
        assert summary.end_time == pytest.approx(0.4)
        assert summary.shaft_radius_max == pytest.approx(0.8e-3)
        assert summary.shaft_radius_final == pytest.approx(0.8e-3)
        held = summary.strain_energy_final
        assert held is not None
        assert held["suspension"] == pytest.approx(0.5 * (190 * 0.8e-3) ** 2)
        assert held["1F"] == {"1": pytest.approx(0.5 * (75 * 0.3e-3) ** 2)}
        assert held["rest"] == pytest.approx(0.5 * (400 * 1e-4 * np.sin(40 * 0.4)) ** 2)
        rest = 0.5 * (400 * 1e-4) ** 2  # a quarter of a turn at 40 rad/s comes within the run
        peak = held["suspension"] + held["1F"]["1"] + rest
        assert summary.strain_energy_max == pytest.approx(peak, rel=1e-3)

    def test_the_whirl_is_in_net_turns_a_second(self, result: xr.Dataset) -> None:
        summary = summarise(result, synthetic.REPORT)
        rotating, carried = -70.0 / (2 * np.pi), synthetic.SPEED / (2 * np.pi)
        assert summary.whirl_frequency_rotating == pytest.approx(rotating)
        assert summary.whirl_frequency_static == pytest.approx(rotating + carried)
        (line,) = summary.whirl_lines
        assert line["rotating"] == pytest.approx(rotating, abs=0.05)
        assert line["static"] - line["rotating"] == pytest.approx(carried)
        assert line["share"] == pytest.approx(1.0, abs=1e-3)

    def test_contact_share_counts_steps_of_each_blade(self, result: xr.Dataset) -> None:
        steps = np.zeros((401, 22), dtype=np.int64)
        steps[10, 3], steps[20, 3], steps[400, 21] = 250, 150, 400_000
        result["contact_steps"] = ("time", "contact_node"), steps
        share = summarise(result, synthetic.REPORT).contact_share
        assert share[3] == 1e-3
        assert share[21] == 1.0
        assert sum(share) == pytest.approx(1.001)

    def test_penetration_is_the_deepest_gap_below_zero(self, result: xr.Dataset) -> None:
        assert summarise(result, synthetic.REPORT).gap_violation_max == 0.0
        result["gap"][17, 4] = -2e-9
        result["gap"][18, 5] = -1e-9
        assert summarise(result, synthetic.REPORT).gap_violation_max == 2e-9

    @pytest.mark.parametrize("records", [1, 2, 3, 10])
    def test_runs_of_few_records_say_what_they_can(self, records: int) -> None:
        short = synthetic.synthetic_result(records=records)
        summary = summarise(
            short, synthetic.REPORT | {"steps": 0 if records == 1 else 1000 * (records - 1)}
        )
        assert summary.regime in ("no-contact", "sustained")
        judged = "too few records or periods" in summary.regime_criterion
        assert judged == (summary.regime == "sustained")  # without contact nothing is judged
        assert summary_rows(summary)["regime"] in ("no-contact", "contact up to the end")

    @pytest.mark.parametrize(
        ("line", "share", "expected"),
        [
            (0.0022, 1.0, "none, the displacement is constant"),
            (0.0022, 0.4, "no single whirl frequency; strongest lines 40% at 0.0022 Hz"),
            (22.0, 1.0, "no single whirl frequency; strongest lines 100% at 22 Hz"),
        ],
    )
    def test_a_displacement_that_turns_with_the_rotor_is_constant(
        self, result: xr.Dataset, line: float, share: float, expected: str
    ) -> None:
        summary = replace(
            summarise(result, synthetic.REPORT),
            end_time=1.0,
            whirl_frequency_rotating=None,
            whirl_lines=[{"rotating": line, "static": line + 40.0, "share": share}],
        )
        assert summary_rows(summary)["whirl, rotating frame"] == expected
        json.loads(summary.to_json())

    @pytest.mark.slow
    def test_a_long_run_is_read_without_holding_its_histories(self, tmp_path: Path) -> None:
        records, modes = 15_000, 156
        rng = np.random.default_rng(7)
        motion = rng.standard_normal((records, modes))
        file = tmp_path / "result.nc"
        small = synthetic.synthetic_result(records=records)
        kept = [name for name in small.variables if "rotor_mode" not in small[name].dims]
        big = small[kept].assign(
            rotor_displacement=(("time", "rotor_mode"), motion),
            rotor_velocity=(("time", "rotor_mode"), motion),
            rotor_frequency=("rotor_mode", np.linspace(1.0, 9.0, modes)),
            rotor_backward_frequency=("rotor_mode", np.linspace(1.0, 9.0, modes)),
            rotor_forward_frequency=("rotor_mode", np.linspace(1.0, 9.0, modes)),
            rotor_nodal_diameter=("rotor_mode", np.arange(modes) // 2 % 12),
            rotor_spring_share=("rotor_mode", np.zeros(modes)),
            rotor_family=("rotor_mode", np.array(["1F"] * 22 + ["2F"] * 134, dtype=object)),
            rotor_shape=(("rotor_node", "rotor_component", "rotor_mode"), np.ones((111, 3, modes))),
            centre_shape=(("axis", "rotor_mode"), np.ones((2, modes))),
        )
        big.to_netcdf(file, engine="h5netcdf")
        with open_result(file) as result:
            tracemalloc.start()
            summary = summarise(result, synthetic.REPORT)
            _, peak = tracemalloc.get_traced_memory()
            tracemalloc.stop()
        total = 0.5 * motion**2 @ np.linspace(1.0, 9.0, modes) ** 2
        assert summary.strain_energy_max == pytest.approx(total.max(), rel=1e-12)
        radius = np.sqrt(2) * np.abs(motion.sum(axis=1))
        assert summary.shaft_radius_max == pytest.approx(radius.max(), rel=1e-12)
        assert peak < 2 * motion.nbytes  # two histories of 18.7 MB, plus tips and energies


WORKS = ("external_work", "normal_work", "friction_work", "coupling_work")


class TestEnergyLedger:
    def test_closes_to_rounding(self, result: xr.Dataset) -> None:
        assert energy_residual(result) < 1e-14

    @pytest.mark.parametrize("term", [*WORKS, "energy"])
    def test_finds_an_error_planted_in_a_term(self, result: xr.Dataset, term: str) -> None:
        names = ["energy", "damping_work", *WORKS]
        largest = max(float(np.abs(result[name]).max()) for name in names)
        result[term][137] += 1e-6 * largest
        assert energy_residual(result) == pytest.approx(1e-6, rel=1e-4)


END = 3.0
TIME = np.linspace(0.0, END, 3001)
FREQUENCY = 75.0  # lowest of the synthetic rotor [rad/s]


def judged(amplitude: Array, *, contact: slice | None = None, standing: bool = False) -> Regime:
    """Regime of a history whose strain energy is that amplitude squared; `contact` says when."""
    result = synthetic.synthetic_result(records=len(TIME))
    steps = np.zeros((len(TIME), 22), dtype=np.int64)
    if contact is not None:
        steps[contact, 5] = 3
    result["contact_steps"] = ("time", "contact_node"), steps
    wave = np.cos(FREQUENCY * TIME) if standing else 1.0
    return classify(result, (amplitude * wave) ** 2)


def wander(rng: np.random.Generator, correlation: float, size: float) -> Array:
    """Noise of that correlation time [s] and standard deviation."""
    steps = 600
    keep = np.exp(-END / steps / correlation)
    kicks = rng.standard_normal(steps)
    state = [kicks[0]]
    for kick in kicks[1:]:
        state.append(keep * state[-1] + np.sqrt(1 - keep**2) * kick)
    values: Array = size * np.interp(TIME, np.linspace(0, END, steps), state)
    return values


def _ended_at_the_limit(duration: float, unloaded: float) -> tuple[xr.Dataset, Array]:
    """A march that grew at 12/s under its load, then at 6/s, and its amplitude."""
    records = int(duration / 1e-3) + 1
    result = synthetic.synthetic_result(records=records)
    time = np.linspace(0.0, duration, records)
    work = np.minimum(time, duration - unloaded)
    result = result.assign_coords(time=time).assign(external_work=("time", work))
    result.attrs |= {
        "end_reason": "divergent",
        "end_message": "a tip moved by 21 mm; look at its load",
    }
    return result, np.exp(6.0 * time + 6.0 * work)


def _windows(level: Array) -> Windows:
    """Equal windows of 10 ms, all of them to be fitted, of that logarithm of the amplitude."""
    return Windows(
        begin=np.arange(0.0, 0.01 * len(level) - 0.005, 0.01),
        length=0.01,
        amplitude=np.exp(level),
        late=0,
        is_third=True,
    )


ALWAYS = slice(0, None)
PHASES = np.linspace(0, 2 * np.pi, 12, endpoint=False)


class TestRegimes:
    @pytest.mark.parametrize("rate", [0.2, 1.0, 4.0])
    @pytest.mark.parametrize("standing", [False, True])
    def test_exponential_growth_diverges_at_its_rate(self, rate: float, standing: bool) -> None:
        regime = judged(np.exp(rate * (TIME - END)), contact=ALWAYS, standing=standing)
        assert regime.name == "divergent"
        assert regime.growth is not None
        assert regime.growth.rate == pytest.approx(rate, abs=0.03)

    def test_the_displacement_limit_is_divergence_however_short_the_run(self) -> None:
        result = synthetic.synthetic_result(records=3)
        result.attrs |= {"end_reason": "divergent", "end_message": "a tip moved by 21 mm at 0.4 s"}
        regime = classify(result, np.ones(3))
        assert regime.name == "divergent"
        assert regime.reason.startswith(
            "a tip moved by 21 mm at 0.4 s; most energy came from the load"
        )

    @pytest.mark.parametrize(
        ("contact", "name"),
        [(None, "no-contact"), (slice(0, 2700), "damped"), (ALWAYS, "sustained")],
    )
    def test_a_steady_orbit_with_ripple_does_not_diverge(
        self, contact: slice | None, name: str
    ) -> None:
        for phase in PHASES:
            amplitude = 1 + 0.1 * np.cos(FREQUENCY * TIME + phase)
            assert judged(amplitude, contact=contact).name == name

    @pytest.mark.parametrize("period", [0.05, 0.2, 0.4, 0.7, 1.0, 1.3, 1.7, 1.9])
    @pytest.mark.parametrize("depth", slow_except([0.3, 1.0], 1.0))
    def test_beating_does_not_diverge(self, period: float, depth: float) -> None:
        for phase in PHASES:
            beat = 1 + depth * np.cos(2 * np.pi * TIME / period + phase)
            assert judged(beat, contact=ALWAYS).name == "sustained"

    @pytest.mark.slow
    def test_chaos_about_a_steady_amplitude_rarely_looks_divergent(self) -> None:
        rng = np.random.default_rng(11)
        actual = [judged(np.exp(wander(rng, 0.05, 0.3)), contact=ALWAYS).name for _ in range(60)]
        assert actual.count("divergent") <= 2

    @pytest.mark.parametrize(
        "amplitude",
        [
            *(1 - np.exp(-TIME / delay) for delay in (0.1, 0.3, 1.0)),  # a load that settles
            0.5 * (1 - np.cos(np.pi * TIME / END)),  # a ramp
            *(1 / (1 + np.exp(-8 * (TIME - half))) for half in (1.2, 1.8, 2.4)),  # limit cycles
        ],
    )
    def test_growth_that_slows_is_sustained(self, amplitude: Array) -> None:
        assert judged(amplitude, contact=ALWAYS).name == "sustained"

    def test_a_decaying_motion_is_damped_or_sustained_by_its_contact(self) -> None:
        rng = np.random.default_rng(5)
        for noise in (0.0, 0.2):
            amplitude = np.exp(-TIME + wander(rng, 0.1, noise))
            assert judged(amplitude, contact=slice(0, 900)).name == "damped"
            assert judged(amplitude, contact=ALWAYS).name == "sustained"
            assert judged(amplitude).name == "no-contact"

    def test_growth_too_small_to_matter(self) -> None:
        result = synthetic.synthetic_result(records=len(TIME))
        result["contact_steps"] = 0 * result["contact_steps"]
        energy = np.exp(2 * TIME)
        result["gap"] = (
            ("time", "contact_node"),
            np.full((len(TIME), 22), 0.995 * synthetic.CLEARANCE),
        )
        assert classify(result, energy).name == "no-contact"
        result["gap"][2500, 3] = 0.98 * synthetic.CLEARANCE
        assert classify(result, energy).name == "divergent"

    def test_damped_needs_a_last_tenth_without_contact(self) -> None:
        steady = np.ones(len(TIME))
        assert judged(steady, contact=slice(100, 2701)).name == "damped"
        assert judged(steady, contact=slice(2701, 2702)).name == "sustained"

    @pytest.mark.parametrize(
        ("frequency", "half_period"),
        [([190.0, 75.0], np.pi / 75.0), ([1e-5, 75.0], np.pi / 75.0), ([0.0, 0.0], np.inf)],
    )
    def test_rigid_modes_set_no_period(self, frequency: list[float], half_period: float) -> None:
        ways = ("rotor_backward_frequency", "rotor_forward_frequency")
        stage = xr.Dataset({way: ("rotor_mode", frequency) for way in ways})
        assert longest_half_period(stage) == pytest.approx(half_period)

    def test_too_few_periods_or_records_are_not_judged(self) -> None:
        few_periods = TIME[TIME < 0.9]
        assert windowed_amplitude(few_periods, np.exp(few_periods), np.pi / FREQUENCY) is None
        few_records = TIME[::40]
        assert windowed_amplitude(few_records, np.exp(few_records), np.pi / FREQUENCY) is None

    @pytest.mark.parametrize(
        ("unloaded", "windows"), [(6.4, 6), (11.0, 8), (2.0, 8)], ids=["since", "last", "loaded"]
    )
    def test_a_march_ended_at_its_limit_has_a_rate_from_its_last_windows(
        self, unloaded: float, windows: int
    ) -> None:
        period = np.pi / FREQUENCY
        result, amplitude = _ended_at_the_limit(18.3 * period, unloaded * period)
        regime = classify(result, amplitude**2)
        assert regime.name == "divergent"
        assert regime.growth is not None
        end, begin = result["time"].values[-1], result["time"].values[-1] - windows * period
        assert regime.growth.span == f"{begin:.3g} to {end:.3g} s"
        assert regime.reason.startswith("a tip moved by 21 mm; growth rate of the amplitude ")
        assert regime.growth.span in regime.reason
        if unloaded > 6:
            assert regime.growth.rate == pytest.approx(6.0, rel=1e-2)
        else:  # the load, which drives it faster, is in it
            assert regime.growth.rate > 7.0
        result.attrs["end_reason"] = "completed"
        assert classify(result, amplitude**2).growth is None

    def test_what_left_all_numbers_has_no_rate(self) -> None:
        period = np.pi / FREQUENCY
        result, amplitude = _ended_at_the_limit(18.3 * period, 18.3 * period)
        amplitude[-1] = np.inf
        regime = classify(result, amplitude**2)
        assert (regime.name, regime.growth) == ("divergent", None)
        assert regime.reason == "a tip moved by 21 mm"

    @pytest.mark.parametrize(
        ("correlation", "count", "least", "most"),
        [(0.0, 12, 0.8, 1.25), (0.6, 400, 0.9, 1.2), (0.6, 12, 1.0, 2.2)],
    )
    def test_the_error_holds_for_correlated_windows(
        self, correlation: float, count: int, least: float, most: float
    ) -> None:
        rng = np.random.default_rng(8)
        pulls, plain = [], []
        for _ in range(400):
            misfit = np.empty(count)
            misfit[0] = rng.standard_normal()
            for n in range(1, count):
                misfit[n] = correlation * misfit[n - 1]
                misfit[n] += np.sqrt(1 - correlation**2) * rng.standard_normal()
            growth = fit_growth(_windows(0.1 * misfit + 1.5 * 0.01 * np.arange(count)))
            pulls.append((growth.rate - 1.5) / growth.error)
            place = 0.01 * (np.arange(count) - (count - 1) / 2)
            rest = 0.1 * (misfit - misfit.mean()) - (growth.rate - 1.5) * place
            naive = np.sqrt(rest @ rest / (count - 2) / (place @ place))
            assert growth.error >= naive * (1 - 1e-12)
            plain.append((growth.rate - 1.5) / naive)
        spread = np.sqrt(np.mean(np.square(pulls)))
        assert least < spread < most
        if correlation:
            assert np.sqrt(np.mean(np.square(plain))) > 1.1 * spread

    @pytest.mark.parametrize(
        ("ripple", "regime"), [(1.3, "divergent"), (0.0, "sustained"), (-0.5, "sustained")]
    )
    def test_a_ripple_that_grows_on_a_steady_orbit_is_divergence(
        self, ripple: float, regime: str
    ) -> None:
        """The shaft stays displaced by 1.2 mm, its ripple ends at 0.1 mm."""
        result = synthetic.synthetic_result(records=4501, bending=0.0, shaft_radius=0.0)
        time = result["time"].values
        motion = np.zeros((len(time), 5))
        size = 1e-4 * np.exp(ripple * (time - time[-1]))
        motion[:, 0] = 1.2e-3 + size * np.cos(75.0 * time)
        motion[:, 1] = size * np.sin(75.0 * time)
        result["rotor_displacement"] = ("time", "rotor_mode"), motion
        result["contact_steps"] = xr.full_like(result["contact_steps"], 10)
        actual = classify(result, strain_energies(result)["total"].values)
        assert actual.name == regime
        assert actual.growth is not None
        assert actual.ripple is not None
        assert actual.ripple.rate == pytest.approx(ripple, abs=0.05)
        assert abs(actual.growth.rate) < 0.1
        assert actual.ripple.residual < 0.05
        assert "growth rate of the motion about its mean position" in actual.reason

    def test_a_curved_record_has_its_rate_at_the_end_and_a_misfit(self) -> None:
        """The logarithm goes as the square of time: its slope doubles from middle to end."""
        begin, length = 0.1 * np.arange(36, dtype=np.float64), 0.1
        middle = begin + 0.05
        windows = Windows(
            begin=begin, length=length, amplitude=np.exp(middle**2), late=24, is_third=True
        )
        growth = fit_growth(windows)
        assert growth.rate == pytest.approx(2 * middle[24:].mean())
        assert growth.end_rate == pytest.approx(2 * middle[-3])
        assert growth.residual == pytest.approx(np.std((middle[24:] - middle[24:].mean()) ** 2))
        assert f"{growth.end_rate:.3g} ±" in growth.sentence


WORN = xr.Dataset(
    {
        "coating_strain": (("wear_time", "track", "rod"), np.array([[[0.0, 0.1]]])),
        **{name: ("time", np.ones(1)) for name in ("wear_volume", "wear_dissipated")},
        "coating_impulse": (("time", "contact_node"), np.ones((1, 2))),
        "contact_impulse": (("time", "contact_node"), np.ones((1, 2))),
        "rod_angle": ("rod", [0.0, np.pi]),
        "wall_angle": ("wall_angle", [0.0]),
        "clearance": ("wall_angle", [1e-3]),
    },
    coords={"time": [0.0]},
    attrs={
        "case": "[casing.coating]\nthickness = 1e-3\nyoung_modulus = 1e9\nyield_stress = 1e6",
        "time_step": 1e-6,
    },
)
"""Variables of a result with a coating that its summary needs."""


def test_every_measure_has_one_row_in_the_registry() -> None:
    """Names, units and meanings of the summary, of sweeps and of convergence are in one table."""
    assert {*SUMMARY} == {field.name for field in fields(Summary)}
    assert MEASURES.keys() <= SUMMARY.keys() | SWEEP.keys()
    for name in CONVERGENCE.keys() & SUMMARY.keys():
        assert CONVERGENCE[name] == SUMMARY[name]
    for name, variable in {**SUMMARY, **CONVERGENCE}.items():
        assert variable.long_name, name
        assert variable.units or variable.kind in ("str", "table"), name


class TestWriting:
    def test_json_is_at_full_precision(self, result: xr.Dataset) -> None:
        summary = summarise(result, synthetic.REPORT)
        document = json.loads(summary.to_json())
        assert document["growth_rate"] is None  # too short a history
        assert document.keys() >= synthetic.REPORT.keys()
        assert Summary(**document) == summary
        assert set(document["strain_energy_final"]) == {"suspension", "1F", "rest"}

    def test_the_table_reads_in_handy_units(self, result: xr.Dataset) -> None:
        text = io.StringIO()
        summary = summarise(result, synthetic.REPORT)
        Console(file=text, width=100).print(facts(summary_rows(summary)))
        shown = text.getvalue()
        for line in ("0.8 mm", "of 22", "1F, k = 1", "up to the end", "4.38 µs a step"):
            assert line in shown

    def test_the_yield_strength_is_compared(self, result: xr.Dataset) -> None:
        assert "yield" not in str(summary_rows(summarise(result, synthetic.REPORT)))
        weak = summary_rows(summarise(result.assign_attrs(yield_strength=1e3), synthetic.REPORT))
        assert weak["stress of casing, largest"].endswith("beyond the yield strength, 1 kPa")

    def test_a_drive_without_known_work_has_the_power_of_friction(self, result: xr.Dataset) -> None:
        known, closing = summarise(result, synthetic.REPORT), result["closing_work"]
        unknown = summarise(result.assign(closing_work=np.nan * closing), synthetic.REPORT)
        assert unknown.drive_power is None
        # Without work of the normal forces it is that of the drive.
        assert unknown.friction_power == pytest.approx(known.drive_power)
        assert unknown.friction_torque == pytest.approx(known.drive_torque)
        name = "drive against friction, last third"
        assert name in summary_rows(unknown)
        assert name not in summary_rows(known)
        coated = result.assign(coating_impulse=result["contact_impulse"])
        assert np.isnan(drive_work(coated)).all()

    def test_the_stress_is_split_into_mean_and_alternating(self, result: xr.Dataset) -> None:
        split = summarise(result, synthetic.REPORT).stress_split
        assert split is not None
        history = stress_history(result).sel(member=split["member"])
        assert split["mean"] == pytest.approx(float(history["mean_stress"]))
        assert split["alternating"] == pytest.approx(float(history["alternating_stress"]))
        limits = {"endurance": 1e8, "strength": 1e9}
        limited = summarise(result.assign_attrs(limits), synthetic.REPORT)
        assert "margin against fatigue" in summary_rows(limited)["  mean and alternating"]
        assert (
            "margin"
            not in summary_rows(summarise(result, synthetic.REPORT))["  mean and alternating"]
        )

    def test_numbers_of_unsolved_steps_are_marked(self, result: xr.Dataset) -> None:
        assert "unsolved" not in str(summary_rows(summarise(result, synthetic.REPORT)))
        total = float(result["contact_impulse"].sum())
        doubtful = result.assign_attrs(unsolved_time=0.125, unsolved_impulse=0.25 * total)
        summary = summarise(doubtful, synthetic.REPORT)
        assert summary.unsolved_impulse_share == pytest.approx(0.25)
        rows = summary_rows(summary)
        assert rows["contact force, largest"].endswith("(unsolved steps have 0.25 of it)")
        assert "first at 0.125 s" in unsolved_share(summary)

    def test_the_page_of_the_summary_has_every_key_and_every_row(self, result: xr.Dataset) -> None:
        page = (ROOT / "docs" / "reference" / "summary.md").read_text(encoding="utf-8")
        rows = [line.split("|")[1:-1:2] for line in page.splitlines() if line.startswith("|")]
        labels = "; ".join(label.strip() for label, _ in rows)
        messages = set(re.findall(r"`(\w+)", "".join(keys for _, keys in rows[2:])))
        summary = summarise(result, synthetic.REPORT)
        assert messages == json.loads(summary.to_json()).keys() | wear_summary(WORN).keys()
        printed = summary_rows(summary)
        assert printed["steps"].endswith("largest values are of records, every 1 ms")
        assert [
            name for name in printed if name.strip().removesuffix(", largest") not in labels
        ] == []
