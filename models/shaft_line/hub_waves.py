"""A wheel of solids with a hub, reduced in the waves that move the hub.

A wheel with equal blades moves a shaft by two waves only: that of nodal diameter 0 along and about
the axis, that of nodal diameter 1 by the deflection zeta = u_x + i u_y and the slope pi = p_x + i
p_y of the axis. Each has two displacements of the hub and amplitudes of the wheel with a fixed hub.
In rotating axes the real motion of the wheel is the real part of `fields` times the conjugate
amplitudes for nodal diameter 1, which turns with the hub as the complex number zeta does.

The basis has the rigid motions with the hub; the lowest modes with a fixed hub; and the static
displacements by the inertia, Coriolis and centrifugal forces of the former, by the Coriolis forces
of the latter, and by forces on the blades, all at rest and at the highest speed. Of a wheel in one
piece, whose blades must be equal, those modes are taken that the forces of a wave drive.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.cholesky import Cholesky
from bladewhirl.models.superelements.hub import (
    HELD,
    NEEDED,
    WAVES,
    check_hub,
    hub_freed,
    hub_of,
    inner_dofs,
    rigid_motions,
    sectors_of,
)
from bladewhirl.models.superelements.joined import joined, over_speeds
from bladewhirl.models.superelements.nodal_blocks import BY_VELOCITY, EQUAL
from bladewhirl.models.superelements.reduction import lowest_modes
from bladewhirl.models.superelements.sector import Sector
from bladewhirl.models.superelements.superelement import (
    IndefiniteError,
    Superelement,
    SuperelementError,
    dense,
)

KEPT = 24  #: number of modes with a fixed hub, at rest and at the highest speed

ALL, LOWEST = 2000, 300
"""Number of coordinates up to which all modes of a wheel in one piece are computed, and number of
those of a larger one, of all nodal diameters."""

DRIVEN = 1e-7
"""A combination of modes is driven by loads if they have at least this part in it, as a fraction of
the product of their norms."""

ROUNDING = 1e-9
"""A force is a rounding error if it is at most this fraction of the sum of the sizes of its terms
for the largest displacement."""

UNEQUAL_BLADES = Fault(expected="equal blades; a wheel on a shaft line cannot be mistuned")

UNEQUAL = 1e-3
"""Blades are equal if the mass between a wave and its mirror image is at most this fraction of that
of the wave."""


@dataclass(frozen=True, kw_only=True)
class HubWave(Rotating[ComplexArray]):
    """A wheel in the waves of one nodal diameter, in rotating axes, on two displacements of the hub
    and m - 2 amplitudes: of u_z and theta_z, or of zeta and pi."""

    ROWS: ClassVar[tuple[str, ...]] = ("contact",)

    contact: ComplexArray
    """Radial, tangential and axial displacements of the contact nodes of the first sector, or of
    the wheel, (3c, m)."""

    def turning(self, omega: float) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return mass, damping and stiffness in static axes at a speed [rad/s], (m, m) each, for
        amplitudes z = zeta exp(i Omega t)."""
        mass, drag, stiffness = self.mass, self.drag(omega), self.stiffness_at(omega)
        static = stiffness - 1j * omega * drag - omega**2 * mass
        return mass, drag - 2j * omega * mass, static


def hub_waves(
    part: Superelement, highest: float, bases: Mapping[int, Any] | None = None
) -> dict[int, HubWave]:
    """Return the waves of nodal diameter 0 and 1 of a wheel or of the first of its sectors.

    Args:
        part: superelement with hub_dofs.
        highest: highest speed at which the waves are used [rad/s].
        bases: fields of each nodal diameter of a wheel in one piece on the coordinates that are not
            those of the hub, sparse (n - 6, fields), if they are known.

    Raises:
        SuperelementError: there is no hub, it does not hold the wheel, matrices are missing or not
            those of a rigid body on its motions, or the blades of a wheel are not equal.
    """
    hub_of(part)
    if missing := [key for key in NEEDED if highest and getattr(part, key) is None]:
        text = "by which a wheel that turns with a shaft line tilts"
        raise SuperelementError(Fault(expected=f"{' and '.join(missing)}, {text}"))
    motions = rigid_motions(part)
    check_hub(part, motions)
    try:
        states = map(hub_freed, over_speeds(part, highest, between=False))
        held = [_held(each) if bases is None else _Fields(each, bases) for each in states]
    except la.LinAlgError:
        raise IndefiniteError(HELD) from None
    return {k: _wave(part, motions @ WAVES[k], held, k) for k in WAVES}


def _wave(part: Superelement, rigid: ComplexArray, states: "list[_Held]", k: int) -> HubWave:
    """Return a wave from the rigid motions of the wheel, (n, 2)."""
    inner, sectors, still = inner_dofs(part), sectors_of(part), hub_freed(part)
    names = ("mass", "gyroscopic", "damping", "stiffness_speed", "stiffness_speed4")
    loads = []
    for form in part.given(names).values():
        load, size = form @ rigid, abs(form) @ np.full(rigid.shape, abs(rigid).max(axis=0))
        load, size = load[inner], size[inner]
        loads.append(load[:, la.norm(load, axis=0) > ROUNDING * la.norm(size, axis=0)])
    on_blades = _on_blades(part, k)[inner]
    loads.append(on_blades[:, on_blades.any(axis=0)])  # beams have no axial displacements
    fields = []
    for held in states:
        shapes = held.modes(k, np.hstack(loads))
        by_velocity = [form @ shapes for form in still.given(BY_VELOCITY).values()]
        fields += [shapes, held.solve(k, np.hstack([*loads, *by_velocity]))]
    among = joined(still, fields)
    basis = np.zeros((part.size, 2 + among.shape[1]), np.complex128)
    basis[:, :2], basis[inner, 2:] = rigid, among
    basis = basis.conj()
    if k and part.left_dofs is None:
        mirror = abs(basis.T @ (part.mass @ basis))[2:, 2:]
        if mirror.size and mirror.max() > UNEQUAL:
            raise SuperelementError(UNEQUAL_BLADES)
    share = sectors / (1 + k)  # the wave of nodal diameter 1 is two real ones
    forms = part.projected(basis, Rotating.FORMS)
    forms["stiffness"][:2] = forms["stiffness"][:, :2] = 0.0  # but for rounding errors
    return HubWave(
        **{name: share * form for name, form in forms.items()},
        speed=part.speed,
        contact=np.asarray(part.contact_rows @ basis),
    )


def _on_blades(part: Superelement, k: int) -> ComplexArray:
    """Return radial, tangential and axial forces on the contact nodes of each blade with a nodal
    diameter, (n, 3); (n, 0) of a wheel that does not tell its number of blades."""
    blades = 1 if part.left_dofs is not None else (part.sectors or 0)
    if not blades or part.contacts % blades:
        return np.zeros((part.size, 0), np.complex128)
    x, y = part.contact_position[:, :2].reshape(blades, -1, 2).mean(axis=1).T
    turn = np.repeat(np.exp(1j * k * np.arctan2(y, x)), part.contacts // blades)
    shares = np.kron(turn[:, None], np.eye(3))
    return np.asarray(part.contact_rows.T @ shares)


class _Held(Protocol):
    """A wheel with a fixed hub."""

    def modes(self, k: int, loads: ComplexArray) -> ComplexArray:
        """Return the lowest modes of a nodal diameter that loads drive, (n, m)."""

    def solve(self, k: int, loads: ComplexArray) -> ComplexArray:
        """Return the static displacements by loads with a nodal diameter, (n, m)."""


def _held(part: Superelement) -> _Held:
    return _Wheel(part) if part.left_dofs is None else _Sectors(part)


class _Sectors:
    def __init__(self, part: Superelement) -> None:
        sector = Sector(part, sectors_of(part), modes=KEPT, loads=2 * KEPT, rigid=False)
        self._waves = {k: sector.wave(k) for k in WAVES}

    def modes(self, k: int, loads: ComplexArray) -> ComplexArray:
        """Return the lowest modes, whether loads drive them or not."""
        wave = self._waves[k]
        return np.asarray(wave.tie @ wave.lowest(min(KEPT, wave.size))[1], np.complex128)

    def solve(self, k: int, loads: ComplexArray) -> ComplexArray:
        wave = self._waves[k]
        forces = wave.tie.conj().T @ loads
        if wave.kind is float:
            forces = np.ascontiguousarray(forces.real)
        return np.asarray(wave.tie @ wave.shifted_solution(forces), np.complex128)


class _Fields:
    """A wheel whose fields of each nodal diameter are known."""

    def __init__(self, part: Superelement, bases: Mapping[int, Any]) -> None:
        self._bases = bases
        self._forms = {
            k: [(basis.conj().T @ (form @ basis)).toarray() for form in (part.stiffness, part.mass)]
            for k, basis in bases.items()
        }

    def modes(self, k: int, loads: ComplexArray) -> ComplexArray:
        """Return the lowest modes, whether loads drive them or not."""
        stiffness, mass = self._forms[k]
        last = min(KEPT, len(mass)) - 1
        return np.asarray(self._bases[k] @ la.eigh(stiffness, mass, subset_by_index=[0, last])[1])

    def solve(self, k: int, loads: ComplexArray) -> ComplexArray:
        basis = self._bases[k]
        within = la.solve(self._forms[k][0], basis.conj().T @ loads, assume_a="pos")
        return np.asarray(basis @ within)


class _Wheel:
    def __init__(self, part: Superelement) -> None:
        self._factor = Cholesky.of(sp.csr_array(part.stiffness))
        if part.size <= ALL:
            self._modes = la.eigh(dense(part.stiffness), dense(part.mass))
        else:
            self._modes = lowest_modes(part, LOWEST)

    def modes(self, k: int, loads: ComplexArray) -> ComplexArray:
        """Return the lowest modes that loads drive: of modes of equal frequency the combinations
        that the loads of a wave select."""
        squares, shapes = self._modes
        starts = np.flatnonzero(np.diff(squares) > EQUAL * squares[1:]) + 1
        size, found = la.norm(loads, axis=0), []
        for modes in np.split(np.arange(len(squares)), starts):
            ways, strength, _ = la.svd(shapes[:, modes].T @ loads / size, full_matrices=False)
            own = strength > DRIVEN * la.norm(shapes[:, modes])
            found.append(shapes[:, modes] @ ways[:, own])
        return np.hstack(found)[:, :KEPT]

    def solve(self, k: int, loads: ComplexArray) -> ComplexArray:
        real, imaginary = np.hsplit(self._factor.solve(np.hstack([loads.real, loads.imag])), 2)
        return np.asarray(real + 1j * imaginary)
