"""Geometry of the line meshes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bladewhirl.meshes.line_mesh import LineMesh
from bladewhirl.models.case.case import case_from
from bladewhirl.models.elements.build import case_beam_model


def disk(blades: int, elements: int) -> LineMesh:
    table = {"blades": blades, "elements_per_blade": elements}
    return case_beam_model(case_from({"bladed_disk": table})).mesh


@pytest.mark.slow
@settings(max_examples=20)
@given(blades=st.integers(3, 40), elements=st.integers(1, 12))
def test_a_bladed_disk_of_any_size(blades: int, elements: int) -> None:
    mesh = disk(blades, elements)
    assert len(mesh.points) == blades * (elements + 1) + 1
    assert {name: len(lines) for name, lines in mesh.line_sets.items()} == {
        "blades": blades * elements,
        "spokes": blades,
        "rim": blades,
    }
    # The sets share the lines out, none left and none twice.
    assert np.array_equal(
        np.sort(np.concatenate([*mesh.line_sets.values()])), range(len(mesh.lines))
    )

    angle = 2.0 * np.pi / blades
    lengths = {name: mesh.lengths[lines] for name, lines in mesh.line_sets.items()}
    np.testing.assert_allclose(lengths["blades"], 0.45 / elements, rtol=1e-12)
    np.testing.assert_allclose(lengths["spokes"], 0.05, rtol=1e-12)
    np.testing.assert_allclose(lengths["rim"], 0.1 * np.sin(angle / 2.0), rtol=1e-12)

    tips = mesh.points[mesh.node_sets["tips"]] @ [1.0, 1.0j]
    np.testing.assert_allclose(tips, 0.5 * np.exp(1j * angle * np.arange(blades)), atol=1e-15)
    np.testing.assert_allclose(mesh.points[mesh.node_sets["centre"]], 0.0, atol=0.0)


@pytest.mark.parametrize(("blades", "elements"), [(3, 1), (7, 4), (22, 10)])
def test_a_turn_by_one_sector_maps_the_mesh_to_itself(blades: int, elements: int) -> None:
    mesh = disk(blades, elements)
    assert mesh.sectors is not None
    angle = 2.0 * np.pi / blades
    turned = mesh.points @ [1.0, 1.0j] * np.exp(1j * angle)
    image = np.arange(len(mesh.points))
    image[mesh.sectors] = np.roll(mesh.sectors, -1, axis=0)
    np.testing.assert_allclose(turned, mesh.points[image] @ [1.0, 1.0j], atol=1e-15)
    lines = {frozenset(line) for line in mesh.lines.tolist()}
    assert {frozenset(image[list(line)].tolist()) for line in lines} == lines
    radial = mesh.points[mesh.sectors] @ [1.0, 1.0j]
    axes = np.exp(1j * mesh.node_axes[mesh.sectors])
    np.testing.assert_allclose(axes, radial / np.abs(radial), atol=1e-14)


def test_every_line_knows_its_part() -> None:
    mesh = disk(3, 2)
    assert mesh.line_parts == ["blades"] * 6 + ["spokes"] * 3 + ["rim"] * 3
    bare = LineMesh(points=mesh.points, lines=mesh.lines, node_axes=mesh.node_axes)
    assert set(bare.line_parts) == {""}


def test_a_mesh_keeps_its_own_unwritable_arrays() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0]])
    mesh = LineMesh(points=points, lines=np.array([[0, 1]]), node_axes=np.zeros(2))
    points[1, 0] = 5.0
    assert mesh.lengths[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        mesh.points[0, 0] = 1.0
    with pytest.raises(TypeError):
        mesh.node_sets["more"] = np.array([0])  # type: ignore[index]
