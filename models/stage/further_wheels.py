"""Points of the further wheels of a shaft line, for pictures."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.shaft_line.line import LineModel
from bladewhirl.models.shaft_line.rotor import LineRotor, X, Y, wheel_bases, wheel_start
from bladewhirl.models.superelements.superelement import HUB, Superelement


def further_arrays(
    line: LineModel,
    wheels: Sequence[Superelement],
    rotor: LineRotor,
    shapes: FloatArray,
    turn: float,
) -> dict[str, Any]:
    """Return the arrays of further wheels in a result by name: the shapes of their centres, and
    points, triangles and shapes of those whose files give them.

    Args:
        line: the shaft line.
        wheels: its wheels with their hubs, the first one first.
        rotor: the rotor at rest.
        shapes: displacements of its coordinates for unit modal coordinates, (n, modes).
        turn: angle by which all wheels are turned [rad].
    """
    (first, *others), modes = wheels, shapes.shape[1]
    if not others:
        return {}
    moved = (rotor.line_rows @ shapes).reshape(-1, HUB, modes)
    places, bases = line.wheels[1:], wheel_bases(line, wheels, rotor.line_rows)[1:]
    points, rows, triangles = [np.zeros((0, 3))], [np.zeros((0, 3, modes))], list[Any]()
    own = [0]  # wheel 0 has its points elsewhere
    for wheel, place, basis in zip(others, places, bases, strict=True):
        own.append(0 if wheel.points is None else len(wheel.points))
        if wheel.points is None or wheel.recovery is None:
            continue
        if wheel.triangles is not None:
            triangles.append(wheel.triangles + sum(own[:-1]))
        ahead = wheel_start(line, place, wheel) - wheel_start(line, line.wheels[0], first)
        points.append(wheel.points + np.array([0.0, 0.0, ahead]))
        rows.append(np.asarray(wheel.recovery @ (basis @ shapes)).reshape(-1, 3, modes))
    return {
        "further_centre_shape": rotate(
            np.stack([moved[place.node, [X, Y]] for place in places]), turn, axis=1
        ),
        "further_point": rotate(np.concatenate(points), turn),
        "further_point_shape": rotate(np.concatenate(rows), turn, axis=1),
        "further_point_wheel": np.repeat(np.arange(len(own)), own),
        "further_triangle": np.concatenate([np.zeros((0, 3), dtype=np.int64), *triangles]),
    }
