"""Sweep the paper's contact cases with rotation effects; draw the figures of rotation_cases.md.

    python docs/rotation_cases.py FOLDER

Sweeps and runs that are not yet in FOLDER are computed, which takes half an hour for all of them on
one core. The numbers of all points are written to docs/rotation_cases.csv, the figures to
docs/rotation_*.png.
"""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from pictures import DOCS, EXAMPLES, bladewhirl, keep

import bladewhirl as bw
from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, INCH, styled
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.sweep.frequency_map import LINES, frequency_map

CASES = {"casing_distortion": ("casing distortion", 1.5), "imbalance": ("imbalance", 3.0)}
"""Title in figures and duration of the marches [s] of each case file."""

EFFECTS = {"none": COLOURS["rotor"], "centrifugal": COLOURS["other k"], "full": COLOURS["k = 0"]}
SPEEDS = (0.95, 1, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.35, 1.39, 1.45, 1.5, 1.6, 1.7, 1.8, 1.9, 2)
CRITICAL = 1.8797  #: critical speed; "centrifugal" is refused from this speed on
SHOWN = 1.05  #: speed at which orbits are drawn
MARKERS = {"divergent": "^", "sustained": "o", "damped": "v"}
FLOOR, TOP, REACH = 1e-3, 10.0, 2.9  #: limits of the maps: amplitudes [mm], frequency / ω₁
STEADY = 10.0  #: largest scatter of a whirl frequency that is drawn [Hz]
TURNS = 4  #: number of last revolutions that the orbits show

NUMBERS = (
    "end_time growth_rate shaft_radius_max late_radius whirl_frequency whirl_scatter"
    " mode_frequency mode_forward_frequency late_contact_share"
).split()
SHARES = {"suspension": "suspension", "k = 0": "1F k=0", "k = 1": "1F k=1", "rest": "rest"}


def made(folder: Path, command: tuple[str, ...], case: str, effects: str) -> Path:
    """Return a folder; if it does not exist, write the sweep or run of a command into it."""
    if not folder.exists():
        changes = ("--set", f"rotation.effects={effects}")
        length = ("--set", f"march.duration={CASES[case][1]}")
        bladewhirl(*command, EXAMPLES / f"{case}.toml", "-o", folder, *changes, *length)
    return folder


def swept(folder: Path, case: str, effects: str) -> xr.Dataset:
    """Return the sweep of a case over the speed with some rotation effects."""
    allowed = [speed for speed in SPEEDS if effects != "centrifugal" or speed < CRITICAL]
    over = f"march.speed={','.join(map(str, allowed))}"
    sweep = made(folder / f"{case}-{effects}", ("sweep", "--over", over), case, effects)
    return bw.open_sweep(sweep)


def orbit(folder: Path, case: str, effects: str) -> xr.Dataset:
    """Return the orbit of a case at the speed `SHOWN` with some rotation effects."""
    speed = ("--set", f"march.speed={SHOWN}", "--frames", "0")
    run = made(folder / f"{case}-{effects}-run", ("run", *speed), case, effects)
    with bw.open_result(run) as result:
        return shaft_orbit(result).load()


def rows(case: str, effects: str, sweep: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Yield a row of the table for each point: lengths in mm, frequencies in Hz."""
    for number, speed in enumerate(sweep["march_speed"].values):
        point = sweep.isel(march_speed=number)
        first = point.sel(mode="1F k=1")
        energy = point["energy_mean"]
        contact = point["contact_share"].values
        row = {"case": case, "effects": effects, "speed": f"{speed:g}"}
        for name in ("regime", "whirl_rotating", "whirl_static", "scenario"):
            row[name] = str(point[name].values)
        row["blades_touched"] = str(int((contact > 0).sum()))
        for name in NUMBERS:
            value = float(np.mean(first[name].values))
            row[name] = f"{value * (1e3 if 'radius' in name else 1.0):.5g}"
        for name, group in SHARES.items():
            share = float(energy.sel(energy_group=group) / energy.sum())
            row[f"energy, {name}"] = f"{share:.3f}"
        yield row


@styled
def plot_radii(table: list[dict[str, Any]]) -> Figure:
    """Draw shaft radius and whirl frequency late in the march over speed, with the regimes."""
    figure = Figure(figsize=(FULL_WIDTH / INCH, 4.6), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey="row")
    for column, (case, (title, _)) in enumerate(CASES.items()):
        radius, whirl = axes[:, column]
        for effects, colour in EFFECTS.items():
            rows = [row for row in table if (row["case"], row["effects"]) == (case, effects)]
            speed = [float(row["speed"]) for row in rows]
            sizes = [float(row["late_radius"]) for row in rows]
            radius.plot(speed, sizes, color=colour, linewidth=0.7)
            turning = [float(row["whirl_frequency"]) for row in rows]
            steady = [  # the scatter of a short march is NaN, its whirl is drawn
                row["whirl_rotating"] != "none" and not float(row["whirl_scatter"]) > STEADY
                for row in rows
            ]
            clear = np.where(steady, turning, np.nan)
            whirl.plot(speed, clear, color=colour, linewidth=0.7)
            for x, size, rate, row in zip(speed, sizes, clear, rows, strict=True):
                filled = colour if row["regime"] == "divergent" else "white"
                style = {"marker": MARKERS[row["regime"]], "markersize": 5, "color": colour}
                radius.plot(x, size, **style, markerfacecolor=filled, linestyle="")
                whirl.plot(x, rate, **style, markerfacecolor=filled, linestyle="")
        whirl.axhline(0.0, color="grey", linewidth=0.5)
        for panel in (radius, whirl):
            panel.axvline(CRITICAL, color="grey", linestyle=":")
        radius.set(yscale="log", title=title)
        whirl.set_xlabel("speed / ω₁ [–]")
    axes[0, 0].set_ylabel("late radius of the shaft [mm]")
    axes[1, 0].set_ylabel("whirl, rotating frame [Hz]\n← backward   forward →")
    for effects, colour in EFFECTS.items():
        axes[0, 0].plot([], [], color=colour, label=f'effects = "{effects}"')
    for regime, marker in MARKERS.items():
        face = "grey" if regime == "divergent" else "white"
        style = {"color": "grey", "linestyle": "", "markerfacecolor": face, "markersize": 5}
        axes[0, 0].plot([], [], marker=marker, label=regime, **style)
    axes[0, 0].plot([], [], color="grey", linestyle=":", label="critical speed")
    figure.legend(loc="outside lower center", ncols=4)
    return figure


@styled
def plot_maps(sweeps: dict[tuple[str, str], xr.Dataset]) -> Figure:
    """Draw spectra of the shaft over speed in the rotating frame, with the waves of k = 1."""
    figure = Figure(figsize=(FULL_WIDTH / INCH, 4.6), layout="constrained")
    axes = figure.subplots(len(CASES), len(EFFECTS), sharex=True, sharey=True)
    for panel, ((case, effects), sweep) in zip(axes.flat, sweeps.items(), strict=True):
        picture = _map(panel, frequency_map(sweep, "march_speed").isel(line=0))
        panel.set_title(f'{CASES[case][0]}, "{effects}"')
    for panel in axes[-1]:
        panel.set(xlabel="speed / ω₁ [–]", xlim=(SPEEDS[0], SPEEDS[-1]))
    figure.supylabel("frequency / ω₁, forward positive", fontsize="medium")
    figure.colorbar(picture, ax=list(axes.flat), label="amplitude of the shaft [mm]", pad=0.01)
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3, handlelength=2.6)
    return figure


def _map(axes: Axes, one: xr.Dataset) -> Any:
    speed, frequency = one["march_speed"].values, one["frequency"].values
    amplitude = np.maximum(1e3 * one["amplitude"].values, FLOOR).T
    picture = draw_map(axes, speed, frequency, amplitude, norm=LogNorm(FLOOR, TOP))
    for name, (colour, dashes, _) in LINES.items():
        for way in ("backward", "forward"):
            line = one["mode_line"].sel(mode=name, direction=way)
            label = name if way == "backward" else None
            axes.plot(speed, line, color=colour, linestyle=dashes, label=label)
    axes.set_ylim(-REACH, REACH)
    return picture


@styled
def plot_orbits(orbits: dict[tuple[str, str], xr.Dataset]) -> Figure:
    """Draw the last revolutions of the orbits in the static frame."""
    figure = Figure(figsize=(FULL_WIDTH / INCH, 4.9), layout="constrained")
    axes = figure.subplots(len(CASES), len(EFFECTS))
    for panel, ((case, effects), orbit) in zip(axes.flat, orbits.items(), strict=True):
        end = float(orbit["time"][-1])
        last = orbit["time"].values > end - TURNS * 2 * np.pi / abs(orbit.attrs["speed"])
        x, y = 1e3 * orbit["static"].values[last].T
        panel.plot(x, y, color=EFFECTS[effects], linewidth=0.8)
        panel.plot(x[-1], y[-1], "s", color=EFFECTS[effects], markersize=4)
        panel.plot(0, 0, "+", color="grey")
        panel.set(aspect="equal", title=f'{CASES[case][0]}, "{effects}"\nuntil {end:.2f} s')
        reach = 1.1 * np.hypot(x, y).max()
        panel.set(xlim=(-reach, reach), ylim=(-reach, reach))
    for panel in axes[-1]:
        panel.set_xlabel("x [mm]")
    for panel in axes[:, 0]:
        panel.set_ylabel("y [mm]")
    figure.suptitle(f"Shaft over the last {TURNS} revolutions at {SHOWN} ω₁, static frame")
    return figure


def main(folder: Path) -> None:
    """Write the table and draw the figures."""
    kinds = [(case, effects) for case in CASES for effects in EFFECTS]
    sweeps = {kind: swept(folder, *kind) for kind in kinds}
    table = [row for kind, sweep in sweeps.items() for row in rows(*kind, sweep)]
    with (DOCS / "rotation_cases.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, table[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    orbits = {kind: orbit(folder, *kind) for kind in kinds}
    figures = {"radii": plot_radii(table), "maps": plot_maps(sweeps), "orbits": plot_orbits(orbits)}
    for name, figure in figures.items():
        figure.savefig(folder / f"{name}.png", dpi=200)
        keep(folder / f"{name}.png", f"rotation_{name}.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
