"""Values under the pointer for pictures of figures in pages: what matplotlib drew, in integers.

A page shows the picture of a figure; its script (`hover.js`) finds the drawn point or cell next to
the pointer, and states the coordinates that the axes have there. Positions are `FULL` times shares
of the picture, so that their digits are those that a reader could see.
"""

import base64
import io
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PathCollection, PolyQuadMesh, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle, StepPatch

from bladewhirl.files import write_atomically
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.files import filled_template

DPI = 200  #: resolution of the pictures: a column of 8 cm is as wide as half a screen [1/inch]
FULL = 10000  #: width and height of a picture in the unit of positions
MOST_POINTS = 600  #: largest number of points of a curve
MOST_CELLS = 160  #: largest number of rows and columns of a map


def hover_data(figure: Figure) -> list[dict[str, Any]]:
    """Return what can be pointed at in a figure that was drawn, panel by panel: `box` (left, top,
    right, bottom), the axes `x` and `y` with `label`, values at both ends and whether they are
    logarithmic, `curves` with a name and points x, y, and `maps` with a label, edges x and y and
    values (row, column). Polar panels are left out."""
    panels = []
    for axes in figure.axes:
        if axes.name != "rectilinear" or axes.get_label() == "<colorbar>" or not axes.axison:
            continue
        curves, maps = [*_curves(axes)], [*_maps(axes)]
        if curves or maps:
            left, low, right, top = axes.get_position().extents * FULL
            box = [round(each) for each in (left, FULL - top, right, FULL - low)]
            both = {"x": _axis(_labelled(axes)), "y": _axis(axes.yaxis)}
            panels.append({"box": box, **both, "curves": curves, "maps": maps})
    return panels


def as_png(figure: Figure) -> str:
    """Return a figure that is laid out as PNG in base64."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return base64.b64encode(file.getvalue()).decode("ascii")


def write_figure_page(figure: Figure, path: Path) -> None:
    """Write a figure that is laid out as an HTML page, which needs no network."""
    text = filled_template(
        __package__,
        "figure.html",
        title=figure.get_suptitle() or path.stem,
        picture=as_png(figure),
        values=hover_data(figure),
        script=script(),
    )
    write_atomically(path, text)


def script() -> str:
    """Return the script that shows the values."""
    return resources.files(__package__).joinpath("hover.js").read_text("utf-8")


def _labelled(axes: Axes) -> Axis:
    """Return the x axis of a panel or, if it has no label, of a panel below that shares it."""
    below = axes.get_shared_x_axes().get_siblings(axes)
    named = [each.xaxis for each in (axes, *below) if each.get_xlabel()]
    return named[0] if named else axes.xaxis


def _axis(axis: Axis) -> dict[str, Any]:
    """Return label, values at both ends as the ticks show them, and whether it is logarithmic."""
    ends = np.array(axis.get_view_interval(), dtype=np.float64)
    scale = 1.0  # of ticks whose formatter has another unit than the data
    try:
        largest = float(ends[np.abs(ends).argmax()])
        scale = float(axis.get_major_formatter()(largest, None)) / largest
        power = round(np.log10(scale))
        scale = 10.0**power if abs(np.log10(scale) - power) < 1e-3 else 1.0
    except (ValueError, ZeroDivisionError, OverflowError):
        scale = 1.0
    text = axis.get_label_text()
    label = (
        " ".join(text.split()) if axis is axis.axes.yaxis else text.partition("\n")[0].strip(",")
    )
    return {"label": label, "ends": (scale * ends).tolist(), "log": axis.get_scale() == "log"}


def _placed(axes: Axes, points: Array) -> Array:
    """Return points (point, 2) of the data as positions in the picture, from its top left."""
    figure = axes.get_figure(root=True)
    shares = axes.transData.transform(points) / figure.bbox.size  # type: ignore[union-attr]
    return np.asarray(np.column_stack([shares[:, 0], 1.0 - shares[:, 1]]) * FULL)


def _curves(axes: Axes) -> Iterator[dict[str, Any]]:
    """Yield lines, marks, steps and bars of a panel."""
    found: list[tuple[str, Array]] = []
    for line in axes.lines:
        if line.get_transform() == axes.transData:
            name = line.get_gid() or line.get_label()  # one of several lines of a label
            found.append((str(name), np.asarray(line.get_xydata(), dtype=np.float64)))
    for marks in axes.collections:
        if isinstance(marks, PathCollection):
            found.append((str(marks.get_label()), np.ma.filled(marks.get_offsets(), np.nan)))
    for patch in axes.patches:
        if isinstance(patch, StepPatch):
            values, edges, _ = patch.get_data()
            middles = 0.5 * (edges[1:] + edges[:-1])
            found.append(("", np.column_stack([middles, np.asarray(values, dtype=np.float64)])))
    for bars in axes.containers:
        if isinstance(bars, BarContainer):
            own = [bar for bar in bars.patches if isinstance(bar, Rectangle)]
            tops = [(b.get_x() + b.get_width() / 2, b.get_y() + b.get_height()) for b in own]
            found.append((str(bars.get_label()), np.array(tops, dtype=np.float64).reshape(-1, 2)))
    for name, points in found:
        known = points[np.isfinite(points).all(axis=1)]
        known = known[:: max(1, -(-len(known) // MOST_POINTS))]
        if len(known):
            places = np.round(_placed(axes, known))
            inside = np.abs(places) < 10 * FULL
            places = places[inside.all(axis=1)].astype(int)
            yield {"name": "" if name.startswith("_") else name, "points": places.tolist()}


def _maps(axes: Axes) -> Iterator[dict[str, Any]]:
    """Yield the maps of a panel, with the labels of their colour bars."""
    for mesh in axes.collections:
        if not isinstance(mesh, (QuadMesh, PolyQuadMesh)) or mesh.get_array() is None:
            continue
        corners: Array = np.asarray(mesh.get_coordinates())
        given: Any = mesh.get_array()
        if given.dtype.kind != "f":  # numbers of classes
            continue
        values: Array = np.ma.filled(np.ma.masked_invalid(given), np.nan)
        values = values.reshape(np.array(corners.shape[:2]) - 1)
        if np.isnan(values).all():
            continue
        rows, columns = (max(1, -(-size // MOST_CELLS)) for size in values.shape)
        across = _placed(axes, corners[0, ::columns])[:, 0]
        up = _placed(axes, corners[::rows, 0])[:, 1]
        bar = mesh.colorbar
        label = "" if bar is None else bar.ax.get_ylabel() or bar.ax.get_xlabel()
        cells = values[::rows, ::columns]
        texts = [[None if np.isnan(v) else float(f"{v:.4g}") for v in row] for row in cells]
        edges = {"x": across, "y": up}
        yield {
            "label": " ".join(label.split()),
            **{way: np.round(each).astype(int).tolist() for way, each in edges.items()},
            "values": texts,
        }
