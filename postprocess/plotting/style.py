"""Common style of all figures: sizes, fonts, colours with a fixed meaning, and saving.

Figures are drawn at the width at which they are printed: no text is smaller than 7 points in a
column of 85 mm. Neither a display nor pyplot is used.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib.style
import xarray as xr
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from bladewhirl.files import replacing
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.netcdf import write_netcdf

P = ParamSpec("P")
R = TypeVar("R")

INCH = 0.0254  #: [m]
COLUMN_WIDTH = 0.085  #: one column of a page [m]
FULL_WIDTH = 0.17  #: the text width of a page [m]
NARROW = 0.13  #: panels are one above another in narrower figures [m]

COLOURS: Mapping[str, str] = {
    "total": "#000000",
    "rotor": "#000000",
    "suspension": "#009E73",
    "k = 0": "#0072B2",
    "k = 1": "#D55E00",
    "other k": "#E69F00",
    "casing": "#56B4E9",
    "contact": "#CC79A7",
    "rest": "#AAAAAA",
}
"""Colours of Okabe and Ito, distinct for colour-blind readers; a colour has the same meaning in all
figures."""

JOINT_STATES = {"open": "#FFFFFF", "stuck": "#7A828B", "slipping": COLOURS["k = 1"]}
"""Colours of the states of joints, in the order of their numbers."""

#: colours of lines without a meaning of their own; orange is reserved for k = 1
LINES = [COLOURS[name] for name in ("k = 0", "suspension", "contact", "total", "casing", "rest")]

COLOUR_MAPS: Mapping[str, LinearSegmentedColormap] = {
    name: LinearSegmentedColormap.from_list(name, colours)
    for name, colours in {
        "magnitude": ["#FFFFFF", "#D9F0C4", "#7FCDBB", "#41B6C4", "#1D91C0", "#225EA8", "#081D58"],
        "line": ["#6CC3C0", "#1D91C0", "#225EA8", "#081D58"],
        "wall": ["#FFFFFF", "#E0D8EC", "#B3A2D0", "#8465AF", "#54278F", "#260046"],
        "contact": ["#FBEAF4", COLOURS["contact"], "#4A1238"],
        "gap": ["#FFFFFF", "#9AA5B8"],
        "signed": ["#053061", "#4393C3", "#FFFFFF", "#D6604D", "#67001F"],
    }.items()
}
"""Colour maps of all figures, films and pages, distinct for colour-blind readers. Zero is white as
paper and larger is darker: magnitudes, also those of the blades; magnitudes along lines, which have
no white; those of the wall, among them wear; shares and forces of contact, where white is none;
gaps, paler than contact; and signed values, white at the middle."""

#: makes dark lines and letters legible on dark places of maps
OUTLINE = [withStroke(linewidth=2.0, foreground="white")]

STYLE: Mapping[str, Any] = {
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.5,
    "figure.titlesize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 1.5,
    "legend.columnspacing": 1.2,
    "lines.linewidth": 1.0,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": cycler(color=LINES),
    "axes.formatter.useoffset": False,
    "grid.linewidth": 0.4,
    "grid.color": "#DDDDDD",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "savefig.dpi": 300,
    "agg.path.chunksize": 10000,
    "pdf.fonttype": 42,  # TrueType: text in PDFs stays text
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "bladewhirl",  # the same figure gives the same file
}

FORMATS = ("png",)  #: default formats of a figure


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function so that it draws in the common style, regardless of user settings."""

    @wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> R:
        with matplotlib.style.context(["default", dict(STYLE)]):
            return draw(*args, **kwargs)

    return in_style


_width: ContextVar[float | None] = ContextVar("width", default=None)


@contextmanager
def at_width(width: float | None) -> Iterator[None]:
    """Draw all figures in the ``with`` block at a width [m]; None keeps the width of each."""
    token = _width.set(width)
    try:
        yield
    finally:
        _width.reset(token)


def drawn_width(width: float) -> float:
    """Return a width [m], or the one that `at_width` gives."""
    return _width.get() or width


@styled
def new_figure(*, width: float = COLUMN_WIDTH, height: float) -> Figure:
    """Return an empty figure in constrained layout, with a width [m], unless `at_width` gives
    another one, and a height [m]."""
    figure = Figure(figsize=(drawn_width(width) / INCH, height / INCH), layout="constrained")
    FigureCanvasAgg(figure)  # measures text without starting a picture for each text
    return figure


def is_narrow(figure: Figure) -> bool:
    """Return whether a figure is so narrow that its panels are one above another."""
    return bool(figure.get_figwidth() * INCH < NARROW)


def rows_of_panels(
    figure: Figure, rows: int, widths: Sequence[float], **options: Any
) -> list[list[Axes]]:
    """Return rows of panels with relative widths, (row, column), or all panels one above another in
    a narrow figure, which becomes higher; `options` are those of `Figure.subplots`."""
    count = len(widths)
    if is_narrow(figure):
        figure.set_figheight(count * figure.get_figheight())
        panels = figure.subplots(rows * count, 1, squeeze=False, **options)
    else:
        panels = figure.subplots(rows, count, squeeze=False, width_ratios=widths, **options)
    return [[*row] for row in panels.reshape(rows, count)]


def side_by_side(figure: Figure, count: int, **options: Any) -> list[Axes]:
    """Return panels in a row, see `rows_of_panels`."""
    return rows_of_panels(figure, 1, [1.0] * count, **options)[0]


def time_axis(*panels: Axes) -> None:
    """Show the times of panels in a suitable unit, and label the time axis of the last panel. The x
    values of the panels are times [s]."""
    unit, scale = handy_unit(max(abs(end) for end in panels[-1].get_xlim()), "s")
    for axes in panels:
        axes.locator_params(axis="x", nbins=5)
        axes.xaxis.set_major_formatter(lambda value, _: f"{scale * value:.6g}")
    panels[-1].set_xlabel(f"time [{unit}]")


@contextmanager
def laid_out(figure: Figure) -> Iterator[None]:
    """Lay out a figure once, instead of twice for each file written in the ``with`` block."""
    layout = figure.get_layout_engine()
    if layout is not None and figure.axes:
        layout.execute(figure)
        figure.set_layout_engine(None)
    try:
        yield
    finally:
        figure.set_layout_engine(layout)


@styled
def save_figure(
    figure: Figure,
    path: str | Path,
    data: xr.Dataset | None = None,
    formats: Sequence[str] = FORMATS,
) -> list[Path]:
    """Save a figure in one or more formats, and its data as netCDF; return the paths of the files.

    Args:
        figure: figure drawn in the common style.
        path: path of the files without suffix; a suffix .png, .pdf, .svg or .html is ignored. The
            folder is created if needed.
        data: data of the figure; None writes no netCDF file.
        formats: "png", "pdf", "svg", or "html", a page that states the values under the pointer.
    """
    path = Path(path)
    name = path.stem if path.suffix in (".png", ".pdf", ".svg", ".html") else path.name
    pictures = [path.with_name(f"{name}.{suffix}") for suffix in formats]
    with laid_out(figure):
        for picture, suffix in zip(pictures, formats, strict=True):
            if suffix == "html":
                from bladewhirl.postprocess.plotting.hover import write_figure_page

                write_figure_page(figure, picture)
                continue
            faster: Any = {"pil_kwargs": {"compress_level": 3}} if suffix == "png" else {}
            with replacing(picture) as draft:
                figure.savefig(draft, format=suffix, **faster)
    if data is None:
        return pictures
    beside = path.with_name(f"{name}.nc")
    with replacing(beside) as draft:
        write_netcdf(data, draft)
    return [*pictures, beside]
