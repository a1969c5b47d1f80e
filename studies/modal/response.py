"""Steady response of the bladed disk to engine-order forces, without contact: Dataset, rows."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, cast

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.plausibility import stiffness_hints
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import speed_of
from bladewhirl.models.joints.limits import LIMITS, Ties
from bladewhirl.models.stage.build import Buildable, build_stage
from bladewhirl.models.stage.forced import ForcedRotor, Resonances, forced, orders_of
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.modal.response import (
    amplitude,
    at_peaks,
    by_limit,
    by_nodal_diameter,
    drawn_amplitudes,
    joined_limits,
    largest_in_period,
    plot_response,
)
from bladewhirl.studies.modal.response_peaks import peak_speeds, resonance_beyond
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, table

MOTIONS = {
    "tip_tangential": "tangential displacement of the tip, towards +theta",
    "tip_radial": "radial displacement of the tip, outward",
    "centre": "centre, rotating frame",
}
"""Variables of displacements with their long names."""

PEAKS = (
    Column("order", "engine order", "d"),
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("rpm", "[rpm]", ".1f"),
    Column("blade", "blade", "d"),
    Column("amplitude", "amplitude of the tip [mm]", ".4g", 1e3),
    Column("nodal_diameter", "nodal diameter", "d"),
    Column("place", "is"),
)
"""Columns of the peaks of each engine order."""


def response(
    case_or_stage: Buildable,
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

    Peaks between the speeds are found to 0.1 % of their amplitude, however narrow they are, if the
    speeds ascend: those of up to 12 resonances of each engine order with the largest amplitudes.

    Returns:
        over (speed, blade): complex `tip_tangential` and `tip_radial` [m]; over (speed, axis):
        complex `centre` [m], x and y in the rotating frame, if there is one. A tip with several
        contact nodes moves by their mean. Tips of a superelement with massless contact nodes have
        the static displacement by the modes that are left out. With several engine orders, `order`
        is the first dimension. `speed` is in multiples of the reference frequency, with the
        coordinate `rpm`. Over (peak, blade): complex `peak_tip_tangential` and `peak_tip_radial`
        [m], with the coordinates peak_order, peak_speed and peak_rpm. Over order:
        `resonance_beyond` [rpm], the next resonance if the largest amplitude at the speeds is at
        the first or the last of them, otherwise NaN. With [[joint]], `limit` is the first
        dimension: the joints are free, closed without friction, or stuck, and peaks have the
        coordinate peak_limit.

    Raises:
        CaseError: the case cannot be built at one of the speeds.
        UserError: no excitation is of engine order; the case selects modes; or the equations
            depend on time because of unequal shaft springs or springs to the casing.
    """
    stage = build_stage(case_or_stage)
    given = [stage.case.march.speed.given] if speeds is None else list(speeds)
    if not given:
        raise UserError("response: speeds []: expected at least one speed")
    reference = stage.reference_frequency
    multiples = [speed_of(each, f"response: speeds {each!r}").multiple(reference) for each in given]
    loads = engine_orders(stage.case)
    omegas = [multiple * reference for multiple in multiples]
    curves = {
        name: _Curve(view, stage, loads, omegas) for name, view in _views(stage, loads).items()
    }
    for done, disk in enumerate(forced(stage, loads, omegas), 1):
        for curve in curves.values():
            curve.add(disk)
        if progress is not None:
            progress(done, len(multiples))
    found = [curve.dataset(multiples, reference) for curve in curves.values()]
    data = (found[0] if len(found) == 1 else joined_limits(found, list(curves))).assign_attrs(
        title="response to engine-order forces",
        case=stage.case.title,
        reference_frequency_hz=reference / (2.0 * np.pi),
        rotation_effects=stage.case.rotation.effects,
        hints="; ".join(stiffness_hints(stage.case)),
    )
    return data if data.sizes["order"] > 1 else data.isel(order=0)


View = Callable[[ForcedRotor], ForcedRotor]
"""A function that returns a bladed disk with its joints in a linear limit."""


def _views(stage: Stage, loads: Sequence[EngineOrder]) -> dict[str, View]:
    """Return views of a bladed disk by the names of the linear limits of its joints; without
    joints, the bladed disk itself."""
    if not stage.case.joint:
        return {"": lambda disk: disk}
    ties = Ties.of(cast(Matrices, stage), loads)  # only superelements have joints
    return {name: partial(ties.held, directions=held) for name, held in LIMITS.items()}


class _Curve:
    """The response of a bladed disk in a view at speeds [rad/s]."""

    def __init__(
        self, view: View, stage: Stage, loads: Sequence[EngineOrder], omegas: Sequence[float]
    ) -> None:
        self._view, self._stage, self._loads, self._omegas = view, stage, loads, omegas
        self._orders = orders_of(loads)
        self._answers: list[list[dict[str, ComplexArray]]] = []
        self._near: dict[int, list[Resonances]] = {order: [] for order in self._orders}

    def add(self, disk: ForcedRotor) -> None:
        """Add the response at the next speed."""
        seen, omega = self._view(disk), self._omegas[len(self._answers)]
        self._answers.append([seen.motion(order, omega) for order in self._orders])
        for order in self._orders:
            self._near[order].append(seen.resonances(order, omega))

    def _at(self, omega: float) -> ForcedRotor:
        (disk,) = forced(self._stage, self._loads, [omega])
        return self._view(disk)

    def _height_at(self, order: int, omega: float) -> float:
        return _height(self._at(omega).motion(order, omega))

    def _beyond(self, order: int, heights: Sequence[float]) -> float:
        """Return the speed of the resonance beyond the end with the largest of some amplitudes."""
        omegas, last, most = self._omegas, len(heights) - 1, int(np.argmax(heights))
        if not order or not last or most not in (0, last):
            return float("nan")
        outward = float(np.sign(omegas[most] - omegas[last - most]))
        return resonance_beyond(
            partial(self._height_at, order),
            lambda w: self._at(w).resonances(order, w),
            order,
            omegas[most],
            outward,
        )

    def dataset(self, multiples: Sequence[float], reference: float) -> xr.Dataset:
        """Return the Dataset of `response` with all engine orders, without attributes.

        Args:
            multiples: speeds in multiples of the reference frequency.
            reference: reference frequency [rad/s].
        """
        answers, orders, omegas = self._answers, self._orders, self._omegas
        peaks = [
            (order, omega, self._at(omega).motion(order, omega))
            for order in orders
            if order and all(later > before for before, later in pairwise(omegas))
            for omega in peak_speeds(partial(self._height_at, order), omegas, self._near[order])
        ]
        further = [
            self._beyond(order, [_height(row[n]) for row in answers])
            for n, order in enumerate(orders)
        ]
        variables = {
            name: quantity(
                ("order", "speed", "axis" if name == "centre" else "blade"),
                np.moveaxis(np.array([[motion[name] for motion in row] for row in answers]), 1, 0),
                "m",
                MOTIONS[name],
            )
            for name in answers[0][0]
        }
        blades = variables["tip_radial"][1].shape[-1]
        at_peaks = {
            f"peak_{name}": quantity(
                ("peak", "blade"),
                np.array([motion[name] for _, _, motion in peaks]).reshape(-1, blades),
                "m",
                MOTIONS[name],
            )
            for name in ("tip_tangential", "tip_radial")
        }
        peak_at = np.array([omega for _, omega, _ in peaks])
        rpm = np.array(multiples) * reference * 30.0 / np.pi
        beyond = quantity(
            "order",
            np.array(further) * 30.0 / np.pi,
            "rpm",
            "speed of the resonance beyond the end with the largest amplitude",
        )
        return xr.Dataset(
            variables | at_peaks | {"resonance_beyond": beyond},
            coords={
                "order": ("order", orders),
                "speed": quantity("speed", np.array(multiples), "1", "normalised speed"),
                "rpm": quantity("speed", rpm, "rpm", "speed"),
                "blade": ("blade", np.arange(blades)),
                "peak_order": ("peak", np.array([order for order, _, _ in peaks], dtype=np.int64)),
                "peak_speed": quantity(
                    "peak", peak_at / reference, "1", "normalised speed of a peak"
                ),
                "peak_rpm": quantity("peak", peak_at * 30.0 / np.pi, "rpm", "speed of a peak"),
                **({"axis": ("axis", ["x", "y"])} if "centre" in variables else {}),
            },
        )


def _height(motion: Mapping[str, ComplexArray]) -> float:
    """Return the largest amplitude of a tip [m]."""
    return float(largest_in_period(motion["tip_tangential"], motion["tip_radial"]).max())


def engine_orders(case: Case) -> list[EngineOrder]:
    """Return the excitations of engine order; raise an error if there are none."""
    given = case.excitations
    loads = [load for load in given.values() if isinstance(load, EngineOrder)]
    if not loads:
        types = ", ".join(f'{key}.type = "{load.type}"' for key, load in given.items())
        raise UserError(f'{types}: expected "engine-order" for a response')
    return loads


def largest(data: xr.Dataset) -> list[dict[str, Any]]:
    """Return the largest amplitude of each engine order as a row, see `PEAKS`."""
    return [rows[0] for rows in peak_rows(data).values()]


def peak_rows(data: xr.Dataset) -> dict[int, list[dict[str, Any]]]:
    """Return rows of the peaks of each engine order, see `PEAKS`, the largest first; and of the
    largest amplitude at the given speeds, if it is larger than that of all peaks. `place` is
    "peak", "given speed" or "end of the range", with `resonance_rpm` if a resonance is beyond."""
    every = data if "order" in data.dims else data.expand_dims("order")
    found = {}
    for order in every["order"].values.tolist():
        grid = every.sel(order=order)
        peaks = at_peaks(data, order)
        rows = [_row(peaks, order, n) | {"place": "peak"} for n in range(peaks.sizes["speed"])]
        most, last = int(amplitude(grid).max("blade").values.argmax()), grid.sizes["speed"] - 1
        row = _row(grid, order, most) | {"place": "given speed"}
        if last and most in (0, last):
            row["place"] = "end of the range"
            beyond = float(grid["resonance_beyond"])
            if np.isfinite(beyond):
                row |= {"resonance_rpm": beyond}
                row["place"] += f", resonance at {beyond:.0f} rpm"
        if row["amplitude"] > max((each["amplitude"] for each in rows), default=0.0):
            rows.append(row)
        found[order] = sorted(rows, key=lambda each: -each["amplitude"])
    return found


def _row(one: xr.Dataset, order: int, speed: int) -> dict[str, Any]:
    tips = amplitude(one).transpose("speed", "blade").values[speed]
    return {
        "order": order,
        "speed": float(one["speed"][speed]),
        "rpm": float(one["rpm"][speed]),
        "blade": int(tips.argmax()),
        "amplitude": float(tips.max()),
        "nodal_diameter": int(by_nodal_diameter(one).values[speed].argmax()),
    }


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of `response`; complex numbers in the document are
    pairs of real and imaginary part. With joints, the document has those of each linear limit."""
    documents = {name: _document(each) for name, each in by_limit(data).items()}
    rows = [{**row, "limit": name} for name, own in documents.items() for row in own["peaks"]]
    columns = PEAKS if "" in documents else (Column("limit", "joints"), *PEAKS)
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "order": np.atleast_1d(data["order"].values).tolist(),
        "speed": data["speed"].values.tolist(),
        "speed_rpm": data["rpm"].values.tolist(),
        **(documents.get("") or {"limits": documents}),
    }
    return Study(
        name="response",
        document=document,
        tables=[table(rows, columns, "Peaks of the amplitudes of the tips")],
        figures=lambda: {"response": (plot_response(data), drawn_amplitudes(data))},
        hints=data.attrs["hints"],
    )


def _document(data: xr.Dataset) -> dict[str, Any]:
    """Return the amplitudes and peaks of a response without dimension `limit`."""
    pairs = {
        name: np.stack([data[name].values.real, data[name].values.imag], axis=-1).tolist()
        for name in MOTIONS
        if name in data
    }
    peaks = [row for rows in peak_rows(data).values() for row in rows]
    return {**pairs, "largest": largest(data), "peaks": peaks}
