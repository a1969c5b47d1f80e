"""Report of a sweep: regimes, maps, points and case."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.growth_rates import CERTAINTY, rate_text
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.plotting.axes import SPEED
from bladewhirl.postprocess.reports import page
from bladewhirl.postprocess.reports.parts import (
    REGIMES,
    Provenance,
    case_section,
    criterion_table,
    key_heading,
    subject,
)
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.sweep.dataset import SCREENED, swept, swept_keys
from bladewhirl.postprocess.sweep.drawing import in_handy_units, key_label, line_label
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.postprocess.sweep.probability import probability
from bladewhirl.postprocess.sweep.quantities import (
    LINE,
    along,
    largest_motion,
    main_key,
    other_keys,
    table_keys,
)
from bladewhirl.solvers.march.schema import DRAW

WINDOWED = ("frequency-map", "energy-families", "node-spectra")
"""Figures of spectra and mean energies; the attribute `window` of a sweep states their time window.
All other figures describe the last third of the time."""

MOST_NAMED = 10  #: largest number of points with an uncertain outcome that are named
MOST_POINTS = 2000  #: largest number of points in the table; more points make a page slow


def sweep_report(
    dataset: xr.Dataset,
    provenance: Provenance,
    failures: Sequence[tuple[str, str]] = (),
    *,
    name: str = "",
    links: Mapping[int, str] | None = None,
) -> page.Page:
    """Return the report of a sweep, for `page.write_page`.

    The report of an unfinished sweep contains the points that are finished.

    Args:
        dataset: from `open_sweep`.
        provenance: provenance of the sweep.
        failures: values of the swept keys, and reason, of each failed point.
        name: name of the sweep, such as its folder.
        links: reports of points by the numbers of the points.
    """
    state = dataset["state"].values
    done, failed = int((state == "done").sum()), int((state == "failed").sum())
    needed = state.size - int((state == "not-needed").sum())
    points = _points(dataset) if done else None
    regimes = points["regime"].values if points is not None else np.empty(0)
    counts = {name: n for name in REGIMES if (n := int((regimes == name).sum()))}
    verdict, tone = _verdict(counts, needed, done, failed)
    keys = [str(dataset[key].attrs["long_name"]) for key in _keys(dataset)]
    blocks: dict[str, list[page.Block]] = {
        name: [*_drawn(dataset, name)] for name in ("regimes", "frequencies", "motion", "points")
    }
    if failures:
        head = ("point", "reason")
        table = page.PageTable(name="failures", title="Failed points", head=head, rows=failures)
        blocks["points"].append(table)
    if points is not None:
        blocks["points"].append(_point_table(points, links or {}))
        blocks["motion"] = [_linked(block, points, links or {}) for block in blocks["motion"]]
    blocks["regimes"].append(criterion_table())
    titles = ("Regimes", "Frequencies", "Motion and contact", "Points")
    sections = [
        page.PageSection(name=name, title=title, blocks=parts)
        for (name, parts), title in zip(blocks.items(), titles, strict=True)
        if parts
    ]
    way = {"up": "rising", "down": "falling"}.get(str(dataset.attrs.get("carry")))
    return page.Page(
        title=(str(dataset.attrs.get("title", "")) or "Sweep") + ", sweep",
        subject=subject(dataset, provenance, name),
        verdict=verdict,
        tone=tone,
        reason=" ".join(
            [
                f"Swept: {', '.join(keys)}.",
                REGIMES[next(iter(counts))].meaning if counts else "",
                _certainty(dataset) if done and DRAW in dataset.dims else "",
                _screening(dataset) if done and SCREENED in dataset else "",
                f"The motion was carried from speed to speed, with {way} speed." if way else "",
                _starts(dataset) if done and has(dataset, "start") else "",
            ]
        ),
        warnings=_warnings(needed, done, failed),
        figures=_glance(dataset, points, counts, done),
        sections=[*sections, _case_section(dataset, provenance)],
    )


def _keys(dataset: xr.Dataset) -> list[str]:
    """Return the dimensions of the sweep: the swept keys and, if any, the random draws."""
    return swept_keys(dataset) + [DRAW] * (DRAW in dataset.dims)


def _points(dataset: xr.Dataset) -> xr.Dataset:
    """Return the quantities of every point, with dimensions as in `sweep.quantities`; the swept
    keys are in convenient units."""
    largest, what = largest_motion(dataset)
    names = ["regime", largest, "growth_rate", "growth_error", "end_time", "number"]
    numbers = np.arange(dataset["state"].size).reshape(dataset["state"].shape)
    dataset = dataset.assign(number=(dataset["state"].dims, numbers))
    names += [SCREENED] if SCREENED in dataset else []
    points = in_handy_units(along(dataset, main_key(dataset), [*names, "contact_share"]))
    touched = (points["contact_share"] > 0).sum("blade")
    regime = points["regime"].where(points["state"] == "done", "no result")
    points = points.assign(touched=touched, regime=regime).drop_vars("contact_share")
    return points.rename({largest: "largest_displacement"}).assign_attrs(moving=what)


def _verdict(counts: Mapping[str, int], points: int, done: int, failed: int) -> tuple[str, str]:
    """Return the verdict and its `tone` (see `page.Page`): the worst regime of all points, with the
    number of points in this regime."""
    if not counts:
        return "No result yet" if points > failed else "No result", "open"
    worst = next(iter(counts))
    where = f"{counts[worst]} of {done} points" if counts[worst] < done else f"all {done} points"
    so_far = " so far" if done + failed < points else ""
    return f"{REGIMES[worst].name} at {where}{so_far}", REGIMES[worst].tone


def _certainty(dataset: xr.Dataset) -> str:
    """Return a sentence on the points of a sweep with random draws whose outcome is uncertain."""
    shares = in_handy_units(probability(dataset))
    interval = "the 95 % interval of the share of"
    if not shares["uncertain"].any():
        return f"The outcome is certain at every point: {interval} each regime excludes one half."
    places = [
        line_label(shares.isel({LINE: line, str(shares.attrs["along"]): number}))
        for line, number in np.argwhere(shares["uncertain"].values)
    ]
    named = "; ".join(places[:MOST_NAMED]) + ("; ..." if len(places) > MOST_NAMED else "")
    return (
        f"The outcome is uncertain at {len(places)} of {shares['uncertain'].size} points, where"
        f" {interval} a regime includes one half: {named}."
    )


def _starts(dataset: xr.Dataset) -> str:
    """Return a sentence on the marches that start on periodic motions."""
    done = dataset["state"] == "done"
    count = int(((dataset["start"] == "periodic") & done).sum())
    return (
        f"{count} of {int(done.sum())} marches start on a periodic motion; others start at rest,"
        " because none was found."
    )


def _screening(dataset: xr.Dataset) -> str:
    """Return a sentence on the screened points of a sweep."""
    done = dataset["state"] == "done"
    screened = ((dataset[SCREENED] == "yes") & done).any(DRAW)
    return (
        f"{int(screened.sum())} of {int(done.any(DRAW).sum())} points were screened with scaled"
        " masses of the casing, and are marked in the table of points; where the regimes of"
        " the random draws differed, draws were repeated with the time step of the case until the"
        " outcome was known."
    )


def _warnings(points: int, done: int, failed: int) -> list[str]:
    missing = points - done - failed
    unfinished = (
        f"The sweep is unfinished: {missing} of {points} points are missing; bladewhirl sweep "
        "--resume finishes it."
    )
    failures = f"{failed} of {points} points failed; the reasons are listed under Points."
    return [text for text, count in ((unfinished, missing), (failures, failed)) if count]


def _glance(
    dataset: xr.Dataset, points: xr.Dataset | None, counts: Mapping[str, int], done: int
) -> list[tuple[str, str, str]]:
    """Return the key figures: name, value, remark."""
    left = int((dataset["state"].values == "not-needed").sum())
    remark = f"{left} random draws skipped" if left else ""
    rows = [("points done", f"{done} of {dataset['state'].size}", remark)]
    attributes = {} if points is None else points.attrs
    keys = in_handy_units(dataset[_keys(dataset)].assign_attrs(attributes))
    for key in (keys[name] for name in _keys(dataset)):
        first, last, unit = key.values.min(), key.values.max(), str(key.attrs["units"])
        remark = f"{key.size} values" + ("" if unit == "1" else f", {unit}")
        if key_label(key) == SPEED and "reference_hz" in attributes:
            rpm = 60.0 * float(attributes["reference_hz"])
            remark += f", Ω/ω₁; {rpm * first:.0f} to {rpm * last:.0f} rpm"
        text = f"{first:.5g} to {last:.5g}" if key.size > 1 else f"{first:g}"
        rows.append((str(key.attrs["long_name"]), text, remark))
    return rows + [
        (name, str(count), f"{100 * count / done:.3g} %") for name, count in counts.items()
    ]


def _drawn(dataset: xr.Dataset, section: str) -> list[page.ReportFigure]:
    """Return the figures of a section that this sweep has: maps only with two or more swept keys,
    probabilities only with random draws, and wear only with a coating."""
    figures = SweepFigures(dataset)
    worn = "wear_volume" in dataset and bool(np.isfinite(dataset["wear_volume"]).any())
    absent = {
        "maps": len(swept(dataset)) == 1,
        "interaction": len(swept(dataset)) == 1,
        "probability": DRAW not in dataset.dims,
        "wear": not worn,
    }
    left_out = [name for name, without in absent.items() if without]
    return [
        replace(figure, caption=_windowed(dataset, figure.caption))
        if figure.name in WINDOWED
        else figure
        for figure in page.report_figures(figures, section, left_out)
    ]


def _windowed(dataset: xr.Dataset, caption: str) -> str:
    """Return a caption with the time window of spectra and mean energies added."""
    window = str(dataset.attrs.get("window", ""))
    return f"{caption} {window[:1].upper()}{window[1:]}." if window else caption


def _linked(block: page.Block, points: xr.Dataset, links: Mapping[int, str]) -> page.Block:
    """Return a block; points of the interaction map over two keys open their reports."""
    if not links or block.name != "interaction" or not isinstance(block, page.ReportFigure):
        return block
    numbers = points["number"].values.astype(int)  # (value of the other key, key)
    pages = [[links.get(number) for number in row] for row in numbers.tolist()]
    hover = [
        {**panel, "links": pages} if np.shape(each["values"]) == numbers.shape else panel
        for panel in block.hover
        for each in panel["maps"][-1:]
    ]
    return replace(block, hover=hover)


def _point_table(points: xr.Dataset, links: Mapping[int, str]) -> page.PageTable:
    key = points[str(points.attrs["along"])]
    listed, others = table_keys(points), other_keys(points)
    column = {str(name): points[name].values for name in points.data_vars}
    screened = column.get(SCREENED, np.full(column["state"].shape, "no")) == "yes"
    screened &= column["state"] == "done"
    rows = [
        (
            f"{at:.6g}",
            *(f"{values[n]:.6g}" for values in listed),
            *(f"{other.values[line]:.6g}" for other in others),
            str(column["regime" if column["state"][line, n] == "done" else "state"][line, n])
            + (", screened" if screened[line, n] else ""),
            _number(MILLI * column["largest_displacement"][line, n]),
            rate_text(column["growth_rate"][line, n], column["growth_error"][line, n]),
            _number(column["touched"][line, n] if column["state"][line, n] == "done" else np.nan),
            _number(column["end_time"][line, n]),
        )
        for line in range(points.sizes[LINE])
        for n, at in enumerate(key.values)
    ]
    left_out = len(rows) - MOST_POINTS
    return page.PageTable(
        name="all-points",
        title=f"All points ({len(rows)})",
        caption=f"Growth rates ± {CERTAINTY:g} standard errors."
        + (f" First {MOST_POINTS} points; all are in the dataset." if left_out > 0 else ""),
        head=(
            *map(key_heading, (key, *listed, *others)),
            "regime",
            f"largest recorded displacement of the {points.attrs['moving']} [mm]",
            "growth rate [1/s]",
            "blades that touched",
            "end [s]",
        ),
        rows=rows[:MOST_POINTS],
        links={row: links[n] for row, n in enumerate(column["number"].ravel()) if n in links},
        numbers=True,
        folded=True,
    )


def _case_section(dataset: xr.Dataset, provenance: Provenance) -> page.PageSection:
    """Return the resolved case, with the swept keys in the caption."""
    keys = swept_keys(dataset)
    settings = " ".join(f"--set {dataset[key].attrs['long_name']}=VALUE" for key in keys)
    caption = (
        "All keys of the case with their values in SI units; the values of swept keys "
        "differ from point to point. Save these lines as a case file; bladewhirl run with this "
        f"file and {settings} (in SI units, or with a unit) repeats a point."
    )
    return case_section(dataset, provenance, caption)


def _number(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "–"
