"""Reduction of the result of a superelement to the data of a sweep."""

from collections.abc import Mapping
from typing import Any

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

DIGESTED = (
    "regime end_reason end_time steps unsolved_steps growth_rate impulse_per_revolution"
    " casing_displacement_max energy_residual complementarity_residual dt_over_critical"
).split()
"""Fields of a summary that a sweep stores under the same name."""


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
    natural = dataset["modal_frequency"].values[0] / (2.0 * np.pi)  # of the first copy
    swing = moved[first:, :, TANGENTIAL]
    swing = swing[:, int(np.abs(swing).max(axis=0).argmax())]  # of the node that moves most
    spectrum = 2.0 * magnitudes(swing.astype(complex), step, layout.frequency)
    values = {
        **{name: _number(getattr(summary, name)) for name in DIGESTED},
        "rotation_speed": dataset.attrs["speed"],
        "reference_frequency": dataset.attrs["reference_frequency"],
        "growth_error": _number(summary.growth_rate_error),
        "smallest_clearance": smallest_node_clearance(dataset),
        "contact_force_max": summary.contact_force_max["force"],
        "contact_share": padded(_by_blade(blade, np.array(summary.contact_share)), layout.blades),
        "late_contact_share": padded(_by_blade(blade, share), layout.blades),
        "displacement_max": max(summary.contact_displacement_max.values()),
        "late_displacement": np.abs(late["contact_displacement"].values).max(axis=(0, 1)),
        **wear_numbers(dataset),
        "gap_violation_max": max(0.0, -summary.gap_min),
        "window_start": time[first],
        "natural_frequency": padded(np.sort(natural)[:NATURAL], NATURAL),
        "spectrum": np.where(layout.frequency == 0.0, 0.5 * spectrum, spectrum),
        "energy_max": energy.max(),
        "history_time": padded(time[starts], layout.samples),
        "radial_history": padded(np.maximum.reduceat(radial, starts), layout.samples),
        "energy_history": padded(np.add.reduceat(energy, starts) / counts, layout.samples),
    }
    return coded(values, layout)


def _number(value: Any) -> Any:
    return np.nan if value is None else value


def _by_blade(blade: IntArray, share: Array) -> Array:
    """Return for each blade the largest share of time in contact among its contact nodes."""
    largest = np.zeros(int(blade.max()) + 1)
    np.maximum.at(largest, blade, share)
    return largest
