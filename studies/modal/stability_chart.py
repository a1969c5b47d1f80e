"""Growth rate of coupled modes against speed and stiffness, with zones and eigenvalues."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.solvers.stability.growth import Progress, coincidence_speeds, eigenvalues, track
from bladewhirl.solvers.stability.zones import UnstableZones, unstable_zones
from bladewhirl.studies.modal.coupled_system import EvenSystem, System
from bladewhirl.studies.runs.columns import quantity

StringArray = NDArray[np.str_]

BORDER_STIFFNESSES = 61  #: number of stiffnesses at which the borders of zones are computed

LINE_SPEEDS, ZONE_SPEEDS = 1201, 21
"""Number of speeds along a line of constant stiffness, and of the speeds that are added to them
inside each zone."""

MULTIPLES = {"units": "1", "long_name": "speed in multiples of reference_frequency"}
GROWTH = {"units": "1/s", "long_name": "largest real part of the spectrum"}
STIFFNESS = {"units": "N/m", "long_name": "coupling stiffness"}


def stability_chart(
    system: System, omegas: FloatArray, kappas: FloatArray, progress: Progress | None = None
) -> xr.Dataset:
    """Compute growth rates at ascending speeds omegas [rad/s] and spring stiffnesses kappas
    [N/m]; for an `EvenSystem`, also the unstable zones."""
    growth = system.growth(omegas, kappas, progress)
    data = _ranges(system, omegas, kappas)
    if isinstance(system, EvenSystem):
        data = zones(system, system.modes, omegas, kappas)
    return (
        data.assign(growth=(("kappa", "speed"), growth, GROWTH))
        .assign_coords(
            kappa=("kappa", kappas, STIFFNESS),
            speed=("speed", omegas / system.reference, MULTIPLES),
        )
        .assign_attrs(system.attributes())
    )


def zones(
    system: System, modes: CouplingModes, omegas: FloatArray, kappas: FloatArray
) -> xr.Dataset:
    """Compute the borders of unstable zones, and the coincidence speeds at which the zones start.

    The modes are all coupled modes of the system, or some of them; speeds omegas [rad/s] and spring
    stiffnesses kappas [N/m] are in ascending order.
    """
    borders = unstable_zones(
        modes,
        kappas=np.linspace(kappas[0], kappas[-1], BORDER_STIFFNESSES),
        low=omegas[0],
        high=omegas[-1],
    )
    names, unit = np.array(modes.name), system.reference
    pairs = coincidence_speeds(modes)
    casings, rotors = np.array(list(pairs), dtype=np.int64).reshape(-1, 2).T
    coincidence = MULTIPLES | {"long_name": "coincidence speed, Eq. (14)"}
    starts = [
        pairs.get(pair, np.nan) / unit for pair in zip(borders.casing, borders.rotor, strict=True)
    ]
    return _ranges(system, omegas, kappas).assign(
        **_zone_variables(borders, names, unit),
        zone_kappa=quantity("zone", borders.kappa, "N/m"),
        zone_nodal_diameter=("zone", modes.nodal_diameter[borders.casing]),
        zone_start=("zone", np.array(starts), coincidence),
        coincidence=("pair", np.array([*pairs.values()]) / unit, coincidence),
        coincidence_nodal_diameter=("pair", modes.nodal_diameter[casings]),
        coincidence_casing=("pair", names[casings]),
        coincidence_rotor=("pair", names[rotors]),
    )


def _zone_variables(borders: UnstableZones, names: StringArray, unit: float) -> dict[str, Any]:
    return {
        "zone_lower": ("zone", borders.lower / unit, MULTIPLES),
        "zone_upper": ("zone", borders.upper / unit, MULTIPLES),
        "zone_growth": quantity("zone", borders.growth, "1/s"),
        "zone_casing": ("zone", names[borders.casing]),
        "zone_rotor": ("zone", names[borders.rotor]),
    }


def _ranges(system: System, omegas: FloatArray, kappas: FloatArray) -> xr.Dataset:
    """Return a chart with its attributes only, without variables."""
    unit = system.reference
    return xr.Dataset(
        attrs={
            "title": "stability chart",
            "case": system.case,
            "reference_frequency": unit,
            "speed_range": [omegas[0] / unit, omegas[-1] / unit],
            "kappa_range": [kappas[0], kappas[-1]],
        }
    )


def truncation(complete: xr.Dataset, few: xr.Dataset) -> xr.Dataset:
    """Join the zones of all modes and of a few modes; `zone_of` labels them "all" and "few"."""
    parts = [
        data[[str(name) for name in data.data_vars if str(name).startswith("zone_")]].assign(
            zone_of=("zone", np.full(data.sizes["zone"], label))
        )
        for label, data in (("all", complete), ("few", few))
    ]
    return xr.concat(parts, dim="zone").assign_attrs(title="unstable zones that the six modes hide")


def spectrum_along(system: EvenSystem, omegas: FloatArray, kappa: float) -> xr.Dataset:
    """Compute eigenvalues, tracked along branches, from the first to the last of the speeds omegas
    [rad/s] at the spring stiffness kappa [N/m]."""
    low, high = omegas[0], omegas[-1]
    borders = unstable_zones(system.modes, kappas=np.array([kappa]), low=low, high=high)
    inside = np.linspace(borders.lower, borders.upper, ZONE_SPEEDS).ravel()
    along = np.unique(np.append(np.linspace(low, high, LINE_SPEEDS), inside))
    spectra = eigenvalues(system.modes, speed=along, kappa=kappa)
    branches, plane = track(along, spectra), ("speed", "branch")
    title, unit = "eigenvalues in the invariant frame", system.reference
    return xr.Dataset(
        data_vars={
            "real": quantity(plane, branches.real, "1/s", "growth rate"),
            "imaginary": quantity(plane, branches.imag, "rad/s", "frequency"),
            "branch_name": ("branch", _branch_names(system.modes, along[0], branches[0])),
            **_zone_variables(borders, np.array(system.modes.name), unit),
        },
        coords={"speed": ("speed", along / unit, MULTIPLES)},
        attrs=system.attributes() | {"title": title, "kappa": kappa, "reference_frequency": unit},
    )


def _branch_names(modes: CouplingModes, omega: float, spectrum: ComplexArray) -> StringArray:
    """Name each branch after the wave of an uncoupled mode with the nearest eigenvalue at the speed
    omega [rad/s]; `spectrum` contains the eigenvalues of the branches at this speed."""
    alone, names = [], []
    for entry in range(modes.entries):
        part = modes.take(np.array([entry]))
        values = eigenvalues(part, speed=omega, kappa=0.0)
        waves = len(values) // 2 if part.paired[0] else 0
        static = np.append(values[:waves], values[waves:].conj()).imag + omega * part.frame_rate[0]
        directions = ["forward" if rate > 0.0 else "backward" for rate in static]
        alone.append(values)
        names += [f"{part.name[0]}{f', {way}' if waves else ''}" for way in directions]
    distance = np.abs(spectrum[:, None] - np.concatenate(alone)) ** 2
    return np.asarray(np.array(names)[linear_sum_assignment(distance)[1]], dtype=np.str_)
