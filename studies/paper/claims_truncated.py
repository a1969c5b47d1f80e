"""Claims of Section 4.3.3: the truncated modal space and the coupling in it (35 to 38, 46)."""

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
from bladewhirl.studies.paper.claims_imbalance import MILLI, done_points
from bladewhirl.studies.paper.trials import KAPPAS, NotTestableError

LIMIT = 1.52
"""Normalised speed above which the paper's truncated space diverges under imbalance."""

ROUNDING = 1e-9
"""Rounding of normalised speeds, whose differences are compared with a step."""


@evaluates(35)
def truncated_space_diverges(six: Motion, full: Motion) -> Finding:
    energy = six.energy(*six.late)
    energy.pop("total")
    order = sorted(energy, key=lambda name: -energy[name])
    until = min(six.end, full.end)
    peak = [float(each.radius[: each.record_at(until)].max()) for each in (six, full)]
    ratio = peak[0] / peak[1]
    return Finding(
        ours=f"{six.regime.name}, {order[0]}, then {order[1]}; until {until:.3g} s the shaft moves"
        f" {MILLI * peak[0]:.3g} mm, in the full space {MILLI * peak[1]:.3g} mm",
        checks=(
            Check(text=f"regime {six.regime.name}", met=six.diverges, essential=True),
            equal("most energy in", order[0], "k = 1"),
            equal("then in", order[1], "suspension"),
            at_least("shaft displacement over that in the full space", ratio, 2.0),
        ),
    )


@evaluates(36)
def coupling_shifts_the_critical_speed(sweep: xr.Dataset) -> Finding:
    """Critical is the middle of the speeds that diverge: their peaks end at the same limit.

    It is known no better than to the step between the speeds, so a shift has to be larger.
    """
    critical = {kappa: middle_of_divergence(sweep, kappa) for kappa in KAPPAS}
    missing = [kappa for kappa, speed in critical.items() if np.isnan(speed)]
    if missing:
        listed = ", ".join(f"{kappa:g}" for kappa in missing)
        text = f"no speed diverges at {listed} N/m"
        return Finding(ours=text, checks=(Check(text=text, met=False),))
    words = ", ".join(f"{speed:.4g} at {kappa:g} N/m" for kappa, speed in critical.items())
    rises = np.diff([critical[kappa] for kappa in KAPPAS])
    grid = float(np.diff(sweep["march_speed"].values).max()) + ROUNDING
    if not any(abs(rises) > grid):
        raise NotTestableError(
            f"critical speeds {words} differ by less than the step of the sweep, {grid:.3g}"
        )
    steps = zip(KAPPAS[:-1], KAPPAS[1:], rises, strict=True)
    return Finding(
        ours=words,
        checks=tuple(
            Check(
                text=f"shift from {a:g} to {b:g} N/m {rise:.3g}, expected more than {grid:.3g}",
                met=rise > grid,
            )
            for a, b, rise in steps
        ),
    )


def middle_of_divergence(sweep: xr.Dataset, kappa: float) -> float:
    """Mean of the speeds of a sweep that diverge at a coupling stiffness; NaN if none does."""
    points = sweep.sel(coupling_stiffness=kappa)
    speeds = points["march_speed"].values[points["regime"].values == "divergent"]
    return float(speeds.mean()) if len(speeds) else np.nan


@evaluates(37)
def coupling_does_not_matter_to_imbalance(*motions: Motion) -> Finding:
    radii, ripples = np.transpose([motion.radius_between(*motion.late) for motion in motions])
    spread = float(np.ptp(radii) / radii.mean())
    regimes = sorted({motion.regime.name for motion in motions})
    return Finding(
        ours=f"{', '.join(regimes)}, {MILLI * radii[0]:.3g} mm, {100 * spread:.2g} % apart, ripple"
        f" {MILLI * ripples[0]:.2g} mm",
        checks=(
            equal("regime", ", ".join(regimes), "sustained", essential=True),
            at_most("difference of the radii", 100 * spread, 2.0, " %"),
            near("mean radius", MILLI * radii[0], 1.2, 0.15, " mm"),
            between("ripple", MILLI * ripples[0], 0.05, 0.2, " mm"),
        ),
    )


@evaluates(38)
def truncated_space_diverges_under_imbalance(motion: Motion, sweep: xr.Dataset) -> Finding:
    sweep = done_points(sweep)
    divergent = (sweep["regime"] == "divergent").transpose("march_speed", ...).values
    above = sweep["march_speed"].values > LIMIT
    shares = [float(100 * divergent[chosen].mean()) for chosen in (above, ~above)]
    share = motion.share(*motion.late)
    leader = max(share, key=lambda name: share[name])
    return Finding(
        ours=f"divergent at {shares[0]:.0f} % of the points above {LIMIT:g}, at"
        f" {shares[1]:.0f} % below; {leader} leads at 1.65",
        checks=(
            at_least("share of divergent points above", shares[0], 90.0, " %"),
            at_most("share of divergent points below", shares[1], 10.0, " %"),
            equal("leader at 1.65", leader, "k = 1"),
        ),
    )


@evaluates(46)
def coupling_does_not_change_the_motion(*motions: Motion) -> Finding:
    quiet = [m for m in motions if not m.touched]
    if quiet:
        raise NotTestableError("without contact there is no side of it")
    rates = [motion.late_whirl("rotating").rate / motion.reference for motion in motions]
    shares = np.array([list(motion.share(*motion.late).values()) for motion in motions])
    moved = float(np.abs(shares - shares[0]).max())
    sides = [motion.scenario for motion in motions]
    return Finding(
        ours=f"whirl {', '.join(f'{rate:.3g}' for rate in rates)} ω₁, energy shares at most"
        f" {100 * moved:.2g} points apart, contact {', '.join(sides)}",
        checks=(
            at_most("difference of the whirl in rotating axes over ω₁", float(np.ptp(rates)), 0.05),
            at_most("difference of energy shares", 100 * moved, 10.0, " points"),
            equal("contact sides", len(set(sides)), 1),
        ),
    )
