"""Claims of Section 4.3.1: contact begun by a distortion of the casing (18 to 28, 39 to 43)."""

from __future__ import annotations

import numpy as np
import xarray as xr

from bladewhirl.models.case.file import loads
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.run.measures import Motion
from bladewhirl.studies.paper.claim import (
    Check,
    Finding,
    at_least,
    at_most,
    between,
    equal,
    evaluates,
)
from bladewhirl.studies.paper.claims_imbalance import MILLI, done_points, in_contact
from bladewhirl.studies.paper.trials import NotTestableError

AROUND = (0.95, 1.15)
"""Speeds that count as around the first coincidence, 1.05."""

EARLY = 0.5
"""End of the transient in the paper [s]."""


def _growing(motion: Motion) -> Check:
    return Check(text=f"regime {motion.regime.name}", met=motion.diverges, essential=True)


def _regimes(sweep: xr.Dataset) -> tuple[Array, Array]:
    """Speeds at which every point has a result, and what moved there."""
    done = done_points(sweep)
    return done["march_speed"].values, done["regime"].values


def _runs_of(speeds: Array, chosen: Array) -> list[tuple[float, float]]:
    """First and last of each group of neighbouring speeds."""
    marks = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    return [
        (float(speeds[a]), float(speeds[b - 1]))
        for a, b in zip(marks[::2], marks[1::2], strict=True)
    ]


def _listed(groups: list[tuple[float, float]]) -> str:
    words = [f"{a:.4g}" if a == b else f"{a:.4g}–{b:.4g}" for a, b in groups]
    return ", ".join(words) or "none"


@evaluates(18)
def highest_around_the_coincidence(sweep: xr.Dataset) -> Finding:
    sweep = done_points(sweep)
    speed, radius = sweep["march_speed"].values, sweep["shaft_radius_max"].values
    at = float(speed[radius.argmax()])
    near = (speed >= AROUND[0]) & (speed <= AROUND[1])
    ratio = float(np.median(radius[near]) / np.median(radius[~near]))
    return Finding(
        ours=f"largest at {at:.4g}: {MILLI * radius.max():.3g} mm",
        checks=(
            between("speed of the largest displacement", at, *AROUND),
            at_least("median radius there over that elsewhere", ratio, 1.5),
        ),
    )


@evaluates(19)
def other_critical_speeds(motion: Motion, sweep: xr.Dataset) -> Finding:
    speed, regime = _regimes(sweep)
    groups = _runs_of(speed, regime == "divergent")
    apart = [group for group in groups if group[0] > AROUND[1]]
    return Finding(
        ours=f"divergent at {_listed(groups)}; at 1.39 {motion.regime.name}",
        checks=(
            at_least("groups of divergent speeds apart from 1.05", len(apart), 1),
            equal("at 1.39", motion.regime.name, "divergent"),
        ),
    )


@evaluates(20)
def divergence_at_the_coincidence(motion: Motion) -> Finding:
    radius = MILLI * float(motion.radius[-1])
    planned = loads(motion.result.attrs["case"]).march.duration
    return Finding(
        ours=f"{motion.regime.name}, {radius:.3g} mm at {motion.end:.3g} s",
        checks=(
            _growing(motion),
            between("end of the march", motion.end, 0.999 * planned, planned, " s"),
            between("radius at the end", radius, 1.8, 7.2, " mm"),
        ),
    )


@evaluates(21)
def backward_in_rotating_axes(motion: Motion) -> Finding:
    whirl = motion.late_whirl("rotating")
    return Finding(
        ours=f"{motion.regime.name}, {whirl.text}",
        checks=(_growing(motion), equal("whirl", whirl.direction, "backward")),
    )


@evaluates(22)
def one_nodal_diameter_leads(motion: Motion) -> Finding:
    share = {name: 100 * value for name, value in motion.share(*motion.late).items()}
    leader = max(share, key=lambda name: share[name])
    return Finding(
        ours=f"{motion.regime.name}, "
        + ", ".join(f"{name} {value:.2g} %" for name, value in share.items()),
        checks=(
            _growing(motion),
            equal("leader", leader, "k = 1"),
            at_least("k = 0", share["k = 0"], 0.1, " %"),
            at_least("suspension", share["suspension"], 0.1, " %"),
            at_most("other k", share["other k"], 5.0, " %"),
        ),
    )


@evaluates(23)
def fast_growth(motion: Motion) -> Finding:
    """Fast is ten times the energy at the end of the transient, however far a march is followed."""
    if motion.end <= 2 * EARLY:
        raise NotTestableError(f"the march ended after {motion.end:.3g} s, in the transient")
    onset = motion.onset(10.0, EARLY)
    words = f"from {onset:.3g} s" if np.isfinite(onset) else "never"
    return Finding(
        ours=f"{motion.regime.name}, energy above ten times that at {EARLY:g} s {words}",
        checks=(
            _growing(motion),
            between("onset of fast growth", onset, 1.3, 2.6, " s"),
        ),
    )


@evaluates(24)
def suspension_matters_early(motion: Motion) -> Finding:
    if motion.end <= 1.5 * EARLY:
        raise NotTestableError(f"the march ended after {motion.end:.3g} s, in the transient")
    early = motion.share(0.0, EARLY)["suspension"]
    later = motion.share(EARLY, motion.end)["suspension"]
    return Finding(
        ours=f"{100 * early:.2g} % of the energy before, {100 * later:.2g} % after 0.5 s",
        checks=(
            at_least("suspension in the first 0.5 s", 100 * early, 10.0, " %"),
            at_most("its share later over that", later / (early or 1.0), 0.5),
        ),
    )


@evaluates(25)
def forward_in_static_axes(motion: Motion) -> Finding:
    whirl = motion.late_whirl("static")
    return Finding(
        ours=f"{motion.regime.name}, {whirl.direction}, {motion.scenario}, shaft leads by"
        f" {motion.lead:.0f}°",
        checks=(
            _growing(motion),
            in_contact(motion),
            equal("whirl", whirl.direction, "forward"),
            equal("contact", motion.scenario, "standard"),
            between("phase shift", abs(motion.lead), 5.0, 90.0, "°"),
        ),
    )


@evaluates(26)
def whirl_slows_down(motion: Motion) -> Finding:
    rates = np.abs(motion.late_whirl_rates)
    if not motion.diverges or len(rates) < 4:
        raise NotTestableError(f"{motion.regime.name} after {motion.end:.3g} s: too little growth")
    half = len(rates) // 2
    before, after = (float(part.mean() / 2 / np.pi) for part in (rates[:half], rates[-half:]))
    return Finding(
        ours=f"{before:.3g} Hz, then {after:.3g} Hz",
        checks=(at_most("later over earlier frequency", after / before, 0.9),),
    )


@evaluates(27)
def sustained_near_critical_speeds(sweep: xr.Dataset) -> Finding:
    speed, regime = _regimes(sweep)
    critical = speed[regime == "divergent"]
    sustained = speed[regime == "sustained"]
    damped = int(np.count_nonzero(regime == "damped"))
    apart = [float(np.abs(critical - s).min()) if len(critical) else np.inf for s in sustained]
    close = sum(each <= 0.1 for each in apart)
    return Finding(
        ours=f"{len(critical)} divergent, {len(sustained)} sustained ({close} of them within 0.1"
        f" of a divergent one), {damped} damped",
        checks=(
            at_least("sustained speeds", len(sustained), 1),
            at_least("damped speeds", damped, 1),
            at_least("share of sustained speeds near a divergent one", _share(close, apart), 0.8),
        ),
    )


@evaluates(28)
def clamped_centre(*motions: Motion) -> Finding:
    names = [motion.regime.name for motion in motions]
    regimes = dict(zip(("1.05", "1.39"), names, strict=True))
    return Finding(
        ours=", ".join(f"{name} at {speed}" for speed, name in regimes.items()),
        checks=tuple(equal(f"at {speed}", name, "damped") for speed, name in regimes.items()),
    )


@evaluates(39)
def ovalisation_leaves_the_centre(motion: Motion) -> Finding:
    largest = MILLI * float(motion.radius.max())
    contact = "contact" if motion.touched else "no contact"
    return Finding(
        ours=f"{largest:.2g} mm, {contact}",
        checks=(
            Check(text=contact, met=motion.touched),
            at_most("largest shaft displacement", largest, 1e-3, " mm"),
        ),
    )


@evaluates(40)
def sustained_radius(sweep: xr.Dataset) -> Finding:
    clearance = loads(sweep.attrs["case"]).casing.clearance
    sweep = done_points(sweep)
    chosen = sweep["regime"].values == "sustained"
    if not chosen.any():
        raise NotTestableError("no sustained motion in the sweep of the casing distortion")
    history = sweep["radius_history"].isel(march_speed=chosen).values
    late = np.nanmean(history[:, -history.shape[1] // 3 :], axis=1) / clearance
    share = float(np.mean((late >= 0.5) & (late <= 2.0)))
    return Finding(
        ours=f"median {np.median(late):.3g} clearances at {len(late)} speeds",
        checks=(at_least("share of radii from 0.5 to 2 clearances", share, 0.8),),
    )


@evaluates(41)
def first_family_at_every_speed(sweep: xr.Dataset) -> Finding:
    energy = done_points(sweep)["energy_mean"]
    names = energy["energy_group"].values.astype(str)
    family = energy.values[:, np.char.startswith(names, "1F")].sum(axis=1)
    suspension = energy.values[:, names == "suspension"].sum(axis=1)
    rest = energy.values[:, names == "rest"].sum(axis=1)
    first = float(np.mean(family > suspension + rest))
    return Finding(
        ours=f"1F holds most at {100 * first:.0f} % of {len(family)} speeds, the suspension"
        f" {100 * np.median(suspension / (family + suspension + rest)):.2g} % (median)",
        checks=(at_least("share of speeds with most energy in 1F", first, 0.95),),
    )


@evaluates(42)
def hardly_any_precession(motion: Motion) -> Finding:
    rate = abs(motion.late_whirl("static").rate) / motion.reference
    return Finding(
        ours=f"{motion.regime.name}, {rate:.3g} of the reference frequency",
        checks=(_growing(motion), at_most("whirl in static axes over ω₁", rate, 0.1)),
    )


@evaluates(43)
def higher_modes_early(motion: Motion) -> Finding:
    rest = 100 * motion.share(0.0, min(EARLY, motion.end))["rest"]
    return Finding(
        ours=f"{rest:.2g} % of the energy",
        checks=(at_least("share of higher modes before 0.5 s", rest, 1.0, " %"),),
    )


def _share(part: int, whole: list[float]) -> float:
    return part / len(whole) if whole else 0.0
