"""Strain energy by groups of modes and by families, against single modes."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from bladewhirl.postprocess.energy.strain import (
    family_energies,
    plot_energy,
    plot_family_energies,
    strain_energies,
)

GROUPS = {0: "suspension", 1: "suspension", 2: "rest", 3: "1F", 4: "1F"}


def single(mode: int, amplitude: float = 2e-3) -> xr.Dataset:
    """A result in which one rotor mode vibrates at its own frequency."""
    motion = np.zeros((101, 5))
    time = synthetic.RECORD_STEP * np.arange(101)
    motion[:, mode] = amplitude * np.cos(synthetic.ROTOR_FREQUENCY[mode] * time)
    return synthetic.resting(101, rotor_displacement=motion)


class TestStrainEnergies:
    @pytest.mark.parametrize("mode", range(5))
    def test_a_single_mode_is_a_spring(self, mode: int) -> None:
        energies = strain_energies(single(mode))
        frequency = synthetic.ROTOR_FREQUENCY[mode]
        spring = 0.5 * (frequency * 2e-3 * np.cos(frequency * energies.time.values)) ** 2
        held = {
            "suspension": energies.suspension,
            "1F": energies.first_family.sel(nodal_diameter=1),
            "rest": energies.rest,
        }
        for group, energy in held.items():
            expected = spring if group == GROUPS[mode] else 0.0 * spring
            np.testing.assert_allclose(energy, expected, rtol=1e-13, atol=0)
        np.testing.assert_allclose(energies.total, spring, rtol=1e-13)

    def test_the_first_family_is_reported_by_nodal_diameter(self) -> None:
        result = single(3)
        result["rotor_family"] = (
            "rotor_mode",
            np.array(["1F", "1F", "2F", "1F", "1F"], dtype=object),
        )
        result["rotor_nodal_diameter"] = "rotor_mode", np.array([0, 2, 0, 2, 5])
        result["rotor_displacement"] = ("time", "rotor_mode"), np.ones((101, 5))
        energies = strain_energies(result)
        np.testing.assert_array_equal(energies.nodal_diameter, [0, 2, 5])
        spring = 0.5 * synthetic.ROTOR_FREQUENCY**2
        expected = [spring[0], spring[1] + spring[3], spring[4]]
        np.testing.assert_allclose(energies.first_family[7], expected, rtol=1e-14)
        np.testing.assert_allclose(energies.rest[7], spring[2], rtol=1e-14)
        assert not energies.suspension.values.any()


def lines(figure: Figure) -> dict[str, str]:
    """Colours of the lines of a figure by label."""
    return {str(line.get_label()): to_hex(line.get_color()) for line in figure.axes[0].lines}


class TestPlotEnergy:
    def test_modes_without_a_nodal_diameter_count_as_other(self) -> None:
        result = synthetic.synthetic_result(records=5)
        result["rotor_nodal_diameter"] = "rotor_mode", np.full(5, -1)
        assert "1F, other k" in lines(plot_energy(strain_energies(result)))

    def test_long_runs_are_drawn_as_means_over_periods(self) -> None:
        result = synthetic.synthetic_result(records=3001)
        motion = np.zeros((3001, 5))
        motion[:, 3] = 1e-3 * np.cos(75.0 * result.time.values)  # at the reference frequency
        result["rotor_displacement"] = ("time", "rotor_mode"), motion
        figure = plot_energy(strain_energies(result))
        drawn = np.asarray(figure.axes[0].lines[0].get_ydata())
        assert len(drawn) == 35  # 35.8 periods
        np.testing.assert_allclose(drawn, 0.25 * (75.0 * 1e-3) ** 2, rtol=0.05)
        assert "means over 85.7 ms" in figure.get_suptitle()


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
