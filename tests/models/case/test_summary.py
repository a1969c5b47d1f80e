"""Representation of a case and handy units."""

import pytest

import bladewhirl as bw
from bladewhirl.models.case.file import loads
from bladewhirl.models.inputs.units import handy, handy_unit, to_si


def small_sketch() -> bw.Sketch:
    sketch = bw.Sketch(sectors=12)
    sketch.node("hub", 0.0, shared=True)
    sketch.node("tip", "400 mm")
    section = bw.Section(width="100 mm", thickness="10 mm", material=bw.Material())
    sketch.member("blades", "hub", "tip", section)
    sketch.set("centre", "hub")
    sketch.set("tips", "tip")
    return sketch


def test_the_representation_shows_what_differs_from_the_defaults() -> None:
    case = bw.Case(excitation={"type": "harmonic", "force": 1e3}, march={"speed": "2500 rpm"})
    assert repr(case) == str(case)
    assert repr(case).splitlines()[1:] == [
        '  excitation   { type = "harmonic" }',
        '  march        { speed = "2500 rpm" }',
    ]


def test_default_blades_are_not_shown_beside_a_sketch() -> None:
    case = small_sketch().case(march={"speed": "2500 rpm"}, initial={"centre_velocity": [1, 0]})
    assert "\n  sketch       { sectors = 12, nodes = [" in repr(case)
    assert "initial      { centre_velocity = [1.0, 0.0] }\n" in repr(case)
    assert "bladed_disk" not in repr(case)
    text = bw.dumps_case(case)
    assert "bladed_disk" not in text
    assert "bladed_disk" not in case.model_dump()
    assert loads(text) == case
    before = f"{text}[bladed_disk]\nblades = 22\n"  # earlier versions wrote its defaults
    assert loads(before) == case


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.5, "m", "500 mm"),
        (4e-4, "m", "0.4 mm"),
        (5e-5, "m", "50 µm"),
        (1e-6, "s", "1 µs"),
        (0.2, "s", "0.2 s"),
        (0.0, "N", "0 N"),
        (-0.59, "kg m", "-590 g m"),
        (3e8, "Pa", "300 MPa"),
    ],
)
def test_handy_units_are_read_back(value: float, unit: str, text: str) -> None:
    assert handy(value, unit) == text
    assert to_si(text, unit) == pytest.approx(value, rel=1e-12)
    assert handy_unit(1e9, "rad/s") == ("rad/s", 1.0)
