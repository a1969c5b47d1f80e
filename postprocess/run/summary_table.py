"""Summary of a run as rows of text."""

import numpy as np

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.energy.regimes import regime_title
from bladewhirl.postprocess.energy.strain import FIRST_FAMILY
from bladewhirl.postprocess.energy.works import Works
from bladewhirl.postprocess.run.extremes import StressPeak, StressSplit, WallPeak
from bladewhirl.postprocess.run.summary import (
    CriticalCrossing,
    EnergyHolders,
    LineOfWhirl,
    Summary,
)
from bladewhirl.postprocess.run.wear import lobes_text
from bladewhirl.postprocess.shaft.transforms import Frame
from bladewhirl.solvers.march.schema import SUMMARY

MOSTLY = 0.5  #: share of the mean square of a line that describes the motion
ROUNDING = 1e-15  #: smaller magnitudes in SI units are printed as zero


def summary_rows(summary: Summary) -> dict[str, str]:
    """Return the rows of the summary, with rounded values in convenient units."""
    work = summary.work
    joints = "" if work["joints"] is None else f" joints {_text(work['joints'], 'J')},"
    return {
        "regime": regime_title(summary.regime, judged=summary.growth_rate is not None),
        "because": summary.regime_criterion.rpartition("Here: ")[2],
        "end time": f"{summary.end_time:.6g} s, {summary.end_reason}",
        **({} if summary.blade_loss is None else {"loss": summary.blade_loss}),
        **_known("support fused at", summary, "fuse_time"),
        **_shaft(summary),
        **_walls(summary.casing_displacement_max),
        **_tips(summary),
        "strain energy, largest": _shown(summary, "strain_energy_max"),
        **_energies(summary.strain_energy_final),
        **_known("casing's strain energy, final", summary, "strain_energy_casing_final"),
        "work of": f"load {_text(work['load'], 'J')}, {_normal(work)},"
        f" friction {_text(work['friction'], 'J')}, springs {_text(work['springs'], 'J')},"
        f"{joints} damping {_text(work['damping'], 'J')}",
        **_drive(summary),
        **_contact_force(summary),
        **_stresses(summary),
        **_contact(summary),
        **_joints(summary),
        **_wear(summary),
        "energy residual": f"{summary.energy_residual:.3g}",
        "complementarity residual": f"{summary.complementarity_residual:.3g}",
        "time step / critical": f"{summary.dt_over_critical:.3g}",
        "steps": f"{summary.steps}; largest values are of records, every"
        f" {handy(summary.record_step, 's', 4)}",
        "wall time": f"{summary.wall_time:.3g} s ({summary.us_per_step:.3g} µs a step)",
    }


def _tips(summary: Summary) -> dict[str, str]:
    if not summary.contact_impulse_by_blade:  # a shaft line
        return {}
    rows = {"tip displacement, largest": _shown(summary, "tip_displacement_max")}
    return rows | _directions(summary.contact_displacement_max)


def _contact_force(summary: Summary) -> dict[str, str]:
    return {"contact force, largest": _force(summary)} if summary.contact_impulse_by_blade else {}


def _shaft(summary: Summary) -> dict[str, str]:
    if summary.shaft_radius_max is None:
        return {}
    rows = {
        "shaft radius, largest": f"{_shown(summary, 'shaft_radius_max')},"
        f" {_shown(summary, 'shaft_radius_final')} at the end",
        **_bearings(summary),
    }
    if summary.ripple_rms is None:  # a shaft line, each place of which has its own orbit
        return rows
    return {
        **rows,
        "whirl, rotating frame": _whirl(
            summary.whirl_frequency_rotating, summary.whirl_lines, "rotating", summary.end_time
        ),
        "whirl, static frame": _whirl(
            summary.whirl_frequency_static, summary.whirl_lines, "static", summary.end_time
        ),
        "ripple about the mean position": f"{_shown(summary, 'ripple_rms')} (rms),"
        f" {_whirl(summary.ripple_frequency, summary.ripple_lines, 'rotating', np.inf)}",
        **_crossings(summary.critical_crossings),
    }


def _drive(summary: Summary) -> dict[str, str]:
    work, power, rows = summary.work, summary.drive_power, {}
    if work["drive"] is not None:
        heat = _text(work["heat"], "J")
        rows["work of the drive"] = f"{_text(work['drive'], 'J')}, of it friction heat {heat}"
    if power is not None:
        torque = "" if summary.drive_torque is None else f", {_shown(summary, 'drive_torque')}"
        rows["drive over the last third"] = _shown(summary, "drive_power") + torque
    elif summary.friction_power:
        text = f"{_shown(summary, 'friction_power')}, {_shown(summary, 'friction_torque')}"
        rows["drive against friction, last third"] = text
    return rows


def _bearings(summary: Summary) -> dict[str, str]:
    if summary.bearing_force_max is None:
        return {}
    force, time = _shown(summary, "bearing_force_max"), _shown(summary, "bearing_force_time")
    return {"force on the bearings, largest": f"{force} at {time}"}


def _crossings(found: list[CriticalCrossing]) -> dict[str, str]:
    texts = [
        f"{each['speed'] * 30.0 / np.pi:.5g} rpm ({each['whirl']},"
        f" {'rising' if each['rising'] else 'falling'}) at {_text(each['time'], 's')}, shaft radius"
        f" {_text(each['amplitude'], 'm')}"
        for each in found
    ]
    return {"critical speeds passed": "; ".join(texts)} if texts else {}


def _walls(peaks: dict[str, WallPeak] | None) -> dict[str, str]:
    walls = [
        f"{direction} {_text(peak['displacement'], 'm')}"
        + (f" at {peak['angle']:.4g}°, {_text(peak['time'], 's')}" if peak["displacement"] else "")
        + (f", wheel {peak['wheel']}" if "wheel" in peak else "")
        for direction, peak in (peaks or {}).items()
    ]
    return {"casing displacement, largest": "; ".join(walls)} if walls else {}


def _directions(largest: dict[str, float]) -> dict[str, str]:
    parts = [f"{name} {_text(value, 'm')}" for name, value in largest.items() if value]
    return {"  by direction": ", ".join(parts)} if parts else {}


def _known(row: str, summary: Summary, name: str) -> dict[str, str]:
    return {} if getattr(summary, name) is None else {row: _shown(summary, name)}


def _force(summary: Summary) -> str:
    force = summary.contact_force_max
    if not force["force"]:
        return "none"
    several = len(summary.contact_share) > len(summary.contact_impulse_by_blade)
    node = f", node {force['node']}" if several else ""
    blade = f"; on a whole blade {_text(force['on_blade'], 'N')}" if several else ""
    return (
        f"{_text(force['force'], 'N')} over {_text(force['averaged_over'], 's')}, blade"
        f" {force['blade']}{node} at {_text(force['time'], 's')}{blade}; impulse of all"
        f" {_shown(summary, 'contact_impulse')}{_doubtful(summary.unsolved_impulse_share)}"
    )


def unsolved_share(summary: Summary) -> str:
    """Return when steps were first not solved, their residual, and their shares of impulse and
    wear; nothing if all were."""
    if summary.unsolved_time is None:
        return ""
    worn = f" and {summary.unsolved_wear_share:.2g} of the wear" if summary.wear else ""
    return (
        f" (first at {_shown(summary, 'unsolved_time')}, residual"
        f" {summary.complementarity_residual:.3g}; {summary.unsolved_impulse_share:.2g} of the"
        f" impulse{worn})"
    )


def _doubtful(share: float) -> str:
    """Return a mark for a number of which unsolved steps have a share."""
    return f" (unsolved steps have {share:.2g} of it)" if share else ""


def _joints(summary: Summary) -> dict[str, str]:
    """Return a row for each friction joint: forces and states over the last third, and sums."""
    return {
        f"joint {name}": f"normal force up to {_text(own['largest_normal_force'], 'N')}, tangential"
        f" {_text(own['largest_tangential_force'], 'N')}; open {own['share_open']:.0%}, stuck"
        f" {own['share_stuck']:.0%}, slipping {own['share_slipping']:.0%} of the last third; slip"
        f" {_text(own['slip'], 'm')}, work taken {_text(own['work'], 'J')}"
        for name, own in summary.joints.items()
    }


def _wear(summary: Summary) -> dict[str, str]:
    wear = summary.wear
    if not wear:
        return {}
    metal = wear["metal_time"]
    return {
        "wear of the coating": f"{1e9 * wear['wear_volume']:.4g} mm³"
        f"{_doubtful(summary.unsolved_wear_share)}, strain at most"
        f" {wear['wear_strain_max']:.3g}, mean {wear['wear_strain_mean']:.3g};"
        f" {lobes_text(wear)}",
        "energy dissipated in the coating": _text(wear["wear_dissipated"], "J"),
        "first contact with the metal": "none" if metal is None else _text(metal, "s"),
    }


def _normal(work: Works) -> str:
    """Return the work of the normal forces as text, split into its two parts if they are known."""
    closing = work["closing"]
    if closing is None:
        return f"normal forces {_text(work['normal'], 'J')}"
    passing = _text(work["normal"] - closing, "J")
    return f"closing tips {_text(closing, 'J')}, passing wall {passing}"


def _shown(summary: Summary, name: str) -> str:
    """Return a measure in a handy unit; a dash if it is not known."""
    return _text(getattr(summary, name), SUMMARY[name].units)


def _text(value: float | None, unit: str) -> str:
    return "–" if value is None else handy(value if abs(value) > ROUNDING else 0.0, unit, 4)


def _energies(energy: EnergyHolders | None) -> dict[str, str]:
    if energy is None:
        return {}
    family = energy["1F"]
    total = energy["suspension"] + sum(family.values()) + energy["rest"]
    parts = {
        "suspension": energy["suspension"],
        **{f"{FIRST_FAMILY}, k = {k}": family[k] for k in ("0", "1") if k in family},
        f"{FIRST_FAMILY}, other k": sum(e for k, e in family.items() if k not in ("0", "1")),
        "rest": energy["rest"],
    }
    return {
        "strain energy, final": _text(total, "J"),
        **{
            f"  {name}": f"{_text(value, 'J')} ({100 * value / (total or 1.0):.1f} %)"
            for name, value in parts.items()
        },
    }


def _whirl(frequency: float | None, lines: list[LineOfWhirl], frame: Frame, end_time: float) -> str:
    """Return the whirl; lines are those of the last third of the time until the end."""
    if lines and lines[0]["share"] > MOSTLY and abs(lines[0][frame]) * end_time < 3.0:
        return "none, the displacement is constant"
    if frequency is not None:
        return f"{'forward' if frequency > 0 else 'backward'}, {abs(frequency):.4g} Hz"
    shares = [f"{line['share']:.0%} at {round(line[frame], 6) + 0.0:.3g} Hz" for line in lines]
    strongest = [f"strongest lines {', '.join(shares)}"] if shares else []
    return "; ".join(["no single whirl frequency", *strongest])


def _stress(peak: StressPeak, strength: float | None) -> str:
    if not peak["stress"]:
        return "none"
    beyond = strength is not None and abs(peak["stress"]) > strength
    measure = "linear" if peak["measure"] == "beam theory" else f"{peak['measure']}, linear"
    rotation = "with" if peak["centrifugal"] else "without"
    sense = " compression" if peak["stress"] < 0.0 else ""
    return (
        f"{_text(abs(peak['stress']), 'Pa')}{sense}, {measure}, {rotation} centrifugal stress ("
        f"{peak['member']}, r = {peak['radius']:.3g} m, {_text(peak['time'], 's')})"
        + (f"; beyond the yield strength, {_text(strength, 'Pa')}" if beyond else "")
    )


def _stresses(summary: Summary) -> dict[str, str]:
    rows = {}
    for body, peak in (summary.stress_max or {}).items():
        rows[f"stress of {body.replace('_', ' ')}, largest"] = _stress(peak, summary.yield_strength)
        if body == "bladed_disk":
            rows |= _split(summary.stress_split)
    return rows


def _split(split: StressSplit | None) -> dict[str, str]:
    if split is None or not split["alternating"]:
        return {}
    margin = split["margin"]
    fatigue = "" if margin is None else f"; margin against fatigue {margin:.3g}"
    parts = f"{_text(split['mean'], 'Pa')}, {_text(split['alternating'], 'Pa')}"
    place = f"{split['member']}, r = {split['radius']:.3g} m"
    return {"  mean and alternating": f"{parts} ({place}){fatigue}"}


def _contact(summary: Summary) -> dict[str, str]:
    shares, impulses = summary.contact_share, summary.contact_impulse_by_blade
    if not impulses:
        return {}
    several = len(shares) > len(impulses)
    blades = np.flatnonzero(impulses if several else shares)
    text = f"{len(blades)} of {len(impulses)}"
    if len(blades):
        touched = np.array(shares)[np.flatnonzero(shares)] * 100
        share = f"{touched.min():.3g} to {touched.max():.3g} % of the steps"
        text += f": {', '.join(map(str, blades))}; {share}"
    rows = {"blades that touched": text}
    if several:
        rows["contact nodes that touched"] = f"{np.count_nonzero(shares)} of {len(shares)}"
    if summary.impulse_per_revolution:
        rows["impulse per revolution, at the end"] = _shown(summary, "impulse_per_revolution")
    return rows | {"deepest penetration": _shown(summary, "gap_violation_max")}
