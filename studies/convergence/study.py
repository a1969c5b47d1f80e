"""Convergence of time integration in its time step and its modes: Section 4.2 of the paper.

Marches with different time steps, or with different numbers of modes, are compared with the finest
march: by the distance of the motions (root mean square, divided by that of the finest motion), the
total normal impulse and the regime. The motion is that of the shaft, or of the contact nodes of
blades without a common centre.
"""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from bladewhirl.files import json_text, write_atomically
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault, with_values
from bladewhirl.models.inputs.errors import CaseError, UserError, writing
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.run.measures import MEASURES, Motion, motion_distance
from bladewhirl.solvers.march.schema import CONVERGENCE
from bladewhirl.studies.runs.figures_folder import check_figure_folder
from bladewhirl.studies.sweeps.cache import Progress, RunStore, run_key

TIME_STEP = "march.time_step"

RUNS_NAME = "runs"  #: name of the folder of the marches

REFINEMENTS = (4.0, 2.0, 1.0, 0.5)
"""Default time steps, divided by the time step of the case. A step is used only if it is below the
critical time step and divides the time between records."""

SHARES = (0.4, 0.6, 0.8, 1.0, 1.2)
"""Default numbers of modes, divided by that of the case: 2 to 6 modes a blade for the default of 22
blades."""

FAMILIES = tuple(f"{rank}F" for rank in range(1, 6))
"""Families for which the paper states frequency errors."""


@dataclass(frozen=True, kw_only=True)
class Convergence:
    """Results of a case for several time steps and for several numbers of modes."""

    time_steps: xr.Dataset  #: from `time_step_convergence`
    modes: xr.Dataset  #: from `mode_convergence`

    def as_json(self) -> dict[str, Any]:
        """Return both datasets as a document, for `files.json_text`."""
        return {"time_steps": _document(self.time_steps), "modes": _document(self.modes)}


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

    Figures with their data, convergence.json and the marches are written into the folder. A later
    study in the same folder uses these marches again.

    Args:
        case: case to march.
        directory: folder to make.
        time_steps: two or more time steps [s], descending; `default_time_steps` if None.
        modes: two or more numbers of modes of the reduction, ascending; `default_modes` if None.
        overwrite: whether to write into an existing folder.
        scheduler: address of a dask scheduler; if None, processes of this computer march.
        workers: number of processes of this computer; one per core if None; if 1, this
            process marches.
        progress: called with the numbers of finished marches and of all marches.

    Raises:
        CaseError: faults of the case.
        UserError: a value is invalid for the case, the folder must not be used or cannot be
            written, or a march failed.
    """
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.studies.convergence.figures import plot_modes, plot_time_steps

    stage, folder = build_stage(case), Path(directory)
    check_figure_folder(folder, overwrite=overwrite)
    for key, values in ((TIME_STEP, time_steps), (stage.basis.key, modes)):
        for value in values or ():
            try:
                with_values(case, {key: value})
            except CaseError as error:
                line = error.lines[0]
                named = "" if line.startswith(f"{key} = ") else f"{key} = {value:g}: "
                raise UserError(f"{named}{line}") from None
    store = RunStore(directory=folder / RUNS_NAME, scheduler=scheduler, workers=workers)
    steps, counts = time_steps or default_time_steps(stage), modes or default_modes(stage)
    study = Convergence(
        time_steps=time_step_convergence(case, steps, store, progress),
        modes=mode_convergence(case, counts, store, progress),
    )
    with writing(folder):
        save_figure(plot_time_steps(study.time_steps), folder / "time-step", study.time_steps)
        save_figure(plot_modes(study.modes), folder / "modes", study.modes)
        write_atomically(folder / "convergence.json", json_text(study.as_json()))
    return study


def default_time_steps(stage: Stage) -> list[float]:
    """Return the default time steps, descending [s]: the steps of `REFINEMENTS` that can be used.

    Raises:
        CaseError: all errors that prevent time integration of the stage.
    """
    limit, march = contact_problem(stage).critical_time_step, stage.case.march
    steps = [scale * march.time_step for scale in REFINEMENTS]
    ratios = [march.record_step / step for step in steps]
    return [
        step
        for step, ratio in zip(steps, ratios, strict=True)
        if step < limit and ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6 * ratio
    ]


def default_modes(stage: Stage) -> list[int]:
    """Return how many modes the study keeps by default, in ascending order, see `SHARES`.

    Raises:
        CaseError: at least two of these numbers are not possible.
    """
    key, used = stage.basis
    counts = sorted({max(1, round(share * used)) for share in SHARES})
    while counts and not _is_possible(stage.case, {key: counts[-1]}):
        counts.pop()
    if len(counts) < 2:
        expected = "at least 2 numbers of modes that the stage can have; give them by --modes"
        raise CaseError([case_fault(stage.case, key, expected)])
    return counts


def _is_possible(case: Case, changes: Mapping[str, Any]) -> bool:
    try:
        build_stage(with_values(case, changes))
    except CaseError:
        return False
    return True


def time_step_convergence(
    case: Case, time_steps: Sequence[float], store: RunStore, progress: Progress | None = None
) -> xr.Dataset:
    """March a case with several time steps, as for claim 16 of the paper (converged at 1e-6 s).

    Args:
        case: case with a `march.record_step` that is a multiple of each time step.
        time_steps: two or more time steps [s], descending.
        store: store of the marches; missing marches are made on all cores.
        progress: called with the numbers of finished marches and of all marches.

    Returns:
        Dataset over `time_step` [s]: `regime`; `radius_max`, largest displacement of the shaft, or
        of a contact node [m]; `contact_impulse`, total normal impulse on all blades [N s];
        `distance` and `impulse_error`, differences of motion and impulse from the finest time step
        (`impulse_error` is NaN without contact); `step_distance` and `step_impulse_error`,
        differences from the next finer time step (NaN at the finest step); `free_step_distance`,
        `step_distance` of the motions up to the first contact in any march. Attributes:
        `free_until` [s], the time of this first contact; `displacement_order`, `impulse_order` and
        `free_order`, the observed orders of `step_distance`, `step_impulse_error` and
        `free_step_distance`, see `observed_order`. The order is two without contact, and one in
        contact. If contacts make the motion chaotic, differences stop decreasing, and the order
        over the complete march is near zero or NaN.

    Raises:
        UserError: a march failed.
    """
    compared = _compared(case, TIME_STEP, list(time_steps), store, progress)
    data = compared.rename({"refined": "time_step"}).assign_coords(
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
    """March a case with several numbers of modes, as for claim 17 of the paper.

    The paper reports motion convergence: already with few modes the kind of motion no longer
    changes, while displacements do not converge asymptotically.

    The numbers of modes, two or more, ascend; the other arguments are described in
    `time_step_convergence`.

    Returns:
        Dataset over `modes`: the variables of `time_step_convergence`, where the finest march has
        the most modes; `kept`, the number of modes used, which may include one more mode to
        complete a pair; `frequency_error`, the largest relative frequency error of the reduced
        bladed disk in the families 1F to 5F (claim 5; NaN without these families). Attributes:
        `key`, the key of the number of modes; `motion_converged`, 1 if all marches have the same
        regime.

    Raises:
        UserError: a march failed.
    """
    key = build_stage(case).basis.key
    compared = _compared(case, key, list(modes), store, progress)
    stages = [build_stage(with_values(case, {key: count})) for count in modes]
    data = compared.rename({"refined": "modes"}).assign_coords(
        modes=("modes", np.array(modes), {"long_name": key})
    )
    data["kept"] = "modes", [stage.basis.used for stage in stages]
    errors = [stage.frequency_error for stage in stages]
    worst = [max((error[k] for k in FAMILIES if k in error), default=np.nan) for error in errors]
    data["frequency_error"] = "modes", worst, {"units": "1"}
    return data.assign_attrs(
        title="convergence in the modes",
        key=key,
        motion_converged=int(len(set(data["regime"].values)) == 1),
    )


OFF_THE_LAW = 0.3
"""Limit of the root mean square deviation from the fitted power law, in the natural logarithm of
the changes: exp(0.3), about 4/3."""


def observed_order(size: FloatArray, change: FloatArray) -> float:
    """Compute the order p with which results approach the limit of size zero.

    If the error is C size^p, successive results differ by C (size_i^p - size_(i+1)^p), for any
    ratios of the sizes; p is a least-squares fit of this law to the logarithms of the changes.

    Args:
        size: sizes in descending order, such as time steps, (sizes,).
        change: change of the result from each size to the next, (sizes,); the last one is ignored.

    Returns:
        p, between -8 and 8; NaN if there are fewer than two changes above zero, if the changes are
        not monotone, or if they deviate from the law by more than `OFF_THE_LAW`.
    """
    positive = change[:-1] > 0.0  # False for NaN
    if np.count_nonzero(positive) < 2:
        return float("nan")
    logarithm, finer = np.log(change[:-1][positive]), np.log(size[1:][positive])
    ratio = np.log(size[:-1] / size[1:])[positive]
    if len(set(np.sign(np.diff(logarithm - np.log(ratio))))) > 1:
        return float("nan")

    def scatter(order: float) -> float:
        grown = ratio if order == 0.0 else np.expm1(order * ratio) / order
        return float(np.var(logarithm - order * finer - np.log(grown)))

    fit = minimize_scalar(scatter, bounds=(-8.0, 8.0), options={"xatol": 1e-9})
    return float(fit.x) if fit.fun <= OFF_THE_LAW**2 else float("nan")


def _compared(
    case: Case, key: str, values: Sequence[float], store: RunStore, progress: Progress | None
) -> xr.Dataset:
    """March a case with each value of a key; return differences from the last, finest march."""
    cases = [with_values(case, {key: value}) for value in values]
    store.make(cases, progress)
    failures = [
        f"{key} = {value:g}: {store.failures[run_key(one)]}"
        for value, one in zip(values, cases, strict=True)
        if run_key(one) in store.failures
    ]
    if failures:
        raise UserError("; ".join(failures))
    with ExitStack() as results:
        motions = [Motion(results.enter_context(open_result(store.path(one)))) for one in cases]
        finest = motions[-1]
        regime, impulses = (
            [MEASURES[name](motion) for motion in motions] for name in ("regime", "contact_impulse")
        )
        impulse, finer = np.array(impulses), list(pairwise(motions))
        free = min(motion.first_contact for motion in motions)
        columns = {
            "regime": regime,
            "radius_max": [np.linalg.norm(motion.places, axis=-1).max() for motion in motions],
            "contact_impulse": impulse,
            "distance": [motion_distance(motion, finest) for motion in motions],
            "impulse_error": _relative(impulse - impulse[-1], impulse[-1]),
            "step_distance": [*(motion_distance(*pair) for pair in finer), np.nan],
            "free_step_distance": [
                *(motion_distance(*pair, until=free) for pair in finer),
                np.nan,
            ],
            "step_impulse_error": [*_relative(np.diff(impulse), impulse[-1]), np.nan],
        }
        attributes = {name: finest.result.attrs[name] for name in ("speed", "reference_frequency")}
        attributes["case_title"] = finest.result.attrs["title"]
        attributes |= {"free_until": min(free, finest.end), "end": finest.end}
    return xr.Dataset(
        {
            name: ("refined", np.array(column), CONVERGENCE[name].attributes)
            for name, column in columns.items()
        },
        attrs=attributes,
    )


def _relative(difference: FloatArray, reference: float) -> FloatArray:
    """Return absolute differences divided by a reference; NaN if the reference is zero."""
    return np.abs(difference) / reference if reference else np.full(len(difference), np.nan)


def _document(data: xr.Dataset) -> dict[str, Any]:
    columns = {str(name): data[name].values.tolist() for name in [*data.coords, *data.data_vars]}
    return columns | data.attrs
