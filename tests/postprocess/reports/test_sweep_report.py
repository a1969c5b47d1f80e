"""`bladewhirl report` of sweeps: finished ones, ones with failed or missing points, none done."""

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from report_pages import Parsed, reported
from synthetic_result import synthetic_result
from synthetic_sweep import synthetic_sweep

import bladewhirl as bw
from bladewhirl.postprocess.plotting.registry import SWEEP_FIGURES
from bladewhirl.postprocess.reports import page as report_page
from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME

REFERENCE = 75.0  # rad/s
SPEEDS = (1.0, 1.2, 1.4, 1.6)
RADII = (0.4e-3, 1.3e-3, 1.2e-3)  # the clearance is 1 mm


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Free, in contact twice, failed."""
    motions = [
        *(
            {"speed": REFERENCE * speed, "shaft_radius": radius}
            for speed, radius in zip(SPEEDS, RADII, strict=False)
        ),
        None,
    ]
    over = {"march.speed": SPEEDS}
    return synthetic_sweep(tmp_path_factory.mktemp("sweeps") / "one", over, motions)


@pytest.fixture(scope="module")
def page(folder: Path) -> Parsed:
    return reported(folder)


@pytest.mark.slow
def test_it_has_its_figures(page: Parsed) -> None:
    of_beams = {
        name for name, kind in SWEEP_FIGURES.items() if "contact_spectrum" not in kind.needs
    }
    assert set(page.pictures) == of_beams - {"maps", "interaction", "probability", "wear"}


def test_the_verdict_counts_points(page: Parsed) -> None:
    words = page.words
    assert "Sustained contact at 2 of 3 points" in words
    assert "1 of 4 points failed; the reasons are listed under Points." in words
    assert "march.speed = 1.6 it could not be marched" in words
    assert "unfinished" not in words


def test_values_under_the_pointer_are_those_of_the_sweep(page: Parsed) -> None:
    (panel,) = [each for each in page.values["frequency-map"] if each["maps"]]
    (shown,) = panel["maps"]
    assert "mm" in shown["label"]
    columns = np.array(shown["values"], dtype=float)  # None is nan
    assert np.isnan(columns[:, 3]).all()  # the failed point
    np.testing.assert_allclose(np.nanmax(columns[:, :3], axis=0), [0.4, 1.3, 1.2], rtol=0.2)


CASE = "title = 'x'\n\n[casing]\nclearance = 5e-4\n\n[march]\nspeed = 1.2\nduration = 1.0\n"


@pytest.mark.slow
def test_two_keys_and_a_missing_point(tmp_path: Path) -> None:
    over = {"march.speed": (1.0, 1.2), "casing.clearance": (5e-4, 1e-3)}
    motions = [{"speed": REFERENCE, "shaft_radius": radius} for radius in (*RADII, RADII[0])]
    units = {"march.speed": "1", "casing.clearance": "m"}
    folder = synthetic_sweep(tmp_path / "two", over, motions, units=units, case=CASE)
    with h5py.File(folder / SWEEP_NAME, "r+") as file:
        file["state"][1, 0] = 0
    page = reported(folder)
    words = page.words
    assert re.search(r"\d of 3 points so far", words)
    assert "unfinished: 1 of 4 points are missing; bladewhirl sweep --resume" in words
    columns = "march.speed casing.clearance [mm] regime largest recorded displacement of the shaft"
    assert columns in words
    assert re.search(r"1 1 sustained 1\.3 ", words)
    window = "Spectra and mean energies are over the last 0.2 s of each march, at most 50% of it."
    assert words.count(window) == 2
    assert "Growth rates ± 2 standard errors." in words
    settings = "--set march.speed=VALUE --set casing.clearance=VALUE"
    assert f"{settings} (in SI units, or with a unit) repeats a point" in words


@pytest.mark.slow
def test_points_open_their_reports(tmp_path: Path) -> None:
    """Of a kept history: from its row in the table, and from its cell of the interaction map."""
    over = {"march.speed": (1.2, 1.0), "casing.clearance": (5e-4, 1e-3)}
    motions = [{"speed": REFERENCE, "shaft_radius": 1.3e-3, "records": 60}] * 4
    folder = synthetic_sweep(tmp_path / "two", over, motions)
    kept = folder / "histories" / "point_1.nc"
    kept.parent.mkdir()
    synthetic_result(**motions[1]).to_netcdf(kept, engine="h5netcdf")  # type: ignore[arg-type]
    assert bw.report(kept) == kept.with_suffix(".html")
    page = reported(folder)
    assert [link for link in page.references if "histories" in link] == ["histories/point_1.html"]
    (panel, *_) = [each for each in page.values["interaction"] if "links" in each]
    # The second clearance; the first speed is the larger one.
    assert panel["links"] == [[None, None], [None, "histories/point_1.html"]]


def test_a_sweep_without_a_point_done(tmp_path: Path) -> None:
    folder = synthetic_sweep(tmp_path / "none", {"march.speed": (1.0, 2.0)}, [None, None])
    page = reported(folder)
    assert "No result" in page.words
    assert "2 of 2 points failed" in page.words
    assert "Not drawn: no point of the sweep is finished" in page.words
    assert page.values == {}


@pytest.mark.parametrize(("radii", "named"), [((0.4e-3, 1.3e-3), ["1"]), ((0.4e-3, 0.4e-3), [])])
@pytest.mark.slow
def test_the_report_names_points_with_an_uncertain_outcome(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, radii: tuple[float, float], named: list[str]
) -> None:
    """Eight draws at two speeds; at the first speed every second draw touches or none."""
    monkeypatch.setattr(report_page, "report_figures", lambda figures, section, left_out: [])
    motions = [{"speed": REFERENCE, "shaft_radius": radii[n % 2]} for n in range(8)]
    motions += [{"speed": 1.2 * REFERENCE, "shaft_radius": 1.3e-3}] * 8
    over = {"march.speed": (1.0, 1.2), "draw": tuple(range(8))}
    folder = synthetic_sweep(tmp_path / "draws", over, motions)
    words = reported(folder).words
    if named:
        assert (
            "uncertain at 1 of 2 points, where the 95 % interval of the share of a regime" in words
        )
        assert "includes one half: speed = 1." in words
    else:
        assert "The outcome is certain at every point: the 95 % interval" in words
