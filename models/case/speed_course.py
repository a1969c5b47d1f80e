"""Speed of rotation over time, with its acceleration and the angle of the rotor in closed form."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray

DEGREE = 3
"""Degree of the polynomials of the speed."""

SPEED = slice(2, 2 + DEGREE + 1)
"""Columns of the coefficients of the speed in `SpeedCourse.pieces`."""


@dataclass(frozen=True)
class SpeedCourse:
    """Speed of rotation as a piecewise polynomial of degree 3; the last piece does not end."""

    pieces: FloatArray
    """Start of each piece [s], angle at its start [rad], and coefficients of the speed [rad/s] in
    ascending powers of the time since its start, (pieces, 6)."""

    @classmethod
    def of_speeds(cls, starts: Sequence[float], speeds: Sequence[Polynomial]) -> "SpeedCourse":
        """Return the course of polynomials of the time since the start of each piece.

        Args:
            starts: start of each piece [s], ascending from 0, where the angle is zero.
            speeds: speed in each piece [rad/s].
        """
        angle, rows = 0.0, []
        for n, (start, speed) in enumerate(zip(starts, speeds, strict=True)):
            rows.append([start, angle, *np.pad(speed.coef, (0, DEGREE + 1 - len(speed.coef)))])
            if n + 1 < len(starts):
                angle += float(speed.integ()(starts[n + 1] - start))
        return cls(np.array(rows))

    @classmethod
    def smooth_step(cls, first: float, last: float, start: float, end: float) -> "SpeedCourse":
        """Return a course from one speed to another [rad/s] as 3 s^2 - 2 s^3 between two instants
        [s]."""
        length, change = end - start, last - first
        rise = Polynomial([first, 0.0, 3.0 * change / length**2, -2.0 * change / length**3])
        pieces = [(0.0, Polynomial([first]))] if start > 0.0 else []
        pieces += [(start, rise), (end, Polynomial([last]))]
        return cls.of_speeds(*zip(*pieces, strict=True))

    @classmethod
    def through(cls, times: ArrayLike, speeds: ArrayLike, blend: float) -> "SpeedCourse":
        """Return a course through the rows of a table, constant before and after them.

        The speed is linear between rows except near them: at a row the acceleration changes
        linearly within a time `blend`, which is centred on the row, ends there if the speed is
        constant after the row, and begins there if it is constant before the row. The speeds at the
        rows are those of the table, and between rows with one speed it is constant.

        Args:
            times: times of the rows in ascending order [s], (rows,).
            speeds: speed at each row [rad/s], (rows,).
            blend: time in which the acceleration changes [s]; at most half of the shortest time
                between rows.
        """
        times, speeds = np.asarray(times, dtype=float), np.asarray(speeds, dtype=float)
        change, length = np.diff(speeds), np.diff(times)
        intervals = len(length)
        held = np.concatenate([[True], change == 0.0, [True]])  # before and after each row
        begun = np.where(held[:-1], 0.0, np.where(held[1:], 1.0, 0.5))  # share before the row
        corners: FloatArray = np.zeros(0)
        if intervals:
            # Each change of the speed as a sum of the accelerations in the middle of the intervals.
            lost, gained = 0.5 * blend * (1.0 - begun) ** 2, 0.5 * blend * begun**2
            shares = np.diag(length - lost[:-1] - gained[1:])
            shares += np.diag(lost[1:-1], -1) + np.diag(gained[1:-1], 1)
            corners = np.asarray(np.linalg.solve(shares, change), dtype=np.float64)
        levels = np.concatenate([[0.0], corners, [0.0]])  # of the acceleration
        begins = times - begun * blend
        pieces, speed = list[tuple[float, Polynomial]](), float(speeds[0])
        if times[0] > 0.0 or not intervals:
            pieces.append((0.0, Polynomial([speed])))
        for row in range(len(times) if intervals else 0):
            if blend > 0.0:
                rate = 0.5 * (levels[row + 1] - levels[row]) / blend
                pieces.append((float(begins[row]), Polynomial([speed, levels[row], rate])))
                speed = float(pieces[-1][1](blend))
            after = float(begins[row] + blend)
            pieces.append((after, Polynomial([speed, levels[row + 1]])))
            if row < intervals:
                speed = float(pieces[-1][1](begins[row + 1] - after))
        if intervals:
            pieces[-1] = (pieces[-1][0], Polynomial([float(speeds[-1])]))
        return cls.of_speeds(*zip(*pieces, strict=True))

    def relative_to(self, base: float) -> "SpeedCourse":
        """Return the course of the difference between the speed and a constant one [rad/s]."""
        speeds = [Polynomial(row) - base for row in self.pieces[:, SPEED]]
        return SpeedCourse.of_speeds(self.pieces[:, 0].tolist(), speeds)

    def speed(self, time: ArrayLike) -> FloatArray:
        """Return the speed at times [rad/s], in the shape of the times."""
        return self._sum(time, np.ones(DEGREE + 1), 0)

    def acceleration(self, time: ArrayLike) -> FloatArray:
        """Return the acceleration at times [rad/s2], in the shape of the times."""
        return self._sum(time, np.arange(DEGREE + 1.0), -1)

    def angle(self, time: ArrayLike) -> FloatArray:
        """Return the angle of the rotor at times [rad], in the shape of the times."""
        turned = self._sum(time, 1.0 / np.arange(1.0, DEGREE + 2.0), 1)
        return np.asarray(self.pieces[self._piece(time), 1] + turned)

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest speed [rad/s]."""
        ends, found = np.append(self.pieces[1:, 0], self.pieces[-1, 0]), list[float]()
        for row, end in zip(self.pieces, ends, strict=True):
            speed = Polynomial(row[SPEED])
            turning = speed.deriv().roots() if np.any(row[SPEED][2:]) else np.zeros(0)
            inner = turning[np.isreal(turning)].real
            inner = inner[(inner > 0.0) & (inner < end - row[0])]
            found += speed(np.concatenate([[0.0, end - row[0]], inner])).tolist()
        return min(found), max(found)

    @property
    def largest_acceleration(self) -> float:
        """Largest magnitude of the acceleration [rad/s2]."""
        ends = np.append(self.pieces[1:, 0], self.pieces[-1, 0])
        middle = 0.5 * (ends + self.pieces[:, 0])
        before = np.nextafter(ends, self.pieces[:, 0])
        every = np.concatenate([self.pieces[:, 0], middle, before])
        return float(np.abs(self.acceleration(every)).max())

    def _piece(self, time: ArrayLike) -> np.ndarray:
        after = np.searchsorted(self.pieces[:, 0], time, side="right")
        return np.asarray(np.maximum(after - 1, 0))

    def _sum(self, time: ArrayLike, factors: FloatArray, powers: int) -> FloatArray:
        """Return the sum of coefficients times factors and powers of the time since the start of
        the piece."""
        piece = self.pieces[self._piece(time)]
        since = np.asarray(time, dtype=float) - piece[..., 0]
        power = np.arange(DEGREE + 1) + powers
        terms = since[..., None] ** np.maximum(power, 0) * factors
        return np.asarray((terms * piece[..., SPEED]).sum(axis=-1))
