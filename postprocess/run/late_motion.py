"""Measures of the last third of a run: whirl, contact side, contact of blades, Poincaré map."""

from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.run.blade_contact import contact_share
from bladewhirl.postprocess.run.contact_side import contact_scenario
from bladewhirl.postprocess.shaft.poincare import section_places
from bladewhirl.postprocess.shaft.whirl import whirls
from bladewhirl.postprocess.shaft.whirl_history import rotating_rates


def late_motion(late: xr.Dataset, orbit: xr.Dataset) -> dict[str, Any]:
    """Measure the motion in the last third of a run.

    Args:
        late: result, from `windows.late_part`.
        orbit: from `orbits.shaft_orbit`, for the same time window.

    Returns:
        values of variables of a sweep, by name; `solvers.march.schema` describes the variables.
        `late_contact_share` (blade,) is nan if there is a single record, `whirl_scatter` is nan if
        `whirl_history` has a single span. `radius_peak` (peak,) [m] contains all maxima of the
        displacement, `section` (revolution, 2) [m] all positions of the Poincaré map, which are the
        same in both frames.
    """
    scenario, lead, steadiness = contact_scenario(late, orbit)
    turning, rates = whirls(orbit), rotating_rates(orbit)
    rates = rates[~np.isnan(rates)]
    share = np.full(late.sizes["blade"], np.nan)
    if orbit.sizes["time"] > 1:
        share = contact_share(late)
    try:
        section = section_places(orbit)[1]
    except ViewError:  # less than a revolution
        section = np.empty((0, 2))
    return {
        "late_radius": float(np.sqrt(np.mean(orbit.variables["radius"].values ** 2))),
        "whirl_rotating": turning["rotating"].direction,
        "whirl_static": turning["static"].direction,
        "whirl_frequency": turning["rotating"].rate / (2 * np.pi),
        "whirl_scatter": float(rates.std() / (2 * np.pi)) if len(rates) > 1 else np.nan,
        "scenario": scenario.replace(" ", "-"),
        "shaft_lead": lead,
        "lead_steadiness": steadiness,
        "late_contact_share": share,
        "section": section,
        "radius_peak": radius_peaks(orbit),
    }


def radius_peaks(orbit: xr.Dataset) -> Array:
    """Return the local maxima of the displacement of the shaft, also between records, (peaks,) [m].

    The square of the displacement is interpolated by cubics through the values and rates at the
    records. A maximum is where the rate, interpolated linearly between records, falls through zero.
    """
    time, place, velocity = (
        orbit.variables[name].values for name in ("time", "rotating", "rotating_velocity")
    )
    square, rate = np.sum(place**2, axis=1), 2.0 * np.sum(place * velocity, axis=1)
    before = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0))
    if not before.size:
        return np.empty(0)
    share = rate[before] / (rate[before] - rate[before + 1])
    instants = time[before] + share * (time[before + 1] - time[before])
    return np.asarray(np.sqrt(CubicHermiteSpline(time, square, rate)(instants)))
