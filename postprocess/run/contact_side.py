"""Directions of the shaft and of the smallest clearance over time (the paper's Figs 18c, 21c)."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import in_window, span_starts, window_label
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.transforms import Frame
from bladewhirl.postprocess.shaft.whirl import FRAMES
from bladewhirl.solvers.stability.scenario import (
    STEADY,
    motion_scenario,
    shaft_lead,
    smallest_clearance_angle,
)

ALIKE = 1e-6
"""The gaps of all blades at a record are regarded as equal if their spread (largest minus smallest
gap) is below this fraction of the largest spread at any record."""

POINTS = 1200  #: largest number of drawn points of each phase
MOST_TURNS = 12.0  #: largest number of drawn turns; of a longer motion the last turns are drawn


def contact_phase(
    result: xr.Dataset,
    orbit: xr.Dataset | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
    since: float | None = None,
) -> xr.Dataset:
    """Compute the directions of the shaft and of the smallest clearance at every record, and the
    contact scenario of the run.

    If tips touch on one side, the direction of the smallest clearance is the mean direction of
    their contact impulses. Otherwise it is the angle of the tip with the smallest gap, which
    changes in steps of a blade pitch; nan if all gaps are equal.

    Args:
        result: result of a run.
        orbit: from `orbits.shaft_orbit`, for the same time window; computed when None.
        start, end: limits of the time window [s]; start and end of the run when None.
        since: time from which the scenario is determined [s]; `start` when None.

    Returns:
        Dataset over time: `shaft_phase` and `smallest_clearance_phase` [rad] in (-pi, pi], static
        frame; `shaft_lead` [rad], `shaft_phase` minus `smallest_clearance_phase`; all are nan where
        they are undefined; `impulse` [N s], the impulse of all contacts since the previous record.
        Attributes: `scenario` ("standard", "inverted", "unsteady" or "at rest"); `lead` [rad] and
        `steadiness`, averaged from `since` on, weighted by the impulse if a tip touched, see
        `solvers.stability.scenario`; `window`, the time from `since` on in words.
    """
    dataset = in_window(result, start, end)
    orbit = shaft_orbit(dataset if orbit is None else orbit, start=start, end=end)
    clearance, total = _clearance(dataset)
    shaft = orbit["rotating"].values
    lead = shaft_lead(shaft, clearance)
    time = dataset["time"].values
    judged = slice(0 if since is None else int(np.searchsorted(time, since)), None)
    kind, mean, steadiness = _scenario(shaft[judged], clearance[judged], total[judged])
    turned = rotation.angles(dataset)
    at = np.where(np.isnan(lead), np.nan, np.arctan2(shaft[:, 1], shaft[:, 0]))
    return labelled(
        dataset,
        "shaft and smallest clearance, static frame",
        {
            "shaft_phase": ("time", _wrapped(at + turned), "rad"),
            "smallest_clearance_phase": ("time", _wrapped(clearance + turned), "rad"),
            "shaft_lead": ("time", lead, "rad"),
            "impulse": ("time", total, "N s"),
            **rotation.histories(dataset),
        },
        {"time": time},
        window=window_label(dataset.isel(time=judged)),
        scenario=kind,
        lead=mean,
        steadiness=steadiness,
    )


def contact_scenario(dataset: xr.Dataset, orbit: xr.Dataset) -> tuple[str, float, float]:
    """Return the attributes `scenario`, `lead` and `steadiness` of `contact_phase`."""
    return _scenario(orbit.variables["rotating"].values, *_clearance(dataset))


def _clearance(dataset: xr.Dataset) -> tuple[Array, Array]:
    """Return the angle of the smallest clearance in rotating axes [rad], and the impulse of all
    contacts [N s], (time,) each; see `contact_phase`."""
    impulse, gap, tip = (
        dataset.variables[name].values for name in ("contact_impulse", "gap", "tip_angle")
    )
    total = impulse.sum(axis=1)
    push = impulse @ np.exp(1j * tip)
    on_one_side = (total > 0) & (np.abs(push) >= STEADY * total)
    spread = np.ptp(gap, axis=1)
    distinct = spread > ALIKE * spread.max(initial=0.0)
    nearest = np.where(distinct, smallest_clearance_angle(gap, tip), np.nan)
    return np.where(on_one_side, np.angle(push), nearest), total


def _scenario(shaft: Array, clearance: Array, impulse: Array) -> tuple[str, float, float]:
    weight = impulse if impulse.any() else None
    try:
        scenario = motion_scenario(shaft=shaft, clearance_angle=clearance, weight=weight)
    except ValueError:  # the shaft is at rest
        return "at rest", np.nan, 0.0
    return scenario.kind, scenario.lead, scenario.steadiness


@styled
def plot_contact_phase(phases: xr.Dataset) -> Figure:
    """Draw the phases of shaft and smallest clearance from `contact_phase`, and the angle by which
    the shaft leads.

    The phases are drawn in the frame in which the shaft makes fewer turns. If the shaft makes more
    than `MOST_TURNS` turns, only the last turns are drawn.
    """
    frame, since = _followed(phases)
    drawn = phases.sel(time=slice(since, None))
    shown = drawn.isel(time=span_starts(drawn["time"].values, POINTS))
    figure = new_figure(height=0.1)
    upper, lower = figure.subplots(2, sharex=True)
    carried = rotation.angles(shown) if frame == "rotating" else 0.0
    for name, key, size in (("smallest clearance", "contact", 3.6), ("shaft", "rotor", 1.4)):
        phase = np.degrees(_wrapped(shown[f"{name.replace(' ', '_')}_phase"].values - carried))
        upper.plot(shown["time"], phase, ".", color=COLOURS[key], markersize=size, label=name)
    upper.set_ylabel(f"phase in the\n{frame} frame [°]")
    lead = np.degrees(shown["shaft_lead"])
    touching = shown["impulse"].values > 0.0
    looks = (
        (~touching, "rest", "difference, no contact"),
        (touching, "rotor", "difference, contact"),
    )
    for here, colour, name in looks:
        if here.any():
            look = {"color": COLOURS[colour], "markersize": 1.4}
            lower.plot(shown["time"][here], lead[here], ".", label=name, **look)
    lower.axhspan(
        -90, 90, color=COLOURS["rest"], alpha=0.25, linewidth=0, zorder=0, label="standard: ±90°"
    )
    lower.set_ylabel("shaft ahead of\nsmallest gap [°]")
    for axes in (upper, lower):
        axes.set(ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180))
    time_axis(upper, lower)
    figure.legend(loc="outside lower center", ncols=2, markerscale=2)
    lower.set_xlabel(f"{lower.get_xlabel()}\n{_words(phases)}")
    head(figure, phases)
    return figure


def _followed(phases: xr.Dataset) -> tuple[Frame, float]:
    """Return the frame in which the shaft makes fewer turns, and the time [s] from which the phase
    is drawn.
    """
    moving = phases["shaft_phase"].dropna("time")
    time, angle = moving["time"].values, np.unwrap(moving.values)
    turned_by = rotation.angles(phases.sel(time=time))
    if not len(time):
        return "static", float(phases["time"][0])
    turned = {"rotating": np.unwrap(moving.values - turned_by), "static": angle}
    frame = min(FRAMES, key=lambda name: np.ptp(turned[name]))
    ahead = np.abs(turned[frame] - turned[frame][-1]) <= MOST_TURNS * 2 * np.pi
    return frame, float(time[np.argmax(np.logical_and.accumulate(ahead[::-1])[::-1])])


def _words(phases: xr.Dataset) -> str:
    kind = phases.attrs["scenario"]
    if kind == "at rest":
        return "the shaft is at rest"
    contact = f"{kind} contact" if phases["impulse"].any() else "no contact"
    lead = f"{np.degrees(phases.attrs['lead']).round() + 0.0:.0f}°".replace("-", "−")
    return f"{contact}, shaft ahead by {lead} on average"


def _wrapped(angle: Array) -> Array:
    return np.asarray(np.angle(np.exp(1j * angle)))
