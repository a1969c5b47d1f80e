"""A branch of a 3D blade with two folds, against marches from both sides."""

from pathlib import Path

import numpy as np
import pytest
from command_line import answer
from periodic_cases import case

import bladewhirl as bw

UPPER, LOWER = 7526.0, 7287.0  #: speeds of the folds [rpm]


@pytest.mark.slow
def test_the_folds_are_where_marches_jump(tmp_path: Path) -> None:
    """With the speed going up, marches lose the large motion within 0.2 % of the upper fold; going
    down, they come to it within 0.2 % of the lower one."""
    own = case(**{"casing.closure": None, "casing.clearance": "0.25 mm"})
    branch = bw.branch(own, "march.speed", "6600 rpm", "7700 rpm", points=14)
    folds = branch["parameter"].values[branch["kind"].values == 1]
    assert folds == pytest.approx([UPPER, LOWER], abs=1.5)
    turned = branch["stable"].values[branch["impulse_per_revolution"].values > 10.0]
    assert turned.any()
    assert not turned.all()
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(own))
    up = [7400.0, 7480.0, 0.998 * UPPER, 1.002 * UPPER]
    down = [7400.0, 7330.0, 1.002 * LOWER, 0.998 * LOWER]
    found = {}
    for way, speeds in (("up", [7200.0, *up]), ("down", down[::-1])):
        over = "march.speed=" + ",".join(f"{speed!r} rpm" for speed in speeds)
        options = ("--continue", way, "--set", "march.duration=0.4", "-o", tmp_path / way)
        answer("sweep", file, "--over", over, *options)
        with bw.open_sweep(tmp_path / way) as sweep:
            found[way] = np.ravel(sweep["impulse_per_revolution"].values)
    assert (found["up"][:-1] > 40.0).all()
    assert found["up"][-1] < 10.0
    assert (found["down"][1:] < 10.0).all()
    assert found["down"][0] > 40.0
