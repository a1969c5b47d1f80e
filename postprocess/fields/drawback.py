"""Distance by which bent blades draw back, from a result."""

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray, part_up_to
from bladewhirl.meshes.plane import rotate, unit
from bladewhirl.models.case.analysis import Contact
from bladewhirl.models.elements.foreshortening import slope_form
from bladewhirl.postprocess.fields.blades import blade_chain
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    IntArray,
    combine,
    history,
    line_rows,
    line_shapes,
    slope_rows,
    table_of_result,
)

RECORDS = 1000  #: largest number of records that are examined

GAUSS = 3  #: number of Gauss points between two stations; the squares of slopes have degree four


def largest_drawback(dataset: xr.Dataset) -> float:
    """Return the largest distance by which a tip draws back towards its root, to second order [m].

    The distance is measured along the radius of the tip, relative to axes that turn with the root;
    see `models.elements.foreshortening`.

    Raises:
        ViewError: the beams of a blade are not a chain that ends at its tip.
    """
    points = dataset["rotor_point"].values
    _, span, axes, local, rotation = line_shapes(dataset)
    length = np.linalg.norm(span, axis=1)
    every = -(-dataset.sizes["time"] // RECORDS)
    coordinates = dataset["rotor_displacement"].values[::every]
    largest = 0.0
    for blade, tip in enumerate(dataset["tip_node"].values):
        out, drawn = points[tip] / np.linalg.norm(points[tip]), np.zeros(len(coordinates))
        chain = blade_chain(dataset, blade)
        root = rotation[chain.lines[0], 0 if chain.outward[0] else 1]
        for line, outward in zip(*chain[:2], strict=True):
            rise = local[line, 1, 1] - local[line, 0, 1] - length[line] * root
            moved = coordinates @ np.array([rise, *(rotation[line] - root)]).T
            along = axes[line, 0] @ out * (1.0 if outward else -1.0)
            form = along * slope_form(float(length[line]))
            drawn += 0.5 * np.einsum("ri,ij,rj->r", moved, form, moved)
        largest = max(largest, float(drawn.max()))
    return largest


def drawn_back(dataset: xr.Dataset, records: IntArray, pieces: int) -> Array | None:
    """Return the distance by which the points of beams draw back as the blades bend, to second
    order [m], (record, point): nodes, and then the stations that divide each beam into `pieces`;
    None without `contact.foreshortening`.

    The distance is measured along the outward radius of each point. At a tip it is the distance by
    which the gap opens in the march: along the blade, or with `contact.tip_rotation` the decrease
    of the distance from the axis. It is zero at the roots of the blades, and linear between the
    ends of beams that do not belong to a blade.

    Args:
        dataset: a result of beams.
        records: numbers of records.
        pieces: number of pieces of each beam.
    """
    contact = table_of_result(dataset, "contact", Contact)
    if not contact.foreshortening:
        return None
    lines, points = dataset["rotor_line"].values, dataset["rotor_point"].values
    parts, shape = dataset["rotor_part"].values.astype(str), dataset["rotor_shape"].values
    coordinates = history(dataset, "rotor_displacement", records)
    line, rows = line_rows(dataset, pieces)
    moved = combine(coordinates, rows).reshape(len(records), *line.shape)
    slopes = _slopes(dataset, coordinates, pieces)
    centre = coordinates @ shape[int(dataset["centre_node"]), :2].T
    of_stations, of_nodes = np.zeros(moved.shape[:3]), np.zeros((len(records), len(points)))
    rest = np.ones(len(lines), dtype=np.bool_)
    for tip in dataset["tip_node"].values:
        chain = part_up_to(tip, points, lines, parts)
        beams, backward = chain.lines, ~chain.outward
        place = _turned_round(line[beams][None], backward)[0]
        root = coordinates @ shape[chain.root, 2]  # rotation
        turned = _turned_round(slopes[:, beams], backward) - root[:, None, None]
        drawn = _shortening(place, turned)
        if contact.tip_rotation:
            drawn += _around(place, _turned_round(moved[:, beams], backward), centre, root)
        of_nodes[:, lines[beams, 1 * chain.outward]] = drawn[:, :, -1]
        of_stations[:, beams] = _turned_round(drawn, backward)
        rest[beams] = False
    x = np.linspace(0.0, 1.0, line.shape[1])
    ends = of_nodes[:, lines[rest]]
    of_stations[:, rest] = ends[..., :1] * (1.0 - x) + ends[..., 1:] * x
    return np.hstack([of_nodes, of_stations.reshape(len(records), -1)])


def _turned_round(values: Array, backward: BoolArray) -> Array:
    """Return values (record, beam, station, ...) with the stations of some beams reversed."""
    out = values.copy()
    out[:, backward] = values[:, backward, ::-1]
    return out


def _slopes(dataset: xr.Dataset, coordinates: Array, pieces: int) -> Array:
    """Return the slope of the beams at the Gauss points of equal pieces, (record, rotor_line,
    pieces * GAUSS)."""
    within = 0.5 * (1.0 + np.polynomial.legendre.leggauss(GAUSS)[0])
    rows = slope_rows(dataset, (np.arange(pieces)[:, None] + within).ravel() / pieces)
    flat = coordinates @ rows.reshape(-1, rows.shape[-1]).T
    return np.asarray(flat.reshape(len(coordinates), *rows.shape[:2]))


def _shortening(place: Array, turned: Array) -> Array:
    """Return 1/2 int (t . e_r) (w' - theta)^2 ds from the root of a blade to each station [m],
    (record, beam, station), with the direction t and the slope w' of the beams, the rotation theta
    of the root and the outward direction e_r of the station.

    Args:
        place: stations from root to tip, (beam, station, 2) [m].
        turned: rotations w' - theta at the Gauss points of the pieces between stations, (record,
            beam, pieces * GAUSS) [rad].
    """
    span = place[:, -1] - place[:, 0]
    pieces = place.shape[1] - 1
    squares = turned.reshape(*turned.shape[:2], pieces, GAUSS) ** 2
    weights = 0.5 * np.polynomial.legendre.leggauss(GAUSS)[1] / pieces  # sum 1 / pieces
    inside = np.cumsum(0.5 * squares @ weights, axis=-1)  # share of the length
    vector = np.pad(inside, ((0, 0), (0, 0), (1, 0)))[..., None] * span[:, None]
    vector[:, 1:] += np.cumsum(vector[:, :-1, -1:], axis=1)
    return np.asarray(np.sum(vector * unit(place), axis=-1))


def _around(place: Array, moved: Array, centre: Array, root: Array) -> Array:
    """Return the decrease of the distance from the axis in addition to the shortening along the
    blade [m], (record, beam, station).

    At the root this decrease is not zero, because the centre moves. It is made zero there: the
    value at the root is subtracted, at each station with a factor that falls from one at the root
    to zero at the tip.

    The terms are those of `models.elements.foreshortening`, for each station in place of the tip.

    Args:
        place: stations from root to tip, (beam, station, 2) [m].
        moved: displacements of the stations, (record, beam, station, 2) [m].
        centre: displacement of the centre, (record, 2) [m].
        root: rotation of the root, (record,) [rad].
    """
    radius, out, theta = np.linalg.norm(place, axis=-1), unit(place), root[:, None, None]
    ahead, from_axis = rotate(out, np.pi / 2), np.maximum(out @ place[0, 0], 0.0)
    reach = radius - out @ place[0, 0]
    swept = np.sum(moved * ahead, axis=-1)
    at_root, at_centre = (
        np.einsum("rd,bsd->rbs", vectors, ahead) for vectors in (moved[:, 0, 0], centre)
    )
    carried = np.broadcast_to(theta, swept.shape).copy()
    np.divide(at_root - at_centre, from_axis, out=carried, where=from_axis > 0.0)
    bent = swept - at_root - reach * theta
    lost = reach * theta**2 + 2.0 * theta * bent + from_axis * carried**2 - swept**2 / radius
    share = (radius[-1, -1] - radius) / (radius[-1, -1] - radius[0, 0])
    return np.asarray(0.5 * (lost - share * lost[:, :1, :1]))
