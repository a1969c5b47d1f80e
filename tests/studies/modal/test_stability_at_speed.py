"""Stability of coupled modes: datasets of a point and of a chart, disks with rotation effects."""

from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from places import EXAMPLES
from stages import bladed_disk, oracle

import bladewhirl as bw
from bladewhirl.models.elements.cyclic import nodal_diameters
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.rotation.internal_growth import internal_growth
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.solvers.stability.floquet import coupled_floquet, floquet
from bladewhirl.solvers.stability.growth import (
    coincidence_speeds,
    growth_rate,
    is_unstable,
    rotor_waves,
)
from bladewhirl.solvers.stability.zones import unstable_zones
from bladewhirl.studies.modal.coupled_system import EvenSystem, couple
from bladewhirl.studies.modal.stability_chart import stability_chart
from bladewhirl.studies.modal.stability_report import ZONES
from bladewhirl.studies.runs.columns import rows_of


@cache
def coupled(
    example: str, modes: str = "six", effects: Effects = "full", *, damped: bool = False
) -> EvenSystem:
    case = bw.read_case(EXAMPLES / f"{example}.toml", [f"rotation.effects={effects}"])
    system = couple(modal_model(case), modes=modes, damped=damped, with_pi=True, physical=False)
    assert isinstance(system, EvenSystem)
    return system


@pytest.mark.parametrize("speed", [-1.6, 1.6, 2.5])
@pytest.mark.parametrize("effects", ["centrifugal", "full"])
@pytest.mark.parametrize("example", ["fan_stage", "curved_blades"])
@pytest.mark.slow
def test_the_frame_at_half_speed_agrees_with_real_matrices_over_a_turn(
    example: str, effects: Effects, speed: float
) -> None:
    """The monodromy is that of matrices projected on real modes, without complex numbers."""
    system = coupled(example, effects=effects, damped=True)
    omega, modes = speed * system.reference, system.modes
    rotor, numbers = system.stage.coordinates(on_casing=False)
    fields = system.stage.modal.disk_modes.fields(numbers)
    assert system.disk is not None
    at_rest = replace(modes, gyroscopic=None, stiffness_speed=None)
    damping, softening = np.diag(modes.damping_rate[modes.entry]), np.zeros((modes.size,) * 2)
    among, matrices = np.ix_(rotor, rotor), system.disk.structure
    softening[among] = omega**2 * (fields.T @ matrices.known("stiffness_speed") @ fields)
    if effects == "full":
        damping[among] += omega * (fields.T @ matrices.known("gyroscopic") @ fields)
    turn = floquet(
        lambda times: softening + at_rest.equations.stiffness(omega * times, 400.0),
        period=2.0 * np.pi / abs(omega),
        damping=damping,
    )
    growth = growth_rate(modes, speed=omega, kappa=400.0)
    assert float(growth) == pytest.approx(float(turn.growth), rel=1e-7, abs=1e-6)
    (rotating,) = coupled_floquet(modes, speed=omega, kappa=400.0)
    np.testing.assert_allclose(rotating.monodromy, turn.monodromy, atol=1e-7 * abs(omega))


@pytest.mark.slow
def test_blades_of_one_hand_have_complex_matrices() -> None:
    straight, curved = (coupled(name).modes for name in ("fan_stage", "curved_blades"))
    for modes, mirrored in ((straight, True), (curved, False)):
        rates = map(modes.over_entries, (modes.gyroscopic, modes.stiffness_speed))
        coriolis, softening = rates
        assert mirrored is not bool(coriolis.real.any() or softening.imag.any())
        np.testing.assert_allclose(coriolis, -coriolis.conj().T, atol=1e-12)
        np.testing.assert_allclose(softening, softening.conj().T, atol=1e-12)


def test_more_modes_at_rest_come_nearer_to_waves_at_speed() -> None:
    errors = []
    for modes in ("six", "all"):
        system = coupled("fan_stage", modes)
        part = system.modes.harmonic(1)
        omega = 1.05 * system.reference
        computed = rotor_waves(part.take(~part.on_casing), omega).real
        assert system.disk is not None
        exact = -system.disk.structure.wave(1).frequencies(omega).real
        lowest = exact[np.argsort(np.abs(exact))[:2]]
        errors.append(max(np.abs(computed - rate).min() / abs(rate) for rate in lowest))
    assert errors[0] < 1e-2
    assert errors[1] < 3e-4


@pytest.mark.parametrize("modes", ["six", "all"])
@pytest.mark.slow
def test_zones_at_speed_are_where_growth_is(modes: str) -> None:
    system = coupled("fan_stage", modes)
    low, high = 0.8 * system.reference, 2.2 * system.reference
    kappas = np.array([200.0, 700.0])
    zones = unstable_zones(system.modes, kappas=kappas, low=low, high=high)
    assert len(zones.kappa) >= 2
    speeds = np.linspace(low, high, 1500)
    for kappa in kappas:
        growing = is_unstable(growth_rate(system.modes, speed=speeds, kappa=kappa), speeds)
        border = zones.kappa == kappa
        inside = (speeds[:, None] > zones.lower[border]) & (speeds[:, None] < zones.upper[border])
        away = np.abs(speeds[:, None] - np.append(zones.lower[border], zones.upper[border])).min(
            axis=1
        )
        sure = away > 1e-3 * low
        np.testing.assert_array_equal(growing[sure], inside.any(axis=1)[sure])


def test_zones_begin_at_coincidences_at_speed() -> None:
    system = coupled("fan_stage")
    ((pair, speed),) = coincidence_speeds(system.modes).items()
    assert pair == (0, 1)
    zones = unstable_zones(
        system.modes,
        kappas=np.array([1e-2]),
        low=0.8 * system.reference,
        high=2.2 * system.reference,
    )
    assert zones.lower == pytest.approx([speed], rel=1e-4)
    assert zones.upper == pytest.approx([speed], rel=1e-4)
    at_rest = coincidence_speeds(replace(system.modes, gyroscopic=None, stiffness_speed=None))
    assert speed > 1.2 * at_rest[pair]  # Coriolis forces raise the backward wave


@pytest.mark.slow
def test_a_zone_of_waves_that_never_meet_has_no_start() -> None:
    """Static divergence past the critical speed, without Coriolis forces."""
    system = coupled("curved_blades", effects="centrifugal", damped=True)
    speeds = np.array([2.5, 2.8]) * system.reference
    chart = stability_chart(system, speeds, np.array([1000.0]))
    document = rows_of(chart, ZONES, "zone_")
    assert [row["coincidence"] for row in document] == [None] * 61


@pytest.mark.slow
def test_internal_damping_grows_as_known_and_bearings_hold_it() -> None:
    disk, row = bladed_disk(disk_thickness=0.01), oracle("rotation")["stages"]["0.01"]
    disk = replace(disk, structure=rotation_matrices(disk))
    for ratio, growth, _ in row["growth_rates_xi_0.005"]:
        omega = 2.0 * np.pi * row["reference_hz"] * ratio
        computed = internal_growth(disk, omega, "full", damping_ratio=0.005)
        if growth < 0.0:  # known of k = 1; others may decay more slowly
            assert growth - 1e-6 < computed.rate < 0.0
            assert computed.holding == 0.0
            continue
        assert computed.rate == pytest.approx(growth, abs=1e-6)
        assert computed.nodal_diameter == 1
        assert computed.holding is not None
        layout = disk.structure.layout
        assert layout is not None
        assert 1 in nodal_diameters(layout.sectors)
        centre = np.asarray(layout.basis(1).conj().T[:, disk.centre].toarray())
        growth = partial(disk.structure.wave(1).growth, omega, 0.005, centre)
        assert growth(computed.holding) == pytest.approx(0.0, abs=1e-7)
        assert growth(1.1 * computed.holding) < 0.0 < growth(0.0)


@pytest.mark.slow
def test_internal_damping_destabilises_the_bladed_disk_alone_past_its_critical_speed() -> None:
    damped, undamped = (coupled("fan_stage", damped=both) for both in (True, False))
    past = 2.5 * damped.reference
    grows, undamped_past = damped.rotor_alone(past), undamped.rotor_alone(past)
    assert grows["rotor_growth_rate"] > 0.0
    assert grows["rotor_nodal_diameter"] == 1
    assert grows["holding_damping"] > 0.0
    assert grows["critical_speed"] == undamped_past["critical_speed"] < 2.5
    assert undamped_past["rotor_growth_rate"] == pytest.approx(0.0, abs=1e-6)
    assert not undamped_past["waves_met"]
    assert damped.rotor_alone(damped.reference)["rotor_growth_rate"] <= 0.0


@pytest.mark.slow
def test_unlike_blades_with_rotation_are_refused() -> None:
    case = bw.read_case(EXAMPLES / "mistuned_blades.toml", ["rotation.effects=full"])
    with pytest.raises(UserError, match=r"rotation\.effects = \"full\"; here blades differ"):
        bw.stability(case, speed=1.0, kappa=100.0, physical=True)


@pytest.mark.parametrize(
    "shaft",
    [{"stiffness": 2e7, "stiffness_y": 2.5e7}, {"stiffness": 2e7, "damping": 10, "damping_y": 20}],
)
def test_an_unequal_shaft_with_rotation_is_named(shaft: dict[str, float]) -> None:
    """Its springs turn with the rotor, so that they split the modes of equal blades."""
    disk = {"blades": 7, "elements_per_blade": 2}
    tables = {"bladed_disk": disk, "rotation": {"effects": "full"}, "shaft": shaft}
    case = bw.case_from(tables | {"casing": {"support": 8e6}})
    with pytest.raises(UserError, match=r"shaft are unequal|dampers at points"):
        bw.stability(case, speed=1.0, kappa=100.0, damped=True)
    equal = bw.case_from(tables | {"shaft": {"stiffness": 2e7}, "casing": {"support": 8e6}})
    bw.stability(equal, speed=1.0, kappa=100.0)


SPEEDS, KAPPAS = np.linspace(0.9, 1.4, 5), np.linspace(0.0, 1000.0, 3)


@cache
def fan_stage() -> ModalModel:
    return modal_model(bw.read_case(EXAMPLES / "fan_stage.toml"))


def test_a_point_holds_growth_eigenvalues_mode_and_scenario(tmp_path: Path) -> None:
    point = bw.stability(fan_stage(), speed=1.17, kappa=500.0)
    assert float(point["growth_rate"]) == pytest.approx(7.503, abs=1e-3)
    assert float(point["growth_rate_floquet"]) == pytest.approx(float(point["growth_rate"]))
    assert bool(point["unstable"])
    assert point["real"].values.max() == point["growth_rate"]
    assert point["mode"]["entry"].values.tolist() == ["casing k=1", "1F k=1", "suspension"]
    assert point["mode"].idxmax() == "casing k=1"
    assert point["rotor_wave_speed"] < 0.0 < point["casing_wave_speed"]
    assert point["scenario"] == "inverted"
    for name, variable in point.data_vars.items():
        assert variable.attrs.keys() & {"units", "long_name"} or name == "unstable", name
    point.to_netcdf(tmp_path / "point.nc", engine="h5netcdf")


@pytest.mark.slow
def test_a_chart_agrees_with_its_points(tmp_path: Path) -> None:
    chart = bw.stability(fan_stage(), speed=SPEEDS, kappa=KAPPAS, modes="all")
    assert chart["growth"].dims == ("kappa", "speed")
    assert {"1F k=1", "suspension"} <= set(chart.attrs["modes"])
    here = chart["growth"].sel(speed=SPEEDS[2], kappa=KAPPAS[1])
    point = bw.stability(fan_stage(), speed=SPEEDS[2], kappa=KAPPAS[1], modes="all")
    assert float(here) == pytest.approx(float(point["growth_rate"]), rel=1e-9)
    assert "1F k=2" in chart["coincidence_rotor"].values
    chart.to_netcdf(tmp_path / "chart.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "chart.nc", engine="h5netcdf") as saved:
        assert saved["growth"].attrs["units"] == "1/s"


def test_unlike_blades_have_a_chart_without_zones() -> None:
    changes = {"bladed_disk.mistuning": {"stiffness": [1.0, 1.1, 0.95, 1.0, 1.2, 0.9]}}
    small = {"bladed_disk.blades": 6, "bladed_disk.elements_per_blade": 3, "casing.elements": 16}
    case = bw.with_values(bw.Case(), small | changes)
    chart = bw.stability(case, speed=[1.0, 1.9], kappa=[0.0, 3e5], physical=True)
    assert "zone" not in chart.dims
    unstable = chart["growth"] > 0.1
    assert unstable.values.tolist() == [[False, False], [False, True]]


def test_a_chart_of_a_periodic_system_is_refused() -> None:
    case = bw.read_case(EXAMPLES / "unequal_bearings.toml")
    with pytest.raises(bw.UserError, match="the stationary shaft springs are unequal"):
        bw.stability(case)
