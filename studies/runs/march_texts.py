"""Attributes of the result of a march, and the description of a divergence."""

import numpy as np

from bladewhirl.models.stage.superelement_stage import SuperelementStage
from bladewhirl.solvers.march.boundary import BoundaryChunk
from bladewhirl.solvers.march.recorder import AnyChunk, Attribute
from bladewhirl.solvers.march.schema import MODEL, SUPERELEMENT
from bladewhirl.studies.runs import folder
from bladewhirl.studies.runs.prepare import Prepared
from bladewhirl.studies.runs.properties import MARCHES


def attributes(prepared: Prepared, case_text: str) -> dict[str, Attribute]:
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
    if isinstance(stage, SuperelementStage):
        if (worn := stage.coating) is not None:
            common |= {"coating_thickness": worn.thickness, "coating_removable": worn.removable}
        return {
            **common,
            MODEL: SUPERELEMENT,
            "superelement": stage.part.name,
            "boundary": stage.case.reduction.boundary,
            "casing_radius": stage.casing_radius,
            "tip_radius": float(stage.part.contact_radius.max()),
        }
    strength = stage.case.material.lowest_yield_strength
    return {
        **common,
        **({} if strength is None else {"yield_strength": strength}),
        "casing_radius": stage.reduced_casing.radius,
        "tip_radius": stage.rotor.tip_radius,
        "clamped": int(stage.case.shaft.clamped),
        "symmetry": "; ".join(
            f"{body.replace('_', ' ')}: {symmetry}, march {MARCHES[cyclic]}"
            for (body, symmetry), cyclic in zip(
                stage.symmetry.items(), prepared.scheme.cyclic, strict=True
            )
        ),
    }


def divergence(prepared: Prepared, chunk: AnyChunk) -> str:
    """Describe the violation of the displacement limit at the end of the last chunk of a march.

    The text contains blade or angle, time and size, or only the time if the motion of the casing is
    not recorded. The last record of a stage of beams is still within the limit; the place of the
    violation is found from displacements that are extrapolated by one step.
    """
    problem, at = prepared.problem, f"at {chunk.time[-1]:.6g} s"
    limit = f"march.displacement_limit = {problem.displacement_limit:g} m"
    if isinstance(chunk, BoundaryChunk):
        node = int(np.abs(chunk.contact_displacement[-1, :, 0]).argmax())
        arrays = prepared.stage.arrays
        name = f"contact node {arrays.node[node]} of blade {arrays.blade[node]}"
        return f"{name} passed {limit} {at}"
    rotor, casing = problem.rotor, problem.casing
    if chunk.casing_displacement.shape[1] < len(casing.frequency):
        return f"a tip or the casing passed {limit} {at}"
    largest, text = 0.0, ""
    for body, way, shapes in (
        ("rotor", "radially", rotor.tip_radial),
        ("rotor", "tangentially", rotor.tip_tangential),
        ("casing", "radially", casing.nodal[:, 0]),
    ):
        moved = shapes @ getattr(chunk, f"{body}_displacement")[-1]
        rate = shapes @ getattr(chunk, f"{body}_velocity")[-1]
        ahead = np.abs(moved + prepared.timing.time_step * rate)
        place = int(ahead.argmax())
        if ahead[place] >= largest:
            angle = 360.0 * place / len(shapes)
            name = f"blade {place}" if body == "rotor" else f"the casing at {angle:.4g}°"
            text = f"{name} passed {limit} {at} ({moved[place]:.4g} m {way})"
            largest = ahead[place]
    return text
