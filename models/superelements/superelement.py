"""A superelement: the matrices of a blade, a sector or a wheel, with its contact nodes."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.fields import SMALLEST
from bladewhirl.models.inputs.plausible import fault_of
from bladewhirl.models.structure.rotating import Rotating

Matrix: TypeAlias = FloatArray | sp.csr_array
"""A dense or a sparse matrix."""

SYMMETRIC = 1e-8
"""A matrix is symmetric if it differs from its transpose by at most this fraction of its largest
entry."""

RADII = (1e-3, 20.0)
"""Smallest and largest plausible radius of the outermost contact node [m]."""

HUB = 6  #: displacements of a hub: along x, y and z, and rotations about x, y and z

ON_AXIS = 1e-9
"""Largest distance of a hub from the axis, as a fraction of the largest radius of a contact node.
"""

FIXED = -1
"""Number in place of a degree of freedom that does not exist because its displacement is zero."""


class SuperelementError(UserError):
    """Error in a superelement; each argument is a fault in one line."""


class IndefiniteError(SuperelementError):
    """The stiffness is not positive definite, at rest or at a speed."""


@contextmanager
def errors_of(source: object) -> Iterator[None]:
    """Add the name of a file or a program to each line of the errors raised in this context."""
    try:
        yield
    except UserError as error:
        raise SuperelementError(*(f"{source}: {line}" for line in error.lines)) from None


COMPONENTS = 6  #: components xx, yy, zz, xy, yz and zx of a stress

ARRAYS = (
    "contact_position",
    "hub_position",
    "points",
    "young_modulus",
    "poisson_ratio",
    *Rotating.LOADS,
)
"""Names of the arrays of numbers."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Superelement(Rotating[Matrix]):
    """Matrices of a blade clamped at its root, of a sector or of a wheel.

    Coordinates that are not displacements of nodes are amplitudes of modes. A file with
    stiffness_speed has the speed 0.

    Raises:
        SuperelementError: the arrays do not describe a structure; the error lists all faults.
    """

    FORMS: ClassVar[tuple[str, ...]] = (*Rotating.FORMS, "blade_stiffness")
    ROWS: ClassVar[tuple[str, ...]] = ("recovery", "strain_recovery", "stress_recovery")

    contact_position: FloatArray  #: undeformed positions of contact nodes [m], (c, 3)
    contact_dofs: IntArray
    """Numbers of the x, y and z displacement of each contact node, (c, 3); -1 for a component that
    is always zero."""
    blade_stiffness: Matrix | None = None
    """Part of the stiffness that the blade of a sector, or the blades of a wheel, have at rest
    [N/m], (n, n), symmetric. The mistuning of a case changes it."""
    centre_dofs: IntArray | None = None
    """Numbers of the x and y displacement of the centre of a wheel, (2,)."""
    hub_dofs: IntArray | None = None
    """Numbers of the displacements along x, y and z and of the rotations about x, y and z of the
    hub, (6,), to which nodes of a wheel or sector are tied, see `hub`; in place of centre_dofs."""
    hub_position: FloatArray | None = None  #: position of the hub on the axis [m], (3,)
    points: FloatArray | None = None  #: undeformed points for pictures [m], (p, 3)
    recovery: Matrix | None = None
    """Matrix from the coordinates to the x, y and z displacements of the points, (3p, n)."""
    triangles: IntArray | None = None  #: points of each surface triangle, (t, 3)
    strain_recovery: Matrix | None = None
    """Matrix from the coordinates to the strains of gauges [1/m], (gauges, n), listed blade by
    blade."""
    stress_recovery: Matrix | None = None
    """Matrix from the coordinates to the stress at the points [Pa/m], (6p, n): components xx, yy,
    zz, xy, yz and zx of each point in the axes of the file."""
    young_modulus: FloatArray | None = None
    """Young's modulus at each point [Pa], (p,), for strain gauges; with stress_recovery."""
    poisson_ratio: FloatArray | None = None  #: Poisson's ratio at each point, (p,)
    left_dofs: IntArray | None = None
    """Numbers of the x, y and z displacements of the nodes on the clockwise face of a sector,
    (l, 3)."""
    right_dofs: IntArray | None = None
    """Numbers of the x, y and z displacements of the matching nodes on the counter-clockwise face,
    which is the clockwise face turned by one pitch, (l, 3)."""
    joint_left: IntArray | None = None
    """Contact nodes on the clockwise side of a blade that touch the next blade, (j,)."""
    joint_right: IntArray | None = None
    """Contact nodes on the counter-clockwise side, each of which touches the node of joint_left at
    the same position on the next blade, (j,)."""
    sectors: int | None = None
    """Number of sectors of the wheel with left_dofs, or of blades of a wheel in one piece, if it is
    known."""
    name: str = "superelement"  #: name, free text
    source: str = ""  #: origin of the matrices, free text
    mesh_axis: str = "z"  #: axis of rotation of the mesh of which it was made
    group_places: str = ""
    """For each group of nodes of this mesh the position of the node nearest to their mean [m], x, y
    and z in the axes of the file, by its name, as JSON."""
    command: str = ""  #: command that made the file
    whole_mass: float | None = None  #: mass with that of clamped nodes [kg], if it is known

    def __post_init__(self) -> None:
        faults = list(_faults(self))
        if faults:
            raise SuperelementError(*faults)

    def __repr__(self) -> str:
        """Return the name, and the numbers of coordinates, contact nodes and points."""
        return (
            f'Superelement "{self.name}": {self.size} coordinates, {self.contacts} contact nodes,'
            f" {self.point_count} points"
        )

    @property
    def groups(self) -> dict[str, list[float]]:
        """Positions of `group_places` by the name of the group."""
        return dict(json.loads(self.group_places or "{}"))

    @property
    def softening(self) -> float:
        """Stiffness plus this number times mass is positive definite [rad2/s2]: the square of the
        speed of a wheel that rotates, whose stiffness is indefinite above its first critical
        speed."""
        rotates = self.centre_dofs is not None and self.stiffness_speed is not None
        return (self.speed or 0.0) ** 2 if rotates else 0.0

    @property
    def contacts(self) -> int:
        """Number of contact nodes."""
        return len(self.contact_position)

    @property
    def point_count(self) -> int:
        """Number of points for pictures."""
        return 0 if self.points is None else len(self.points)

    @property
    def contact_radius(self) -> FloatArray:
        """Radius of each contact node [m], (c,)."""
        return np.asarray(np.hypot(self.contact_position[:, 0], self.contact_position[:, 1]))

    @property
    def contact_angle(self) -> FloatArray:
        """Angle of each contact node from +x [rad], (c,)."""
        return np.asarray(np.arctan2(self.contact_position[:, 1], self.contact_position[:, 0]))

    @property
    def contact_rows(self) -> sp.csr_array:
        """Matrix from the coordinates to the radial, tangential and axial displacements of the
        contact nodes, (3c, n); the first three rows belong to node 0."""
        c, s = np.cos(self.contact_angle), np.sin(self.contact_angle)
        rows, columns, values = [], [], []
        for node, (x, y, z) in enumerate(self.contact_dofs.tolist()):
            for row, column, value in (
                *((0, x, c[node]), (0, y, s[node])),
                *((1, x, -s[node]), (1, y, c[node])),
                (2, z, 1.0),
            ):
                if column != FIXED:
                    rows.append(3 * node + row)
                    columns.append(column)
                    values.append(value)
        shape = (3 * self.contacts, self.size)
        return sp.csr_array((values, (rows, columns)), shape=shape)


def _faults(part: Superelement) -> Iterator[str]:
    """Yield the faults of the arrays of a superelement, each as "KEY: expected ..."."""
    n = part.size
    for key in (*part.FORMS, *part.ROWS, *ARRAYS):
        given = getattr(part, key)
        if given is not None and not np.isfinite(given.data if sp.issparse(given) else given).all():
            yield f"{key}: expected finite numbers"
            return
    for key, matrix in part.given(part.FORMS).items():
        if matrix.ndim != 2 or matrix.shape != (n, n) or n == 0:
            yield f"{key}: expected a square matrix of the size of mass, got {_shape(matrix)}"
            return
        values = matrix.data if sp.issparse(matrix) else matrix
        sign, word = (1.0, "skew") if key == "gyroscopic" else (-1.0, "symmetric")
        largest = abs(values).max() if values.size else 0.0
        if abs(matrix + sign * matrix.T).max() > SYMMETRIC * largest:
            yield f"{key}: expected a {word} matrix"
        if key in ("mass", "stiffness", "damping", "blade_stiffness") and np.any(
            diagonal(matrix) < 0.0
        ):
            yield f"{key}: expected no negative numbers on the diagonal"
    if part.mesh_axis not in ("x", "y", "z"):
        yield f"mesh_axis: expected x, y or z, got {part.mesh_axis}"
    try:
        sizes = {np.shape(np.asarray(place, dtype=float)) for place in part.groups.values()}
    except (ValueError, TypeError, AttributeError):
        sizes = {()}
    if sizes - {(3,)}:
        yield "group_places: expected JSON of three numbers for each name of a group"
    if part.speed is not None and not np.isfinite(part.speed):
        yield "speed: expected a finite number"
    if part.stiffness_speed4 is not None and part.stiffness_speed is None:
        yield "stiffness_speed4: expected stiffness_speed too"
    masses = diagonal(part.mass)
    if not masses.any():
        yield "mass: expected a diagonal that is not zero everywhere"
    elif 0.0 < (least := masses[masses != 0.0].min()) < SMALLEST:
        yield f"mass: expected numbers of at least {SMALLEST:g} on the diagonal, got {least:g}"
    c = part.contact_position.shape[0] if part.contact_position.ndim == 2 else 0
    if part.contact_position.shape != (c, 3) or c == 0:
        yield f"contact_position: expected (nodes, 3), got {_shape(part.contact_position)}"
        return
    if not part.contact_radius.min() > 0.0:
        node = int(part.contact_radius.argmin())
        yield f"contact_position: expected nodes away from the axis z; node {node} is on it"
    radius = float(part.contact_radius.max())
    if radius > 0.0 and (expected := fault_of(radius, *RADII, "m")):
        yield (
            f"contact_position: expected contact nodes at a radius of {expected}, got {radius:.4g}"
            " m; give the units of the program, such as mm and t for a stiffness in N/mm"
        )
    yield from _dof_faults(part, "contact_dofs", (c, 3), fixed=True)
    yield from _joint_faults(part)
    if part.centre_dofs is not None:
        yield from _dof_faults(part, "centre_dofs", (2,))
    yield from _hub_faults(part)
    yield from _picture_faults(part)
    strains = part.strain_recovery
    if strains is not None and (strains.ndim != 2 or strains.shape[1] != n or not strains.shape[0]):
        yield f"strain_recovery: expected (gauges, {n}), got {_shape(strains)}"
    yield from _stress_faults(part)
    if (part.left_dofs is None) != (part.right_dofs is None):
        yield "left_dofs: expected both left_dofs and right_dofs, or neither"
    elif part.left_dofs is not None and part.right_dofs is not None:
        shape = part.left_dofs.shape
        if len(shape) != 2 or shape[1] != 3:
            yield f"left_dofs: expected (nodes, 3), got {_shape(part.left_dofs)}"
        else:
            yield from _dof_faults(part, "left_dofs", shape, fixed=True)
            yield from _dof_faults(part, "right_dofs", shape, fixed=True)


def _dof_faults(
    part: Superelement, key: str, shape: tuple[int, ...], *, fixed: bool = False
) -> Iterator[str]:
    dofs = getattr(part, key)
    if dofs.shape != shape or dofs.dtype.kind not in "iu":
        yield f"{key}: expected whole numbers {shape}, got {dofs.dtype} {_shape(dofs)}"
        return
    given = dofs[dofs != FIXED] if fixed else dofs.ravel()
    if given.size and not (given.min() >= 0 and given.max() < part.size):
        yield f"{key}: expected numbers from 0 to {part.size - 1}, got {_extreme(given, part.size)}"
    elif len(np.unique(given)) < given.size:
        yield f"{key}: expected each degree of freedom at most once"


def _hub_faults(part: Superelement) -> Iterator[str]:
    dofs, place = part.hub_dofs, part.hub_position
    if (dofs is None) != (place is None):
        yield "hub_dofs: expected both hub_dofs and hub_position, or neither"
        return
    if dofs is None or place is None:
        return
    yield from _dof_faults(part, "hub_dofs", (HUB,))
    if part.centre_dofs is not None:
        yield "hub_dofs: expected hub_dofs or centre_dofs, not both"
    if place.shape != (3,):
        yield f"hub_position: expected (3,), got {_shape(place)}"
    elif np.hypot(*place[:2]) > ON_AXIS * part.contact_radius.max():
        yield "hub_position: expected a point on the axis z"
    for key, others in part.given(("contact_dofs", "left_dofs", "right_dofs")).items():
        if np.isin(others, dofs).any():
            yield f"{key}: expected degrees of freedom that are not those of the hub"


def _joint_faults(part: Superelement) -> Iterator[str]:
    if part.joint_left is None or part.joint_right is None:
        if part.joint_left is not part.joint_right:
            yield "joint_left: expected both joint_left and joint_right, or neither"
        return
    both = np.concatenate([part.joint_left.ravel(), part.joint_right.ravel()])
    if part.joint_left.size != part.joint_right.size or not part.joint_left.size:
        yield "joint_right: expected as many nodes as joint_left, at least one"
    elif both.min() < 0 or both.max() >= part.contacts:
        yield f"joint_left: expected numbers of contact nodes, from 0 to {part.contacts - 1}"
    elif len(np.unique(both)) < both.size:
        yield "joint_left: expected each contact node at most once in joint_left and joint_right"


def _picture_faults(part: Superelement) -> Iterator[str]:
    if part.points is None:
        for key in ("recovery", "triangles"):
            if getattr(part, key) is not None:
                yield f"{key}: only allowed together with points, which are missing"
        return
    p = part.points.shape[0] if part.points.ndim else 0
    if part.points.shape != (p, 3):
        yield f"points: expected (points, 3), got {_shape(part.points)}"
        return
    if part.recovery is None:
        yield "points: only allowed together with recovery, which is missing"
    elif part.recovery.shape != (3 * p, part.size):
        yield f"recovery: expected {(3 * p, part.size)}, got {_shape(part.recovery)}"
    if part.triangles is not None and not (
        part.triangles.ndim == 2
        and part.triangles.shape[1] == 3
        and part.triangles.size
        and part.triangles.min() >= 0
        and part.triangles.max() < p
    ):
        yield f"triangles: expected numbers of points from 0 to {p - 1}, (triangles, 3)"


def _stress_faults(part: Superelement) -> Iterator[str]:
    """Yield the faults of the arrays of stresses, each as "KEY: expected ..."."""
    n, rows, given_points = part.size, part.stress_recovery, part.points
    points = 0 if given_points is None or not given_points.ndim else len(given_points)
    for key, load in part.given(part.LOADS).items():
        if load.shape != (n,):
            yield f"{key}: expected ({n},), got {_shape(load)}"
    if part.euler_load is not None and part.centrifugal_load is None:
        yield "euler_load: expected centrifugal_load too"
    if rows is not None and rows.shape != (COMPONENTS * points, n):
        shape = (COMPONENTS * points, n)
        yield f"stress_recovery: expected {shape}, six rows a point, got {_shape(rows)}"
    for key, least, most in (("young_modulus", 0.0, np.inf), ("poisson_ratio", -1.0, 0.5)):
        values = getattr(part, key)
        if values is None:
            continue
        if rows is None:
            yield f"{key}: only allowed together with stress_recovery, which is missing"
        elif values.shape != (points,):
            yield f"{key}: expected a number for each point, ({points},), got {_shape(values)}"
        elif not ((values > least) & (values <= most)).all():
            yield f"{key}: expected numbers above {least:g}, up to {most:g}"
    if (part.young_modulus is None) != (part.poisson_ratio is None):
        yield "young_modulus: expected both young_modulus and poisson_ratio, or neither"


def diagonal(matrix: Matrix) -> FloatArray:
    """Return the diagonal of a dense or sparse matrix."""
    return np.asarray(matrix.diagonal())


def dense(matrix: Any) -> FloatArray:
    """Return a dense or sparse matrix as a dense array."""
    return np.asarray(matrix.toarray() if sp.issparse(matrix) else matrix, dtype=np.float64)


def _shape(array: Any) -> str:
    return f"({', '.join(map(str, array.shape))})"


def _extreme(given: IntArray, size: int) -> int:
    return int(given.max() if given.max() >= size else given.min())
