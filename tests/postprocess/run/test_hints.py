"""Hints of a run about displacements and stresses that no linear model describes."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.run.hints import run_hints
from bladewhirl.postprocess.run.summary import summarise


@pytest.fixture
def result() -> xr.Dataset:
    return synthetic.synthetic_result()


def test_tips_that_bend_far_are_pointed_out(result: xr.Dataset) -> None:
    shapes = result["rotor_shape"].values[result["tip_node"].values, :2]
    moved = np.einsum("bcm,tm->tbc", shapes, result["rotor_displacement"].values)
    largest = float(np.linalg.norm(moved, axis=2).max())
    summary = summarise(result, synthetic.REPORT)
    assert summary.tip_displacement_max == pytest.approx(largest, rel=1e-12)
    for share, expected in ((0.099, None), (0.101, "draw back"), (0.34, "off by a tenth or")):
        hints = run_hints(summary, result.assign_attrs(blade_length=largest / share))
        assert len(hints) == (expected is not None)
        for hint in hints:
            assert f"{largest:.3g} m, {share:.2g} of the length" in hint
            assert str(expected) in hint


def test_a_stress_that_no_metal_bears_is_pointed_out(result: xr.Dataset) -> None:
    """Unless the case gives a yield strength, with which the summary compares it."""
    modulus = float(result["rotor_young_modulus"].max())
    summary = summarise(result, synthetic.REPORT)
    assert summary.stress_max is not None
    now = abs(summary.stress_max["bladed_disk"]["stress"])
    for strain, expected in ((0.0049, 0), (0.0052, 1)):
        scaled = result.assign(
            rotor_displacement=result["rotor_displacement"] * strain * modulus / now
        )
        far = summarise(scaled, synthetic.REPORT)
        hints = [one for one in run_hints(far, scaled) if "stress" in one]
        assert len(hints) == expected
        for hint in hints:
            assert "0.52 % of Young's modulus" in hint
            assert "material.yield_strength" in hint
        limited = scaled.assign_attrs(yield_strength=1e9)
        assert not any(
            "stress" in one for one in run_hints(summarise(limited, synthetic.REPORT), limited)
        )
