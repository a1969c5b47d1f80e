"""Sizes of what a sweep keeps of each point, chosen once so that all points share them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bladewhirl.models.case import Case
from bladewhirl.models.stage import Stage
from bladewhirl.postprocess.sweep_result import WINDOW_SHARE, Layout
from bladewhirl.solvers.recorder import result_bytes

REACH = 10.0
"""Spectra reach to this multiple of the first point's reference frequency: past the second blade
family of the default stage."""

MOST_LINES = 20_001
"""Frequencies that a spectrum has at most: of a very long march it reaches less far."""

MOST_SAMPLES = 1000
"""Samples that a thinned history has at most."""


def make_layout(cases: Sequence[Case], stage: Stage) -> tuple[Layout, int]:
    """Layout of a sweep, and the size of all its full histories [bytes].

    Frequencies are those of the shortest march's window, where a Hann window keeps the parts of a
    motion that come round in it apart; they end where the coarsest records still resolve them.

    Args:
        cases: at every point.
        stage: of the first point.
    """
    nyquist = min(0.5 / case.march.record_step for case in cases)
    highest = min(REACH * stage.reference_frequency / (2.0 * np.pi), nyquist)
    window = WINDOW_SHARE * min(case.march.duration for case in cases)
    each_side = int(np.clip(highest * window, 1, MOST_LINES // 2))
    records = [case.march.steps // case.march.steps_per_record + 1 for case in cases]
    blades = max(case.bladed_disk.blades for case in cases)
    layout = Layout(
        frequency=np.arange(-each_side, each_side + 1) / max(window, 1.0 / highest),
        samples=min(MOST_SAMPLES, max(records)),
        nodal_diameters=blades // 2 + 1,
        blades=blades,
    )
    histories = sum(
        result_bytes(
            stage.reduction.modes.count,
            stage.casing_modes.count,
            case.bladed_disk.blades,
            count,
        )
        for case, count in zip(cases, records, strict=True)
    )
    return layout, histories
