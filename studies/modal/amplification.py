"""Amplification of the response by mistuning, for many random patterns of blade stiffness.

For each pattern the stiffness of the blades is projected on the modes of the tuned bladed disk at
the speed of its largest amplitude, where the mistuned modes follow (Yang and Griffin 2001, J. Eng.
Gas Turbines Power 123(4)). Near this speed the stiffness changes linearly with the square of the
speed; a pattern then takes one eigenproblem and a few hundred evaluations of a sum over modes.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import binom
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]  # has no types

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.machine import cores
from bladewhirl.models.stage.blade_stiffness import TunedRotor, drawn_factors, without_mistuning
from bladewhirl.models.stage.marched import Marchable, marched_stage
from bladewhirl.postprocess.modal.response import largest_in_period
from bladewhirl.studies.modal.response import engine_orders, peak_rows, response
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, table

SHARES = (0.5, 0.95, 0.99)  #: shares of the patterns whose largest amplification is listed

CONFIDENCE = 0.95  #: confidence of the bands of these percentiles

WEAK = 0.02
"""Modes whose amplitude in resonance is below this fraction of the largest are not searched."""

NEAR = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
"""Speeds searched about the resonance of each mode, in half-power widths."""

REFINEMENTS, FINER = 6, 3.0
"""Number of times the speeds about the largest amplitude come closer, and by which factor."""

ROWS = (
    Column("order", "engine order", "d"),
    Column("tuned", "tuned amplitude [mm]", ".4g", 1e3),
    Column("median", "50 %", ".3f"),
    Column("median_band", "band", ".3f"),
    Column("p95", "95 %", ".3f"),
    Column("p95_band", "band", ".3f"),
    Column("p99", "99 %", ".3f"),
    Column("p99_band", "band", ".3f"),
    Column("largest", "largest", ".3f"),
    Column("whitehead", "Whitehead", ".3f"),
)
"""Columns of the amplification of each engine order."""


def amplification(
    case_or_stage: Marchable,
    *,
    draws: int,
    speeds: Sequence[float | str],
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Compute the amplification by mistuning for many random patterns of blade stiffness.

    The amplification is the largest amplitude of a blade between the first and the last speed,
    divided by that of the tuned bladed disk. Patterns are those of
    `bladed_disk.mistuning.stiffness_spread` with the seed of the case and the seeds that follow.

    Args:
        case_or_stage: beams or a sector of a superelement with a spread of the stiffness and an
            excitation of engine order, see `response`.
        draws: number of patterns.
        speeds: speeds at which the tuned response is computed, see `response`.
        progress: called with the numbers of patterns done and in total.

    Returns:
        over (order, draw): `amplification`, `blade` of the largest amplitude and its `speed`
        (multiple of the reference frequency); over order: `tuned_amplitude` [m] and `tuned_speed`;
        the attribute `whitehead_bound`, (1 + sqrt N) / 2 for N blades.

    Raises:
        CaseError: the case cannot be built.
        UserError: the case has no spread of the stiffness or no engine order, or its modes are
            coupled by Coriolis forces or by a damping matrix.
    """
    if draws < 1:
        raise UserError(f"response: draws {draws}: expected at least 1")
    given = marched_stage(case_or_stage)
    factors = drawn_factors(given.case, draws)
    stage = marched_stage(without_mistuning(given.case))
    reference, loads = stage.reference_frequency, engine_orders(stage.case)
    if any(0 in load.order for load in loads):
        raise UserError("response: draws: expected engine orders of 1 or more; order 0 is static")
    equal = response(stage, speeds=speeds)
    rows = [peaks[0] for peaks in peak_rows(equal).values()]
    ends = float(equal["speed"][0]) * reference, float(equal["speed"][-1]) * reference
    found = []
    for number, row in enumerate(rows):
        tuned = stage.tuned_rotor(loads, row["speed"] * reference)
        pattern = _Patterns(tuned, row["order"], ends)
        with threadpool_limits(1, user_api="blas"), ThreadPoolExecutor(cores()) as pool:
            for done, one in enumerate(pool.map(pattern.largest, factors - 1.0), 1):
                found.append(one)
                if progress is not None:
                    progress(number * draws + done, len(rows) * draws)
    amplitude, blade, omega = (
        np.array(values).reshape(len(rows), draws) for values in zip(*found, strict=True)
    )
    tuned_amplitude = np.array([row["amplitude"] for row in rows])
    both, blades = ("order", "draw"), factors.shape[1]
    return xr.Dataset(
        {
            "amplification": quantity(
                both, amplitude / tuned_amplitude[:, None], "1", "amplification by mistuning"
            ),
            "blade": (both, blade.astype(np.int64)),
            "speed": quantity(both, omega / reference, "1", "normalised speed of the peak"),
            "tuned_amplitude": quantity("order", tuned_amplitude, "m", "tuned amplitude"),
            "tuned_speed": quantity("order", np.array([row["speed"] for row in rows]), "1"),
        },
        coords={"order": ("order", [row["order"] for row in rows])},
        attrs={
            "title": "amplification by mistuning",
            "case": stage.case.title,
            "whitehead_bound": 0.5 * (1.0 + np.sqrt(blades)),
            "stiffness_spread": given.case.bladed_disk.mistuning.stiffness_spread,
        },
    )


class _Patterns:
    """Amplitudes of the blades of a tuned rotor with other stiffness."""

    def __init__(self, tuned: TunedRotor, order: int, ends: tuple[float, float]) -> None:
        rotor, disk = tuned.disk.rotor, tuned.disk
        if rotor.by_velocity is not None or (len(rotor.dampers) and rotor.dampers.any()):
            raise UserError(
                'response: draws: expected modal damping only, with rotation.effects = "none" or'
                ' "centrifugal", and no dampers and no matrices damping and gyroscopic'
            )
        self._tuned, self._order, self._ends = tuned, order, ends
        self._ratio = rotor.damping_ratio
        self._force = disk.forces[order]
        means = np.eye(len(rotor.tip_radial)) if disk.tips is None else disk.tips
        self._rows = np.stack([means @ rotor.tip_tangential, means @ rotor.tip_radial])
        static = disk.static.get(order, np.zeros((1, 3 * len(rotor.tip_radial))))[0]
        self._static = np.stack([means @ static[1::3], means @ static[0::3]])

    def largest(self, change: FloatArray) -> tuple[float, int, float]:
        """Return the largest amplitude [m], its blade and its speed [rad/s] for relative changes of
        the stiffness of each blade, (blades,)."""
        tuned, order = self._tuned, self._order
        stiffness = np.diag(tuned.disk.rotor.stiffness) + np.tensordot(change, tuned.blades, 1)
        squares, shapes = np.linalg.eigh(stiffness)
        slope = np.einsum("im,im->m", shapes, tuned.by_speed @ shapes)
        rate = 2.0 * self._ratio * np.sqrt(np.maximum(squares, 0.0))
        force, rows = shapes.T @ self._force, self._rows @ shapes

        def tips(omega: FloatArray) -> FloatArray:
            w = order * omega[:, None]
            dynamic = (
                squares + (omega[:, None] ** 2 - tuned.omega**2) * slope - w**2 + 1j * w * rate
            )
            moved: ComplexArray = (force / dynamic) @ rows.transpose(0, 2, 1)
            moved = moved + self._static[:, None]
            return np.asarray(largest_in_period(*moved))

        met = (squares - tuned.omega**2 * slope) / (order**2 - slope)
        reached = np.abs(force) * np.abs(rows).max(axis=(0, 1)) / np.maximum(rate, 1e-300)
        reached = reached / np.sqrt(np.maximum(squares, 1e-300))
        low, high = self._ends
        close = (met > low**2) & (met < high**2)
        chosen = close & (reached > WEAK * reached[close].max(initial=0.0))
        at = np.sqrt(met[chosen])
        width = rate[chosen] / order
        speeds = np.clip([tuned.omega, *(at[:, None] + width[:, None] * NEAR).ravel()], low, high)
        step = 0.5 * float(width.min(initial=high - low))
        best = speeds[int(tips(speeds).max(axis=1).argmax())]
        for _ in range(REFINEMENTS):
            step /= FINER
            near = np.clip(best + step * np.arange(-FINER, FINER + 1.0), low, high)
            best = near[int(tips(near).max(axis=1).argmax())]
        amplitudes = tips(np.array([best]))[0]
        return float(amplitudes.max()), int(amplitudes.argmax()), float(best)


def amplification_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each engine order: percentiles with bands of order statistics, which contain
    the percentile of all patterns with a probability of `CONFIDENCE`."""
    rows = []
    for order in data["order"].values.tolist():
        one = data.sel(order=order)
        values = np.sort(one["amplification"].values)
        row = {
            "order": order,
            "tuned": float(one["tuned_amplitude"]),
            "largest": float(values[-1]),
            "whitehead": data.attrs["whitehead_bound"],
            "draws": len(values),
        }
        for key, share in zip(("median", "p95", "p99"), SHARES, strict=True):
            ends = binom.interval(CONFIDENCE, len(values), share)
            low, high = max(int(ends[0]) - 1, 0), min(int(ends[1]), len(values) - 1)
            row[key] = float(np.quantile(values, share))
            row[f"{key}_band"] = [float(values[low]), float(values[high])]
        rows.append(row)
    return rows


def report(data: xr.Dataset) -> Study:
    """Return the document, table and figure of `amplification`."""
    rows = amplification_rows(data)

    def figures() -> Any:
        from bladewhirl.postprocess.modal.response import plot_amplification

        return {"amplification": (plot_amplification(data), data)}

    return Study(
        name="response",
        document={"amplification": rows, "stiffness_spread": data.attrs["stiffness_spread"]},
        tables=[table(rows, ROWS, f"Amplification by mistuning, {rows[0]['draws']} patterns")],
        figures=figures,
    )
