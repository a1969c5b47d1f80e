"""Arrays of an abradable coating on the wall."""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class WallCoating:
    """Abradable coating on the wall: elastic-plastic rods in tracks, one track for each axial
    position of tips.

    Source: Legrand, Batailly and Pierre, J. Comput. Nonlinear Dyn. 7 (2012).
    """

    thickness: float  #: thickness [m]
    young_modulus: float  #: Young's modulus [Pa]
    yield_stress: float  #: yield stress [Pa]
    hardening: float  #: increase of the yield stress per plastic strain [Pa]
    limit: float  #: largest plastic strain
    strain: FloatArray  #: plastic strain of each rod at the start, (tracks, rods)
    axial: FloatArray  #: axial position of each track [m], (tracks,)
    width: FloatArray  #: size of each track along the axis [m], (tracks,)
    track: IntArray  #: track of each tip of a copy, (tips,)
    footprint: FloatArray  #: arc that each tip of a copy covers [m], (tips,)
    radius: float  #: radius of the wall [m]

    @property
    def removable(self) -> float:
        """Depth of the metal below the surface of the new coating [m]."""
        return self.limit * self.thickness

    @property
    def arc(self) -> float:
        """Arc length of a rod [m]."""
        return float(2.0 * np.pi * self.radius / self.strain.shape[1])


def rod_angles(rods: int) -> FloatArray:
    """Return the angle of the middle of each rod of a coating [rad], (rods,)."""
    return np.asarray(2.0 * np.pi / rods * (np.arange(rods) + 0.5))
