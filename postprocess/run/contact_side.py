"""Directions of the shaft and of the smallest clearance over time (Figs 18c, 21c)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import (
    few_time_ticks,
    in_window,
    span_starts,
    window_label,
)
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, speed_label, styled
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.solvers.stability.scenario import (
    STEADY,
    motion_scenario,
    shaft_lead,
    smallest_clearance_angle,
)

POINTS = 1200
"""Points of a line of phases at most."""

TURNS, DRAWN_TURNS = 10.0, 4.0
"""Turns of the shaft from which its phase is drawn over the last few only: more can't be read."""


def contact_phase(
    result: xr.Dataset,
    orbit: xr.Dataset | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
    since: float | None = None,
) -> xr.Dataset:
    """Static angles of the shaft and of the smallest clearance at every record, and the scenario.

    Where tips touch on one side, the smallest clearance is the mean direction of their contact
    impulses: several gaps are zero then. Elsewhere it is that of the tip with the smallest gap, so
    it moves in steps of a blade pitch.

    Args:
        result: of a run.
        orbit: from `orbits.shaft_orbit`, of the same time; found where it is None.
        start: of the window [s]; of the run when None.
        end: of the window [s]; of the run when None.
        since: the scenario is that from this time on [s]; of all records when None.

    Returns:
        over time [rad]: `shaft_phase` and `smallest_clearance_phase` in (-pi, pi], static frame;
        `shaft_lead`, their difference, the same in any frame; nan where the shaft rests; `impulse`
        of all contacts since the record before [N s]. Attributes `scenario` ("standard",
        "inverted", "unsteady" or "at rest"), `lead` [rad] and `steadiness`: means over the time
        `window`, in words, weighted by the impulse if anything touched, see `solvers.scenario`.
    """
    dataset = in_window(result, start, end)
    orbit = shaft_orbit(dataset if orbit is None else orbit, start=start, end=end)
    impulse = dataset["contact_impulse"].values
    tip = dataset["tip_angle"].values
    total = impulse.sum(axis=1)
    push = impulse @ np.exp(1j * tip)
    on_one_side = (total > 0) & (np.abs(push) >= STEADY * total)
    nearest = smallest_clearance_angle(dataset["gap"].values, tip)
    clearance = np.where(on_one_side, np.angle(push), nearest)
    shaft = orbit["rotating"].values
    lead = shaft_lead(shaft, clearance)
    time = dataset["time"].values
    judged = slice(0 if since is None else int(np.searchsorted(time, since)), None)
    turned = dataset.attrs["speed"] * time
    at = np.where(np.isnan(lead), np.nan, np.arctan2(shaft[:, 1], shaft[:, 0]))
    return labelled(
        dataset,
        "shaft and smallest clearance, static frame",
        {
            "shaft_phase": ("time", _wrapped(at + turned), "rad"),
            "smallest_clearance_phase": ("time", _wrapped(clearance + turned), "rad"),
            "shaft_lead": ("time", lead, "rad"),
            "impulse": ("time", total, "N s"),
        },
        {"time": time},
        window=window_label(dataset.isel(time=judged)),
        **_scenario(shaft[judged], clearance[judged], total[judged]),
    )


def _scenario(shaft: Array, clearance: Array, impulse: Array) -> dict[str, str | float]:
    weight = impulse if impulse.any() else None
    try:
        found = motion_scenario(shaft=shaft, clearance_angle=clearance, weight=weight)
    except ValueError:  # the shaft rests
        return {"scenario": "at rest", "lead": np.nan, "steadiness": 0.0}
    return {"scenario": found.kind, "lead": found.lead, "steadiness": found.steadiness}


@styled
def plot_contact_phase(phases: xr.Dataset) -> Figure:
    """Draw the static phase of shaft and smallest clearance, and by how much the shaft leads.

    A shaft that goes round many times has its phase drawn over the last turns only.

    Args:
        phases: from `contact_phase`.
    """
    figure = new_figure(height=0.08)
    upper, lower = figure.subplots(2, 1, height_ratios=(1.4, 1.0))
    last = _thinned(_last_turns(phases))
    for name, key, size in (("smallest clearance", "contact", 3.6), ("shaft", "rotor", 1.4)):
        phase = np.degrees(last[f"{name.replace(' ', '_')}_phase"])
        upper.plot(last["time"], phase, ".", color=COLOURS[key], markersize=size, label=name)
    shown = _thinned(phases)
    lead = np.degrees(shown["shaft_lead"])
    lower.plot(shown["time"], lead, ".", color=COLOURS["k = 1"], markersize=1.4)
    band = lower.axhspan(-90, 90, color=COLOURS["rest"], alpha=0.25, linewidth=0, zorder=0)
    for axes, label in ((upper, "static phase [°]"), (lower, "shaft leads [°]")):
        axes.set(ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180), ylabel=label)
        few_time_ticks(axes)
    lower.set_xlabel("time [s]")
    upper.set_title(f"{_words(phases)}\n{speed_label(phases)}")
    handles, labels = upper.get_legend_handles_labels()
    figure.legend(
        [*handles, band],
        [*labels, "standard"],
        loc="outside lower center",
        ncols=3,
        markerscale=2,
    )
    return figure


def _last_turns(phases: xr.Dataset) -> xr.Dataset:
    """All of it, or the last turns of the shaft where it makes many."""
    moving = phases.isel(time=np.flatnonzero(~np.isnan(phases["shaft_phase"].values)))
    angle = np.unwrap(moving["shaft_phase"].values)
    if len(angle) == 0 or np.ptp(angle) <= TURNS * 2 * np.pi:
        return phases
    before = np.flatnonzero(np.abs(angle - angle[-1]) >= DRAWN_TURNS * 2 * np.pi)
    return phases.sel(time=slice(moving["time"].values[before[-1]], None))


def _thinned(phases: xr.Dataset) -> xr.Dataset:
    """No more records than are seen."""
    return phases.isel(time=span_starts(phases["time"].values, POINTS))


def _words(phases: xr.Dataset) -> str:
    kind = phases.attrs["scenario"]
    if kind == "at rest":
        return "the shaft rests"
    if kind == "unsteady":
        return f"no steady contact scenario over {phases.attrs['window']}"
    lead = f"{np.degrees(phases.attrs['lead']):.0f}°"
    return f"{kind} contact, shaft leads by {lead}\nover {phases.attrs['window']}"


def _wrapped(angle: Array) -> Array:
    return np.asarray(np.angle(np.exp(1j * angle)))
