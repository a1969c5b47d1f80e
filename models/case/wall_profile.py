"""The `[casing.profile]` table of a case: a measured clearance around the casing, from a file."""

import csv
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import model_validator

from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.inputs.units import to_si
from bladewhirl.models.sections.wall import TURN, Lobe

FEWEST, MOST = 8, 20_000
"""Smallest and largest number of points of a profile."""

HEADING = re.compile(r"\s*(\w+)\s*\[([^\]]+)\]\s*")

Point = tuple[fields.Angle, Annotated[float, fields.quantity("m", "any")]]


class ClearanceProfile(Table):
    """A measured clearance around the casing, in place of a constant one."""

    points: Annotated[
        tuple[Point, ...], fields.rows('[angle, clearance], as in ["90 deg", "1 mm"]')
    ] = ()
    """Measured points, rows of [angle, clearance]: angle from the x axis [rad] and clearance at
    rest [m], with a periodic cubic spline between them. casing.clearance is then the clearance from
    which the radius of the ring follows; the gaps follow from the points. file = "wall.csv" reads
    the points from a file whose first line is "angle [deg],clearance [mm]", with any units; its
    path is relative to the case file."""
    harmonics: Annotated[
        tuple[Lobe, ...], fields.rows('{ lobes = 2, amplitude = "0.2 mm", phase = "30 deg" }')
    ] = ()
    """Waves around the casing that are added, rows as in casing.clearance_lobes."""

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, values: Any) -> Any:
        return with_points_of_file(values, "clearance")

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield an error for too few or too many points, and for two points at one angle."""
        if self.points and (fault := angle_fault([angle for angle, _ in self.points])):
            yield Inconsistency("points", fault)


def angle_fault(given: list[float]) -> str:
    """Describe valid angles of the points of a profile; empty if the angles [rad] are valid."""
    if not FEWEST <= len(given) <= MOST:
        return f"{FEWEST} to {MOST} points, not {len(given)}"
    angles = np.sort(np.mod(given, TURN))
    apart = np.diff(angles, append=angles[0] + TURN).min() > fields.SMALLEST
    return "" if apart else "one value at each angle of a turn"


def with_points_of_file(values: Any, column: str) -> Any:
    """Return the values of a table with `points` in place of the name of a `file`."""
    if not isinstance(values, dict) or "file" not in values:
        return values
    if values.get("points"):
        raise fields.expectation("either points or file, not both")
    rest = {name: value for name, value in values.items() if name != "file"}
    return rest | {"points": read_points(values["file"], column)}


def read_points(file: Any, column: str) -> list[list[float]]:
    """Return the points of a file, rows of angle [rad] and of the values of a column [m].

    Raises:
        PydanticCustomError: the file cannot be read, or a line does not have two numbers.
    """
    if not isinstance(file, str | os.PathLike) or "\0" in os.fspath(file):
        raise fields.expectation('the path of a file such as "wall.csv"')
    try:
        with Path(file).open(encoding="utf-8", newline="") as stream:
            lines = [line for line, _ in zip(csv.reader(stream), range(MOST + 2), strict=False)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise fields.expectation(f"a readable file of a wall profile, {file}", error) from None
    matches = [HEADING.fullmatch(cell) for cell in lines[0]] if lines else []
    names = [match[1].lower() if match else "" for match in matches]
    units = {"angle": "rad", column: "m"}
    try:
        if sorted(names) != sorted(units):
            raise ValueError("other columns")
        scales = [to_si(f"1 {match[2]}", units[match[1].lower()]) for match in matches if match]
    except ValueError as error:
        phrase = f'"angle [deg],{column} [mm]", with any units, as the first line of {file}'
        raise fields.expectation(phrase, error) from None
    points = []
    for number, line in enumerate(lines[1:], 2):
        if not any(cell.strip() for cell in line):
            continue
        try:
            first, second = (scale * float(cell) for scale, cell in zip(scales, line, strict=True))
        except ValueError:
            raise fields.expectation(f"two numbers in line {number} of {file}") from None
        points.append([first, second] if names[0] == "angle" else [second, first])
    again = len(points) > 1 and np.allclose(points[-1], np.add(points[0], [TURN, 0.0]), 1e-9, 1e-12)
    return points[:-1] if again else points
