"""Hints at a stage that was perhaps not meant: too soft, or blades that are not among its tips."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.rotation.eigenproblems import damped_eigenvalues
from bladewhirl.models.stage.stage import Stage

LOWEST_FREQUENCY = 1.0
"""Lowest frequency that a bladed disk has [Hz]; below, a unit was mistaken."""

AS_FAR_OUT = 0.9
"""Radius over that of the innermost tip from which on a free end could be a tip."""


def stage_hints(stage: Stage) -> tuple[str, ...]:
    """One line for each of them, those of the case first."""
    return (
        *case_hints(stage.case),
        *_too_soft(stage),
        *_fed_whirl(stage),
        *_free_ends(stage.disk.model),
    )


MET = 1e-6
"""Growth without damping above this share of the speed is no rounding."""


def _too_soft(stage: Stage) -> Iterator[str]:
    hertz = stage.reference_frequency / (2.0 * np.pi)
    if hertz < LOWEST_FREQUENCY:
        yield (
            f"the reference frequency is {hertz:.3g} Hz, and speeds count in it: see that sizes,"
            " material and springs are in SI, or text with a unit"
        )


def _fed_whirl(stage: Stage) -> Iterator[str]:
    """Whirl that grows by the bladed disk's own damping, and what holds it."""
    rotor = stage.rotor
    if not rotor.frequency.min() < 0.0:
        return
    stiffness = np.diag(rotor.stiffness) + rotor.circulation_stiffness
    forces = rotor.damping
    coriolis = 0.5 * (forces - forces.T)
    growth, undamped = (
        float(damped_eigenvalues(np.eye(len(forces)), by_velocity, held)[0].real.max())
        for by_velocity, held in ((forces, stiffness), (coriolis, np.diag(rotor.stiffness)))
    )
    if undamped > MET * abs(stage.speed):
        yield (
            "two waves of the bladed disk have met at this speed, and it is unstable by itself,"
            f" growing by {undamped:.3g} 1/s without damping or contact; bladewhirl campbell says"
            " from which speed on"
        )
    elif growth > 0.0:
        yield (
            f"past a critical speed damping that turns with the bladed disk lets it whirl by"
            f" itself, growing by {growth:.3g} 1/s;"
            ' shaft.damping with damping_frame = "static" holds it, bladewhirl stability says how'
            " much it takes"
        )


def _free_ends(model: BeamModel) -> Iterator[str]:
    """Ends of lines as far out as the tips that are none of them."""
    points = model.mesh.points
    joined = np.bincount(model.joints.ravel(), minlength=len(points))
    ends = np.setdiff1d(np.flatnonzero(joined == 1), [*model.tips, model.centre, *model.links.led])
    radii = np.linalg.norm(points, axis=1)
    ends = ends[radii[ends] >= AS_FAR_OUT * radii[model.tips].min()]
    if len(ends):
        x, y = np.round(points[ends[0]], 9) + 0.0  # no rounding, no -0
        free = "1 free end" if len(ends) == 1 else f"{len(ends)} free ends"
        yield (
            f"{free} as far out as the {len(model.tips)} tips not in their set, first at"
            f" ({x:.4g}, {y:.4g}) m: the casing is never touched there"
        )
