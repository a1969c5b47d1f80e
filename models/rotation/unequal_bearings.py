"""Waves with one nodal diameter of a bladed disk whose stationary shaft springs are unequal.

The springs k_x, k_y along the static axes have the energy s/2 (X^2 - Y^2) besides that of their
mean, where s = (k_x - k_y) / 2 and (X, Y) is the displacement of the centre. Let b be the complex
amplitudes of the wave exp(i theta) in the static frame and Z b the displacement of the centre along
x that belongs to them. The waves b = p exp(i W t) + conj(q) exp(-i W t) then solve

    (-W^2 M + i W Omega (G + 2 i M) + K + Omega^2 (K1 - M + i G)) p + 2 s Z^H conj(Z) q = 0

and the complex conjugate equation with p and q interchanged, with the matrices of `rotating`. The
coefficients are constant, and every motion is an ellipse of the backward wave p and the forward
wave q.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.structure.eigenproblems import gyroscopic_eigen
from bladewhirl.models.structure.waves import Waves

ROUND = 6  #: decimals of the share of the backward wave in a motion; closer shares count as equal


@dataclass(frozen=True, kw_only=True)
class EllipticWaves(Waves):
    """Waves of nodal diameter 1 on unequal bearings, one for each elliptic motion.

    The wave that prevails in a motion represents it, so frequencies, ranks and shares have the
    order of `Waves`. In a plane motion none prevails; of each two motions in ascending order the
    lower then counts as backward.
    """

    static: Waves
    """Waves (p, q) in the static frame, with matrices (2 n, 2 n)."""

    def on_springs(self, ratio: float) -> "EllipticWaves":
        """Return the waves with both springs of `ratio` times their stiffness."""
        return replace(self, static=self.static.on_springs(ratio))

    def frequencies(self, omega: float) -> ComplexArray:
        """Return the frequency w of the prevailing wave of each motion, see `Waves.frequencies`."""
        return self._motions(omega)[0]

    def spring_shares(self, omega: float) -> FloatArray:
        """Return the springs' share of the strain energy of each motion, see `Waves`."""
        return self.static.shares(self._motions(omega)[1])

    def synchronous(self, order: int) -> tuple[FloatArray, FloatArray]:
        """Return the speeds at which a motion contains a wave with w = m Omega, see `Waves`."""
        return self.static.synchronous(order - 1)

    def meeting(self, casing_frequency: float, highest: float) -> FloatArray:
        """Return the speeds at which a motion has the frequency of the casing, see `Waves`."""
        return self.static.meeting(casing_frequency, highest)

    def _distances(self, omega: float, frequency: float) -> FloatArray:
        """Return the distances by the static frequency, which both waves of a motion share."""
        static = np.abs(self.frequencies(omega) - omega)
        return np.abs(static - abs(frequency - omega))

    def _motions(self, omega: float) -> tuple[ComplexArray, ComplexArray]:
        """Return w (2 n,) and the fields (p, q), (2 n, 2 n), of all motions at a speed omega."""
        coriolis = omega * self.static.known("gyroscopic")
        stiffness = self.static.stiffness_at(omega)
        rates, fields = gyroscopic_eigen(self.static.mass, stiffness, coriolis)
        size = len(self.mass)
        # (W, p, q) and (-W, conj q, conj p) are the same motion. The sign of the action
        # v^H (2 W M - i G) v does not change along a branch; it is the sign of W at rest.
        action = 2.0 * rates.real - np.einsum("im,ij,jm->m", fields.conj(), 1j * coriolis, fields)
        kept = np.lexsort((-rates.imag, -np.sign(np.round(action.real / np.abs(action).max(), 9))))
        kept = kept[: 2 * size][np.argsort(rates[kept[: 2 * size]].real, kind="stable")]
        rates, fields = rates[kept], fields[:, kept]
        p, mass = fields[:size], self.static.mass[:size, :size]
        share = np.round(np.einsum("im,ij,jm->m", p.conj(), mass, p).real, ROUND)
        ranking = np.lexsort((np.arange(2 * size) % 2, -share))
        backward, forward = np.sort(ranking[:size])[::-1], np.sort(ranking[size:])
        w = np.concatenate([rates[backward], -rates[forward].conj()]) + omega
        return np.asarray(w, dtype=np.complex128), fields[:, np.append(backward, forward)]


def on_bearings(waves: Waves, centre: ComplexArray, difference: float) -> Waves:
    """Return the waves of nodal diameter 1 on bearings whose stiffnesses may differ.

    Args:
        waves: waves with the mean stiffness of the bearings.
        centre: displacement of the centre along x and y in these waves, (2, n); (0, n) for a
            centre that does not move.
        difference: s, see `on_unequal_bearings`.
    """
    if not difference or not len(centre):
        return waves
    return on_unequal_bearings(waves, centre[0].conj(), difference)


def on_unequal_bearings(waves: Waves, centre: ComplexArray, difference: float) -> EllipticWaves:
    """Return the waves of nodal diameter 1 of a bladed disk on unequal bearings.

    Args:
        waves: waves with the mean stiffness of the bearings and with Coriolis forces.
        centre: components of a unit force on the centre along x, Z^H, (n,).
        difference: s, half the difference of the stiffnesses along static x and y [N/m].
    """
    mixed = 2.0 * difference * np.outer(centre, centre)
    zero = np.zeros_like(mixed)
    coupling = np.block([[zero, mixed], [mixed.conj().T, zero]])
    turning, fourth = waves.known("gyroscopic"), waves.stiffness_speed4

    def both(matrix: ComplexArray) -> ComplexArray:
        return np.asarray(la.block_diag(matrix, matrix.conj()))

    static = Waves(
        nodal_diameter=1,
        frame=1,
        mass=both(waves.mass),
        stiffness=both(waves.stiffness) + coupling,
        gyroscopic=both(turning + 2j * waves.mass),
        stiffness_speed=both(waves.known("stiffness_speed") - waves.mass + 1j * turning),
        stiffness_speed4=None if fourth is None else both(fourth),
        springs=both(waves.springs) + coupling,
    )
    own = {each.name: getattr(waves, each.name) for each in fields(Waves)}
    return EllipticWaves(**own, static=static)
