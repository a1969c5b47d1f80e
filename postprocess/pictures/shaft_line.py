"""Stills and films of a whole shaft line with the orbits at its bearings."""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.case.shaft_line import ShaftLine, Wheel
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.pictures import films
from bladewhirl.postprocess.pictures.offscreen import Pixels
from bladewhirl.postprocess.plotting.files import checked_target
from bladewhirl.postprocess.plotting.legends import entries_of
from bladewhirl.postprocess.plotting.style import COLOURS, styled
from bladewhirl.postprocess.shaft_line.rotor import Rotor, draw_rotor, rotor_of

SIZE, DPI, GIF_DPI = (8.0, 4.5), 160, 120  #: width and height [in], pixels per inch
SHOWN = 1.0  #: largest deflection in a picture as a multiple of the largest radius of the shaft
MOST = 4  #: largest number of bearings whose orbits have a panel


def _further_wheels(
    result: xr.Dataset, rows: list[dict[str, Any]]
) -> Iterator[tuple[float, float]]:
    """Yield position and radius [m] of the further wheels of which a result has points."""
    if not has(result, "further points"):
        return
    radius = np.hypot(*result["further_point"].values[:, :2].T)
    for number, row in enumerate(rows, start=1):
        own = radius[result["further_point_wheel"].values == number]
        if len(own):
            yield Wheel(position=row["position"]).position, float(own.max())


def is_line(result: xr.Dataset) -> bool:
    """Return whether a result is that of a shaft line without blades."""
    return has(result, "line") and not result.sizes["contact_node"]


def largest_deflection(result: xr.Dataset) -> int:
    """Return the record with the largest displacement of the axis across it."""
    moved = result["shaft_displacement"].values
    return int(np.hypot(moved[..., 0], moved[..., 1]).max(axis=1).argmax())


@styled
def render_line(
    result: xr.Dataset,
    path: str | Path,
    records: IntArray,
    *,
    exaggeration: float | None = None,
    progress: films.Progress | None = None,
) -> Path:
    """Draw records of a run of a shaft line as PNG, GIF or MP4; return the path.

    The rotor is seen obliquely, with displacements multiplied by a factor; beside it are the orbits
    at the bearings, of the last turn.

    Args:
        result: result of a run with a shaft line.
        path: path of the file.
        records: numbers of the records; the first one only for a PNG.
        exaggeration: factor on displacements; automatic if None.
        progress: called with the numbers of finished and of all pictures of a film.

    Raises:
        ViewError: the result has no shaft line, or the suffix is unknown.
    """
    target = checked_target(path, ".png", ".gif", ".mp4")
    if not has(result, "line"):
        raise ViewError("view: expected another view; the run has no shaft line")
    moved = result["shaft_displacement"].values
    place, slope = moved[..., 0] + 1j * moved[..., 1], moved[..., 4] - 1j * moved[..., 3]
    supports = result["support_displacement"].values
    given = tomllib.loads(result.attrs["case"])["shaft_line"]
    further = given.pop("wheels", [])  # whose files may have moved
    table, title = ShaftLine(**given), str(result.attrs["title"])
    wheels = [] if table.wheel is None else [(table.wheel.position, result.attrs["tip_radius"])]
    wheels += _further_wheels(result, further)
    rotor = rotor_of(table, result["shaft_position"].values, title=title, wheels=wheels)
    largest = float(np.abs(place[records]).max()) or 1.0
    factor = exaggeration or _rounded(SHOWN * float(rotor.radius.max()) / largest)
    turned = 2.0 * np.pi * rotation.turns(result) * np.sign(float(result.attrs["speed"]) or 1.0)
    at_bearings = place[:, result["bearing_node"].values]
    shown = at_bearings[_turn_before(turned, int(records[0])) : int(records[-1]) + 1]
    figure = Figure(figsize=SIZE, dpi=GIF_DPI if target.suffix.lower() == ".gif" else DPI)
    canvas = FigureCanvasAgg(figure)

    def picture(number: int) -> Pixels:
        record = int(records[number])
        trail = at_bearings[_turn_before(turned, record) : record + 1]
        figure.clear()
        axes = figure.add_axes((0.01, 0.06, 0.7, 0.84))
        draw_rotor(
            axes,
            rotor,
            deflection=factor * place[record],
            slope=factor * slope[record],
            support=factor * (supports[record, :, 0] + 1j * supports[record, :, 1]),
            angle=float(turned[record]),
        )
        _draw_orbits(figure, rotor, trail, shown)
        seconds, speed = result["time"].values[record], rotation.speeds(result)[record]
        texts = f"{handy(float(seconds), 's', 4)}, {speed * 30.0 / np.pi:.5g} rpm"
        figure.text(0.02, 0.94, title, fontsize=9)
        figure.text(0.02, 0.03, f"{texts}, displacements × {factor:.4g}", fontsize=8)
        if entries := entries_of(axes):
            handles, labels = zip(*entries, strict=True)
            figure.legend(handles, labels, loc="lower right", ncols=2, bbox_to_anchor=(0.76, 0.0))
        turns = "x and y at the bearings in the last turn"
        figure.text(0.98, 0.97, turns, fontsize=7, ha="right", va="center")
        drawn: Any = canvas  # whose methods matplotlib leaves untyped
        drawn.draw()
        return np.asarray(drawn.buffer_rgba())[..., :3].copy()

    return films.write_pictures(target, picture, len(records), progress)


def _turn_before(turned: FloatArray, record: int) -> int:
    """Return the first record of the turn that ends with a record; `turned` is the angle of the
    rotation at each record [rad]."""
    return int(np.searchsorted(np.abs(turned), abs(turned[record]) - 2.0 * np.pi))


def _draw_orbits(figure: Figure, rotor: Rotor, trail: ComplexArray, shown: ComplexArray) -> None:
    """Draw the last turn at the bearings, (records, bearings); `shown` gives the scale."""
    count = min(len(rotor.bearings), MOST)
    height = 0.86 / count
    side = min(0.2, 0.75 * height * SIZE[1] / SIZE[0])
    for number in range(count):
        axes = figure.add_axes(
            (0.98 - side, 0.95 - height * (number + 1) + 0.04, side, side * SIZE[0] / SIZE[1])
        )
        own = shown[:, number]
        middle = complex(own.real.max() + own.real.min(), own.imag.max() + own.imag.min()) / 2.0
        reach = 1.1 * float(np.abs(own - middle).max()) or 1e-9
        unit, scale = handy_unit(float(np.abs(own).max()) or 1e-9, "m")
        axes.plot(*scale * _parts(trail[:, number]), color=COLOURS["contact"])
        axes.plot(*scale * _parts(trail[-1:, number]), "o", color=COLOURS["rotor"], markersize=3.0)
        axes.set_xlim(scale * (middle.real - reach), scale * (middle.real + reach))
        axes.set_ylim(scale * (middle.imag - reach), scale * (middle.imag + reach))
        axes.set_title(f"bearing {rotor.bearings[number][0]} [{unit}]", pad=2.0)
        axes.locator_params(nbins=4)


def _parts(values: ComplexArray) -> FloatArray:
    """Return real and imaginary parts, (2, values)."""
    return np.stack([values.real, values.imag])


def _rounded(factor: float) -> float:
    """Return a factor rounded down to one digit."""
    size = 10.0 ** np.floor(np.log10(factor))
    return float(np.floor(factor / size) * size)
