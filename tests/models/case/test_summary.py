"""The summary of a case: one screen, in units that suit, of what the case uses."""

from pathlib import Path

import pytest

import bladewhirl as bw
from bladewhirl.models.case.file import loads
from bladewhirl.models.inputs.units import handy, handy_unit, to_si

EXAMPLES = Path(__file__).parents[3] / "examples"

FAN = """\
Case "Fan stage"
  bladed disk  22 blades, 50 mm to 500 mm, 100 mm x 10 mm, 10 elements each, disk of spokes and rim
  material     210 GPa, 7800 kg/m3, where sections name no other
  shaft        34 MN/m
  casing       clearance 1 mm, wall 100 mm x 10 mm, 40 elements, support 1.508 kN/m2, rotation fixed
  contact      friction 0.1, permanent sliding
  excitation   none
  speed        1.05 x reference frequency
  march        3 s in steps of 1 µs, recorded every 0.1 ms, modes all, damping 0.5 %"""


def small_sketch() -> bw.Sketch:
    sketch = bw.Sketch(sectors=12)
    sketch.node("hub", 0.0, shared=True)
    sketch.node("tip", "400 mm")
    section = bw.Section(width="100 mm", thickness="10 mm", material=bw.Material())
    sketch.member("blades", "hub", "tip", section)
    sketch.set("centre", "hub")
    sketch.set("tips", "tip")
    return sketch


def test_the_default_case_on_one_screen() -> None:
    assert repr(bw.Case()) == str(bw.Case()) == FAN


def test_default_blades_are_not_shown_beside_a_sketch() -> None:
    case = small_sketch().case(march={"speed": "2500 rpm"}, initial={"centre_velocity": [1, 0]})
    assert "bladed disk  sketch of 12 sectors, 12 tips at 400 mm, members blades\n" in repr(case)
    assert "initial      centre_velocity\n  speed        2500 rpm\n" in repr(case)
    assert "22 blades" not in repr(case)
    text = bw.dumps_case(case)
    assert "bladed_disk" not in text
    assert "bladed_disk" not in case.model_dump()
    assert loads(text) == case
    before = f"{text}[bladed_disk]\nblades = 22\n"  # earlier versions wrote its defaults
    assert loads(before) == case


def test_default_blades_are_not_shown_beside_a_mesh() -> None:
    case = bw.read_case(EXAMPLES / "shrouded_fan.toml")
    assert "bladed disk  mesh shrouded_fan.msh, 12 tips at 400 mm, disk, blades, shroud" in repr(
        case
    )


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_examples_fit_on_a_screen(path: Path) -> None:
    lines = repr(bw.read_case(path)).splitlines()
    assert len(lines) <= 12
    assert max(map(len, lines)) <= 180


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
