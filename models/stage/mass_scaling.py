"""Mass scaling of the casing: a longer critical time step, with the same static compliance.

Every casing mode with a natural frequency above a cut-off frequency gets the cut-off frequency. Its
shape and its loads are divided by the same factor, frequency / cut-off frequency. The modal mass of
these modes grows by the square of the factor; their static response to any force is the same.
"""

import math
from dataclasses import replace

import numpy as np

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import W_SLOPE, W
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.wall import ReducedCasing

MASS_CHANGE = 0.03
"""Largest decrease, relative and on average around the casing, of the inverse mass on which a force
between a tip and the wall acts; it determines the default cut-off frequency."""

STEP_SHARE = 0.5
"""The time step of a screening march is at most this fraction of the critical step: with longer
steps, divergent motions can die out."""

PLACES = 16
"""Number of positions in each element at which the inverse mass of the wall is computed."""


def screening_problem(problem: ContactProblem, timing: Timing) -> tuple[ContactProblem, Timing]:
    """Return a contact problem with scaled masses of the casing, and the timing of its march.

    The time step is the largest one that divides the record step and is at most `STEP_SHARE` of the
    critical time step.

    Raises:
        ValueError: screening is not valid for this problem, or does not save time; the message
            completes "expected ...".
    """
    if problem.coating is not None:
        raise ValueError("a casing without a coating")
    if not problem.casing.is_flexible:
        raise ValueError('casing.type = "ring", whose modes can be scaled')
    if problem.rotor.compliance is not None:
        raise ValueError(
            'reduction.boundary = "consistent": contact of massless nodes with a flexible casing'
            " loses energy in proportion to the time step, so that longer steps change the motion"
        )
    cut = screening_cut(problem)
    above = problem.casing.frequency > cut
    springs = problem.springs
    if springs is not None and above[springs.casing.any(axis=(0, 1))].any():
        raise ValueError(
            "coupling springs (coupling.stiffness) that act on no casing mode above"
            f" {cut / (2.0 * np.pi):.4g} Hz"
        )
    scaled = with_scaled_casing(problem, cut)
    longest = STEP_SHARE * min(each.critical_time_step for each in scaled.phases)
    step = timing.record_step / math.ceil(timing.record_step / longest)
    if not step > timing.time_step:
        raise ValueError(
            f"march.time_step below {step:.4g} s, the time step of a screening march; otherwise"
            " screening saves no time"
        )
    element = 2.0 * np.pi / problem.casing.elements
    if not abs(problem.speed) * step < element:
        raise ValueError(
            f"a speed below {element / step:.4g} rad/s, at which a tip passes an element of the"
            " casing in each step of a screening march"
        )
    return scaled, replace(timing, time_step=step)


def screening_cut(problem: ContactProblem) -> float:
    """Return the default cut-off frequency [rad/s]: the lowest frequency at which the inverse mass
    changes by at most `MASS_CHANGE`, and not less than the highest frequency of the rotor."""
    rotor, casing = problem.rotor, problem.casing
    of_tip = float((rotor.tip_radial**2).sum(axis=1).mean())
    share, frequency = np.zeros(len(casing.frequency)), casing.frequency
    for row in _wall_rows(casing):
        total = of_tip + (row**2).sum(axis=1, keepdims=True)
        share += (row**2 / total).mean(axis=0) / PLACES
    low, high = float(rotor.frequency.max()), float(frequency.max())
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        lost = share @ (1.0 - np.minimum(1.0, middle / np.maximum(frequency, middle)) ** 2)
        low, high = (middle, high) if lost > MASS_CHANGE else (low, middle)
    return high


def with_scaled_casing(problem: ContactProblem, cut: float) -> ContactProblem:
    """Return a contact problem whose casing modes above a cut-off frequency [rad/s] have scaled
    masses, also after sudden changes."""
    casing, loss, fuse = problem.casing, problem.loss, problem.fuse
    factor = np.maximum(1.0, casing.frequency / cut)
    if loss is not None:
        loss = replace(loss, after=with_scaled_casing(loss.after, cut))
    if fuse is not None:
        fuse = replace(fuse, after=with_scaled_casing(fuse.after, cut))
    return replace(
        problem,
        loss=loss,
        fuse=fuse,
        casing=replace(
            casing,
            frequency=np.minimum(casing.frequency, cut),
            nodal=casing.nodal / factor,
            dampers=casing.dampers / factor,
        ),
        loads=tuple(replace(load, casing=load.casing / factor) for load in problem.loads),
        start=replace(
            problem.start,
            casing=problem.start.casing * factor,
            casing_velocity=problem.start.casing_velocity * factor,
        ),
    )


def _wall_rows(casing: ReducedCasing) -> list[FloatArray]:
    """Return, for each of `PLACES` positions in an element, the radial displacement of the wall for
    unit modal coordinates, (elements, modes)."""
    nodal, following = casing.nodal, casing.nodal[casing.closed[:, 1:].ravel()]
    ends = (nodal[:, W], nodal[:, W_SLOPE], following[:, W], following[:, W_SLOPE])
    at = (np.arange(PLACES) + 0.5) / PLACES
    return [
        np.asarray(sum(weight * end for weight, end in zip(weights, ends, strict=True)))
        for weights in cubic_weights(at, casing.element_length).T
    ]
