"""`bladewhirl critical-speeds`: critical speeds against the stiffness of the shaft."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, table


def critical_speeds(
    case: options.CaseFile,
    branches: Annotated[
        int, typer.Option(help="Number of branches in each direction of whirl.", min=1)
    ] = 2,
    stiffnesses: options.Stiffnesses = None,
    output: options.CaseFolder = None,
    overwrite: options.Replace = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """Draw the map of critical speeds against the stiffness of the shaft.

    At a critical speed the shaft whirls at the speed of rotation: forward, as an imbalance drives
    it, or backward. The table lists the critical speeds with the stiffness of the case. The case
    needs rotation.effects = "full". With --json and no -o nothing is written.
    """
    import numpy as np

    from bladewhirl.postprocess.modal.veering import plot_critical_speeds
    from bladewhirl.studies.modal import critical_speeds as study
    from bladewhirl.studies.modal.modes import stage_of_file
    from bladewhirl.studies.modal.veering import spring_stiffnesses
    from bladewhirl.studies.runs.figures_folder import save_figures

    interval = None if stiffnesses is None else stiffnesses.values()
    folder = output if output is not None or json else Path(f"{case.stem}-critical-speeds")
    stage = stage_of_file(case, overrides)
    at = stage.case.shaft.stiffness
    rows = study.critical_speed_rows(
        study.critical_speeds(stage, stiffnesses=np.array([at]), branches=branches).isel(
            stiffness=0
        )
    )
    document = {"stiffness": at, "critical_speeds": rows}
    if folder is not None:
        springs = spring_stiffnesses(stage.case, interval)
        speeds = study.critical_speeds(stage, stiffnesses=springs, branches=branches)
        figures = {"critical-speeds": (plot_critical_speeds(speeds), speeds)}
        save_figures(folder, figures, overwrite=overwrite)
    title = f"Critical speeds with shaft springs of {at:.4g} N/m"
    emit(document, table(rows, study.AT_THE_CASE, title), json=json, written=[folder])
