"""Regime of the run of a superelement."""

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.growth_rates import RIGID, windowed_amplitude
from bladewhirl.postprocess.energy.regimes import Regime, classify_windows


def node_regime(dataset: xr.Dataset) -> Regime:
    """Classify the run of a superelement by `CRITERION`.

    The amplitude is the root of the mean energy in windows of at least one revolution, and half a
    period of the lowest elastic mode; the energy is that of all copies, with the kinetic energy and
    that of a flexible casing.
    """
    frequency = dataset["modal_frequency"].values
    elastic = frequency[frequency > RIGID * frequency.max()]
    speed = abs(float(dataset.attrs["speed"]))
    shortest = max(np.pi / elastic.min(), 2.0 * np.pi / speed if speed else 0.0)
    windows = windowed_amplitude(dataset["time"].values, dataset["energy"].values, shortest)
    return classify_windows(dataset, windows, clearance=smallest_node_clearance(dataset))


def smallest_node_clearance(dataset: xr.Dataset) -> float:
    """Return the smallest clearance plus the smallest distance of a contact node inside the radius
    from which the clearance is measured [m]."""
    return float(dataset["clearance"].values.min() + dataset["contact_recess"].values.min())
