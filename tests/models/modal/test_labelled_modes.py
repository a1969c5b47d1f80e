"""Labels of modes: however few are asked for, however unlike the blades are."""

from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from stages import bladed_disk, tip_in_sector

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.modal.labels import LabelledModes, families_at_speed, labelled_modes

BLADES = 22


def modes_of(disk: BladedDiskModel, count: int | None = None) -> LabelledModes:
    return labelled_modes(disk.structure, tip_in_sector(disk), "bladed-disk", count)


@cache
def mistuned(spread: float) -> BladedDiskModel:
    """The thick-disked stage with blades whose stiffness differs at random by that much."""
    tuned = bladed_disk(disk_thickness=0.03)
    mesh, properties = tuned.mesh, tuned.properties
    factor = np.ones(len(mesh.lines))
    drawn = 1.0 + spread * np.random.default_rng(7).standard_normal(BLADES)
    factor[mesh.line_sets["blades"]] = np.repeat(drawn, len(mesh.line_sets["blades"]) // BLADES)
    properties = replace(properties, young_modulus=factor * properties.young_modulus)
    model = replace(tuned.model, properties=properties)
    return assemble_bladed_disk(model, shaft_stiffness=3.4e7, clamped=False)


def test_fields_are_modes_with_the_cosine_largest_in_sector_0() -> None:
    disk = bladed_disk(blades=7, elements=3)
    actual = modes_of(disk)
    structure = disk.structure
    shapes = actual.fields(np.arange(actual.count))
    np.testing.assert_allclose(
        shapes.T @ (structure.mass @ shapes), np.eye(actual.count), atol=1e-10
    )
    strain = np.einsum("im,im->m", shapes, structure.stiffness @ shapes)
    np.testing.assert_allclose(strain, actual.frequency**2, rtol=1e-9)
    in_springs = np.einsum("im,im->m", shapes, structure.springs @ shapes) / strain
    np.testing.assert_allclose(actual.spring_share, in_springs, atol=1e-9)
    for k in (1, 2, 3):
        cosine, sine = actual.find("1F", k)
        radial = actual.fields(np.array([cosine, sine]))[disk.tip_radial]
        wave = 2.0 * np.pi * k * np.arange(7) / 7
        np.testing.assert_allclose(radial[:, 0], radial[0, 0] * np.cos(wave), atol=1e-9)
        np.testing.assert_allclose(radial[:, 1], radial[0, 0] * np.sin(wave), atol=1e-9)
        assert radial[0, 0] > 0.0


@pytest.mark.parametrize("spread", [1e-3, 0.03])
def test_families_survive_mistuning(spread: float) -> None:
    """Families of blades are far apart, so each must have as many modes as there are blades."""
    disk = mistuned(spread)
    assert not disk.structure.is_cyclic
    actual = modes_of(disk, 3 * BLADES + 2)
    assert Counter(actual.family) == {"1F": 22, "suspension": 2, "2F": 22, "3F": 22}
    names = ["1F"] * 22 + ["suspension"] * 2 + ["2F"] * 22 + ["3F"] * 22
    assert list(actual.family) == names
    # Blades vibrate on their own: few modes still have one nodal diameter.
    assert np.median(actual.purity) < 0.5
    suspension = [name == "suspension" for name in actual.family]
    np.testing.assert_array_equal(actual.nodal_diameter[suspension], 1)
    assert actual.purity[suspension].min() > 0.99
    assert (actual.purity > 1.0 / (BLADES // 2 + 1)).all()
    shape = actual.fields(np.array([0]))[:, 0]
    residual = disk.structure.stiffness @ shape - actual.frequency[0] ** 2 * (
        disk.structure.mass @ shape
    )
    assert np.abs(residual).max() < 1e-6 * np.abs(disk.structure.stiffness @ shape).max()


def test_labels_of_hardly_mistuned_blades_are_those_of_the_tuned_ones() -> None:
    tuned, actual = modes_of(bladed_disk(disk_thickness=0.03), 68), modes_of(mistuned(1e-6), 68)
    np.testing.assert_allclose(actual.frequency, tuned.frequency, rtol=1e-5)
    np.testing.assert_allclose(actual.purity[:3], 1.0, atol=1e-3)
    # Blades hardly feel each other: where frequencies are close, nodal diameters mix at once.
    assert list(actual.nodal_diameter[:3]) == list(tuned.nodal_diameter[:3]) == [1, 1, 0]
    assert actual.family == tuned.family


def test_two_hundred_blades_by_the_cyclic_path() -> None:
    """6,602 degrees of freedom; each mode found is one of the whole structure."""
    disk = bladed_disk(blades=200, elements=10, disk_thickness=0.03)
    structure = disk.structure
    actual = modes_of(disk, 602)
    assert Counter(actual.family) == {"1F": 200, "2F": 200, "3F": 200, "suspension": 2}
    assert set(actual.nodal_diameter) == set(range(101))
    chosen = np.array([0, 5, 150, 333, 601])
    shapes = actual.fields(chosen)
    force = structure.mass @ (shapes * actual.frequency[chosen] ** 2)
    answer: FloatArray = spla.splu(structure.stiffness.tocsc()).solve(force)
    np.testing.assert_allclose(answer, shapes, rtol=0.0, atol=2e-6 * np.abs(shapes).max())


def test_the_suspension_at_speed_has_most_of_its_energy_in_the_springs() -> None:
    names = ["1F", "suspension", "2F"]
    assert families_at_speed(names, np.array([0.1, 0.7, 0.2])) == names
    assert families_at_speed(names, np.array([0.8, 0.1, 0.0])) == ["suspension", "1F", "2F"]
    assert families_at_speed(names, np.array([0.1, 0.2, 0.6])) == ["1F", "2F", "suspension"]
    assert families_at_speed(names, np.array([0.4, 0.3, 0.3])) == names
    assert families_at_speed(["1F", "2F"], np.array([0.9, 0.0])) == ["1F", "2F"]
