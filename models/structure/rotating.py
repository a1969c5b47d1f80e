"""The matrices of a structure that rotates, at any speed and on any basis.

Small motions x about the state of steady rotation at the speed Omega follow in rotating axes

    M x'' + (D + Omega G) x' + (K + Omega^2 K1 + Omega^4 K2) x = f + Omega^2 F + Omega' E

with the centrifugal forces Omega^2 F and the Euler forces Omega' E on the undeformed structure.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, Literal, Self, TypeVar

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray

Effects = Literal["none", "centrifugal", "full"]
"""Rotation effects: none; "centrifugal", which is tension with its geometric stiffness and spin
softening; or "full", which adds Coriolis forces."""

M = TypeVar("M", bound=Any)
"""A dense or a sparse matrix, real or complex."""


@dataclass(frozen=True, kw_only=True)
class Rotating(Generic[M]):
    """Matrices of a structure on n coordinates, in SI units; the axis of rotation is z, and the
    structure rotates counter-clockwise."""

    FORMS: ClassVar[tuple[str, ...]] = (
        *("mass", "stiffness", "damping", "gyroscopic"),
        *("stiffness_speed", "stiffness_speed4"),
    )
    """Names of the matrices between coordinates."""
    LOADS: ClassVar[tuple[str, ...]] = ("centrifugal_load", "euler_load")
    """Names of the forces on the coordinates."""
    ROWS: ClassVar[tuple[str, ...]] = ()
    """Names of the matrices from coordinates to other quantities."""

    mass: M  #: mass matrix M [kg], (n, n), symmetric
    stiffness: M  #: stiffness matrix K [N/m], (n, n), symmetric
    damping: M | None = None  #: damping matrix D [N s/m], (n, n), symmetric
    gyroscopic: M | None = None
    """Skew matrix G of the Coriolis forces, for a speed of 1 rad/s [kg], (n, n)."""
    stiffness_speed: M | None = None
    """Change K1 of the stiffness by steady rotation (geometric stiffness minus spin softening), for
    a speed of 1 rad/s [kg], (n, n), symmetric; it grows with the square of the speed."""
    stiffness_speed4: M | None = None
    """Further change K2 of the stiffness (of the elastic stiffness by the second power of the
    static displacement) for a speed of 1 rad/s [kg s2], (n, n), symmetric; it grows with the fourth
    power of the speed."""
    speed: float | None = None
    """Speed of rotation to which the stiffness belongs [rad/s]; None if it is unknown. A structure
    with stiffness_speed of unknown speed is at rest."""
    centrifugal_load: FloatArray | None = None
    """Centrifugal forces F on the coordinates at a speed of 1 rad/s [kg m], (n,)."""
    euler_load: FloatArray | None = None
    """Euler forces E = -M (z x X) on the coordinates at an acceleration of the rotation of 1 rad/s2
    [kg m], (n,); with centrifugal_load."""

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return int(self.mass.shape[0])

    @property
    def loads(self) -> FloatArray:
        """The loads of the rotation that are known, (n, loads)."""
        given = [load for name in Rotating.LOADS if (load := getattr(self, name)) is not None]
        return np.reshape(given, (-1, self.size)).T

    @property
    def coriolis(self) -> M:
        """Matrix of the Coriolis forces -2 Omega x' and of the Euler forces -Omega' x, for 1
        [kg], (n, n): half of `gyroscopic`."""
        whole: Any = self.gyroscopic
        half: M = 0.5 * whole
        return half

    def given(self, names: Iterable[str]) -> dict[str, Any]:
        """Return those of some matrices or loads that are known, by name."""
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def change(self, omega: float | FloatArray) -> M:
        """Return what the stiffness at a speed [rad/s] has besides `stiffness`, (n, n), of a
        structure with `stiffness_speed`."""
        base, fourth = self.speed or 0.0, self.stiffness_speed4
        change: Any = self.stiffness_speed
        change = (omega**2 - base**2) * change
        if fourth is not None:
            change = change + (omega**4 - base**4) * fourth
        found: M = change
        return found

    def slope(self, omega: float) -> M:
        """Return the change of the stiffness with the square of the speed, near a speed [rad/s],
        (n, n), of a structure with `stiffness_speed`."""
        slope: Any = self.stiffness_speed
        if self.stiffness_speed4 is not None:
            slope = slope + 2.0 * omega**2 * self.stiffness_speed4
        found: M = slope
        return found

    def stiffness_at(self, omega: float | FloatArray) -> M:
        """Return the stiffness at a speed [rad/s], (n, n)."""
        if self.stiffness_speed is None:
            return self.stiffness
        stiffness: M = self.stiffness + self.change(omega)
        return stiffness

    def known(self, name: str) -> M:
        """Return one of the matrices by name, zero if there is none, (n, n)."""
        matrix: M | None = getattr(self, name)
        zero: Any = 0.0 * self.mass
        found: M = zero if matrix is None else matrix
        return found

    def drag(self, omega: float | FloatArray) -> M:
        """Return the matrix of all forces due to velocities, D + Omega G, at a speed [rad/s],
        (n, n)."""
        drag: M = self.known("damping") + omega * self.known("gyroscopic")
        return drag

    def under(self, effects: Effects) -> Self:
        """Return the structure with some of the effects of the rotation only."""
        left_out: dict[str, Any] = {}
        if effects != "full":
            left_out["gyroscopic"] = None
        if effects == "none":
            left_out |= {"stiffness_speed": None, "stiffness_speed4": None}
        return replace(self, **left_out)

    def at(self, omega: float, effects: Effects = "full") -> Self:
        """Return the structure linearised about its state of steady rotation.

        Args:
            omega: speed of rotation [rad/s].
            effects: effects of the rotation.
        """
        turning = self.under(effects)
        return replace(turning, stiffness=turning.stiffness_at(omega), speed=omega)

    def on(self, basis: Any) -> Self:
        """Return the structure on the coordinates q of a basis, x = basis q, (n, m)."""
        return replace(self, **self.projected(basis))

    def projected(self, basis: Any, names: Collection[str] | None = None) -> dict[str, Any]:
        """Return matrices and loads on a basis (n, m), by name, exactly symmetric or skew.

        Args:
            basis: columns of the basis, (n, m).
            names: names of the matrices and loads; all if None.
        """
        back, every = basis.conj().T, (*self.FORMS, *self.LOADS, *self.ROWS)
        found: dict[str, Any] = {}
        for name, value in self.given(every if names is None else names).items():
            if name in self.ROWS:
                found[name] = value @ basis
            elif name in self.LOADS:
                found[name] = back @ value
            else:
                form, sign = back @ (value @ basis), -1.0 if name == "gyroscopic" else 1.0
                found[name] = 0.5 * (form + sign * form.conj().T)
        return found

    def on_modes(self, squares: FloatArray, shapes: Any) -> dict[str, Any]:
        """Return the fields of `Rotating` on mass-normalised modes, by name.

        Args:
            squares: squared frequencies [rad2/s2], (modes,).
            shapes: modes, (n, modes).
        """
        names = {*Rotating.FORMS, *Rotating.LOADS} - {"mass", "stiffness"}
        return {**of_modes(squares), "speed": self.speed, **self.projected(shapes, names)}


def of_modes(squares: FloatArray) -> dict[str, sp.csr_array]:
    """Return mass and stiffness of mass-normalised modes with squared frequencies [rad2/s2]."""
    return {
        "mass": sp.csr_array(sp.eye_array(len(squares))),
        "stiffness": sp.csr_array(sp.diags_array(squares)),
    }
