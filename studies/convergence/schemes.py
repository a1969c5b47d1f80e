"""Comparison of the contact schemes on one case: displacement, impulse, energy and cost."""

import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.analysis import SCHEMES
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import writing
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.march.march import Chunk, joined, march
from bladewhirl.studies.runs.figures_folder import check_figure_folder
from bladewhirl.studies.runs.prepare import Prepared, prepare
from bladewhirl.studies.sweeps.cache import Progress

WORKS = ("external_work", "normal_work", "friction_work", "coupling_work")

UNITS = {
    "tip_displacement": ("m", "largest radial displacement of a tip"),
    "impulse": ("N s", "normal impulse of all tips since the start"),
    "friction_impulse": ("N s", "friction impulse of all tips since the start"),
    "energy": ("J", "energy of both bodies and of all springs"),
    "friction_work": ("J", "work of the friction forces since the start"),
    "penetration": ("m", "deepest penetration of any tip"),
    "ledger": ("1", "largest mismatch of energy and work, divided by the largest term"),
    "distance": (
        "1",
        "rms difference from the tip displacements of the first scheme, divided by their rms",
    ),
    "step_cost": ("s", "time of computing a step"),
}


def compare_schemes(
    case: Case,
    directory: str | Path | None = None,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset:
    """March a case with every scheme.

    Args:
        case: case to march; its scheme is ignored.
        directory: folder for a figure and its data; nothing is written if None.
        overwrite: whether to write into an existing folder.
        progress: called with the numbers of finished steps and of all steps, over all schemes.

    Returns:
        Histories over (`scheme`, `time`), NaN where a march ended early, and numbers over `scheme`:
        see `UNITS`. Attributes `title`, `speed`, `reference_frequency`.

    Raises:
        CaseError: all faults of the case, with any of the schemes.
        UserError: the folder must not be used, or cannot be written.
    """
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.studies.convergence.figures import plot_schemes

    folder = None if directory is None else Path(directory)
    check_figure_folder(folder, overwrite=overwrite)
    prepared = [prepare(with_values(case, {"march.scheme": name})) for name in SCHEMES]
    tips = contact_problem(build_stage(case)).rotor.tip_radial
    marches = [_marched(one, tips, number, progress) for number, one in enumerate(prepared)]
    data = _side_by_side(marches, prepared[0])
    if folder is not None:
        with writing(folder):
            save_figure(plot_schemes(data), folder / "schemes", data)
    return data


def schemes_document(data: xr.Dataset) -> dict[str, Any]:
    """Return the numbers of each scheme, and the last value of each history."""
    return {
        "title": data.attrs["title"],
        "speed": data.attrs["speed"],
        "schemes": [
            {"scheme": name, "end_time": float(data["end_time"].sel(scheme=name))}
            | {key: _last_value(data[key].sel(scheme=name)) for key in UNITS}
            for name in data["scheme"].values.tolist()
        ],
    }


def _last_value(values: xr.DataArray) -> float:
    """Return the value of a number, the last value of a history, or the largest of the tip
    displacements."""
    if values.ndim:
        values = values.max() if values.name == "tip_displacement" else values.dropna("time")[-1]
    return float(values)


def _marched(
    prepared: Prepared, tip_radial: FloatArray, number: int, progress: Progress | None
) -> xr.Dataset:
    """March with one scheme; return its histories, with displacements of tips (time, tip)."""
    total = prepared.timing.steps
    chunks: list[Chunk] = []
    began, steps = time.perf_counter(), 0
    for state, chunk, _ in march(prepared.scheme, prepared.timing):
        chunks.append(chunk)
        steps = state.step
        if progress is not None:
            progress(number * total + min(steps, total), len(SCHEMES) * total)
    cost = (time.perf_counter() - began) / max(steps, 1)

    whole = joined(chunks)
    tips = whole.rotor_displacement @ tip_radial.T
    energy, damped = whole.energy, whole.damping_work
    works = np.array([getattr(whole, name) for name in WORKS])
    mismatch = energy - energy[0] - works.sum(axis=0) + damped
    terms = np.abs([energy, damped, *works]).max()
    histories = {
        "tip_displacement": np.abs(tips).max(axis=1),
        "impulse": whole.contact_impulse.sum(axis=1).cumsum(),
        "friction_impulse": whole.friction_impulse.sum(axis=1).cumsum(),
        "energy": energy,
        "friction_work": whole.friction_work,
    }
    numbers = {
        "penetration": max(0.0, -float(whole.gap.min())),
        "ledger": float(np.abs(mismatch).max() / terms) if terms > 0.0 else 0.0,
        "step_cost": cost,
        "end_time": float(whole.time[-1]),
    }
    return xr.Dataset(
        {name: ("time", values) for name, values in histories.items()}
        | {"tips": (("time", "tip"), tips)}
        | numbers,
        coords={"time": whole.time},
    )


def _side_by_side(marches: list[xr.Dataset], first: Prepared) -> xr.Dataset:
    data = xr.concat(marches, xr.Variable("scheme", list(SCHEMES)), join="outer")
    reference = data["tips"].isel(scheme=0)
    size = float(np.sqrt((reference**2).mean()))
    distance = np.sqrt(((data["tips"] - reference) ** 2).mean(("time", "tip")))
    data = data.drop_vars("tips").assign(distance=distance / (size or np.nan))
    for name, (unit, long_name) in UNITS.items():
        data[name].attrs.update({"units": unit, "long_name": long_name})
    data["time"].attrs["units"] = "s"
    stage = first.stage
    return data.assign_attrs(
        title=stage.case.title, speed=stage.speed, reference_frequency=stage.reference_frequency
    )
