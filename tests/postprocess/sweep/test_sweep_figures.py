"""Figures of sweeps and what is behind them: closed-form motions, failed points, two keys."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from synthetic_result import synthetic_result
from synthetic_sweep import synthetic_sweep

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.registry import SWEEP_FIGURES
from bladewhirl.postprocess.sweep import frequency_map as map_module
from bladewhirl.postprocess.sweep.dataset import open_sweep
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.postprocess.sweep.frequency_map import frequency_map
from bladewhirl.postprocess.sweep.maps import plot_sweep_maps, sweep_maps
from bladewhirl.postprocess.sweep.quantities import (
    bifurcation,
    contact_sides,
    regimes,
    shaft_radius,
    whirls,
)
from bladewhirl.postprocess.sweep.regimes import regime_entries, regime_names
from bladewhirl.postprocess.sweep.rows import blade_contacts, point_energies

REFERENCE = 75.0  # rad/s
WHIRL = -70.0 / (2 * np.pi)  # Hz in rotating axes
SPEEDS = (1.2, 0.8, 1.0)
RADII = (0.4e-3, 0.2e-3, 1.3e-3)


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three speeds out of order, one of which failed, and one at rest."""
    motions = [
        *({"speed": REFERENCE * s, "shaft_radius": r} for s, r in zip(SPEEDS, RADII, strict=True)),
        None,
        {"speed": REFERENCE * 1.6, "shaft_radius": 0.0, "bending": 0.0},
    ]
    over = {"march.speed": (*SPEEDS, 1.4, 1.6)}
    return synthetic_sweep(tmp_path_factory.mktemp("sweeps") / "one", over, motions)


@pytest.fixture(scope="module")
def sweep(one: Path) -> Iterator[xr.Dataset]:
    with open_sweep(one) as data:
        yield data


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two speeds and three frictions, the radius growing with both."""
    motions = [
        {"speed": REFERENCE * s, "shaft_radius": (s + f) * 1e-4}
        for s in (1.0, 2.0)
        for f in (0.0, 0.1, 0.2)
    ]
    over = {"march.speed": (1.0, 2.0), "contact.friction": (0.0, 0.1, 0.2)}
    return synthetic_sweep(tmp_path_factory.mktemp("sweeps") / "two", over, motions)


@pytest.fixture
def none(tmp_path: Path) -> Path:
    """Two points, both failed."""
    return synthetic_sweep(tmp_path / "none", {"march.speed": (1.0, 2.0)}, [None, None])


def test_points_are_put_in_order(sweep: xr.Dataset) -> None:
    actual = shaft_radius(sweep, "march_speed")
    np.testing.assert_array_equal(actual["march_speed"], [0.8, 1.0, 1.2, 1.4, 1.6])
    expected = [0.2e-3, 1.3e-3, 0.4e-3, np.nan, 0.0]
    np.testing.assert_allclose(actual["shaft_radius_max"].values, [expected], rtol=1e-12)
    assert regimes(sweep, "march_speed")["regime"].values.tolist() == [
        ["no-contact", "sustained", "no-contact", "unknown", "no-contact"]
    ]


def test_a_whirl_has_its_frequency_and_rest_has_none(sweep: xr.Dataset) -> None:
    actual = whirls(sweep, "march_speed").isel(line=0)
    sides = contact_sides(sweep, "march_speed").isel(line=0)
    moving, resting = slice(0, 3), slice(3, 5)
    rotating = actual["frequency"].sel(frame="rotating").values
    np.testing.assert_allclose(rotating[moving], WHIRL, rtol=1e-9)
    assert np.isnan(rotating[resting]).all()
    speeds = REFERENCE * actual["march_speed"].values / (2 * np.pi)
    static = actual["frequency"].sel(frame="static").values
    np.testing.assert_allclose(static[moving], WHIRL + speeds[moving], rtol=1e-9)
    assert actual["direction"].sel(frame="rotating").values.tolist() == [
        *["backward"] * 3,
        "unknown",
        "at rest",
    ]
    assert actual["direction"].sel(frame="static").values[:3].tolist() == [
        "backward",  # 60 against 70 rad/s
        "forward",
        "forward",
    ]
    assert sides["scenario"].values[3:].tolist() == ["unknown", "at-rest"]
    assert np.isnan(sides["shaft_lead"].values[3:]).all()


def test_a_map_peaks_at_the_whirl(sweep: xr.Dataset) -> None:
    maps = frequency_map(sweep, "march_speed").isel(line=0)
    assert maps["amplitude"].dims == ("march_speed", "frequency")
    assert maps["frequency"].attrs["units"] == "1"
    done = maps["amplitude"].isel(march_speed=[0, 1, 2])
    peak = maps["frequency"].values[done.argmax("frequency").values]
    resolution = np.diff(maps["frequency"].values)[0]
    np.testing.assert_allclose(peak, -70.0 / REFERENCE, atol=0.51 * resolution)
    assert np.isnan(maps["amplitude"].isel(march_speed=3)).all()
    orders = maps["engine_order"].sel(order=2).values[:3]
    np.testing.assert_allclose(orders, [1.6, 2.0, 2.4], rtol=1e-12)
    casing = maps["mode_line"].sel(mode="casing k=1", direction="forward").values[:3]
    np.testing.assert_allclose(casing, 5.0 / REFERENCE - np.array([0.8, 1.0, 1.2]), rtol=1e-12)


def test_many_points_share_columns(sweep: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    """Five points in two columns: the largest of each is seen."""
    every = frequency_map(sweep, "march_speed")["amplitude"].values[0]
    monkeypatch.setattr(map_module, "MOST_COLUMNS", 2)
    few = frequency_map(sweep, "march_speed")
    np.testing.assert_array_equal(few["march_speed"], [0.8, 1.4])
    np.testing.assert_array_equal(few["amplitude"].values[0, 0], every[:3].max(axis=0))
    np.testing.assert_array_equal(few["amplitude"].values[0, 1], every[4])
    assert few.attrs["points_per_column"] == 3


def test_two_keys_give_a_line_for_each_value_of_the_other(two: Path) -> None:
    key, other = "march_speed", "contact_friction"
    with open_sweep(two) as sweep:
        actual = shaft_radius(sweep, key)
        maps = frequency_map(sweep, key)
    assert actual["shaft_radius_max"].dims == ("line", key)
    expected = actual["march_speed"] + actual["contact_friction"]
    np.testing.assert_allclose(actual["shaft_radius_max"], 1e-4 * expected.transpose("line", key))
    assert actual[other].dims == ("line",)
    top = maps["amplitude"].max("frequency").transpose("line", key)
    assert (np.diff(top.values, axis=0) > 0).all()
    assert (np.diff(top.values, axis=1) > 0).all()


@pytest.mark.slow
def test_a_bifurcation_diagram_tells_periods_apart(tmp_path: Path) -> None:
    """Circles that go round once, or once and a half in a revolution, and out of step with it."""
    turns = (1.0, 1.5, np.sqrt(2.0))
    motions = [whirling(2 * np.pi * 10.0, share) for share in turns]
    folder = synthetic_sweep(tmp_path / "b", {"shaft.stiffness": (1.0, 2.0, 3.0)}, motions)
    with open_sweep(folder) as sweep:
        actual = bifurcation(sweep, "shaft_stiffness").isel(line=0)
    x = [values[np.isfinite(values)] for values in actual["section_x"].values]
    assert [len(values) for values in x] == [10, 10, 10]  # of a second, the last third
    np.testing.assert_allclose(x[0], 1e-3, rtol=1e-3)
    np.testing.assert_allclose(np.sort(x[1]), np.repeat([-1e-3, 1e-3], 5), rtol=1e-2)
    assert len(np.unique(x[2].round(5))) == 10
    radius = actual["section_radius"].values
    np.testing.assert_allclose(radius[np.isfinite(radius)], 1e-3, rtol=1e-3)


def whirling(speed: float, share: float) -> xr.Dataset:
    """Three seconds of a circle of 1 mm, `share` of a turn in static axes each revolution."""
    result = synthetic_result(records=3011, speed=speed, bending=0.0)
    time = result["time"].values
    rate = (share - 1.0) * speed
    angle = rate * time
    result["rotor_displacement"][:, :2] = 1e-3 * np.column_stack([np.cos(angle), np.sin(angle)])
    turned = np.column_stack([-np.sin(angle), np.cos(angle)])
    result["rotor_velocity"][:, :2] = 1e-3 * rate * turned
    return result


def test_blades_are_counted_by_their_share_of_contact(sweep: xr.Dataset) -> None:
    share = np.zeros((5, 22))
    share[0, :4], share[0, 4:10] = 1.0, 0.3  # of speed 1.2
    changed = sweep.assign(late_contact_share=(("march_speed", "blade"), share))
    actual = blade_contacts(changed, "march_speed").isel(line=0)
    classes = ("permanent", "intermittent", "free")
    assert [actual[name].values[2] for name in classes] == [4, 6, 12]
    assert [actual[name].values[0] for name in classes] == [0, 0, 22]
    assert np.isnan(actual["free"].values[3])  # it failed


def test_energies_are_those_of_the_modes(sweep: xr.Dataset) -> None:
    """Two modes in quadrature hold 1/2 omega^2 q^2 together at any time."""
    actual = point_energies(sweep, "march_speed").isel(line=0)
    radii = np.array([0.2e-3, 1.3e-3, 0.4e-3])
    np.testing.assert_allclose(actual["suspension"][:3], 0.5 * 190.0**2 * radii**2, rtol=1e-9)
    family = actual["first_family"].sel(nodal_diameter=1).values
    np.testing.assert_allclose(family[:3], 0.5 * 75.0**2 * 0.3e-3**2, rtol=1e-9)
    np.testing.assert_allclose(
        actual["total"][:3], (actual["suspension"] + actual["rest"])[:3] + family[:3], rtol=1e-12
    )
    assert np.isnan(actual["total"].values[3])


@pytest.mark.slow
def test_a_third_key_makes_rows_of_maps(tmp_path: Path) -> None:
    over = {"march.speed": (1.0, 2.0), "contact.friction": (0.1, 0.0), "casing.support": (5.0, 3.0)}
    motions = [
        {"speed": REFERENCE * s, "shaft_radius": (s + f + k) * 1e-5}
        for s in (1.0, 2.0)
        for f in (0.1, 0.0)
        for k in (5.0, 3.0)
    ]
    with open_sweep(synthetic_sweep(tmp_path / "three", over, motions)) as sweep:
        maps = sweep_maps(sweep, "march_speed")
        radius = shaft_radius(sweep, "march_speed")
        top = frequency_map(sweep, "march_speed")["amplitude"].max("frequency")
    for actual in (maps, radius):
        names = ("march_speed", "contact_friction", "casing_support")
        expected = 1e-5 * sum((actual[name] for name in names), xr.DataArray(0.0))
        size = actual["shaft_radius_max"]
        np.testing.assert_allclose(size, expected.transpose(*size.dims), rtol=1e-12)
    np.testing.assert_allclose(maps["casing_support"], [3.0, 5.0])
    ratio = top.values / radius["shaft_radius_max"].values
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-6)
    assert len(plot_sweep_maps(maps).axes) == 2 * 2 + 1


@pytest.mark.slow
def test_all_figures_come_with_their_data(one: Path, tmp_path: Path) -> None:
    result = answer("plot", one, "all", "-o", tmp_path)
    messages = {line.split(" left out")[0] for line in result.stderr.splitlines()}
    of_beams = {
        name for name, kind in SWEEP_FIGURES.items() if "contact_spectrum" not in kind.needs
    }
    drawn = of_beams - messages
    assert messages == {"interaction", "maps", "probability", "wear"}
    files = {f"{name}.{kind}" for name in drawn for kind in ("png", "nc")}
    assert {path.name for path in tmp_path.iterdir()} == {*files, "manifest.json"}
    for name in drawn:
        with xr.open_dataset(tmp_path / f"{name}.nc", engine="h5netcdf") as data:
            assert "march_speed" in data.coords


def test_a_sweep_without_points_says_so(none: Path) -> None:
    with open_sweep(none) as sweep:
        for name in ("regimes", "maps"):
            with pytest.raises(
                ViewError, match=r"no point of the sweep is finished|two swept keys"
            ):
                SweepFigures(sweep).draw(name)
    refusal("plot", none, "regimes")
    answer("plot", none, "all")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["orbit"], "orbit: a sweep has the figures frequency-map, shaft-radius, contact-nodes"),
        (["regimes", "--from", "0.1"], "omit --from and --to, because a sweep"),
    ],
)
def test_what_a_sweep_has_not_is_said_in_one_line(
    one: Path, arguments: list[str], complaint: str
) -> None:
    assert complaint in refusal("plot", one, *arguments)


def test_draws_that_were_not_needed_are_not_counted_as_without_result() -> None:
    data = xr.Dataset(
        {
            "regime": ("draw", ["sustained", "unknown", "unknown", "unknown"]),
            "state": ("draw", ["done", "not-needed", "not-needed", "failed"]),
        }
    )
    entries = regime_entries(regime_names(data))
    texts = [text for _, text in entries]
    assert texts == ["sustained: 1", "skipped, outcome known: 2", "no result: 1"]
    assert np.unique(regime_names(data)).size == 3
