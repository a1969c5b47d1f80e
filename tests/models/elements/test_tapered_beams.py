"""Tapered beams against a Ritz method of smooth functions and against beam theory."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse.linalg as spla
import xarray as xr
from stages import observed_order, steel
from synthetic_result import synthetic_result

from bladewhirl.models.case.case import case_from
from bladewhirl.models.elements.build import case_bladed_disk
from bladewhirl.models.sections.rectangular import QUANTITIES, Section, along, along_elements
from bladewhirl.postprocess.fields.strains import rotor_sections, rotor_strain_rows
from bladewhirl.postprocess.paraview.boxes import rotor_boxes
from bladewhirl.postprocess.pictures.drawing import Drawing

SPAN, YOUNG, DENSITY = 0.45, 2.1e11, 7800.0

TAPER = [steel(0.020), steel(0.012), steel(0.008)]


def bent(elements: int, taper: list[dict[str, float]]) -> xr.Dataset:
    """The static answer of a bladed disk, held rigidly, to a newton on the tip of blade 2."""
    tables = {"blades": 6, "disk_kind": "rigid", "elements_per_blade": elements, "taper": taper}
    disk = case_bladed_disk(case_from({"bladed_disk": tables}), clamped=True)
    force = np.zeros(disk.structure.size)
    force[disk.tip_tangential[2]] = 1.0
    answer = spla.spsolve(disk.structure.stiffness.tocsc(), force)
    sections = {
        f"rotor_{name}": ("rotor_line", getattr(disk.properties, name))
        for quantity in ("thickness", "width", "young_modulus")
        for name in (quantity, f"{quantity}_change")
    }
    return xr.Dataset(
        {
            "rotor_point": (("rotor_node", "axis"), disk.mesh.points),
            "rotor_line": (("rotor_line", "end"), disk.mesh.lines),
            "rotor_shape": (
                ("rotor_node", "rotor_component", "rotor_mode"),
                disk.cartesian(answer[:, None]),
            ),
            **sections,
        }
    )


@pytest.mark.parametrize(
    "taper", [[{"width": 0.1}, {"width": 0.05}], [{"thickness": 0.02}, {"thickness": 0.01}]]
)
def test_stress_at_a_root_with_the_section_there(taper: list[dict[str, float]]) -> None:
    """sigma = 6 F L / (b h^2); what is left is that of the curvature."""
    root = {"width": 0.1, "thickness": 0.01} | taper[0]
    expected = 6 * SPAN / (root["width"] * root["thickness"] ** 2)
    errors = []
    for elements in (10, 20, 40):
        result = bent(elements, taper)
        modulus = rotor_sections(result, "young_modulus", 1)
        stress = modulus * rotor_strain_rows(result).bending[..., 0]
        errors.append(float(np.abs(stress).max()) / expected - 1.0)
    assert abs(errors[0]) < 1e-3
    assert (observed_order(np.array(errors)) > 1.8).all(), errors


def test_sections_at_the_ends_of_elements_are_those_of_the_taper() -> None:
    thick = Section(width=0.1, thickness=0.02, young_modulus=YOUNG, density=DENSITY)
    thin = replace(thick, width=0.08, thickness=0.01, young_modulus=1.1e11)
    for elements in (1, 3, 8):
        middle, change = along_elements([thick, thin], elements)
        edges = along([thick, thin], np.linspace(0.0, 1.0, elements + 1))
        np.testing.assert_allclose(middle - change / 2, edges[:, :-1], rtol=1e-13)
        np.testing.assert_allclose(middle + change / 2, edges[:, 1:], rtol=1e-13)
    middle, change = along_elements(thick, 3)
    assert not change.any()
    assert (middle == [[getattr(thick, name)] for name in QUANTITIES]).all()


def test_a_station_inside_an_element_leaves_its_mean() -> None:
    """Mean and first moment, which the nearest straight line shares, against many small pieces."""
    fine = (np.arange(30000) + 0.5) / 30000
    for elements in (1, 3, 5):
        middle, change = along_elements(TAPER, elements)
        actual = along(TAPER, fine).reshape(4, elements, -1)
        shift = fine[: 30000 // elements] * elements - 0.5
        np.testing.assert_allclose(middle, actual.mean(axis=2), rtol=1e-8)
        np.testing.assert_allclose(
            change, 12.0 * (actual * shift).mean(axis=2), rtol=1e-7, atol=1e-9 * middle.max()
        )


def test_pictures_have_the_section_at_the_place() -> None:
    result = synthetic_result(records=2)
    thickness = result["rotor_thickness"].values
    tapered = result.assign(rotor_thickness_change=("rotor_line", -0.4 * thickness))
    ends = rotor_boxes(tapered, 2).offset[:, :, 1]
    np.testing.assert_allclose(ends, thickness[:, None] * [0.6, 0.5, 0.4], rtol=1e-14)
    sides = Drawing(tapered, np.array([0])).picture(0).rotor.sides
    gap = np.linalg.norm(sides[:, :, 1] - sides[:, :, 0], axis=-1)
    np.testing.assert_allclose(gap[:, [0, 3]], thickness[:, None] * [1.2, 1.0], rtol=1e-9)
