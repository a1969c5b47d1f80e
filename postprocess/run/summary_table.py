"""The summary of a run in words: rows, a table on screen, hints."""

import numpy as np
from rich.table import Table

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.energy.strain import FIRST_FAMILY
from bladewhirl.postprocess.fields.enlarged import LARGE_DISPLACEMENT
from bladewhirl.postprocess.run.summary import LineOfWhirl, Summary
from bladewhirl.postprocess.shaft.whirl import Frame


def summary_rows(summary: Summary) -> dict[str, str]:
    """The summary in words: rounded, in handy units, the blades counted."""
    held = summary.strain_energy_final
    family = held["1F"]
    total = held["suspension"] + sum(family.values()) + held["rest"]
    other = sum(energy for k, energy in family.items() if k not in ("0", "1"))
    shares = summary.contact_share
    blades = np.flatnonzero(np.array(shares) > 0)
    touching = np.split(blades, np.flatnonzero(np.diff(blades) > 1) + 1) if len(blades) else []
    ends = ("–".join(dict.fromkeys([str(run[0]), str(run[-1])])) for run in touching)
    touched = [share for share in shares if share > 0]
    extremes = [f"{100 * bound(touched):.3g}" for bound in (min, max)] if touched else []
    told = (
        f": {', '.join(ends)}; {' to '.join(dict.fromkeys(extremes))} % of the steps"
        if touched
        else ""
    )

    def part(energy: float) -> str:
        return f"{energy:.4g} J ({100 * energy / total:.1f} %)" if total else "0 J"

    def turning(frame: Frame, frequency: float | None) -> str:
        if frequency is not None:
            way = "forward" if frequency > 0 else "backward"
            known = 2 * (summary.whirl_frequency_error or 0.0)
            error = f" ± {known:.1g}" if known > 1e-6 * abs(frequency) else ""
            return f"{way}, {abs(frequency):.4g}{error} Hz over the last third"
        return f"doesn't go round the centre at one rate{spectrum(summary.whirl_lines, frame)}"

    def spectrum(lines: list[LineOfWhirl], frame: Frame) -> str:
        least = 3.0 / summary.end_time if summary.end_time else np.inf  # of a turn in that third
        told = [
            f"{line['share']:.0%} "
            + (
                f"at {line[frame]:.3g} Hz"
                if abs(line[frame]) >= least
                else f"standing still, below {least:.2g} Hz"
            )
            for line in lines
        ]
        return f"; lines of its spectrum: {', '.join(told)}" if told else ""

    def wall(way: str) -> str:
        peak = summary.casing_displacement_max[way]
        if not peak["displacement"]:
            return "none"
        size = f"{1e3 * peak['displacement']:.4g} mm"
        return f"{size} at {peak['angle']:.4g}°, {peak['time']:.4g} s"

    work, force, rest = summary.work, summary.contact_force_max, summary.strain_energy_rest
    first = max(rest, key=lambda name: rest[name], default="")
    leading = f"{first} ({rest[first]:.4g} J)" if 2 * held["rest"] > total > 0 and first else ""
    return {
        "regime": summary.regime,
        "because": summary.regime_criterion.rpartition("Here: ")[2],
        "end time": f"{summary.end_time:.6g} s, {summary.end_reason}",
        "shaft radius, largest": f"{1e3 * summary.shaft_radius_max:.4g} mm,"
        f" {1e3 * summary.shaft_radius_final:.4g} mm at the end",
        "whirl, rotating frame": turning("rotating", summary.whirl_frequency_rotating),
        "whirl, static frame": turning("static", summary.whirl_frequency_static),
        "ripple about the mean place": f"{1e3 * summary.ripple_rms:.3g} mm (rms)"
        + (
            f", {summary.ripple_frequency:.4g} Hz"
            if summary.ripple_frequency
            else spectrum(summary.ripple_lines, "rotating")
        ),
        "casing displacement, largest": f"radial {wall('radial')}, tangential {wall('tangential')}",
        "tip displacement, largest": f"{1e3 * summary.tip_displacement_max:.4g} mm",
        "strain energy, largest": f"{summary.strain_energy_max:.4g} J",
        "strain energy, final": f"{total:.4g} J",
        "  suspension": part(held["suspension"]),
        **{f"  {FIRST_FAMILY}, k = {k}": part(family[k]) for k in ("0", "1") if k in family},
        f"  {FIRST_FAMILY}, other k": part(other),
        "  rest": part(held["rest"]) + (f", most of it {leading}" if leading else ""),
        "casing's strain energy, final": f"{summary.strain_energy_casing_final:.4g} J",
        "work of": f"load {work['load']:.3g} J, normal forces {work['normal']:.3g} J, friction"
        f" {work['friction']:.3g} J, springs {work['springs']:.3g} J, damping"
        f" {-work['damping']:.3g} J",
        "work of the drive": f"{work['drive']:.3g} J, {work['heat']:.3g} J of it rubbed away",
        "drive over the last third": (
            f"{summary.drive_power:.4g} W"
            + (f", {summary.drive_torque:.4g} N m" if summary.drive_torque is not None else "")
            if summary.drive_power is not None
            else "–"
        ),
        "contact force, largest": (
            f"{force['force']:.4g} N over {1e3 * force['averaged_over']:.3g} ms, blade"
            f" {force['blade']} at {force['time']:.4g} s; impulse of all"
            f" {summary.contact_impulse:.4g} N s"
            if force["force"]
            else "none"
        ),
        **{
            f"stress of {body.replace('_', ' ')}, largest": stress(summary, body)
            for body in summary.stress_max
        },
        "blades that touched": f"{len(touched)} of {len(shares)}{told}",
        "deepest penetration": f"{summary.gap_violation_max:.3g} m",
        "energy residual": f"{summary.energy_residual:.3g}",
        "complementarity residual": f"{summary.complementarity_residual:.3g}",
        "time step / critical": f"{summary.dt_over_critical:.3g}",
        "steps": f"{summary.steps}",
        "wall time": f"{summary.wall_time:.3g} s ({summary.us_per_step:.3g} µs a step)",
    }


def stress(summary: Summary, body: str) -> str:
    """The largest stress of a body: where, when, and whether the model holds there."""
    peak = summary.stress_max[body]
    place = f"{peak['member']}, r = {peak['radius']:.3g} m, {peak['time']:.4g} s"
    strong = summary.yield_strength
    beyond = strong is not None and abs(peak["stress"]) > strong
    known = f"; beyond the yield strength, {strong * 1e-6:.4g} MPa" if beyond and strong else ""
    size, sense = abs(peak["stress"]), "compression" if peak["stress"] < 0.0 else "tension"
    if size == 0.0:
        return "none"
    return f"{handy(size, 'Pa', 4)} {sense}, if elastic ({place}){known}"


def summary_table(summary: Summary) -> Table:
    """The summary as a table to read."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(style="cyan", no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in summary_rows(summary).items():
        table.add_row(name, f"[bold]{value}[/]" if name == "regime" else value)
    return table


def displacement_hints(summary: Summary, tip_radius: float) -> tuple[str, ...]:
    """A line where blades bend further than a linear model holds, else none.

    Args:
        summary: of a run.
        tip_radius: [m]
    """
    limit = LARGE_DISPLACEMENT * tip_radius
    if summary.tip_displacement_max <= limit:
        return ()
    return (
        f"tips moved up to {summary.tip_displacement_max:.3g} m, and from about {limit:.2g} m on "
        "a linear model is off by a tenth or more: take the kind of motion from it, not its size",
    )
