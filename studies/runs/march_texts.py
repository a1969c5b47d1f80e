"""Attributes of the result of a march, and descriptions of a divergence and of unsolved steps."""

from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.solvers.march.recorder import Attribute
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
        "friction": stage.case.wall_friction,
        "time_step": timing.time_step,
        "record_step": timing.record_step,
        "case": case_text,
    }
    course = stage.case.march.course(stage.reference_frequency)
    if course is not None and stage.case.march.drive is None:
        common["lowest_speed"], common["highest_speed"] = course.range
    if stage.case.blade_loss is not None:
        common["blade_loss"] = stage.case.blade_loss.text
    symmetries = stage.symmetry.items()
    marched = "; ".join(
        f"{body.replace('_', ' ')}: {symmetry}, march {MARCHES[cyclic]}"
        for (body, symmetry), cyclic in zip(symmetries, prepared.scheme.cyclic, strict=False)
    )
    return {**common, **stage.attributes, **({"symmetry": marched} if marched else {})}


def divergence(prepared: Prepared, chunk: Chunk) -> str:
    """Describe the violation of the displacement limit at the end of the last chunk of a march."""
    problem = prepared.problem
    who, detail = chunk.beyond(problem, prepared.arrays, prepared.timing.time_step)
    limit = f"march.displacement_limit = {problem.displacement_limit:g} m"
    return f"{who} passed {limit} at {chunk.time[-1]:.6g} s{detail}"


def check_solved(prepared: Prepared, unsolved: int, steps: int) -> None:
    """Check the number of steps whose contact problem was not solved.

    Raises:
        CaseError: they are more than march.unsolved_share allows.
    """
    case = prepared.stage.case
    if unsolved > case.march.unsolved_share * max(steps, 1):
        text = unsolved_text(unsolved, steps)
        expected = f"a larger share, or a contact problem that can be solved; {text}"
        raise CaseError([case_fault(case, "march.unsolved_share", expected)])


def unsolved_text(unsolved: int, steps: int, about: str = "") -> str:
    """Return the number of unsolved steps, what is known about them, and what to check; nothing if
    all are solved."""
    if not unsolved:
        return ""
    return (
        f"the contact problem of {unsolved} of {steps} steps was not solved{about}: check for"
        " contact nodes that are nearly at one place, use fewer of them, more modes or a shorter"
        " march.time_step, and for a coating more hardening or a lower young_modulus"
    )
