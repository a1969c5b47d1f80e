"""`bladewhirl stability`: one point, the chart, the divergent mode in time, and bad input."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import answer
from matplotlib.figure import Figure
from places import ROOT

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.whirl import whirl
from bladewhirl.studies.commands.options import span
from bladewhirl.studies.modal import coupled_mode_figures
from bladewhirl.studies.sweeps.axes import parse_over

FAN_STAGE = str(ROOT / "examples" / "fan_stage.toml")
POINT = ["--speed", "1.17", "--kappa", "500"]
SMALL = ["--speeds", "0.6:3:0.2", "--kappas", "0:1000:250"]


def run(*arguments: str) -> str:
    return answer("stability", FAN_STAGE, *arguments).stdout


@pytest.mark.parametrize(
    ("flag", "growth"),
    [("--json", 7.504), ("--no-pi", 0.0), ("--damped", 6.8655), ("--physical", 0.0)],
)
def test_papers_example_point(flag: str, growth: float) -> None:
    """Growth rates of an independent integration; with physical amplitudes, of which the casing's
    is 0.2, the point is stable."""
    point = json.loads(run(*POINT, flag, "--json"))
    assert point["growth_rate"] == pytest.approx(growth, abs=1e-3)
    assert point["growth_rate_floquet"] == pytest.approx(point["growth_rate"], abs=1e-6)
    assert point["unstable"] == (growth > 0.0)
    assert (point["amplitude"] == "physical") == (flag == "--physical")
    values = np.array(point["eigenvalues"])
    assert values.shape == (12, 2)
    assert values[:, 0].max() == point["growth_rate"]


@pytest.mark.parametrize("speed", ["0", "1e-9", "5e-324"])
def test_rest_has_no_monodromy(speed: str) -> None:
    point = json.loads(run("--speed", speed, "--kappa", "500", "--json"))
    assert point["growth_rate"] == pytest.approx(0.0, abs=1e-6)
    assert "growth_rate_floquet" not in point


@pytest.mark.slow
def test_chart_with_its_figures(
    tmp_path: Path, saved: dict[str, tuple[Figure, xr.Dataset]]
) -> None:
    modes = "casing:1,casing:2,1F:1,1F:2,suspension"
    printed = run(*SMALL, "--modes", modes, "-o", str(tmp_path / "chart"))
    rows = [line.split()[:5] for line in printed.splitlines()]
    assert ["casing", "k=2", "1F", "k=2", "0.8319"] in rows
    assert set(saved) == {"stability", "spectrum", "truncation"}
    _, chart = saved["stability"]
    assert chart["growth"].shape == (5, 13)
    zone = chart.isel(zone=(chart["zone_rotor"] == "1F k=1").values)
    assert zone["zone_lower"].values[-1] == pytest.approx(1.1423, abs=2e-3)


def test_chart_as_one_document(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report = json.loads(run(*SMALL, "--json"))
    assert [zone["rotor"] for zone in report["zones"]] == ["1F k=1", "suspension"]
    assert [zone["coincidence"] for zone in report["zones"]] == pytest.approx(
        [1.0550, 2.5817], abs=1e-3
    )
    zone = report["zones"][0]
    assert np.all(np.diff(np.subtract(zone["upper"], zone["lower"])) > 0.0)
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("saved")
@pytest.mark.slow
def test_divergent_mode_in_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Check claim 15 on the written motion."""
    folder = tmp_path / "mode"
    films: list[str] = []
    for name in ("export_vtk", "render_animation"):
        monkeypatch.setattr(
            coupled_mode_figures,
            name,
            lambda motion, path, *args, **options: films.append(path.name),
        )
    point = json.loads(run(*POINT, "-o", str(folder), "--json"))
    assert films == ["vtk", "animation.gif"]
    motion = point["coupled_mode"]
    assert motion["rotor_wave_speed"] < 0.0 < motion["casing_wave_speed"]
    assert {"mode.nc", "case.toml"} <= {path.name for path in folder.iterdir()}
    with xr.open_dataset(folder / "mode.nc", engine="h5netcdf") as result:
        orbit = shaft_orbit(result)
        assert whirl(orbit, "rotating").direction == "backward"
        assert whirl(orbit, "static").direction == "forward"
        assert whirl(orbit, "rotating").rate == pytest.approx(motion["whirl_speed_rotating"])
        radius = orbit["radius"].values
        grown = np.log(radius[-1] / radius[0]) / float(result["time"][-1])
        assert grown == pytest.approx(point["growth_rate"], rel=1e-6)
        # The nearest blade is so at the end, a blade's pitch from contact at most.
        gap = result["gap"].values
        assert 0.0 <= gap.min() < 0.05e-3
        assert np.unravel_index(gap.argmin(), gap.shape)[0] > 0.98 * len(gap)


@pytest.mark.slow
def test_damping_takes_energy_as_a_growing_circle_does(tmp_path: Path) -> None:
    """The power sum 2 xi omega v^2 grows with exp(2 growth t)."""
    folder = tmp_path / "mode"
    point = json.loads(run(*POINT, "--damped", "--no-films", "-o", str(folder), "--json"))
    assert not (folder / "vtk").exists()
    with xr.open_dataset(folder / "mode.nc", engine="h5netcdf") as result:
        power = sum(
            float(np.sum(2.0 * 0.005 * result[f"{body}_frequency"] * velocity**2))
            for body in ("rotor", "casing")
            for velocity in [result[f"{body}_velocity"].isel(time=0)]
        )
        rate, time = 2.0 * point["growth_rate"], result["time"].values
        expected = power * np.expm1(rate * time) / rate
        assert result["damping_work"].values == pytest.approx(expected, rel=1e-4)
        energy = result["energy"].values
        balance = result["coupling_work"].values - result["damping_work"].values
        assert balance == pytest.approx(energy - energy[0])


def test_the_third_number_of_a_range_is_a_step_as_in_a_sweep() -> None:
    text = "900 rpm:1500 rpm:300 rpm"
    speeds = span("--speeds", stepped=True).parser
    reference = 2.0 * np.pi * 10.0
    assert parse_over([f"march.speed={text}"])["march.speed"] == ("900 rpm", "1200 rpm", "1500 rpm")
    assert speeds(text).values(reference) == pytest.approx([1.5, 2.0, 2.5])
    assert speeds("0.1:0.3:0.1").values().tolist() == [0.1, 0.2, 0.3]
    assert speeds("1,1.5,4").values().tolist() == [1.0, 1.5, 4.0]
    for wrong in ("0.1:2:381", "1:2", "1 rpm:2 rpm:0.5", "1", "2:1:0.1", "0:1e9:1", "1:2:-1", "::"):
        with pytest.raises(UserError, match=r"^--speeds .* expected "):
            speeds(wrong).values(reference)


def test_a_span_includes_its_ends_and_takes_units() -> None:
    kappas = span("--kappas", unit="N/m", stepped=True).parser
    assert kappas("0.5:2:0.5").values().tolist() == [0.5, 1.0, 1.5, 2.0]
    assert kappas("0 kN/m:1 kN/m:0.5 kN/m").values().tolist() == [0.0, 500.0, 1000.0]
    stiffnesses = span("--stiffnesses", unit="N/m").parser("1 kN/mm:2e7")
    assert stiffnesses.values().tolist() == [1e6, 2e7]
    reference = 2.0 * np.pi * 40.0
    speeds = span("--speeds").parser
    assert speeds("1200 rpm:2.5").values(reference) == pytest.approx([0.5, 2.5])
    with pytest.raises(UserError, match="expected a START of zero or more and a STOP above"):
        speeds("3000 rpm:0.5").values(reference)
    for wrong in ("1 mm:2 mm", "1:2:3", "a:b"):
        with pytest.raises(UserError, match=r"--speeds .* expected START:STOP"):
            speeds(wrong)
