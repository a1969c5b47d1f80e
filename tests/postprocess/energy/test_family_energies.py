"""Strain energy by family and nodal diameter: labels of modes against a transform of the field."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.energy.families import (
    cyclic_energies,
    family_energies,
    plot_family_energies,
)
from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.sectors import sectors


def with_waves(k: int) -> xr.Dataset:
    """The synthetic result, its blades bending with k nodal diameters."""
    result = synthetic.synthetic_result(records=31)
    points = result.rotor_point.values
    angle = np.arctan2(*points.T[::-1])
    shape = result.rotor_shape.values.copy()
    flat = np.hypot(*points.T) > 0
    # A shape bent alike on all blades, times a wave over the blades.
    bent = shape[..., 3] / np.where(np.abs(np.cos(angle)) > 1e-9, np.cos(angle), np.inf)[:, None]
    other = shape[..., 4] / np.where(np.abs(np.sin(angle)) > 1e-9, np.sin(angle), np.inf)[:, None]
    alike = np.where((np.abs(np.cos(angle)) > 0.5)[:, None], bent, other) * flat[:, None]
    shape[..., 3] = alike * np.cos(k * angle)[:, None]
    shape[..., 4] = alike * np.sin(k * angle)[:, None]
    result["rotor_shape"] = result.rotor_shape.dims, shape
    result["rotor_nodal_diameter"] = "rotor_mode", np.array([1, 1, 0, k, k])
    return result


@pytest.mark.parametrize("k", [1, 2, 5, 10])
def test_the_cyclic_projection_is_the_modal_one(k: int) -> None:
    result = with_waves(k)
    modal, cyclic = family_energies(result).energy, cyclic_energies(result).energy
    assert cyclic.sizes["nodal_diameter"] == 12
    total = float(modal.sum(("family", "nodal_diameter")).max())
    full = modal.reindex(nodal_diameter=cyclic.nodal_diameter, fill_value=0.0)
    np.testing.assert_allclose(cyclic, full, rtol=0, atol=1e-9 * total)
    assert float(modal.sel(family="1F", nodal_diameter=k).max()) > 0


def test_the_cyclic_projection_does_not_believe_labels() -> None:
    right = with_waves(5)
    wrong = right.assign(rotor_nodal_diameter=("rotor_mode", np.array([1, 1, 0, 3, 3])))
    xr.testing.assert_equal(cyclic_energies(wrong), cyclic_energies(right))
    assert not np.allclose(
        family_energies(wrong).energy.sel(nodal_diameter=3),
        cyclic_energies(wrong).energy.sel(nodal_diameter=3),
    )


def test_families_add_up_to_the_groups_of_a_run() -> None:
    result = synthetic.synthetic_result(records=31)
    energy, groups = family_energies(result).energy, strain_energies(result)
    assert energy.family.values.tolist() == ["suspension", "2F", "1F"]
    np.testing.assert_allclose(energy.sum(("family", "nodal_diameter")), groups.total, rtol=1e-13)
    np.testing.assert_allclose(
        energy.sel(family="suspension").sum("nodal_diameter"), groups.suspension, rtol=1e-13
    )
    np.testing.assert_allclose(energy.sel(family="2F", nodal_diameter=0), groups.rest, rtol=1e-13)


def test_the_transform_over_sectors_keeps_lengths() -> None:
    result = synthetic.synthetic_result(records=2)
    mesh = sectors(result)
    assert mesh.count == 22
    assert sorted([*mesh.nodes.ravel(), *mesh.centre]) == list(range(result.sizes["rotor_node"]))
    field = np.random.default_rng(1).normal(size=(3, result.sizes["rotor_node"], 3))
    waves = mesh.transform(field)
    np.testing.assert_allclose(np.sum(waves**2, axis=1), np.sum(field**2, axis=(1, 2)))
    assert len(mesh.nodal_diameter) == waves.shape[1]


def test_a_translation_is_one_nodal_diameter() -> None:
    """The conclusion of Eqs 11-13."""
    mesh = sectors(synthetic.synthetic_result(records=2))
    along_x = np.zeros((mesh.nodes.size + 1, 3))
    along_x[:, 0] = 1.0
    waves = mesh.transform(along_x)
    assert not np.abs(waves[mesh.nodal_diameter != 1]).max() > 1e-14
    assert np.sum(waves**2) == pytest.approx(len(along_x))


def test_a_disk_with_a_node_out_of_place_has_no_sectors() -> None:
    result = synthetic.synthetic_result(records=2)
    points = result.rotor_point.values.copy()
    points[7] += 1e-3
    result["rotor_point"] = result.rotor_point.dims, points
    with pytest.raises(ViewError, match=r"22 like sectors.* 0\.001"):
        cyclic_energies(result)


def test_the_figure_has_a_line_for_each_family_and_a_row_for_each_nodal_diameter() -> None:
    figure = plot_family_energies(cyclic_energies(synthetic.synthetic_result(records=401)))
    upper, lower = figure.axes[:2]
    assert [str(line.get_label()) for line in upper.lines] == ["total", "suspension", "1F", "2F"]
    assert "[J]" in upper.get_ylabel()
    assert lower.get_ylim() == (-0.5, 11.5)


def test_a_disk_at_rest_can_be_drawn() -> None:
    result = synthetic.synthetic_result(records=3)
    result["rotor_displacement"] = 0.0 * result.rotor_displacement
    upper = plot_family_energies(family_energies(result)).axes[0]
    assert np.isfinite([*upper.get_xlim(), *upper.get_ylim()]).all()
