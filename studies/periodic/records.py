"""Records of a periodic motion in the form of a run, for films, series and figures."""

from pathlib import Path

import numpy as np
import xarray as xr

from bladewhirl.files import claim
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.cone import in_wall_axes
from bladewhirl.models.stage.modal_loads import NEVER, Start
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.solvers.periodic.blade import Grid
from bladewhirl.solvers.periodic.contact import Motion, NotConverged
from bladewhirl.solvers.periodic.corotating import corotating_contact
from bladewhirl.solvers.periodic.search import prolonged, refined
from bladewhirl.studies.periodic import corotating
from bladewhirl.studies.periodic.initial_states import of_blades, of_corotating
from bladewhirl.studies.periodic.motions import blade_of
from bladewhirl.studies.runs.folder import case_files, portable_case
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_to_file
from bladewhirl.studies.sweeps.starts import begun

RECORDS = 360  #: least number of records of a turn
GROWTH = 30.0
"""Largest growth of deviations within the records; the march deviates by some 0.1 % in a turn."""


def record_motion(
    case: Case, data: xr.Dataset, directory: str | Path, *, overwrite: bool = False
) -> Path:
    """March a turn on a periodic motion, and write it into a folder as a run that `render`,
    `export_vtk`, `open_result` and figures of runs read.

    The march starts with the displacements, velocities and contact forces of the motion.

    Args:
        case: case of the motion.
        data: Dataset of `bladewhirl.periodic` for one speed; of several constant contacts the first
            is taken.
        directory: folder of result.nc and case.toml.
        overwrite: whether files of the folder that bladewhirl did not write may be replaced.

    Returns:
        path of result.nc.

    Raises:
        CaseError: the case cannot be built.
        ViewError: the motion is so unstable that a march leaves it within a turn.
        UserError: there are several speeds, or the folder cannot be written.
    """
    if (speeds := len(np.unique(data["rpm"]))) != 1:
        raise UserError(f"record_motion: {speeds} speeds; expected one")
    one, folder = data.isel(speed=0), Path(directory)
    speed = f"{float(one['rpm'])!r} rpm"
    own = with_values(case, {"march.speed": speed})
    stage = build_stage(own)
    turns = 1
    if "multipliers" in one:
        turn = 2.0 * np.pi / abs(stage.speed)
        share = float(one["period"]) / turn
        turns = 1 if abs(1.0 / share - round(1.0 / share)) < 1e-6 else round(data.attrs["periods"])
        growth = float(np.abs(one["multipliers"].values[0])) ** (turns / share)
        if growth > GROWTH:
            raise ViewError(
                f"a march leaves the motion at {float(one['rpm']):g} rpm, from"
                f" which deviations grow by a factor of {growth:.3g} in {turns} revolutions"
            )
    step = own.march.time_step
    every = max(1, int(2.0 * np.pi / abs(stage.speed) / RECORDS / step))
    records = int(np.ceil(turns * 2.0 * np.pi / abs(stage.speed) / (every * step)))
    times = {"march.record_step": every * step, "march.duration": records * every * step}
    own = with_values(own, times)
    stage = build_stage(own)
    start = _start(stage, data)
    prepared = prepare(stage, lambda problem, timing: (begun(problem, start), timing))
    with writing(folder):
        files = case_files(own)
        claim(folder, [RESULT_NAME, *files], overwrite=overwrite)
        for name, content in files.items():
            (folder / name).write_bytes(content)
        march_to_file(prepared, folder / RESULT_NAME, portable_case(_closed(own)))
    return folder / RESULT_NAME


def _start(stage: Stage, data: xr.Dataset) -> Start:
    """Return the start of a march on the motion of a Dataset.

    Raises:
        UserError: the motion is not one of the stage.
    """
    problem, one = contact_problem(stage), data.isel(speed=0)
    try:
        if corotating.is_corotating(problem):
            return of_corotating(problem, corotating_contact(problem))[0]
        number = int(data.attrs["blade"])
        blade = blade_of(stage, number, int(data.attrs["periods"]))
        force = one["contact_force"].values
        force = in_wall_axes(force.reshape(len(force), -1).T, problem.slope).T
        radial, along, axial = np.moveaxis(force.reshape(len(force), -1, 3), -1, 0)
        turned = 0.0 if problem.speed > 0.0 else np.pi
        angle = np.where(radial < 0.0, np.arctan2(-axial, -along), turned)
        guess = Motion(Grid(blade, len(force)), np.maximum(0.0, -radial), angle)
        return of_blades(stage, refined(prolonged(guess)), number)[0]
    except NotConverged as reason:
        raise UserError(f"record_motion: expected a motion of this case ({reason})") from None


def _closed(case: Case) -> Case:
    """Return the case of a closing casing at its end; that of another one unchanged."""
    closure = case.casing.closure
    if closure is None:
        return case
    end = closure.value(NEVER)
    lobes = [
        lobe.model_dump() | {"amplitude": lobe.amplitude * end / closure.largest}
        for lobe in closure.lobes
    ]
    table = [[0.0, float(end)], [1.0, float(end)]]
    return with_values(case, {"casing.closure": {"table": table, "lobes": lobes}})
