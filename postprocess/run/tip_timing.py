"""Blade tip timing: arrival times of the tips at probes in the casing, as rigs measure them."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.by_blade import blade_angles, blade_means, blade_radii
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, tip_rows
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.result import reduce_modes
from bladewhirl.postprocess.fields.windows import in_window
from bladewhirl.postprocess.run.histories import radians

STEPS = 12  #: number of Newton steps; each arrival converges quadratically


def tip_timing(
    result: xr.Dataset,
    probes: ArrayLike | str | Sequence[str] = 0.0,
    *,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Return the times at which the blade tips arrive at probes in the casing.

    Blade n at the angle theta_n arrives at a probe at theta_p at the time t with
    theta_n + Omega t + v_n(t) / R_n = theta_p + 2 pi m, where v_n is the tangential displacement of
    the tip in the rotating frame, the mean of its contact nodes without their residual flexibility.
    Between records v_n is the cubic with the displacements and velocities of the records, so that
    the error decreases with the fourth power of the record step.

    Args:
        result: result of a run.
        probes: one angle or several angles (probes,), counter-clockwise from +x: numbers in rad, or
            text such as "90 deg".
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        over (probe, blade, revolution): `arrival` [s], and `deflection` [m], the tangential
        displacement v_n at the arrival, counter-clockwise. Revolutions are counted for each probe
        and blade from its first arrival in the window; nan stands for arrivals after the window.

    Raises:
        ViewError: the shaft does not turn, records are a quarter of a revolution or more apart, or
            a tip turns backward.
        UserError: a probe is not an angle.

    Example:
        ``tip_timing(result, "90 deg")["deflection"].sel(blade=3).plot()``
    """
    result = in_window(result, start, end)
    angles = np.array([radians(value) for value in np.ravel(np.asarray(probes))])
    time, speed = result["time"].values, float(result.attrs["speed"])
    if not angles.size:
        raise UserError('tip timing: probes []: expected at least one angle, such as "90 deg"')
    step = float(np.diff(time).max()) if len(time) > 1 else np.inf
    if too_slow(speed, step):
        raise ViewError(f"tip timing: expected {too_slow(speed, step)}")
    tips, radius = blade_angles(result), blade_radii(result)
    across = blade_means(result, tip_rows(result)[1].T).T
    moved = reduce_modes(result, "rotor_displacement", across)
    rate = reduce_modes(result, "rotor_velocity", across)
    turning = rotation.speeds(result)
    sense, angle = np.sign(speed), rotation.angles(result)
    if rotation.varies(result):
        sense = np.sign(angle[-1] - angle[0])
    turned = sense * (tips + angle[:, None] + moved / radius)
    if not np.all(np.diff(turned, axis=0) > 0.0):
        raise ViewError("tip timing: expected tips that turn forward between all records")
    arrivals = [
        [
            _arrivals(time, moved[:, n], rate[:, n], tips[n] - probe, (angle, turning), radius[n])
            for n in range(len(tips))
        ]
        for probe in angles
    ]
    most = max(len(times) for row in arrivals for times, _ in row)
    table = np.full((2, len(angles), len(tips), most), np.nan)
    for p, row in enumerate(arrivals):
        for n, each in enumerate(row):
            table[:, p, n, : len(each[0])] = each
    over = ("probe", "blade", "revolution")
    return labelled(
        result,
        "arrivals of the blade tips at probes",
        {"arrival": (over, table[0], "s"), "deflection": (over, table[1], "m")},
        {"probe": angles, "blade": np.arange(len(tips)), "revolution": np.arange(most)},
    )


def too_slow(speed: float, step: float) -> str:
    """Return an empty text if the record step [s] is short enough for tip timing at a speed
    [rad/s]; otherwise a text that states the required records and the record step."""
    if speed != 0.0 and abs(speed) * step < 0.5 * np.pi:
        return ""
    rpm = abs(speed) * 30.0 / np.pi
    return f"at least four records a revolution, got a record step of {step:.3g} s at {rpm:.4g} rpm"


def _arrivals(
    time: Array,
    moved: Array,
    rate: Array,
    angle: float,
    turned: tuple[Array, Array],
    radius: float,
) -> tuple[Array, Array]:
    """Return arrival times of a tip at a probe [s], and the tangential displacement of the tip at
    these times [m].

    Args:
        time: times of the records [s], (time,).
        moved: tangential displacement of the tip at the records [m], (time,).
        rate: rate of this displacement [m/s], (time,).
        angle: angle of the tip at rest from the probe [rad].
        turned: angle [rad] and speed [rad/s] of the rotor at the records, (time,) each.
        radius: radius of the tip [m].
    """
    sense = np.sign(turned[0][-1] - turned[0][0])
    turns = sense * (angle + turned[0] + moved / radius) / (2.0 * np.pi)
    passed = np.floor(turns)
    record: IntArray = np.flatnonzero(np.diff(passed) > 0.0)
    target = sense * 2.0 * np.pi * passed[record + 1]
    length = time[record + 1] - time[record]
    share = (passed[record + 1] - turns[record]) / (turns[record + 1] - turns[record])
    for _ in range(STEPS):
        v, slope = _cubic(share, length, moved, rate, record)
        along, speed = _cubic(share, length, *turned, record)
        excess = angle + along + v / radius - target
        share = np.clip(share - excess / (length * (speed + slope / radius)), 0.0, 1.0)
    return time[record] + share * length, _cubic(share, length, moved, rate, record)[0]


def _cubic(
    share: Array, length: Array, moved: Array, rate: Array, record: IntArray
) -> tuple[Array, Array]:
    """Return the displacement and its rate at a share of the interval after each record,
    (arrivals,), from the cubic with the displacements and rates of both records."""
    first, second = moved[record], moved[record + 1]
    before, after = length * rate[record], length * rate[record + 1]
    square = 3.0 * (second - first) - 2.0 * before - after
    cube = 2.0 * (first - second) + before + after
    value = first + share * (before + share * (square + share * cube))
    return value, (before + share * (2.0 * square + share * 3.0 * cube)) / length
