"""Histories of single blades and of points of the casing: gap, contact force, displacement."""

from collections.abc import Sequence
from typing import cast

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import to_si
from bladewhirl.postprocess.fields.by_blade import blade_means, contact_motion, of_blades
from bladewhirl.postprocess.fields.kinematics import casing_rows, record_lengths
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import need
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.wheels import of_wheel
from bladewhirl.postprocess.fields.windows import in_window

COMPONENTS = ("radial", "tangential")  #: outward, and counter-clockwise


def gap(result: xr.Dataset, *, start: float | None = None, end: float | None = None) -> xr.Dataset:
    """Return for every blade tip the smallest gap since the previous record, and true if the tip
    touched in this time. With several contact nodes on a tip the gap is the smallest of all.

    Args:
        result: result of a run.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (time, blade): `gap` [m], `contact` (bool).

    Example:
        ``gap(result).sel(blade=3)["gap"].plot()``
    """
    result = in_window(result, start, end)
    both = ("time", "blade")
    smallest = of_blades(result, result["gap"].values, np.minimum)
    contact = of_blades(result, result["contact_steps"].values) > 0
    return labelled(
        result,
        "gaps of the blade tips",
        {"gap": (both, smallest, "m"), "contact": (both, contact, "1")},
        {"time": result["time"].values, "blade": np.arange(smallest.shape[1])},
    )


def contact_force(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Return the contact force on every blade tip, averaged over the time since the previous
    record.

    The average converges as the time step decreases, while the peak force does not. With several
    contact nodes on a tip the force is the sum of all.

    Args:
        result: result of a run.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (time, blade): `normal` [N], positive if the casing pushes the tip inward;
        `friction` [N], positive if friction drags the tip towards -theta.

    Example:
        ``contact_force(result, start=0.5)["normal"].max("blade").plot()``
    """
    result = in_window(result, start, end)
    length = record_lengths(result)[:, None]
    both = ("time", "blade")
    normal, friction = (
        of_blades(result, result[f"{kind}_impulse"].values) / length
        for kind in ("contact", "friction")
    )
    return labelled(
        result,
        "contact forces on the blade tips",
        {"normal": (both, normal, "N"), "friction": (both, friction, "N")},
        {"time": result["time"].values, "blade": np.arange(normal.shape[1])},
    )


def tip_displacement(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Return the radial and tangential displacement of every blade tip in the rotating frame, the
    mean of the contact nodes on the tip.

    Args:
        result: result of a run; it is read portion by portion.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        `displacement` (time, component, blade) [m]; components "radial" (outward) and "tangential"
        (counter-clockwise).

    Example:
        ``tip_displacement(result)["displacement"].sel(blade=3, component="radial").plot()``
    """
    result = in_window(result, start, end)
    ways = [blade_means(result, contact_motion(result, way)) for way in range(len(COMPONENTS))]
    moved, over = np.stack(ways, axis=1), ("time", "component", "blade")
    blades = np.arange(moved.shape[2])
    return labelled(
        result,
        "displacement of the blade tips, rotating frame",
        {"displacement": (over, moved, "m")},
        {"time": result["time"].values, "component": [*COMPONENTS], "blade": blades},
    )


def casing_displacement(
    result: xr.Dataset,
    angle: ArrayLike | str | Sequence[str] = 0.0,
    *,
    wheel: int = 0,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Return the displacement of the casing at static angles, by the cubic shape functions of the
    finite elements.

    Args:
        result: result of a run; it is read portion by portion.
        angle: one angle or several angles (points,), counter-clockwise from +x: numbers in rad,
            from minus one turn to one turn, or text such as "90 deg".
        wheel: number of the wheel inside the ring, if several wheels of a shaft line have one.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        `displacement` (time, angle, component) [m]; components "radial" (outward) and "tangential"
        (counter-clockwise). For a single angle the dimension `angle` has the length 1.

    Raises:
        UserError: a text is not an angle, or an angle is more than a turn, for instance because it
            is in degrees but has no unit.

    Example:
        ``casing_displacement(result, angle="90 deg")["displacement"].sel(component="radial")``
    """
    result = in_window(result, start, end)
    need(result, "casing_displacement")
    angles = np.array([radians(value) for value in np.ravel(np.asarray(angle))])
    rows = casing_rows(of_wheel(result, wheel), angles)
    moved = reduce_modes(result, "casing_displacement", rows.reshape(-1, rows.shape[-1]))
    return labelled(
        result,
        "displacement of the casing, static frame",
        {"displacement": (("time", "angle", "component"), moved.reshape(-1, *rows.shape[:2]), "m")},
        {"time": result["time"].values, "angle": angles, "component": [*COMPONENTS]},
    )


def radians(angle: object) -> float:
    """Return an angle in rad from a number in rad or from text such as "90 deg"."""
    try:
        radians = to_si(angle, "rad") if isinstance(angle, str) else float(cast(float, angle))
    except (TypeError, ValueError) as error:
        raise UserError(f'angle = "{angle}": expected an angle ({error})') from None
    if not abs(radians) <= 2.0 * np.pi:
        raise UserError(f'angle = {angle}: expected within a turn, in rad or text such as "90 deg"')
    return radians
