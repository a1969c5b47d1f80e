"""A uniform ring under equal blades whose motions follow one another around the wall.

A wall and loads that are fixed in space force blade j of N equal blades, at the angle theta_j +
Omega t, to do the same as blade 0 does the time theta_j / Omega later: f_j(t) = f(t + theta_j /
Omega). The harmonic h Omega of the forces of all blades then moves the harmonics n of the ring with
n = h + k N, for all integers k, at the frequency (h - n) Omega, and the displacement of the ring
under blade 0 has the harmonic h again,

    w_h = N sum_n Y_n((h - n) Omega) f_h,   Y_n(w) = s_n s_n^H / (w_n^2 - w^2 + 2 i zeta w_n w),

with the radial and tangential displacements s_n exp(i n theta) of each mode. The velocity of the
ring is that of its material, at a fixed angle in space.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.stage.wall import ReducedCasing, around_wall

PER_ELEMENT = 8  #: angles per element at which shapes of the casing are expanded
FAINT = 1e-9  #: harmonics of a mode below this fraction of the largest, squared, are left out
MOST_HARMONICS = 8192  #: least number of harmonics of forces that are constant in steps


@dataclass(frozen=True)
class Ring:
    """Modes of a uniform ring by harmonics around the wall, n >= 0; those of -n are conjugate."""

    order: IntArray  #: number n of the harmonic, (modes,)
    frequency: FloatArray  #: natural frequency [rad/s], (modes,)
    damping_ratio: FloatArray  #: damping ratio, (modes,)
    shape: ComplexArray
    """Radial and tangential displacement s_n [kg^-1/2], (modes, 2)."""

    @classmethod
    def of_casing(cls, casing: ReducedCasing) -> "Ring":
        """Return the ring of a uniform casing. A pair of modes, of a cosine and a sine, is one mode
        of its harmonic; other harmonics of the shapes, due to the finite elements, are left out."""
        count = PER_ELEMENT * len(casing.nodal)
        around = 2.0 * np.pi / count * np.arange(float(count))
        radial, tangential = (
            np.fft.rfft(
                [
                    around_wall(casing.nodal[:, rows, mode], casing.element_length, around)
                    for mode in range(len(casing.frequency))
                ],
                axis=1,
            )
            / count
            for rows in (slice(0, 2), slice(2, 4))
        )
        both = np.stack([radial, tangential], axis=-1)  # (casing modes, harmonics, 2)
        order = np.argmax(np.linalg.norm(both, axis=-1), axis=1)
        own = both[np.arange(len(order)), order]
        products = own[:, :, None] * own[:, None, :].conj()
        found: dict[tuple[int, float, float], ComplexArray] = {}
        for n, frequency, ratio, product in zip(
            order.tolist(), casing.frequency, casing.damping_ratio, products, strict=True
        ):
            key = (n, float(f"{frequency:.9e}"), float(ratio))
            found[key] = found.get(key, 0.0) + product
        entries = []
        for (n, frequency, ratio), product in found.items():
            size, ways = np.linalg.eigh(product if n else product.real)
            entries += [
                (n, frequency, ratio, np.sqrt(size[k]) * ways[:, k])
                for k in range(2)
                if size[k] > FAINT * size[-1]
            ]
        orders, frequencies, ratios, shapes = zip(*entries, strict=True)
        return cls(np.array(orders), np.array(frequencies), np.array(ratios), np.array(shapes))

    def equals(self, other: "Ring | None") -> bool:
        """Return whether another ring has the same arrays."""
        return other is not None and all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("order", "frequency", "damping_ratio", "shape")
        )

    def transition(
        self, speed: float, unit: float, step: float
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return how the ring moves in a step in rotating axes, in which harmonics n turn by
        n Omega.

        Args:
            speed: speed of rotation [rad/s].
            unit: frequency that multiplies displacements in the state (unit q, q') [rad/s].
            step: length of the step [s].

        Returns:
            matrices of the states, (modes, 2, 2), and responses to constant modal forces,
            (modes, 2).
        """
        w, turning = self.frequency, 1j * self.order * speed
        wide = np.zeros((len(w), 3, 3), dtype=np.complex128)
        wide[:, 0, 0] = wide[:, 1, 1] = step * turning
        wide[:, 0, 1] = step * unit
        wide[:, 1, 0] = -step * w**2 / unit
        wide[:, 1, 1] -= step * 2.0 * self.damping_ratio * w
        wide[:, 1, 2] = step
        moved = la.expm(wide)[:, :2]
        return moved[:, :, :2], moved[:, :, 2]

    @property
    def both_ways(self) -> tuple[IntArray, ComplexArray, IntArray]:
        """Harmonics n and -n: their numbers, shapes (entries, 2), and the number of their mode."""
        pairs = np.flatnonzero(self.order > 0)
        return (
            np.concatenate([self.order, -self.order[pairs]]),
            np.concatenate([self.shape, self.shape[pairs].conj()]),
            np.concatenate([np.arange(len(self.order)), pairs]),
        )

    def between(self, speed: float, angle: FloatArray) -> FloatArray:
        """Return displacements for constant forces in rotating axes [m/N].

        Args:
            speed: speed of rotation [rad/s].
            angle: angles from the force to the displacement [rad], any shape.

        Returns:
            radial and tangential displacement for radial and tangential force, (..., 2, 2).
        """
        order, shape, mode = self.both_ways
        own, w = self.frequency[mode], -order * speed
        response = 1.0 / (own**2 - w**2 + 2j * self.damping_ratio[mode] * own * w)
        turned = np.exp(1j * angle[..., None] * order) * response
        return np.asarray(np.einsum("...k,ka,kb->...ab", turned, shape, shape.conj()).real)

    def answers(
        self, lobes: int, speed: float, copies: int, angle: FloatArray, instants: int
    ) -> ComplexArray:
        """Return the responses under blade 0 to forces of all blades by harmonic of its own forces.
        In each step the mean of the forces at both ends acts.

        Args:
            lobes: number of periods in a turn.
            speed: speed of rotation [rad/s].
            copies: number N of equal blades at equal angles.
            angle: angle of each contact node of the blade [rad], (nodes,).
            instants: number of instants in a period.

        Returns:
            displacements [m/N] and velocities [m/(N s)] at the instants for the harmonics 0 to
            instants / 2 of the forces at the instants, radial and tangential, (2, harmonics,
            2 * nodes, 2 * nodes); node by node.
        """
        order, shape, mode = self.both_ways
        half, folds = instants // 2 + 1, max(4, MOST_HARMONICS // instants)
        line = np.arange(half)
        total = np.zeros((2, half, len(order)), dtype=np.complex128)
        own, ratio = self.frequency[mode], self.damping_ratio[mode]
        for fold in range(-folds, folds + 1):
            harmonic = (line + fold * instants) * lobes * int(np.sign(speed))
            k, entry = np.nonzero((harmonic[:, None] - order) % copies == 0)
            w = (harmonic[k] - order[entry]) * speed
            share = np.pi * (line + fold * instants)[k] / instants
            at = np.cos(share) * np.sinc(share / np.pi) * copies
            at = at / (own[entry] ** 2 - w**2 + 2j * ratio[entry] * own[entry] * w)
            total[0, k, entry] += at
            total[1, k, entry] += 1j * w * at
        rows = np.exp(1j * order[:, None] * angle)[:, :, None] * shape[:, None]
        rows = rows.reshape(len(order), -1)
        outer = rows[:, :, None] * rows[:, None, :].conj()
        found = total @ outer.reshape(len(order), -1)
        return np.asarray(found.reshape(2, half, rows.shape[1], rows.shape[1]))
