"""Figures of recorded quantities."""

import numpy as np
import pytest
import synthetic_result as synthetic

from bladewhirl.postprocess.run.recorded import MOST, plot_recorded, recorded


def test_any_variable_is_drawn_with_its_largest_columns() -> None:
    result = synthetic.synthetic_result(records=30, blades=22)
    result["gap"].values[:] = np.random.default_rng(1).uniform(size=result["gap"].shape)
    contacts = recorded(result, name="contacts")
    (line,) = plot_recorded(contacts).axes[0].lines
    assert line.get_ydata() == pytest.approx(result["contacts"].values)
    gap = recorded(result, name="gap")
    assert plot_recorded(gap).axes[0].get_ylabel().endswith("[m]")
    largest = np.abs(result["gap"].values).max(axis=0)
    kept = gap["contact_node"].values
    assert len(kept) == min(MOST, len(largest))
    assert largest[kept].min() >= np.sort(largest)[-len(kept)]
