"""The bladed disk reduced to its tips, its centre and fixed-interface modes, as plain matrices.

M q'' + D q' + K q = f in rotating axes; with rotation effects K is that at speed, and Coriolis
forces G q' may join. The basis is found with the stiffness at speed: with Coriolis forces the
first N frequencies of Table 1 are then within 6e-5 of the full model's at 1.05 and 4e-4
at 2.5; on the basis at rest they are within 1e-4 and 1.2e-3.

The march has the modes of these matrices; whoever builds a solver, an observer or a circuit of
their own wants the matrices, and degrees of freedom by name.
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
from bladewhirl.models.rotation.eigenproblems import gyroscopic_frequencies, modal_damping

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, kw_only=True, repr=False)
class ReducedDisk:
    """Craig-Bampton model of a bladed disk: displacements of tips and centre, modes inside.

    The coordinates q are displacements [m] of the boundary and amplitudes [kg^1/2 m] of
    mass-normalised fixed-interface modes. Shaft springs are in the stiffness; of springs that stand
    still and differ, their mean is.
    """

    names: tuple[str, ...]  #: "tip 3 radial", "centre x", "fixed-interface 12", (size,)
    mass: FloatArray  #: [kg] among displacements, (size, size)
    stiffness: FloatArray  #: [N/m] among displacements, (size, size)
    damping: FloatArray
    """Modal damping and the shaft's dampers [N s/m], (size, size). With Coriolis forces it is that
    of the modes at rest; it turns with the disk and can feed waves past their critical speed."""
    gyroscopic: FloatArray | None
    """Coriolis forces by velocity, skew [N s/m], (size, size); None where they don't count."""
    basis: FloatArray  #: free degrees of freedom of the finite element model, (full size, size)
    disk: BladedDiskModel  #: the finite element model

    def __repr__(self) -> str:
        """Numbers of coordinates."""
        kinds: dict[str, int] = {}
        for name in self.names:
            kind = name.split()[0]
            kinds[kind] = kinds.get(kind, 0) + 1
        listed = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        return f"ReducedDisk: {len(self.names)} coordinates ({listed}) of {len(self.basis)}"

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies [rad/s], ascending, of waves where Coriolis forces count, (size,)."""
        if self.gyroscopic is not None:
            w = gyroscopic_frequencies(self.mass, self.stiffness, self.gyroscopic)
            return np.sort(np.abs(w.real))[::2]  # each is there with both signs
        squares = la.eigvalsh(self.stiffness, self.mass)
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)))

    def position(self, name: str) -> int:
        """Position of a coordinate.

        Raises:
            ValueError: there is no such coordinate.
        """
        return self.names.index(name)

    def expand(self, coordinates: FloatArray) -> FloatArray:
        """Displacements x, y [m] and rotation [rad] of every node, (nodes, 3, m), rotating axes.

        Args:
            coordinates: q, (size, m); a node is a row of `disk.mesh.points`.
        """
        return self.disk.cartesian(self.basis @ coordinates)

    def to_xarray(self) -> xr.Dataset:
        """Mass, stiffness and damping over the names of the coordinates, `row` and `column`."""
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
    """Matrices of a reduced bladed disk.

    Args:
        case: for its damping.
        disk: finite element model.
        reduction: which coordinates are kept.
        sets: the boundary, as `boundary_sets` names it, in the order of `reduction.boundary`.
    """
    structure, boundary = disk.structure, reduction.boundary
    basis = craig_bampton_basis(structure, boundary, reduction.kept)
    mass = basis.T @ (structure.mass @ basis)
    stiffness = basis.T @ (structure.stiffness @ basis)
    mass, stiffness = 0.5 * (mass + mass.T), 0.5 * (stiffness + stiffness.T)
    gyroscopic, damped = None, stiffness
    if structure.gyroscopic is not None:
        gyroscopic = basis.T @ (structure.gyroscopic @ basis)
        gyroscopic = 0.5 * (gyroscopic - gyroscopic.T)
        damped = basis.T @ (structure.elastic @ basis)
        damped = 0.5 * (damped + damped.T)
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
        stiffness=stiffness,
        damping=damping,
        gyroscopic=gyroscopic,
        basis=basis,
        disk=disk,
    )
