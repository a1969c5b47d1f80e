"""Which value of which parameter meets a claim: one row for each parameter around a base set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from bladewhirl.postprocess.style import COLOURS, FULL_WIDTH, new_figure, styled

VERDICT_COLOURS: Mapping[str, str] = {
    "holds": COLOURS["suspension"],
    "partly": COLOURS["other k"],
    "does not hold": COLOURS["k = 1"],
    "not testable": COLOURS["rest"],
    "": "white",
}
"""Of the cells; the last is of what was not tried."""

ROW_HEIGHT, MARGIN = 0.0055, 0.016
"""Heights of a row, and of what is around the rows [m]."""


def sensitivity_dataset(
    claim: str, rows: Mapping[str, Sequence[tuple[str, str]]], base: Mapping[str, str]
) -> xr.Dataset:
    """Verdicts by parameter and value.

    Args:
        claim: in words.
        rows: for each parameter its values with their verdicts, which are empty if not tried.
        base: value of each parameter in the base set.

    Returns:
        `value` and `verdict` (parameter, place), empty where a parameter has fewer values, and
        `base` (parameter,).
    """
    width = max(len(row) for row in rows.values())
    value = np.full((len(rows), width), "", dtype=object)
    verdict = value.copy()
    for line, row in enumerate(rows.values()):
        for place, (shown, found) in enumerate(row):
            value[line, place], verdict[line, place] = shown, found
    return xr.Dataset(
        {
            "value": (("parameter", "place"), value.astype(str)),
            "verdict": (("parameter", "place"), verdict.astype(str)),
            "base": ("parameter", [base[name] for name in rows]),
        },
        coords={"parameter": list(rows)},
        attrs={"title": claim},
    )


@styled
def plot_sensitivity(data: xr.Dataset) -> Figure:
    """Draw a cell for each value, coloured by its verdict; those of the base set are framed.

    Args:
        data: from `sensitivity_dataset`.
    """
    names = data["parameter"].values
    figure = new_figure(width=FULL_WIDTH, height=MARGIN + ROW_HEIGHT * len(names))
    axes = figure.add_subplot()
    seen = set()
    for line, name in enumerate(names):
        row = data.sel(parameter=name)
        for place, (value, verdict) in enumerate(
            zip(row["value"].values, row["verdict"].values, strict=True)
        ):
            if not value:
                continue
            is_base = value == str(row["base"].values)
            seen.add(str(verdict))
            axes.add_patch(
                Rectangle(
                    (place + 0.03, line - 0.42),
                    0.94,
                    0.84,
                    facecolor=VERDICT_COLOURS[str(verdict)],
                    edgecolor="black",
                    linewidth=1.6 if is_base else 0.3,
                    zorder=3 if is_base else 2,
                )
            )
            axes.text(place + 0.5, line, value, ha="center", va="center", fontsize=7, zorder=4)
    axes.set(xlim=(0, data.sizes["place"]), ylim=(len(names) - 0.5, -0.5), xticks=[])
    axes.set_yticks(range(len(names)), names)
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    axes.set_title(data.attrs["title"], wrap=True)
    handles = [
        Patch(facecolor=colour, edgecolor="black", linewidth=0.3, label=word or "not tried")
        for word, colour in VERDICT_COLOURS.items()
        if word in seen
    ]
    framed = Patch(facecolor="white", edgecolor="black", linewidth=1.6, label="base set")
    figure.legend(handles=[*handles, framed], loc="outside lower center", ncols=5)
    return figure
