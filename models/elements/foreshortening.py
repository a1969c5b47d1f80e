"""Distance by which the tip of a bent blade draws back, as a quadratic form of the displacements.

A blade is a chain of straight, inextensible elements from its root to its tip. Relative to axes
that turn with the root by its rotation theta, an element turns by w' - theta, where w' is the slope
of its displacement. To second order, the tip therefore moves towards the root by

    d = 1/2 sum_e (t_e . e_r) int (w' - theta)^2 ds

with the direction t_e of each element and the radial direction e_r at the tip. A rigid rotation of
the bladed disk gives d = 0. The distance of the tip from the axis is, to second order,

    |X + u| = R + u_r - d - theta^2 rho / 2 - theta v - alpha^2 X_r / 2 + u_t^2 / (2 R)

for a tip at the position X and the radius R, with the displacements u_r and u_t. The position of
the root has the radial component X_r, and the chord from root to tip the radial component rho. The
tip has the tangential displacement v relative to the axes of the root. The rotation alpha carries
the root around the centre: alpha X_r is u_t of the root minus u_t of the centre. If the disk is
rigid, the last four terms are v^2 / (2 R): the tip of a bent blade moves along a tangent, farther
from the axis.
"""

import numpy as np

from bladewhirl.meshes.line_mesh import Chain, FloatArray, part_up_to
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.geometry.beam_model import BeamModel


def blade_beams(model: BeamModel, tip: int) -> Chain:
    """Return the beams of a blade of a model, see `part_up_to`; none if no beam ends at the tip."""
    mesh = model.mesh
    return part_up_to(tip, mesh.points, mesh.lines, np.array(mesh.line_parts))


def drawback(
    disk: BladedDiskModel, shapes: FloatArray, blade: int, *, around: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the quadratic form 1/2 sum_i s_i y_i^2 of the distance by which a tip draws back.

    Args:
        disk: finite element model with beams at the tip.
        shapes: fields on the free DoF for unit coordinates, (size, fields).
        blade: number of the blade.
        around: return the decrease of the tip's distance from the axis, instead of the distance d
            along the blade.

    Returns:
        rows of y for unit coordinates [m^1/2 per coordinate], (rows, fields), and the signs s,
        (rows,).
    """
    points, tip = disk.mesh.points, disk.model.tips[blade]
    chain, moved = blade_beams(disk.model, tip), disk.cartesian(shapes)
    out, turned = points[tip] / np.linalg.norm(points[tip]), moved[chain.root, 2]
    rows, forms = [], []
    for line, outward in zip(chain.lines[::-1], chain.outward[::-1], strict=True):
        first, second = disk.mesh.lines[line][:: 1 if outward else -1]
        span = points[second] - points[first]
        length = float(np.linalg.norm(span))
        along = span / length
        across = np.array([-along[1], along[0]])
        rise = across @ (moved[second, :2] - moved[first, :2]) - length * turned
        rows.append([rise, moved[first, 2] - turned, moved[second, 2] - turned])
        forms.append(slope_form(length) * (along @ out))
    factors = [_factors(form, np.array(row)) for form, row in zip(forms, rows, strict=True)]
    if around:
        factors.append(_factors(*_around(disk, moved, chain.root, int(tip))))
    return np.vstack([rows for rows, _ in factors]), np.concatenate([signs for _, signs in factors])


def slope_form(length: float) -> FloatArray:
    """Return the matrix of int w'^2 ds, (3, 3), for the rise between the ends of an element and the
    slopes at both ends."""
    h = length
    return np.array(
        [[36.0, -3 * h, -3 * h], [-3 * h, 4 * h**2, -(h**2)], [-3 * h, -(h**2), 4 * h**2]]
    ) / (30.0 * h)


def _around(
    disk: BladedDiskModel, moved: FloatArray, root: int, tip: int
) -> tuple[FloatArray, FloatArray]:
    """Return the quadratic form theta^2 rho + 2 theta v + alpha^2 X_r - u_t^2 / R: its matrix,
    (4, 4), and the rows of theta, v, alpha and u_t, (4, fields)."""
    points, centre = disk.mesh.points, disk.model.centre
    radius = float(np.linalg.norm(points[tip]))
    out = points[tip] / radius
    ahead = np.array([-out[1], out[0]])
    reach, from_axis = float(out @ (points[tip] - points[root])), float(out @ points[root])
    turned, swept = moved[root, 2], np.tensordot(ahead, moved[[centre, root, tip], :2], (0, 1))
    bent = swept[2] - swept[1] - reach * turned
    carried = (swept[1] - swept[0]) / from_axis if from_axis > 0.0 else turned
    form = np.diag([reach, 0.0, max(from_axis, 0.0), -1.0 / radius])
    form[0, 1] = form[1, 0] = 1.0
    return form, np.array([turned, bent, carried, swept[2]])


def _factors(form: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return rows y and signs s such that sum_i s_i y_i^2 is a quadratic form of given rows, which
    has the symmetric matrix `form`."""
    values, vectors = np.linalg.eigh(form)
    return np.sqrt(np.abs(values))[:, None] * (vectors.T @ rows), np.sign(values)


def fewest_terms(
    rows: FloatArray, signs: FloatArray, weight: FloatArray, share: float
) -> tuple[FloatArray, FloatArray, float]:
    """Return a quadratic form with as few terms as possible; its smallest terms are neglected.
    Terms are compared for equal energies of all coordinates.

    Args:
        rows: rows y of the form 1/2 sum_i s_i y_i^2, (rows, coordinates).
        signs: signs s, (rows,).
        weight: square root of the stiffness of each coordinate, positive, (coordinates,).
        share: terms below this fraction of the largest term are neglected.

    Returns:
        rows (terms, coordinates) and signs (terms,), the largest term first; and, of the terms
        above 1e-3 of the largest, the highest mean frequency, in the unit of `weight`.
    """
    basis, triangle = np.linalg.qr((rows / weight).T)
    values, vectors = np.linalg.eigh(triangle @ (signs[:, None] * triangle.T))
    order = np.argsort(-np.abs(values))
    size = np.abs(values[order])
    kept = order[size > share * size[0]]
    unit = (basis @ vectors[:, kept]).T
    large = np.abs(values[kept]) > 1e-3 * size[0]
    fastest = float(np.sqrt((unit[large] ** 2 @ weight**2).max(initial=0.0)))
    return np.sqrt(np.abs(values[kept]))[:, None] * unit * weight, np.sign(values[kept]), fastest
