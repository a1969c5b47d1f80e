"""Attributes of the result of a march, and the description of a divergence."""

import numpy as np

from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.stage import Stage
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.solvers.march.recorder import AnyChunk, Attribute
from bladewhirl.solvers.march.schema import MODEL, SUPERELEMENT
from bladewhirl.studies.runs import folder
from bladewhirl.studies.runs.prepare import AnyPrepared
from bladewhirl.studies.runs.properties import MARCHES


def attributes(prepared: AnyPrepared, case_text: str) -> dict[str, Attribute]:
    """Return the attributes of the result of a march.

    Args:
        prepared: the case to march.
        case_text: text of the case, see `folder.portable_case`.
    """
    stage, timing = prepared.stage, prepared.timing
    common: dict[str, Attribute] = {
        "title": stage.case.title,
        "version": folder.version(),
        "speed": stage.speed,
        "reference_frequency": stage.reference_frequency,
        "friction": stage.case.contact.friction,
        "time_step": timing.time_step,
        "record_step": timing.record_step,
        "case": case_text,
    }
    if isinstance(stage, Stage):
        return common | _beam_attributes(prepared, stage)
    worn = stage.coating
    layer: dict[str, Attribute] = (
        {}
        if worn is None
        else {"coating_thickness": worn.thickness, "coating_removable": worn.removable}
    )
    return (
        common
        | layer
        | {
            MODEL: SUPERELEMENT,
            "superelement": stage.part.name,
            "boundary": stage.case.reduction.boundary,
            "casing_radius": stage.casing_radius,
            "tip_radius": float(stage.part.contact_radius.max()),
        }
    )


def divergence(prepared: AnyPrepared, chunk: AnyChunk) -> str:
    """Describe a violation of the displacement limit, at the end of the records of a chunk."""
    if isinstance(chunk, Chunk):
        assert isinstance(prepared.problem, ContactProblem)
        return _beam_divergence(prepared.problem, prepared.timing.time_step, chunk)
    moved = np.abs(chunk.contact_displacement[-1, :, 0])
    node = int(moved.argmax())
    arrays = prepared.stage.arrays
    return (
        f"contact node {arrays.node[node]} of blade {arrays.blade[node]} passed"
        f" march.displacement_limit = {prepared.problem.displacement_limit:g} m"
        f" at {chunk.time[-1]:.6g} s"
    )


def _beam_attributes(prepared: AnyPrepared, stage: Stage) -> dict[str, Attribute]:
    case = stage.case
    strength = case.material.lowest_yield_strength
    return {
        **({} if strength is None else {"yield_strength": strength}),
        "casing_radius": stage.reduced_casing.radius,
        "tip_radius": stage.rotor.tip_radius,
        "clamped": int(case.shaft.clamped),
        "symmetry": "; ".join(
            f"{body.replace('_', ' ')}: {symmetry}, march {MARCHES[cyclic]}"
            for (body, symmetry), cyclic in zip(
                stage.symmetry.items(), prepared.scheme.cyclic, strict=True
            )
        ),
    }


def _beam_divergence(problem: ContactProblem, step: float, chunk: Chunk) -> str:
    """Describe a violation of the displacement limit: blade or angle, time and size; only the time
    if the motion of the casing is not recorded.

    The last record is within the limit. The place of the violation is found from displacements that
    are extrapolated by one step.
    """
    rotor, casing = problem.rotor, problem.casing
    largest, text = 0.0, ""
    limit = f"march.displacement_limit = {problem.displacement_limit:g} m"
    if chunk.casing_displacement.shape[1] < len(casing.frequency):
        return f"a tip or the casing passed {limit} at {chunk.time[-1]:.6g} s"
    for body, way, shapes in (
        ("rotor", "radially", rotor.tip_radial),
        ("rotor", "tangentially", rotor.tip_tangential),
        ("casing", "radially", casing.nodal[:, 0]),
    ):
        moved = shapes @ getattr(chunk, f"{body}_displacement")[-1]
        ahead = np.abs(moved + step * (shapes @ getattr(chunk, f"{body}_velocity")[-1]))
        place = int(ahead.argmax())
        if ahead[place] >= largest:
            angle = 360.0 * place / len(shapes)
            name = f"blade {place}" if body == "rotor" else f"the casing at {angle:.4g}°"
            text = f"{name} passed {limit} at {chunk.time[-1]:.6g} s ({moved[place]:.4g} m {way})"
            largest = ahead[place]
    return text
