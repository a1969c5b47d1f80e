"""Figure of a branch of periodic motions, with points of sweeps laid over it."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.periodic.dataset import of_sweep
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    new_figure,
    side_by_side,
    styled,
)
from bladewhirl.postprocess.plotting.titles import key_words, set_title
from bladewhirl.solvers.periodic.bifurcation import KINDS

MARKS = dict(zip(KINDS, "osD", strict=True))
JUMP = {"arrowstyle": "-|>", "color": COLOURS["casing"], "linestyle": ":"}
"""Look of an arrow from a fold to where a slow change of the key jumps."""

STARTS = {"up": "marches, key rising", "down": "marches, key falling", "": "marches from rest"}
"""Labels of the points of a sweep by the direction in which it carried the motion."""


def with_marches(branch: xr.Dataset, sweeps: Sequence[xr.Dataset] = ()) -> xr.Dataset:
    """Return a branch with the points of sweeps over its key: over `march`, `march_parameter` in
    the unit of the branch, `march_impulse` [N s] and `march_label`.

    Raises:
        ViewError: a dataset is no sweep, or the sweep has other keys.
    """
    place, impulse, label = list[np.ndarray](), list[np.ndarray](), list[str]()
    key = str(branch.attrs["key"])
    name = key.replace(".", "_")
    for sweep in sweeps:
        factor = 1.0 / of_sweep(branch, sweep)
        done = sweep["impulse_per_revolution"].where(sweep["state"] == "done")
        others = [str(other) for other in done.dims if other not in (name, "draw")]
        if others:
            raise ViewError(
                f"expected a sweep over {key} only to lay over the branch, not also over"
                f" {', '.join(others)}"
            )
        flat = done.stack(march=done.dims)
        place.append(factor * flat[name].values)
        impulse.append(flat.values)
        start = "marches from periodic motions" if "start" in sweep else ""
        label += [start or STARTS[str(sweep.attrs.get("carry", ""))]] * flat.size
    if not sweeps:
        return branch
    return branch.assign(
        march_parameter=("march", np.concatenate(place)),
        march_impulse=("march", np.concatenate(impulse), {"units": "N s"}),
        march_label=("march", np.array(label, dtype=object)),
    )


def size_of(data: xr.Dataset) -> np.ndarray:
    """Return half the range of the radial displacement of the contact node that moves most at each
    point of a branch [m], (points,); in constant contact the deflection of the shaft."""
    if "centre" in data:
        return np.asarray(np.hypot(*data["centre"].values.T))
    moved = data["contact_displacement"].sel(direction="radial")
    swing = moved.max("instant") - moved.min("instant")
    return np.asarray(swing.max("node").values / 2.0)


def parts_of(data: xr.Dataset, values: np.ndarray) -> list[tuple[np.ndarray, str]]:
    """Return values at the points of a branch for its stable and for its unstable parts, with the
    style of each; other points are NaN. Unstable parts reach to the next stable points."""
    stable = data["stable"].values
    joined = ~stable
    joined[:-1] |= ~stable[1:]
    joined[1:] |= ~stable[:-1]
    return [(np.where(stable, values, np.nan), "-"), (np.where(joined, values, np.nan), "--")]


def key_label(data: xr.Dataset) -> str:
    """Return the label of the key of a branch with its unit."""
    return f"{key_words(str(data.attrs['key']))} [{data.attrs['unit'] or '–'}]"


def jumps(data: xr.Dataset, values: np.ndarray) -> list[tuple[float, float, float]]:
    """Return where a slow change of the key jumps at a fold to the nearest other stable part of the
    branch: the parameter, and the values before and after the jump."""
    place, stable = data["parameter"].values, data["stable"].values
    both = np.flatnonzero(stable[1:] & stable[:-1])
    found = []
    for fold in np.flatnonzero(data["kind"].values == 1 + list(KINDS).index("fold")):
        own = place[fold]
        across = both[(place[both] - own) * (place[both + 1] - own) < 0.0]
        across = across[np.abs(across - fold) > 2]
        if len(across):
            ends = np.stack([across, across + 1])
            share = (own - place[ends[0]]) / (place[ends[1]] - place[ends[0]])
            levels = values[ends[0]] + share * (values[ends[1]] - values[ends[0]])
            to = levels[np.abs(levels - values[fold]).argmin()]
            found.append((float(own), float(values[fold]), float(to)))
    return found


@styled
def plot_branch(data: xr.Dataset) -> Figure:
    """Draw the impulse over the key and over the multipliers, of `bladewhirl.branch`.

    Stable parts are solid, unstable ones dashed; dotted arrows lead from folds to where the motion
    jumps if the key changes slowly. On the right are the multipliers of all points in
    the unit circle. Points of `with_marches` are marks over the impulse.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.07)
    impulse, size, circle = side_by_side(figure, 3)
    value = data["parameter"].values
    for axes, drawn in (
        (impulse, data["impulse_per_revolution"].values),
        (size, 1e3 * size_of(data)),
    ):
        for (part, style), label in zip(parts_of(data, drawn), ("stable", "unstable"), strict=True):
            if np.isfinite(part).any():
                axes.plot(value, part, style, color=COLOURS["rotor"], label=label)
        for at, before, after in jumps(data, drawn):
            axes.annotate("", (at, after), (at, before), arrowprops=JUMP)
        for number, (kind, mark) in enumerate(MARKS.items(), 1):
            there = data["kind"].values == number
            place = value[there], drawn[there]
            if there.any():
                axes.plot(*place, mark, markersize=4, color=COLOURS["casing"], label=kind)
        axes.set_xlabel(key_label(data))
    labels = data["march_label"].values if "march_label" in data else np.zeros(0)
    looks = zip(dict.fromkeys(labels.tolist()), ("x", "+", "1", "2"), strict=False)
    for number, (label, mark) in enumerate(looks):
        chosen = data.isel(march=labels == label)
        colour = (COLOURS["k = 1"], COLOURS["k = 0"])[number % 2]
        marched = chosen["march_parameter"].values, chosen["march_impulse"].values
        impulse.plot(*marched, mark, markersize=5, color=colour, label=label)
    impulse.set_ylabel("impulse per revolution [N s]")
    whirl = "radius of the shaft" if "centre" in data else "largest radial amplitude"
    size.set_ylabel(f"{whirl} [mm]")
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
    circle.plot(turn.real, turn.imag, color=COLOURS["rest"], linewidth=0.5)
    real, imaginary = data["multiplier_real"].values, data["multiplier_imaginary"].values
    away = np.hypot(real, imaginary)
    for here, colour in ((away <= 1.0, "rotor"), ((away > 1.0) & (away < 3.0), "k = 1")):
        circle.plot(real[here], imaginary[here], ".", markersize=2, color=COLOURS[colour])
    circle.set(xlabel="real part", ylabel="imaginary part", aspect="equal")
    circle.set_title("multipliers,\norange: outside the circle")
    set_title(figure, data.attrs["case"], "branch of periodic motions")
    legends_below(figure, Group(list(zip(*impulse.get_legend_handles_labels(), strict=True))))
    return figure
