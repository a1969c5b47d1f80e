"""External superelements of Nastran: .op4 with .asm and .pch, read by pyyeti.

Nastran writes them for EXTSEOUT(ASMBULK,EXTBULK,EXTID=102,MATOP4=102). The matrices are those of a
Craig-Bampton reduction. Coordinates are the displacements of the boundary nodes, in the axes of
each node, and the amplitudes of modes, which Nastran calls scalar points.
"""

from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.models.imports.parts import ForeignPart
from bladewhirl.models.superelements.containers import checked_matrix, read_foreign
from bladewhirl.models.superelements.superelement import FIXED, SuperelementError, dense, errors_of

STIFFNESS, MASS, DAMPING = ("kaa", "kxx"), ("maa", "mxx"), ("baa", "bxx")
"""Names of the matrices in files of different versions."""


def read_nastran(path: Path) -> ForeignPart:
    """Read an external superelement, and turn its displacements into the basic axes.

    Raises:
        SuperelementError: pyyeti is not installed, or the files are missing or invalid.
    """
    try:
        from pyyeti import nastran
        from pyyeti.nastran import op4
    except ImportError:
        raise SuperelementError(
            f"{path}: expected pyyeti, which reads .op4 files: pip install 'bladewhirl[nastran]'"
        ) from None
    table = path.with_suffix(".asm")
    if not (path.is_file() and table.is_file()):
        missing = table if path.is_file() else path
        raise SuperelementError(f"{path}: expected {missing.name} in the same folder")
    kind = "a file of Nastran"
    matrices = read_foreign(path, kind, lambda: op4.read(str(path)))
    uset, _, _, kept = read_foreign(
        table, kind, lambda: nastran.asm2uset(str(table), try_rdextrn="pv_only")
    )
    rigid = read_foreign(table, kind, lambda: nastran.rbgeom_uset(uset))
    size = int(np.count_nonzero(kept))
    with errors_of(path):
        mass, stiffness, damping = (
            _named(matrices, names, size) for names in (MASS, STIFFNESS, DAMPING)
        )
    if mass is None or stiffness is None:
        names = " and ".join(" or ".join(names) for names in (STIFFNESS, MASS))
        raise SuperelementError(
            f"{path}: expected {names} with {size} rows, as many as {table.name} has displacements"
            " and modes"
        )
    nodes = uset.index.get_level_values("id").to_numpy()
    direction = uset.index.get_level_values("dof").to_numpy()
    first = np.flatnonzero(direction == 1)
    turned, dofs = _basic_axes(first, kept, rigid[:, :3], nodes, table)
    return ForeignPart(
        source=f"{path.name} of Nastran",
        mass=turned.T @ mass @ turned,
        stiffness=turned.T @ stiffness @ turned,
        damping=None if damping is None else turned.T @ damping @ turned,
        numbers=nodes[first],
        points=uset.loc[:, ["x", "y", "z"]].to_numpy(dtype=np.float64)[first],
        dofs=dofs,
    )


def _named(matrices: Any, names: tuple[str, ...], size: int) -> Any:
    """Return the first matrix that has one of the names and the size; None if there is none."""
    given = (name for name in names if name in matrices and matrices[name].shape == (size, size))
    return next((dense(checked_matrix(name, matrices[name])) for name in given), None)


def _basic_axes(first: Any, kept: Any, rigid: Any, nodes: Any, table: Path) -> tuple[Any, Any]:
    """Return the matrix from coordinates in the basic axes to those of Nastran, (n, n), and for
    each node the rows of its x, y and z displacements in the matrices, (nodes, 3).

    Args:
        first: row of the first displacement of each node among all rows, (nodes,).
        kept: true for the rows that the matrices contain.
        rigid: displacements in all rows under unit translations along x, y and z.
        nodes: number of the node of each row.
        table: path of the file, for messages.
    """
    place = np.where(kept, np.cumsum(kept) - 1, FIXED)
    turned = sp.lil_array(sp.eye_array(int(kept.sum())))
    dofs = place[first[:, None] + np.arange(3)]
    for rows, axes in zip(dofs, rigid[first[:, None] + np.arange(3)], strict=True):
        if np.allclose(axes, np.eye(3), atol=1e-12):
            continue
        if (rows == FIXED).any():
            node = nodes[first[int(np.flatnonzero((dofs == rows).all(axis=1))[0])]]
            raise SuperelementError(
                f"{table}: expected all three displacements of node {node}, which has axes of its"
                " own"
            )
        turned[np.ix_(rows, rows)] = axes
    return turned.tocsr(), dofs
