"""The `[rotation]` table of a case: what turning does to the bladed disk itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from bladewhirl.models.inputs.table import Inconsistency, Table

Effects = Literal["none", "centrifugal", "full"]
"""Rotation effects: none; tension, its stiffness and spin softening; those and Coriolis forces."""


class Rotation(Table):
    """Forces on the bladed disk due to its rotation; the paper leaves them out."""

    effects: Effects = "none"
    """"none", as in the paper; "centrifugal": tension in blades and disk with its geometric
    stiffness, spin softening and static growth of the tips; "full": Coriolis forces as well. All at
    march.speed."""
    clearance: Literal["hot", "cold"] = "hot"
    """State in which casing.clearance is measured: "hot", at march.speed; "cold", at rest: the
    static growth of the tips at march.speed is subtracted from it, which needs effects other than
    "none"."""

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """A cold clearance of tips that do not grow."""
        if self.effects == "none" and self.clearance == "cold":
            expected = '"hot", or rotation.effects = "centrifugal" or "full", with which tips grow'
            yield Inconsistency("clearance", expected, ("effects",))
