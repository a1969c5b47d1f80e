"""Warnings about valid but implausible stages."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.rotation.eigenproblems import damped_eigenvalues
from bladewhirl.models.stage.stage import Stage

LOWEST_FREQUENCY = 1.0
"""Lowest plausible reference frequency [Hz]; lower frequencies are usually due to a wrong unit."""

TIP_SHARE = 0.9
"""A free end is reported as a possible tip from this fraction of the smallest tip radius on.
"""


def stage_hints(stage: Stage) -> tuple[str, ...]:
    """Return the warnings for a stage, one line each; the warnings for its case come first."""
    return (
        *case_hints(stage.case),
        *_too_soft(stage),
        *_fed_whirl(stage),
        *_free_ends(stage.disk.model),
    )


COALESCED = 1e-6
"""A growth rate up to this fraction of the speed of rotation counts as a rounding error."""


def _too_soft(stage: Stage) -> Iterator[str]:
    hertz = stage.reference_frequency / (2.0 * np.pi)
    if hertz < LOWEST_FREQUENCY:
        yield (
            f"the reference frequency, the unit of speeds, is {hertz:.3g} Hz: check that"
            " dimensions, material and springs are in SI units or are text with a unit"
        )


def _fed_whirl(stage: Stage) -> Iterator[str]:
    """Yield a warning with the remedy if whirl grows without contact."""
    rotor = stage.rotor
    if not rotor.frequency.min() < 0.0:
        return
    stiffness, forces = np.diag(rotor.stiffness), rotor.damping
    growth, undamped = (
        float(damped_eigenvalues(np.eye(len(forces)), by_velocity, by_position)[0].real.max())
        for by_velocity, by_position in (
            (forces, stiffness + rotor.circulation_stiffness),
            (0.5 * (forces - forces.T), stiffness),  # Coriolis forces only
        )
    )
    if undamped > COALESCED * abs(stage.speed):
        yield (
            "two waves of the bladed disk have coalesced below this speed: growth rate"
            f" {undamped:.3g} 1/s without damping or contact; bladewhirl campbell prints the speed"
        )
    elif growth > 0.0:
        yield (
            "internal damping destabilises the bladed disk above its critical speed: growth rate"
            f' {growth:.3g} 1/s; shaft.damping with damping_frame = "static" stabilises it,'
            " bladewhirl stability prints the damping needed"
        )


def _free_ends(model: BeamModel) -> Iterator[str]:
    """Yield a warning about free ends at the radius of the tips that are missing in their set."""
    points = model.mesh.points
    joined = np.bincount(model.joints.ravel(), minlength=len(points))
    ends = np.setdiff1d(np.flatnonzero(joined == 1), [*model.tips, model.centre, *model.links.led])
    radii = np.linalg.norm(points, axis=1)
    ends = ends[radii[ends] >= TIP_SHARE * radii[model.tips].min()]
    if len(ends):
        x, y = np.round(points[ends[0]], 9) + 0.0  # no rounding, no -0
        free = "1 free end" if len(ends) == 1 else f"{len(ends)} free ends"
        yield (
            f"{free} at the radius of the {len(model.tips)} tips but not in their set, the first at"
            f" ({x:.4g}, {y:.4g}) m: contact is not computed there"
        )
