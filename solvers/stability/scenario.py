"""Contact scenarios of a whirling shaft: place of the contact and effect of friction (Figs 9, 10).

Radial fields with one nodal diameter are Re(C exp(-i theta)), with their crest at arg(C). A shaft
displacement (x, y) is the phasor x + i y, which is also the C of a translation. With C = W on the
casing and C = U at the blade tips, the clearance changes by Re((W - U) exp(-i theta)). The
clearance is smallest at arg(U - W):

* *standard*: on the side to which the shaft is displaced, because the rotor moves more than the
  casing. Friction drags the shaft against the rotation and drives backward whirl.
* *inverted*: on the opposite side, because the casing moves more than the rotor (or the tips move
  against the centre). Friction drags the shaft in the sense of rotation and drives forward whirl.

All angles are in one frame, rotating or static; their differences do not depend on the frame.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray

Kind = Literal["standard", "inverted", "unsteady"]

STEADY = 0.5
"""Least `Scenario.steadiness` of a standard or inverted motion; below it a motion is unsteady."""

SMALLEST = 1e-9
"""A displacement up to this fraction of the largest amplitude counts as zero."""


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Angle between the shaft's displacement and the smallest clearance."""

    lead: float  #: angle of the shaft minus angle of the smallest clearance, (-pi, pi] [rad]
    steadiness: float  #: length of the mean of exp(i lead), from 0 to 1; 1 if the lead is constant

    @property
    def kind(self) -> Kind:
        """Standard or inverted; unsteady if the lead has no preferred value."""
        if self.steadiness < STEADY:
            return "unsteady"
        return "standard" if abs(self.lead) < np.pi / 2 else "inverted"


def mode_scenario(*, shaft: complex, rotor: complex, casing: complex) -> Scenario:
    """Return the scenario of a rotor mode and a casing mode with k = 1 and the same phase.

    Args:
        shaft: displacement x + i y of the centre.
        rotor: U of the blade tips, in the unit of ``shaft``.
        casing: W of the casing, in the unit of ``shaft``.

    Raises:
        ValueError: the shaft does not move, or the clearance does not change.
    """
    closing = rotor - casing
    if abs(shaft) <= SMALLEST * max(abs(rotor), abs(casing)):
        raise ValueError("the shaft does not move in this mode: it has no contact scenario")
    if abs(closing) <= SMALLEST * max(abs(rotor), abs(casing)):
        raise ValueError("rotor and casing move by the same amount: the clearance does not change")
    lead = np.angle(shaft / closing)
    return Scenario(lead=float(lead), steadiness=1.0)


def motion_scenario(
    *, shaft: ArrayLike, clearance_angle: ArrayLike, weight: ArrayLike | None = None
) -> Scenario:
    """Return the scenario of a motion, from the mean angle between shaft and smallest clearance.

    Args:
        shaft: displacement x, y of the centre over time [m], (times, 2).
        clearance_angle: angle of the smallest clearance or of the contact [rad], (times,).
        weight: weight of each instant, such as its contact impulse; None for equal weights.
            Instants at which the shaft does not move have no weight.

    Raises:
        ValueError: the shaft does not move at any instant with a weight.
    """
    lead = shaft_lead(shaft, clearance_angle)
    weights = np.ones(len(lead)) if weight is None else np.asarray(weight, float)
    weights = np.where(np.isnan(lead), 0.0, weights)
    if not weights.sum() > 0.0:
        raise ValueError("the shaft does not move: there is no contact scenario")
    mean = np.sum(weights * np.exp(1j * np.nan_to_num(lead))) / weights.sum()
    return Scenario(lead=float(np.angle(mean)), steadiness=float(abs(mean)))


def shaft_lead(shaft: ArrayLike, clearance_angle: ArrayLike) -> FloatArray:
    """Return the angle from the smallest clearance to the shaft, in (-pi, pi] [rad], (times,).

    Args:
        shaft: displacement x, y of the centre over time [m], (times, 2).
        clearance_angle: angle of the smallest clearance [rad], (times,).

    Returns:
        the angles; NaN at instants at which the shaft does not move.
    """
    x, y = np.asarray(shaft, float).T
    radius = np.hypot(x, y)
    moving = radius > SMALLEST * radius.max(initial=0.0)
    lead = np.angle(np.exp(1j * (np.arctan2(y, x) - np.asarray(clearance_angle, float))))
    return np.where(moving, lead, np.nan)


def smallest_clearance_angle(gap: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return the angle of the tip with the smallest gap at each instant [rad], (times,).

    Args:
        gap: gap of each tip over time [m], (times, tips).
        angle: angle of each tip [rad], (tips,), in the frame of the result, rotating or static.
    """
    return np.asarray(np.asarray(angle, float)[np.argmin(np.asarray(gap, float), axis=1)])
