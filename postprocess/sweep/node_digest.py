"""Reduction of the result of a superelement to the data of a sweep."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.nodes import (
    DIRECTIONS,
)
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run.node_summary import smallest_node_clearance, summarise_nodes
from bladewhirl.postprocess.sweep.dataset import NATURAL, WINDOW_SHARE, Layout
from bladewhirl.postprocess.sweep.digest import (
    Digest,
    coded,
    magnitudes,
    padded,
    span_starts,
    wear_numbers,
)

TANGENTIAL = DIRECTIONS.index("tangential")


def node_digest(dataset: xr.Dataset, report: Mapping[str, float], layout: Layout) -> Digest:
    """Reduce the result of a superelement to the data of a sweep.

    Args:
        dataset: the result.
        report: quality measures of the march, as for `summarise_nodes`.
        layout: sizes of the arrays; elements without a value are NaN.
    """
    summary, late = summarise_nodes(dataset, report), late_part(dataset)
    time, energy = dataset["time"].values, dataset["energy"].values
    step = float(dataset.attrs["record_step"])
    first = len(time) - max(1, round(min(layout.window, WINDOW_SHARE * np.ptp(time)) / step))
    starts = span_starts(len(time), layout.samples)
    counts = np.diff(starts, append=len(time))
    moved = dataset["contact_displacement"].values
    radial = np.abs(moved[:, :, 0]).max(axis=1)
    late_steps = np.ptp(late["time"].values) / float(dataset.attrs["time_step"])
    share = late["contact_steps"].values[1:].sum(axis=0) / max(late_steps, 1.0)
    blade = dataset["blade"].values
    values = {
        "regime": summary.regime,
        "end_reason": summary.end_reason,
        "end_time": summary.end_time,
        "steps": summary.steps,
        "unsolved_steps": summary.unsolved_steps,
        "rotation_speed": dataset.attrs["speed"],
        "reference_frequency": dataset.attrs["reference_frequency"],
        "growth_rate": _number(summary.growth_rate),
        "growth_error": _number(summary.growth_rate_error),
        "smallest_clearance": smallest_node_clearance(dataset),
        "impulse_per_revolution": _number(summary.impulse_per_revolution),
        "contact_force_max": summary.contact_force_max["force"],
        "contact_share": padded(_by_blade(blade, np.array(summary.contact_share)), layout.blades),
        "late_contact_share": padded(_by_blade(blade, share), layout.blades),
        "displacement_max": max(summary.contact_displacement_max.values()),
        "late_displacement": np.abs(late["contact_displacement"].values).max(axis=(0, 1)),
        "casing_displacement_max": _number(summary.casing_displacement_max),
        **wear_numbers(dataset),
        "gap_violation_max": max(0.0, -summary.gap_min),
        "energy_residual": summary.energy_residual,
        "complementarity_residual": summary.complementarity_residual,
        "dt_over_critical": summary.dt_over_critical,
        "window_start": time[first],
        "natural_frequency": padded(_natural(dataset), NATURAL),
        "spectrum": _amplitudes(moved[first:, :, TANGENTIAL], step, layout.frequency),
        "energy_max": energy.max(),
        "history_time": padded(time[starts], layout.samples),
        "radial_history": padded(np.maximum.reduceat(radial, starts), layout.samples),
        "energy_history": padded(np.add.reduceat(energy, starts) / counts, layout.samples),
    }
    return coded(values, layout)


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _by_blade(blade: IntArray, share: Array) -> Array:
    """Return for each blade the largest share of time in contact among its contact nodes."""
    largest = np.zeros(int(blade.max()) + 1)
    np.maximum.at(largest, blade, share)
    return largest


def _natural(dataset: xr.Dataset) -> Array:
    """Return up to `NATURAL` of the lowest natural frequencies of the first copy [Hz]."""
    return np.asarray(np.sort(dataset["modal_frequency"].values[0])[:NATURAL] / (2.0 * np.pi))


def _amplitudes(motion: Array, step: float, frequency: Array) -> Array:
    """Return the amplitudes of the node that moves most, (frequencies,). `motion` (records, nodes)
    is the motion of all nodes; `frequency` [Hz] begins at zero."""
    node = int(np.abs(motion).max(axis=0).argmax())
    size = 2.0 * magnitudes(motion[:, node].astype(complex), step, frequency)
    return np.where(frequency == 0.0, 0.5 * size, size)
