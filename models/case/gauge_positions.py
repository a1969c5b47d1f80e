"""Strain gauges at positions or groups of a mesh: at the nearest point of the surface."""

import os
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError

from bladewhirl.models.case.sensors import Sensor, StrainGauge
from bladewhirl.models.case.superelement import SOURCE, part_of
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.models.superelements.superelement import Superelement


def with_gauge_points(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case whose strain gauges with a position or group have the nearest
    point of the superelement, and their direction in the axes of the file. Rows that have a point
    already, or are not valid, are left as they are.

    Raises:
        CaseError: the file has no such group.
    """
    rows, file = tables.get("sensor"), value_at(tables, (*path_of(SOURCE), "file"))
    if not isinstance(rows, list | tuple) or not isinstance(file, str | os.PathLike):
        return dict(tables)
    return {**tables, "sensor": [_with_point(n, row, file) for n, row in enumerate(rows)]}


def _with_point(number: int, row: Any, file: Any) -> Any:
    if not isinstance(row, Mapping) or "point" in row or not {"position", "group"} & row.keys():
        return row
    try:
        gauge = StrainGauge.model_validate({**row, "point": 0})
    except ValidationError:  # the case yields it
        return row
    part = part_of(file)
    if part is None or part.points is None:
        return row
    if gauge.group is not None and gauge.group not in part.groups:
        known = ", ".join(part.groups) or "none"
        expected = f"a group of nodes of the mesh of {file}: {known}"
        raise CaseError(
            [Fault(key=f"sensor[{number}].group", value=gauge.group, expected=expected)]
        )
    assert gauge.direction is not None
    direction = np.roll(gauge.direction, _turn(part)).tolist()
    return {**row, "point": int(_distances(gauge, part).argmin()), "direction": direction}


def _turn(part: Superelement) -> int:
    """Return by how many places the axes x, y and z of the mesh move to become those of a part."""
    return "zyx".index(part.mesh_axis)


def _distances(gauge: StrainGauge, part: Superelement) -> Any:
    """Return the distance of each point of a part from the position or the group of a gauge [m],
    (points,)."""
    if gauge.position is not None:
        place = np.roll(gauge.position, _turn(part))
    else:
        place = np.array(part.groups[str(gauge.group)])
    return np.linalg.norm(part.points - place, axis=1)


def gauge_hints(sensors: tuple[Sensor, ...], part: Superelement) -> Iterator[str]:
    """Yield where gauges are that were given by their position or a group."""
    for gauge in sensors:
        point = getattr(gauge, "point", None)
        if not isinstance(gauge, StrainGauge) or point is None:
            continue
        if gauge.position is None and gauge.group not in part.groups:
            continue
        if part.points is None or point >= len(part.points):
            continue
        x, y, z = 1e3 * np.roll(part.points[point], -_turn(part))
        yield (
            f"sensor {gauge.label} is at point {point} of the surface, at ({x:.6g}, {y:.6g},"
            f" {z:.6g}) mm, {1e3 * _distances(gauge, part)[point]:.3g} mm from its"
            f" {'group' if gauge.position is None else 'position'}"
        )
