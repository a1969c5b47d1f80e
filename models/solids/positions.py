"""Nodes by their positions: half spaces, boxes, cylinders, planes, sectors, the outermost nodes."""

import re

import numpy as np

from bladewhirl.meshes.coincident import COINCIDENT
from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.inputs.units import to_si

OUTERMOST, SHARE = "outermost", 0.01
"""Name of the nodes at the largest radius, within this fraction of the extent in radius."""

_VALUE = r"[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*[A-Za-z]*"
_CONDITION = re.compile(
    rf"(?:(?P<low>{_VALUE})\s*(?P<above><=?)\s*)?(?P<name>x|y|z|r|angle)\s*"
    rf"(?:(?P<sign><=?|>=?|=)\s*(?P<value>{_VALUE}))?"
)
EXAMPLE = '"outermost", or a condition such as "r < 210 mm" or "x = 0.3 and -5 mm < z < 5 mm"'


def nodes_where(text: str, points: FloatArray, axis: str) -> IntArray | None:
    """Return the nodes at which a condition holds, (m,); None if the text is no condition.

    Conditions compare x, y, z, r or angle with numbers by <, <=, >, >= or =, as in ``r < 0.21`` or
    ``0 < x <= 20 mm``, and are connected by ``and``. Lengths are in m or have a unit; r is the
    distance from the axis of rotation, and the angle, in degrees, is counter-clockwise about it,
    from the axis that follows it in the order x, y, z, x. A coordinate is equal to a number within
    1e-5 of the size of the mesh. ``outermost`` means a radius within 1 % of the extent of the
    largest.

    Args:
        text: the condition.
        points: positions in the axes of the mesh [m], (n, 3).
        axis: axis of rotation of the mesh, "x", "y" or "z".

    Raises:
        ValueError: the text has a comparison that is not valid.
    """
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    radius = np.hypot(points[:, first], points[:, second])
    if text.strip() == OUTERMOST:
        return np.flatnonzero(radius >= radius.max() - SHARE * np.ptp(radius))
    if not re.search("[<>=]", text):
        return None
    angle = np.degrees(np.arctan2(points[:, second], points[:, first]))
    values = dict(zip(("x", "y", "z", "r", "angle"), (*points.T, radius, angle), strict=True))
    close = COINCIDENT * float(np.ptp(points, axis=0).max())
    degrees = np.degrees(close / np.maximum(radius, close))
    inside = np.ones(len(points), dtype=np.bool_)
    for part in re.split(r"\s+and\s+|,", text.strip()):
        match = _CONDITION.fullmatch(part.strip())
        if match is None or not (match["low"] or match["value"]):
            raise ValueError(f"{part!r} is no condition")
        name = match["name"]
        for sign, number in (
            (match["above"] and match["above"].replace("<", ">"), match["low"]),
            (match["sign"], match["value"]),
        ):
            if number is not None:
                near = degrees if name == "angle" else close
                inside &= _compared(values[name], sign, _number(number, name), near)
    return np.flatnonzero(inside)


def _compared(values: FloatArray, sign: str, number: float, near: FloatArray | float) -> BoolArray:
    if sign == "=":
        return np.asarray(abs(values - number) <= near)
    if sign.startswith("<"):
        return np.asarray(values <= number + near if sign == "<=" else values < number)
    return np.asarray(values >= number - near if sign == ">=" else values > number)


def _number(text: str, name: str) -> float:
    if name == "angle":
        return float(text.strip().removesuffix("deg"))
    try:
        return float(text)
    except ValueError:
        return to_si(text.strip(), "m")
