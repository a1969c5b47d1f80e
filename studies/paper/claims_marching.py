"""Claims of Section 4.2: convergence in the time step (16) and in the number of modes (17)."""

from __future__ import annotations

from bladewhirl.postprocess.run.measures import Motion, orbit_distance
from bladewhirl.studies.paper.claim import (
    Finding,
    at_least,
    at_most,
    equal,
    evaluates,
)
from bladewhirl.studies.paper.trials import MODES, NotTestableError

CONVERGED = 0.01
"""Relative distance of two orbits below which they count as the same."""


@evaluates(16)
def time_step_converged(coarse: Motion, chosen: Motion, fine: Motion) -> Finding:
    impulses = [float(m.result["contact_impulse"].sum()) for m in (chosen, fine)]
    apart, before = orbit_distance(chosen, fine), orbit_distance(coarse, fine)
    if not impulses[1]:
        raise NotTestableError("no contact with the finest time step")
    change = abs(impulses[0] / impulses[1] - 1.0)
    return Finding(
        ours=f"orbit {100 * apart:.2g} %, impulse {100 * change:.2g} % from that at 0.5 µs",
        checks=(
            at_most("distance of the orbits at 1 and 0.5 µs", apart, CONVERGED),
            at_most("difference of the impulses at 1 and 0.5 µs", change, CONVERGED),
            at_most("distance at 1 µs over that at 2 µs", apart / (before or 1.0), 1.0),
        ),
    )


@evaluates(17)
def modes_converged(*motions: Motion) -> Finding:
    regimes = {motion.regime.name for motion in motions}
    *others, last = motions
    apart = [orbit_distance(motion, last) for motion in others]
    return Finding(
        ours=f"{', '.join(sorted(regimes))}; orbits with {', '.join(map(str, MODES[:-1]))} modes"
        f" {', '.join(f'{100 * d:.2g}' for d in apart)} % from that with {MODES[-1]}",
        checks=(
            equal("kinds of motion", len(regimes), 1, essential=True),
            at_least("distance of the orbits with the most modes", apart[-1], CONVERGED),
        ),
    )
