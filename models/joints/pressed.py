"""Static normal forces of joints that are closed by them."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray

STEPS = 100  #: largest number of changes of the closed nodes


class NoStaticForces(ArithmeticError):
    """The static forces of joints do not converge."""


def pressed(flexible: FloatArray, gap: FloatArray) -> FloatArray:
    """Return the normal forces that close gaps: 0 <= l, flexible l + gap >= 0, of which one is zero
    for each node [N], (nodes,), by a semismooth Newton method.

    Args:
        flexible: static displacements by normal forces [m/N], (nodes, nodes), positive definite.
        gap: gaps without forces [m], (nodes,).

    Raises:
        NoStaticForces: no set of closed nodes was found that its forces keep closed.
    """
    closed = gap < 0.0
    for _ in range(STEPS):
        force = np.zeros(len(gap))
        force[closed] = np.linalg.solve(flexible[np.ix_(closed, closed)], -gap[closed])
        after = force - (flexible @ force + gap) / np.diag(flexible) > 0.0
        if (after == closed).all():
            return force
        closed = after
    raise NoStaticForces("the static forces of the joints do not converge")
