"""Peaks of the response to engine-order forces, found between the speeds of a grid.

A resonance is narrower than most grids. The dynamic stiffness without damping has an eigenvalue
that passes through zero there, which tells of every resonance between two speeds and of its
half-power width; from there the speed of the largest amplitude is found.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.forced import Resonances

FOUND = 12  #: largest number of resonances of an engine order that are refined

WEAK = 0.05
"""Resonances with an estimated amplitude below this fraction of the largest are not refined."""

ACCURACY = 1e-3
"""Accuracy of the speed of a peak, as a fraction of the half-power width; the square of it is the
error of the amplitude."""

CORRECTIONS = 6
"""Corrections of the speed of a resonance by the stiffness at this speed."""

STEPS = 60  #: largest number of steps towards a peak


def peak_speeds(
    amplitude: Callable[[float], float], omegas: Sequence[float], near: Sequence[Resonances]
) -> list[float]:
    """Return the speeds of the largest peaks between the first and the last of some speeds
    [rad/s], ascending.

    Args:
        amplitude: function that returns the amplitude at a speed.
        omegas: speeds [rad/s], ascending.
        near: resonances near each of these speeds.
    """
    crossings = sorted(_crossings(omegas, near), reverse=True)
    chosen: list[tuple[float, float]] = []
    for estimate, speed, width in crossings:
        if len(chosen) == FOUND or estimate < WEAK * crossings[0][0]:
            break
        if all(abs(speed - other) > 0.5 * max(width, wide) for other, wide in chosen):
            chosen.append((speed, width))
    ends = omegas[0], omegas[-1]
    peaks = (_peak(amplitude, speed, width, ends) for speed, width in chosen)
    found: list[float] = []
    for peak in sorted(each for each in peaks if each is not None):
        if not found or peak - found[-1] > 1e-9 * peak:
            found.append(peak)
    return found


def resonance_beyond(
    amplitude: Callable[[float], float],
    resonances: Callable[[float], Resonances],
    order: int,
    end: float,
    outward: float,
) -> float:
    """Return the speed of the nearest peak of a strong resonance beyond an end of a range [rad/s];
    NaN without one.

    Args:
        amplitude: function that returns the amplitude at a speed.
        resonances: function that returns the resonances near a speed.
        order: engine order.
        end: the end [rad/s].
        outward: 1 for resonances at higher speeds, -1 for those at lower ones.
    """
    near, square = resonances(end), float(order) ** 2
    away = outward * near.value / square  # of the squares, if the stiffness did not change
    with np.errstate(over="ignore"):  # infinite without damping
        reached = near.drive / np.maximum(near.loss, np.finfo(float).tiny)
    strong = (away > -near.loss / square) & (end**2 + outward * away > 0.0)
    strong &= reached > WEAK * reached.max(initial=0.0)
    order_of = np.argsort(np.where(strong, np.abs(away), np.inf), axis=None)
    for place in zip(*np.unravel_index(order_of[: strong.sum()], away.shape), strict=True):
        speed = end
        try:
            for _ in range(1 + CORRECTIONS):
                further = speed**2 + resonances(speed).value[place] / square
                speed = float(np.sqrt(max(further, 0.0)))
            if not speed > 0.0:
                continue
            width = float(near.loss[place]) / (square * speed)
            speed = _peak(amplitude, speed, width, (0.0, np.inf)) or speed
        except CaseError:  # the stage does not exist at this speed
            continue
        if outward * (speed - end) > 0.0:
            return speed
    return float("nan")


def _crossings(
    omegas: Sequence[float], near: Sequence[Resonances]
) -> Iterator[tuple[float, float, float]]:
    """Yield estimated amplitude, speed and half-power width of each resonance [rad/s]."""
    for n in range(len(omegas) - 1):
        first, second, step = near[n], near[n + 1], omegas[n + 1] - omegas[n]
        passed = (first.value > 0.0) != (second.value > 0.0)
        for place in zip(*np.nonzero(passed), strict=True):
            before, change = first.value[place], second.value[place] - first.value[place]
            loss = max(0.5 * (first.loss[place] + second.loss[place]), np.finfo(float).tiny)
            drive = max(first.drive[place], second.drive[place])
            width = min(2.0 * loss * step / abs(change), step)
            yield float(drive / loss), float(omegas[n] - before * step / change), float(width)


def _peak(
    amplitude: Callable[[float], float], speed: float, width: float, ends: tuple[float, float]
) -> float | None:
    """Return the speed of the peak next to a speed [rad/s]; None if there is none inside."""
    height, step = amplitude(speed), 0.25 * width
    for _ in range(STEPS):
        low, high = speed - step, speed + step
        if low <= ends[0] or high >= ends[1]:
            return None
        below, above = amplitude(low), amplitude(high)
        if max(below, above) <= height:
            found = minimize_scalar(
                lambda omega: -amplitude(float(omega)),
                bounds=(low, high),
                method="bounded",
                options={"xatol": ACCURACY * width},
            )
            return float(found.x)
        speed, height = (low, below) if below > above else (high, above)
        step *= 1.5
    return None
