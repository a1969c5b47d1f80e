"""Warnings about implausible input: each where it applies, none for the examples."""

from pathlib import Path

import numpy as np
import pytest
from command_line import answer
from stages import SMALL, stage, steel

from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.file import with_values
from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.hints import stage_hints
from bladewhirl.studies.runs.prepare import prepare


def strut(**values: float) -> dict[str, float]:
    return {"angle": 0.0, "width": 0.01, "thickness": 0.01, "length": 0.3, **values}


@pytest.mark.parametrize(
    ("key", "value", "hint"),
    [
        ("material.young_modulus", 210e3, "material.young_modulus = 210000.0: expected 1e+09 to"),
        ("material.density", 7.8, "material.density = 7.8: expected 500 to 25000 kg/m3"),
        ("bladed_disk.tip_radius", 500, "bladed_disk.tip_radius = 500.0: expected 0.01 to 10 m"),
        ("casing.clearance", 1e-29, "casing.clearance = 1e-29: expected 5e-07 to 0.05 m, or 0"),
        ("coupling.stiffness", 1e20, "coupling.stiffness = 1e+20: expected at most 1e+13 N/m"),
        ("casing.struts", [strut(length=1e6)], "casing.struts[0].length = 1000000.0: expected at "),
        ("contact.friction", 1e29, "contact.friction = 1e+29: expected at most 2 for dry metals"),
        (
            "excitation",
            {"type": "imbalance", "unbalance": 1e9},
            "excitation.unbalance = 1000000000.0: expected at most 1000 kg m",
        ),
        ("damping.ratio", 5e9, "damping.ratio = 5000000000.0: expected at most 0.5 for modes"),
    ],
)
def test_implausible_values_are_named(key: str, value: object, hint: str) -> None:
    [line] = case_hints(with_values(Case(), {key: value}))
    assert line.startswith(f"unusual {hint}")


ARC = {"start": 0.0, "end": 1.0}


@pytest.mark.parametrize(
    ("key", "value", "likely"),
    [
        ("material.young_modulus", 114.0, "perhaps 114 is in GPa"),
        ("material.young_modulus", 210e3, "perhaps 210000 is in MPa"),
        ("material.young_modulus", 210e6, "perhaps 2.1e+08 is in kPa, or MPa where GPa was meant"),
        ("material.density", 7.8, "perhaps 7.8 is in g/cm3"),
        ("material.density", 4430e3, "perhaps 4.43e+06 is in g/m3"),
        ("material.density", 7.8e-9, "perhaps 7.8e-09 is in t/mm3"),
        ("material.density", 7.8e-6, "perhaps 7.8e-06 is in kg/mm3"),
        ("casing.stiffened_arcs", [ARC | {"density": 4.43}], "perhaps 4.43 is in g/cm3"),
        ("casing.stiffened_arcs", [ARC | {"young_modulus": 70.0}], "perhaps 70 is in GPa"),
        ("bladed_disk.tip_radius", 500, "perhaps 500 is in mm"),
        (
            "bladed_disk",
            {"tip_radius": "0.5 mm", "disk_radius": "0.05 mm"},
            "perhaps 0.0005 is in m, where mm was written",
        ),
        ("casing.clearance", 1, "perhaps 1 is in mm"),
        ("casing.wall", {"width": 100.0, "thickness": 0.01}, "perhaps 100 is in mm"),
    ],
)
def test_the_likely_unit_is_named(key: str, value: object, likely: str) -> None:
    lines = case_hints(with_values(Case(), {key: value}))
    assert likely in lines[0]


@pytest.mark.parametrize(
    ("key", "value", "likely"),
    [
        ("material.density", 7.8, "material.density = 7.8: expected .* is in g/cm3"),
        ("material.density", 7.8e-9, "material.density = 7.8e-9: expected .* is in t/mm3"),
    ],
)
def test_a_critical_time_step_names_its_probable_cause(
    key: str, value: object, likely: str
) -> None:
    given = {"bladed_disk": {"blades": 6, "elements_per_blade": 2}, "march": {"time_step": 5e-6}}
    case = with_values(case_from(given | {"casing": {"elements": 12}}), {key: value})
    with pytest.raises(
        CaseError, match=f"less than the critical step .*; the cause may be {likely}"
    ):
        prepare(case)


def test_a_critical_time_step_of_plausible_materials_has_no_other_cause() -> None:
    with pytest.raises(CaseError, match=r"reduction\.fixed_interface_modes\)$"):
        prepare(with_values(Case(), {"march.time_step": 5e-5, "march.record_step": 5e-5}))


def test_named_materials_are_checked_too() -> None:
    named = [{"name": "ti", "young_modulus": 114.0, "density": 4430.0}]
    [line] = case_hints(with_values(Case(), {"material.named": named}))
    assert line.startswith("unusual material.named[0].young_modulus = 114.0")


@pytest.mark.parametrize(("duration", "hints"), [(0.2, 0), (0.199, 1), (0.0, 0)])
def test_a_ramp_longer_than_the_march(duration: float, hints: int) -> None:
    values = {"excitation": {"type": "imbalance"}, "march.duration": duration}
    lines = case_hints(with_values(Case(), values))
    assert len(lines) == hints
    assert all("excitation.ramp = 0.2 s exceeds march.duration = 0.199 s" in x for x in lines)


def test_a_stage_far_too_soft() -> None:
    soft = stage(*SMALL, "material.young_modulus=210e3")
    hertz = soft.reference_frequency / (2.0 * np.pi)
    assert hertz < 1.0
    assert f"the unit of speeds, is {hertz:.3g} Hz" in stage_hints(soft)[1]
    assert stage_hints(stage(*SMALL)) == ()


def fan(*, tips: int, ends: float = 0.5) -> Sketch:
    """Return a fan of five blades: the first ones are tips, the others end at another radius."""
    sketch = Sketch(1)
    sketch.node("hub", 0.0, 0.0)
    for blade in range(5):
        angle = 0.4 * np.pi * blade
        radius = 0.5 if blade < tips else ends
        sketch.node(f"tip {blade}", radius * np.cos(angle), radius * np.sin(angle))
        sketch.member(f"blade {blade}", "hub", f"tip {blade}", steel(0.01), elements=2)
    sketch.set("centre", "hub")
    sketch.set("tips", *[f"tip {blade}" for blade in range(tips)])
    return sketch


@pytest.mark.parametrize(("tips", "ends", "free"), [(5, 0.5, 0), (3, 0.5, 2), (3, 0.4, 0)])
def test_free_blade_ends_outside_the_set_of_tips(tips: int, ends: float, free: int) -> None:
    case = fan(tips=tips, ends=ends).case(reduction={"fixed_interface_modes": 5})
    lines = stage_hints(build_beams(case))
    assert len(lines) == (free > 0)
    if free:
        assert lines[0].startswith(
            "2 free ends at the radius of the 3 tips but not in their set, the first"
        )
        assert "(-0.4045, -0.2939) m" in lines[0]


@pytest.mark.parametrize(("damper", "hints"), [(0.0, 1), (2e3, 0)])
def test_whirl_fed_by_internal_damping(damper: float, hints: int) -> None:
    case = with_values(
        Case(),
        {
            "bladed_disk.elements_per_blade": 2,
            "reduction.fixed_interface_modes": 22,
            "rotation.effects": "full",
            "march.speed": 2.5,
            "damping.ratio": 0.005,
            "shaft": {"damping": damper, "damping_frame": "static"},
        },
    )
    stage = build_beams(case)
    assert stage.rotor.frequency.min() < 0.0
    lines = stage_hints(stage)
    assert len(lines) == hints
    assert all(line.startswith("internal damping destabilises the bladed disk") for line in lines)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    tables = "bladed_disk = { blades = 5, elements_per_blade = 2 }\ncasing.elements = 20\n"
    path.write_text(f"{tables}reduction.fixed_interface_modes = 5\nmarch.duration = 1e-3\n")
    return path


def test_commands_print_hints_and_continue(path: Path) -> None:
    done = answer("show", path, "--set", "casing.clearance=0.06")
    assert "Hint: unusual casing.clearance = 0.06: expected 5e-07 to 0.05 m" in done.stderr
