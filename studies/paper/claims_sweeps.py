"""Measures of claims on sweeps over speed (claims 18, 19, 27, 29, 34, 36, 38, 40, 41)."""

import numpy as np
import xarray as xr

from bladewhirl.models.case.file import loads
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.run.measures import Motion
from bladewhirl.studies.paper.claim import Measures, measures
from bladewhirl.studies.paper.claims_marches import MILLI, descending
from bladewhirl.studies.paper.trials import KAPPAS, NotTestableError

AROUND = (0.95, 1.15)  #: range of normalised speeds regarded as near the first coincidence, 1.05

HIGH = (1.42, 1.75)  #: normalised speeds with high amplitudes in the paper

LIMIT = 1.52
"""Normalised speed above which the paper's march of six modes diverges under imbalance."""

ROUNDING = 1e-9  #: rounding error of normalised speeds, for comparing their differences with a step


def done_points(sweep: xr.Dataset) -> xr.Dataset:
    """Return the part of a sweep with the speeds at which every point has a result."""
    done = sweep["state"] == "done"
    complete = done.all([name for name in done.dims if name != "march_speed"])
    return sweep.isel(march_speed=np.flatnonzero(complete.values))


def _radii(sweep: xr.Dataset, ends: tuple[float, float]) -> tuple[Array, Array, float]:
    """Return speeds, largest radii, and the median radius inside an interval divided by the
    median radius outside."""
    speed, radius = sweep["march_speed"].values, sweep["shaft_radius_max"].values
    inside = (speed >= ends[0]) & (speed <= ends[1])
    return speed, radius, float(np.median(radius[inside]) / np.median(radius[~inside]))


@measures(18)
def highest_around_the_coincidence(sweep: xr.Dataset) -> Measures:
    """Return the largest radius [mm], its speed, and the ratio of median radii near the first
    coincidence and at other speeds."""
    speed, radius, ratio = _radii(done_points(sweep), AROUND)
    peak = radius.argmax()
    return {"speed": float(speed[peak]), "radius": MILLI * radius[peak], "ratio": ratio}


@measures(19)
def other_critical_speeds(motion: Motion, sweep: xr.Dataset) -> Measures:
    """Return groups of divergent speeds, and the number of groups above the first coincidence."""
    done = done_points(sweep)
    speeds, divergent = done["march_speed"].values, done["regime"].values == "divergent"
    marks = np.flatnonzero(np.diff(np.concatenate([[0], divergent.astype(int), [0]])))
    groups = np.column_stack([speeds[marks[::2]], speeds[marks[1::2] - 1]]).tolist()  # neighbours
    texts = [f"{a:.4g}" if a == b else f"{a:.4g}–{b:.4g}" for a, b in groups]
    return {
        "regime": motion.regime.name,
        "groups": ", ".join(texts) or "none",
        "apart": sum(first > AROUND[1] for first, _ in groups),
    }


@measures(27)
def sustained_near_critical_speeds(sweep: xr.Dataset) -> Measures:
    """Return numbers of speeds by regime, and the share of the sustained speeds that are near
    divergent speeds."""
    done = done_points(sweep)
    speed, regime = done["march_speed"].values, done["regime"].values
    critical, sustained = speed[regime == "divergent"], speed[regime == "sustained"]
    apart = np.abs(np.subtract.outer(sustained, critical)).min(axis=1, initial=np.inf)
    near = int(np.count_nonzero(apart <= 0.1))
    return {
        "divergent": len(critical),
        "sustained": len(sustained),
        "damped": np.count_nonzero(regime == "damped"),
        "near": near,
        "share": near / max(len(sustained), 1),
    }


@measures(29)
def smaller_than_distortion(distortion: xr.Dataset, imbalance: xr.Dataset) -> Measures:
    """Compare radii under imbalance and distortion [mm], at speeds where distortion diverges."""
    first, second = done_points(distortion), done_points(imbalance)
    critical = first["march_speed"].values[first["regime"].values == "divergent"]
    speeds = np.intersect1d(critical, second["march_speed"].values)
    if not len(speeds):
        raise NotTestableError("no speed at which the casing distortion leads to divergence")
    radius, other = (s["shaft_radius_max"].sel(march_speed=speeds).values for s in (second, first))
    return {
        "speeds": len(speeds),
        "share": 100 * float(np.mean(radius < other)),
        "radius": MILLI * np.median(radius),
        "other_radius": MILLI * np.median(other),
    }


@measures(34)
def high_amplitudes_without_divergence(motion: Motion, sweep: xr.Dataset) -> Measures:
    """Return the ratio of median radii inside and outside the paper's interval, and the energy
    peak [J] of a march."""
    sweep = done_points(sweep)
    _, _, ratio = _radii(sweep, HIGH)
    total = motion.energies["total"].values
    return {
        "divergent": np.count_nonzero(sweep["regime"].values == "divergent"),
        "ratio": ratio,
        "regime": motion.regime.name,
        "bounded": not motion.diverges,
        "peak": float(total.max()),
        "time": float(motion.energies["time"].values[total.argmax()]),
    }


@measures(36)
def shifts_of_the_critical_speed(sweep: xr.Dataset) -> Measures:
    """Return shifts of the critical speed between coupling stiffnesses, relative to the step of the
    sweep.

    The critical speed is taken as the mean of the divergent speeds, because all divergent marches
    reach the same displacement limit. A shift counts only if it is larger than the step between
    speeds, which limits the accuracy.
    """
    critical = {kappa: middle_of_divergence(sweep, kappa) for kappa in KAPPAS}
    missing = [f"{kappa:g}" for kappa, speed in critical.items() if np.isnan(speed)]
    if missing:
        text = f"no speed diverges at {', '.join(missing)} N/m"
        return {"speeds": text, "missing": len(missing)}
    listed = ", ".join(f"{speed:.4g} at {kappa:g} N/m" for kappa, speed in critical.items())
    rises = np.diff(list(critical.values()))
    step = float(np.diff(sweep["march_speed"].values).max()) + ROUNDING
    if not any(abs(rises) > step):
        raise NotTestableError(
            f"critical speeds {listed} differ by less than the step of the sweep, {step:.3g}"
        )
    shifts = zip(KAPPAS[1:], rises / step, strict=True)
    return {"speeds": listed} | {f"shift_{kappa:g}": shift for kappa, shift in shifts}


def middle_of_divergence(sweep: xr.Dataset, kappa: float) -> float:
    """Return the mean of the divergent speeds at a coupling stiffness; NaN without divergence."""
    points = sweep.sel(coupling_stiffness=kappa)
    speeds = points["march_speed"].values[points["regime"].values == "divergent"]
    return float(speeds.mean()) if len(speeds) else np.nan


@measures(38)
def truncated_space_under_imbalance(motion: Motion, sweep: xr.Dataset) -> Measures:
    """Return shares of divergent points above and below the speed `LIMIT` [%]."""
    sweep = done_points(sweep)
    divergent = (sweep["regime"] == "divergent").transpose("march_speed", ...).values
    above = sweep["march_speed"].values > LIMIT
    return {
        "above": float(100 * divergent[above].mean()),
        "below": float(100 * divergent[~above].mean()),
        "leader": descending(motion.share(*motion.late))[0],
    }


@measures(40)
def sustained_radius(sweep: xr.Dataset) -> Measures:
    """Return the median of the mean radii of sustained motions in the last third of the march,
    divided by the clearance, the number of speeds, and the share of radii from 0.5 to 2."""
    clearance = loads(sweep.attrs["case"]).casing.clearance
    sweep = done_points(sweep)
    sustained = sweep["regime"].values == "sustained"
    if not sustained.any():
        raise NotTestableError("no sustained motion in the sweep of the casing distortion")
    history = sweep["radius_history"].isel(march_speed=sustained).values
    late = np.nanmean(history[:, -history.shape[1] // 3 :], axis=1) / clearance
    return {
        "median": np.median(late),
        "speeds": len(late),
        "share": float(np.mean((late >= 0.5) & (late <= 2.0))),
    }


@measures(41)
def first_family_at_every_speed(sweep: xr.Dataset) -> Measures:
    """Return the share of speeds with most energy in 1F, and the median energy share of the
    suspension [%]."""
    energy = done_points(sweep)["energy_mean"]
    names = energy["energy_group"].values.astype(str)
    family = energy.values[:, np.char.startswith(names, "1F")].sum(axis=1)
    suspension = energy.values[:, names == "suspension"].sum(axis=1)
    rest = energy.values[:, names == "rest"].sum(axis=1)
    share = float(np.mean(family > suspension + rest))
    return {
        "share": share,
        "percent": 100 * share,
        "speeds": len(family),
        "suspension": 100 * np.median(suspension / (family + suspension + rest)),
    }
