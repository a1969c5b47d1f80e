"""`bladewhirl response`: steady response to engine-order forces against the speed."""

from pathlib import Path
from typing import Annotated, Any

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, table
from bladewhirl.studies.commands.progress import progress_bar

SPEEDS: Any = "0.1:2:381"


def response(
    case: options.CaseFile,
    speeds: Annotated[
        options.Span,
        options.span(
            "--speeds",
            'Speeds of rotation: multiples of ω₁, or "2000 rpm:9000 rpm:600".',
            counted=True,
        ),
    ] = SPEEDS,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Compute the steady response to engine-order forces at many speeds, without contact.

    The case needs excitation.type = "engine-order". The equations of motion of the time
    integration, with damping, mistuning and rotation effects, are solved for the complex amplitude
    at each speed. The table lists the largest amplitude of each engine order; the figure shows the
    amplitudes of all blades and of nodal diameters against the speed. With --json and no -o nothing
    is written.
    """
    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.models.stage.stage import build_stage
    from bladewhirl.postprocess.modal.response import drawn_amplitudes, plot_response
    from bladewhirl.studies.modal import response as study
    from bladewhirl.studies.runs.figures_folder import save_figures

    folder = output if output is not None or json else Path(f"{case.stem}-response")
    values = overrides or []
    read = read_case(case, values)
    with faults_from(case, values), progress_bar("speeds") as progress:
        stage = build_stage(read)
        multiples = speeds.values(stage.reference_frequency).tolist()
        data = study.response(stage, speeds=multiples, progress=progress)
    if folder is not None:
        figures = {"response": (plot_response(data), drawn_amplitudes(data))}
        save_figures(folder, figures, overwrite=overwrite)
    title = "Largest amplitudes of the tips"
    rows = table(study.largest(data), study.PEAKS, title)
    emit(study.response_document(data), rows, json=json, written=[folder])
