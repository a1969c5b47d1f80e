"""Draws of sweeps: their values, their intervals, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import answer
from small_run import small

import bladewhirl as bw
from bladewhirl.postprocess.sweep.probability import plot_probability, probability
from bladewhirl.postprocess.sweep.quantities import bifurcation
from bladewhirl.postprocess.sweep.shares import wilson
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.draws import parse_draws
from bladewhirl.studies.sweeps.plan import plan_sweep, read_plan, write_plan

CASE = small(**{"contact.friction": 0.2})
OVER = {"march.speed": [1.0, 1.5]}


@pytest.mark.slow
def test_values_depend_on_seed_point_and_draw_alone() -> None:
    perturb = ["contact.friction = 0.1", "march.speed = 0.01 absolute uniform"]
    grids = [
        make_grid(CASE, OVER, large=False, draws=parse_draws(count, perturb, seed))
        for count, seed in ((3, 0), (5, 0), (3, 1))
    ]
    few, more, other = ([grid.values(point) for point in range(grid.size)] for grid in grids)
    assert few[:3] == more[:3]  # further draws leave the first as they are
    assert few[3:] == more[5:8]
    assert few != other
    assert len({values["contact.friction"] for values in few}) == 6
    for values, nominal in zip(more, np.repeat([1.0, 1.5], 5), strict=True):
        assert abs(float(values["march.speed"]) - nominal) < 0.01


@pytest.mark.slow
def test_normal_changes_have_their_standard_deviation() -> None:
    grid = make_grid(CASE, OVER, large=False, draws=parse_draws(2000, ["contact.friction=0.1"], 7))
    numbers = [float(grid.values(point)["contact.friction"]) for point in range(2000)]
    assert np.mean(numbers) == pytest.approx(0.2, abs=0.002)
    assert np.std(numbers) == pytest.approx(0.02, rel=0.06)


def toy(share: float, draws: int, seed: int) -> xr.Dataset:
    """A sweep of one point that diverges with a known probability."""
    hit = np.random.default_rng(seed).random((1, draws)) < share
    regime = np.where(hit, "divergent", "sustained")
    over = ("march_speed", "draw")
    return xr.Dataset(
        {
            "regime": (over, regime),
            "state": (over, np.full((1, draws), "done")),
            "reference_frequency": (over, np.ones((1, draws))),
        },
        coords={
            "march_speed": ("march_speed", [1.0], {"long_name": "speed"}),
            "draw": ("draw", np.arange(float(draws)), {"long_name": "draw"}),
        },
        attrs={"case": "toy"},
    )


@pytest.mark.parametrize(("share", "draws"), [(0.3, 20), (0.5, 40)])
@pytest.mark.slow
def test_intervals_cover_the_probability_of_a_toy(share: float, draws: int) -> None:
    covered = 0
    for seed in range(200):
        one = probability(toy(share, draws, seed)).sel(regime="divergent").squeeze()
        covered += bool(one["low"] <= share <= one["high"])
    assert 180 <= covered <= 198


def test_wilson_at_the_ends() -> None:
    low, high = wilson(np.array([0.0, 10.0, 0.0]), np.array([10.0, 10.0, 0.0]))
    np.testing.assert_allclose(low, [0.0, 0.7224672, 0.0], atol=1e-7)
    np.testing.assert_allclose(high, [0.2775328, 1.0, 1.0], atol=1e-7)


@pytest.mark.usefixtures("process")
@pytest.mark.slow
def test_a_sweep_has_a_dimension_of_draws(tmp_path: Path) -> None:
    perturb = ["contact.friction = 1e-3"]
    folder = tmp_path / "sweep"
    bw.run_sweep(CASE, OVER, folder, draws=2, perturb=perturb, seed=3)
    with bw.open_sweep(folder) as sweep:
        assert dict(sweep["regime"].sizes) == {"march_speed": 2, "draw": 2}
        shares = probability(sweep)
        np.testing.assert_array_equal(shares["share"].sum("regime"), 1.0)
        assert shares["uncertain"].values.all()  # two draws say little
        assert plot_probability(shares).axes
        sections = bifurcation(sweep, "march_speed")
        peaks = sweep["radius_peak"].values
    assert dict(sections["radius_peak"].sizes) == {"line": 1, "march_speed": 2, "section": 128}
    np.testing.assert_array_equal(sections["radius_peak"].values[0], peaks.reshape(2, -1))
    draws = parse_draws(2, perturb, 3)
    plan = plan_sweep(CASE, make_grid(CASE, OVER, large=False, draws=draws))
    (tmp_path / "plan").mkdir()
    write_plan(plan, tmp_path / "plan")
    assert read_plan(tmp_path / "plan").grid == plan.grid


def test_a_sweep_without_draws_has_no_probability() -> None:
    with pytest.raises(bw.ViewError, match="expected a sweep with random draws"):
        probability(toy(0.5, 2, 0).isel(draw=0, drop=True))


@pytest.mark.usefixtures("process")
@pytest.mark.slow
def test_drawn_values_are_stored_and_a_draw_can_be_repeated(tmp_path: Path) -> None:
    perturb = ["contact.friction = 0.1", "march.speed = 0.02", "casing.clearance = 1e-5 absolute"]
    folder = tmp_path / "swept"
    done = bw.run_sweep(CASE, OVER, folder, draws=3, perturb=perturb, seed=4)
    with bw.open_sweep(folder) as sweep:
        sweep.load()
    for point in range(6):
        at = divmod(point, 3)
        expected = done.grid.values(point)
        assert sweep["drawn_contact_friction"].values[at] == expected["contact.friction"]
        assert sweep["drawn_march_speed"].values[at] == expected["march.speed"]
        assert sweep["drawn_casing_clearance"].values[at] == expected["casing.clearance"]
    units = [sweep[f"drawn_{n}"].attrs["units"] for n in ("march_speed", "casing_clearance")]
    assert units == ["1", "m"]
    case = bw.drawn_case(folder, 2, march_speed=1.5)
    ran = bw.run(case, tmp_path / "run", frames=0)
    one = sweep.sel(march_speed=1.5, draw=2)
    assert ran.summary.shaft_radius_max == float(one["shaft_radius_max"])
    assert case.contact.friction == float(one["drawn_contact_friction"])
    for wrong, speed in ((3, 1.5), (0, 1.4)):
        with pytest.raises(bw.UserError, match="expected"):
            bw.drawn_case(folder, wrong, march_speed=speed)


def test_the_command_writes_the_cases_of_a_draw(tmp_path: Path) -> None:
    file, folder = tmp_path / "case.toml", tmp_path / "drawn"
    file.write_text(bw.dumps_case(CASE), encoding="utf-8")
    words = ["--over", "march.speed=1:1.5:0.5", "--draws", "3", "--seed", "4"]
    words += ["--perturb", "contact.friction = 0.1", "--draw", "1", "-o", str(folder)]
    printed = answer("sweep", file, *words).stdout
    over = {"march.speed": [1, 1.5]}
    grid = make_grid(CASE, over, large=False, draws=parse_draws(3, ["contact.friction=0.1"], 4))
    for point in (0, 1):
        drawn = bw.read_case(folder / f"point_{point}_draw_1.toml")
        assert drawn == bw.with_values(CASE, grid.values(3 * point + 1))
        assert f"point_{point}_draw_1.toml: {grid.label(3 * point + 1)}" in printed
    assert not (folder / "sweep.nc").exists()
