"""Case files: what is written can be read again, and bad ones end in one line a fault."""

import re
import time
from pathlib import Path
from typing import Any

import pytest
from faults import fault, faults
from places import DATA, EXAMPLES

from bladewhirl.models.case.analysis import Contact
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.excitation import EXCITATIONS, CasingDistortion, Imbalance
from bladewhirl.models.case.file import loads, read_case, table_of, with_values
from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.case.template import dumps_case, template
from bladewhirl.models.inputs.errors import CaseError, toml_value
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.inputs.units import Speed

OPTIONAL = """
[material]
named = [{ name = "ti", young_modulus = "114 GPa", density = 4430.0 }]
[bladed_disk]
blades = 3
elements_per_blade = 4
taper = [{ thickness = 0.014 }, { thickness = 0.006, width = 0.06, material = "ti" }]
[casing]
clearance_lobes = [{ lobes = 2, amplitude = "0.1 mm", phase = "30 deg" }]
[excitation]
type = "imbalance"
unbalance = 0.25
[initial]
tip_velocity = [[1.0, 0.0], [1.5e-300, -0.0], ["1 mm/s", 2]]
[march]
speed = "-2500 rpm"
"""


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_an_example_reads_back_equal_fits_on_a_screen_and_has_no_hints(path: Path) -> None:
    case = read_case(path)
    assert loads(dumps_case(case)) == case
    lines = repr(case).splitlines()
    assert len(lines) <= 12
    assert max(map(len, lines)) <= 80
    assert case_hints(case) == ()


def test_a_written_case_reads_back_equal() -> None:
    case = loads(OPTIONAL)
    text = dumps_case(case)
    assert loads(text) == case
    assert dumps_case(loads(text)) == text


def test_every_key_is_written_with_its_default() -> None:
    """The file is what `dumps_case(Case())` gives: defaults change on purpose alone."""
    text = (DATA / "default_case.toml").read_text(encoding="utf-8")
    assert dumps_case(Case()) == text
    assert loads(text) == Case()


def test_what_was_given_with_a_unit_stays_readable() -> None:
    text = '[march]\nspeed = "2500 rpm"\n[material]\nyoung_modulus = "210 GPa"'
    written = dumps_case(loads(text))
    assert 'speed = "2500 rpm"' in written
    assert "young_modulus = 2.1e11" in written


@pytest.mark.parametrize(
    "title", ["", "\x00\x1f\x7f\x85", "a\"b\\c'd", "a\r\nb\tc", "Möbius \U0001f300"]
)
def test_any_title_is_written(title: str) -> None:
    assert loads(dumps_case(Case(title=title))).title == title


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (2.1e11, "2.1e11"),
        (1e-6, "1e-6"),
        (1508.0, "1508.0"),
        (0.1, "0.1"),
        (-1 / 3e9, "-3.333333333333333e-10"),
    ],
)
def test_numbers_are_written_short_and_exact(value: float, text: str) -> None:
    assert toml_value(value) == text
    assert float(text) == value


def test_the_template_is_the_default_case() -> None:
    assert loads(template()) == Case()


def test_the_template_shows_every_key_and_its_meaning() -> None:
    def keys(model: type[Any]) -> set[str]:
        return set(model.model_fields)

    shown = set(re.findall(r"^(?:#+ )?(\w+) = ", template(), re.MULTILINE))
    tables = [type(table) for _, table in Case() if isinstance(table, Table)]
    assert set().union(*map(keys, tables), *map(keys, EXCITATIONS.values())) <= shown
    assert max(map(len, template().splitlines())) <= 100


@pytest.mark.parametrize("kind", ["casing-distortion", "imbalance", "harmonic"])
def test_the_templates_alternatives_can_be_uncommented(kind: str) -> None:
    active, marker = 'type = "none"\n', f'# type = "{kind}"\n'
    blocks = template().split("\n\n")
    blocks = [block.replace(active, "") if active in block + "\n" else block for block in blocks]
    [block] = [block for block in blocks if marker in block]
    uncommented = "\n".join(line.removeprefix("# ") for line in block.splitlines())
    case = loads("\n\n".join(blocks).replace(block, uncommented).replace('type = "none"', ""))
    assert case.excitation == EXCITATIONS[kind]()


def test_the_fan_stage_is_the_default_case() -> None:
    assert read_case(EXAMPLES / "fan_stage.toml") == Case()


@pytest.mark.parametrize(
    ("name", "excitation"),
    [
        ("casing_distortion", CasingDistortion(modal_force=3e4, duration=0.01, nodal_diameter=1)),
        ("imbalance", Imbalance(clearance_speed=0.95, ramp=0.1)),
    ],
)
def test_the_contact_cases_are_the_fan_stage_but_for_two_lines_and_a_load(
    name: str, excitation: object
) -> None:
    case, stage = read_case(EXAMPLES / f"{name}.toml"), Case()
    assert case.casing == stage.casing.model_copy(update={"support": 7.975e6})
    assert case.excitation == excitation
    differing = {key for key, value in case if value != getattr(stage, key)}
    assert case.damping.ratio == 0.001
    assert differing == {"title", "casing", "damping", "excitation"}
    march = case.march
    assert (march.speed, march.time_step, march.duration) == (Speed(1.05), 1e-6, 3.0)


BAD = """
titel = "x"
speed = 3
[material]
young_modulus = "210 GPA"
density = -1
[bladed_disk]
blades = 2
tip_radius = 0.04
blade.thicknes = 3
disk = 4
[shaft]
clamped = true
[casing]
elements = 8
clearance = nan
[excitation]
type = "casing-distortion"
nodal_diameter = 5
ramp = 1
[initial]
centre_velocity = [0.0, 1.0]
tip_velocity = [[0.0, 1.0], [inf, "x"]]
[[coupling]]
pi = true
[march]
time_step = 1e-4
record_step = 1e-6
scheme = "runge-kutta"
"""


def test_all_faults_of_a_file_at_once(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(BAD)
    lines = faults(read_case, path)
    assert all(line.startswith(f"{path}: ") and "\n" not in line for line in lines)
    actual = [line.removeprefix(f"{path}: ").partition(": expected ")[0] for line in lines]
    assert sorted(actual) == sorted(
        [
            'titel = "x"',
            "speed = 3",
            'material.young_modulus = "210 GPA"',
            "material.density = -1",
            "bladed_disk.blades = 2",
            "bladed_disk.blade.thicknes = 3",
            "bladed_disk.disk = 4",
            "casing.clearance = nan",
            "excitation.ramp = 1",
            "initial.tip_velocity[1][0] = inf",
            'initial.tip_velocity[1][1] = "x"',
            "coupling = [{ pi = true }]",
            'march.scheme = "runge-kutta"',
        ]
    )


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("sped = 1", "sped = 1: expected a known key; the nearest is march.speed"),
        ("marsh.speed = 1", "marsh = { speed = 1 }: expected a known key; the nearest is march"),
        (
            'march."sp.eed" = 1',
            'march."sp.eed" = 1: expected a known key; the nearest is march.speed',
        ),
        ('"\\u001b[1m\\n" = 1', '"\\u001b[1m\\n" = 1: expected a known key'),
        (
            'excitation = { type = "imbalance", shape = "half-sine" }',
            'a key of excitation.type = "imbalance"; this key belongs to "casing-distortion"',
        ),
        ("excitation.ramp = 1", 'excitation.type: expected "casing-distortion" or "imbalance"'),
        ('excitation.type = "imbalanc"', 'excitation.type = "imbalanc": expected'),
        ("title = 3", "title = 3: expected text"),
        ("x = 1", "x = 1: expected a known key: title, material, bladed_disk, "),
        ("casing.foo = 1", "expected a known key of [casing]: elements, clearance, "),
        ("march = 3", "march = 3: expected a table, [march]"),
        ('bladed_disk = ["a"]', 'bladed_disk = ["a"]: expected a table, [bladed_disk]'),
    ],
)
def test_faults_name_the_key_and_what_was_expected(text: str, line: str) -> None:
    actual = fault(loads, text, file="a.toml")
    assert actual.startswith("a.toml: ")
    assert line in actual


def test_values_compared_with_a_mistaken_one_are_not_blamed() -> None:
    text = "march.tme_step = 1e-7\nmarch.record_step = 5e-7"  # 5e-7 is less than the default step
    assert "march.tme_step" in fault(loads, text)


QUOTED_PARTS = ('"a b".', "'a b' .", '"".', r'"\"".', "'#'. ", '"é"\t.\t', 'a."b".', "'\"'.")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("a = [", "at end of document"),
        ("[march]\nspeed = 1.0.0", "line 2"),
        ("a = 1\na = 2\n[b]", "overwrite"),
        ("a = " + "9" * 5000, "integer"),
        pytest.param("a = " + "[" * 5000, "recursion", id="nested values"),
        pytest.param("a." * 40_000 + "b = 1", "keys of at most 50 parts", id="nested keys"),
        *(
            pytest.param(part * 40_000 + "b = 1", "keys of at most 50 parts", id=part)
            for part in QUOTED_PARTS
        ),
        pytest.param("[" + '"a b".' * 40_000 + "b]", "keys of at most 50 parts", id="heads"),
        pytest.param("x = {" + "'a b'." * 40_000 + "b = 1}", "at most 50 parts", id="inline"),
    ],
)
def test_invalid_toml_is_one_line(text: str, reason: str) -> None:
    line = fault(loads, text, file="a.toml")
    assert line.startswith("a.toml: ")
    assert reason in line


@pytest.mark.parametrize("text", ['"a', "'a ", '\\"a', '"a"', "' '", '"a\\'])
def test_quotes_do_not_take_long(text: str) -> None:
    """A pattern that searched to the end of the text from each quote would take minutes."""
    start = time.process_time()
    assert "expected valid TOML" in fault(loads, text * 50_000)
    assert time.process_time() - start < 2.0


def test_long_values_are_cut() -> None:
    lines = faults(loads, f"material.density = 0x{'f' * 9000}\nmarch.speed = [{'1.0,' * 900}]")
    assert lines[0].startswith("case: material.density = a huge integer: ")
    assert max(map(len, lines)) < 300


@pytest.mark.parametrize("name", ["missing.toml", "", "null\0.toml"])
def test_a_file_that_cannot_be_read_is_one_line(tmp_path: Path, name: str) -> None:
    path = f"{tmp_path}/{name}"  # with no name, the folder itself
    assert fault(read_case, path).startswith(f"{path}: expected ")


def test_a_file_that_is_no_text_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(b"\xff\xfe")
    assert "expected text in UTF-8" in fault(read_case, path)


def test_marks_and_line_ends_of_other_systems_are_read(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(b'\xef\xbb\xbftitle = "\xc3\xa9"\r\n[march]\r\nspeed = 2\r\n')
    case = read_case(path)
    assert (case.title, case.march.speed) == ("é", Speed(2.0))


def test_another_type_of_load_drops_the_keys_of_the_one_before() -> None:
    text = '[excitation]\ntype = "casing-distortion"\nmodal_force = 1e4\nduration = 0.01'
    changes = ["excitation.unbalance=0.5", "excitation.type=imbalance"]
    case = loads(text, overrides=changes)
    assert isinstance(case.excitation, Imbalance)
    assert case.excitation.unbalance == 0.5
    assert case == with_values(
        loads(text), {"excitation.unbalance": 0.5, "excitation.type": "imbalance"}
    )
    with pytest.raises(CaseError, match="unbalance"):
        loads(text, overrides=["excitation.type=none", "excitation.unbalance=0.5"])


LISTED = """
[[excitation]]
type = "casing-distortion"
modal_force = "20 kN/kg^0.5"

[[excitation]]
type = "engine-order"
order = 3
"""


def test_a_list_of_excitations_is_read_written_and_changed() -> None:
    case = loads(LISTED)
    assert loads(dumps_case(case)) == case
    changed = loads(LISTED, overrides=["excitation.1.type=imbalance", "excitation.0.modal_force=1"])
    assert changed.excitation == (CasingDistortion(modal_force=1.0), Imbalance())
    assert with_values(case, {"excitation.0.modal_force": 1.0}).excitation == (
        CasingDistortion(modal_force=1.0),
        *case.excitation[1:],  # type: ignore[index]
    )
    assert with_values(case, {"excitation": []}).excitation == Case().excitation


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('order = "x"', 'excitation[1].order = "x": expected an engine order'),
        (
            "nodal_diameter = 2",
            "excitation[1].nodal_diameter = 2: expected a key of excitation.type",
        ),
        (
            "factors = [1.0]",
            "excitation[1].factors = [1.0]: expected 22 numbers, one for each blade",
        ),
        ('[[excitation]]\ntype = "x"', 'excitation[2].type = "x": expected "casing-distortion" or'),
    ],
)
def test_faults_name_the_excitation_of_a_list(text: str, line: str) -> None:
    lines = LISTED.replace("order = 3", text) if text.startswith("order") else LISTED + text
    assert line in fault(loads, lines)


def test_a_row_that_is_not_there_cannot_be_set() -> None:
    with pytest.raises(
        CaseError, match=r"number of a row, excitation.0 to excitation.1: excitation is a list"
    ):
        loads(LISTED, overrides=["excitation.2.order=1"])
    with pytest.raises(
        CaseError, match=r"number of a row, excitation.0 to excitation.1: excitation is a list"
    ):
        loads(LISTED, overrides=["excitation.type=imbalance"])


def test_one_table_of_a_case_needs_no_files_of_others() -> None:
    text = '[contact]\nfriction = 0.3\n[bladed_disk.mesh]\nfile = "nowhere.msh"\n'
    assert table_of(text, "contact", Contact) == Contact(friction=0.3)
    assert table_of("[contact]\nstick_speed = 1.0", "contact", Contact) == Contact()
    assert table_of("", "casing", Casing) == Casing()
    for wrong, expected in (
        ("contact = 1", "contact: expected a table"),
        ("[contact]\nfriction = -1", "contact.friction = -1"),
        ("[contact", "valid TOML"),
    ):
        with pytest.raises(CaseError, match=expected):
            table_of(wrong, "contact", Contact)


def test_removed_keys_without_an_effect_are_dropped() -> None:
    """Earlier versions wrote them into every case, with these values."""
    earlier = {"restitution": 0.0, "penalty_stiffness": 1e9, "stick_speed": 0.01, "friction": 0.2}
    case = case_from({"contact": earlier, "march": {"scheme": "central-difference"}})
    assert case.contact == Contact(friction=0.2)
    for name, value in (("restitution", 0.5), ("penalty_stiffness", 2e9), ("stick_speed", 1.0)):
        with pytest.raises(CaseError, match=rf"contact\.{name} .*removed in this version"):
            case_from({"contact": {name: value}})
