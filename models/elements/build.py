"""Full finite element models of a case: bladed disk and casing."""

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.case.plausibility import unusual_values
from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.elements.casing import CasingModel, assemble_casing, spring, strut
from bladewhirl.models.geometry.beam_model import BeamModel, part_outside
from bladewhirl.models.geometry.from_mesh import mesh_beam_model
from bladewhirl.models.geometry.sketch_build import build_sketch
from bladewhirl.models.geometry.standard_disk import bladed_disk_sketch
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.sections.rectangular import BeamSection
from bladewhirl.models.sections.wall import Wall

LOST = 100.0
"""An eigenvalue must exceed this multiple of the rounding error of the largest eigenvalue; a
smaller one has fewer than two correct digits."""


def case_bladed_disk(case: Case, *, clamped: bool) -> BladedDiskModel:
    """Assemble the bladed disk of a case, with a free or a clamped centre."""
    return assemble_bladed_disk(
        case_beam_model(case), shaft_stiffness=case.shaft.stiffnesses, clamped=clamped
    )


def case_beam_model(case: Case) -> BeamModel:
    """Return the beams, masses, springs and links of the bladed disk of a case.

    Raises:
        CaseError: parts do not fit together, or tips reach into the casing.
    """
    mesh = case.bladed_disk.mesh
    if case.bladed_disk.superelement is not None:
        expected = "beams here: a superelement has no lines, sections and nodes of beams"
        raise CaseError([case_fault(case, "bladed_disk.superelement.file", expected)])
    if mesh is not None:
        model = mesh_beam_model(mesh, case.material)
    elif case.sketch is not None:
        model = build_sketch(case.sketch)
    else:
        rings = [joint.cut_ring for joint in case.joint]
        model = bladed_disk_sketch(case.bladed_disk, case.material, rings).build()
    smallest_gap = case.casing.clearance_profile.smallest + model.tip_recess
    tight = int(smallest_gap.argmin())
    if smallest_gap[tight] < 0.0:
        reach = float(model.tip_radius - model.tip_recess[tight])
        outside = reach > model.tip_radius + case.casing.clearance
        expected = (
            f"tips inside the casing: the tip of blade {tight}, at radius {reach:.6g} m, "
            + ("is outside" if outside else "reaches into its lobes")
            + f" by {-smallest_gap[tight]:.3g} m where the casing is narrowest"
        )
        raise CaseError([case_fault(case, "casing.clearance", expected)])
    beyond = part_outside(model, model.tip_radius + case.casing.clearance_profile.smallest)
    if beyond is not None:
        expected = f"all parts inside the casing where it is narrowest; {beyond}"
        raise CaseError([case_fault(case, "casing.clearance", expected)])
    return model


def case_casing(case: Case) -> CasingModel:
    """Assemble the casing of a case."""
    given = case.casing
    springs = [spring(**row.model_dump()) for row in given.springs]
    struts = [
        strut(
            section=case.material.section(row),
            **row.model_dump(exclude={*BeamSection.model_fields}),
        )
        for row in given.struts
    ]
    return assemble_casing(
        _ring(case),
        Wall(
            section=case.material.section(given.wall),
            thickness=given.thickness_profile,
            arcs=given.stiffened_arcs,
        ),
        curvature=given.curvature,
        support=given.support,
        rotation=given.rotation,
        supports=(*springs, *struts),
    )


def case_clearance(case: Case) -> FloatArray:
    """Return the clearance and its derivative with respect to the arc length s at each casing
    node [m, 1], (elements, 2)."""
    profile, casing = case.casing.clearance_profile, _ring(case)
    slope = profile.slope(casing.angles) / casing.radius
    return np.column_stack([profile.value(casing.angles), slope])


def tip_in_sector(disk: BladedDiskModel) -> tuple[int, int]:
    """Return the positions of the tip's radial and tangential DoF among the DoF of a sector.

    These DoF fix the phase of cosine and sine modes. Without sectors the positions are arbitrary.
    """
    layout = disk.structure.layout
    if layout is None:
        return 0, 1
    first = list(layout.sector_dofs[0])
    return first.index(disk.tip_radial[0]), first.index(disk.tip_tangential[0])


def lowest_frequency(disk: BladedDiskModel, frequencies: Iterable[float]) -> float:
    """Return the lowest natural frequency of a bladed disk [rad/s], checked against rounding.

    The rounding error of each eigenvalue is proportional to the largest eigenvalue, which is at
    least the largest ratio of stiffness to mass at a single degree of freedom.

    Raises:
        FloatingPointError: the lowest frequency is lost in rounding.
    """
    structure, lowest = disk.structure, float(min(frequencies))
    largest_square = np.max(structure.stiffness.diagonal() / structure.mass.diagonal())
    if not lowest > np.sqrt(LOST * np.finfo(np.float64).eps * largest_square):
        raise FloatingPointError(
            "the lowest frequency of the bladed disk is below the rounding error"
        )
    return lowest


def _ring(case: Case) -> RingMesh:
    radius = case.tip_radius + case.casing.clearance
    return RingMesh(elements=case.casing.elements, radius=radius)


@contextmanager
def numbers_within_reach(case: Case) -> Iterator[None]:
    """Turn floating-point errors raised inside into an error of the case.

    Raises:
        CaseError: sizes or materials are too extreme: matrices overflow, are singular or lose
            definiteness. The error names the implausible values of the case, if any.
    """
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"), warnings.catch_warnings():
            warnings.simplefilter("error", la.LinAlgWarning)
            yield
    except (ArithmeticError, ValueError, la.LinAlgError, la.LinAlgWarning) as error:
        stable = ""
        if case.rotation.effects != "none":
            stable = f" and a speed, unlike {case.march.speed.given}, at which blades are stable"
        expected = f"sizes, material and springs that double precision can represent{stable}"
        singular = isinstance(error, la.LinAlgError | la.LinAlgWarning)
        expected += f" ({'a matrix is singular' if singular else error})"
        raise CaseError([*unusual_values(case)] or [Fault(expected=expected)]) from None
