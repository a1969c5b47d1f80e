"""Gaps and normal forces of constant contact, 0 <= lambda, g = g_0 + A lambda >= 0, lambda g = 0.

If A + A^T is positive definite the problem has one solution. Otherwise, as above critical speeds
and with dampers in the static frame, it can have several, which differ in the tips in contact.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray

CHANGES, OF_ARC = 200, 12
"""Largest number of changes of the set of tips in contact, and of a set that was an arc of tips."""
SAME = 10.0  #: largest difference of the gaps of equal solutions, relative to the tolerance
ARCS = 32  #: largest number of tips at which arcs of tips begin, and of lengths of arcs
DEFINITE = 1e-12  #: least eigenvalue of a matrix that counts as definite, relative to the largest


@dataclass(frozen=True)
class Complementarity:
    """Constant contact of tips."""

    start: FloatArray  #: gap g_0 of each tip without contact forces [m], (tips,)
    matrix: FloatArray  #: change A of the gaps by normal forces [m/N], (tips, tips)
    tolerance: float  #: largest penetration that counts as contact [m]
    angle: FloatArray  #: angle of each tip [rad], (tips,)
    tried: dict[bytes, tuple[FloatArray, BoolArray] | None] = field(
        default_factory=dict, compare=False
    )
    """Results of `forces_of` by set of tips: searches from different sets meet the same ones."""

    def gap(self, normal: FloatArray) -> FloatArray:
        """Return the gaps for normal forces, (tips,)."""
        return np.asarray(self.start + self.matrix @ normal)

    def forces_of(self, chosen: BoolArray) -> tuple[FloatArray, BoolArray] | None:
        """Return the normal forces that close the gaps of a set of tips, (tips,), and which tips
        of the set pull and which others penetrate the wall, (tips,); None if the forces are not
        unique."""
        key = chosen.tobytes()
        if key not in self.tried:
            self.tried[key] = self._forces_of(chosen)
        return self.tried[key]

    def _forces_of(self, chosen: BoolArray) -> tuple[FloatArray, BoolArray] | None:
        normal = np.zeros(len(self.start))
        try:
            normal[chosen] = np.linalg.solve(
                self.matrix[np.ix_(chosen, chosen)], -self.start[chosen]
            )
        except np.linalg.LinAlgError:
            return None
        return normal, np.where(chosen, normal < 0.0, self.gap(normal) < -self.tolerance)

    def solved(self, chosen: BoolArray, changes: int = CHANGES) -> FloatArray | None:
        """Return the normal forces of a solution, from a set of tips in contact; None if the set
        still changes after a number of changes."""
        seen = set[bytes]()
        for _ in range(changes):
            if (one := self.forces_of(chosen)) is None:
                return None
            normal, wrong = one
            if not wrong.any():
                return normal
            if chosen.tobytes() in seen:  # change one tip only
                wrong = np.arange(len(wrong)) == np.flatnonzero(wrong)[-1]
            seen.add(chosen.tobytes())
            chosen = chosen ^ wrong
        return None

    @property
    def free(self) -> bool:
        """True if the motion without contact is a solution."""
        return bool((self.start >= -self.tolerance).all())

    def with_contact(self) -> Iterator[FloatArray]:
        """Yield the normal forces of different solutions with contact.

        The search begins with the tips that the motion without contact presses into the wall, then
        with each tip alone, at last with arcs of tips.
        """
        size = np.linalg.eigvalsh(self.matrix + self.matrix.T)
        only = bool(len(size)) and bool(size[0] > DEFINITE * size[-1])
        known = list[FloatArray]()
        for chosen, changes in self._sets():
            normal = self.solved(chosen, changes)
            if normal is None:
                continue
            gap = self.gap(normal)
            same = (np.abs(gap - other).max() <= SAME * self.tolerance for other in known)
            if normal.any() and not any(same):
                known.append(gap)
                yield normal
            if only:
                return

    def _sets(self) -> Iterator[tuple[BoolArray, int]]:
        """Yield sets of tips with which a search begins, and the number of their changes."""
        tips = len(self.start)
        yield self.start < 0.0, CHANGES
        for chosen in np.eye(tips, dtype=np.bool_)[self.start * np.diag(self.matrix) < 0.0]:
            yield chosen, CHANGES
        around, step = np.argsort(np.mod(self.angle, 2.0 * np.pi), kind="stable"), 1 + tips // ARCS
        for length in range(2, tips + 1, step):
            for first in range(0, tips, step):
                chosen = np.zeros(tips, dtype=np.bool_)
                chosen[around[(first + np.arange(length)) % tips]] = True
                yield chosen, OF_ARC
