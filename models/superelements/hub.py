"""The hub of a wheel that moves and tilts with a shaft.

Nodes of the bore or of a flange are tied to six displacements of the hub: those along x, y and z,
and the rotations about x, y and z. A node at X from the hub moves by

    u = d + phi x X + phi x (phi x X) / 2

up to the second order of the rotations phi. The second order counts at speed: the reaction r that
holds a node against the centrifugal forces does work on it, so that the change of the stiffness by
rotation has for each node the matrix of the tie (X r^T + r X^T) / 2 - (r . X) 1 on phi. Without it
the tilt of a free wheel would grow.

A wheel moves as a rigid body under static displacements of its hub. Its matrices on these six
motions are those of a rigid body, which `check_hub` compares:

    G = 2 sum m N^T (z x N),        K1 = -sum m (N^T P N + second order of P X),

with u = N q for the hub q, and the projection P onto the plane of rotation. About the centre of
mass of a wheel they are 2 m and 2 I_t - I_p, and diag(-m, -m, 0, I_p - I_t, I_p - I_t, 0).
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.superelements.cholesky import Cholesky
from bladewhirl.models.superelements.sector import Sector
from bladewhirl.models.superelements.superelement import (
    FIXED,
    HUB,
    IndefiniteError,
    Superelement,
    SuperelementError,
    diagonal,
)

WAVES: dict[int, ComplexArray] = {
    0: np.array([[0, 0, 1, 0, 0, 0], [0, 0, 0, 0, 0, 1]], dtype=np.complex128).T,
    1: np.array([[1, 1j, 0, 0, 0, 0], [0, 0, 0, -1j, 1, 0]], dtype=np.complex128).T,
}
"""Displacements of the hub, (6, 2), in the waves of nodal diameter 0 and 1 of `cyclic`: along z and
about z; and those of the axis and of its slopes, u_x - i u_y and p_x - i p_y with p_x = phi_y and
p_y = -phi_x."""

NEEDED = ("gyroscopic", "stiffness_speed")  #: matrices of a wheel that turns with a shaft line

FEWEST = 3  #: fewest sectors, in whose waves of nodal diameter 1 a hub moves

TOLERANCE = 1e-6
"""Largest difference from a rigid body, as a fraction of its largest entry."""

HELD = Fault(expected="a wheel that a fixed hub holds, and a stiffness that is not indefinite")

SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  #: matrix of z x
IN_PLANE = np.diag([1.0, 1.0, 0.0])


def tied_rows(arm: FloatArray) -> FloatArray:
    """Return the displacements of tied nodes at positions from the hub [m], (n, 3), for those of
    the hub, (3n, 6)."""
    turned = np.cross(np.eye(3)[:, None], arm).reshape(3, -1)
    return np.hstack([np.tile(np.eye(3), (len(arm), 1)), turned.T])


def tie_stiffness(reaction: FloatArray, arm: FloatArray) -> FloatArray:
    """Return the matrix of the tie at 1 rad/s, (6, 6), from the forces that hold the tied nodes
    against the centrifugal forces [kg m], (n, 3), and their positions from the hub [m]."""
    product = reaction.T @ arm
    tie = np.zeros((HUB, HUB))
    tie[3:, 3:] = 0.5 * (product + product.T) - np.trace(product) * np.eye(3)
    return tie


def hub_freed(part: Superelement, free: tuple[int, ...] = ()) -> Superelement:
    """Return a wheel or sector of whose hub only some displacements remain, by their numbers; x and
    y remain as `centre_dofs`. Other superelements are returned as they are."""
    if part.hub_dofs is None:
        return part
    kept = np.setdiff1d(np.arange(part.size), np.delete(part.hub_dofs, list(free)))
    place = np.full(part.size + 1, FIXED)  # the last entry is that of a fixed component
    place[kept] = np.arange(len(kept))
    select = sp.csr_array(sp.eye_array(part.size))[:, kept]
    names = ("contact_dofs", "left_dofs", "right_dofs")
    dofs: dict[str, Any] = {name: place[one] for name, one in part.given(names).items()}
    dofs["centre_dofs"] = place[part.hub_dofs[:2]] if free else None
    return replace(part, **part.projected(select), **dofs, hub_dofs=None, hub_position=None)


def in_whole(part: Superelement, number: IntArray, size: int) -> Superelement:
    """Return a superelement with the coordinates of a larger one; others have no mass and no
    stiffness.

    Args:
        part: superelement.
        number: number of each of its coordinates in the larger one, (n,).
        size: number of coordinates of the larger one.
    """
    if size == part.size:
        return part
    entries = np.ones(part.size), (np.arange(part.size), number)
    every = np.append(number, FIXED)  # the last entry is that of a fixed component
    names = ("contact_dofs", "hub_dofs", "centre_dofs", "left_dofs", "right_dofs")
    return replace(
        part,
        **part.projected(sp.csr_array(entries, shape=(part.size, size))),
        **{name: every[one] for name, one in part.given(names).items()},
    )


def remaining_dofs(part: Superelement) -> IntArray:
    """Return the coordinates of a superelement that have mass or stiffness, ascending."""
    return np.flatnonzero((diagonal(part.mass) > 0.0) | (diagonal(part.stiffness) > 0.0))


def without_tilt(part: Superelement) -> Superelement:
    """Return a wheel whose hub moves along x and y only, or a sector whose hub is held."""
    return hub_freed(part, () if part.left_dofs is not None else (0, 1))


def inner_dofs(part: Superelement) -> IntArray:
    """Return the coordinates that are not those of the hub, ascending."""
    return np.setdiff1d(np.arange(part.size), hub_of(part))


def hub_of(part: Superelement) -> IntArray:
    """Return the coordinates of the hub, (6,).

    Raises:
        SuperelementError: the superelement has no hub.
    """
    if part.hub_dofs is None:
        raise SuperelementError(
            f"{part.name}: expected hub_dofs, the six displacements of the hub: mesh3d --hub ties"
            " the nodes of the bore to them"
        )
    return part.hub_dofs


def sectors_of(part: Superelement) -> int:
    """Return the number of sectors of a sector with a hub; 1 for a wheel.

    Raises:
        SuperelementError: the number is unknown or below `FEWEST`.
    """
    if part.left_dofs is None:
        return 1
    if part.sectors is None or part.sectors < FEWEST:
        raise SuperelementError(
            f"{part.name}: sectors: expected at least {FEWEST} with hub_dofs, got {part.sectors}"
        )
    return part.sectors


def rigid_motions(part: Superelement) -> FloatArray:
    """Return the static displacements of a wheel, or of its first sector, under unit displacements
    of its hub, (n, 6).

    Raises:
        SuperelementError: a fixed hub does not hold the wheel.
    """
    hub, inner, held = hub_of(part), inner_dofs(part), hub_freed(part)
    motions = np.zeros((part.size, HUB))
    motions[hub] = np.eye(HUB)
    loads = -(sp.csr_array(part.stiffness) @ motions)[inner]
    if part.left_dofs is None:
        motions[inner] = _static(held, loads)
        return motions
    axial, whirling = (_static(held, loads @ WAVES[k], sectors_of(part), k) for k in WAVES)
    (of_z, about_z), (of_x, about_y) = axial.T, whirling.T
    columns = [of_x.real, of_x.imag, of_z.real, -about_y.imag, about_y.real, about_z.real]
    motions[inner] = np.stack(columns, axis=1)
    return motions


def _static(held: Superelement, loads: Any, sectors: int = 1, k: int = 0) -> Any:
    """Return the static displacements of a wheel, or of the first of its sectors, without its hub
    under loads with a nodal diameter, (n, loads).

    Raises:
        SuperelementError: the wheel is not held.
    """
    try:
        if held.left_dofs is None:
            return Cholesky.of(sp.csr_array(held.stiffness)).solve(loads)
        wave = Sector(held, sectors, modes=0, loads=loads.shape[1], rigid=False).wave(k)
        forces = wave.tie.conj().T @ (loads.real if wave.kind is float else loads)
        return wave.tie @ wave.shifted_solution(forces)
    except la.LinAlgError:
        raise IndefiniteError(HELD) from None


def tied_to_hub(
    part: Superelement, dofs: IntArray, arm: FloatArray, position: FloatArray, place: FloatArray
) -> Superelement:
    """Return a superelement with nodes tied to a hub; `stiffness_speed` gets the matrix of the tie.

    Args:
        part: free superelement; `stiffness_speed` is that with the tied nodes fixed.
        dofs: numbers of the x, y and z displacements of the nodes, (nodes, 3).
        arm: their positions from the hub [m], (nodes, 3).
        position: position of the hub [m], (3,).
        place: distances x and y from the axis at the coordinates that are displacements along x and
            y, and 0 at others [m], (n,).

    Raises:
        SuperelementError: a displacement of a node is fixed, or the hub does not hold the wheel.
    """
    if (dofs == FIXED).any():
        raise SuperelementError("hub: expected nodes whose displacements are all in the matrices")
    every, tied = sp.csr_array(sp.eye_array(part.size)), dofs.ravel()
    kept = np.setdiff1d(np.arange(part.size), tied)
    basis = sp.csr_array(sp.hstack([every[:, kept], every[:, tied] @ tied_rows(arm)]))
    number = np.full(part.size + 1, FIXED)  # the last entry is that of a fixed component
    number[kept] = np.arange(len(kept))
    names = ("contact_dofs", "left_dofs", "right_dofs")
    hub = len(kept) + np.arange(HUB)
    made = replace(
        part,
        **part.projected(basis),
        **{name: number[one] for name, one in part.given(names).items()},
        hub_dofs=hub,
        hub_position=position,
    )
    if made.stiffness_speed is None:
        return made
    load, held = part.mass @ place, hub_freed(made)
    moved = np.zeros(part.size)
    moved[kept] = _static(held, load[kept, None], part.sectors or 1)[:, 0].real
    reaction = (part.stiffness @ moved - load)[tied].reshape(-1, 3)
    return replace(made, **with_tie(made, reaction, arm))


def with_tie(part: Superelement, reaction: FloatArray, arm: FloatArray) -> dict[str, sp.csr_array]:
    """Return `stiffness_speed` of a superelement with the matrix of the tie, by name; see
    `tie_stiffness`."""
    of_hub = sp.csr_array(sp.eye_array(part.size))[:, hub_of(part)]
    tie = of_hub @ sp.csr_array(tie_stiffness(reaction, arm)) @ of_hub.T
    return {"stiffness_speed": sp.csr_array(part.stiffness_speed + tie)}


def of_all_sectors(form: FloatArray, sectors: int) -> FloatArray:
    """Return the sum over all sectors of a matrix of the hub of the first one, (6, 6)."""
    whole = np.zeros((HUB, HUB))
    for angle in 2.0 * np.pi / sectors * np.arange(sectors):
        turn = np.eye(3) + np.sin(angle) * SPIN + (np.cos(angle) - 1.0) * IN_PLANE
        both = la.block_diag(turn, turn)
        whole += both @ form @ both.T
    return whole


def check_hub(part: Superelement, motions: FloatArray) -> None:
    """Check that the matrices of a wheel, or of its first sector, move rigidly with the hub.

    Args:
        part: superelement with hub_dofs.
        motions: its rigid motions, (n, 6).

    Raises:
        SuperelementError: a matrix has not that of a rigid body on them.
    """
    faults = list(_hub_faults(part, motions))
    if faults:
        raise SuperelementError(*faults)


def _hub_faults(part: Superelement, motions: FloatArray) -> Iterator[str]:
    sectors = sectors_of(part)
    forms = {
        name: of_all_sectors(np.asarray(motions.T @ (matrix @ motions)), sectors)
        for name, matrix in part.given(("mass", "gyroscopic", "stiffness_speed")).items()
    }
    stiffness = sp.csr_array(part.stiffness)
    strained = motions.T @ (stiffness @ motions)
    scale = np.sqrt(np.diag(abs(motions).T @ (abs(stiffness) @ abs(motions))))
    if (abs(strained) > TOLERANCE * np.outer(scale, scale)).any():
        yield "stiffness: expected no force on the hub where the wheel moves rigidly with it"
        return
    mass = forms["mass"]
    total, polar = float(mass[0, 0]), float(mass[5, 5])
    unit = np.append(np.ones(3), np.full(3, np.sqrt(total / max(polar, 1e-300))))
    unit = np.outer(unit, unit)
    if not _alike(mass[:3, :3] * unit[:3, :3], total * np.eye(3), total):
        values = ", ".join(f"{value:.6g}" for value in np.diag(mass)[:3])
        yield f"mass: expected that of a rigid wheel along x, y and z, got {values} kg"
        return
    for name, expected in rigid_body(mass).items():
        if name in forms and not _alike(forms[name] * unit, expected * unit, total):
            text = "that of a rigid wheel on motions with the hub"
            if name == "stiffness_speed":
                tilt, own = expected[3, 3], forms[name][3, 3]
                text += (
                    f", whose tilt has I_p - I_t = {tilt:.6g} kg m2, got {own:.6g}: is the matrix"
                    " of the tie missing, by which the reaction of the bore resists the tilt?"
                )
            else:
                text += ", 2 M J with the tie to the hub"
            yield f"{name}: expected {text}"


def _alike(form: FloatArray, expected: FloatArray, scale: float) -> bool:
    return bool((abs(form - expected) <= TOLERANCE * scale).all())


def rigid_body(mass: FloatArray) -> dict[str, FloatArray]:
    """Return `gyroscopic` and `stiffness_speed` of the rigid body with a mass matrix of the hub,
    (6, 6)."""
    total, first = mass[0, 0], mass[3:, :3]  # the matrix of (sum m X) x
    inertia = mass[3:, 3:]
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia  # sum m X X^T
    place = np.array([first[2, 1], first[0, 2], first[1, 0]])
    across = place[2] * np.eye(3)
    across[:, 2] -= place
    about_z = np.cross(np.eye(3), second[:, 2])
    spin = SPIN @ second @ SPIN.T
    both = 0.5 * (second @ IN_PLANE + IN_PLANE @ second)
    tilt = second[2, 2] * np.eye(3) - second - spin + both
    coupled = -IN_PLANE @ first
    return {
        "gyroscopic": 2.0 * np.block([[total * SPIN, across], [-across.T, about_z]]),
        "stiffness_speed": -np.block([[total * IN_PLANE, coupled], [coupled.T, tilt]]),
    }
