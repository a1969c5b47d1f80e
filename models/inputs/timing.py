"""Time steps, records and duration of a march."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Steps of a march; records are a whole number of steps apart."""

    time_step: float  #: [s]
    duration: float  #: [s]; zero leaves the record at t = 0 alone
    record_step: float  #: time between records [s]

    @property
    def record_every(self) -> int:
        """Steps between records."""
        return round(self.record_step / self.time_step)

    @property
    def steps(self) -> int:
        """Steps of the whole march."""
        return round(self.duration / self.time_step)

    @property
    def whole_steps(self) -> int:
        """Step of the last record that is a whole number of records from the start."""
        return self.steps - self.steps % self.record_every

    @property
    def records(self) -> int:
        """Records of the whole march: at the start, at whole record steps and at the end."""
        whole, rest = divmod(self.steps, self.record_every)
        return 1 + whole + (rest > 0)
