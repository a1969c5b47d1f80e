"""Axes of a sweep: keys of the case with their values, validated point by point."""

import dataclasses
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from difflib import get_close_matches
from typing import Any, get_args

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError, shown
from bladewhirl.models.inputs.table import Table, path_of, row_of, value_at
from bladewhirl.models.inputs.units import Speed
from bladewhirl.solvers.march.schema import DRAW, POINT
from bladewhirl.studies.sweeps.draws import PERTURB, Draws

Value = int | float | str  #: value as in a case file: a number, or text with a unit

OVER, TABLE = "--over", "--table"

ASKED_POINTS = 100_000  #: largest number of points of a sweep without confirmation

MOST_POINTS = 10_000_000
"""Largest number of points of a range; a larger range is taken as a typing error."""

ON_GRID = Decimal("1e-6")  #: tolerance for including the stop of a range, relative to the step

NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(\S.*?)?\s*", re.ASCII)


@dataclass(frozen=True, kw_only=True)
class Axis:
    """Swept key and its values, in order."""

    key: str  #: dotted key, as in the case file
    values: tuple[Value, ...]  #: values as in a case file

    @property
    def name(self) -> str:
        """Name of the dimension in the dataset of the sweep."""
        return self.key.replace(".", "_")

    @property
    def unit(self) -> str:
        """Common unit of the values; empty for plain numbers and for values of several units."""
        units = {unit for _, unit in self._parts}
        return units.pop() if len(units) == 1 else ""

    @property
    def numbers(self) -> FloatArray:
        """Values as numbers, without the unit."""
        return np.array([number for number, _ in self._parts])

    @property
    def _parts(self) -> list[tuple[float, str]]:
        """Number and unit of each value."""
        matches = (NUMBER.fullmatch(str(value)) for value in self.values)
        return [(float(match[1]), match[2] or "") for match in matches if match is not None]


@dataclass(frozen=True, kw_only=True)
class PointTable:
    """Points of a sweep in any number and order."""

    values: Mapping[str, tuple[Value, ...]]  #: values of each key, in the form of the case file
    head: str = TABLE  #: place of the keys, for messages: "points.csv, line 1,"
    #: name of each point for messages, "points.csv, line 2,"; by default none
    rows: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Points of a sweep: all combinations of values of its axes; the last axis varies fastest. If
    the sweep has random draws, the last axis is the number of the draw. If the sweep has a table of
    points, the first axis is the number of the point."""

    axes: tuple[Axis, ...]
    draws: Draws | None = None
    nominal: Mapping[str, tuple[float, ...]] = dataclasses.field(default_factory=dict)
    """Values of each perturbed key along its axis, or a single value if the key is not swept."""
    table: tuple[Axis, ...] = ()  #: keys with their values at each point of a table
    rows: tuple[str, ...] = dataclasses.field(default=(), compare=False)  #: see `PointTable`

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def over(self) -> dict[str, tuple[Value, ...]]:
        """Values of each swept key, without random draws; no keys if the sweep has a table."""
        return {axis.key: axis.values for axis in self.axes if axis.key not in (DRAW, POINT)}

    @property
    def listed(self) -> dict[str, tuple[Value, ...]]:
        """Values of each key of the table."""
        return {axis.key: axis.values for axis in self.table}

    @property
    def drawn(self) -> dict[str, str]:
        """Name of the variable with the drawn values of each perturbed key."""
        changes = () if self.draws is None else self.draws.perturbations
        return {each.key: f"drawn_{each.key.replace('.', '_')}" for each in changes}

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def values(self, point: int) -> dict[str, Value]:
        """Values of the swept keys at a point, and those of the perturbed keys."""
        position = np.unravel_index(point, self.shape)
        places = {axis.key: int(i) for axis, i in zip(self.axes, position, strict=True)}
        places |= {axis.key: places[POINT] for axis in self.table}
        swept = {**self.over, **self.listed}
        values: dict[str, Value] = {key: swept[key][places[key]] for key in swept}
        if self.draws is not None:
            stream = self.draws.stream(point // self.draws.count, places[DRAW])
            for perturbation in self.draws.perturbations:
                nominal = self.nominal[perturbation.key]
                at = nominal[places.get(perturbation.key, 0)]
                values[perturbation.key] = perturbation.value(at, stream)
        return values

    def label(self, point: int) -> str:
        """Return the label of a point, "march.speed = 1.05, contact.friction = 0.1"."""
        return ", ".join(f"{key} = {shown(value)}" for key, value in self.values(point).items())

    def failed(self, failures: Mapping[int, str]) -> list[dict[str, Any]]:
        """Return failed points, ascending, with their values and the reasons of the failures."""
        return [
            {"point": point, **self.values(point), "reason": reason}
            for point, reason in sorted(failures.items())
        ]

    def cases(self, case: Case) -> Iterator[Case]:
        """Yield the case at every point, in order.

        Raises:
            UserError: the case has errors at a point; the message names the first such point.
        """
        for point in range(self.size):
            with self.naming(point):
                at_point = with_values(case, self.values(point))
            yield at_point

    @contextmanager
    def naming(self, point: int) -> Iterator[None]:
        """Add the name of a point to errors raised in the ``with`` block.

        Raises:
            UserError: the point and the first line of the error.
        """
        try:
            yield
        except UserError as error:
            row = int(np.unravel_index(point, self.shape)[0])
            option = TABLE if self.table else OVER
            place = self.rows[row] if self.rows else f"{option}, point"
            raise UserError(f"{place} {self.label(point)}: {error.lines[0]}") from None


def make_grid(
    case: Case,
    over: Mapping[str, Sequence[Value]],
    *,
    large: bool,
    draws: Draws | None = None,
    table: PointTable | None = None,
) -> Grid:
    """Return the points of a sweep of a case over values of keys.

    Args:
        case: case that is varied.
        over: values of each swept key.
        large: whether to allow more than 100,000 points.
        draws: random draws at each point; None for one march without random changes.
        table: points in place of all combinations of the values `over`.

    Raises:
        UserError: nothing to sweep, a key that is unknown or does not take a number, fewer than two
            values, a value given twice, or too many points.
    """
    given = over if table is None else table.values
    if not given:
        raise UserError(f"{OVER}: expected at least one key, such as march.speed=0.95:2:0.005")
    for key in given:
        check_key(case, key, OVER if table is None else table.head)
        if key == "march.speed" and case.march.varies and case.march.drive is None:
            raise UserError(
                f"{OVER} march.speed: expected a key of the speed over time, such as"
                " march.run_up.end, or a case without march.speed_table and march.run_up"
            )
    axes = [Axis(key=key, values=tuple(values)) for key, values in given.items()]
    columns = () if table is None else tuple(axes)
    if columns:
        axes = [Axis(key=POINT, values=tuple(range(len(columns[0].values))))]
    nominal = {}
    if draws is not None:
        nominal = {each.key: _nominal(case, each.key, given) for each in draws.perturbations}
        axes.append(Axis(key=DRAW, values=tuple(range(draws.count))))
    rows = () if table is None else table.rows
    grid = Grid(axes=tuple(axes), draws=draws, nominal=nominal, table=columns, rows=rows)
    for axis in grid.axes if table is None else ():
        if len(axis.values) < 2 or len(set(axis.values)) < len(axis.values):
            raise UserError(
                f"{OVER} {axis.key}: expected two or more different values; --set sets one value"
            )
    if grid.size > ASKED_POINTS and not large:
        option = OVER if table is None else TABLE
        raise UserError(
            f"{option}: {grid.size} points are more than {ASKED_POINTS}; --yes runs them all"
        )
    return grid


def _nominal(case: Case, key: str, over: Mapping[str, Sequence[Value]]) -> tuple[float, ...]:
    """Return the unperturbed values of a key: all values of a swept key, or the value of the case.

    Raises:
        UserError: the key does not take a number, or is a speed with a unit.
    """
    check_key(case, key)
    cases = [with_values(case, {key: value}) for value in over.get(key, ())] or [case]
    values = [value_at(each, path_of(key)) for each in cases]
    if any(isinstance(value, Speed) and value.kind != "normalised" for value in values):
        raise UserError(
            f"{PERTURB} {key}: expected the speed in the case and in {OVER} as a multiple of the"
            " reference frequency, without a unit"
        )
    numbers = [value.value if isinstance(value, Speed) else value for value in values]
    if None in numbers:
        raise UserError(f"{PERTURB} {key}: expected a key that has a value in the case")
    return tuple(float(number) for number in numbers)


def parse_over(options: Sequence[str]) -> dict[str, tuple[Value, ...]]:
    """Return the values of each key from options "KEY=START:STOP:STEP" and "KEY=VALUE,VALUE".

    The stop is included if it is a whole number of steps from the start, within rounding. All
    numbers of an option have the same unit, or none, as in the case file: "2000 rpm:2500 rpm:10
    rpm" or "0.5 mm,1 mm". Steps are added in decimal arithmetic, so that 0.95:2:0.005 gives exactly
    the numbers 0.95, 0.955, ...

    Raises:
        UserError: an option has another form, a range is empty, reversed or a single point, or a
            key is given twice.
    """
    over: dict[str, tuple[Value, ...]] = {}
    for option in options:
        key, equals, text = (part.strip() for part in option.partition("="))
        if not (key and equals and text):
            raise UserError(f"{OVER} {option}: expected KEY=START:STOP:STEP or KEY=VALUE,VALUE")
        if key in over:
            raise UserError(f"{OVER} {key}: expected each key at most once")
        over[key] = parse_values(f"{OVER} {option}", text)
    return over


def parse_values(label: str, text: str, most: int = MOST_POINTS) -> tuple[Value, ...]:
    """Return the values of "START:STOP:STEP" or "VALUE,VALUE", see `parse_over`.

    Raises:
        UserError: the text has another form, or a range has fewer than two or more than `most`
            values; the message begins with the label.
    """
    is_range = ":" in text
    parts = text.split(":") if is_range else text.removesuffix(",").split(",")
    matches = [match for match in map(NUMBER.fullmatch, parts) if match is not None]
    units = {match[2] or "" for match in matches}
    if len(matches) < len(parts) or len(units) > 1:
        raise UserError(f"{label}: expected numbers, all with the same unit or none")
    numbers, unit = [Decimal(match[1]) for match in matches], units.pop()
    numbers = _range(label, numbers, most) if is_range else numbers
    return tuple(case_value(number, unit) for number in numbers)


def coordinate(case_values: Sequence[Any]) -> tuple[FloatArray, str]:
    """Return the values of a key as numbers, and the unit of speeds (empty for other values).

    Args:
        case_values: values of the key in the cases: int, float or `Speed`.

    Raises:
        UserError: some speeds are multiples of the reference frequency, others are absolute.
    """
    kinds = {value.kind for value in case_values if isinstance(value, Speed)}
    if len(kinds) > 1:
        raise UserError(
            f"{OVER}: expected all speeds as numbers (multiples of the reference frequency) or"
            " all with a unit"
        )
    numbers = [value.value if isinstance(value, Speed) else float(value) for value in case_values]
    unit = {"normalised": "1"}.get(*kinds, *kinds) if kinds else ""
    return np.array(numbers), unit


def check_key(case: Case, key: str, place: str = OVER) -> None:
    """Check that the value of a key of the case is a number; `place` is where the key is given.

    Raises:
        UserError: the key does not take a number; the message names the most similar numeric key.
    """
    keys = [name for name, _ in _numeric_keys(case)]
    if _numbered(case, key) not in keys:
        last = key.rpartition(".")[2]
        nearest = [name for name in keys if name.rpartition(".")[2] == last]
        nearest = nearest or get_close_matches(key, keys, n=1, cutoff=0.0)
        raise UserError(
            f"{place} {key}: expected a key of the case that holds a number; the nearest is"
            f" {' or '.join(nearest)}"
        )


def unit_of(case: Case, key: str) -> str:
    """Return the SI unit of a key, from its description; "1" for dimensionless numbers."""
    table = dict(_numeric_keys(case))[_numbered(case, key)]
    description = table.descriptions().get(key.rpartition(".")[2], "")
    match = re.search(r"\[([^\]]+)\]", description)
    return match[1] if match else "1"


def _numbered(case: Case, key: str) -> str:
    """Return a dotted key with the numbers of rows in place of their names."""
    value, parts = case, list[str]()
    for part in path_of(key):
        place = row_of(value, part)
        parts.append(str(place))
        value = value_at(value, (place,))
    return ".".join(parts)


def _numeric_keys(table: Table) -> Iterator[tuple[str, type[Table]]]:
    """Yield the dotted keys with numerical values, and the kinds of the tables that have them."""
    for attribute, field in type(table).model_fields.items():
        name, value = field.alias or attribute, getattr(table, attribute)
        rows: Iterable[tuple[object, Table]] = ()
        if isinstance(value, Mapping):
            rows = value.items()
        elif isinstance(value, tuple):
            rows = ((number, row) for number, row in enumerate(value) if isinstance(row, Table))
        for key, row in rows:
            yield from ((f"{name}.{key}.{inner}", kind) for inner, kind in _numeric_keys(row))
        if isinstance(value, Table):
            yield from ((f"{name}.{inner}", kind) for inner, kind in _numeric_keys(value))
            continue
        kinds = {field.annotation, *get_args(field.annotation)}
        kinds |= {part for kind in tuple(kinds) for part in get_args(kind)}
        scalar = isinstance(value, int | float | Speed) and not isinstance(value, bool)
        if scalar or (value is None and kinds & {int, float, Speed} and tuple not in kinds):
            yield name, type(table)


def _range(label: str, numbers: Sequence[Decimal], most: int) -> list[Decimal]:
    """Return the numbers from start to stop of a range with the numbers start, stop and step."""
    steps = Decimal(0)
    if len(numbers) == 3 and numbers[2] > 0:
        start, stop, step = numbers
        steps = (stop - start) / step
    if not 1 - ON_GRID <= steps < most:
        raise UserError(
            f"{label}: expected START:STOP:STEP with START below STOP, a positive STEP and"
            f" 2 to {most} points"
        )
    grid = [start + i * step for i in range(int(steps + ON_GRID) + 1)]
    if abs(grid[-1] - stop) <= ON_GRID * step:
        grid[-1] = stop
    return grid


def case_value(number: Decimal, unit: str) -> Value:
    """Return a number in the form of the case file."""
    whole = number == number.to_integral_value() and abs(number) < 2**53
    plain: int | float = int(number) if whole else float(number)
    return f"{plain!r} {unit}" if unit else plain
