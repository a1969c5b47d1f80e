"""Changes of single keys, as `--set` takes them."""

from typing import Any

import pytest
from faults import faults

from bladewhirl.models.case.analysis import Initial
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.models.case.file import loads
from bladewhirl.models.inputs.units import Speed


@pytest.mark.parametrize(
    ("override", "key", "value"),
    [
        ("march.speed=1.2", "march.speed", Speed(1.2)),
        ("march.speed=2500 rpm", "march.speed", Speed("2500 rpm")),
        ('march.speed="2500 rpm"', "march.speed", Speed("2500 rpm")),
        ("casing.curvature=shallow", "casing.curvature", "shallow"),
        ("contact.tip_rotation=true", "contact.tip_rotation", True),
        ("bladed_disk.blade.thickness=0.02", "bladed_disk.blade.thickness", 0.02),
        ("bladed_disk.blade={width=0.2}", "bladed_disk.blade.thickness", 0.01),
        ("title=a = b", "title", "a = b"),
        ('excitation={type="imbalance"}', "excitation", Imbalance()),
        ("excitation.type=imbalance", "excitation", Imbalance()),
        ("initial.centre_velocity=[1, 0]", "initial", Initial(centre_velocity=(1.0, 0.0))),
    ],
)
def test_overrides(override: str, key: str, value: object) -> None:
    text = "bladed_disk.blade = { width = 0.3, thickness = 0.03 }\nmarch.speed = 7"
    actual: Any = loads(text, overrides=[override])
    for part in key.split("."):
        actual = getattr(actual, part)
    assert actual == value


def test_overrides_leave_the_rest_of_an_inline_table_and_the_last_wins() -> None:
    text = "bladed_disk.blade = { width = 0.3, thickness = 0.03 }"
    key = "bladed_disk.blade.thickness"
    blade = loads(text, overrides=[f"{key}=1 cm", f"{key}=2 cm"]).bladed_disk.blade
    assert (blade.width, blade.thickness) == (0.3, 0.02)


@pytest.mark.parametrize(
    ("override", "line"),
    [
        ("march.speed", "--set march.speed: expected KEY=VALUE"),
        ("march.speed=", '--set: march.speed = "": expected a TOML value'),
        ("march.speed=[1", '--set: march.speed = "[1": expected a TOML value'),
        ("march.speed=1\ntitle='b'", "expected a TOML value"),
        ("march.speed=fast", '--set: march.speed = "fast": expected a number'),
        ("march.sped=1", "--set: march.sped = 1: expected a known key; the nearest is march.speed"),
        ("title.x=1", "--set: title = { x = 1 }: expected text"),
        (
            "initial.tip_velocity=[[1]]",
            "--set: initial.tip_velocity[0] = [1]: expected two velocities in m/s",
        ),
    ],
)
def test_faults_of_overrides_are_not_put_on_the_file(override: str, line: str) -> None:
    [by_hand] = faults(loads, "bladed_disk.blades = 22", file="a.toml", overrides=[override])
    assert line in by_hand


def test_faults_of_the_file_are_put_on_the_file() -> None:
    text = "march.speed = 2\ndamping.ratio = -1"
    by_hand, in_file = sorted(faults(loads, text, file="a.toml", overrides=["march.sped=1"]))
    assert by_hand.startswith("--set: march.sped = 1")
    assert in_file.startswith("a.toml: damping.ratio = -1: expected")
