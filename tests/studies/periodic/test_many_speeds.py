"""Periodic motions of a 3D blade at many speeds against marches with small steps."""

import numpy as np
import pytest
from periodic_cases import case, growth, marched, rub

import bladewhirl as bw
from bladewhirl.models.stage.build import build_stage, contact_problem

SPEEDS = np.linspace(4200.0, 8200.0, 21)  #: [rpm]
STEPS = 1e-6 / 2.0 ** np.arange(5)  #: time steps of marches [s]
SETTLED = 20  #: periods in which a march settles


@pytest.mark.slow
@pytest.mark.parametrize("closure", ["0.09 mm", "0.1 mm"])
def test_impulses_and_multipliers_are_those_of_marches(closure: str) -> None:
    """Steps are halved until the impulse changes by less than 0.05 %, and the leading
    multiplier by less than 0.001. Where a motion is unstable, a march leaves it, and the multiplier
    is that at its start."""
    own = case(**{"casing.closure.amount": closure})
    data = bw.periodic(own, speeds=[f"{speed} rpm" for speed in SPEEDS.tolist()])
    assert not data.attrs["failures"]
    for n, speed in enumerate(SPEEDS.tolist()):
        one = data.isel(speed=n)
        at_speed = bw.with_values(own, {"march.speed": f"{speed} rpm"})
        problem = contact_problem(build_stage(at_speed))
        motion = rub(problem)
        leading = float(np.abs(one["multipliers"].values[0]))
        rates = list[float]()
        for step in STEPS:
            rates.append(growth(problem, motion, step, SETTLED if leading < 1.0 else 0))
            if len(rates) > 1 and abs(rates[-1] - rates[-2]) < 1e-3:
                break
        impulses = list[float]()
        for step in STEPS if leading < 1.0 else ():
            impulses.append(2.0 * marched(problem, motion, step, 80).contact_impulse[-1].sum())
            if len(impulses) > 1 and abs(impulses[-1] / impulses[-2] - 1.0) < 5e-4:
                break
        found = float(one["impulse_per_revolution"])
        print(
            f"{speed:.0f} rpm: impulse {found:.5g}, {impulses[-1:]}; {leading:.5f}, {rates[-1]:.5f}"
        )
        assert leading == pytest.approx(rates[-1], abs=5e-3), speed
        if impulses:
            assert found == pytest.approx(impulses[-1], rel=2e-3), speed
    assert np.count_nonzero(data["stable"]) >= 20
