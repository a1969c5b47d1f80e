"""Strain energy by groups of modes and by families, against single modes; growth at known rates."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from bladewhirl.postprocess.energy.growth import amplitude_growth, plot_growth
from bladewhirl.postprocess.energy.regimes import classify
from bladewhirl.postprocess.energy.strain import (
    family_energies,
    group_energies,
    plot_energy,
    plot_family_energies,
    strain_energies,
)
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.result import completed

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

    def test_modes_without_families_are_springs_too(self) -> None:
        result = single(2)
        energy, diameters = group_energies(completed(result.drop_vars("rotor_family")))
        assert not diameters.size
        np.testing.assert_allclose(energy[:, -1], strain_energies(result).total, rtol=1e-13)

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


RECORDS = 4001  # 4 s: windows that average the slow suspension's ripple


def growing(rate: float) -> xr.Dataset:
    return synthetic.synthetic_result(
        blades=6, records=RECORDS, shaft_radius=1e-5, bending=1e-5, ovalisation=0.0, growth=rate
    )


@pytest.mark.parametrize("rate", [-0.3, 1.5])
def test_a_known_rate_comes_out_within_its_band(rate: float) -> None:
    still = growing(rate)
    # The rigid rotation does not grow; without it all energy goes as exp(2 rate t).
    moving = still["rotor_displacement"] * (still["rotor_frequency"] != 400.0)
    growth = amplitude_growth(still.assign(rotor_displacement=moving))
    assert growth.attrs["rate"] == pytest.approx(rate, rel=1e-2)
    late = growth.isel(time=np.flatnonzero(np.isfinite(growth["fit"].values)))
    assert late.sizes["time"] == growth.sizes["time"] // 3
    assert np.all(late["low"] <= late["fit"])
    assert np.all(late["high"] >= late["fit"])
    np.testing.assert_allclose(late["fit"], late["energy"], rtol=2e-2)
    np.testing.assert_allclose(late["local_rate"], rate, atol=0.02)
    assert growth.attrs["residual"] < 0.01
    exact = 0.5 * np.log(late["fit"].values[-1] / late["fit"].values[0])
    span = float(late["time"][-1] - late["time"][0])
    assert exact / span == pytest.approx(growth.attrs["rate"], rel=1e-9)
    width = 0.5 * np.log((late["high"] / late["fit"]).values[-1]) / (span / 2)
    assert width == pytest.approx(2 * growth.attrs["error"], rel=1e-9)


def test_it_is_the_growth_of_the_regime_and_says_so() -> None:
    result = growing(1.5)
    growth = amplitude_growth(result)
    regime = classify(result, strain_energies(result)["total"].values)
    assert regime.growth is not None
    assert growth.attrs["rate"] == regime.growth.rate
    assert growth.attrs["regime"] == regime.name
    figure = plot_growth(growth)
    axes, misfits = figure.axes
    # ± is two standard errors, as the band is.
    words = misfits.get_xlabel()
    assert f"{regime.growth.rate:.3g} ± {2 * regime.growth.error:.2g} 1/s" in words
    misfit = np.log1p(np.asarray(misfits.lines[0].get_ydata()) / 100)
    assert np.nanstd(misfit) == pytest.approx(growth.attrs["residual"], rel=1e-6)
    assert axes.get_yscale() == "log"  # it grows by more than ten times


def test_a_short_history_has_none() -> None:
    with pytest.raises(ViewError, match="too short for a growth rate"):
        amplitude_growth(synthetic.synthetic_result(blades=6, records=40))
