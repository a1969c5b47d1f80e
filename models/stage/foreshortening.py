"""Gaps that open as blades bend."""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray


@dataclass(frozen=True, kw_only=True)
class Foreshortening:
    """Quadratic forms of the distances by which tips move inward as their blades bend.

    The gap of tip j opens by 1/2 sum_i s_ji y_ji^2 with y_j = F_j x and the modal displacements x
    of the rotor.
    """

    rows: FloatArray  #: rows F of each tip [kg^-1/2 m^-1/2], (tips, terms, rotor modes)
    sign: FloatArray  #: signs s, 1 or -1, or 0 for terms that a tip does not have, (tips, terms)
    frequency: float  #: frequency of the fastest large term [rad/s]

    def opening(self, displacement: FloatArray) -> FloatArray:
        """Return the opening of each gap [m], (..., tips).

        Args:
            displacement: modal displacements of the rotor, (..., modes).
        """
        bent = np.einsum("jim,...m->...ji", self.rows, displacement)
        return np.asarray(0.5 * np.einsum("ji,...ji->...j", self.sign, bent**2))
