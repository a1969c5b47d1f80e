"""Parameters that the paper leaves out, as sets of values, and the case that each set means."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from math import asin, pi, sqrt
from typing import Any, Literal

from bladewhirl.models.case_file import with_values
from bladewhirl.models.modal_stage import modal_stage
from bladewhirl.studies.paper_cases import CASES

MODAL_FORCE = 3e4
"""Of the paper's Table 2 [N/kg^0.5]."""

HOLD = 0.15
"""How long a held push acts [s]."""

SHORTEST = 5e-6
"""Shortest push [s]."""


@dataclass(frozen=True, kw_only=True)
class ParameterSet:
    """One choice of what the paper leaves out."""

    disk: float = 0.03  #: thickness of the disk's beams [m]
    wall: float = 0.01  #: thickness of the casing [m]
    strain: Literal["exact", "shallow"] = "exact"  #: of the casing
    frequency: float = 0.055  #: of the casing as a rigid ring on its support, over ω₁
    mass: float = 1.0  #: of the casing, over that of Table 1's section
    damping: float = 0.005  #: ratio, of all modes
    push: Literal["hit", "hold"] = "hit"  #: short, or held for `HOLD`
    swing: float = 1.2  #: of the casing by the push, if nothing were in the way [clearances]
    ramp: float = 0.2  #: of the imbalance [s]
    sliding: Literal["permanent", "signed"] = "permanent"
    tip_rotation: bool = False

    def changes(self) -> dict[str, Any]:
        """Changes of the paper's cases, by dotted key."""
        given = CASES["modal"]
        wall = given.casing.wall
        line_mass = given.material.density * wall.width * wall.thickness * self.mass
        omega = self.frequency * reference_frequency(self.disk)
        radius = given.bladed_disk.tip_radius + given.casing.clearance
        # A ring that moves as a whole has the mode shape cos in radius and sin along it.
        ring_mass = 2.0 * pi * radius * line_mass
        swing = self.swing * given.casing.clearance * sqrt(ring_mass)
        return {
            "bladed_disk.disk.thickness": self.disk,
            "casing.wall.thickness": self.wall,
            "casing.wall.width": wall.width * wall.thickness * self.mass / self.wall,
            "casing.curvature": self.strain,
            "casing.support": omega**2 * line_mass,
            "damping.ratio": self.damping,
            "contact.sliding": self.sliding,
            "contact.tip_rotation": self.tip_rotation,
            "excitation.ramp": self.ramp,
            **_push(self.push, swing, omega),
        }

    def words(self, left_out: Container[str] = ()) -> str:
        """All values in a line, but for those of some parameters."""
        return ", ".join(
            f"{PARAMETERS[name]} {value}"
            for name, value in asdict(self).items()
            if name not in left_out
        )

    def neighbours(self) -> Iterator[ParameterSet]:
        """Sets that differ in one value."""
        own = asdict(self)
        for name, values in UNKNOWNS.items():
            for value in values:
                if value != own[name]:
                    yield replace(self, **{name: value})

    def difference(self, other: ParameterSet) -> dict[str, Any]:
        """Own values that another set does not have."""
        theirs = asdict(other)
        return {name: value for name, value in asdict(self).items() if value != theirs[name]}


UNKNOWNS: Mapping[str, tuple[Any, ...]] = {
    "swing": (1.1, 1.15, 1.2, 1.3, 1.5, 3.0, 5.9, 200.0),
    "damping": (0.005, 0.01, 0.02, 0.03, 0.05),
    "mass": (1.0, 20.0, 100.0, 200.0, 400.0, 700.0, 1200.0),
    "wall": (0.005, 0.01, 0.02, 0.04, 0.06),
    "frequency": (0.03, 0.055, 0.1, 1.0, 2.0, 4.0, 9.7),
    "sliding": ("permanent", "signed"),
    "push": ("hit", "hold"),
    "strain": ("exact", "shallow"),
    "ramp": (0.0, 0.2),
    "disk": (0.02, 0.03, 0.04),
    "tip_rotation": (False, True),
}
"""What is tried of each; those that matter most come first."""

PARAMETERS: Mapping[str, str] = {
    "swing": "push [clearances]",
    "damping": "damping ratio",
    "mass": "casing mass over Table 1's",
    "wall": "casing thickness [m]",
    "frequency": "casing frequency over ω₁",
    "sliding": "friction",
    "push": "kind of push",
    "strain": "casing strain",
    "ramp": "ramp of the imbalance [s]",
    "disk": "disk beams [m]",
    "tip_rotation": "tip rotation",
}
"""In words."""

STARTS: Mapping[str, ParameterSet] = {
    "soft": ParameterSet(swing=3.0),
    "supported": ParameterSet(frequency=4.0, push="hold", swing=5.9),
    # A ring far above k_o / Omega^2, about 490 kg: it yields less to a rotating load than the
    # shaft does, however soft its support.
    "heavy": ParameterSet(wall=0.04, mass=400.0, damping=0.02),
}
"""Where a search begins: the modal case, the supported casing, and one of large inertia."""

assert set(UNKNOWNS) == set(PARAMETERS) == {field.name for field in fields(ParameterSet)}


@lru_cache
def reference_frequency(disk: float) -> float:
    """Lowest frequency of the bladed disk [rad/s] with disk beams of a thickness [m]."""
    case = with_values(CASES["modal"], {"bladed_disk.disk.thickness": disk})
    return modal_stage(case).reference_frequency


def _push(push: str, swing: float, omega: float) -> dict[str, float]:
    """Force and duration of a rectangular push of an oscillator.

    After a time T it swings by 2 F / ω² sin(ω T / 2); held, it settles at F / ω². A hit that the
    paper's force can't give takes a larger one for half a period.

    Args:
        push: "hit" or "hold".
        swing: modal [m kg^0.5].
        omega: frequency of the oscillator [rad/s].
    """
    if push == "hold":
        force, duration = swing * omega**2, HOLD
    else:
        force = max(MODAL_FORCE, 0.5 * swing * omega**2)
        duration = 2.0 / omega * asin(min(1.0, 0.5 * swing * omega**2 / force))
    return {
        "excitation.modal_force": float(f"{force:.6g}"),
        "excitation.duration": max(round(duration, 7), SHORTEST),
    }
