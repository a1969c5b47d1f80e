"""Floquet analysis of x'' + D x' + K(t) x = 0 with K(t) of period T, by direct integration.

`floquet` does not use the frame in which the equations are autonomous and is thus an independent
check of that frame. The state is integrated over one period by the sixth-order Magnus integrator on
Gauss-Legendre nodes. The number of steps is doubled until the monodromy matrix no longer changes.

Reference: S. Blanes, F. Casas, J. A. Oteo, J. Ros, The Magnus expansion and some of its
applications, Physics Reports 470 (2009) 151-238, Section 5.4.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.equations import CoupledEquations, companion
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.solvers.stability.growth import eigenvalues

FEWEST_STEPS = 8
MOST_STEPS = 1 << 17

NODES = 0.5 + np.sqrt(15.0) / 10.0 * np.array([-1.0, 0.0, 1.0])
"""Gauss-Legendre nodes of one step, as shares of the step."""


@dataclass(frozen=True, kw_only=True)
class Floquet:
    """Change of the state of a linear system over one period."""

    period: float  #: period T [s]
    monodromy: FloatArray  #: matrix from (x, x') to (x, x') a period later, (..., 2 n, 2 n)
    steps: int  #: number of integration steps in the period
    change: float  #: relative change of the scaled monodromy matrix at the last doubling

    @property
    def multipliers(self) -> ComplexArray:
        """Eigenvalues of the monodromy matrix, (..., 2 n)."""
        return np.asarray(np.linalg.eigvals(self.monodromy), dtype=np.complex128)

    @property
    def exponents(self) -> ComplexArray:
        """Logarithms of the multipliers, divided by T [1/s], (..., 2 n)."""
        return np.asarray(np.log(self.multipliers) / self.period)

    @property
    def growth(self) -> FloatArray:
        """Largest real part of the exponents [1/s], (...)."""
        return np.asarray(np.max(self.exponents.real, axis=-1))


def floquet(
    stiffness: Callable[[FloatArray], FloatArray],
    *,
    period: float,
    damping: FloatArray | None = None,
    tolerance: float = 1e-11,
) -> Floquet:
    """Integrate a periodic system over one period.

    Args:
        stiffness: function of times [s], (m,), that returns K [1/s^2], (m, ..., n, n); additional
            axes belong to several systems with the same period.
        period: T [s].
        damping: D [1/s], broadcast to (..., n, n); None for an undamped system.
        tolerance: permitted relative change of the monodromy matrix when the steps are doubled.

    Raises:
        ArithmeticError: the tolerance is not met with `MOST_STEPS` steps, or the period is too
            long.
    """
    first = stiffness(np.zeros(1))[0]
    drag = np.broadcast_to(0.0 if damping is None else damping, first.shape)
    unit = np.sqrt(np.abs(first).max()) or 1.0  # unit x is as large as x'
    steps = max(FEWEST_STEPS, int(np.ceil(0.25 * period * unit)))
    if 2 * steps > MOST_STEPS:
        longest = MOST_STEPS / (0.5 * unit)
        raise ArithmeticError(
            f"monodromy matrix: expected a period of at most {longest:.4g} s, got {period:.4g} s"
        )
    coarse = _propagate(stiffness, drag, period, steps, unit)
    while 2 * steps <= MOST_STEPS:
        steps *= 2
        fine = _propagate(stiffness, drag, period, steps, unit)
        change = float(np.abs(fine - coarse).max() / np.abs(fine).max())
        if change <= tolerance:
            size = first.shape[-1]
            scale = np.where(np.arange(2 * size) < size, unit, 1.0)
            monodromy = fine * scale / scale[:, None]
            return Floquet(period=period, monodromy=monodromy, steps=steps, change=change)
        coarse = fine
    raise ArithmeticError(
        f"monodromy matrix: expected a change below {tolerance:g} with at most {MOST_STEPS} steps,"
        f" got {change:g}"
    )


def coupled_floquet(
    modes: CouplingModes | CoupledEquations, *, speed: float, kappa: float
) -> tuple[Floquet, ...]:
    """Integrate the coupled rotor and casing over one revolution, each nodal diameter separately.

    Args:
        modes: the coupled modes.
        speed: Omega, not zero [rad/s].
        kappa: spring stiffness [N/m].

    Returns:
        The change of state over one turn, one entry for each nodal diameter, ascending.
    """

    def over_one_turn(block: CoupledEquations) -> Floquet:
        return floquet(
            lambda times: block.stiffness(speed * times, kappa, speed=speed),
            period=2.0 * np.pi / abs(speed),
            damping=block.drag(speed),
        )

    return tuple(over_one_turn(block) for block in modes.blocks)


def exponents(
    modes: CouplingModes | CoupledEquations, *, speed: float, kappa: float
) -> ComplexArray:
    """Return the spectrum of coupled modes, the fastest growing first, (2 * modes,) [1/s].

    The spectrum consists of eigenvalues if the speed is zero or a frame makes the equations
    autonomous, otherwise of the Floquet exponents over one turn.

    Args:
        modes: the coupled modes.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m].
    """
    if speed == 0.0 or all(block.turning is not None for block in modes.blocks):
        values = eigenvalues(modes, speed=speed, kappa=kappa)
    else:
        turns = coupled_floquet(modes, speed=speed, kappa=kappa)
        values = np.concatenate([turn.exponents for turn in turns])
    return np.asarray(np.sort_complex(values)[::-1], dtype=np.complex128)


def _propagate(
    stiffness: Callable[[FloatArray], FloatArray],
    damping: FloatArray,
    period: float,
    steps: int,
    unit: float,
) -> FloatArray:
    """Return the monodromy matrix of (unit x, x') as the product of the exponentials of all
    steps."""
    step = period / steps
    times = step * np.add.outer(np.arange(steps), NODES)
    early, middle, late = (
        companion(-stiffness(times[:, node]), -damping, unit) for node in range(len(NODES))
    )
    linear = step * middle
    slope = np.sqrt(15.0) / 3.0 * step * (late - early)
    bend = 10.0 / 3.0 * step * (late - 2.0 * middle + early)
    inner = _commutator(linear, slope)
    outer = -_commutator(linear, 2.0 * bend + inner) / 60.0
    correction = _commutator(-20.0 * linear - bend + inner, slope + outer) / 240.0
    factors = la.expm(linear + bend / 12.0 + correction)
    while len(factors) > 1:  # pairwise, so that products are batched
        odd = factors[-1:] if len(factors) % 2 else factors[:0]
        factors = np.concatenate([factors[1::2] @ factors[: len(factors) - 1 : 2], odd])
    return np.asarray(factors[0])


def _commutator(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a @ b - b @ a)
