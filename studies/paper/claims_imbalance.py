"""Claims of Section 4.3.2: contact begun by an imbalance (29 to 34, 44, 45)."""

from __future__ import annotations

import numpy as np
import xarray as xr

from bladewhirl.postprocess.run.measures import Motion
from bladewhirl.studies.paper.claim import (
    Check,
    Finding,
    at_least,
    at_most,
    between,
    equal,
    evaluates,
    near,
)
from bladewhirl.studies.paper.trials import NotTestableError

MILLI, MICRO = 1e3, 1e6

HIGH = (1.42, 1.75)
"""Normalised speeds with high amplitudes in the paper."""

STEADY_FROM = 1.1
"""Time after which the paper's orbit is steady [s]."""

STEADY_RATE = 0.1
"""Growth or decay of a ripple that is steady, at most [1/s]: a tenth in a second."""


def done_points(sweep: xr.Dataset) -> xr.Dataset:
    """The speeds of a sweep at which every point has a result."""
    done = sweep["state"] == "done"
    whole = done.all([name for name in done.dims if name != "march_speed"])
    return sweep.isel(march_speed=np.flatnonzero(whole.values))


def in_contact(motion: Motion) -> Check:
    """Judge the side of contact and the blades; not testable without late contact."""
    text = "contact in the last third" if motion.touches_late else "no contact in the last third"
    return Check(text=text, met=motion.touches_late, essential=True)


@evaluates(29)
def smaller_than_distortion(distortion: xr.Dataset, imbalance: xr.Dataset) -> Finding:
    first, second = done_points(distortion), done_points(imbalance)
    critical = first["march_speed"].values[first["regime"].values == "divergent"]
    speeds = np.intersect1d(critical, second["march_speed"].values)
    if not len(speeds):
        raise NotTestableError("no speed at which the casing distortion leads to divergence")
    radius = [each["shaft_radius_max"].sel(march_speed=speeds).values for each in (second, first)]
    share = float(np.mean(radius[0] < radius[1]))
    return Finding(
        ours=f"smaller at {100 * share:.0f} % of {len(speeds)} speeds, median"
        f" {MILLI * np.median(radius[0]):.3g} against {MILLI * np.median(radius[1]):.3g} mm",
        checks=(at_least("share of divergent speeds with less", 100 * share, 80.0, " %"),),
    )


@evaluates(30)
def limit_cycle(motion: Motion) -> Finding:
    """Judge a limit cycle by the ripple, not by the mean radius."""
    mean, size = motion.radius_between(*motion.late)
    growth = motion.regime.ripple
    checks = [
        equal("regime", motion.regime.name, "sustained", essential=True),
        near("mean radius", MILLI * mean, 1.1, 0.15, " mm"),
        between("ripple", MILLI * size, 0.05, 0.2, " mm"),
    ]
    words = ""
    if growth is not None:
        words = f", growing by {growth.text} 1/s"
        steady = abs(growth.rate) <= STEADY_RATE
        text = f"growth rate of the ripple {growth.text} 1/s, expected {STEADY_RATE:g} 1/s or less"
        checks.append(Check(text=text, met=steady, essential=True))
    if motion.end > STEADY_FROM:
        middle = 0.5 * (STEADY_FROM + motion.end)
        before = motion.ripple_between(STEADY_FROM, middle)
        after = motion.ripple_between(middle, motion.end)
        checks.append(near("ripple from 1.1 s over that at the end", before / after, 1.0, 0.2))
    scatter = motion.section_scatter()
    checks.append(at_most("spread of the Poincaré map over the radius", scatter, 0.2))
    return Finding(
        ours=f"{motion.regime.name}, {MILLI * mean:.3g} mm, ripple {MILLI * size:.2g} mm{words}",
        checks=tuple(checks),
    )


@evaluates(31)
def suspension_leads(motion: Motion, other: Motion) -> Finding:
    energy = motion.energy(*motion.late)
    total = energy.pop("total")
    order = sorted(energy, key=lambda name: -energy[name])
    ratio = other.energy(*other.late)["total"] / total
    return Finding(
        ours=f"{order[0]} {energy[order[0]]:.3g} J, {order[1]} {energy[order[1]]:.3g} J; distortion"
        f" {ratio:.3g} times that",
        checks=(
            equal("most energy in", order[0], "suspension"),
            equal("then in", order[1], "k = 1"),
            between("energy under distortion over that", ratio, 3.0, 30.0),
        ),
    )


@evaluates(32)
def three_kinds_of_blades(motion: Motion) -> Finding:
    blades = motion.blades
    return Finding(
        ours=", ".join(f"{count} {name}" for name, count in blades.items()),
        checks=(
            in_contact(motion),
            at_least("in permanent contact", blades["permanent"], 2),
            near("in intermittent contact", blades["intermittent"], 2, 0),
            at_least("free", blades["free"], 11),
        ),
    )


@evaluates(33)
def contact_with_the_shaft(motion: Motion) -> Finding:
    return Finding(
        ours=f"{motion.scenario}, shaft leads by {motion.lead:.0f}°",
        checks=(in_contact(motion), equal("contact", motion.scenario, "standard")),
    )


@evaluates(34)
def high_amplitudes_without_divergence(motion: Motion, sweep: xr.Dataset) -> Finding:
    sweep = done_points(sweep)
    speed, radius = sweep["march_speed"].values, sweep["shaft_radius_max"].values
    inside = (speed >= HIGH[0]) & (speed <= HIGH[1])
    divergent = int(np.count_nonzero(sweep["regime"].values == "divergent"))
    ratio = float(np.median(radius[inside]) / np.median(radius[~inside]))
    total = motion.energies["total"].values
    peak = float(total.max())
    when = float(motion.energies["time"].values[total.argmax()])
    return Finding(
        ours=f"{divergent} divergent speeds; at 1.6 {motion.regime.name}, peak {peak:.3g} J at"
        f" {when:.2g} s",
        checks=(
            at_most("divergent speeds of the sweep", divergent, 0),
            at_least("median radius inside over that outside", ratio, 1.5),
            Check(text=f"at 1.6 {motion.regime.name}", met=not motion.diverges),
            between("peak energy at 1.6", peak, 400.0, 1600.0, " J"),
            between("time of the peak", when, 1.6, 2.4, " s"),
        ),
    )


@evaluates(44)
def casing_hardly_moves(motion: Motion) -> Finding:
    size = MICRO * motion.casing_motion
    return Finding(
        ours=f"{size:.3g} µm", checks=(between("largest casing motion", size, 3.0, 30.0, " µm"),)
    )


@evaluates(45)
def course_at_high_speed(motion: Motion, long: Motion, usual: Motion) -> Finding:
    early = motion.share(0.0, 0.2)
    leader = max(early, key=lambda name: early[name])
    other = motion.share(0.0, motion.end)["other k"]
    ratio = long.energy(*long.late)["total"] / usual.energy(*usual.late)["total"]
    return Finding(
        ours=f"{leader} first; other k {100 * other:.2g} %; at the end of {long.end:.3g} s"
        f" {long.regime.name}, {ratio:.3g} times the energy at 1.05",
        checks=(
            equal("leader of the first 0.2 s", leader, "suspension"),
            at_least("share of other k", 100 * other, 5.0, " %"),
            equal("long run", long.regime.name, "sustained"),
            between("its late energy over that at 1.05", ratio, 0.1, 10.0),
        ),
    )
