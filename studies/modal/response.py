"""Steady response of the bladed disk to engine-order forces, without contact: Dataset, rows."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.mode_names import ALL
from bladewhirl.models.inputs.units import speed_of
from bladewhirl.models.rotation.at_speed import check_stable
from bladewhirl.models.stage.engine_order import complex_factors, unit_forces
from bladewhirl.models.stage.stage import Stage, build_stage, rotor_at
from bladewhirl.postprocess.modal.response import (
    amplitude,
    by_nodal_diameter,
    drawn_amplitudes,
    plot_response,
)
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, table

PEAKS = (
    Column("order", "engine order", "d"),
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("rpm", "[rpm]", ".1f"),
    Column("blade", "blade", "d"),
    Column("amplitude", "amplitude of the tip [mm]", ".4g", 1e3),
    Column("nodal_diameter", "nodal diameter", "d"),
)
"""Columns of the largest amplitude of each engine order."""


def response(
    case_or_stage: Case | Stage,
    *,
    speeds: Sequence[float | str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Compute the steady response to engine-order forces at many speeds, without contact.

    The equations are those of the time integration: modes, damping and rotation effects of the case
    at each speed. They are solved for the complex amplitude X of X exp(i r Omega t) of each engine
    order r; nothing is integrated in time. If the case has several excitations, only those of
    engine order are included; the motions of equal orders are added.

    Args:
        case_or_stage: a case with an excitation of the type "engine-order", or its stage.
        speeds: speeds of rotation, each a multiple of the reference frequency or text such as "2500
            rpm"; by default the speed of the case.
        progress: called with the numbers of speeds done and in total.

    Returns:
        over (speed, blade): complex `tip_tangential` and `tip_radial` [m]; over (speed, axis):
        complex `centre` [m], x and y in the rotating frame. With several engine orders, `order` is
        the first dimension. `speed` is in multiples of the reference frequency, with the coordinate
        `rpm`.

    Raises:
        CaseError: the case cannot be built at one of the speeds.
        UserError: no excitation is of engine order; the case selects modes; or the equations
            depend on time because of unequal shaft springs or springs to the casing.
    """
    stage = build_stage(case_or_stage) if isinstance(case_or_stage, Case) else case_or_stage
    loads = _engine_orders(stage)
    given = [stage.case.march.speed.given] if speeds is None else list(speeds)
    if not given:
        raise UserError("response: speeds []: expected at least one speed")
    multiples = [
        speed_of(each, f"response: speeds {each!r}").multiple(stage.reference_frequency)
        for each in given
    ]
    fastest = max(multiples, key=abs)
    if stage.turning is not None:
        at_speed, omega = {"march.speed": fastest}, fastest * stage.reference_frequency
        own = with_values(stage.case, at_speed)
        check_stable(own, stage.turning.matrices, omega, stage.reference_frequency)
    orders = list(dict.fromkeys(order for load in loads for order in load.order))
    units = [(load, unit_forces(stage.case, stage.disk, load)) for load in loads]
    answers = []
    for done, multiple in enumerate(multiples, 1):
        answers.append(_answers(stage, orders, units, multiple * stage.reference_frequency))
        if progress is not None:
            progress(done, len(multiples))
    blades = len(stage.rotor.tip_angle)
    tangential, radial, centre = (
        np.moveaxis(np.array([[each[i] for each in row] for row in answers]), 1, 0)
        for i in range(3)
    )
    names = "tangential displacement of the tip", "radial displacement of the tip"
    over = ("order", "speed", "blade")
    rpm = np.array(multiples) * stage.reference_frequency * 30.0 / np.pi
    data = xr.Dataset(
        {
            "tip_tangential": quantity(over, tangential, "m", f"{names[0]}, towards +theta"),
            "tip_radial": quantity(over, radial, "m", f"{names[1]}, outward"),
            "centre": quantity(("order", "speed", "axis"), centre, "m", "centre, rotating frame"),
        },
        coords={
            "order": ("order", orders),
            "speed": quantity("speed", np.array(multiples), "1", "normalised speed"),
            "rpm": quantity("speed", rpm, "rpm", "speed"),
            "blade": ("blade", np.arange(blades)),
            "axis": ("axis", ["x", "y"]),
        },
        attrs={
            "title": "response to engine-order forces",
            "case": stage.case.title,
            "reference_frequency_hz": stage.reference_frequency / (2.0 * np.pi),
            "rotation_effects": stage.case.rotation.effects,
        },
    )
    return data if len(orders) > 1 else data.isel(order=0)


def _engine_orders(stage: Stage) -> list[EngineOrder]:
    """Return the excitations of engine order; raise an error if the response is not defined."""
    given = stage.case.excitations
    loads = [load for load in given.values() if isinstance(load, EngineOrder)]
    if not loads:
        types = ", ".join(f'{key}.type = "{load.type}"' for key, load in given.items())
        raise UserError(f'{types}: expected "engine-order" for a response')
    if stage.rotor.anisotropy:
        raise UserError("response: expected equal shaft springs")
    if stage.kept.springs is not None:
        raise UserError("response: not allowed with springs between bladed disk and casing")
    if stage.case.reduction.modes != ALL:
        raise UserError(f'reduction.modes = "{stage.case.reduction.modes}": expected "{ALL}"')
    return loads


def _answers(
    stage: Stage,
    orders: Sequence[int],
    loads: Sequence[tuple[EngineOrder, FloatArray]],
    omega: float,
) -> list[tuple[ComplexArray, ...]]:
    """Return for each engine order the complex tangential and radial displacements of the tips, and
    the displacement of the centre [m], at the speed of rotation omega [rad/s].

    `loads` contains each excitation with the forces from `unit_forces`, (blades, size).
    """
    rotor, shapes = rotor_at(stage, omega)
    modal = [(load, unit @ shapes) for load, unit in loads]
    stiffness = np.diag(rotor.stiffness) + rotor.circulation_stiffness
    answers: list[tuple[ComplexArray, ...]] = []
    for order in orders:
        w = order * omega
        force = sum(
            load.amplitude * complex_factors(stage.disk, load, order) @ unit
            for load, unit in modal
            if order in load.order
        )
        dynamic = stiffness - w**2 * np.eye(len(stiffness)) + 1j * w * rotor.damping
        answer = np.linalg.solve(dynamic, force)
        parts = rotor.tip_tangential, rotor.tip_radial, rotor.centre
        answers.append(tuple(rows @ answer for rows in parts))
    return answers


def largest(data: xr.Dataset) -> list[dict[str, Any]]:
    """Return the largest amplitude of each engine order as a row, see `PEAKS`."""
    rows = []
    every = data if "order" in data.dims else data.expand_dims("order")
    for order in every["order"].values.tolist():
        one = every.sel(order=order)
        tips = amplitude(one)
        speed, blade = np.unravel_index(int(tips.values.argmax()), tips.shape)
        rows.append(
            {
                "order": order,
                "speed": float(one["speed"][speed]),
                "rpm": float(one["rpm"][speed]),
                "blade": int(blade),
                "amplitude": float(tips[speed, blade]),
                "nodal_diameter": int(by_nodal_diameter(one).values[speed].argmax()),
            }
        )
    return rows


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of `response`; complex numbers in the document are
    pairs of real and imaginary part."""
    pairs = {
        name: np.stack([data[name].values.real, data[name].values.imag], axis=-1).tolist()
        for name in ("tip_tangential", "tip_radial", "centre")
    }
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "order": np.atleast_1d(data["order"].values).tolist(),
        "speed": data["speed"].values.tolist(),
        "speed_rpm": data["rpm"].values.tolist(),
        **pairs,
        "largest": largest(data),
    }
    return Study(
        name="response",
        document=document,
        tables=[table(document["largest"], PEAKS, "Largest amplitudes of the tips")],
        figures=lambda: {"response": (plot_response(data), drawn_amplitudes(data))},
    )
