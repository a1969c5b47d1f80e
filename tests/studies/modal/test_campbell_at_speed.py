"""Campbell diagrams and critical speeds of bladed disks with rotation effects."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import answer
from matplotlib.figure import Figure
from stages import oracle

import bladewhirl as bw
from bladewhirl.models.rotation.critical_speeds import ORDERS
from bladewhirl.models.stage.hints import stage_hints
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.postprocess.modal.campbell import Frame, plot_campbell
from bladewhirl.postprocess.modal.veering import plot_critical_speeds
from bladewhirl.studies.modal.campbell import campbell, coincidence_list
from bladewhirl.studies.modal.critical_speeds import critical_speeds
from bladewhirl.studies.modal.scenarios import CASING_SHARES, whirling_modes
from bladewhirl.studies.runs import figures_folder

SMALL = {"bladed_disk.blades": 8, "bladed_disk.elements_per_blade": 4, "shaft.stiffness": 1e7}

FRAMES: tuple[Frame, ...] = ("rotating", "static")

KNOWN = oracle("rotation")["stages"]["0.01"]


def stage_case(effects: str = "full") -> bw.Case:
    return bw.case_from(
        {
            "bladed_disk": {"disk": {"thickness": 0.01}},
            "rotation": {"effects": effects},
            "march": {"speed": 1.05},
        }
    )


@cache
def diagram(effects: str = "full") -> xr.Dataset:
    return campbell(stage_case(effects), families=2, speeds=(0.0, 2.5))


@pytest.mark.slow
def test_critical_speeds_and_engine_orders_are_listed() -> None:
    result = coincidence_list(diagram())
    (critical,) = result["critical_speeds"]
    assert critical["ratio"] == pytest.approx(KNOWN["critical_speed"], rel=1e-7)
    assert critical["rpm"] == pytest.approx(critical["ratio"] * 60.0 * KNOWN["reference_hz"])
    assert critical["spring_share"] > 0.5
    named = (critical["k"], critical["family"], critical["family_at_rest"])
    assert named == (1, "suspension", "1F")
    stiffness = stage_case().shaft.stiffness
    stiffer = campbell(
        bw.with_values(stage_case(), {"shaft.stiffness": 1.001 * stiffness}), speeds=(0.0, 2.5)
    )
    gained = (stiffer.critical_rpm.item() / critical["rpm"]) ** 2 - 1.0
    assert gained == pytest.approx(0.001 * critical["spring_share"], rel=1e-2)
    orders = {(row["k"], row["family"]): row["ratio"] for row in result["engine_orders"]}
    for row in KNOWN["engine_orders"]:
        assert orders[row["k"], "1F"] == pytest.approx(row["full"], rel=1e-7)
    assert result["clearance_gone"]["ratio"] == pytest.approx(KNOWN["growth_of_1mm"], rel=1e-7)


@pytest.mark.slow
def test_speeds_take_any_unit() -> None:
    case, same = bw.with_values(stage_case(), SMALL), small_diagram("full")
    hertz = same.attrs["reference_frequency_hz"]
    limits = ("0 rpm", f"{2.5 * 60.0 * hertz!r} rpm")
    result = campbell(case, families=1, speeds=limits, operating=(0.5, "50 Hz"))
    assert result.attrs["speeds"] == pytest.approx((0.0, 2.5))
    assert result.attrs["operating_range"] == pytest.approx((0.5, 50.0 / hertz))
    np.testing.assert_allclose(result.critical_speed, same.critical_speed)
    for wrong in (("0 mm", 1), (2.0, 1.0), (-1.0, 1.0), (float("nan"), 1.0)):
        with pytest.raises(bw.UserError, match=r"campbell: speeds \("):
            campbell(case, speeds=wrong)


@pytest.mark.slow
def test_branches_have_the_frequencies_of_the_stage_at_speed() -> None:
    result = diagram()
    for row in KNOWN["speeds"]:
        if row["ratio"] in (0.5, 2.5):  # which are among the speeds of the lines
            here = result.sel(line_speed=row["ratio"], method="nearest")
            for k in (2, 5):
                for way in ("backward", "forward"):
                    branch = (result.branch_nodal_diameter == k) & (result.branch_direction == way)
                    branch &= result.branch_family == "1F"
                    (frequency,) = np.abs(here.branch_frequency.values[branch.values])
                    assert frequency == pytest.approx(row[way][str(k)][0], rel=1e-7)
            growth = float(here.tip_growth)
            assert growth == pytest.approx(row["tip_growth_softened"], rel=1e-7)


def test_coincidences_lie_on_the_branches() -> None:
    """At k Omega - omega_c, later than at rest: tension stiffens the blades."""
    result, at_rest = diagram(), campbell(stage_case("none"), families=2)
    for family, k in (("1F", 1), ("1F", 2), ("1F", 4)):
        casing = "rigid" if k == 1 else "1F"
        one = result.sel(family=family, casing_family=casing, nodal_diameter=k)
        other = at_rest.sel(family=family, casing_family=casing, nodal_diameter=k)
        assert float(one.normalised_speed.item()) > float(other.normalised_speed.item()) * 1.01
        hertz = float(one.speed.item()) / 60.0
        met = k * hertz - float(one.casing_frequency.item())
        assert float(one.rotor_frequency.item()) == pytest.approx(met, rel=1e-12)
        branch = (result.branch_nodal_diameter == k) & (result.branch_direction == "backward")
        branch &= result.branch_family == family
        line = result.branch_frequency.values[branch.values][0]
        expected = np.interp(one.normalised_speed.item(), result.line_speed.values, line)
        assert met == pytest.approx(expected, rel=1e-3)


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


@cache
def small_diagram(effects: str) -> xr.Dataset:
    case = bw.with_values(stage_case(effects), SMALL)
    return campbell(case, families=1, speeds=(0.0, 2.5))


@pytest.mark.slow
def test_the_figures_show_branches_and_critical_speeds() -> None:
    rotating, static = (plot_campbell(small_diagram("full"), f) for f in FRAMES)
    speed = small_diagram("full").critical_speed.item()
    critical = f"critical speed, {speed:.4g} ω₁"
    assert {"forward wave", critical} <= set(texts(rotating))
    assert "forward wave" in texts(static)
    (cross,) = [line for line in rotating.axes[0].lines if line.get_marker() == "X"]
    np.testing.assert_allclose(np.asarray(cross.get_xdata()), speed, rtol=1e-7)
    np.testing.assert_array_equal(np.asarray(cross.get_ydata()), 0.0)
    at_rest = texts(plot_campbell(small_diagram("none"), "rotating"))
    assert not {"forward wave", critical} & set(at_rest)


@pytest.mark.slow
def test_the_command_prints_critical_speeds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(bw.with_values(stage_case(), SMALL)), encoding="utf-8")
    monkeypatch.setattr(figures_folder, "save_figures", lambda *figures, **options: None)
    done = answer("campbell", file, "--speeds", "0:2.5")
    (critical,) = coincidence_list(small_diagram("full"))["critical_speeds"]
    rows = [line.split()[:5] for line in done.stdout.splitlines()]
    assert ["1", "suspension", "1F", f"{critical['ratio']:.5f}", f"{critical['rpm']:.1f}"] in rows
    assert f"ratio {small_diagram('full').attrs['clearance_gone']:.6g}" in done.stdout


@pytest.mark.slow
def test_merged_waves_grow() -> None:
    """Ground resonance without damping and contact; the hint comes from the reduced model."""
    soft = {"bladed_disk.blades": 8, "bladed_disk.elements_per_blade": 4, "shaft.stiffness": 6e6}
    turning = {"rotation.effects": "full", "march.speed": 3.6, "damping.ratio": 0.0}
    case = bw.with_values(bw.Case(), {**soft, **turning, "reduction.fixed_interface_modes": 40})
    result = campbell(case, families=1, speeds=(0.0, 3.6))
    met, growth = result.attrs["waves_meet"], result["branch_growth"]
    one = growth.isel(branch=int(growth[:, -1].values.argmax()))
    assert (one.sel(line_speed=slice(0.0, met)) == 0.0).all()
    assert (one.where(one["line_speed"] > met, drop=True) > 0.0).all()
    assert result["critical_speed"].max() < met < 3.6
    stage = bw.build_stage(case)
    rate = float(one[-1])
    (hint,) = [line for line in stage_hints(stage) if "have coalesced" in line]
    assert float(hint.partition("growth rate ")[2].split()[0]) == pytest.approx(rate, rel=0.01)


def test_unlike_sectors_are_refused() -> None:
    unlike = {**SMALL, "bladed_disk.mistuning": {"stiffness": [1.0] * 7 + [1.01]}}
    with pytest.raises(bw.UserError, match="expected equal sectors, without"):
        campbell(bw.with_values(stage_case("centrifugal"), unlike))


@pytest.mark.slow
def test_contact_scenarios_are_of_the_wave_where_it_meets_the_casing() -> None:
    """The backward wave of 1F, slow in static axes there, hardly moves the shaft."""
    stage = modal_model(bw.with_values(stage_case(), {"casing.support": 1508.0}))
    result = campbell(stage, families=1, speeds=(0.0, 2.5))["normalised_speed"]
    met = result.values[[(row[0], row[2]) == ("1F", 1) for row in result["coincidence"].values]]
    for name, share in CASING_SHARES.items():
        modes = whirling_modes(stage, casing_share=share)
        assert modes.speed / stage.reference_frequency == pytest.approx(met[0], rel=1e-9)
        assert abs(modes.shaft) < 0.5 * abs(modes.rotor), name
    stiff = bw.with_values(stage_case(), {"casing.support": 7.975e6})
    with pytest.raises(bw.UserError, match="coincides with the casing wave at no speed"):
        whirling_modes(modal_model(stiff), casing_share=0.5)


RPM = 30.0 / np.pi


FEW = bw.case_from(
    {
        "bladed_disk": {"blades": 6, "elements_per_blade": 3},
        "rotation": {"effects": "full"},
    }
)


def test_a_disk_on_soft_springs_is_critical_at_its_frequency_at_rest() -> None:
    soft = 1e3  # N/m
    stage = modal_model(bw.with_values(FEW, {"shaft.stiffness": soft}))
    (pair,) = {float(f) for f in stage.disks["free"].labelled.frequency[:2].round(9)}
    speeds = critical_speeds(stage, stiffnesses=np.array([soft, 4.0 * soft]))
    lowest = speeds["critical_speed"].isel(branch=0)
    np.testing.assert_allclose(lowest.isel(stiffness=0), pair * RPM, rtol=1e-4)
    np.testing.assert_allclose(lowest.isel(stiffness=1), 2.0 * pair * RPM, rtol=1e-3)
    np.testing.assert_allclose(speeds["spring_share"].isel(branch=0), 1.0, rtol=1e-3)


@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_the_shaft_whirls_at_the_speed_of_rotation(stiffness: float) -> None:
    speeds = critical_speeds(FEW, stiffnesses=np.array([stiffness]))["critical_speed"]
    own = modal_model(bw.with_values(FEW, {"shaft.stiffness": stiffness}))
    block = own.waves[1]
    for direction, order in ORDERS.items():
        for rpm in speeds.sel(direction=direction).values.ravel():
            nearest = np.abs(block.frequencies(rpm / RPM) - order * rpm / RPM).min()
            assert nearest < 1e-5 * rpm / RPM


def test_the_command_lists_the_speeds_of_the_case(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(FEW), encoding="utf-8")
    document = json.loads(answer("critical-speeds", file, "--json", "--branches", "1").stdout)
    assert document["stiffness"] == FEW.shaft.stiffness
    speeds = critical_speeds(FEW, stiffnesses=np.array([document["stiffness"]]), branches=1)
    expected = speeds["critical_speed"].values.ravel()
    assert [row["rpm"] for row in document["critical_speeds"]] == pytest.approx(expected)
    assert [row["direction"] for row in document["critical_speeds"]] == list(ORDERS)


def test_the_figure_has_a_line_a_branch() -> None:
    springs = np.geomspace(1e6, 1e9, 5)
    axes = plot_critical_speeds(critical_speeds(FEW, stiffnesses=springs)).axes[0]
    assert len(axes.collections) == 4
    assert axes.get_xlim() == pytest.approx((1.0, 1e3))  # MN/m


def rigid_rotor(stiffness: float, stiffness_y: float, effects: str = "full") -> bw.Case:
    """A rotor that does not bend, on stationary bearings."""
    return bw.case_from(
        {
            "material": {"young_modulus": 1e13},
            "bladed_disk": {
                "blades": 8,
                "elements_per_blade": 3,
                "tip_radius": 0.2,
                "disk_kind": "rigid",
                "point_masses": [{"radius": 0, "mass": 50.0}],
            },
            "shaft": {"stiffness": stiffness, "stiffness_y": stiffness_y, "frame": "static"},
            "rotation": {"effects": effects},
            "casing": {"elements": 16},
            "march": {"speed": 0.5},
        }
    )


@pytest.mark.slow
def test_unequal_bearings_have_a_critical_speed_each() -> None:
    """The closed form sqrt(k / m) for x and for y; the mean stiffness gives neither."""
    case = rigid_rotor(2e6, 7e6)
    mass = modal_model(case).beams.model.mass
    expected = np.sqrt(np.array([2e6, 7e6]) / mass) * 30.0 / np.pi
    result = critical_speeds(case, stiffnesses=np.array([2e6, 4e6]))
    np.testing.assert_array_equal(result["direction"], ["elliptic"])
    computed = result["critical_speed"].values[:, 0, :2]
    np.testing.assert_allclose(computed[0], expected, rtol=1e-4)
    np.testing.assert_allclose(computed[1], np.sqrt(2.0) * expected, rtol=1e-4)
    diagram = campbell(case, families=1, speeds=("0 rpm", "9000 rpm"))
    np.testing.assert_allclose(diagram["critical_rpm"][:2], expected, rtol=1e-4)
    first = diagram["critical_family"].values[:2].tolist()
    assert first == ["suspension", "suspension"]
    assert plot_critical_speeds(result).axes[0].get_legend_handles_labels()[1][1:] == ["elliptic"]


@pytest.mark.parametrize("effects", ["none", "centrifugal"])
def test_unequal_bearings_need_coriolis_forces(effects: str) -> None:
    with pytest.raises(bw.UserError, match="campbell: expected equal shaft springs"):
        campbell(rigid_rotor(2e6, 7e6, effects))
