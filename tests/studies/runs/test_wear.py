"""Runs with an abradable coating: files, continuation, summary and figures."""

import json
from pathlib import Path

import meshio
import numpy as np
import pytest
import xarray as xr
from small_run import assert_same_bits, broken_off, small

import bladewhirl as bw
from bladewhirl.models.case.analysis import Contact
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.postprocess.fields.kinematics import ViewError, table_of_result, track_strains
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.wear import lobe_shares, lobes_of, wear_summary
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.properties import stage_properties
from bladewhirl.studies.runs.recorded_march import expected_bytes
from bladewhirl.studies.runs.run import resume

COATING = {
    **{"thickness": 5e-3, "young_modulus": 1e9, "yield_stress": 1e7, "hardening": 5e7},
    "elements": 630,
}


def coated(**values: object) -> bw.Case:
    return small(**{"casing.coating": COATING, "march.duration": 0.02, **values})


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bw.run(coated(), tmp_path_factory.mktemp("coated") / "run", frames=0).directory


@pytest.mark.slow
def test_a_run_broken_off_goes_on_to_the_same_profiles(whole: Path, tmp_path: Path) -> None:
    broken_off(coated(), tmp_path / "run", 4_000)
    resume(tmp_path / "run", frames=0)
    assert_same_bits(whole, tmp_path / "run")
    with bw.open_result(whole) as result:
        assert result.sizes["wear_time"] >= 200
        assert result["coating_strain"].values[-1].max() > 0.0


@pytest.mark.slow
def test_the_predicted_size_includes_the_coating(whole: Path) -> None:
    predicted = stage_properties(build_beams(coated()))["result_bytes"]
    actual = (whole / "result.nc").stat().st_size
    assert predicted == expected_bytes(prepare(coated())) == pytest.approx(actual, rel=0.1)


def test_a_second_run_begins_with_the_profile_of_the_first(whole: Path) -> None:
    profile = {"file": str(whole / "wear.csv")}
    case = bw.with_values(coated(), {"casing.coating.profile": profile})
    with bw.open_result(whole) as first:
        worn = first["coating_strain"].values[-1]
    second = contact_problem(build_beams(case)).coating
    assert second is not None
    assert worn.max() > 0.0
    np.testing.assert_allclose(second.strain, worn, rtol=0.0, atol=1e-15)


def test_the_summary_has_the_wear(whole: Path) -> None:
    summary = json.loads((whole / "summary.json").read_text())
    with bw.open_result(whole) as result:
        wear = bw.wear(result)
        strain = result["coating_strain"].values[-1]
        assert summary["wear_strain_max"] == strain.max()
        assert summary["wear_volume"] == wear["wear_volume"].values[-1] > 0.0
        assert summary["metal_time"] is None
        assert sum(summary["coating_impulse"]) == pytest.approx(summary["contact_impulse"])
    assert summary["energy_residual"] < 1e-8


@pytest.mark.slow
def test_a_run_without_a_coating_has_no_wear(tmp_path: Path) -> None:
    plain = bw.run(small(**{"march.duration": 0.002}), tmp_path / "plain", frames=0)
    assert "wear_volume" not in json.loads(plain.summary.to_json())
    with bw.open_result(tmp_path / "plain") as result:
        assert "coating_strain" not in result
        with pytest.raises(ViewError, match=r"no casing.coating"):
            bw.wear(result)


@pytest.mark.parametrize("name", ["wear", "wear-profile", "wear-lobes", "wear-volume"])
def test_figures_of_the_wear(whole: Path, name: str) -> None:
    with bw.open_result(whole) as result:
        figure, data = RunFigures(result).draw(name)
    assert figure.axes
    assert data["recess"].max() > 0.0


def test_the_series_has_the_remaining_thickness(whole: Path, tmp_path: Path) -> None:
    with bw.open_result(whole) as result:
        bw.export_vtk(result, tmp_path / "vtk", frames=2)
    file = sorted((tmp_path / "vtk" / "frames").glob("coating*"))[-1]
    remaining = meshio.read(file).point_data["remaining_thickness"]
    assert 0.0 < remaining.min() < remaining.max() <= 5e-3


def test_lobes_are_counted_by_the_largest_harmonic() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    share = lobe_shares(2.0 + np.cos(7 * angle) + 0.5 * np.cos(3 * angle))
    assert int(share.argmax()) + 1 == 7
    assert share[6] == pytest.approx(0.8)
    assert share.sum() == pytest.approx(1.0)


def test_the_number_of_lobes_is_that_of_the_profile(whole: Path) -> None:
    with bw.open_result(whole) as result:
        rods = result.sizes["rod"]
        cut = 0.1 + 0.01 * np.cos(5.0 * 2.0 * np.pi * np.arange(rods) / rods)
        strain = np.broadcast_to(cut, result["coating_strain"].shape)
        round_wall = result.load().copy(deep=True)
    round_wall["coating_strain"] = round_wall["coating_strain"].dims, strain
    round_wall["clearance"] = 0.0 * round_wall["clearance"] + 1e-3
    assert bw.wear(round_wall).attrs["lobes"] == 5
    assert wear_summary(round_wall)["lobes"] == 5


def test_the_file_of_a_mesh_need_not_be_here_to_see_the_wear(whole: Path) -> None:
    """The case of a result names its mesh file, which lies in the folder of the run."""
    with bw.open_result(whole) as result:
        text = result.attrs["case"] + '\n[bladed_disk.mesh]\nfile = "elsewhere.msh"\n'
        moved = result.assign_attrs(case=text)
        for name in ("wear", "gaps"):
            RunFigures(moved).draw(name)
        at = np.array([0.5]), np.array([-1])
        assert track_strains(moved, at[1], at[0]) == track_strains(result, at[1], at[0])


def test_motions_of_modes_have_no_case() -> None:
    """Their attribute `case` is a title."""
    modes = xr.Dataset(attrs={"case": "Fan with foreshortening", "record_step": 1e-3})
    assert table_of_result(modes, "contact", Contact) == Contact()


def test_lobes_of_the_walls_own_shape_are_told_apart() -> None:
    """A cut on a circle in an oval wall, and seven lobes that vibration adds."""
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    oval = 1e-3 + 2e-4 * np.cos(2.0 * angle)
    cut = np.maximum(9e-4 - oval, 0.0)
    names = {"rod_angle": ("rod", angle), "wall_angle": ("node", angle)}
    for shape, lobes, explained in ((oval, 7, 0.95), (np.full(720, 1e-3), 2, 0.0)):
        result = xr.Dataset({**names, "clearance": ("node", shape), "time": ("time", [0.0, 1.0])})
        share, rest = lobes_of(result, cut + 5e-6 * (1.0 + np.cos(7.0 * angle)))
        assert int(rest.argmax()) + 1 == lobes
        assert share == pytest.approx(explained, abs=0.05)
        assert rest.sum() == pytest.approx(1.0, rel=1e-4)
    inverted = xr.Dataset({**names, "clearance": ("node", 2e-3 - oval), "time": ("time", [0.0])})
    assert lobes_of(inverted, cut)[0] == 0.0
