"""The paper's six coupled modes with frequencies close to those of its stage."""

import numpy as np

from bladewhirl.models.coupling.springs import CouplingModes


def paper_modes(
    *, casing: float, first_flexural: float, suspension: float, damping_ratio: float = 0.0
) -> CouplingModes:
    """Make the paper's six-mode system: three k = 1 pairs of unit amplitude (Eqs 4-9).

    Args:
        casing: frequency of the casing's k = 1 pair [rad/s].
        first_flexural: frequency of the bladed disk's 1F, k = 1 pair [rad/s].
        suspension: frequency of the suspension pair [rad/s].
        damping_ratio: modal damping ratio of all three pairs.
    """
    return CouplingModes(
        name=("casing", "1F", "suspension"),
        on_casing=np.array([True, False, False]),
        nodal_diameter=np.ones(3, dtype=np.int64),
        frequency=np.array([casing, first_flexural, suspension]),
        amplitude=np.ones(3),
        damping_ratio=np.full(3, damping_ratio),
        paired=np.ones(3, dtype=np.bool_),
    )


UNIT = 252.8
"""Lowest frequency of the bladed disk, the unit of speeds and frequencies [rad/s]."""

CASING, FIRST, SUSPENSION = 0.055 * UNIT, UNIT, 2.527 * UNIT


def six_modes(damping_ratio: float = 0.0) -> CouplingModes:
    """Pairs of casing, 1F and suspension with one nodal diameter."""
    return paper_modes(
        casing=CASING, first_flexural=FIRST, suspension=SUSPENSION, damping_ratio=damping_ratio
    )
