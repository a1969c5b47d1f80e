"""Colours, sizes, words and the inset of the shaft's orbit, the same in whatever draws a stage."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb

from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, history, rotate, turn
from bladewhirl.postprocess.pictures.colouring import Colouring, scale_end
from bladewhirl.postprocess.pictures.drawing import Frame
from bladewhirl.postprocess.pictures.symbols import Symbols

INK = "#20262e"
FAINT = "#5f6872"
BACKGROUND = "white"
NO_VALUE = "#cdd2d8"  #: of what has no value of the field that colours the rest
MASS_COLOUR = "#f0e442"  #: yellow, apart from the colours of parts
FORCE_COLOUR = "#d55e00"  #: vermilion, apart from the whole map in every kind of colour vision

# Sizes of drawn things, as shares of the picture's radius.
OUTLINE = 0.0035
HUB = 0.022
MARK = 0.014
RIM = 0.006  #: light, around hub and mark, which stand on parts of any colour
EDGE = 0.002  #: light, on both sides of strokes
CONTACT_DISC = 0.014
ARROW_WIDTH = 0.011
LONGEST_ARROW = 0.17
SPRING, GROUND, STRUT = 0.0032, 0.0026, 0.011  #: widths of strokes
MARGIN = 1.04

FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
"""The font of matplotlib's figures, so that pictures and plots look alike."""

FINER = 2  #: points drawn for a pixel, across and up

SQUARE = 0.75
"""Share of a picture's width that the stage takes; the panel has the rest."""


def strokes_of(symbols: Symbols) -> list[tuple[str, float, str, Array]]:
    """Name, width, colour and ends (stroke, 2, 2) of each kind of stroke, lowest first."""
    return [
        ("struts", STRUT, INK, symbols.struts),
        ("ground", GROUND, FAINT, symbols.ground),
        ("springs", SPRING, INK, symbols.springs),
        ("dampers", SPRING, INK, symbols.dampers),
    ]


def scene_colours(colouring: Colouring, levels: int) -> Array:
    """The colours (colour, 3) between 0 and 1 that a picture is made of, the map's in steps."""
    own = [BACKGROUND, INK, FAINT, FORCE_COLOUR, NO_VALUE, MASS_COLOUR]
    return np.array([to_rgb(colour) for colour in [*own, *colouring.colours(levels)]])


def contact_words(forces: Array) -> str:
    """How many blades touch, and the largest force with friction, from forces (blade, 2) [N]."""
    size = np.linalg.norm(forces, axis=1)
    touching = int(np.count_nonzero(size))
    if not touching:
        return "no contact"
    largest = f"largest force {handy(float(size.max()), 'N', 3)},\nwith friction"
    return f"{touching} of {len(size)} blades touch\n{largest}"


def speed_words(dataset: xr.Dataset) -> str:
    """The speed in three units, a line each."""
    speed = float(dataset.attrs["speed"])
    relative = speed / float(dataset.attrs["reference_frequency"])
    return f"{speed:.5g} rad/s\n{speed * 30 / np.pi:.5g} rpm\nΩ/ω₁ = {relative:.4g}"


DOTS = "dots: centre and blade 0"
"""What the dots of a picture mark."""


def enlargement(factor: float) -> str:
    """The exaggeration in words."""
    if factor == 1:
        return "true size"
    return f"displacement and clearance\ndrawn {factor:g} times as large"


class ShaftTrail(NamedTuple):
    """Places of the centre over time."""

    places: Array  #: in units of the circle's radius (record, 2)
    title: str  #: which says how large the circle is


def shaft_trail(dataset: xr.Dataset, records: IntArray, frame: Frame) -> ShaftTrail:
    """The centre at records, in static or rotating axes."""
    rows = dataset["rotor_shape"].values[int(dataset["centre_node"]), :2]
    way = history(dataset, "rotor_displacement", records) @ rows.T
    if frame == "static":
        way = rotate(way, turn(dataset, records))
    reach = float(np.linalg.norm(way, axis=1).max())
    unit, scale = handy_unit(reach, "m")
    end = scale_end(1.1 * scale * reach)  # the orbit stays clear of the circle
    title = f"shaft\N{RIGHT SINGLE QUOTATION MARK}s orbit, circle r = {end:g} {unit}"
    return ShaftTrail(scale / end * way, title)
