"""Measures of a run by which claims of the paper are checked: regime, whirl, contact, energies."""

from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.regimes import Regime, classify
from bladewhirl.postprocess.energy.strain import energy_terms, strain_energies
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import late_part, select_window
from bladewhirl.postprocess.run.blade_contact import CLASS_COLOURS, contact_classes
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.poincare import poincare_map
from bladewhirl.postprocess.shaft.transforms import Frame
from bladewhirl.postprocess.shaft.whirl import Whirl, ripple, whirl
from bladewhirl.postprocess.shaft.whirl_history import whirl_history

HOLDERS = ("suspension", "k = 0", "k = 1", "other k", "rest")
"""Groups of modes whose strain energies are compared; k is the nodal diameter in the first blade
family, and "rest" are all other modes."""


class Motion:
    """Measures of a result, which must stay open; each measure is computed once, at its first
    use."""

    def __init__(self, result: xr.Dataset) -> None:
        self.result = result

    @cached_property
    def orbit(self) -> xr.Dataset:
        """Orbit of the shaft, from `shaft_orbit`."""
        return shaft_orbit(self.result)

    @cached_property
    def energies(self) -> xr.Dataset:
        """Strain energy [J] over time of each group of `HOLDERS`, and the total."""
        return xr.Dataset(energy_terms(strain_energies(self.result)))

    @cached_property
    def regime(self) -> Regime:
        """Regime, from `classify`."""
        return classify(self.result, self.energies["total"].values)

    @property
    def diverges(self) -> bool:
        """True if the regime is divergent."""
        return self.regime.name == "divergent"

    @property
    def end(self) -> float:
        """Time of the last record [s]."""
        return float(self.result["time"][-1])

    @cached_property
    def first_contact(self) -> float:
        """Time of the record before the first contact [s]; infinite without contact."""
        touched = np.flatnonzero(self.result["contact_steps"].values.any(axis=1))
        if not touched.size:
            return float("inf")
        return float(self.result["time"][max(0, touched[0] - 1)])

    @property
    def reference(self) -> float:
        """Reference frequency [rad/s]; speeds are given as multiples of it."""
        return float(self.result.attrs["reference_frequency"])

    @cached_property
    def radius(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Displacement of the shaft at every record [m]."""
        return np.asarray(self.orbit["radius"].values)

    def record_at(self, time: float) -> int:
        """Return the number of records up to a time [s], at least one."""
        return max(1, int(np.searchsorted(self.result["time"].values, time, side="right")))

    def radius_between(self, start: float, end: float) -> tuple[float, float]:
        """Return the mean of the shaft's displacement from `start` to `end` [s], and the difference
        of its largest and smallest value [m]."""
        values = select_window(self.orbit, start, end)["radius"].values
        return float(values.mean()), float(np.ptp(values))

    def late_whirl(self, frame: Frame) -> Whirl:
        """Return the whirl over the last third of the time."""
        return whirl(late_part(self.orbit), frame)

    @cached_property
    def late_whirl_rates(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Whirl rates in the static frame in equal spans of the last third of the time, forward
        positive [rad/s]."""
        rates = whirl_history(late_part(self.orbit))["rate"].sel(frame="static")
        return np.asarray(rates.dropna("time").values)

    @cached_property
    def late_phase(self) -> xr.Dataset:
        """Phases of shaft and contact over the last third of the time, from `contact_phase`."""
        return contact_phase(late_part(self.result), late_part(self.orbit))

    @property
    def scenario(self) -> str:
        """Contact scenario over the last third of the time."""
        return str(self.late_phase.attrs["scenario"])

    @property
    def lead(self) -> float:
        """Angle by which the shaft leads the contact over the last third of the time [degrees]."""
        return float(np.degrees(self.late_phase.attrs["lead"]))

    def energy(self, start: float, end: float) -> dict[str, float]:
        """Return the mean strain energy from `start` to `end` [s] of each group, and the total."""
        window = select_window(self.energies, start, end)
        return {name: float(window[name].mean()) for name in (*HOLDERS, "total")}

    def share(self, start: float, end: float) -> dict[str, float]:
        """Return the share of each group in the strain energy from `start` to `end` [s]."""
        energy = self.energy(start, end)
        total = energy.pop("total") or 1.0
        return {name: value / total for name, value in energy.items()}

    @property
    def late(self) -> tuple[float, float]:
        """Start and end of the last third of the time [s]."""
        return 2.0 / 3.0 * self.end, self.end

    def onset(self, times: float, since: float) -> float:
        """Return the first time [s] at which the strain energy exceeds `times` times its value at
        the time `since` [s]; infinite if it never does.

        The energy is averaged over periods of the reference frequency.
        """
        time, total = self.energies["time"].values, self.energies["total"].values
        number = (time * self.reference / (2.0 * np.pi)).astype(int)
        first = np.flatnonzero(np.diff(number, prepend=-1))
        mean = np.add.reduceat(total, first) / np.diff(first, append=len(total))
        at = int(np.searchsorted(time[first], since))
        above = np.flatnonzero(mean[at:] > times * mean[at])
        return float(time[first[at + above[0]]]) if len(above) else float("inf")

    def ripple_between(self, start: float, end: float) -> float:
        """Return the root mean square of the motion about its mean position in rotating axes, from
        `start` to `end` [s], [m]."""
        return ripple(select_window(self.orbit, start, end), "rotating")[0]

    @cached_property
    def blades(self) -> dict[str, int]:
        """Number of blades by contact class in the last third of the time."""
        classes = contact_classes(late_part(self.result))["contact_class"]
        return {name: int((classes == name).sum()) for name in CLASS_COLOURS}

    @property
    def touched(self) -> bool:
        """True if any tip touched the casing."""
        return bool((self.result["contact_steps"] > 0).any())

    def section_scatter(self) -> float:
        """Return the largest distance of a point of the Poincaré map in the last third from the
        mean of all points, relative to the mean distance of the points from the origin."""
        place = poincare_map(late_part(self.orbit))["place"].values
        spread = np.hypot(*(place - place.mean(axis=0)).T).max()
        return float(spread / np.hypot(*place.T).mean())

    @cached_property
    def casing_motion(self) -> float:
        """Largest radial displacement of a casing node in the last third of the time [m]."""
        late = late_part(self.result)
        radial = self.result["casing_shape"].isel(casing_component=0).values
        return float(np.abs(reduce_modes(late, "casing_displacement", radial)).max())


def orbit_distance(one: Motion, other: Motion, *, until: float = np.inf) -> float:
    """Return the root mean square distance of the orbits of two runs in rotating axes, relative to
    the root mean square radius of the orbit of `other`.

    Only records that both runs contain, up to the time `until` [s], are compared. NaN if the shaft
    of `other` is at rest.
    """
    a, b = one.orbit["rotating"].values, other.orbit["rotating"].values
    records = min(len(a), len(b), other.record_at(until))
    apart = np.sqrt(np.mean(np.sum((a[:records] - b[:records]) ** 2, axis=1)))
    size = np.sqrt(np.mean(other.radius[:records] ** 2))
    return float(apart / size) if size else float("nan")
