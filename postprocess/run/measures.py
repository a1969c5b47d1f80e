"""Measures of a run, for its summary, for sweeps and for claims of the paper: regime, whirl,
contact, energies."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, Literal

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.regimes import CRITERION_TEXT, Regime, classify
from bladewhirl.postprocess.energy.strain import energy_terms, group_energies, strain_energies
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.by_blade import largest_displacement
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, smallest_clearance
from bladewhirl.postprocess.fields.labelled import LOSS
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import late_part, select_window
from bladewhirl.postprocess.run.blade_contact import CLASS_COLOURS, contact_classes
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.shaft.orbits import centre_displacement, shaft_orbit
from bladewhirl.postprocess.shaft.poincare import poincare_map
from bladewhirl.postprocess.shaft.transforms import Frame
from bladewhirl.postprocess.shaft.whirl import Whirl, ripple, whirl
from bladewhirl.postprocess.shaft.whirl_history import whirl_history

HOLDERS = ("suspension", "k = 0", "k = 1", "other k", "rest")
"""Groups of modes whose strain energies are compared; k is the nodal diameter in the first blade
family, and "rest" are all other modes."""


MARCH_REPORT: Mapping[str, type[float]] = {
    "complementarity_residual": float,
    "unsolved_steps": int,
    "dt_over_critical": float,
    "steps": int,
    "wall_time": float,
    "us_per_step": float,
}
"""Key figures of the march that the histories in a result do not contain, with their types."""

LATE = 10
"""The impulse per revolution is averaged over up to this many complete revolutions at the end."""


class Motion:
    """Measures of a result, which must stay open; each measure is computed once, at its first use.

    Args:
        result: a result.
        report: key figures of the march, see `MARCH_REPORT`.
        orbit: from `shaft_orbit`; computed when None.
    """

    def __init__(
        self,
        result: xr.Dataset,
        report: Mapping[str, float] | None = None,
        *,
        orbit: xr.Dataset | None = None,
    ) -> None:
        self.result, self.report, self._orbit = result, report or {}, orbit

    @cached_property
    def orbit(self) -> xr.Dataset:
        """Orbit of the shaft, from `shaft_orbit`."""
        return shaft_orbit(self.result) if self._orbit is None else self._orbit

    @cached_property
    def groups(self) -> tuple[Array, IntArray]:
        """Strain energies of groups of modes, from `group_energies`."""
        return group_energies(self.result)

    @cached_property
    def strain_energy(self) -> Array:
        """Strain energy of bladed disk and shaft springs at every record [J]."""
        return np.asarray(self.groups[0].sum(axis=1))

    @cached_property
    def energies(self) -> xr.Dataset:
        """Strain energy [J] over time of each group of `HOLDERS`, and the total."""
        return xr.Dataset(energy_terms(strain_energies(self.result)))

    @cached_property
    def regime(self) -> Regime:
        """Regime, from `classify`."""
        return classify(self.result, self.strain_energy)

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
    def radius(self) -> Array:
        """Displacement of the shaft at every record [m], the largest along a shaft line."""
        if has(self.result, "line"):
            x, y = np.moveaxis(self.result["shaft_displacement"].values[..., :2], 2, 0)
            return np.asarray(np.hypot(x, y).max(axis=1))
        return np.asarray(np.hypot(*centre_displacement(self.result).T))

    @property
    def has_shaft(self) -> bool:
        """True if the stage has a centre."""
        return has(self.result, "centre")

    @property
    def moves_shaft(self) -> bool:
        """True if the stage has a centre or a shaft line."""
        return self.has_shaft or has(self.result, "line")

    @property
    def places(self) -> Array:
        """Displacement of what moves at every record [m], (time, places, axes): of the centre in
        rotating axes, of the nodes of a shaft line in static axes, else of the contact nodes."""
        if self.has_shaft and self.radius.any():
            return np.asarray(self.orbit["rotating"].values[:, None])
        if has(self.result, "line"):
            return np.asarray(self.result["shaft_displacement"].values[..., :2])
        return np.asarray(self.result["contact_displacement"].values)

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


def energy_residual(dataset: xr.Dataset) -> float:
    """Return the largest error of the energy balance relative to its largest term; 0 at rest.

    At every record, energy - energy_0 = external + normal + friction + coupling work - damping
    work - work of joints. Works are since the first record, energy_0 is the energy at the first
    record, and damping and joints take positive work.
    """
    works = {
        name: dataset.variables[f"{name}_work"].values
        for name in ("external", "normal", "friction", "coupling", "damping")
    }
    if has(dataset, "joints"):
        works["joints"] = -dataset.variables["joint_work"].values.sum(axis=1)
    energy = dataset.variables["energy"].values
    since: dict[str, Array] = {name: work - work[0] for name, work in works.items()}
    taken = since.pop("damping")
    gained = sum(since.values()) - taken
    error = np.abs(energy - energy[0] - gained).max()
    largest = max(np.abs(term).max() for term in (energy, *works.values()))
    return float(error / largest) if largest > 0 else 0.0


def late_impulse(dataset: xr.Dataset) -> float | None:
    """Return the normal impulse on all contact nodes per revolution [N s], averaged over at most
    `LATE` complete revolutions at the end; None without a complete revolution."""
    turned = rotation.turns(dataset)
    whole = int(min(LATE, np.floor(turned[-1] + 1e-9)))
    if whole < 1:
        return None
    total = np.cumsum(dataset["contact_impulse"].values.sum(axis=1))
    sums = np.interp([turned[-1] - whole, turned[-1]], turned, total)
    return float((sums[1] - sums[0]) / whole)


def _report(name: str) -> Callable[[Motion], Any]:
    return lambda run: MARCH_REPORT[name](run.report[name])


def _attribute(name: str) -> Callable[[Motion], Any]:
    return lambda run: run.result.attrs.get(name)


def _fit(kind: Literal["growth", "ripple"], name: str) -> Callable[[Motion], Any]:
    return lambda run: getattr(getattr(run.regime, kind), name, None)


MEASURES: Mapping[str, Callable[[Motion], Any]] = {
    "regime": lambda run: run.regime.name,
    "regime_criterion": lambda run: f"{CRITERION_TEXT}. Here: {run.regime.reason}.",
    "growth_rate": _fit("growth", "rate"),
    "growth_rate_error": _fit("growth", "error"),
    "growth_error": _fit("growth", "error"),  # in a sweep
    "growth_rate_end": _fit("growth", "end_rate"),
    "growth_residual": _fit("growth", "residual"),
    "ripple_growth_rate": _fit("ripple", "rate"),
    "ripple_growth_rate_error": _fit("ripple", "error"),
    "end_reason": _attribute("end_reason"),
    "end_time": lambda run: run.end,
    "revolutions": lambda run: float(rotation.turns(run.result)[-1]),
    "rotation_speed": _attribute("speed"),
    "reference_frequency": _attribute("reference_frequency"),
    "shaft_radius_max": lambda run: float(run.radius.max()) if run.moves_shaft else None,
    "shaft_radius_final": lambda run: float(run.radius[-1]) if run.moves_shaft else None,
    "tip_displacement_max": lambda run: largest_displacement(run.result),
    "smallest_clearance": lambda run: smallest_clearance(run.result),
    "strain_energy_max": lambda run: float(run.strain_energy.max()),
    "energy_final": lambda run: float(run.result.variables["energy"].values[-1]),
    "contact_impulse": lambda run: float(run.result.variables["contact_impulse"].values.sum()),
    "impulse_per_revolution": lambda run: late_impulse(run.result),
    "gap_violation_max": lambda run: max(
        0.0, -float(run.result.variables["gap"].values.min(initial=0.0))
    ),
    "blade_loss": _attribute(LOSS),
    "fuse_time": _attribute("fuse_time"),
    "yield_strength": _attribute("yield_strength"),
    "record_step": lambda run: float(run.result.attrs["record_step"]),
    "energy_residual": lambda run: energy_residual(run.result),
    "unsolved_time": _attribute("unsolved_time"),
    **{name: _report(name) for name in MARCH_REPORT},
}
"""Measures of every march by name, as functions of a run; None if a run does not have a measure.
The row of the name in `solvers/march/schema.csv` gives unit and meaning, and says where the measure
appears."""


def motion_distance(one: Motion, other: Motion, *, until: float = np.inf) -> float:
    """Return the root mean square distance of the motions of two runs, see `Motion.places`,
    relative to the root mean square displacement of `other`.

    Only records that both runs contain, up to the time `until` [s], are compared. NaN if `other` is
    at rest.
    """
    a, b = one.places, other.places
    records = min(len(a), len(b), other.record_at(until))
    apart, size = (np.linalg.norm(each) for each in (a[:records] - b[:records], b[:records]))
    return float(apart / size) if size else float("nan")
