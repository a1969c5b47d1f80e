"""Sections made in Python: units, materials, refusals of one line."""

import pytest

import bladewhirl as bw
from bladewhirl.models.sections.rectangular import LIMITS


def test_units_and_materials() -> None:
    plain = bw.Section(width=0.12, thickness=8e-3, young_modulus=2.1e11, density=7800.0)
    assert bw.Section(width="120 mm", thickness="8 mm", material=bw.Material()) == plain
    titanium = bw.Material(young_modulus="114 GPa", density="4.43 g/cm3")
    section = bw.Section(width="12 cm", thickness=8e-3, material=titanium)
    assert (section.young_modulus, section.density) == (1.14e11, 4430.0)


def test_section_of_a_rectangle() -> None:
    section = bw.Section(width=0.1, thickness=0.01, young_modulus=2e11, density=8000.0)
    assert section.axial_stiffness == pytest.approx(2e8)
    assert section.bending_stiffness == pytest.approx(2e11 * 0.1 * 0.01**3 / 12.0)
    assert section.line_mass == pytest.approx(8.0)


@pytest.mark.parametrize("name", ["width", "thickness", "young_modulus", "density"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_sections_that_cannot_be(name: str, value: float) -> None:
    sound = {"width": 0.1, "thickness": 0.01, "young_modulus": 2e11, "density": 8000.0}
    with pytest.raises(bw.CaseError, match=rf"section\.{name} = .*expected a positive number"):
        bw.Section(**(sound | {name: value}))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"width": "3 kg"}, r'section\.width = "3 kg": expected a positive number in m, .*\[mass'),
        ({"density": 7800}, r"section\.material: expected either material, or young_modulus and"),
        ({"material": None}, r"section: expected a material, such as Material\(\) for steel, or"),
    ],
)
def test_faults_are_one_line(given: dict[str, object], message: str) -> None:
    sound = {"width": 0.1, "thickness": 0.01, "material": bw.Material()}
    with pytest.raises(bw.CaseError, match=f"^{message}"):
        bw.Section(**(sound | given))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", LIMITS)
def test_limits_of_the_stress_belong_in_the_case(name: str) -> None:
    """A section would lose them, and no stress would be marked."""
    strong = bw.Material(**{name: "600 MPa"})
    with pytest.raises(bw.CaseError, match=rf'sketch\.case\(material=\{{"{name}"'):
        bw.Section(width=0.1, thickness=0.01, material=strong)


def test_the_lowest_limits_of_all_materials_count() -> None:
    other = {"name": "titanium", "young_modulus": "114 GPa", "density": 4430.0}
    given = bw.Material(strength="900 MPa", named=[other | {"strength": 8e8, "endurance": 3e8}])
    assert given.lowest_limits == {"strength": 8e8, "endurance": 3e8}
