"""Parameters that decide the motion, as sets of values, and the case that each set means.

Most are left out by the paper. A few it gives, and are varied to see what they decide: a set knows
which of them it changes.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from math import asin, pi, sqrt
from typing import Any, Literal

from bladewhirl.models.case.file import with_values
from bladewhirl.models.modal.full_stage import modal_stage
from bladewhirl.studies.paper.cases import CASES

MODAL_FORCE = 3e4
"""Of the paper's Table 2 [N/kg^0.5]."""

SHORTEST = 5e-6
"""Shortest push [s]."""

ALIKE = 0.15
"""Relative difference up to which values are tried for a better fit, not to see what they do."""

GIVEN: Mapping[str, Any] = {"wall": 0.01, "mass": 1.0, "friction": 0.1, "tip_mass": 0.0}
"""Parameters whose value the paper gives: the section of its beams in Table 1 and the friction in
Table 2; it has no masses at the tips."""


@dataclass(frozen=True, kw_only=True)
class ParameterSet:
    """One choice of what the paper leaves out."""

    disk: float = 0.03  #: thickness of the disk's beams [m]
    wall: float = 0.01  #: thickness of the casing [m]
    strain: Literal["exact", "shallow"] = "exact"  #: of the casing
    frequency: float = 0.055  #: of the casing as a rigid ring on its support, over ω₁
    mass: float = 1.0  #: of the casing, over that of Table 1's section
    damping: float = 0.005  #: ratio, of all modes
    push: Literal["hit", "hold"] = "hit"  #: short, or the paper's force held
    swing: float = 1.2  #: of the casing by a hit, if nothing were in the way [clearances]
    hold: float = 0.15  #: how long a held push acts [s]
    ramp: float = 0.2  #: of the imbalance [s]
    sliding: Literal["permanent", "signed"] = "permanent"
    tip_rotation: bool = False
    friction: float = 0.1  #: coefficient
    tip_mass: float = 0.0  #: at each tip [kg]

    def changes(self) -> dict[str, Any]:
        """Changes of the paper's cases, by dotted key."""
        given = CASES["modal"]
        wall = given.casing.wall
        line_mass = given.material.density * wall.width * wall.thickness * self.mass
        omega = self.frequency * reference_frequency(self.disk, self.tip_mass)
        radius = given.bladed_disk.tip_radius + given.casing.clearance
        # A ring that moves as a whole has the mode shape cos in radius and sin along it.
        ring_mass = 2.0 * pi * radius * line_mass
        swing = self.swing * given.casing.clearance * sqrt(ring_mass)
        return {
            "bladed_disk.disk.thickness": self.disk,
            "bladed_disk.tip_mass": self.tip_mass,
            "casing.wall.thickness": self.wall,
            "casing.wall.width": wall.width * wall.thickness * self.mass / self.wall,
            "casing.curvature": self.strain,
            "casing.support": omega**2 * line_mass,
            "damping.ratio": self.damping,
            "contact.friction": self.friction,
            "contact.sliding": self.sliding,
            "contact.tip_rotation": self.tip_rotation,
            "excitation.ramp": self.ramp,
            **(_held(self.hold) if self.push == "hold" else _hit(swing, omega)),
        }

    @property
    def given_changed(self) -> tuple[str, ...]:
        """Parts of `GIVEN` it changes, in words; empty if nothing."""
        own = asdict(self)
        return tuple(PARAMETERS[name] for name, value in GIVEN.items() if own[name] != value)

    @property
    def departures(self) -> tuple[str, ...]:
        """Parts of the paper's Tables 1 and 2 it changes, in words; empty if nothing."""
        changed = list(self.given_changed)
        if self.changes()["excitation.modal_force"] > MODAL_FORCE:
            changed.append("modal force")
        return tuple(changed)

    def uses(self, name: str) -> bool:
        """Whether a parameter matters: not how long a hit is held, nor how far a held push goes."""
        return name != {"hit": "hold", "hold": "swing"}[self.push]

    def words(self, left_out: Container[str] = ()) -> str:
        """All values in a line, but for those of some parameters."""
        return ", ".join(
            f"{PARAMETERS[name]} {value}"
            for name, value in asdict(self).items()
            if name not in left_out and self.uses(name)
        )

    def neighbours(self) -> Iterator[ParameterSet]:
        """Sets that differ in one value."""
        own = asdict(self)
        for name, values in UNKNOWNS.items():
            for value in values:
                if value != own[name] and self.uses(name):
                    yield replace(self, **{name: value})

    def resembles(self, other: ParameterSet) -> bool:
        """Whether no number of it is off that of another set by more than `ALIKE`."""
        theirs = asdict(other)
        return all(
            isinstance(value, float) and abs(value - theirs[name]) <= ALIKE * abs(theirs[name])
            for name, value in self.difference(other).items()
        )

    def difference(self, other: ParameterSet) -> dict[str, Any]:
        """Own values that another set does not have."""
        theirs = asdict(other)
        return {name: value for name, value in asdict(self).items() if value != theirs[name]}


UNKNOWNS: Mapping[str, tuple[Any, ...]] = {
    "swing": (1.2, 1.5, 3.0, 5.9),
    "hold": (0.006, 0.0085, 0.009, 0.0095, 0.0105, 0.015, 0.03, 0.15),
    "damping": (0.0005, 0.0008, 0.001, 0.0012, 0.002, 0.005),
    "frequency": (0.055, 1.0, 1.5, 2.0, 2.2839, 2.5, 3.0, 4.0, 6.0),
    "ramp": (0.0, 0.02, 0.05, 0.1, 0.2),
    "push": ("hit", "hold"),
    "sliding": ("permanent", "signed"),
    "strain": ("exact", "shallow"),
    "disk": (0.01, 0.02, 0.03, 0.04),
    "tip_rotation": (False, True),
    "mass": (1.0, 20.0, 50.0, 100.0, 200.0, 400.0),
    "wall": (0.005, 0.01, 0.02, 0.04),
    "friction": (0.05, 0.1, 0.15, 0.2),
    "tip_mass": (0.0, 0.1, 0.3),
}
"""Values tried of each; what the paper gives comes last."""

PARAMETERS: Mapping[str, str] = {
    "swing": "push [clearances]",
    "hold": "push held [s]",
    "damping": "damping ratio",
    "frequency": "casing frequency over ω₁",
    "ramp": "ramp of the imbalance [s]",
    "push": "kind of push",
    "sliding": "sliding",
    "strain": "casing strain",
    "disk": "disk beams [m]",
    "tip_rotation": "tip rotation",
    "mass": "casing mass over Table 1's",
    "wall": "casing thickness [m]",
    "friction": "friction coefficient",
    "tip_mass": "mass at each tip [kg]",
}
"""In words."""

STARTS: Mapping[str, ParameterSet] = {
    "soft": ParameterSet(swing=3.0),
    "supported": ParameterSet(frequency=4.0, push="hold"),
    # In the middle of the sets whose motion grows for two seconds after a short push.
    "light": ParameterSet(frequency=2.2839, push="hold", hold=0.009, damping=0.001, ramp=0.1),
    # A ring far above k_o / Omega^2, 480 kg: it yields less to a rotating load than the
    # shaft does, however soft its support.
    "heavy": ParameterSet(wall=0.04, mass=400.0, damping=0.02, swing=1.5),
}
"""Beginnings of a search: the modal case, the supported casing pushed for long, the same with light
damping and a short push, and a casing of large inertia."""

assert set(UNKNOWNS) == set(PARAMETERS) == {field.name for field in fields(ParameterSet)}


@lru_cache
def reference_frequency(disk: float, tip_mass: float) -> float:
    """Lowest frequency of the bladed disk [rad/s].

    Args:
        disk: thickness of the disk's beams [m].
        tip_mass: at each tip [kg].
    """
    changes = {"bladed_disk.disk.thickness": disk, "bladed_disk.tip_mass": tip_mass}
    return modal_stage(with_values(CASES["modal"], changes)).reference_frequency


def _held(duration: float) -> dict[str, float]:
    return {"excitation.modal_force": MODAL_FORCE, "excitation.duration": duration}


def _hit(swing: float, omega: float) -> dict[str, float]:
    """Force and duration of a rectangular push of an oscillator, which is short.

    After a time T it swings by 2 F / ω² sin(ω T / 2). A hit that the paper's force can't give
    takes a larger one for half a period.

    Args:
        swing: modal [m kg^0.5].
        omega: frequency of the oscillator [rad/s].
    """
    force = max(MODAL_FORCE, 0.5 * swing * omega**2)
    duration = 2.0 / omega * asin(min(1.0, 0.5 * swing * omega**2 / force))
    return {
        "excitation.modal_force": float(f"{force:.6g}"),
        "excitation.duration": max(round(duration, 7), SHORTEST),
    }
