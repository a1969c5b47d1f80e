"""The `[casing.closure]` table of a case: clearance that is lost over time."""

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.wall import FINE, TURN, Lobe, RingProfile

MOST = 10_000  #: largest number of rows of a closure table

Row = tuple[fields.TimeOrZero, Annotated[float, fields.quantity("m", "any")]]


class Closure(Table):
    """Clearance that is lost over time, as the casing cools or the bladed disk grows."""

    amount: Annotated[float, fields.quantity("m", "any")] = 0.0
    """Clearance lost in the end [m]; at the time t, amount (1 - exp(-t / time_constant)) is lost. A
    negative amount opens the gap."""
    time_constant: fields.Time | None = None
    """Time after which 63 % of the amount is lost [s]; needed with an amount."""
    table: Annotated[tuple[Row, ...], fields.rows('[time, closure], as in ["1 s", "0.2 mm"]')] = ()
    """Measured closure in place of an amount, rows of [time, closure] in ascending order of time:
    time [s] and lost clearance [m], with linear interpolation between rows, and constant before the
    first and after the last row."""
    lobes: Annotated[
        tuple[Lobe, ...], fields.rows('{ lobes = 2, amplitude = "0.1 mm", phase = "30 deg" }')
    ] = ()
    """Waves of the closure around the casing, rows as in casing.clearance_lobes. Their amplitudes
    hold at the time at which the closure has its largest magnitude; at other times they are
    proportional to the closure."""

    @property
    def largest(self) -> float:
        """Closure of the largest magnitude, without lobes [m]."""
        return max([self.amount, *(lost for _, lost in self.table)], key=abs)

    @property
    def around(self) -> RingProfile:
        """Closure divided by the closure without lobes, around the ring."""
        scaled = (
            lobe.model_copy(update={"amplitude": lobe.amplitude / self.largest})
            for lobe in self.lobes
        )
        return RingProfile(mean=1.0, lobes=tuple(scaled))

    @property
    def smallest_loss(self) -> float:
        """Smallest closure at any time, anywhere around the ring [m]; negative if a gap opens."""
        return min(0.0, *self._extremes)

    @property
    def largest_loss(self) -> float:
        """Largest closure at any time, anywhere around the ring [m]."""
        return max(0.0, *self._extremes)

    @property
    def _extremes(self) -> list[float]:
        around = self.around.value(np.linspace(0.0, TURN, FINE, endpoint=False))
        courses = [self.amount, *(lost for _, lost in self.table)]
        return [lost * share for lost in courses for share in (around.min(), around.max())]

    def value(self, time: ArrayLike) -> FloatArray:
        """Return the closure without lobes [m] at times [s], in the shape of the times."""
        time = np.asarray(time, dtype=np.float64)
        if self.table:
            return np.asarray(np.interp(time, *np.transpose(self.table)))
        return np.asarray(-self.amount * np.expm1(-time / (self.time_constant or np.inf)))
