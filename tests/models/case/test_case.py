"""The case: its defaults, what each key accepts, what does not fit together."""

import math
from pathlib import Path
from typing import Any, Literal, get_origin

import numpy as np
import pytest
from faults import fault, faults
from places import ROOT
from pydantic import ValidationError

from bladewhirl.models.case.analysis import Initial, March
from bladewhirl.models.case.bladed_disk import BladedDisk, DiskSection
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.excitation import EXCITATIONS, CasingDistortion, Harmonic, Imbalance
from bladewhirl.models.case.file import loads, read_case, with_values
from bladewhirl.models.case.shaft import Shaft
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.inputs.units import Speed
from bladewhirl.models.sections.rectangular import BeamSection

# Key, a unit of its dimension with its SI size, whether 0 means something.
NUMBERS: list[tuple[str, str, float, bool]] = [
    ("material.young_modulus", "GPa", 1e9, False),
    ("material.density", "g/cm3", 1e3, False),
    ("bladed_disk.tip_radius", "km", 1e3, False),
    ("bladed_disk.disk_radius", "mm", 1e-3, False),
    ("bladed_disk.blade.width", "mm", 1e-3, False),
    ("bladed_disk.blade.thickness", "mm", 1e-3, False),
    ("bladed_disk.disk.width", "mm", 1e-3, False),
    ("bladed_disk.disk.thickness", "mm", 1e-3, False),
    ("bladed_disk.web_radial", "MN/m", 1e6, False),
    ("bladed_disk.web_tangential", "kN/m", 1e3, False),
    ("bladed_disk.tip_mass", "g", 1e-3, True),
    ("shaft.stiffness", "MN/m", 1e6, False),
    ("shaft.stiffness_y", "MN/m", 1e6, False),
    ("shaft.damping", "kN s/m", 1e3, True),
    ("shaft.damping_y", "kN s/m", 1e3, True),
    ("casing.clearance", "mm", 1e-3, True),
    ("casing.wall.width", "mm", 1e-3, False),
    ("casing.wall.thickness", "mm", 1e-3, False),
    ("casing.support", "kN/m2", 1e3, True),
    ("coupling.stiffness", "kN/m", 1e3, True),
    ("march.time_step", "us", 1e-6, False),
    ("march.duration", "ms", 1e-3, True),
    ("march.record_step", "ms", 1e-3, False),
    ("march.displacement_limit", "mm", 1e-3, False),
    ("casing-distortion.modal_force", "kN/kg^0.5", 1e3, True),
    ("casing-distortion.duration", "ms", 1e-3, True),
    ("imbalance.unbalance", "g m", 1e-3, True),
    ("imbalance.ramp", "ms", 1e-3, True),
    ("harmonic.force", "kN", 1e3, True),
    ("harmonic.frequency", "kHz", 1e3, False),
]
COUNTS = [
    ("bladed_disk.blades", 3),
    ("bladed_disk.elements_per_blade", 1),
    ("bladed_disk.mistuning.seed", 0),
    ("casing.elements", 3),
    ("reduction.fixed_interface_modes", 1),
    ("casing-distortion.nodal_diameter", 1),
]
RATIOS = ["damping.ratio", "contact.friction"]
CHOICES = {
    "casing.curvature": ("exact", "shallow"),
    "casing.rotation": ("free", "fixed"),
    "contact.sliding": ("permanent", "signed"),
    "coupling.amplitude": ("paper", "physical"),
    "casing-distortion.shape": ("rectangular", "half-sine"),
    "harmonic.frame": ("rotating", "static"),
    "shaft.frame": ("rotating", "static"),
}
SWITCHES = ["shaft.clamped", "contact.tip_rotation", "coupling.pi"]


def tables(key: str, value: object) -> dict[str, Any]:
    """Nested tables with one key set; an excitation's keys are given by its type."""
    table, *inner = key.split(".")
    result: dict[str, Any] = {inner[-1]: value}
    for name in reversed(inner[:-1]):
        result = {name: result}
    if table in EXCITATIONS:
        return {"excitation": {"type": table, **result}}
    return {table: result}


def get(case: Case, key: str) -> object:
    table, *inner = key.split(".")
    value: object = case.excitation if table in EXCITATIONS else getattr(case, table)
    for name in inner:
        value = getattr(value, name)
    return value


def fault_of(key: str, value: object) -> str:
    return fault(case_from, tables(key, value))


def in_file(key: str) -> str:
    table, _, rest = key.partition(".")
    return f"excitation.{rest}" if table in EXCITATIONS else key


def test_defaults_of_the_loads() -> None:
    assert CasingDistortion().model_dump() == {
        "type": "casing-distortion",
        "nodal_diameter": 1,
        "modal_force": 3e4,
        "duration": 0.15,
        "shape": "rectangular",
    }
    assert (Imbalance().clearance_speed, Imbalance().unbalance) == (Speed(0.95), None)
    assert Imbalance().ramp == 0.2
    assert Imbalance(unbalance=0.59).clearance_speed is None


def test_a_partial_section_keeps_its_own_defaults() -> None:
    case = case_from({"bladed_disk": {"disk": {"width": 0.2}, "blade": {"width": 0.3}}})
    assert case.bladed_disk.disk.model_dump(exclude_none=True) == {"width": 0.2, "thickness": 0.03}
    assert case.bladed_disk.blade.model_dump(exclude_none=True) == {"width": 0.3, "thickness": 0.01}


def test_every_key_is_described_and_every_dimension_has_its_unit() -> None:
    models: list[type[Table]] = [type(table) for _, table in Case() if isinstance(table, Table)]
    models += [*EXCITATIONS.values(), BeamSection, DiskSection]
    for model in models:
        assert model.__doc__
        descriptions = model.descriptions()
        for name, field in model.model_fields.items():
            assert descriptions[name], f"{model.__name__}.{name}"
            a_word = get_origin(field.annotation) is Literal
            if not a_word and name in {key.rpartition(".")[2] for key, *_ in NUMBERS}:
                assert "[" in descriptions[name], f"{model.__name__}.{name} has no unit"


@pytest.mark.parametrize(("key", "unit", "size", "zero"), NUMBERS)
class TestDimensionalKeys:
    def test_take_si_and_text(self, key: str, unit: str, size: float, zero: bool) -> None:
        # 10 units fit every key's neighbours but for the record step, which fits 10 ms too.
        number, text = case_from(tables(key, 10 * size)), case_from(tables(key, f"10 {unit}"))
        assert get(text, key) == pytest.approx(10 * size, rel=1e-15)
        assert get(number, key) == 10 * size
        assert loads(dumps_case(text)) == text

    def test_refuse_negative_and_meaningless_zero(
        self, key: str, unit: str, size: float, zero: bool
    ) -> None:
        for value in (-1, -1e-9, f"-1 {unit}"):
            line = fault_of(key, value)
            assert line.startswith(f"{in_file(key)} = ")
            assert "expected a" in line
        if zero:
            assert get(case_from(tables(key, 0)), key) == 0.0
            assert get(case_from(tables(key, f"0 {unit}")), key) == 0.0
        else:
            assert "expected a positive number" in fault_of(key, 0)

    def test_refuse_other_types_and_dimensions(
        self, key: str, unit: str, size: float, zero: bool
    ) -> None:
        wrong = [math.nan, math.inf, -math.inf, True, False, 10**400, 1 << 40000, [1.0], {}, "1"]
        for value in [*wrong, "1 candela", "1 nonsense", "", "nan m", f"1e999 {unit}"]:
            line = fault_of(key, value)
            assert line.startswith(in_file(key))
            assert "such as" in line


@pytest.mark.parametrize(("key", "least"), COUNTS)
def test_counts(key: str, least: int) -> None:
    assert get(case_from(tables(key, least)), key) == least
    for value in (least - 1, -5, float(least), True, "3", 10**30, 1 << 40000, math.nan, "5 m"):
        line = fault_of(key, value)
        assert line.startswith(in_file(key))
        assert f"expected a whole number from {least}" in line


@pytest.mark.parametrize("key", RATIOS)
def test_ratios(key: str) -> None:
    assert get(case_from(tables(key, 0)), key) == 0.0
    assert get(case_from(tables(key, 2)), key) == 2.0
    for value in (-0.1, math.nan, True, "0.1", "10 mm"):
        assert "expected a number of zero or more" in fault_of(key, value)


@pytest.mark.parametrize("key", CHOICES)
def test_choices(key: str) -> None:
    for choice in CHOICES[key]:
        case = case_from(tables(key, choice))
        assert get(case, key) == choice
        assert loads(dumps_case(case)) == case
    for value in ("other", 1, True, [CHOICES[key][0]]):
        line = fault_of(key, value)
        assert all(f'"{choice}"' in line for choice in CHOICES[key])


@pytest.mark.parametrize("key", SWITCHES)
def test_switches(key: str) -> None:
    assert get(case_from(tables(key, True)), key) is True
    for value in (1, 0, "true", 1.0):
        assert fault_of(key, value).endswith("expected true or false")


@pytest.mark.parametrize(
    ("given", "value"), [(1.2, 1.2), (0, 0.0), (-1, -1.0), ("-60 rpm", -2 * math.pi), ("0 Hz", 0.0)]
)
def test_speeds_may_be_negative_or_zero(given: object, value: float) -> None:
    speed = get(case_from(tables("march.speed", given)), "march.speed")
    assert isinstance(speed, Speed)
    assert speed.value == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("value", [0, -0.95, "0 rpm", "-1 Hz", "x"])
def test_the_clearance_is_closed_at_a_positive_speed(value: object) -> None:
    line = fault_of("imbalance.clearance_speed", value)
    assert line.startswith("excitation.clearance_speed = ")


def test_initial_rows_take_units_and_arrays() -> None:
    rows = [["1 mm", 0.0], [0, -1e-3], [0.0, 0.0]]
    initial = {"tip_displacement": rows, "centre_velocity": ["-1 km/h", 2]}
    case = case_from({"bladed_disk": {"blades": 3}, "initial": initial})
    assert case.initial.tip_displacement == ((1e-3, 0.0), (0.0, -1e-3), (0.0, 0.0))
    assert case.initial.centre_velocity == pytest.approx((-1 / 3.6, 2.0), rel=1e-15)
    velocity = np.arange(44.0).reshape(22, 2)
    initial_from_python = Case(initial=Initial(tip_velocity=velocity)).initial
    np.testing.assert_array_equal(np.array(initial_from_python.tip_velocity), velocity)


@pytest.mark.parametrize(
    ("key", "value", "place"),
    [
        ("initial.centre_velocity", [1.0], "initial.centre_velocity = [1.0]"),
        ("initial.centre_velocity", 3, "initial.centre_velocity = 3"),
        ("initial.centre_displacement", [0.0, "1 s"], 'initial.centre_displacement[1] = "1 s"'),
        ("initial.tip_velocity", [[0.0, 0.0]] * 21, "22 rows, one for each blade, not 21"),
        ("initial.tip_velocity", [], "22 rows, one for each blade, not 0"),
        ("initial.tip_velocity", [[0.0] * 2] * 21 + [[0.0]], "initial.tip_velocity[21] = [0.0]"),
        ("initial.tip_velocity", [0.0] * 22, "initial.tip_velocity[0] = 0.0"),
        (
            "initial.tip_displacement",
            [[math.nan, 0.0]] * 22,
            "initial.tip_displacement[0][0] = nan",
        ),
        ("initial.tip_displacement", "1 mm", 'initial.tip_displacement = "1 mm"'),
    ],
)
def test_initial_rows_of_a_wrong_shape(key: str, value: object, place: str) -> None:
    assert place in faults(case_from, tables(key, value))[0]


@pytest.mark.parametrize(
    ("given", "key", "expected"),
    [
        ({"bladed_disk": {"disk_radius": 0.5}}, "bladed_disk.disk_radius = 0.5", "less than"),
        ({"bladed_disk": {"tip_radius": "2 cm"}}, "bladed_disk.disk_radius = 0.05", "= 0.02"),
        ({"march": {"record_step": 1e-7}}, "march.record_step = 1e-7", "at least march.time_step"),
        ({"march": {"duration": 5e-7}}, "march.duration = 5e-7", "0, or at least march.time_step"),
        (
            {"march": {"record_step": 1.5e-6}},
            "march.record_step",
            "1e-06 s or 2e-06 s, not 1.5 time steps",
        ),
        ({"march": {"time_step": 1e-29}}, "march.duration = 3.0", "steps"),
        ({"march": {"time_step": 1e-31}}, "march.time_step = 1e-31", "(too small)"),
        (
            {"excitation": {"type": "casing-distortion", "nodal_diameter": 21}},
            "excitation.nodal_diameter = 21",
            "at most half of casing.elements = 40",
        ),
        (
            {"excitation": {"type": "imbalance", "clearance_speed": 1.0, "unbalance": 1.0}},
            "excitation.unbalance = 1.0",
            "either unbalance or clearance_speed",
        ),
        (
            {"excitation": {"type": "imbalance", "unbalance": 1.0, "blade": 22}},
            "excitation.blade = 22",
            "a blade from 0 to 21",
        ),
        (
            {"excitation": {"type": "imbalance"}, "shaft": {"clamped": True}},
            'excitation.type = "imbalance"',
            "shaft.clamped = false",
        ),
        (
            {"initial": {"centre_velocity": [0.0, 1.0]}, "shaft": {"clamped": True}},
            "initial.centre_velocity = [0.0, 1.0]",
            "zero, or shaft.clamped = false",
        ),
        (
            {"bladed_disk": {"blades": 1000, "elements_per_blade": 1000}},
            "bladed_disk.elements_per_blade = 1000",
            "at most 100000 elements",
        ),
        (
            {
                "bladed_disk": {
                    "blades": 22000,
                    "elements_per_blade": 3,
                    "shrouds": [
                        {"radius": 0.3, "width": 0.1, "thickness": 0.01, "elements": elements}
                        for elements in (1, 3)
                    ],
                }
            },
            "bladed_disk.elements_per_blade = 3",
            "including those of shrouds, not 154000",
        ),
    ],
)
def test_what_does_not_fit_together(given: dict[str, Any], key: str, expected: str) -> None:
    lines = faults(case_from, given)
    assert any(line.startswith(key) and expected in line for line in lines)


@pytest.mark.parametrize(
    "given",
    [
        {"shaft": {"clamped": True}, "excitation": {"type": "casing-distortion"}},
        {"shaft": {"clamped": True}, "initial": {"centre_velocity": [0, 0.0]}},
        {"excitation": {"type": "casing-distortion", "nodal_diameter": 20}},
        {"excitation": {}},
        {"march": {"duration": 0}},
        {"march": {"time_step": 1e-4}},
        {"march": {"time_step": 1 / 3e6, "record_step": 1e-4}},
        {"bladed_disk": {"blades": 3}, "casing": {"elements": 3}},
    ],
)
def test_what_does_fit(given: dict[str, Any]) -> None:
    case = case_from(given)
    for table, values in given.items():
        assert getattr(case, table).model_fields_set >= set(values)


def test_steps_are_whole_numbers() -> None:
    march = March(time_step=1e-6, duration=3.0, record_step=1e-4)
    assert (march.steps, march.timing.record_every) == (3_000_000, 100)


def test_a_case_can_be_built_in_python_and_is_frozen() -> None:
    case = Case(
        casing=Casing(support="7.975 N/mm2", clearance=2e-3),
        excitation=Harmonic(force=10, frequency="10 Hz"),
        march=March(speed="2500 rpm"),
    )
    assert (case.casing.support, case.casing.clearance) == (7.975e6, 2e-3)
    assert case.excitation == Harmonic(force=10.0, frequency=10.0)
    assert hash(case) == hash(case.model_copy())
    with pytest.raises(ValidationError, match="frozen"):
        case.march = March()  # type: ignore[misc]
    with pytest.raises(ValidationError, match="frozen"):
        case.casing.clearance = 1.0  # type: ignore[misc]
    make: Any = Casing
    with pytest.raises(TypeError):
        make(40)


def test_python_gets_the_same_checks() -> None:
    with pytest.raises(ValidationError, match=r"expected less than bladed_disk\.tip_radius"):
        BladedDisk(tip_radius=0.1, disk_radius=0.2)
    with pytest.raises(CaseError, match=r"casing.clearence = 1: .*nearest is casing.clearance"):
        Case(casing={"clearence": 1})
    with pytest.raises(CaseError, match=r"shaft\.clamped = false"):
        Case(shaft=Shaft(clamped=True), excitation=Imbalance())
    with pytest.raises(ValidationError, match="either unbalance or clearance_speed"):
        Imbalance(unbalance=1.0, clearance_speed=1.0)


def test_with_values_checks_the_new_case_and_keeps_the_old() -> None:
    case = Case()
    other = with_values(case, {"march.speed": "50 Hz", "bladed_disk.blade.thickness": "2 cm"})
    assert (other.march.speed, other.bladed_disk.blade.thickness) == (Speed("50 Hz"), 0.02)
    assert other.bladed_disk.blade.width == 0.1
    assert case == Case()
    assert with_values(other, {"excitation": {"type": "imbalance"}}).excitation == Imbalance()
    line = fault(with_values, case, {"march.sped": 2})
    assert line.startswith("march.sped = 2: expected a known key")


@pytest.mark.parametrize("path", [*(ROOT / "examples").glob("*.toml")], ids=lambda one: one.stem)
def test_a_case_is_made_again_from_the_keys_that_differ_from_defaults(path: Path) -> None:
    case = read_case(path)
    assert case_from(case.model_dump(exclude_defaults=True)) == case
