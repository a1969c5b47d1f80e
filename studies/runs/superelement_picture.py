"""Picture of the stage of a superelement at t = 0."""

from pathlib import Path

import numpy as np

from bladewhirl.models.stage.superelement_stage import SuperelementStage
from bladewhirl.postprocess.fields.enlarged import round_factor
from bladewhirl.postprocess.fields.result import result_of
from bladewhirl.postprocess.pictures.blades import render_blades
from bladewhirl.solvers.march.recorder import histories_of
from bladewhirl.studies.runs.march_texts import attributes
from bladewhirl.studies.runs.prepare import prepare

CLEARANCE_SHARE = 0.1  #: largest drawn clearance, divided by the size of a blade


def draw_superelement(stage: SuperelementStage, path: Path) -> None:
    """Draw the blades at t = 0 with their contact nodes and the wall; the clearance is enlarged.

    Args:
        stage: stage of a superelement with points and triangles.
        path: file to write, .png.

    Raises:
        ViewError: the superelement has no points and triangles.
        CaseError: the case cannot be marched.
    """
    prepared = prepare(stage)
    _, chunk, _ = prepared.scheme.advance(prepared.scheme.init(), 1)
    histories = {name: getattr(chunk, name) for name in histories_of(stage.arrays)}
    result = result_of(stage.arrays, histories, attributes(prepared, ""))
    points, clearance = stage.arrays.point, float(np.abs(stage.wall.clearance[:, 0]).max())
    size = float(np.ptp(points, axis=0).max(initial=0.0)) if len(points) else 0.0
    factor = round_factor(size, (CLEARANCE_SHARE, clearance))
    render_blades(result, path, np.array([0]), exaggeration=factor)
