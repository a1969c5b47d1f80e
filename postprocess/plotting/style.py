"""One style for every figure: sizes, fonts, colours with a fixed meaning, and how they are saved.

Figures are drawn at the width at which they are printed, so that a font size is a font size:
nothing is below 6.5 points in a column of 8 cm. No display and no pyplot state is involved;
matplotlib picks Agg for PNG and its own writer for PDF from the file's name.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from itertools import product
from pathlib import Path
from typing import Any, BinaryIO, ParamSpec, TypeVar

import matplotlib.style
import xarray as xr
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import Formatter, LogFormatter

from bladewhirl.meshes.files.drafts import replacing
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.netcdf import write_netcdf

P = ParamSpec("P")
R = TypeVar("R")

INCH = 0.0254  #: [m]
COLUMN_WIDTH = 0.08  #: one column of a page [m]
FULL_WIDTH = 0.17  #: the text width of a page [m]

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
"""Okabe and Ito's colours, told apart by colour-blind readers; one meaning in all figures."""

SEQUENTIAL = "cividis"
"""Colour map of magnitudes: even in lightness, the same with and without red-green vision."""

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
    "grid.linewidth": 0.4,
    "grid.color": "#DDDDDD",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "image.cmap": SEQUENTIAL,
    "savefig.dpi": 300,
    "agg.path.chunksize": 10000,
    "pdf.fonttype": 42,  # TrueType: text in PDFs stays text
}


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function that draws: it then draws in the common style, whatever the user's own
    matplotlib settings are.
    """

    @wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> R:
        with matplotlib.style.context(["default", dict(STYLE)]):
            return draw(*args, **kwargs)

    return in_style


@styled
def new_figure(*, width: float = COLUMN_WIDTH, height: float) -> Figure:
    """An empty figure of that size [m], arranged by the constrained layout when it is saved."""
    return Figure(figsize=(width / INCH, height / INCH), layout="constrained")


def time_axis(*panels: Axes) -> None:
    """Name the time axis of panels above each other, the last of them labelled, in a unit that
    reads well, with so few ticks that their labels stay apart.

    Args:
        panels: drawn over seconds.
    """
    unit, scale = handy_unit(max(abs(end) for end in panels[-1].get_xlim()), "s")
    for axes in panels:
        axes.locator_params(axis="x", nbins=5)
        axes.xaxis.set_major_formatter(lambda value, _: f"{scale * value:.6g}")
    panels[-1].set_xlabel(f"time [{unit}]")


LAYOUT_TABLES = ["GDEF", "GPOS", "GSUB", "kern"]
"""Tables of a font that place letters beside each other: matplotlib has done so already."""

PNG_OPTIONS: Mapping[str, Any] = {"compress_level": 3}
"""Half the time of the usual level, files a tenth larger."""


def print_png(figure: Figure, file: str | Path | BinaryIO) -> None:
    """Print a figure that is `arranged` as PNG."""
    FigureCanvasAgg(figure).print_png(file, pil_kwargs=dict(PNG_OPTIONS))  # type: ignore[no-untyped-call]


def _print_pdf(figure: Figure, file: Path) -> None:
    """Print a figure that is `arranged` as PDF, its fonts without `LAYOUT_TABLES`: to read these
    would take half of the time. matplotlib hands no options on to fontTools, so its list of tables
    to drop is another one meanwhile; where fontTools has no such list, nothing is left out.
    """
    from fontTools.subset import Options
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    name = "_drop_tables_default"
    dropped = getattr(Options, name, [])
    setattr(Options, name, [*dropped, *LAYOUT_TABLES])
    try:
        FigureCanvasPdf(figure).print_pdf(file)  # type: ignore[no-untyped-call]
    finally:
        setattr(Options, name, dropped)


class PowerFormatter(Formatter):
    """Labels of a logarithmic axis as letters of the font, 10⁻³ and 2×10⁻³: matplotlib typesets
    them as formulas, which takes a tenth of the time of a figure.
    """

    def __init__(self, typeset: LogFormatter) -> None:
        self._typeset = typeset

    def set_locs(self, locs: Sequence[float]) -> None:
        """Told by the axis: places of all ticks."""
        self._typeset.set_locs(locs)

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Label of a tick."""
        letters = re.sub(r"[$}]|\\mathdefault\{", "", self._typeset(x, pos))
        number, _, power = letters.replace(r"\times", "×").replace("-", "−").partition("^{")
        return number + power.translate(str.maketrans("−0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


@contextmanager
def arranged(figure: Figure, dpi: float) -> Iterator[None]:
    """Arrange a figure once, for all files that are printed of it at that resolution.

    `figure.savefig` would arrange it for each file, and twice.
    """
    arrangement, canvas, before = figure.get_layout_engine(), figure.canvas, figure.dpi
    figure.dpi = dpi
    for axes, name in product(figure.axes, "xy"):
        axis = getattr(axes, f"{name}axis")
        for formatter, change in (
            (axis.get_major_formatter(), axis.set_major_formatter),
            (axis.get_minor_formatter(), axis.set_minor_formatter),
        ):
            if isinstance(formatter, LogFormatter):
                change(PowerFormatter(formatter))
    if figure.axes and arrangement is not None:
        arrangement.execute(figure)
        figure.set_layout_engine("none")
    try:
        yield
    finally:
        figure.set_layout_engine(arrangement)
        figure.set_canvas(canvas)
        figure.dpi = before


@styled
def save_figure(figure: Figure, path: str | Path, data: xr.Dataset | None = None) -> list[Path]:
    """Save as PNG and PDF, with the data behind the figure beside them; returns the paths.

    Args:
        figure: drawn in the common style.
        path: where to, in a folder that is made if there is none; a suffix .png or .pdf gives way
            to .png, .pdf and .nc.
        data: goes to netCDF; None for pictures alone.
    """
    path = Path(path)
    name = path.stem if path.suffix in (".png", ".pdf") else path.name
    png, pdf, beside = (path.with_name(f"{name}{suffix}") for suffix in (".png", ".pdf", ".nc"))
    with arranged(figure, rcParams["savefig.dpi"]):
        with replacing(png) as draft:
            print_png(figure, draft)
        with replacing(pdf) as draft:
            _print_pdf(figure, draft)
    if data is None:
        return [png, pdf]
    with replacing(beside) as draft:
        write_netcdf(data, draft)
    return [png, pdf, beside]
