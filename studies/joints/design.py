"""Design curve of joints: the largest amplitude over the speed at values of a key, such as the
preload, and the value at which it is smallest."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, cast

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import speed_of
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.limits import LIMITS
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.postprocess.joints.design import plot_design
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joint_stability import NEUTRAL, largest_multiplier
from bladewhirl.studies.joints.motions import check, limits_of, stage_of
from bladewhirl.studies.joints.peaks import Peak, peak
from bladewhirl.studies.modal.response import response
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, table
from bladewhirl.studies.sweeps.parameter import Parameter

VALUES = 12  #: number of values of the key
STAGES = 512  #: largest number of speeds whose reduced bladed disks are kept
RATIO = 4.0  #: ratio of the ends of a range from which on values are at equal ratios
OPTIMUM_STEPS, OPTIMUM_WIDTH = 12, 0.02
"""Largest number of values at which the smallest peak is sought, and its accuracy as a share of the
range."""
FLAT = 1e-3  #: relative difference of peaks up to which none is the smallest

COLUMNS = (
    Column("parameter", "value", ".6g"),
    Column("amplitude", "peak [mm]", ".4g", 1e3),
    Column("speed_rpm", "[rpm]", ".1f"),
    Column("place", "is"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("stable", "stable"),
    Column("not_found", "speeds without a motion", "d"),
)
"""Columns of the peaks."""


def design(
    case: Case,
    parameter: Parameter,
    speeds: Sequence[float | str],
    values: int = VALUES,
    progress: Callable[[float, int], None] | None = None,
) -> xr.Dataset:
    """Compute the largest amplitude over the speed at values of a key; see `bladewhirl.branch`.

    Motions have a fixed number of harmonics, those at the peaks as many as they need. Speeds of the
    resonances of the linear limits are added, so that narrow peaks are not missed.

    Raises:
        CaseError: the case cannot be built at a value.
        UserError: the method does not apply, or no motion was found at a value.
    """
    if len(speeds) < 3 or values < 3:
        raise UserError(f"branch: {len(speeds)} speeds, {values} points: expected at least 3 each")
    base = stage_of(parameter.case(case, parameter.start)).over_many_speeds
    reference = base.reference_frequency
    texts = [speed_of(each, f"branch: speeds {each!r}") for each in speeds]
    given = np.unique([each.multiple(reference) * reference for each in texts])
    linear = response(base, speeds=(given / reference).tolist())
    inside = linear["peak_rpm"].values * np.pi / 30.0
    omegas = np.unique(np.concatenate([given, inside])).tolist()
    check(base, contact_problem(base, steps=False))
    if not any(jointed_wheel(base).orders):
        raise UserError('periodic: expected excitation.type = "engine-order" of an order above 0')

    stages = lru_cache(maxsize=STAGES)(base.at)

    def wheel_at(value: float) -> Callable[[float], JointedWheel]:
        own = parameter.case(case, value)
        return lambda omega: jointed_wheel(cast(Matrices, stages(omega).with_case(own)))

    def peak_at(value: float) -> Peak:
        try:
            return peak(wheel_at(value), omegas)
        except NotConverged as reason:
            raise UserError(f"branch: {parameter.text(value)}: {reason}") from None

    even = np.geomspace if _by_ratio(parameter) else np.linspace
    grid = even(parameter.start, parameter.stop, values).tolist()
    peaks = dict[float, Peak]()
    for done, value in enumerate(grid, 1):
        peaks[value] = peak_at(value)
        if progress is not None:
            progress(done / values, done)
    least = grid.index(min(grid, key=lambda value: peaks[value].amplitude))
    highest = max(each.amplitude for each in peaks.values())
    if 0 < least < values - 1 and peaks[grid[least]].amplitude < (1.0 - FLAT) * highest:
        _add_near(peaks, peak_at, sorted((grid[least - 1], grid[least + 1])), _by_ratio(parameter))
    return _dataset(case, parameter, peaks, omegas, wheel_at(grid[0]), reference)


def _by_ratio(parameter: Parameter) -> bool:
    """Return whether the values are at equal ratios."""
    low, high = sorted((parameter.start, parameter.stop))
    return low > 0.0 and high >= RATIO * low


def _add_near(
    peaks: dict[float, Peak], peak_at: Callable[[float], Peak], ends: list[float], by_ratio: bool
) -> None:
    """Add peaks at values near the smallest one."""
    to, back = (np.log, np.exp) if by_ratio else (float, float)

    def height(place: float) -> float:
        value = float(back(place))
        peaks[value] = peak_at(value)
        return peaks[value].amplitude

    low, high = (float(to(end)) for end in ends)
    minimize_scalar(
        height,
        bounds=(low, high),
        method="bounded",
        options={"xatol": OPTIMUM_WIDTH * (high - low), "maxiter": OPTIMUM_STEPS},
    )


def _dataset(
    case: Case,
    parameter: Parameter,
    peaks: dict[float, Peak],
    omegas: Sequence[float],
    wheel_at: Callable[[float], JointedWheel],
    reference: float,
) -> xr.Dataset:
    """Return the Dataset of `design`."""
    order = sorted(peaks)
    found = [peaks[value] for value in order]
    wheels = [wheel_at(omega) for omega in omegas]
    limits = np.array([limits_of(wheel).max(axis=1) for wheel in wheels]).T
    growth = [largest_multiplier(each.motion) for each in found]
    rpm = 30.0 / np.pi
    return xr.Dataset(
        {
            "amplitude": quantity(
                ("value", "speed"), [each.at_speeds for each in found], "m", "amplitude"
            ),
            "peak_amplitude": quantity("value", [each.amplitude for each in found], "m", "peak"),
            "peak_rpm": quantity("value", [rpm * each.speed for each in found], "rpm", "its speed"),
            "place": ("value", [each.place for each in found]),
            "largest_multiplier": ("value", growth),
            "stable": ("value", np.array(growth) < 1.0 + NEUTRAL),
            "linear_limit": quantity(("limit", "speed"), limits, "m", "amplitude"),
        },
        coords={
            "value": ("value", order),
            "speed": quantity("speed", np.array(omegas) / reference, "1", "normalised speed"),
            "rpm": quantity("speed", rpm * np.array(omegas), "rpm", "speed"),
            "limit": list(LIMITS),
        },
        attrs={
            "title": "design curve of joints",
            "case": case.title,
            "key": parameter.key,
            "unit": parameter.unit,
            "ended": f"reaches {parameter.text(parameter.stop)}",
            "by_ratio": int(_by_ratio(parameter)),
            "engine_order": next(each for each in wheels[0].orders if each),
        },
    )


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of a design curve."""
    rows = [
        {
            "parameter": float(one["value"]),
            "amplitude": float(one["peak_amplitude"]),
            "speed_rpm": float(one["peak_rpm"]),
            "place": one["place"].item(),
            "largest_multiplier": float(one["largest_multiplier"]),
            "stable": bool(one["stable"]),
            "not_found": int(np.isnan(one["amplitude"].values).sum()),
        }
        for one in (data.isel(value=n) for n in range(data.sizes["value"]))
    ]
    least = min(rows, key=lambda row: row["amplitude"])
    limits: dict[str, Any] = {}
    for name in data["limit"].values.tolist():
        curve = data["linear_limit"].sel(limit=name).values
        most = int(curve.argmax())
        limits[name] = {"amplitude": float(curve[most]), "speed_rpm": float(data["rpm"][most])}
    hints = [
        f"the smallest peak is at the end of the range, {data.attrs['key']} ="
        f" {least['parameter']:.6g} {data.attrs['unit']}".rstrip()
    ]
    ends = least in (rows[0], rows[-1])
    if beyond := sum(row["place"] != "peak" for row in rows):
        hints.append(f"{beyond} of {len(rows)} peaks are at the end of the speeds")
    return Study(
        name="periodic",
        document={
            "key": data.attrs["key"],
            "unit": data.attrs["unit"],
            "smallest_peak": least,
            "linear_limits": limits,
            "points": rows,
        },
        tables=[table(rows, COLUMNS, f"Largest amplitude over the speed, {data.attrs['key']}")],
        figures=lambda: {"design": (plot_design(data), data)},
        hints="; ".join(hints if ends else hints[1:]),
    )
