"""Names of regimes for figures."""

import numpy as np
import xarray as xr

from bladewhirl.postprocess.sweep.regimes import regime_entries, regime_names


def test_draws_that_were_not_needed_are_not_counted_as_without_result() -> None:
    data = xr.Dataset(
        {
            "regime": ("draw", ["sustained", "unknown", "unknown", "unknown"]),
            "state": ("draw", ["done", "not-needed", "not-needed", "failed"]),
        }
    )
    entries = regime_entries(regime_names(data))
    texts = [text for _, text in entries]
    assert texts == ["sustained: 1", "skipped, outcome known: 2", "no result: 1"]
    assert np.unique(regime_names(data)).size == 3
