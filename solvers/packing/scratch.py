"""Working arrays of a march."""

from __future__ import annotations

import numpy as np

from bladewhirl.solvers.kernel.arrays import (
    HALF,
    LANES,
    Casing,
    ContactScratch,
    Dampers,
    FieldScratch,
    Rotor,
    Scratch,
    Springs,
    SpringScratch,
)
from bladewhirl.solvers.packing.arrangement import (
    Arrangement,
    aligned,
    aligned_copy,
    padded,
)


def make_scratch(
    rotor: Rotor,
    casing: Casing,
    arrangements: tuple[Arrangement, Arrangement],
    springs: Springs | None,
    dampers: Dampers | None,
) -> Scratch:
    """Working arrays for one march."""
    waves = len(springs.factor) if springs is not None else 0
    strokes = max(len(dampers.rotor.rows), len(dampers.casing.rows)) if dampers is not None else 0
    # Columns, the first half of them once more, and what the last register runs over.
    columns = padded(max(a.columns + a.half + LANES for a in arrangements))
    tips, wide, nodes = len(rotor.spread), len(rotor.position), casing.radial.start.shape[1]
    return Scratch(
        fields=FieldScratch(
            rotor=aligned(columns),
            value=aligned(columns),
            slope=aligned(columns),
            nodal=aligned(nodes),
            nodal_slope=aligned(nodes),
            moved=aligned((2, max(a.entries for a in arrangements))),
            at=aligned(wide),
            element=np.zeros(tips, dtype=np.int64),
            hermite=aligned((4, wide)),
            radial=aligned(wide),
            tangential=aligned(wide),
            other=aligned(wide),
            free_gap=aligned(wide),
            gap=aligned(wide),
        ),
        contact=ContactScratch(
            sign=np.zeros(tips),
            multiplier=np.zeros(tips),
            active=np.zeros(tips, dtype=np.int64),
            known=np.zeros((2, tips), dtype=np.int64),
            on_rotor=aligned((tips, wide)),
            ends=aligned(HALF * wide),
            system=aligned((tips + 1, wide)),
            others=aligned_copy(1.0 - np.eye(tips, wide)),
            diagonal=np.zeros(tips),
            solution=np.zeros(tips),
            tableau=np.zeros((tips, 2 * tips + 2)),
            basis=np.zeros(tips, dtype=np.int64),
            rows=np.zeros(2 * wide, dtype=np.int64),
            factor=aligned((6, 2 * wide)),
            columns=aligned((6, columns)),
            work=np.zeros(2),
        ),
        springs=SpringScratch(
            rotor=np.zeros((2, waves)),
            casing=np.zeros((2, waves)),
            stretch=np.zeros((4, waves)),
            force=np.zeros((2, waves)),
        ),
        turned=aligned(arrangements[0].entries),
        amplitude=np.zeros(len(rotor.body.load)),
        stroke=np.zeros(strokes),
        damper_force=np.zeros((2, strokes)),
    )
