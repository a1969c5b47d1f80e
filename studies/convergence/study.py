"""Convergence of a march in its time step and in its modes: Section 4.2 of the paper.

Runs that differ in nothing else are compared with the finest: distance of the shaft's orbits (root
mean square in rotating axes, over the radius of the finest), total normal impulse, regime.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from bladewhirl.meshes.files.drafts import write_whole
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import CaseError, Fault, UserError
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.run.measures import Motion, orbit_distance
from bladewhirl.studies.runs.figures_folder import check_figure_folder, written_to
from bladewhirl.studies.sweeps.cache import Progress, RunStore, run_key

TIME_STEP, MODES = "march.time_step", "reduction.fixed_interface_modes"

RUNS_NAME = "runs"
"""The folder that keeps the marches."""

REFINEMENTS = (4.0, 2.0, 1.0, 0.5)
"""Time steps looked at where none are given, times that of the case; those below the critical of
which the time between records is a multiple."""

SECTORS = (2, 3, 4, 5, 6)
"""Fixed-interface modes of a blade looked at where no numbers are given."""

FAMILIES = tuple(f"{rank}F" for rank in range(1, 6))
"""Families whose frequency error the paper gives."""


@dataclass(frozen=True, kw_only=True)
class Convergence:
    """Behaviour of a case as it is refined."""

    time_steps: xr.Dataset  #: from `time_step_convergence`
    modes: xr.Dataset  #: from `mode_convergence`

    def as_json(self) -> dict[str, Any]:
        """All numbers; those that don't exist are null."""
        return {name: _plain(getattr(self, name)) for name in ("time_steps", "modes")}


def convergence(
    case: Case,
    directory: str | Path,
    *,
    time_steps: Sequence[float] | None = None,
    modes: Sequence[int] | None = None,
    overwrite: bool = False,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Convergence:
    """Study how a march depends on its time step and on its modes.

    The folder gets figures with their data, convergence.json and the marches, which are found
    there again by a study that was interrupted or asks for more.

    Args:
        case: to march.
        directory: to make.
        time_steps: [s], two or more, descending; `default_time_steps` if none.
        modes: numbers of fixed-interface modes, two or more, ascending; `default_modes` if none.
        overwrite: write into a folder that exists.
        scheduler: address of an existing dask scheduler; a local cluster when None.
        workers: of the local cluster; one a core when None, none but this process when 1.
        progress: called with marches done and marches in all.

    Raises:
        CaseError: faults of the case, also with one of the values.
        UserError: the folder may not be used or written, or a march can't be made.
    """
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.studies.convergence.figures import plot_modes, plot_time_steps

    folder = Path(directory)
    check_figure_folder(folder, overwrite=overwrite)
    for key, values in ((TIME_STEP, time_steps), (MODES, modes)):
        for value in values or ():
            with_values(case, {key: value})
    store = RunStore(directory=folder / RUNS_NAME, scheduler=scheduler, workers=workers)
    steps, counts = time_steps or default_time_steps(case), modes or default_modes(case)
    found = Convergence(
        time_steps=time_step_convergence(case, steps, store, progress),
        modes=mode_convergence(case, counts, store, progress),
    )
    with written_to(folder):
        save_figure(plot_time_steps(found.time_steps), folder / "time-step", found.time_steps)
        save_figure(plot_modes(found.modes), folder / "modes", found.modes)
        text = json.dumps(found.as_json(), indent=2, allow_nan=False, ensure_ascii=False)
        write_whole(folder / "convergence.json", text + "\n")
    return found


def default_time_steps(case: Case) -> list[float]:
    """Time steps to look at, descending [s]: those of the `REFINEMENTS` that can be marched.

    Raises:
        CaseError: all faults that stand in the way of a march of the case itself.
    """
    limit = contact_problem(build_stage(case)).critical_time_step
    steps = [scale * case.march.time_step for scale in REFINEMENTS]
    return [step for step in steps if step < limit and _divides(step, case.march.record_step)]


def _divides(step: float, whole: float) -> bool:
    ratio = whole / step
    return ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6 * ratio


def default_modes(case: Case) -> list[int]:
    """Numbers of fixed-interface modes to look at, ascending: `SECTORS` for each blade.

    Raises:
        CaseError: the bladed disk has degrees of freedom for fewer than two of them.
    """
    stage = build_stage(case)
    boundary = sum(map(len, stage.boundary_sets.values()))
    blades = case.blades
    inner = stage.disk.structure.size - boundary
    counts = [count * blades for count in SECTORS if count * blades <= inner]
    if len(counts) < 2:
        expected = (
            f"elements for {SECTORS[1] * blades} fixed-interface modes or more, to compare numbers "
            f"of them; with {inner} inner degrees of freedom name them by --modes"
        )
        raise CaseError([Fault(key="bladed_disk", expected=expected)])
    return counts


def time_step_convergence(
    case: Case, time_steps: Sequence[float], store: RunStore, progress: Progress | None = None
) -> xr.Dataset:
    """March a case with several time steps: what claim 16 (converged at 1e-6 s) is judged by.

    Args:
        case: whose `march.record_step` is a whole number of each time step.
        time_steps: [s], two or more, descending.
        store: where marches are found, and made on all cores.
        progress: called with marches done and marches in all.

    Returns:
        over `time_step` [s]: `regime`; `radius_max` of the shaft [m]; `impulse` [N s], normal, of
        all blades; `distance` of the orbit from that of the finest and `impulse_error`, relative
        to the finest (both zero there, the latter NaN without contact); `step_distance` and
        `step_impulse_error`, the same from the next finer (NaN at the finest), and
        `free_step_distance`, that of the orbits up to the first contact of any run. Attributes
        `free_until` [s], that time, and `displacement_order`, `impulse_order` and `free_order`: of
        the last three, see `observed_order`, NaN with fewer than two values above zero, or
        where they rise and fall. Without contact the order is two, in contact one; where contacts
        make the motion chaotic, differences stop falling, and the order over the whole march tells
        so by being near zero, or by there being none.

    Raises:
        UserError: a march that can't be made.
    """
    found = _compared(case, TIME_STEP, list(time_steps), store, progress)
    data = found.rename({"refined": "time_step"}).assign_coords(
        time_step=("time_step", np.array(time_steps), {"units": "s", "long_name": "time step"})
    )
    steps = np.array(time_steps)
    return data.assign_attrs(
        title="convergence in the time step",
        free_order=observed_order(steps, data["free_step_distance"].values),
        displacement_order=observed_order(steps, data["step_distance"].values),
        impulse_order=observed_order(steps, data["step_impulse_error"].values),
    )


def mode_convergence(
    case: Case, modes: Sequence[int], store: RunStore, progress: Progress | None = None
) -> xr.Dataset:
    """March a case with several numbers of fixed-interface modes: what claim 17 is judged by.

    The paper finds motion convergence: the kind of motion is the same from few modes on, while
    displacements don't converge asymptotically.

    Args:
        case: to march.
        modes: numbers of fixed-interface modes, two or more, ascending.
        store: where marches are found, and made on all cores.
        progress: called with marches done and marches in all.

    Returns:
        over `modes`: the variables of `time_step_convergence`, the finest being that with the most
        modes, and `kept`, the number without cutting a pair in two, and `frequency_error`, the
        largest relative one of the first five families of the reduced bladed disk (claim 5; NaN
        without these families). Attribute `motion_converged`: 1 where all regimes are the same.

    Raises:
        UserError: a march that can't be made.
    """
    found = _compared(case, MODES, list(modes), store, progress)
    stages = [build_stage(with_values(case, {MODES: count})) for count in modes]
    data = found.rename({"refined": "modes"}).assign_coords(
        modes=("modes", np.array(modes), {"long_name": "fixed-interface modes"})
    )
    data["kept"] = "modes", [stage.reduction.kept for stage in stages]
    data["frequency_error"] = "modes", [_frequency_error(stage) for stage in stages], {"units": "1"}
    return data.assign_attrs(
        title="convergence in the fixed-interface modes",
        motion_converged=int(len(set(data["regime"].values)) == 1),
    )


OFF_THE_LAW = 0.3
"""Root mean square of the logarithm by which differences may be off a power law to have an order:
by a third, about."""


def observed_order(size: FloatArray, change: FloatArray) -> float:
    """Order p with which results approach the limit of a size going to zero.

    An error C size^p makes neighbours differ by C (size_i^p - size_(i+1)^p), whatever the ratios
    of the sizes; p is where the logarithms of the changes lie closest to that.

    Args:
        size: descending, such as time steps, (sizes,).
        change: of the result from each size to the next, (sizes,); the last one counts for nothing.

    Returns:
        p, between -8 and 8; NaN with fewer than two changes above zero, or with changes off that
        law by more than `OFF_THE_LAW`, such as those that rise and fall: they have no order.
    """
    there = change[:-1] > 0.0  # False for NaN
    if np.count_nonzero(there) < 2:
        return float("nan")
    seen, finer = np.log(change[:-1][there]), np.log(size[1:][there])
    ratio = np.log(size[:-1] / size[1:])[there]

    def scatter(order: float) -> float:
        grown = ratio if order == 0.0 else np.expm1(order * ratio) / order
        return float(np.var(seen - order * finer - np.log(grown)))

    found = minimize_scalar(scatter, bounds=(-8.0, 8.0), options={"xatol": 1e-9})
    return float(found.x) if found.fun <= OFF_THE_LAW**2 else float("nan")


def _compared(
    case: Case,
    key: str,
    values: Sequence[float],
    store: RunStore,
    progress: Progress | None,
) -> xr.Dataset:
    """March a case with each value of a key, the last being the finest, over `refined`."""
    cases = [with_values(case, {key: value}) for value in values]
    store.make(cases, progress)
    lost = [
        f"{key} = {value:g}: {store.failures[run_key(one)]}"
        for value, one in zip(values, cases, strict=True)
        if run_key(one) in store.failures
    ]
    if lost:
        raise UserError("; ".join(lost))
    with ExitStack() as results:
        motions = [Motion(results.enter_context(open_result(store.path(one)))) for one in cases]
        finest = motions[-1]
        impulse = np.array([float(motion.result["contact_impulse"].sum()) for motion in motions])
        finer, free = list(pairwise(motions)), min(motion.first_contact for motion in motions)
        apart = [orbit_distance(*pair, until=free) for pair in finer]
        columns: dict[str, tuple[Sequence[Any] | FloatArray, str]] = {
            "regime": ([motion.regime.name for motion in motions], ""),
            "radius_max": ([float(motion.radius.max()) for motion in motions], "m"),
            "impulse": (impulse, "N s"),
            "distance": ([orbit_distance(motion, finest) for motion in motions], "1"),
            "impulse_error": (_relative(impulse - impulse[-1], impulse[-1]), "1"),
            "step_distance": ([*(orbit_distance(*pair) for pair in finer), np.nan], "1"),
            "free_step_distance": ([*apart, np.nan], "1"),
            "step_impulse_error": ([*_relative(np.diff(impulse), impulse[-1]), np.nan], "1"),
        }
        attributes = {name: finest.result.attrs[name] for name in ("speed", "reference_frequency")}
        attributes["case_title"] = finest.result.attrs["title"]
        attributes |= {"free_until": min(free, finest.end), "end": finest.end}
    return xr.Dataset(
        {
            name: ("refined", np.array(column), {"units": units} if units else {})
            for name, (column, units) in columns.items()
        },
        attrs=attributes,
    )


def _relative(difference: FloatArray, whole: float) -> FloatArray:
    """Sizes of differences over a whole; NaN where that is nothing."""
    return np.abs(difference) / whole if whole else np.full(len(difference), np.nan)


def _frequency_error(stage: Stage) -> float:
    errors = [stage.frequency_error[name] for name in FAMILIES if name in stage.frequency_error]
    return max(errors) if errors else float("nan")


def _plain(data: xr.Dataset) -> dict[str, Any]:
    """A dataset as JSON takes it."""
    columns = {str(name): data[name].values.tolist() for name in [*data.coords, *data.data_vars]}
    found: dict[str, Any] = {**columns, **data.attrs}
    return {name: _without_nan(value) for name, value in found.items()}


def _without_nan(value: Any) -> Any:
    if isinstance(value, list):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
