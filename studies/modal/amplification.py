"""Amplification of the response by mistuning, for many random patterns of blade stiffness.

For each pattern the stiffness of the blades is projected on the modes of the tuned bladed disk at
the speed of its largest amplitude, where the mistuned modes follow (Yang and Griffin 2001, J. Eng.
Gas Turbines Power 123(4)). Near this speed the stiffness changes linearly with the square of the
speed; a pattern then takes one or two eigenproblems and a few hundred evaluations of a sum over
modes, of which those near resonance are coupled by damping and by the change of the speed.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import binom
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]  # has no types

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.machine import cores
from bladewhirl.models.stage.blade_stiffness import (
    TunedRotor,
    drawn_factors,
    tuned_rotor,
    without_mistuning,
)
from bladewhirl.models.stage.build import Buildable, build_stage
from bladewhirl.models.superelements.reduction import root_of
from bladewhirl.postprocess.modal.response import largest_in_period
from bladewhirl.studies.modal.response import engine_orders, peak_rows, response
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, table

SHARES = (0.5, 0.95, 0.99)  #: shares of the patterns whose largest amplification is listed

CONFIDENCE = 0.95  #: confidence of the bands of these percentiles

WEAK = 0.02
"""Modes whose amplitude in resonance is below this fraction of the largest are not searched."""

COUPLED = 0.1
"""Modes whose dynamic stiffness without damping is below this fraction of the squared frequency of
the forces are solved together, others one by one."""

SWEEPS = 4
"""Corrections of the amplitudes near the peak by what the modes that are not near resonance do to
each other."""

ROUNDING = 1e-12  #: Coriolis forces below this fraction of all forces by velocities count as zero

NEAR = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
"""Speeds searched about the resonance of each mode, in half-power widths."""

REFINEMENTS, FINER = 6, 3.0
"""Number of times the speeds about the largest amplitude come closer, and by which factor."""

ROWS = (
    Column("order", "engine order", "d"),
    Column("tuned", "tuned amplitude [mm]", ".4g", 1e3),
    Column("tuned_rpm", "at [rpm]", ".1f"),
    Column("median", "50 %", ".3f"),
    Column("median_band", "band", ".3f"),
    Column("p95", "95 %", ".3f"),
    Column("p95_band", "band", ".3f"),
    Column("p99", "99 %", ".3f"),
    Column("p99_band", "band", ".3f"),
    Column("largest", "largest", ".3f"),
    Column("largest_rpm", "at [rpm]", ".1f"),
    Column("whitehead", "Whitehead", ".3f"),
)
"""Columns of the amplification of each engine order."""


def amplification(
    case_or_stage: Buildable,
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
        UserError: the case has no spread of the stiffness or no engine order, or a largest
            amplitude is at the end of the speeds, where it is no peak.
    """
    if draws < 1:
        raise UserError(f"response: draws {draws}: expected at least 1")
    given = case_or_stage if isinstance(case_or_stage, Case) else case_or_stage.case
    if given.joint:
        raise UserError("response: draws: joints do not act on patterns: expected no [[joint]]")
    factors = drawn_factors(given, draws)
    stage = build_stage(without_mistuning(given), blades=True)
    reference, loads = stage.reference_frequency, engine_orders(stage.case)
    if any(0 in load.order for load in loads):
        raise UserError("response: draws: expected engine orders of 1 or more; order 0 is static")
    equal = response(stage, speeds=speeds)
    rows = [peaks[0] for peaks in peak_rows(equal).values()]
    for row in rows:
        if row["place"].startswith("end"):
            raise UserError(
                "response: draws: expected speeds about a resonance: the largest amplitude of"
                f" engine order {row['order']} without mistuning, {row['rpm']:.0f} rpm, is no peak"
                f" but at the {row['place']}"
            )
    found = []
    for number, row in enumerate(rows):
        tuned = tuned_rotor(stage, loads, row["speed"] * reference)
        pattern = _Patterns(tuned, row["order"], equal["speed"].values * reference)
        with threadpool_limits(1, user_api="blas"), ThreadPoolExecutor(cores()) as pool:
            for done, one in enumerate(pool.map(pattern.largest, factors - 1.0), 1):
                found.append(one)
                if progress is not None:
                    progress(number * draws + done, len(rows) * draws)
    amplitude, blade, omega = (
        np.array(values).reshape(len(rows), draws) for values in zip(*found, strict=True)
    )
    _check_inside(rows, omega, equal["speed"].values * reference)
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
            "reference_frequency_hz": reference / (2.0 * np.pi),
            "whitehead_bound": 0.5 * (1.0 + np.sqrt(blades)),
            "stiffness_spread": given.bladed_disk.mistuning.stiffness_spread,
        },
    )


def _check_inside(rows: list[dict[str, Any]], omega: FloatArray, speeds: FloatArray) -> None:
    """Check that no largest amplitude of the patterns of each order is at an end of the speeds."""
    for row, found in zip(rows, omega, strict=True):
        for end in speeds[[0, -1]]:
            if count := int((np.abs(found - end) <= 1e-12 * abs(end)).sum()):
                raise UserError(
                    f"response: draws: expected speeds beyond {end * 30.0 / np.pi:.0f} rpm, where"
                    f" {count} of {len(found)} patterns have their largest amplitude of engine"
                    f" order {row['order']}, which is no peak"
                )


class _Patterns:
    """Amplitudes of the blades of a tuned rotor with other stiffness.

    About the speed o of the tuned peak, the modal amplitudes q of the engine order r at the speed w
    obey

        [H + (w^2 - o^2) M + i r w L + C^T Z C] q = F,       M = dK/d(w^2) - r^2 + i r G / o

        H = K + sum_j d_j B_j - (r o)^2 + i r o G

    with the stiffness K at o, that of the blades, B_j, the Coriolis forces G at o, which grow with
    the speed, the losses L, and the dampers of the shaft, which act on a few displacements C q. The
    unknowns are the amplitudes of the eigenvectors of H, which is Hermitian.
    """

    def __init__(self, tuned: TunedRotor, order: int, speeds: FloatArray) -> None:
        """Prepare matrices.

        Args:
            tuned: equal blades at the speed of their largest amplitude.
            order: engine order.
            speeds: speeds between whose first and last the largest amplitude is sought [rad/s].
        """
        rotor, disk, w = tuned.disk.rotor, tuned.disk, order * tuned.omega
        self._tuned, self._order, self._speeds = tuned, order, speeds
        means = np.eye(len(rotor.tip_radial)) if disk.tips is None else disk.tips
        self._rows = np.stack([means @ rotor.tip_tangential, means @ rotor.tip_radial])
        static = disk.static.get(order, np.zeros((1, 3 * len(rotor.tip_radial))))[0]
        self._static = np.stack([means @ static[1::3], means @ static[0::3]])
        self._dampers = rotor.dampers[rotor.dampers.any(axis=1)]
        self._impedance: Any = 1j * order * np.eye(len(self._dampers))
        if rotor.circulation and len(self._dampers):  # of dampers in the static frame
            self._impedance = self._impedance + np.array([[0.0, -1.0], [1.0, 0.0]])
        self._loads = np.column_stack([disk.forces[order], self._dampers.T])
        rates = replace(rotor, dampers=self._dampers[:0]).damping
        skew, one = 0.5 * (rates - rates.T), np.eye(len(rates))
        self._twice_ratio = 2.0 * tuned.damping_ratio
        modal = self._twice_ratio * root_of(tuned.damped)
        self._loss, skew = (
            part * bool(np.abs(part).max() > ROUNDING * np.abs(rates).max())
            for part in (rates - skew - modal, skew)
        )
        self._hermitian = np.diag(rotor.stiffness) - w**2 * one
        self._by_square: Any = tuned.slope
        if skew.any():
            self._hermitian = self._hermitian + 1j * w * skew
            self._by_square = tuned.slope + 1j * order / tuned.omega * skew
        self._turned = bool(skew.any()) or tuned.at_rest is not None
        self._coupled = self._turned or bool(self._by_square.any() or self._loss.any())

    def largest(self, change: FloatArray) -> tuple[float, int, float]:
        """Return the largest amplitude [m], its blade and its speed [rad/s] for relative changes of
        the stiffness of each blade, (blades,)."""
        tuned, order = self._tuned, self._order
        further = np.tensordot(change, tuned.blades, 1)
        squares, shapes = np.linalg.eigh(tuned.damped + further)
        roots = np.sqrt(np.maximum(squares, np.finfo(float).tiny))
        loss: Any = self._twice_ratio * np.diag(roots)
        growth = np.zeros(loss.shape)  # of the loss with the square of the speed
        if tuned.at_rest is None and tuned.slope.any():
            stiffer = shapes.T @ tuned.slope @ shapes / (roots[:, None] + roots)
            growth = self._twice_ratio * stiffer
        values = squares - (order * tuned.omega) ** 2
        if self._turned:
            values, vectors = np.linalg.eigh(self._hermitian + further)
            turn, shapes = vectors.conj().T @ shapes, vectors
            loss, growth = (turn @ each @ turn.conj().T for each in (loss, growth))
        back, by_square = shapes.conj().T, np.diag(np.full(len(values), -(float(order) ** 2)))
        if self._coupled:
            by_square = by_square + back @ self._by_square @ shapes
            loss = loss + back @ self._loss @ shapes
        loads, rows, dampers = back @ self._loads, self._rows @ shapes, self._dampers @ shapes

        def tips(omega: float, sweeps: int = 0) -> FloatArray:
            w, step = order * omega, omega**2 - tuned.omega**2
            parts = (step, by_square), (1j * w, loss), (1j * w * step, growth)
            alone = values + sum(factor * np.diag(part) for factor, part in parts)
            near = np.flatnonzero((np.abs(alone) < COUPLED * w**2) & self._coupled)
            among = np.ix_(near, near)
            system = np.diag(values[near]) + sum(factor * part[among] for factor, part in parts)

            def estimated(pushes: ComplexArray) -> ComplexArray:
                answer = pushes / alone[:, None]
                answer[near] = np.linalg.solve(system, pushes[near])
                return answer

            answer = estimated(loads)
            size = np.abs(answer).max()
            for _ in range(sweeps * self._coupled):
                known = sum(factor * (part @ answer) for factor, part in parts)
                correction = estimated(loads - values[:, None] * answer - known)
                before, size = size, np.abs(correction).max()
                if size > 0.5 * before:  # far from the tuned peak corrections may diverge
                    break
                answer += correction
            moved, by_dampers = answer[:, 0], answer[:, 1:]
            pushed = omega * self._impedance
            held = np.eye(len(pushed)) + pushed @ dampers @ by_dampers
            moved = moved - by_dampers @ np.linalg.solve(held, pushed @ (dampers @ moved))
            return np.asarray(largest_in_period(*(rows @ moved + self._static)))

        slope = np.diag(by_square).real
        lost = np.diag(loss).real + (np.abs(dampers) ** 2).sum(axis=0)
        met = tuned.omega**2 - values / slope
        rate = np.maximum(np.abs(order * tuned.omega * lost), np.finfo(float).tiny)
        reached = np.abs(loads[:, 0]) * np.abs(rows).max(axis=(0, 1)) / rate
        low, high = self._speeds[[0, -1]]
        close = (met > low**2) & (met < high**2)
        chosen = close & (reached > WEAK * reached[close].max(initial=0.0))
        at, width = np.sqrt(met[chosen]), np.abs(order * lost / slope)[chosen]
        sought = [tuned.omega, *(at[:, None] + width[:, None] * NEAR).ravel()]
        step = 0.5 * float(width.min(initial=high - low))
        if len(dampers):  # they can hold the centre, and so move resonances far
            sought, step = [*sought, *self._speeds], max(step, np.diff(self._speeds).max())
        best = max(np.clip(sought, low, high).tolist(), key=lambda omega: tips(omega).max())
        for done in range(REFINEMENTS):
            step /= FINER
            finer = np.clip(best + step * np.arange(-FINER, FINER + 1.0), low, high).tolist()
            sweeps = SWEEPS if done >= REFINEMENTS // 2 else 0
            best = max(finer, key=lambda omega: tips(omega, sweeps).max())
        amplitudes = tips(best, SWEEPS)
        return float(amplitudes.max()), int(amplitudes.argmax()), float(best)


def amplification_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each engine order: percentiles with bands of order statistics, which contain
    the percentile of all patterns with a probability of `CONFIDENCE`."""
    rows = []
    for order in data["order"].values.tolist():
        one, rpm = data.sel(order=order), 60.0 * float(data.attrs["reference_frequency_hz"])
        values = np.sort(one["amplification"].values)
        row = {
            "order": order,
            "tuned": float(one["tuned_amplitude"]),
            "tuned_rpm": rpm * float(one["tuned_speed"]),
            "largest": float(values[-1]),
            "largest_rpm": rpm * float(one["speed"].values[one["amplification"].values.argmax()]),
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
