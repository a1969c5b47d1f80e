"""Critical speeds of a bladed disk: speeds at which its shaft whirls at the speed of rotation."""

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.rotation.unequal_bearings import EllipticWaves, on_bearings
from bladewhirl.models.structure.waves import Waves

ORDERS = {"forward": 0, "backward": 2}
"""Ratio of the frequency in the rotating frame to the speed of rotation, for forward and backward
whirl at the speed of rotation. A whirl with k = 1 that goes backward in the static frame at the
rate Omega goes backward at 2 Omega in the rotating frame."""

ELLIPTIC_ORDERS = {"elliptic": 0}
"""The same on unequal stationary bearings, where every whirl is an ellipse."""

MOST = 4  #: largest number of critical speeds of each whirl in `lowest_critical_speeds`


def centre_in_waves(disk: BladedDiskModel) -> ComplexArray:
    """Return the displacement of the centre along x and y in the waves of nodal diameter 1, (2, n);
    (0, n) for a clamped centre."""
    layout = disk.structure.layout
    assert layout is not None  # it has waves
    return np.asarray(layout.basis(1)[disk.centre].toarray())


def orders_of(given: Waves) -> dict[str, int]:
    """Return the orders of the whirls at the speed of rotation, by the names of the whirls."""
    return ELLIPTIC_ORDERS if isinstance(given, EllipticWaves) else ORDERS


def lowest_critical_speeds(
    case: Case, disk: BladedDiskModel
) -> tuple[FloatArray, NDArray[np.str_]]:
    """Return the lowest critical speeds of a case [rad/s], (speeds,), ascending, and the whirl at
    each, "forward", "backward" or "elliptic", (speeds,).

    There are none without Coriolis forces, with a clamped centre or with unequal sectors, whose
    waves do not have a single nodal diameter.
    """
    none = np.zeros(0), np.zeros(0, dtype=np.str_)
    if case.rotation.effects != "full" or case.shaft.clamped:
        return none
    if not disk.structure.still.is_cyclic:
        return none
    waves = disk.structure.wave(1).under(case.rotation.effects)
    given = on_bearings(waves, centre_in_waves(disk), case.shaft.anisotropy)
    speeds, whirls = list[float](), list[str]()
    for name, order in orders_of(given).items():
        found = given.synchronous(order)[0][:MOST].tolist()
        speeds += found
        whirls += [name] * len(found)
    order_of = np.argsort(speeds, kind="stable")
    return np.array(speeds)[order_of], np.array(whirls, dtype=np.str_)[order_of]
