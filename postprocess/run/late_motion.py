"""Measures of the last third of a run: whirl, contact side, contact of blades, Poincaré map."""

import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run.blade_contact import contact_classes
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.shaft.poincare import poincare_map
from bladewhirl.postprocess.shaft.whirl import FRAMES, whirl
from bladewhirl.postprocess.shaft.whirl_history import whirl_history


def late_motion(dataset: xr.Dataset, orbit: xr.Dataset) -> xr.Dataset:
    """Measure the motion in the last third of a run.

    Args:
        dataset: a result.
        orbit: from `orbits.shaft_orbit`, for the same time window.

    Returns:
        Dataset of measures. `late_radius` [m]: root mean square displacement of the shaft.
        `whirl_rotating` and `whirl_static`: directions of whirl in the two frames.
        `whirl_frequency` [Hz]: frequency in the rotating frame, forward positive, nan at rest; the
        frequency in the static frame is higher by the speed. `whirl_scatter` [Hz]: standard
        deviation of the frequency over the time spans of `whirl_history`, nan for a single span.
        `scenario`, `shaft_lead` [rad] and `lead_steadiness`: from `contact_phase`.
        `late_contact_share` (blade,): share of the time in contact, nan for a single record.
        `section` (revolution, axis) [m]: positions of the Poincaré map, which are the same in both
        frames. `radius_peak` (peak,) [m]: local maxima of the displacement.
    """
    late, path = late_part(dataset), late_part(orbit)
    phases = contact_phase(late, path)
    turning = {frame: whirl(path, frame) for frame in FRAMES}
    radius = float(np.sqrt(np.mean(path["radius"].values ** 2)))
    rates = whirl_history(path)["rate"].sel(frame="rotating").dropna("time").values
    hertz = {"units": "Hz"}
    scatter = rates.std() if len(rates) > 1 else np.nan
    if path.sizes["time"] > 1:
        share = contact_classes(late)["share"].values
    else:
        share = np.full(dataset.sizes["blade"], np.nan)
    return xr.Dataset(
        {
            "late_radius": ((), radius, {"units": "m"}),
            **{f"whirl_{frame}": ((), turning[frame].direction) for frame in FRAMES},
            "whirl_frequency": ((), turning["rotating"].rate / (2 * np.pi), hertz),
            "whirl_scatter": ((), scatter / (2 * np.pi), hertz),
            "scenario": ((), phases.attrs["scenario"].replace(" ", "-")),
            "shaft_lead": ((), phases.attrs["lead"], {"units": "rad"}),
            "lead_steadiness": ((), phases.attrs["steadiness"], {"units": "1"}),
            "late_contact_share": ("blade", share, {"units": "1"}),
            "section": (("revolution", "axis"), _sections(path), {"units": "m"}),
            "radius_peak": ("peak", radius_peaks(path), {"units": "m"}),
        }
    )


def radius_peaks(orbit: xr.Dataset) -> Array:
    """Return the local maxima of the displacement of the shaft, also between records, (peaks,) [m].

    The square of the displacement is interpolated by cubics through the values and rates at the
    records. A maximum is where the rate, interpolated linearly between records, falls through zero.
    """
    time = orbit["time"].values
    place, velocity = orbit["rotating"].values, orbit["rotating_velocity"].values
    square, rate = np.sum(place**2, axis=1), 2.0 * np.sum(place * velocity, axis=1)
    before = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0))
    if not before.size:
        return np.empty(0)
    share = rate[before] / (rate[before] - rate[before + 1])
    instants = time[before] + share * (time[before + 1] - time[before])
    return np.asarray(np.sqrt(CubicHermiteSpline(time, square, rate)(instants)))


def _sections(orbit: xr.Dataset) -> Array:
    """Return the positions of the Poincaré map (revolutions, 2) [m]; an empty array if the time is
    shorter than a revolution."""
    try:
        return np.asarray(poincare_map(orbit)["place"].values)
    except ViewError:
        return np.empty((0, 2))
