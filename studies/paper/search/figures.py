"""Which value of which parameter meets a claim: single changes of a base set."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from textwrap import wrap

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled

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

TITLE_LETTERS = 95
"""Letters in a line of a title."""

LETTERS = 7
"""Of a value that a cell has room for; longer ones are written smaller."""

GAP = 0.4
"""Between the parameters of the overview [cells]."""

CELL, HEAD = 0.0042, 0.042
"""Height of a claim in the overview, and of what is above and below them [m]."""


def sensitivity_dataset(
    claims: Mapping[int, str],
    rows: Mapping[str, Sequence[tuple[str, Sequence[str]]]],
    base: Mapping[str, str],
) -> xr.Dataset:
    """Verdicts by claim, parameter and value.

    Args:
        claims: in words, by number.
        rows: for each parameter its values with the verdicts on each claim, which are empty if
            not tried.
        base: value of each parameter in the base set.

    Returns:
        `value` (parameter, place) and `verdict` (parameter, place, claim), empty where a parameter
        has fewer values, `base` (parameter,) and `text` (claim,).
    """
    width = max(len(row) for row in rows.values())
    value = np.full((len(rows), width), "", dtype=object)
    verdict = np.full((len(rows), width, len(claims)), "", dtype=object)
    for line, row in enumerate(rows.values()):
        for place, (shown, found) in enumerate(row):
            value[line, place], verdict[line, place] = shown, found
    return xr.Dataset(
        {
            "value": (("parameter", "place"), value.astype(str)),
            "verdict": (("parameter", "place", "claim"), verdict.astype(str)),
            "base": ("parameter", [base[name] for name in rows]),
            "text": ("claim", list(claims.values())),
        },
        coords={"parameter": list(rows), "claim": list(claims)},
    )


@styled
def plot_sensitivity(data: xr.Dataset) -> Figure:
    """Draw a row for each parameter, a cell for each value; those of the base set are framed.

    Args:
        data: from `sensitivity_dataset`, of one claim.
    """
    names = data["parameter"].values
    figure = new_figure(width=FULL_WIDTH, height=MARGIN + ROW_HEIGHT * len(names))
    axes = figure.add_subplot()
    seen = set()
    for line, name in enumerate(names):
        row = data.sel(parameter=name).squeeze("claim")
        for place, (value, verdict) in enumerate(
            zip(row["value"].values, row["verdict"].values, strict=True)
        ):
            if not value:
                continue
            seen.add(str(verdict))
            _draw_cell(axes, (place, line), str(verdict), framed=value == str(row["base"].values))
            size = 7 * min(1.0, LETTERS / len(value))
            axes.text(place + 0.5, line, value, ha="center", va="center", fontsize=size, zorder=4)
    axes.set(xlim=(0, data.sizes["place"]), ylim=(len(names) - 0.5, -0.5), xticks=[])
    axes.set_yticks(range(len(names)), names)
    _bare(axes)
    text = f"Claim {data['claim'].values[0]}: {data['text'].values[0]}"
    axes.set_title("\n".join(wrap(text, TITLE_LETTERS)))
    _add_legend(figure, seen)
    return figure


@styled
def plot_overview(data: xr.Dataset) -> Figure:
    """Draw a row for each claim, a cell for each single change of the base set.

    The first cell of a row is the base set's.

    Args:
        data: from `sensitivity_dataset`.
    """
    claims = data["claim"].values
    figure = new_figure(width=FULL_WIDTH, height=HEAD + CELL * len(claims))
    axes = figure.add_subplot()
    labels, places, seen, at = [], [], set(), 0.0
    is_base = data["value"] == data["base"]
    line, place = np.argwhere(is_base.values)[0]
    columns = [("base set", data["verdict"].values[line, place])]
    groups = [columns]
    for line, name in enumerate(data["parameter"].values):
        groups.append(
            [
                (f"{name} {value}", data["verdict"].values[line, place])
                for place, value in enumerate(data["value"].values[line])
                if value and not is_base.values[line, place]
            ]
        )
    for group in groups:
        for label, verdicts in group:
            if not any(verdicts):
                continue
            for row, verdict in enumerate(verdicts):
                _draw_cell(axes, (at, row), str(verdict), framed=group is columns)
                seen.add(str(verdict))
            labels.append(label)
            places.append(at + 0.5)
            at += 1.0
        at += GAP if any(any(verdicts) for _, verdicts in group) else 0.0
    axes.set(xlim=(0.0, places[-1] + 0.5), ylim=(len(claims) - 0.5, -0.5))
    axes.set_xticks(places, labels, rotation=90, fontsize=6.5)
    axes.xaxis.tick_top()
    axes.set_yticks(range(len(claims)), [f"claim {claim}" for claim in claims])
    _bare(axes)
    _add_legend(figure, seen)
    return figure


def _draw_cell(axes: Axes, corner: tuple[float, int], verdict: str, *, framed: bool) -> None:
    place, line = corner
    axes.add_patch(
        Rectangle(
            (place + 0.03, line - 0.42),
            0.94,
            0.84,
            facecolor=VERDICT_COLOURS[verdict],
            edgecolor="black",
            linewidth=1.6 if framed else 0.3,
            zorder=3 if framed else 2,
        )
    )


def _bare(axes: Axes) -> None:
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)


def _add_legend(figure: Figure, seen: Container[str]) -> None:
    handles = [
        Patch(facecolor=colour, edgecolor="black", linewidth=0.3, label=word or "not tried")
        for word, colour in VERDICT_COLOURS.items()
        if word in seen
    ]
    framed = Patch(facecolor="white", edgecolor="black", linewidth=1.6, label="base set")
    figure.legend(handles=[*handles, framed], loc="outside lower center", ncols=6)
