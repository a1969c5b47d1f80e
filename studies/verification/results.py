"""Balances of a run, computed only from its `result.nc`."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.case.template import dumps_case
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.shaft.whirl_history import whirl_history
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_to_file
from bladewhirl.studies.verification.case import Pair, Pairs, verifies

SMALL: Mapping[str, Any] = {
    "reduction.fixed_interface_modes": 22,
    "casing.elements": 20,
    "casing.support": 7.975e6,
    "casing.rotation": "free",
    "damping.ratio": 0.0,
    "contact.friction": 0.1,
    "march.time_step": 4e-6,
    "march.record_step": 4e-6,
    "march.duration": 0.012,
}
"""Case of a coarse stage without damping, with a record at every step."""


@cache
def recorded(**changes: Any) -> xr.Dataset:
    """March a stage with an initial velocity of the shaft until blades rub, and load the result.

    Args:
        changes: changes of the case, by keys with two underscores for a dot.
    """
    push = {"initial.centre_velocity": [1.5, 0.7]}
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    case = with_values(Case(), {**SMALL, **push, **keys})
    with TemporaryDirectory() as folder:
        path = Path(folder) / RESULT_NAME
        march_to_file(prepare(case), path, dumps_case(case))
        with open_result(path) as result:
            return result.load()


def rows(result: xr.Dataset) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return radial and tangential mode shapes at the tips, (tips, modes), and of the casing under
    the tips at every step, (steps, tips, modes)."""
    angle, tips = result["tip_angle"].values, result["tip_node"].values
    moved = rotate(result["rotor_shape"].values[tips, :2], -angle[:, None], axis=1)
    turned = angle + result.attrs["speed"] * result["time"].values[:, None]
    shape = result["casing_shape"].values
    around = np.concatenate([shape, shape[:1]])
    arc = np.linspace(0.0, 2.0 * np.pi, len(around))
    radius = result.attrs["casing_radius"]
    casing = [
        CubicHermiteSpline(arc, around[:, i], radius * around[:, i + 1])(np.mod(turned, 2 * np.pi))
        for i in (0, 2)
    ]
    return moved[:, 0], moved[:, 1], casing[0], casing[1]


def kicks(result: xr.Dataset, body: str) -> FloatArray:
    """Return the change of modal momentum over each step, minus the part due to elastic forces,
    (steps, modes)."""
    x, dt = result[f"{body}_displacement"].values, result.attrs["time_step"]
    frequency = result[f"{body}_frequency"].values
    bent = (x[2:] - 2.0 * x[1:-1] + x[:-2]) / dt
    return np.asarray(bent + dt * frequency**2 * x[1:-1])


@verifies()
def balances() -> Pairs:
    """Compare changes of momentum with contact impulses. Penetration and closed gaps are zero.

    Normal forces act inward on tips and outward on the casing. Friction acts backward on tips and
    forward on the casing, and its torque turns the casing.
    """
    result = recorded()
    radial, tangential, on_wall, along_wall = rows(result)
    normal, friction = (result[f"{name}_impulse"].values[2:] for name in ("contact", "friction"))
    pushed = np.einsum("tb,tbm->tm", normal, on_wall[2:])
    pushed += np.einsum("tb,tbm->tm", friction, along_wall[2:])
    casing = kicks(result, "casing")
    turning = np.flatnonzero(result["casing_nodal_diameter"].values == 0)
    mean = result["casing_shape"].values[:, 2][:, turning].mean(axis=0)
    most = np.argmax(np.abs(mean))
    turned = casing[:, turning[most]].sum() / mean[most]
    radius, gap = result.attrs["casing_radius"], result["gap"].values
    closed = gap[result["contact_impulse"].values > 0.0]
    on_disk = -normal @ radial - friction @ tangential
    return {
        "momentum_of_the_bladed_disk": (on_disk, kicks(result, "rotor")),
        "momentum_of_the_casing": (pushed, casing),
        "torque_on_the_casing": (0.1 * radius * normal.sum(), radius * turned),
        "penetration": (0.0, min(0.0, float(gap.min()))),
        "complementarity": (np.zeros_like(closed), closed),
    }


@verifies(1.05, -1.05)
def friction_ratio(speed: float) -> Pair:
    """Compare the ratio of friction to normal impulses with the coefficient of friction, which gets
    the sign of the speed."""
    result = recorded(march__speed=speed)
    normal, friction = (result[f"{name}_impulse"].values for name in ("contact", "friction"))
    ratio = friction[normal > 0.0] / normal[normal > 0.0]
    return np.full_like(ratio, 0.1 * np.sign(speed)), ratio


@verifies()
def energy_ledger() -> Pair:
    """Compare the error of the energy balance of a damped and loaded stage with zero."""
    result = recorded(damping__ratio=0.005, excitation__type="imbalance", coupling__stiffness=1e5)
    names = ("external_work", "normal_work", "friction_work", "coupling_work", "damping_work")
    terms = np.array([result[name].values for name in names])
    work = terms[:4].sum(axis=0) - terms[4]
    energy = result["energy"].values
    return np.zeros_like(work), (energy - energy[0] - work) / np.abs([*terms, energy]).max()


@verifies("backward", "forward")
def circle(way: str) -> Pairs:
    """Compare the whirl rate of a circular orbit without contact in both frames with the suspension
    frequency. The labels of the whirl direction agree with the direction in which the shaft
    starts."""
    longer = {"march__duration": 0.1, "march__record_step": 4e-5}
    pair = {"reduction__modes": "suspension,casing:1", **longer}
    still = {"initial__centre_velocity": (0.0, 0.0), "march__duration": 1e-3}
    natural = float(recorded(**pair | still)["rotor_frequency"][0])
    rate = natural if way == "forward" else -natural
    start = {
        "initial__centre_displacement": (1e-4, 0.0),
        "initial__centre_velocity": (0.0, 1e-4 * rate),
    }
    result = recorded(**pair, **start)
    whirl, static = whirl_history(result), rate + result.attrs["speed"]
    rates, labels = (
        [whirl[name].sel(frame=frame).values for frame in ("rotating", "static")]
        for name in ("rate", "direction")
    )
    return {
        "circular_whirl": ([np.full_like(rates[0], rate), np.full_like(rates[1], static)], rates),
        "whirl_labels": (
            [np.full_like(labels[0], np.sign(rate)), np.full_like(labels[1], np.sign(static))],
            labels,
        ),
    }
