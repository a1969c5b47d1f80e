"""Sizes of the data of each point of a sweep, chosen once for all points."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.sweep.dataset import WINDOW_SHARE, Layout
from bladewhirl.solvers.march.recorder import result_bytes

REACH = 10.0
"""Upper limit of the spectra in multiples of the first point's reference frequency: above the
second blade family of the default stage."""

MOST_LINES = 20_001
"""Largest number of frequencies of a spectrum; very long marches have a smaller range."""

MOST_SAMPLES = 1000
"""Largest number of samples of a decimated history."""


@dataclass(frozen=True, kw_only=True)
class Extent:
    """Size of the marches of a sweep."""

    shortest: float  #: duration of the shortest march [s]
    record_step: float  #: longest time between records of any march [s]
    steps: int  #: number of steps of all marches together
    most_steps: int  #: largest number of steps of a march
    histories: Mapping[tuple[int, int], int]  #: number of points by (blades, records)

    @property
    def blades(self) -> int:
        """Largest number of blades of a point."""
        return max(blades for blades, _ in self.histories)

    @property
    def records(self) -> int:
        """Largest number of records of a point."""
        return max(records for _, records in self.histories)


def march_extent(cases: Iterable[Case]) -> Extent:
    """Compute the size of the marches in one pass over the cases, without storing them."""
    shortest, record_step, steps, most_steps = np.inf, 0.0, 0, 0
    histories: Counter[tuple[int, int]] = Counter()
    for case in cases:
        march = case.march
        shortest = min(shortest, march.duration)
        record_step = max(record_step, march.record_step)
        steps, most_steps = steps + march.steps, max(most_steps, march.steps)
        histories[case.blades, march.timing.records] += 1
    return Extent(
        shortest=shortest,
        record_step=record_step,
        steps=steps,
        most_steps=most_steps,
        histories=histories,
    )


def make_layout(extent: Extent, stage: Stage) -> Layout:
    """Return the layout of a sweep.

    The frequencies are multiples of 1 / window of the shortest march; at this spacing a Hann window
    separates the periodic parts of a motion. The longest record step resolves all frequencies.

    Args:
        extent: size of the marches of all points.
        stage: stage of the first point.
    """
    nyquist = 0.5 / extent.record_step
    highest = min(REACH * stage.reference_frequency / (2.0 * np.pi), nyquist)
    window = WINDOW_SHARE * extent.shortest
    each_side = int(np.clip(highest * window, 1, MOST_LINES // 2))
    return Layout(
        frequency=np.arange(-each_side, each_side + 1) / max(window, 1.0 / highest),
        samples=min(MOST_SAMPLES, extent.records),
        nodal_diameters=extent.blades // 2 + 1,
        blades=extent.blades,
    )


def history_bytes(extent: Extent, stage: Stage) -> int:
    """Estimate the size of all full histories of a sweep [bytes], assuming that all points have as
    many modes as the first point."""
    arrays = stage.arrays
    return sum(
        points * result_bytes(arrays, records, blades)
        for (blades, records), points in extent.histories.items()
    )
