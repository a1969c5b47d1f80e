"""Warnings about valid but implausible stages."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.meshes.ring_mesh import W
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.stage.contact_problem import critical_time_step
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.structure.eigenproblems import damped_eigenvalues

LOWEST_FREQUENCY = 1.0
"""Lowest plausible reference frequency [Hz]; lower frequencies are usually due to a wrong unit."""


def stage_hints(stage: Stage) -> tuple[str, ...]:
    """Return the warnings for a stage, one line each; the warnings for its case come first."""
    return (
        *case_hints(stage.case),
        *_too_soft(stage),
        *_fed_whirl(stage),
        *(_stiff_loss(stage.case, stage.inertia) if stage.case.march.drive else ()),
        *_lossy_ring(stage),
        *stage.own_hints(),
    )


STIFF_LOSS = 0.05
"""Largest change of the speed by losses in a time step, as a fraction of the speed."""

COALESCED = 1e-6
"""A growth rate up to this fraction of the speed of rotation counts as a rounding error."""


def _too_soft(stage: Stage) -> Iterator[str]:
    hertz = stage.reference_frequency / (2.0 * np.pi)
    if hertz < LOWEST_FREQUENCY:
        yield (
            f"the reference frequency, the unit of speeds, is {hertz:.3g} Hz: check that"
            " dimensions, material and springs are in SI units or are text with a unit"
        )


def _stiff_loss(case: Case, inertia: float) -> Iterator[str]:
    """Yield a warning if losses change the speed much within a time step; `inertia` is that of all
    that turns [kg m2]."""
    drive = case.march.drive
    if drive is not None and drive.loss * case.march.time_step > STIFF_LOSS * inertia:
        yield (
            f"march.drive.loss = {drive.loss!r} N m s: the losses slow the rotor down within"
            f" {inertia / drive.loss:.2g} s, which march.time_step = {case.march.time_step!r} s"
            " does not resolve"
        )


def _fed_whirl(stage: Stage) -> Iterator[str]:
    """Yield a warning with the remedy if whirl grows without contact."""
    rotor = stage.rotor
    if stage.bearings is not None or rotor.copies > 1 or not rotor.frequency.min() < 0.0:
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


LONG_STEP = 0.3
"""Time step, divided by the critical one, above which the numerical loss of energy of a flexible
casing in contact is usually that of a damping ratio above 1 %."""


def _lossy_ring(stage: Stage) -> Iterator[str]:
    """Yield a warning if the time step is so long that a flexible casing in contact loses much
    energy: the loss is that of the damping ratio omega dt / 2, omega^2 = 1 / (C m), with the radial
    flexibility C of a node and the mass m of the casing under it."""
    compliance, wall = stage.rotor.compliance, stage.reduced_casing
    if compliance is None or not wall.is_flexible:
        return
    softness = np.diagonal(compliance, axis1=1, axis2=2)[:, ::3]
    step = stage.case.march.time_step
    share = step / critical_time_step(*stage.bodies, stage.kept.springs)
    if softness.all() and share > LONG_STEP:
        per_mass = np.sum(wall.nodal[:, W] ** 2, axis=1).max()
        loss = 50.0 * step * np.sqrt(per_mass / softness.min())
        yield (
            f"march.time_step is {share:.2g} of the critical step: in contact, the flexible casing"
            f" loses energy as with a damping ratio of up to {loss:.2g} %, a numerical error of"
            " first order in the step"
        )
