"""What figures of joints share: colours of some of many curves, and lines of the linear limits."""

from typing import Any

import numpy as np

from bladewhirl.postprocess.plotting.style import COLOUR_MAPS

DASHES = ("-", "--", ":")  #: lines of the limits free, closed without friction, stuck


def some_of(count: int, most: int) -> list[tuple[int, Any]]:
    """Return the numbers and the colours of at most so many of the curves, the first and the last
    among them."""
    chosen = np.unique(np.linspace(0, count - 1, most).round().astype(int))
    shades = COLOUR_MAPS["line"](np.linspace(0.0, 1.0, len(chosen)))
    return [*zip(chosen.tolist(), shades, strict=True)]
