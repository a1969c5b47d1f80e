"""Colours, sizes, captions and the inset of the orbit, common to all pictures of a stage."""

from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, history, turn
from bladewhirl.postprocess.fields.netcdf import need
from bladewhirl.postprocess.pictures.choices import Frame
from bladewhirl.postprocess.pictures.colouring import scale_end
from bladewhirl.postprocess.pictures.symbols import Symbols

INK = "#20262e"
FAINT = "#5f6872"
BACKGROUND = "white"
NO_VALUE = "#cdd2d8"  #: colour of places where the field has no value
MASS_COLOUR = "#f0e442"  #: colour of point masses, distinct from the colours of parts
FORCE_COLOUR = "#d55e00"  #: colour of forces, distinct from colour maps for colour-blind readers

# Sizes relative to the radius of the picture.
OUTLINE = 0.0035
HUB = 0.022
MARK = 0.014
RIM = 0.006  #: width of the light rim around hub and mark
EDGE = 0.002  #: width of the light edge on both sides of strokes
CONTACT_DISC = 0.014
NODE_DISC = 0.02  #: of contact nodes that have a value
ARROW_WIDTH = 0.011
LONGEST_ARROW = 0.17
ROUND = (1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
"""Leading digits of the newtons that a metre of an arrow stands for."""
SPRING, GROUND, STRUT = 0.0032, 0.0026, 0.011  #: widths of strokes
MARGIN = 1.04
EDGE_WIDTH = 1.5  #: width of the edges of surfaces [rendered points]

#: font of the figures
FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
FINER = 2  #: number of rendered points per pixel, in each direction

SQUARE = 0.75  #: width of the stage divided by that of the picture; the panel has the rest


def strokes_of(symbols: Symbols) -> list[tuple[str, float, str, Array]]:
    """Return name, width, colour and end points (stroke, 2, 2) of each kind of stroke, in the order
    of drawing."""
    return [
        ("struts", STRUT, INK, symbols.struts),
        ("ground", GROUND, FAINT, symbols.ground),
        ("springs", SPRING, INK, symbols.springs),
        ("dampers", SPRING, INK, symbols.dampers),
    ]


def time_text(time: float, step: float) -> str:
    """Return a time [s] as text, with the decimals that distinguish records a `step` [s] apart."""
    decimals = max(1, int(np.ceil(-np.log10(1e3 * step) - 1e-9)))
    return f"t = {1e3 * time:.{decimals}f} ms"


def contact_text(forces: Array, step: float) -> str:
    """Return a text with the number of blades in contact and the largest of the sizes of the
    contact `forces` on the blades (blade,) [N], which are means over a `step` [s]."""
    touching = int(np.count_nonzero(forces))
    if not touching:
        return "no contact"
    largest, over = handy(float(forces.max()), "N", 3), handy(step, "s", 3)
    if len(forces) == 1:
        few, where = "blade in contact", "on all its nodes"
    else:
        few, where = f"{touching} of {len(forces)} blades in contact", "at most on a blade"
    return f"{few}\n{largest} {where}\nwith friction, over {over}"


def speed_text(reference: float, *speeds: float) -> str:
    """Return one or several speeds [rad/s] as text of three lines: rad/s, rpm, multiple of the
    reference frequency [rad/s]."""

    def ends(scale: float) -> str:
        each = dict.fromkeys(f"{scale * speed:.5g}" for speed in (min(speeds), max(speeds)))
        return " to ".join(each)

    return f"{ends(1.0)} rad/s\n{ends(30 / np.pi)} rpm\nΩ/ω₁ = {ends(1.0 / reference)}"


def metres_per_newton(largest: float, size: float) -> float:
    """Return the length of the arrow of a force of 1 N [m/N], such that the arrow of the `largest`
    force [N] has at most the share `LONGEST_ARROW` of the `size` of the picture [m], and a metre is
    a round number of newtons; 0 without a force."""
    if not largest:
        return 0.0
    newtons = largest / (LONGEST_ARROW * size)
    steps = 10.0 ** np.floor(np.log10(newtons)) * np.array(ROUND)
    return 1.0 / float(steps[np.searchsorted(steps, newtons)])


def bar_text(length: float, enlarged: str, factor: float, metres_per_newton: float) -> str:
    """Return the lines next to a scale bar: its length [m], and the true size of the `enlarged`
    quantities and of the forces that are drawn as long as the bar.

    Args:
        length: length of the bar [m].
        enlarged: quantities that are drawn larger; "" if none has a size.
        factor: their factor.
        metres_per_newton: length of the arrow of a force; 0 without arrows.
    """
    lines = [handy(length, "m", 4)]
    if factor != 1 and enlarged:
        lines.append(f"{handy(length / factor, 'm', 3)} of {enlarged}")
    if metres_per_newton:
        lines.append(f"{handy(length / metres_per_newton, 'N', 3)} of force")
    return "\n".join(lines)


def enlargement(factor: float, *, normalised: bool = False) -> str:
    """Return the text that states the `factor` of displacement and clearance, or that the amplitude
    of a `normalised` motion is arbitrary."""
    if normalised:
        return "normalised:\nthe amplitude of a mode\nis arbitrary"
    if factor == 1:
        return "true size"
    return f"displacement and clearance\ndrawn {factor:g} times as large"


def shaft_trail(dataset: xr.Dataset, records: IntArray, frame: Frame) -> tuple[Array, str]:
    """Return the path of the shaft's centre at some records, for an inset with a circle as a scale.

    Returns:
        positions in static or rotating axes, relative to the radius of the circle (record, 2);
        title of the inset, with the radius of the circle.

    Raises:
        ResultError: the rotor has no centre that moves.
    """
    need(dataset, "centre_shape")
    way = history(dataset, "rotor_displacement", records) @ dataset["centre_shape"].values.T
    if frame == "static":
        way = rotate(way, turn(dataset, records))
    reach = float(np.linalg.norm(way, axis=1).max())
    unit, scale = handy_unit(reach, "m")
    end = scale_end(1.1 * scale * reach)  # the circle is larger than the orbit
    title = f"shaft\N{RIGHT SINGLE QUOTATION MARK}s orbit, circle r = {end:g} {unit}"
    return scale / end * way, title
