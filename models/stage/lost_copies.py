"""Loss of blades that are copies of one superelement.

Each copy is clamped at its root and moves by itself, or with the others through a flexible casing.
A lost copy goes as a whole: its modes have no motion, no load and no contact any more. The root is
held, so that nothing feels the imbalance; other blades continue as they are.
"""

from dataclasses import replace

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades, Start
from bladewhirl.models.stage.superelement_stage import SuperelementStage


def with_lost_copies(stage: SuperelementStage, problem: ContactProblem) -> ContactProblem:
    """Return the contact problem of a stage of separate blades with the loss of blades of its case,
    if it has one."""
    loss = stage.case.blade_loss
    if loss is None:
        return problem
    rotor, blades = problem.rotor, np.array(loss.blade)
    remains = np.isin(np.arange(stage.copies), blades, invert=True)
    kept = np.repeat(remains, len(rotor.frequency) // stage.copies)
    tips = np.flatnonzero(np.repeat(~remains, stage.part.contacts))
    clearance = float(stage.case.casing.clearance_profile.smallest)
    reach = rotor.tip_recess[tips] + stage.blade_length + clearance
    recess = rotor.tip_recess.copy()
    recess[tips] += reach + 3.0 * problem.displacement_limit
    after = replace(
        problem,
        rotor=replace(rotor, tip_recess=recess),
        loads=tuple(replace(load, rotor=_where(kept, load.rotor)) for load in problem.loads),
        start=Start.of_rotor(
            np.zeros(len(kept)), np.zeros(len(kept)), len(problem.casing.frequency)
        ),
    )
    staying = np.diag(kept.astype(np.float64))
    lost = LostBlades(
        time=loss.time,
        after=after,
        restriction=staying,
        extension=staying,
        tips=tips,
        reach=reach,
    )
    return replace(problem, loss=lost)


def _where(kept: BoolArray, values: FloatArray) -> FloatArray:
    """Return values of modes, zero for those of lost blades."""
    return np.asarray(np.where(kept, values, 0.0))
