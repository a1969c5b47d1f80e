"""Time steps, records and duration of a march."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Time step, record step (a multiple of the time step) and duration of a march."""

    time_step: float  #: time step [s]
    duration: float  #: simulated time [s]; if zero, only the state at t = 0 is recorded
    record_step: float  #: time between records [s]

    @property
    def record_every(self) -> int:
        """Number of steps between records."""
        return round(self.record_step / self.time_step)

    @property
    def steps(self) -> int:
        """Number of steps of the march."""
        return round(self.duration / self.time_step)

    @property
    def whole_steps(self) -> int:
        """Number of steps up to the last regular record, without the extra record at the end."""
        return self.steps - self.steps % self.record_every

    @property
    def records(self) -> int:
        """Number of records of the march: at the start, at multiples of `record_step`, at the
        end."""
        whole, rest = divmod(self.steps, self.record_every)
        return 1 + whole + (rest > 0)
