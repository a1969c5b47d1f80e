"""Modal measures, marches and sweeps by which claims are judged; each is computed once."""

import math
from collections.abc import Mapping
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, cast

import xarray as xr

from bladewhirl.files import packaged_rows
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import CasingDistortion, Imbalance
from bladewhirl.models.case.file import override_values, with_values
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.run.measures import Motion
from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME, open_sweep
from bladewhirl.studies.modal.coupled_system import EvenSystem, couple_even
from bladewhirl.studies.paper.modal_numbers import modal_measures
from bladewhirl.studies.sweeps.cache import RunStore, run_key
from bladewhirl.studies.sweeps.plan import PLAN_NAME
from bladewhirl.studies.sweeps.sweep import Watch, resume_sweep, run_sweep

Load = Literal["distortion", "imbalance"]
"""Load that starts the contact: the paper's scenarios A and B."""

PERTURBATION = 1e-7
"""Relative change of the force from one repeat to the next. Near a threshold motions are chaotic,
so the repeats show whether a verdict depends on such a small change."""

QUICK_DURATION = 2.5
"""Duration of a quick march [s]. Marches with casing distortion at the normalised speed 1.05
diverge earlier, after 1.8 to 2.1 s."""

KAPPAS = (0.0, 500.0, 1000.0)
"""Coupling stiffnesses of the marches with six modes [N/m] (paper, Section 4.3.3)."""

CONTACT = {"casing.support": 7.975e6, "damping.ratio": 0.001}
"""Keys by which the stage of both scenarios differs from the stage of the modal analysis."""

CASES: Mapping[str, Case] = {
    "modal": Case(),
    "distortion": with_values(
        Case(title="Casing distortion of one nodal diameter"),
        {**CONTACT, "excitation": {"type": "casing-distortion", "duration": 0.01}},
    ),
    "imbalance": with_values(
        Case(title="Mass imbalance"), {**CONTACT, "excitation": {"type": "imbalance", "ramp": 0.1}}
    ),
}
"""Cases by scenario, as in examples/: the stage for the modal analysis, and the two loads that
start contact."""


class NotTestableError(Exception):
    """Claim that cannot be judged; the message states the reason."""


def changed(scenario: str, changes: Mapping[str, Any]) -> Case:
    """Return the case of a scenario with changed values, by dotted key.

    Changes of `excitation` that the load of this scenario does not have are ignored.

    Raises:
        CaseError: all faults of the new case.
    """
    case = CASES[scenario]
    [load] = case.excitations.values()
    keys = type(load).model_fields
    prefix = "excitation."
    values = {
        key: value
        for key, value in changes.items()
        if not key.startswith(prefix) or key.removeprefix(prefix) in keys
    }
    return with_values(case, values)


@dataclass(frozen=True, kw_only=True)
class Survey:
    """A sweep by which claims are judged."""

    load: Load
    speeds: tuple[float, float]  #: first and last speed, in multiples of the reference frequency
    step: float  #: step between speeds
    coarse_step: float  #: step between speeds in a coarse sweep
    changes: Mapping[str, Any] = field(default_factory=dict)  #: changes of the case, by dotted key
    #: keys swept in addition to the speed
    over: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def axes(self, *, coarse: bool, step: float | None = None) -> dict[str, list[float]]:
        """Return the values of all swept keys; the step between speeds is `step`, or, if `step` is
        None, the normal or the coarse step of the survey."""
        first, last = self.speeds
        step = step or (self.coarse_step if coarse else self.step)
        count = int((last - first) / step + 1e-9) + 1
        speeds = [round(first + step * number, 6) for number in range(count)]
        return {"march.speed": speeds, **{key: list(values) for key, values in self.over.items()}}


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A march by which claims are judged."""

    load: Load
    changes: Mapping[str, Any]  #: changes of the case, by dotted key
    length: float  #: factor on the duration of the case
    repeated: bool  #: whether each repeat of a claim has its own march, with a perturbed force


TRIALS: Mapping[str, Trial] = {
    row["name"]: Trial(
        load=cast(Load, row["load"]),
        changes=override_values(row["changes"].split("; ")),
        length=float(row["length"]),
        repeated=row["repeated"] == "yes",
    )
    for row in packaged_rows(__package__, "trials.csv")
}
"""Marches in trials.csv by name: a load of the paper, with changes of the case as by --set."""

SURVEYS: Mapping[str, Survey] = {
    row["name"]: Survey(
        load=cast(Load, row["load"]),
        speeds=(float(row["first"]), float(row["last"])),
        step=float(row["step"]),
        coarse_step=float(row["coarse step"]),
        changes=override_values([row["changes"]] if row["changes"] else []),
        over={"coupling.stiffness": KAPPAS} if row["over stiffness"] else {},
    )
    for row in packaged_rows(__package__, "surveys.csv")
}
"""Sweeps in surveys.csv by name: over speed, some of them also over `KAPPAS`."""


@dataclass(kw_only=True)
class Evidence(AbstractContextManager["Evidence"]):
    """Modal measures, marches and sweeps under one set of conditions; close it, or use ``with``."""

    directory: Path
    store: RunStore
    changes: Mapping[str, Any] = field(default_factory=dict)  #: changes of all cases, by dotted key
    quick: bool = False  #: whether marches are short and sweeps coarse
    speed_step: float | None = None  #: step of all sweeps over speed; None: step of each survey
    repeat: int = 0  #: number of the repeat, which determines the perturbation of the force
    _open: ExitStack = field(default_factory=ExitStack)
    _motions: dict[str, Motion] = field(default_factory=dict)
    _sweeps: dict[str, xr.Dataset] = field(default_factory=dict)

    def __exit__(self, *_: object) -> None:
        """Close all results."""
        self._motions.clear()
        self._sweeps.clear()
        self._open.close()

    @property
    def modal_case(self) -> Case:
        """Case of the modal analysis."""
        return changed("modal", self.changes)

    @cached_property
    def stage(self) -> ModalModel:
        """Finite element models and modes of the modal case."""
        return modal_model(self.modal_case)

    @cached_property
    def modal(self) -> Mapping[str, Any]:
        """Modal measures to which claims of the paper refer."""
        return modal_measures(self.modal_case, self.stage)

    @cached_property
    def system(self) -> EvenSystem:
        """The six coupled modes of the modal case, undamped as in Eq. (15)."""
        return couple_even(self.stage, modes="six", damped=False, with_pi=True, physical=False)

    def case(self, name: str) -> Case:
        """Return the case of a march, in this repeat."""
        trial = TRIALS[name]
        changes = {**self.changes, **trial.changes}
        repeat = self.repeat if trial.repeated else 0
        return perturbed(self._timed(changed(trial.load, changes), trial.length), repeat)

    def motion(self, name: str) -> Motion:
        """Return the measures of a march, which is computed on first use.

        Raises:
            NotTestableError: the march failed.
        """
        if name not in self._motions:
            case = self.case(name)
            if run_key(case) not in self.store.failures:
                self.store.make([case])
            if run_key(case) in self.store.failures:
                raise NotTestableError(f"{name}: {self.store.failures[run_key(case)]}")
            result = self._open.enter_context(open_result(self.store.path(case)))
            self._motions[name] = Motion(result)
        return self._motions[name]

    def sweep(self, name: str, watch: Watch | None = None) -> xr.Dataset:
        """Return a sweep, which is computed or completed on first use.

        Raises:
            NotTestableError: no point of the sweep could be marched.
        """
        if name in self._sweeps:
            return self._sweeps[name]
        survey = SURVEYS[name]
        case = self._timed(changed(survey.load, {**self.changes, **survey.changes}), 1.0)
        axes = survey.axes(coarse=self.quick, step=self.speed_step)
        points = math.prod(len(values) for values in axes.values())
        slug = name.replace(", ", "-").replace(" ", "-")
        directory = self.directory / f"{slug}-{run_key(case)}-{points}"
        options: dict[str, Any] = {
            "workers": self.store.workers,
            "scheduler": self.store.scheduler,
            "watch": watch,
        }
        if not (directory / PLAN_NAME).exists():
            run_sweep(case, axes, directory, **options)
        elif not is_complete(directory):
            resume_sweep(directory, **options)
        dataset = self._open.enter_context(open_sweep(directory))
        if not (dataset["state"] == "done").any():
            raise NotTestableError(f"{name}: no point of the sweep could be marched")
        self._sweeps[name] = dataset
        return dataset

    def _timed(self, case: Case, length: float) -> Case:
        duration = QUICK_DURATION if self.quick else case.march.duration
        return with_values(case, {"march.duration": length * duration})


def perturbed(case: Case, repeat: int) -> Case:
    """Return the case with the force changed by `repeat` times `PERTURBATION`."""
    if repeat == 0:
        return case
    factor = 1.0 + repeat * PERTURBATION
    load = case.excitation
    if isinstance(load, CasingDistortion):
        return with_values(case, {"excitation.modal_force": factor * load.modal_force})
    if not isinstance(load, Imbalance):
        return case
    if load.unbalance is not None:
        return with_values(case, {"excitation.unbalance": factor * load.unbalance})
    if load.clearance_speed is not None:
        # The force is proportional to the inverse square of this speed.
        speed = load.clearance_speed.value * factor**-0.5
        given = speed if load.clearance_speed.kind == "normalised" else f"{speed!r} rad/s"
        return with_values(case, {"excitation.clearance_speed": given})
    return case


def is_complete(directory: Path) -> bool:
    """Return whether every point of a sweep has a result."""
    if not (directory / SWEEP_NAME).exists():
        return False
    with open_sweep(directory) as dataset:
        return bool((dataset["state"] == "done").all())
