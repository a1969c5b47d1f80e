"""Warnings about superelements that are valid but implausible."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.superelement_stage import SuperelementStage
from bladewhirl.models.superelements.reduction import rigid_limit, static_flexibility

ROUNDING = 1e-9
"""A flexibility up to this fraction of the radial one is a rounding error."""


def superelement_hints(stage: SuperelementStage) -> Iterator[str]:
    """Yield warnings for matrices of the file that are not used or that add to other damping, and
    for a contact node that locks itself against the wall with the given friction."""
    ratio = stage.case.damping.ratio
    for key in ("damping", "gyroscopic"):
        if getattr(stage.table.part, key) is None:
            continue
        if getattr(stage.reduced, key) is None:
            yield f"the matrix {key} of a sector is not used with massless contact nodes"
        elif key == "damping" and ratio > 0.0:
            yield (
                f"the matrix damping of the superelement adds to damping.ratio = {ratio:g};"
                " with damping.ratio = 0 only the matrix damps"
            )
    limits = locking_friction(stage)
    if not limits:
        return
    node = min(limits, key=limits.__getitem__)
    if stage.case.contact.friction > limits[node]:
        yield (
            f"contact node {node} locks itself against the wall with a friction above"
            f" {limits[node]:.3g}: static friction presses it outward more than the normal force"
            " pushes it inward, so that contact can grow without bound"
        )


def locking_friction(stage: SuperelementStage) -> dict[int, float]:
    """Return for each contact node the friction coefficient above which it locks itself.

    Friction on a single node drags it backward. If the node then moves outward by more than the
    normal force moves it inward, no static equilibrium in contact exists. Nodes that no friction
    locks are left out.
    """
    radial, tangential = static_response(stage)
    outward = -np.sign(stage.speed) * tangential
    return {
        int(n): float(radial[n] / outward[n]) for n in np.flatnonzero(outward > ROUNDING * radial)
    }


def static_response(stage: SuperelementStage) -> tuple[FloatArray, FloatArray]:
    """Return the radial displacement of each contact node per radial and per tangential force on
    it [m/N], (nodes,) each; empty for a wheel from a sector, whose matrices are not assembled, and
    for a structure with rigid modes."""
    part = stage.part
    squares = stage.reduced.frequency**2
    if stage.table.kind == "sector" or squares.min() <= rigid_limit(part):
        return np.zeros(0), np.zeros(0)
    flexibility = static_flexibility(part, part.contact_rows, np.zeros((part.size, 0)))
    return np.diag(flexibility)[::3], np.diag(flexibility, 1)[::3]
