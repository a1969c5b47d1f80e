"""Backbone: amplitude over the key at the peaks of branches that differ in another key."""

import re
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.inputs.units import Speed, handy
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.periodic.branch import key_label, parts_of, size_of
from bladewhirl.postprocess.periodic.dataset import CASE_FILE
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import key_words, set_title


def backbone(branch: xr.Dataset, others: Sequence[xr.Dataset] = ()) -> xr.Dataset:
    """Return the amplitudes of branches over a key, and their peaks.

    Args:
        branch: a branch, see `bladewhirl.branch` and `open_branch`.
        others: further branches over the same key, such as those of other clearances or amplitudes
            of an engine order.

    Returns:
        over (branch, point): `parameter`, `amplitude` [m], half the range of the radial
        displacement of the contact node that moves most, and `stable`; over branch: `peak` and
        `peak_amplitude`, the point with the largest amplitude, and `label`, the values of the keys
        in which the cases differ. Branches are in the order of their peaks; shorter ones end with
        NaN.

    Raises:
        ViewError: a branch has another key or unit.
    """
    branches = [branch, *others]
    keys = {(each.attrs.get("key"), each.attrs.get("unit")) for each in branches}
    if len(keys) > 1:
        raise ViewError(f"expected branches over {branch.attrs['key']} in the same unit")
    size = [size_of(each) for each in branches]
    top = [int(each.argmax()) for each in size]
    labels = differences(branches)
    peaks = [float(each[n]) for each, n in zip(size, top, strict=True)]
    order = np.argsort(peaks, kind="stable").tolist()
    most = max(each.sizes["point"] for each in branches)

    def padded(values: np.ndarray) -> np.ndarray:
        return np.pad(values.astype(float), (0, most - len(values)), constant_values=np.nan)

    def joined(values: Sequence[np.ndarray]) -> tuple[tuple[str, str], np.ndarray]:
        return ("branch", "point"), np.stack([padded(values[n]) for n in order])

    place = [each["parameter"].values for each in branches]
    names = ("key", "unit", "case")
    return xr.Dataset(
        {
            "parameter": joined(place),
            "amplitude": (*joined(size), {"units": "m"}),
            "stable": joined([each["stable"].values for each in branches]),
            "peak": ("branch", [place[n][top[n]] for n in order]),
            "peak_amplitude": ("branch", [peaks[n] for n in order], {"units": "m"}),
            "label": ("branch", [labels[n] for n in order]),
        },
        attrs={name: branch.attrs[name] for name in names},
    )


def differences(branches: Sequence[xr.Dataset]) -> list[str]:
    """Return the values of the keys in which the cases of branches differ, as text; the number of a
    branch without the file of its case."""
    files = [each.attrs.get(CASE_FILE) for each in branches]
    if not all(files):
        return [f"branch {number}" for number in range(1, 1 + len(branches))]
    tables = [dict(_numbers(read_case(str(file)))) for file in files]
    own = str(branches[0].attrs["key"])
    every = dict.fromkeys(key for table in tables for key in table if key != own)
    differ = [key for key in every if len({table.get(key) for table in tables}) > 1]
    return [
        ", ".join(f"{key_words(key)} = {table.get(key, 'none')}" for key in differ)
        or f"branch {number}"
        for number, table in enumerate(tables, 1)
    ]


def _numbers(table: Table, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield the dotted keys of a table that have a number, with its text."""
    descriptions = type(table).descriptions()
    for attribute, field in type(table).model_fields.items():
        name, value = field.alias or attribute, getattr(table, attribute)
        rows = value if isinstance(value, tuple) else ()
        for place, row in enumerate(rows):
            if isinstance(row, Table):
                yield from _numbers(row, f"{prefix}{name}.{place}.")
        if isinstance(value, Table):
            yield from _numbers(value, f"{prefix}{name}.")
        elif isinstance(value, float | int | Speed):
            unit = re.search(r"\[([^\]]+)\]", descriptions.get(attribute, ""))
            number = value if isinstance(value, Speed) else handy(value, unit[1] if unit else "1")
            yield f"{prefix}{name}", str(number).removesuffix(" 1")


@styled
def plot_backbone(data: xr.Dataset) -> Figure:
    """Draw `backbone`: amplitudes over the key, unstable parts dashed, and a line through the
    peaks."""
    figure = new_figure(width=FULL_WIDTH, height=0.075)
    axes = figure.subplots()
    for n in range(data.sizes["branch"]):
        one = data.isel(branch=n).dropna("point")
        stable = one.assign(stable=one["stable"].astype(bool))
        colour = None
        for part, style in parts_of(stable, 1e3 * one["amplitude"].values):
            label = str(one["label"].values) if colour is None else "_"
            (line,) = axes.plot(one["parameter"].values, part, style, color=colour, label=label)
            colour = line.get_color()
    if not data["stable"].fillna(1.0).all():
        axes.plot([], [], "--", color=COLOURS["rest"], label="unstable")
    peaks = data["peak"].values, 1e3 * data["peak_amplitude"].values
    axes.plot(*peaks, "o-", color=COLOURS["k = 1"], markersize=4, label="peaks")
    axes.set(xlabel=key_label(data), ylabel="largest radial amplitude [mm]")
    axes.legend(loc="best")
    set_title(figure, data.attrs["case"], "backbone of periodic motions")
    return figure
