"""The [[sensor]] tables: written and read back, and refused by key, value and expectation."""

from pathlib import Path

import numpy as np
import pytest
from faults import fault
from solid_meshes import STEEL, TIE, bladed_sector

import bladewhirl as bw
from bladewhirl.models.case.case import case_from
from bladewhirl.models.case.file import loads
from bladewhirl.models.case.gauge_positions import gauge_hints
from bladewhirl.models.case.sensors import StrainGauge
from bladewhirl.models.case.template import template
from bladewhirl.models.inputs.errors import CaseError

GAUGE = {"type": "strain", "span": 0.1}

TEXT = """
[[sensor]]
type = "strain"
element = 0
blade = 3
side = "-theta"
[[sensor]]
type = "tip-timing"
probes = "90 deg"
noise = "1 us"
sampling_rate = "80 MHz"
[[sensor]]
type = "wall"
angle = "-90 deg"
quantity = "velocity"
noise = "1 mm/s"
[[sensor]]
type = "centre"
name = "x.1"
"""


def test_a_case_with_sensors_is_written_and_read_back() -> None:
    case = loads(TEXT)
    assert loads(bw.dumps_case(case)) == case
    names = [sensor.label for sensor in case.sensor]
    assert names == ["strain-blade-3-element-0-minus", "tip-timing-90", "wall-270-velocity", "x.1"]
    assert [sensor.noise for sensor in case.sensor] == [0.0, 1e-6, 1e-3, 0.0]
    assert case.sensor[1].sampling_rate == 8e7
    faster = bw.with_values(case, {"march.speed": 1.2})
    assert faster.sensor == case.sensor


def test_sensors_are_set_as_rows() -> None:
    case = loads(TEXT, overrides=['sensor=[{type="strain",span=0.1}]', "march.speed=1.2"])
    assert [sensor.label for sensor in case.sensor] == ["strain-0.1"]


def test_a_case_without_sensors_has_no_key_of_sensors() -> None:
    assert "sensor" not in bw.dumps_case(bw.Case())
    text = template()
    assert loads(text) == bw.Case()
    commented = text[text.index("# [[sensor]]") :]
    uncommented = "\n".join(line[2:] for line in commented.splitlines() if line[:2] == "# ")
    assert len(loads(uncommented).sensor) == 4


@pytest.mark.parametrize(
    ("sensor", "line"),
    [
        ({"type": "strian"}, 'type = "strian": expected "strain" or "tip-timing" or "wall" or'),
        ({"span": 0.1}, 'type: expected "strain" or'),
        (GAUGE | {"span": 2}, "span = 2: expected a number from 0 at the root to 1 at the tip"),
        (GAUGE | {"element": 0}, "span = 0.1: expected one of span, element, gauge, point"),
        ({"type": "strain"}, "span: expected one of span, element, gauge, point"),
        (GAUGE | {"blade": 22}, 'blade = 22: expected "all" or a blade from 0 to 21'),
        (GAUGE | {"blade": -1}, 'blade = -1: expected "all" or the number of a blade, from 0'),
        (GAUGE | {"name": "a/b"}, 'name = "a/b": expected up to 60 letters'),
        (GAUGE | {"name": "time"}, 'name = "time": expected up to 60 letters'),
        (GAUGE | {"name": "Wear"}, 'name = "Wear": expected up to 60 letters'),
        (GAUGE | {"sampling_rate": 0}, "sampling_rate = 0: expected a positive number in Hz"),
        (GAUGE | {"angle": 0}, 'angle = 0: expected a key of sensor.type = "strain"; this key'),
        (GAUGE | {"spam": 0}, "spam = 0: expected a known key; the nearest is sensor[0].span"),
        ({"type": "tip-timing", "probes": []}, "probes = []: expected an angle such as"),
        ({"type": "tip-timing", "probes": [0, 90]}, "probes[1] = 90: expected an angle within a"),
        ({"type": "tip-timing", "probes": [0.1] * 1001}, "probes = [0.1, 0.1"),
        ({"type": "wall"}, "angle: expected a value for angle"),
        (
            {"type": "wall", "angle": 0, "quantity": "velocity", "noise": "1 mm"},
            'noise = "1 mm": expected a number of zero or more in m/s',
        ),
        ({"type": "centre", "quantity": "speed"}, 'quantity = "speed": expected "displacement"'),
    ],
)
def test_faults_name_key_value_and_expectation(sensor: dict[str, object], line: str) -> None:
    assert fault(case_from, {"sensor": [sensor]}).startswith(f"sensor[0].{line}")


def test_each_sensor_has_a_name_of_its_own() -> None:
    line = fault(case_from, {"sensor": [GAUGE, GAUGE | {"blade": 2}, GAUGE | {"seed": 1}]})
    expected = "expected a different name; sensor[0] has this one"
    assert line == f'sensor[2].name = "strain-0.1": {expected}'
    assert "expected rows of" in fault(case_from, {"sensor": GAUGE})


def test_the_name_of_many_probes_is_short() -> None:
    angles = np.linspace(0.0, 6.0, 100).tolist()
    [sensor] = case_from({"sensor": [{"type": "tip-timing", "probes": angles}]}).sensor
    assert sensor.label == "tip-timing-0-to-343.775-100-probes"
    again = {"type": "tip-timing", "probes": angles, "name": sensor.label}
    assert case_from({"sensor": [again]}).sensor[0].label == sensor.label


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_gauge_at_a_position_is_at_the_nearest_point_in_the_axes_of_the_mesh(
    tmp_path: Path, axis: str
) -> None:
    order = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[axis]  # of a mesh about z
    mesh = bladed_sector("tetra10")
    mesh.points = mesh.points[:, order]
    part = bw.mesh3d(mesh, **STEEL, **TIE, contacts=2, axis=axis)
    bw.write_superelement(tmp_path / "part.npz", part)
    assert part.points is not None
    gauge = {
        "type": "strain",
        "name": "gauge at the root",
        "position": (part.points[17] + 1e-6)[order].tolist(),
        "direction": np.array([1.0, 2.0, 3.0])[order].tolist(),
    }
    table = {"superelement": {"file": str(tmp_path / "part.npz")}}
    case = case_from({"bladed_disk": table, "casing": {"type": "rigid"}, "sensor": [gauge]})
    [found] = case.sensor
    assert isinstance(found, StrainGauge)
    assert (found.point, found.direction) == (17, (1.0, 2.0, 3.0))
    assert found.label == "gauge at the root"
    assert case_from(case.model_dump(exclude_none=True)) == case
    [hint] = gauge_hints(case.sensor, part)
    assert "is at point 17 of the surface" in hint
    assert "0.00173 mm from its position" in hint
    del gauge["position"]
    tables = {"bladed_disk": table, "casing": {"type": "rigid"}, "sensor": [gauge]}
    gauge["group"] = "tip"
    [of_group] = case_from(tables).sensor
    assert isinstance(of_group, StrainGauge)
    assert of_group.point is not None
    tips = np.array(mesh.points[mesh.point_sets["tip"]])
    middle = tips[np.linalg.norm(tips - tips.mean(axis=0), axis=1).argmin()]
    assert part.points[of_group.point][order] == pytest.approx(middle)
    [hint] = gauge_hints((of_group,), part)
    assert hint.endswith(", 0 mm from its group")
    gauge["group"] = "TOP"
    known = ", ".join(part.groups)
    with pytest.raises(CaseError, match=rf'sensor\[0\].group = "TOP": .*part.npz: {known}'):
        case_from(tables)
    gauge["group"] = "tip"
    gauge.pop("direction")
    with pytest.raises(CaseError, match="both point, position or group and direction"):
        case_from(tables)


def test_a_gauge_at_a_position_needs_a_superelement() -> None:
    gauge = {"type": "strain", "position": [0.1, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]}
    with pytest.raises(CaseError, match="superelement whose file has points"):
        case_from({"sensor": [gauge]})
