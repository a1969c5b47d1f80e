"""Matrices of the bladed disk reduced to its tips, its centre and fixed-interface modes.

The equation of motion in rotating axes is M q'' + D q' + K q = f. With rotation effects K is the
stiffness at speed; Coriolis forces add the term G q'. The reduced basis is computed with the
stiffness at speed. With Coriolis forces, the first N frequencies of Table 1 then differ from the
full model by at most 6e-5 at the speed 1.05 and 4e-4 at 2.5; with a reduced basis from the
stiffness at rest the differences are 1e-4 and 1.2e-3.

Time integration uses the modes of these matrices. The matrices themselves, with named degrees of
freedom, are for users who write their own solvers, observers or controllers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.modal.reduction import ReducedModes, craig_bampton_basis
from bladewhirl.models.structure.eigenproblems import gyroscopic_frequencies, modal_damping

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, kw_only=True, repr=False)
class ReducedDisk:
    """Craig-Bampton model of a bladed disk with named coordinates.

    The coordinates q are displacements [m] of tips and centre, and amplitudes [kg^1/2 m] of
    mass-normalised fixed-interface modes. The stiffness includes the shaft springs. Unequal springs
    in the static frame are included with the mean of both stiffnesses.
    """

    names: tuple[str, ...]
    """Names of the coordinates: "tip 3 radial", "centre x", "fixed-interface 12", (size,)."""
    mass: FloatArray  #: mass matrix, (size, size); entries of displacements in kg
    stiffness: FloatArray  #: stiffness matrix, (size, size); of displacements in N/m
    damping: FloatArray
    """Damping matrix of modal damping and shaft dampers, (size, size); entries of displacements in
    N s/m. With Coriolis forces, the modal damping belongs to the modes at rest; it rotates
    with the disk and can destabilise waves above their critical speed."""
    gyroscopic: FloatArray | None
    """Skew matrix of the Coriolis forces, (size, size); entries of displacements in N s/m. None
    without Coriolis forces."""
    basis: FloatArray
    """Matrix from the coordinates to the free DoF of the finite element model, (free DoF, size).
    """
    disk: BladedDiskModel  #: finite element model

    def __repr__(self) -> str:
        """Return the number of coordinates of each kind."""
        kinds: dict[str, int] = {}
        for name in self.names:
            kind = name.split()[0]
            kinds[kind] = kinds.get(kind, 0) + 1
        listed = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        return f"ReducedDisk: {len(self.names)} coordinates ({listed}) of {len(self.basis)}"

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies, with Coriolis forces those of travelling waves, ascending [rad/s],
        (size,)."""
        if self.gyroscopic is not None:
            w = gyroscopic_frequencies(self.mass, self.stiffness, self.gyroscopic)
            return np.sort(np.abs(w.real))[::2]  # each occurs with both signs
        squares = la.eigvalsh(self.stiffness, self.mass)
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)))

    def position(self, name: str) -> int:
        """Return the position of the coordinate with a name.

        Raises:
            ValueError: there is no such coordinate.
        """
        return self.names.index(name)

    def expand(self, coordinates: FloatArray) -> FloatArray:
        """Return x and y displacements [m] and rotation [rad] of every node in rotating axes.

        Args:
            coordinates: columns of coordinates q, (size, m).

        Returns:
            motion of the nodes in the order of `disk.mesh.points`, (nodes, 3, m).
        """
        return self.disk.cartesian(self.basis @ coordinates)

    def to_xarray(self) -> xr.Dataset:
        """Return all matrices as a dataset with the names of the coordinates along `row` and
        `column`."""
        import xarray as xr

        matrices = {"mass": "kg", "stiffness": "N/m", "damping": "N s/m"}
        if self.gyroscopic is not None:
            matrices["gyroscopic"] = "N s/m"
        return xr.Dataset(
            {
                name: (
                    ("row", "column"),
                    getattr(self, name),
                    {"units": unit, "long_name": f"{name} matrix, units among displacements"},
                )
                for name, unit in matrices.items()
            },
            coords={"row": list(self.names), "column": list(self.names)},
            attrs={"title": "Craig-Bampton model of the bladed disk, rotating axes"},
        )


def reduced_disk(
    case: Case, disk: BladedDiskModel, reduction: ReducedModes, sets: dict[str, IntArray]
) -> ReducedDisk:
    """Return the matrices of a reduced bladed disk.

    Args:
        case: case with the damping.
        disk: finite element model.
        reduction: reduction with the boundary and the number of fixed-interface modes.
        sets: boundary DoF by name from `boundary_sets`, in the order of `reduction.boundary`.
    """
    structure, boundary = disk.structure, reduction.boundary
    basis = craig_bampton_basis(structure, boundary, reduction.kept)
    small = structure.projected(basis, ("mass", "stiffness", "gyroscopic"))
    mass, gyroscopic, damped = small["mass"], None, small["stiffness"]
    if structure.gyroscopic is not None:
        gyroscopic = disk.speed * small["gyroscopic"]
        damped = structure.still.projected(basis, ("stiffness",))["stiffness"]
    damping = modal_damping(mass, damped, case.damping.ratio).real
    blades, free = len(disk.tip_radial), len(sets["centre"])
    centre = 2 * blades + np.arange(free)
    damping[centre, centre] += np.array(case.shaft.dampings)[:free]
    return ReducedDisk(
        names=(
            *(f"tip {blade} radial" for blade in range(blades)),
            *(f"tip {blade} tangential" for blade in range(blades)),
            *("centre x", "centre y")[:free],
            *(f"fixed-interface {mode}" for mode in range(reduction.kept)),
        ),
        mass=mass,
        stiffness=small["stiffness"],
        damping=damping,
        gyroscopic=gyroscopic,
        basis=basis,
        disk=disk,
    )
