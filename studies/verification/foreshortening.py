"""Foreshortening of bent blades: closed-form solutions, elastica, true radii, work of contact."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.integrate import simpson

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import case_bladed_disk
from bladewhirl.models.elements.foreshortening import drawback
from bladewhirl.studies.verification.bodies import default_stage, ledger_residual, marched
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies

BLADE = 3  #: blade that bends
LENGTH = 0.45  #: length of the default blade [m]
ROOTS = {"first": 1.875104068711961, "second": 4.694091132974175}
"""Roots beta of cosh(beta) cos(beta) = -1 of a clamped blade."""

Shape = tuple[Callable[[FloatArray], FloatArray], Callable[[FloatArray], FloatArray]]
"""Deflection and slope as functions of the position on the blade, 0 at the root, 1 at the tip."""

FORCE: Shape = (lambda x: (3.0 * x**2 - x**3) / 2.0, lambda x: (6.0 * x - 3.0 * x**2) / 2.0)
MOMENT: Shape = (lambda x: x**2, lambda x: 2.0 * x)


def mode(name: str) -> Shape:
    """Return a bending mode of a clamped blade, 1 at the tip."""
    beta = ROOTS[name]
    ratio = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))

    def deflection(x: FloatArray) -> FloatArray:
        z = beta * x
        return np.asarray(np.cosh(z) - np.cos(z) - ratio * (np.sinh(z) - np.sin(z)))

    def slope(x: FloatArray) -> FloatArray:
        z = beta * x
        return np.asarray(beta * (np.sinh(z) + np.sin(z) - ratio * (np.cosh(z) - np.cos(z))))

    tip = float(deflection(np.array(1.0)))
    return lambda x: deflection(x) / tip, lambda x: slope(x) / tip


@cache
def bladed_disk() -> BladedDiskModel:
    """Return the finite elements of the default bladed disk."""
    return case_bladed_disk(Case(), clamped=False)


def field(x: FloatArray, y: FloatArray, rotation: FloatArray) -> FloatArray:
    """Return the free DoF of displacements x, y and rotations of all nodes, (size, 1)."""
    disk = bladed_disk()
    local = rotate(np.stack([x, y, rotation], axis=1), -disk.mesh.node_axes)
    dofs = disk.structure.node_dofs
    free = np.zeros((disk.structure.size, 1))
    free[dofs[dofs >= 0], 0] = local[dofs >= 0]
    return free


def directions() -> FloatArray:
    """Return the radial and the tangential direction at the blade that bends, (2, 2)."""
    return rotate(np.eye(2), bladed_disk().tip_angles[BLADE])


def bent(shape: Shape) -> FloatArray:
    """Return the field of one bent blade with a unit tip deflection [m]; the disk is at rest."""
    points = bladed_disk().mesh.points
    out, ahead = directions()
    root = bladed_disk().model.tip_radius - LENGTH
    on = (np.abs(points @ ahead) < 1e-9) & (points @ out > root - 1e-9)
    place = np.clip((points @ out - root) / LENGTH, 0.0, 1.0)
    deflection, slope = shape[0](place) * on, shape[1](place) / LENGTH * on
    return field(deflection * ahead[0], deflection * ahead[1], slope)


def turned() -> FloatArray:
    """Return the field of a rigid rotation by 1 rad about the centre."""
    points = bladed_disk().mesh.points
    return field(-points[:, 1], points[:, 0], np.ones(len(points)))


def opening(moved: FloatArray, *, around: bool = False) -> float:
    """Return the opening of the gap of the blade that bends [m]."""
    rows, signs = drawback(bladed_disk(), moved, BLADE, around=around)
    return float(0.5 * signs @ rows[:, 0] ** 2)


@verifies("first", "second")
def drawback_in_a_mode(name: str) -> Pair:
    """Compare the draw-back of a tip in a bending mode with 1/2 int w'^2 of the exact mode, while
    the disk rotates rigidly."""
    place = np.linspace(0.0, 1.0, 20_001)
    exact = simpson(mode(name)[1](place) ** 2, x=place) / 2.0
    return exact, LENGTH * opening(bent(mode(name)) + turned())


@verifies()
def drawback_under_a_force() -> Pair:
    """Compare the draw-back of a tip that a force deflects by y with 0.6 y^2 / L."""
    return 0.6, LENGTH * opening(bent(FORCE))


@verifies()
def drawback_of_the_elastica() -> Pair:
    """Compare the draw-back of a tip with the exact shortening of beams whose tips deflect by up to
    a fifth of the length."""
    given, exact, ours = reference("elastica"), [], []
    for load, shape in (("tip_force", FORCE), ("end_moment", MOMENT)):
        exact += given[load]["u"]
        ours += [LENGTH * opening(bent(shape)) * w**2 for w in given[load]["w"]]
    return exact, ours


@verifies()
def rotation_without_drawback() -> Pair:
    """Compare the openings by a rigid rotation of 1 rad with zero."""
    return [0.0, 0.0], [opening(turned(), around=around) for around in (False, True)]


@verifies()
def radius_of_a_bent_blade() -> Pair:
    """Compare the distance of a tip from the axis with that of the end of an inextensible curve
    on a rigid disk which turns and moves."""
    exact, ours = [], []
    place, ahead = np.linspace(0.0, 1.0, 20_001), directions()[1]
    slope, ones = mode("first")[1](place) / LENGTH, np.ones(len(bladed_disk().mesh.points))
    radius = bladed_disk().model.tip_radius
    for tip, rotation, centre in ((2e-4, 0.0, 0.0), (2e-4, 3e-4, 0.0), (2e-4, 3e-4, 1e-4)):
        along = LENGTH * simpson(np.cos(tip * slope), x=place) + radius - LENGTH
        across = LENGTH * simpson(np.sin(tip * slope), x=place)
        at = np.add(rotate((along, across), rotation), (0.0, centre))
        exact.append(radius - np.hypot(*at))
        shift = field(centre * ahead[0] * ones, centre * ahead[1] * ones, 0.0 * ones)
        ours.append(opening(tip * bent(mode("first")) + rotation * turned() + shift, around=True))
    return exact, ours


@verifies()
def work_of_drawn_tips() -> Pairs:
    """Compare the work of the contact forces with the forces times the motion of the gaps, both
    extrapolated to a time step of zero. The energy minus all works is zero.

    The blades of a stage in a rigid wall bend by up to a tenth of their length.
    """
    changes = {
        "bladed_disk.blades": 5,
        "casing.elements": 12,
        "reduction.fixed_interface_modes": 15,
        "contact.foreshortening": True,
        "initial.centre_velocity": [3.0, 1.4],
        "initial.tip_velocity": [[0.0, 12.0 - 8.0 * (blade % 2)] for blade in range(5)],
    }
    made = default_stage(changes)
    made = replace(made, casing=replace(made.casing, nodal=np.zeros_like(made.casing.nodal)))
    chunk, coarse = (marched(made, dt, round(8e-3 / dt), every=100) for dt in (1e-6, 2e-6))
    if not chunk.contact_impulse.any():
        raise ArithmeticError("expected contact")
    assert made.foreshortening is not None
    deepest = float(made.foreshortening.opening(chunk.rotor_displacement).max())
    if not deepest > 1e-3:
        raise ArithmeticError(f"expected tips that draw back by 1 mm, not by {deepest:.3g} m")
    along, work = (
        2.0 * getattr(chunk, name)[-1] - getattr(coarse, name)[-1]
        for name in ("closing_work", "normal_work")
    )
    return {
        "work_along_the_gap": (along, work),
        "foreshortening_ledger": (0.0, ledger_residual(chunk)),
    }
