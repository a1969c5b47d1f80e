"""Warnings about valid but implausible stages."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import W
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.plausibility import case_hints
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.stage.cone import compliance_in_wall_axes, in_wall_axes
from bladewhirl.models.stage.speed_change import turning_inertia
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.superelement_stage import SuperelementStage
from bladewhirl.models.structure.eigenproblems import damped_eigenvalues
from bladewhirl.models.superelements.reduction import rigid_limit

LOWEST_FREQUENCY = 1.0
"""Lowest plausible reference frequency [Hz]; lower frequencies are usually due to a wrong unit."""

TIP_SHARE = 0.9
"""A free end is reported as a possible tip if its radius is at least this fraction of the smallest
tip radius."""


def stage_hints(stage: Stage) -> tuple[str, ...]:
    """Return the warnings for a stage, one line each; the warnings for its case come first."""
    return (
        *case_hints(stage.case),
        *_too_soft(stage),
        *_fed_whirl(stage),
        *(_stiff_loss(stage.case, turning_inertia(stage)) if stage.case.march.drive else ()),
        *_free_ends(stage.disk.model),
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
    """Yield a warning about free ends at the radius of the tips that are not in the set `tips`."""
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


LONG_STEP = 0.3
"""Time step, divided by the critical one, above which the numerical loss of energy of a flexible
casing in contact is usually that of a damping ratio above 1 %."""

ROUNDING = 1e-9  #: a flexibility up to this fraction of the radial one is a rounding error


def superelement_hints(stage: SuperelementStage) -> Iterator[str]:
    """Yield warnings about contact nodes and matrices of the file that are not used, about a
    damping matrix that adds to the modal damping, about a long time step, and about a contact node
    that the given friction locks against the wall."""
    if left_out := stage.table.left_out:
        yield f"{left_out} contact nodes of the file are left out: they are at the place of others"
    yield from case_hints(stage.case)
    if len(stage.shown) < (points := stage.table.part.point_count):
        yield (
            f"pictures show {len(stage.shown)} of the {points} points of the sector: the shapes of"
            " all points take too much memory; fewer reduction.free_interface_modes allow more"
        )
    ratio = stage.case.damping.ratio
    if stage.reduced.damping is not None and ratio > 0.0:
        yield (
            f"the matrix damping of the superelement adds to damping.ratio = {ratio:g};"
            " with damping.ratio = 0 only the matrix damps"
        )
    yield from _lossy_ring(stage)
    if stage.case.march.drive is not None:
        yield from _stiff_loss(stage.case, stage.case.march.drive.inertia)
    limits = locking_friction(stage)
    if not limits:
        return
    node = min(limits, key=limits.__getitem__)
    if stage.case.wall_friction > limits[node]:
        yield (
            f"contact node {node} locks itself against the wall with a friction above"
            f" {limits[node]:.3g}: static friction presses it outward more than the normal force"
            " pushes it inward, so that contact can grow without bound"
        )


def _lossy_ring(stage: SuperelementStage) -> Iterator[str]:
    """Yield a warning if the time step is so long that a flexible casing in contact loses much
    energy: the loss is that of the damping ratio omega dt / 2, omega^2 = 1 / (C m), with the radial
    flexibility C of a node and the mass m of the casing under it."""
    softness = np.diag(stage.reduced.compliance)[::3]
    if stage.ring is None or not softness.all():
        return
    step = stage.case.march.time_step
    share = step / stage.problem.critical_time_step
    if share > LONG_STEP:
        per_mass = np.sum(stage.ring.reduced_casing.nodal[:, W] ** 2, axis=1).max()
        loss = 50.0 * step * np.sqrt(per_mass / (softness / stage.factor.max()).min())
        yield (
            f"march.time_step is {share:.2g} of the critical step: in contact, the flexible casing"
            f" loses energy as with a damping ratio of up to {loss:.2g} %, a numerical error of"
            " first order in the step"
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
    """Return the displacement of each contact node normal to the wall, per normal and per
    tangential force on it [m/N], (nodes,) each; empty for a structure with rigid modes."""
    reduced = stage.reduced
    squares = reduced.squares
    if squares.min() <= rigid_limit(stage.part):
        return np.zeros(0), np.zeros(0)
    # The modes and the residual flexibility together are statically exact.
    slope = stage.slope
    rows = in_wall_axes(reduced.contact, slope)
    compliance = compliance_in_wall_axes(reduced.compliance, slope)
    radial, tangential = rows[::3], rows[1::3]
    residual = np.diag(compliance)[::3], np.diag(compliance, 1)[::3]
    return (
        residual[0] + (radial**2) @ (1.0 / squares),
        residual[1] + (radial * tangential) @ (1.0 / squares),
    )
