"""The same case marched with every scheme: displacement, impulse, energy and cost side by side."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np
import xarray as xr

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.march.march import Chunk, march
from bladewhirl.solvers.march.scheme import SchemeName
from bladewhirl.studies.runs.figures_folder import check_figure_folder, written_to
from bladewhirl.studies.runs.prepare import Prepared, prepare_stage

SCHEMES: tuple[str, ...] = get_args(SchemeName)

Progress = Callable[[int, int], None]
"""Called with steps done and steps in all, those of all schemes."""

WORKS = ("external_work", "normal_work", "friction_work", "coupling_work")

UNITS = {
    "tip_displacement": ("m", "largest radial displacement of a tip"),
    "impulse": ("N s", "normal impulse of all tips since the start"),
    "friction_impulse": ("N s", "friction impulse of all tips since the start"),
    "energy": ("J", "energy of both bodies and of all springs"),
    "friction_work": ("J", "work of the friction forces since the start"),
    "penetration": ("m", "deepest penetration of any tip"),
    "ledger": ("1", "largest mismatch of energy and work, over the largest term"),
    "distance": ("1", "root mean square of the tips' distance, over theirs in the first scheme"),
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
        case: to march; its own scheme plays no part.
        directory: for a figure and its data; none when None.
        overwrite: write into a folder that exists.
        progress: called as it goes.

    Returns:
        histories over (`scheme`, `time`), NaN where a march ended early, and numbers over `scheme`:
        see `UNITS`. Attributes `title`, `speed`, `reference_frequency`.

    Raises:
        CaseError: faults of the case, also with one of the schemes.
        UserError: the folder may not be used or written.
    """
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.studies.convergence.figures import plot_schemes

    folder = None if directory is None else Path(directory)
    check_figure_folder(folder, overwrite=overwrite)
    stages = [build_stage(with_values(case, {"march.scheme": name})) for name in SCHEMES]
    prepared = [prepare_stage(stage) for stage in stages]
    found = [_marched(one, number, progress) for number, one in enumerate(prepared)]
    data = _side_by_side(found, prepared[0])
    if folder is not None:
        with written_to(folder):
            save_figure(plot_schemes(data), folder / "schemes", data)
    return data


def schemes_document(data: xr.Dataset) -> dict[str, Any]:
    """The numbers of each scheme, histories by their last value; null where there is none."""
    return {
        "title": data.attrs["title"],
        "speed": data.attrs["speed"],
        "schemes": [
            {"scheme": name, "end_time": float(data["end_time"].sel(scheme=name))}
            | {key: _number(last_value(data[key].sel(scheme=name))) for key in UNITS}
            for name in data["scheme"].values.tolist()
        ],
    }


def last_value(values: xr.DataArray) -> float:
    """A number, or the last of a history: of tip displacements the largest."""
    if values.ndim == 0:
        return float(values)
    return float(values.max() if values.name == "tip_displacement" else values.dropna("time")[-1])


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _marched(prepared: Prepared, number: int, progress: Progress | None) -> xr.Dataset:
    """One scheme's histories, with tips (time, tip) beside them."""
    whole = prepared.timing.steps
    chunks: list[Chunk] = []
    began, steps = time.perf_counter(), 0
    for state, chunk, _ in march(prepared.scheme, prepared.timing):
        chunks.append(chunk)
        steps = state.step
        if progress is not None:
            progress(number * whole + min(steps, whole), len(SCHEMES) * whole)
    cost = (time.perf_counter() - began) / max(steps, 1)

    def joined(name: str) -> np.ndarray[Any, Any]:
        return np.concatenate([getattr(chunk, name) for chunk in chunks])

    tips = joined("rotor_displacement") @ prepared.problem.rotor.tip_radial.T
    energy, damped = joined("energy"), joined("damping_work")
    works = np.array([joined(name) for name in WORKS])
    mismatch = energy - energy[0] - works.sum(axis=0) + damped
    terms = np.abs([energy, damped, *works]).max()
    histories = {
        "tip_displacement": np.abs(tips).max(axis=1),
        "impulse": joined("contact_impulse").sum(axis=1).cumsum(),
        "friction_impulse": joined("friction_impulse").sum(axis=1).cumsum(),
        "energy": energy,
        "friction_work": joined("friction_work"),
    }
    numbers = {
        "penetration": max(0.0, -float(joined("gap").min())),
        "ledger": float(np.abs(mismatch).max() / terms) if terms > 0.0 else 0.0,
        "step_cost": cost,
        "end_time": float(joined("time")[-1]),
    }
    return xr.Dataset(
        {name: ("time", values) for name, values in histories.items()}
        | {"tips": (("time", "tip"), tips)}
        | numbers,
        coords={"time": joined("time")},
    )


def _side_by_side(found: list[xr.Dataset], first: Prepared) -> xr.Dataset:
    whole = xr.concat(found, xr.Variable("scheme", list(SCHEMES)), join="outer")
    size = float(np.sqrt((whole["tips"].isel(scheme=0) ** 2).mean()))
    off = np.sqrt(((whole["tips"] - whole["tips"].isel(scheme=0)) ** 2).mean(("time", "tip")))
    data = whole.drop_vars("tips").assign(distance=off / (size or np.nan))
    for name, (unit, told) in UNITS.items():
        data[name].attrs.update({"units": unit, "long_name": told})
    data["time"].attrs["units"] = "s"
    stage = first.stage
    return data.assign_attrs(
        title=stage.case.title, speed=stage.speed, reference_frequency=stage.reference_frequency
    )
