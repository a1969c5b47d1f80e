"""Commands on a case with a shaft line."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from solid_meshes import STEEL, fan_sector

import bladewhirl as bw
from bladewhirl.models.shaft_line import hub_waves
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.file import write_superelement

pytestmark = pytest.mark.pictures

CASE = """
[shaft_line]
segments = [{ length = "1 m", outer_diameter = "50 mm", elements = 4 }]
disks = [{ position = 0.4, mass = 20, polar_inertia = 0.3, diametral_inertia = 0.16 }]
bearings = [
    { name = "front", position = 0.0, stiffness = "20 MN/m", damping = "1 kN s/m" },
    { position = "1 m", stiffness = [["20 MN/m", 0], [0, "10 MN/m"]], damping = "1 kN s/m" },
]
unbalance = [{ position = 0.4, unbalance = "1 kg mm" }]

[gravity]

[march]
speed = "3000 rpm"
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    file = tmp_path / "line.toml"
    file.write_text(CASE)
    return file


def test_modes_are_listed_at_the_speed_of_the_case_and_drawn(case: Path, tmp_path: Path) -> None:
    listed = answer("modes", case, "--count", 4, "-o", tmp_path / "modes")
    assert "backward" in listed.output
    assert (tmp_path / "modes" / "line-modes.png").exists()
    document = json.loads(answer("modes", case, "--json", "--count", 4).stdout)
    rows = document["shaft_line"]
    assert [row["direction"] for row in rows] == ["backward", "forward"] * 2
    assert all(row["decay_per_s"] < 0.0 for row in rows)
    modes = bw.line_modes(bw.read_case(case), count=4)
    assert [row["frequency_hz"] for row in rows] == modes["frequency"].values.tolist()
    largest = np.hypot(*np.moveaxis(modes["displacement"].values, 2, 0)).max(axis=(1, 2))
    assert largest == pytest.approx(1.0)


def test_critical_speeds_lie_on_the_line_of_the_campbell_diagram(
    case: Path, tmp_path: Path
) -> None:
    critical = json.loads(answer("critical-speeds", case, "--json").stdout)["shaft_line"]
    answer("campbell", case, "--speeds", "0:3", "-o", tmp_path / "campbell")
    diagram = json.loads(answer("campbell", case, "--json", "--speeds", "0:3").stdout)
    rpm, hertz = np.array(diagram["rpm"]), np.array(diagram["frequency_hz"])
    for number, row in enumerate(critical[:2]):
        at_speed = np.interp(row["rpm"], rpm, hertz[:, number])
        assert row["speed_rad_s"] / (2.0 * np.pi) == pytest.approx(at_speed, rel=1e-4)


def test_the_response_peaks_near_critical_speeds(case: Path, tmp_path: Path) -> None:
    critical = json.loads(answer("critical-speeds", case, "--json").stdout)["shaft_line"]
    speeds = "1000 rpm:8000 rpm:5 rpm"
    answer("response", case, "--speeds", speeds, "-o", tmp_path / "response")
    found = json.loads(answer("response", case, "--speeds", speeds, "--json").stdout)
    [peak] = [row for row in found["peaks"] if row["position"] == 0.4]
    nearest = min(abs(peak["rpm"] - row["rpm"]) for row in critical)
    assert nearest < 0.01 * peak["rpm"]


def test_stability_lists_the_speed_at_which_growth_begins(case: Path, tmp_path: Path) -> None:
    words = ["stability", case, "--set", "shaft_line.loss_time=1e-5"]
    assert "begins" in answer(*words, "-o", tmp_path / "stability").output
    assert (tmp_path / "stability" / "stability.png").exists()
    document = json.loads(answer(*words, "--json", "--speeds", "0:3:0.5").stdout)
    [border] = document["shaft_line"]
    rates = np.array(document["growth_rate"])
    assert border["growth"] == "begins"
    assert ((rates > 0.0) == (np.array(document["rpm"]) > border["rpm"])).all()
    speed = f"march.speed={border['rpm']} rpm"
    at_border = json.loads(answer("modes", case, *words[2:], "--set", speed, "--json").stdout)
    assert max(row["decay_per_s"] for row in at_border["shaft_line"]) == pytest.approx(
        0.0, abs=1e-6
    )
    assert document["point"]["growth"] == "stable"
    assert "neither begins nor ends" in answer("stability", case, "-o", tmp_path / "two").output


def test_show_lists_masses_and_static_loads(case: Path) -> None:
    derived = json.loads(answer("show", case, "--json").stdout)["derived"]
    forces = sum(row["force_y"] for row in derived["bearings"])
    assert forces == pytest.approx(9.81 * derived["mass"], rel=1e-9)
    assert derived["mass"] == pytest.approx(20.0 + 7800.0 * np.pi / 4.0 * 0.05**2, rel=1e-9)
    picture = case.with_name("line.png")
    assert "front" in answer("show", case, "--png", "-o", picture).output
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["periodic"], "the weight turns in rotating axes (gravity.acceleration: expected [0, 0])"),
        (["veering"], "shaft_line: not allowed here"),
        (["stability", "--kappa", "500"], "--kappa: not allowed with [shaft_line]"),
        (["modes", "--shapes", "1F", "-o", "x"], "--shapes: not allowed with [shaft_line]"),
        (["modes", "--set", "casing.clearance=0.002"], "clearance = 0.002 }: not allowed"),
        (["modes", "--set", "shaft_line.bearings.1.position=0"], "expected bearings that hold"),
        (["response", "--set", "shaft_line.unbalance=[]"], "shaft_line.unbalance: expected"),
        (
            ["show", "--set", "shaft_line.bearings.1.position=1.2"],
            "shaft_line.bearings[1].position = 1.2: expected a position on the shaft, from 0 m",
        ),
        (
            ["show", "--set", "shaft_line.disks.0.position=-0.1"],
            "shaft_line.disks[0].position = -0.1: expected a position on the shaft",
        ),
        (
            ["modes", "--set", "shaft_line.bearings.0.stiffness=[[1, 2], [3]]"],
            "shaft_line.bearings[0].stiffness = [[1, 2], [3]]: expected one number in N/m, or two",
        ),
        (["modes", "--set", "shaft_line.segments=[]"], "shaft_line.segments = []: expected at"),
    ],
)
def test_what_a_line_does_not_have_is_refused(words: list[str], said: str, case: Path) -> None:
    name, *options = words
    assert said in refusal(name, case, *options)


def test_a_steady_state_at_a_critical_speed_without_damping_is_refused(case: Path) -> None:
    undamped = []
    for key in ("0.damping=0", "1.damping=0", "1.stiffness=20 MN/m"):
        undamped += ["--set", f"shaft_line.bearings.{key}"]
    found = json.loads(answer("critical-speeds", case, *undamped, "--json").stdout)["shaft_line"]
    [first, *_] = [row["speed_rad_s"] for row in found if row["direction"] == "forward"]
    speeds = f"{first!r} rad/s:{2.0 * first!r} rad/s:{first!r} rad/s"
    said = f"speed {first:.6g} rad/s: expected another speed, or bearings with damping: it is a"
    assert said in refusal("response", case, *undamped, "--speeds", speeds)


FAN = """
title = "Overhung fan"

[bladed_disk.superelement]
file = "fan.npz"

[shaft_line]
segments = [{ length = "600 mm", outer_diameter = "50 mm", elements = 6 }]
wheel = { position = "600 mm" }
bearings = [
    { position = 0.0, stiffness = "20 MN/m", damping = "2 kN s/m" },
    { position = "400 mm", stiffness = "20 MN/m", damping = "2 kN s/m" },
]
unbalance = [{ position = "600 mm", unbalance = "100 g mm" }]

[gravity]

[march]
speed = "6000 rpm"
"""


@pytest.fixture
def fan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(hub_waves, "KEPT", 3)
    tie: dict[str, Any] = {"left": "left", "right": "right", "copies": 5}
    part = mesh3d(fan_sector(5), **STEEL, **tie, hub="root", stress=False)
    write_superelement(tmp_path / "fan.npz", part)
    file = tmp_path / "fan.toml"
    file.write_text(FAN)
    return file


def document(*words: Any) -> Any:
    return json.loads(answer(*words, "--json").stdout)


def test_modes_of_a_fan_on_its_shaft_are_listed_and_drawn(fan: Path, tmp_path: Path) -> None:
    answer("modes", fan, "--count", 8, "-o", tmp_path / "modes")
    rows = document("modes", fan, "--count", 8)["shaft_line"]
    whirls = [row["direction"] for row in rows]
    assert whirls[:2] == ["backward", "forward"]
    assert "torsional" in whirls
    derived = document("show", fan)["derived"]
    assert derived["mass"] == pytest.approx(derived["shaft_mass"] + derived["wheels"][0]["mass"])
    loads = sum(row["force_y"] for row in derived["bearings"])
    assert loads == pytest.approx(9.81 * derived["mass"], rel=1e-4)  # blades are displaced


@pytest.mark.slow
def test_the_response_of_a_fan_peaks_at_its_forward_critical_speed(
    fan: Path, tmp_path: Path
) -> None:
    critical = document("critical-speeds", fan, "--branches", 1)["shaft_line"]
    speeds = ["--speeds", "0 rpm:9000 rpm"]
    answer("campbell", fan, *speeds, "--families", 2, "-o", tmp_path / "campbell")
    diagram = document("campbell", fan, *speeds, "--families", 2)
    assert diagram["shaft_line"][0]["rpm"] == pytest.approx(critical[0]["rpm"], rel=1e-8)
    forward = next(row["rpm"] for row in critical if row["direction"] == "forward")
    response = document("response", fan, "--speeds", f"{forward - 400}rpm:{forward + 400}rpm:20rpm")
    [peak] = [row for row in response["peaks"] if row["position"] == 0.6]
    assert peak["rpm"] == pytest.approx(forward, rel=0.02)


def test_engine_orders_move_the_fan_and_its_shaft(fan: Path, tmp_path: Path) -> None:
    text = fan.read_text()
    orders = '[excitation]\ntype = "engine-order"\norder = [4, 5]\namplitude = "10 N"\n'
    fan.write_text(text + orders)
    changes = ["--set", "shaft_line.wheel.damping_ratio=0.01", "--speeds", "1000rpm:2000rpm:500rpm"]
    found = document("response", fan, *changes)
    assert {"peaks", "bearing_force"} < found.keys()
    own = found["engine_orders"]
    assert own["order"] == [4, 5]
    largest = np.hypot(own["tip_radial"], own["tip_tangential"]).max(axis=1)
    assert [row["tip"] for row in own["peaks"]] == pytest.approx(largest.tolist(), rel=1e-9)
    sideways, along = np.array(own["deflection"]).max(axis=(1, 2)), np.max(own["axial"], axis=1)
    assert (sideways > 0.0).tolist() == [True, False]
    assert (along > 0.0).tolist() == [False, True]
    answer("response", fan, *changes, "-o", tmp_path / "response")
    assert (tmp_path / "response" / "engine-orders.png").exists()
    assert "excitation.order = 3: expected" in refusal(
        "response", fan, *changes, "--set", "excitation.order=3"
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["modes", "--set", "shaft_line.wheel.position=1"], "shaft_line.wheel.position = 1: exp"),
        (["modes", "--set", "shaft.damping=2"], "damping"),
    ],
)
def test_what_a_fan_on_a_line_does_not_have_is_refused(
    words: list[str], said: str, fan: Path
) -> None:
    name, *options = words
    assert said in refusal(name, fan, *options)
