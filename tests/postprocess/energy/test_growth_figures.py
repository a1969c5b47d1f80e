"""The growth rate of a motion as a figure: known rates come out, noise widens the band."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.energy.growth import amplitude_growth, plot_growth
from bladewhirl.postprocess.energy.regimes import classify
from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.fields.kinematics import ViewError

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
