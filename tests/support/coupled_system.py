"""The paper's six coupled modes with frequencies close to those of its stage."""

from bladewhirl.models.coupling.springs import CouplingModes, paper_modes

UNIT = 252.8
"""Lowest frequency of the bladed disk, the unit of speeds and frequencies [rad/s]."""

CASING, FIRST, SUSPENSION = 0.055 * UNIT, UNIT, 2.527 * UNIT


def six_modes(damping_ratio: float = 0.0) -> CouplingModes:
    """Pairs of casing, 1F and suspension with one nodal diameter."""
    return paper_modes(
        casing=CASING, first_flexural=FIRST, suspension=SUSPENSION, damping_ratio=damping_ratio
    )
