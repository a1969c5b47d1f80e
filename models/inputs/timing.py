"""Time steps, records and duration of a march."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Steps of a march.

    Raises:
        ValueError: a time step that is not positive, a negative or infinite duration, or records
            that are not a whole number of steps apart.
    """

    time_step: float  #: [s]
    duration: float  #: [s]; zero leaves the record at t = 0 alone
    record_step: float  #: time between records [s]

    def __post_init__(self) -> None:
        if not (0.0 < self.time_step < np.inf and 0.0 <= self.duration < np.inf):
            raise ValueError(
                "time step must be positive, duration not negative, both finite; "
                f"got {self.time_step}, {self.duration}"
            )
        ratio = self.record_step / self.time_step
        if not (0.5 < ratio < np.inf and abs(ratio - self.record_every) < 1e-6 * ratio):
            raise ValueError(
                f"record_step must be a whole number of time steps ({self.time_step} s); "
                f"got {self.record_step} s, {ratio:.6g} steps"
            )

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
