"""Growth by internal damping of a bladed disk of beams."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.cyclic import nodal_diameters
from bladewhirl.models.structure.rotating import Effects

WEAKEST, STRONGEST = 1e-9, 1e3
"""Smallest and largest bearing damping that is tried, divided by mass at the centre times speed."""

TRIED = 200  #: number of values of bearing damping that are tried


@dataclass(frozen=True, kw_only=True)
class InternalGrowth:
    """Fastest growing motion of a bladed disk at a speed, without casing."""

    rate: float  #: growth rate [1/s]; negative if all motions decay
    nodal_diameter: int
    holding: float | None
    """Least damping of bearings fixed in space, along x and along y, that makes the bladed disk
    stable [N s/m]; zero if no damping is needed, None if bearings cannot stabilise the disk."""


def internal_growth(
    disk: BladedDiskModel, omega: float, effects: Effects, *, damping_ratio: float
) -> InternalGrowth:
    """Return the growth that internal (modal) damping causes in a bladed disk with equal sectors.

    Args:
        disk: the bladed disk with the matrices of its rotation.
        omega: speed of rotation [rad/s].
        effects: rotation effects to include.
        damping_ratio: damping ratio of every mode at rest.
    """
    structure, layout = disk.structure, disk.structure.layout
    assert layout is not None  # its sectors are equal
    rates = {
        k: structure.wave(k).under(effects).growth(omega, damping_ratio)
        for k in nodal_diameters(layout.sectors)
    }
    fastest = max(rates, key=lambda k: rates[k])
    others = max((rate for k, rate in rates.items() if k != 1), default=-np.inf)
    holding: float | None = 0.0
    if rates[fastest] > 0.0:
        holding = None
        if others <= 0.0 and disk.centre.size:
            centre = np.asarray(layout.basis(1).conj().T[:, disk.centre].toarray())
            first = structure.wave(1).under(effects)
            mass = float(np.trace(centre.conj().T @ first.mass @ centre).real)
            growth = partial(first.growth, omega, damping_ratio, centre)
            holding = _holding(growth, mass * abs(omega))
    return InternalGrowth(rate=rates[fastest], nodal_diameter=int(fastest), holding=holding)


def _holding(growth: Callable[[float], float], scale: float) -> float | None:
    """Return the least bearing damping without growth [N s/m]; None if growth always remains.

    Args:
        growth: largest growth rate [1/s] as a function of the bearing damping.
        scale: mass at the centre times speed, a typical bearing damping [N s/m].
    """
    from scipy.optimize import brentq  # long to load

    below = 0.0
    for bearing in (scale * np.geomspace(WEAKEST, STRONGEST, TRIED)).tolist():
        if growth(bearing) <= 0.0:
            return float(brentq(growth, below, bearing, rtol=1e-9))
        below = bearing
    return None
