"""Sizes of the data of each point of a sweep, chosen once for all points."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import inf

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.sweep.dataset import WINDOW_SHARE, Layout
from bladewhirl.solvers.march.recorder import result_bytes
from bladewhirl.solvers.march.schema import parts_of

REACH = 10.0
"""Highest frequency of the spectra, divided by the reference frequency of the first point; it is
above the frequencies of the second blade family of the default stage."""

MOST_LINES = 20_001
"""Largest number of frequencies of a spectrum; limits the frequency range of very long marches."""

MOST_SAMPLES = 1000  #: largest number of samples of a decimated history


@dataclass(kw_only=True)
class Extent:
    """Size of the marches of a sweep."""

    shortest: float = inf  #: duration of the shortest march [s]
    record_step: float = 0.0  #: longest time between records of any march [s]
    steps: int = 0  #: number of steps of all marches together
    most_steps: int = 0  #: largest number of steps of a march
    #: number of points by (blades, times of the march)
    histories: Counter[tuple[int, Timing]] = field(default_factory=Counter)

    @property
    def blades(self) -> int:
        """Largest number of blades of a point."""
        return max(blades for blades, _ in self.histories)

    @property
    def records(self) -> int:
        """Largest number of records of a point."""
        return max(timing.records for _, timing in self.histories)


def march_extent(cases: Iterable[Case]) -> Extent:
    """Compute the size of the marches in one pass over the cases, without storing them."""
    extent = Extent()
    for case in cases:
        march = case.march
        extent.shortest = min(extent.shortest, march.duration)
        extent.record_step = max(extent.record_step, march.record_step)
        extent.steps += march.steps
        extent.most_steps = max(extent.most_steps, march.steps)
        extent.histories[case.blades_at_walls, march.timing] += 1
    return extent


def make_layout(extent: Extent, stage: Stage, *, starts: bool = False) -> Layout:
    """Return the layout of a sweep whose first point has the given stage.

    With `starts` its marches start on periodic motions. The spacing of the frequencies is 1 divided
    by the window of the shortest march; a Hann window then separates the periodic parts of a
    motion. The highest frequency is at most half of the sampling rate of the longest record step.
    Only the motion of a shaft has negative frequencies.
    """
    nyquist = 0.5 / extent.record_step
    highest = min(REACH * stage.reference_frequency / (2.0 * np.pi), nyquist)
    window = WINDOW_SHARE * extent.shortest
    each_side = int(np.clip(highest * window, 1, MOST_LINES // 2))
    further = {"start"} if starts else set[str]()
    if stage.case.joint:
        further.add("joints")
    parts = frozenset(parts_of(stage.arrays.stored) | further)
    lines = np.arange(-each_side if "centre" in parts else 0, each_side + 1)
    return Layout(
        parts=parts,
        frequency=lines / max(window, 1.0 / highest),
        samples=min(MOST_SAMPLES, extent.records),
        nodal_diameters=extent.blades // 2 + 1,
        blades=extent.blades,
    )


def history_bytes(extent: Extent, stage: Stage) -> int:
    """Estimate the size of all full histories of a sweep [bytes], assuming that all points have as
    many modes as the first point."""
    return sum(
        points * result_bytes(stage.arrays, timing, stage.coating, blades)
        for (blades, timing), points in extent.histories.items()
    )
