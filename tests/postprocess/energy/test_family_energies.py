"""Strain energy by family and nodal diameter, by the labels of the modes."""

import numpy as np
import synthetic_result as synthetic

from bladewhirl.postprocess.energy.strain import (
    family_energies,
    plot_family_energies,
    strain_energies,
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


def test_the_figure_has_a_row_for_each_nodal_diameter_and_each_family() -> None:
    figure = plot_family_energies(family_energies(synthetic.synthetic_result(records=401)))
    upper, lower = figure.axes[:2]
    assert [text.get_text() for text in upper.get_yticklabels()] == ["0"]
    assert upper.get_ylim() == (-0.5, 1.5)
    assert [text.get_text() for text in lower.get_yticklabels()] == ["suspension", "2F", "1F"]
    assert "0.267 to 0.4 s" in lower.get_title()
