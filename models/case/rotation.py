"""The `[rotation]` table of a case: what turning does to the bladed disk itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from bladewhirl.models.inputs.table import Inconsistency, Table

Effects = Literal["none", "centrifugal", "full"]
"""Rotation effects: none; tension, its stiffness and spin softening; those and Coriolis forces."""


class Rotation(Table):
    """Forces that the bladed disk feels because it turns; the paper leaves them out."""

    effects: Effects = "none"
    """"none", as in the paper; "centrifugal": tension in blades and disk, the stiffness that it
    gives, spin softening and the growth of the tips; "full": Coriolis forces, too. All at
    march.speed."""
    clearance: Literal["hot", "cold"] = "hot"
    """State that casing.clearance is measured in: "hot", at march.speed; "cold", at rest, so that
    the growth of the tips at march.speed is taken off it, which takes effects other than "none"."""

    @property
    def summary(self) -> str:
        """Its effects; nothing where there are none."""
        return "" if self.effects == "none" else f"{self.effects}, {self.clearance} clearance"

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """A cold clearance of tips that do not grow."""
        if self.effects == "none" and self.clearance == "cold":
            expected = '"hot", or rotation.effects = "centrifugal" or "full", with which tips grow'
            yield Inconsistency("clearance", expected, ("effects",))
