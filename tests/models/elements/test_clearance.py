"""Casings out of round: what the case takes, what the tips meet."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_cases import ledger_residual, run
from places import EXAMPLES
from stages import observed_order

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.file import loads, read_case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.elements.build import case_clearance
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.sections.wall import Lobe, RingProfile
from bladewhirl.models.stage.build import contact_problem, march_faults
from bladewhirl.models.stage.build_beams import build_beams

ELLIPSE = EXAMPLES / "elliptical_clearance.toml"


def lobed(elements: int, *rows: Mapping[str, object], clearance: float = 1e-3) -> Case:
    """A case with rows of lobes."""
    casing = {"elements": elements, "clearance": clearance, "clearance_lobes": rows}
    return case_from({"casing": casing, "reduction": {"fixed_interface_modes": 22}})


def test_gaps_at_rest_are_the_lobes_to_fourth_order() -> None:
    """At the tips, whose angles are no nodes', by the casing's cubic interpolation."""
    rows = ({"lobes": 2, "amplitude": "0.3 mm", "phase": "30 deg"}, {"lobes": 3, "amplitude": 1e-4})
    angle = 2.0 * np.pi * np.arange(22) / 22
    exact = 1e-3 + 3e-4 * np.cos(2 * (angle - np.pi / 6)) + 1e-4 * np.cos(3 * angle)
    errors = []
    for elements in (20, 40):
        problem = contact_problem(build_beams(lobed(elements, *rows)))
        errors.append(np.abs(problem.initial_gap() - exact).max())
    assert errors[0] < 1e-6
    assert observed_order(np.array(errors)) == pytest.approx(4.0, abs=0.5)


@pytest.mark.slow
def test_a_tip_touches_first_where_the_clearance_is_smallest() -> None:
    """The force turns with blade 0 and grows by a fifth of the lobes a revolution."""
    case = read_case(ELLIPSE)
    stage = build_beams(case)
    given = contact_problem(stage)
    _, chunk, _ = run(given, case.march.time_step, 300_000, every=100)
    assert ledger_residual(chunk) <= 1e-8
    touched = chunk.contact_steps > 0
    first = int(touched.any(axis=1).argmax())
    assert np.flatnonzero(touched[first]).tolist() == [0]
    angle = chunk.time[first] * given.speed
    np.testing.assert_allclose(
        stage.arrays.clearance, case_clearance(case)[:, 0], rtol=1e-14, atol=0.0
    )
    off = np.angle(np.exp(2j * (angle - np.deg2rad(120.0)))) / 2.0
    assert abs(np.rad2deg(off)) < 15.0


def test_the_profile_knows_its_slope_and_its_smallest_value() -> None:
    profile = RingProfile(
        mean=2.0,
        lobes=(Lobe(lobes=2, amplitude=0.5, phase=0.3), Lobe(lobes=5, amplitude=0.1, phase=1.0)),
    )
    angle, step = np.linspace(0.0, 7.0, 50), 1e-5
    central = (profile.value(angle + step) - profile.value(angle - step)) / (2 * step)
    np.testing.assert_allclose(profile.slope(angle), central, atol=1e-8)
    fine = profile.value(np.linspace(0.0, 2.0 * np.pi, 1_000_000)).min()
    assert profile.smallest == pytest.approx(fine, abs=1e-6)


def test_a_tip_that_starts_inside_a_lobe_is_a_fault() -> None:
    rows = [[0.0, 0.0]] * 22
    rows[0] = [0.8e-3, 0.0]
    outward = {"initial": {"tip_displacement": rows}, "reduction": {"fixed_interface_modes": 22}}
    round_casing = build_beams(case_from(outward))
    assert not list(march_faults(round_casing, ()))
    tight = {"lobes": 1, "amplitude": 3e-4, "phase": "180 deg"}
    given = case_from(outward | {"casing": {"clearance_lobes": [tight]}})
    [fault] = march_faults(build_beams(given), ())
    assert "blade 0 starts 0.0008 m outward, but its clearance is 0.0007 m" in str(fault)


def measured(folder: Path, heading: str, rows: FloatArray) -> Case:
    """A case with a file of a measured wall beside it."""
    lines = [heading, *(f"{a:.17g},{b:.17g}" for a, b in rows)]
    (folder / "wall.csv").write_text("\n".join(lines), encoding="utf-8")
    (folder / "case.toml").write_text('[casing.profile]\nfile = "wall.csv"\n', encoding="utf-8")
    return read_case(folder / "case.toml")


def test_a_measured_ellipse_is_two_lobes(tmp_path: Path) -> None:
    degrees = np.arange(0.0, 361.0, 0.5)[:-1]  # the first point once more at the end
    clearance = 1.0 + 0.2 * np.cos(np.radians(2.0 * (degrees - 30.0)))
    heading = "clearance [mm],angle [deg]"
    case = measured(tmp_path, heading, np.column_stack([clearance, degrees]))
    lobe = {"lobes": 2, "amplitude": "0.2 mm", "phase": "30 deg"}
    expected = case_clearance(lobed(40, lobe))
    np.testing.assert_allclose(case_clearance(case), expected, rtol=0.0, atol=1e-11)
    harmonics = case_from({"casing": {"profile": {"harmonics": [lobe]}}})
    np.testing.assert_array_equal(case_clearance(harmonics), expected)
    assert loads(dumps_case(case)) == case


@pytest.mark.parametrize(
    ("heading", "rows", "complaint"),
    [
        ("angle,clearance", [[0.0, 1.0]], r'expected "angle \[deg\],clearance \[mm\]"'),
        ("angle [deg],clearance [kg]", [[0.0, 1.0]], "kilogram is"),
        ("angle [deg],clearance [mm]", [[0.0, 1.0]] * 9, "one value at each angle"),
        ("angle [deg],clearance [mm]", [[0.0, 1.0]], "8 to 20000 points, not 1"),
        ("angle [deg],clearance [mm]", np.zeros((0, 2)), "8 to 20000 points in .*, not 0"),
        ("angle [deg],clearance [mm]", [[a, a] for a in (*range(10, 90, 10), 370)], "one value"),
        ("angle [deg],clearance [mm]", [[a, 1.0] for a in (*range(10, 90, 10), -350)], "one value"),
        ("angle [deg],clearance at" + " " * 100_000 + "[mm]", [[0.0, 1.0]], "more than 1000 char"),
        ("angle [deg],clearance at" + " " * 900 + "[mm]", [[0.0, 1.0]], "as the first line"),
        ("angle [rad],clearance [mm]", [[k, -1.0] for k in range(6)] + [[6, 1], [7, 1]], "a gap"),
    ],
)
def test_a_measured_wall_that_cannot_be(
    heading: str, rows: list[list[float]], complaint: str, tmp_path: Path
) -> None:
    with pytest.raises(CaseError, match=complaint):
        measured(tmp_path, heading, np.array(rows))


@pytest.mark.parametrize("key", ["profile", "coating.profile"])
@pytest.mark.parametrize("place", ["/dev/zero", "pipe"])
def test_a_wall_is_not_read_from_pipes_and_devices(key: str, place: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "case.toml").write_text(
        f'[casing]\n{key}.file = "{place}"\n{SOFT if key != "profile" else ""}'
    )
    with pytest.raises(CaseError, match="it is not a regular file"):
        read_case(tmp_path / "case.toml")


def test_a_file_of_a_wall_is_of_limited_size(tmp_path: Path) -> None:
    with (tmp_path / "wall.csv").open("wb") as stream:
        stream.truncate(10**12)  # needs no space on the disk
    (tmp_path / "case.toml").write_text('[casing.profile]\nfile = "wall.csv"\n')
    with pytest.raises(CaseError, match="larger than 2 GB"):
        read_case(tmp_path / "case.toml")


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_a_wall_of_excel_is_read(ends: str, tmp_path: Path) -> None:
    rows = [f"{angle},{1 + 0.2 * (angle % 180 < 90)}" for angle in range(0, 360, 30)]
    text = ends.join(["\ufeffangle [deg],clearance [mm]", *rows])
    (tmp_path / "wall.csv").write_bytes(text.encode("utf-8"))
    (tmp_path / "case.toml").write_text('[casing.profile]\nfile = "wall.csv"\n')
    profile = read_case(tmp_path / "case.toml").casing.profile
    assert profile is not None
    assert len(profile.points) == 12


@pytest.mark.parametrize("profile", [{}, {"points": []}, {"points": (), "harmonics": []}])
def test_an_empty_profile_is_not_a_round_wall(profile: dict[str, Any]) -> None:
    with pytest.raises(CaseError, match="expected points, a file or harmonics"):
        case_from({"casing": {"profile": profile}})
    layer = {"thickness": 1e-3, "young_modulus": 1e9, "yield_stress": 1e6}
    worn: dict[str, Any] = {key: [] for key in profile if key == "points"}
    with pytest.raises(CaseError, match="expected points, tracks, a file or lobes"):
        case_from({"casing": {"coating": layer | {"profile": worn}}})


def test_a_clearance_has_no_axial_positions(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"one column without an axial position in .*wall\.csv"):
        measured(tmp_path, "angle [deg],clearance at 1 mm [mm]", np.ones((9, 2)))


SOFT = """coating.thickness = "1 mm"
coating.young_modulus = "1 GPa"
coating.yield_stress = "1 MPa"
"""


def worn(folder: Path, *lines: str) -> Case:
    """A case with a worn profile beside it."""
    (folder / "wear.csv").write_text("\n".join(lines), encoding="utf-8")
    text = f'[casing]\n{SOFT}coating.profile.file = "wear.csv"\n'
    (folder / "case.toml").write_text(text, encoding="utf-8")
    return read_case(folder / "case.toml")


def test_a_worn_profile_is_read_beside_the_case(tmp_path: Path) -> None:
    case = worn(tmp_path, "recess [um],angle [deg]", *(f"{k},{40 * k}" for k in range(9)))
    assert case.casing.coating is not None
    assert case.casing.coating.profile is not None
    assert len(case.casing.coating.profile.points) == 9
    assert case.casing.coating.profile.recess(np.radians([60.0, 80.0])) == pytest.approx(
        [1.5e-6, 2e-6]
    )


@pytest.mark.parametrize(
    ("heading", "row", "complaint"),
    [
        ("recess at 0 mm [mm]", "1", "as the first line of"),
        ("angle [deg],recess [mm],recess [mm]", "{},0,0", "without axial positions"),
        ("angle [deg],recess at 1 mm [mm],recess [mm]", "{},0,0", "without axial positions"),
        ("angle [deg],recess at 1 mm [mm],recess at 0.1 cm [mm]", "{},0,0", "two columns"),
        ("angle [deg],recess at 1 kg [mm]", "{},0", "kilogram is"),
        ("angle [deg],recess at 1 mm [mm],recess at 2 mm [mm]", "{},0", "3 numbers in line 2"),
        ("angle [deg],recess at 1 mm [mm]", "0,{}", "one value at each angle"),
        (
            "angle [deg],recess at 1 mm [mm],recess at 2 mm [mm]",
            "{},0,0.95",
            "a removed depth up to",
        ),
        ("angle [deg],recess at 1 mm [mm],recess at 2 mm [mm]", "{},0,0.1", "or a bladed_disk"),
    ],
)
def test_a_worn_profile_that_cannot_be(
    heading: str, row: str, complaint: str, tmp_path: Path
) -> None:
    with pytest.raises(CaseError, match=complaint) as error:
        worn(tmp_path, heading, *(row.format(30 * k) for k in range(12)))
    assert len(error.value.lines) == 1


def test_tracks_exclude_points_and_each_other() -> None:
    points = [[float(k), 0.0] for k in range(6)] + [[5.5, 0.0], [5.8, 0.0]]
    layer = {"thickness": 1e-3, "young_modulus": 1e9, "yield_stress": 1e6}
    track = {"axial": "1 mm", "points": points}
    for profile, complaint in (
        ({"tracks": [track], "points": points}, "either points or tracks"),
        ({"tracks": [track, track]}, "one track at each axial position"),
        ({"tracks": [track], "file": "wear.csv"}, "either points or file"),
    ):
        with pytest.raises(CaseError, match=complaint):
            case_from({"casing": {"coating": layer | {"profile": profile}}})
