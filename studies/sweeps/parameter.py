"""A key of the case and its range, over which a branch is followed."""

from dataclasses import dataclass

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.sweeps.axes import NUMBER, OVER, check_key


@dataclass(frozen=True)
class Parameter:
    """A key of the case and its range."""

    key: str
    unit: str  #: unit of the values as in the case file; empty for numbers
    start: float
    stop: float

    @classmethod
    def of(cls, case: Case, key: str, start: float | str, stop: float | str) -> "Parameter":
        """Return a key with its range.

        Raises:
            UserError: the key holds no number, or the values have no common unit or are equal.
        """
        check_key(case, key)
        matches = [NUMBER.fullmatch(str(value)) for value in (start, stop)]
        numbers = [(float(match[1]), match[2] or "") for match in matches if match is not None]
        if len({unit for _, unit in numbers}) != 1 or len(set(numbers)) != 2:
            raise UserError(
                f"{OVER} {key}={start}:{stop}: expected START:STOP, two different numbers with the"
                " same unit or none"
            )
        (first, unit), (last, _) = numbers
        return cls(key, unit, first, last)

    def case(self, case: Case, value: float) -> Case:
        """Return the case with a value of the key."""
        number = float(value)
        return with_values(case, {self.key: f"{number!r} {self.unit}" if self.unit else number})

    def text(self, value: float) -> str:
        """Return text such as "march.speed = 5000 rpm"."""
        return f"{self.key} = {value:.6g} {self.unit}".rstrip()

    @property
    def width(self) -> float:
        """Width of the range, with its sign."""
        return self.stop - self.start
