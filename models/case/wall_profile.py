"""The `[casing.profile]` table of a case: a measured clearance around the casing, from a file."""

import csv
import os
import re
from itertools import islice
from typing import Annotated, Any

import numpy as np
from pydantic import model_validator

from bladewhirl.files import csv_rows, plain
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.inputs.units import to_si
from bladewhirl.models.sections.wall import TURN, LobeRows

FEWEST, MOST = 8, 20_000  #: smallest and largest number of points of a profile

HEADING = re.compile(r"\s*(\w+)(?:\s+at\s+([^\[\]]*[^\[\]\s]))?\s*\[([^\]]+)\]\s*")
"""Pattern of the heading of a column: name, axial position if there is one, unit."""

Point = tuple[fields.Angle, Annotated[float, fields.quantity("m", "any")]]


class WallPoints(Table):
    """A table with points around a wall."""

    points: tuple[tuple[float, float], ...] = ()


class ClearanceProfile(WallPoints):
    """A measured clearance around the casing, in place of a constant one."""

    points: Annotated[
        tuple[Point, ...], fields.rows('[angle, clearance], as in ["90 deg", "1 mm"]')
    ] = ()
    """Measured points, rows of [angle, clearance]: angle from the x axis [rad] and clearance at
    rest [m], with a periodic cubic spline between them. casing.clearance then determines
    only the radius of the ring; the gaps follow from the points. file = "wall.csv" reads the points
    from a file whose first line is "angle [deg],clearance [mm]", with any units; its path is
    relative to the case file."""
    harmonics: LobeRows = ()
    """Waves around the casing that are added, rows as in casing.clearance_lobes."""

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, values: Any) -> Any:
        return with_points_of_file(values, "clearance")


def with_points_of_file(values: Any, column: str, *, tracked: bool = False) -> Any:
    """Return the values of a table with the contents of its `file` as `points`, or as `tracks` if
    columns of the file have axial positions. `tracked` is true for a table that may have tracks."""
    if not isinstance(values, dict) or "file" not in values:
        return values
    if values.get("points") or values.get("tracks"):
        raise fields.expectation("either points or file, not both")
    rest = {name: value for name, value in values.items() if name != "file"}
    columns = read_columns(values["file"], column)
    if list(columns) == [None]:
        return rest | {"points": columns[None]}
    if not tracked:
        raise fields.expectation(f"one column without an axial position in {values['file']}")
    return rest | {"tracks": [{"axial": z, "points": rows} for z, rows in columns.items()]}


def read_columns(file: Any, column: str) -> dict[float | None, list[list[float]]]:
    """Read the points along one line around a wall, or along several lines at axial positions.

    Args:
        file: path of a CSV file. Its first line has headings such as "angle [deg],recess [mm]", or
            "angle [deg],recess at -5 mm [mm],recess at 5 mm [mm]", in any order.
        column: name of the columns of lengths.

    Returns:
        Rows of angle [rad] and length [m] of each line, by its axial position [m]; the key is None
        if the file has a single line without axial position.

    Raises:
        PydanticCustomError: the file cannot be read, or a line does not have a number for each
            heading.
    """
    if not isinstance(file, str | os.PathLike) or "\0" in os.fspath(file):
        raise fields.expectation('the path of a file such as "wall.csv"')
    try:
        lines = [line for _, line in islice(csv_rows(file), MOST + 2)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise fields.expectation(f"a readable file of a wall profile, {file}", reason) from None
    try:
        angle, places, scales = _headings(lines[0] if lines else [], column)
    except ValueError as error:
        phrase = f'"angle [deg],{column} [mm]", with any units, as the first line of {file}'
        raise fields.expectation(phrase, error) from None
    points = []
    for number, line in enumerate(lines[1:], 2):
        if not any(cell.strip() for cell in line):
            continue
        try:
            row = [scale * float(plain(cell)) for scale, cell in zip(scales, line, strict=True)]
        except ValueError:
            count = "two" if len(scales) == 2 else str(len(scales))
            raise fields.expectation(f"{count} numbers in line {number} of {file}") from None
        points.append([row.pop(angle), *row])
    turn = [TURN] + [0.0] * len(places)
    again = len(points) > 1 and np.allclose(points[-1], np.add(points[0], turn), 1e-9, 1e-12)
    points = points[:-1] if again else points
    if not points:
        raise fields.expectation(f"{FEWEST} to {MOST} points in {file}, not 0")
    return {z: [[row[0], row[n]] for row in points] for n, z in enumerate(places, 1)}


def _headings(cells: list[str], column: str) -> tuple[int, list[float | None], list[float]]:
    """Return the number of the column of angles, the axial position of each other column [m], and
    the SI value of the unit of each column.

    Raises:
        ValueError: a unit is not one of angles or lengths, or there are other columns.
    """
    matches = [match for cell in cells if (match := HEADING.fullmatch(cell))]
    names = [match[1].lower() for match in matches]
    lengths = [match for match, name in zip(matches, names, strict=True) if name == column]
    at = [match[2] for match in lengths if match[2]]
    if not lengths or names.count("angle") != 1 or len(lengths) + 1 != len(cells):
        raise ValueError("other columns")
    if len(lengths) != 1 and len(at) != len(lengths):
        raise ValueError(f"several columns without axial positions, as in {column} at 5 mm [mm]")
    units = {"angle": "rad", column: "m"}
    scales = [to_si(f"1 {m[3]}", units[name]) for m, name in zip(matches, names, strict=True)]
    places: list[float | None] = [to_si(text, "m") for text in at] or [None]
    if len(set(places)) < len(places):
        raise ValueError("two columns of one axial position")
    return names.index("angle"), places, scales
