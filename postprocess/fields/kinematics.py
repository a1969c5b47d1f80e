"""Physical fields of a result: displacements and velocities of points.

A result contains modal coordinates. The functions of this module turn them into displacements and
velocities of points, for many records at once. The axes of the rotor turn counter-clockwise by the
angle of `rotation`; the axes of the casing are static. The velocity of a point of the rotor is
the rate of its displacement in rotating axes, without the velocity Omega x r of the turning disk.
"""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from bladewhirl.meshes.hermite import cubic_weights, slope_weights
from bladewhirl.meshes.plane import rotate, unit
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.file import TableT, table_of
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.netcdf import has

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

FRAMES_PER_REVOLUTION = 24  #: with fewer pictures per revolution, the rotation is not smooth


class ViewError(UserError, ValueError):
    """Invalid time window, number of frames, factor or file of a view of a result."""


def turn(dataset: xr.Dataset, records: IntArray) -> Array:
    """Return the angle of the rotor axes at the records (record,) [rad]."""
    return rotation.angles(dataset)[records]


MOST_FRAMES = 100_000  #: largest number of pictures of a film or instants of a series


def frame_records(
    dataset: xr.Dataset, frames: int, start: float | None = None, end: float | None = None
) -> IntArray:
    """Return the indices of up to `frames` records, equally spaced over [start, end] [s].

    Instants are rounded to the nearest record and duplicates are dropped, so a window with fewer
    records than frames gives each record once. If `end` is after the end of the run, the window
    ends with the run. Raises ViewError if the window does not begin inside the run.
    """
    time = dataset["time"].values
    first = time[0] if start is None else start
    last = time[-1] if end is None else min(end, time[-1])
    check_frames(frames, max(MOST_FRAMES, len(time)))
    window = f"window [{first:g}, {last if end is None else end:g}] s"
    if end is not None and first > end:
        raise ViewError(f"{window}: expected a start before the end")
    if not time[0] <= first <= last:
        covered = f"[{time[0]:g}, {time[-1]:g}] s"
        raise ViewError(f"{window}: expected a start within the run, which covers {covered}")
    enough = min(frames, 2 * len(time))
    return np.unique(nearest_records(dataset, np.linspace(first, last, enough)))


def check_frames(frames: int, most: int = MOST_FRAMES) -> None:
    """Raise a ViewError if a number of pictures is not from 1 to `most`."""
    if not 1 <= frames <= most:
        raise ViewError(f"number of frames must be from 1 to {most}, got {frames}")


def nearest_records(dataset: xr.Dataset, instants: ArrayLike) -> IntArray:
    """Return the index of the record nearest to each instant [s].

    Raises:
        ViewError: an instant is outside the run.
    """
    first, last = dataset["time"].values[[0, -1]]
    # Tolerance, as a run can end after its last record; a period of a mode has no record step.
    step = float(dataset.attrs.get("record_step", 0.0))
    instants = np.asarray(instants, dtype=np.float64)
    for time in instants.tolist():
        if not first - step <= time <= last + step:
            raise ViewError(f"time {time:g} s lies outside the run, [{first:g}, {last:g}] s")
    return np.asarray(dataset.indexes["time"].get_indexer(instants, method="nearest"))


def sampling_hint(dataset: xr.Dataset, records: IntArray) -> str | None:
    """Return a hint for the user if the records are fewer than 24 a revolution; otherwise None."""
    speed = abs(dataset.attrs["speed"])
    time = dataset["time"].values
    if len(records) < 2 or speed == 0:
        return None
    revolutions = speed * (time[records[-1]] - time[records[0]]) / (2 * np.pi)
    rate = (len(records) - 1) / revolutions
    if rate >= FRAMES_PER_REVOLUTION:
        return None
    window = 2 * np.pi / speed * len(records) / FRAMES_PER_REVOLUTION
    return (
        f"{len(records)} frames over {revolutions:.1f} revolutions are only {rate:.2g} frames per"
        f" revolution; for a smooth rotation choose a window of at most {window:.3g} s,"
        " or more frames"
    )


def history(dataset: xr.Dataset, name: str, records: IntArray) -> Array:
    """Return the values of a variable at some records (record, ...); only these are read."""
    return np.asarray(dataset.variables[name].isel(time=records).values)


def combine(coordinates: Array, shape: Array) -> Array:
    """Return a field (record, point, 2) from coordinates (record, mode) and shapes (point, 2,
    mode), by one matrix product over all records.
    """
    flat: Array = coordinates @ shape.reshape(-1, shape.shape[-1]).T
    return flat.reshape(len(coordinates), -1, 2)


def line_rows(dataset: xr.Dataset, per_line: int) -> tuple[Array, Array]:
    """Return undeformed stations (rotor_line, per_line + 1, 2) [m] along every beam, and their
    displacement for unit modal coordinates (rotor_line, per_line + 1, 2, rotor_mode), both in
    rotating axes. As in the finite elements, axial displacements are interpolated linearly,
    transverse displacements by cubic Hermite polynomials.
    """
    start, span, axes, local, turn_rows = line_shapes(dataset)
    length = np.linalg.norm(span, axis=1)
    x = np.linspace(0.0, 1.0, per_line + 1)
    cubic = cubic_weights(x)
    axial = np.einsum("es,lem->lsm", np.stack([1 - x, x]), local[:, :, 0])
    across = np.einsum("es,lem->lsm", cubic[::2], local[:, :, 1])
    across += np.einsum("l,es,lem->lsm", length, cubic[1::2], turn_rows)
    rows: Array = np.einsum("lad,lsam->lsdm", axes, np.stack([axial, across], axis=2))
    points: Array = start[:, None] + x[:, None] * span[:, None]
    return points, rows


def slope_rows(dataset: xr.Dataset, x: Array) -> Array:
    """Return the rotation of the cross-sections of beams at places x from 0 to 1 along each beam,
    for unit modal coordinates, (rotor_line, place, rotor_mode): the slope of the cubic transverse
    displacement."""
    _, span, _, local, turn_rows = line_shapes(dataset)
    slopes = slope_weights(x)
    across = np.einsum("es,lem->lsm", slopes[::2], local[:, :, 1])
    across /= np.linalg.norm(span, axis=1)[:, None, None]
    return np.asarray(across + np.einsum("es,lem->lsm", slopes[1::2], turn_rows))


def line_shapes(dataset: xr.Dataset) -> tuple[Array, Array, Array, Array, Array]:
    """Return the geometry of each beam, and the motion of its ends for unit modal coordinates.

    Returns:
        start, (rotor_line, 2) [m]; vector from start to end, (rotor_line, 2) [m]; local axes, the
        first along the beam, the second turned by 90 degrees, (rotor_line, axis, 2); displacements
        of both ends in local axes, (rotor_line, end, axis, rotor_mode); rotations of both ends,
        (rotor_line, end, rotor_mode).
    """
    ends = dataset["rotor_point"].values[dataset["rotor_line"].values]
    shape = dataset["rotor_shape"].values[dataset["rotor_line"].values]
    span = ends[:, 1] - ends[:, 0]
    along = unit(span)
    axes = np.stack([along, rotate(along, np.pi / 2)], axis=1)
    local = np.einsum("lad,ledm->leam", axes, shape[:, :, :2])
    return ends[:, 0], span, axes, local, shape[:, :, 2]


def tip_rows(dataset: xr.Dataset) -> Array:
    """Return radial, tangential and axial displacements of the contact nodes for unit modal
    coordinates, (component, contact_node, rotor_mode), positive outward and counter-clockwise.
    """
    shape, copies = dataset["contact_shape"].values, dataset.sizes["copy"]
    own = shape.reshape(copies, -1, *shape.shape[1:])
    rows = np.einsum("cnam,cd->acndm", own, np.eye(copies))
    return np.asarray(rows.reshape(3, len(shape), copies * shape.shape[-1]))


def ring_angles(dataset: xr.Dataset, per_element: int) -> Array:
    """Return the angles (casing_node * per_element,) [rad] that divide each casing element into
    `per_element` equal arcs."""
    return station_angles(dataset, per_element)[:, :-1].ravel()


def wall_angles(dataset: xr.Dataset, per_element: int) -> Array:
    """Return the angles of `ring_angles`; on a rigid wall `per_element` equal steps [rad]."""
    if has(dataset, "casing"):
        return ring_angles(dataset, per_element)
    return np.linspace(0.0, 2 * np.pi, per_element, endpoint=False)


def station_angles(dataset: xr.Dataset, per_element: int) -> Array:
    """Return the angles that divide each casing element into `per_element` equal arcs, both ends of
    the element included, (casing_node, per_element + 1) [rad]."""
    cuts = np.linspace(0.0, 1.0, per_element + 1)
    return np.asarray(dataset["casing_angle"].values[:, None] + _arcs(dataset)[:, None] * cuts)


def _arcs(dataset: xr.Dataset) -> Array:
    """Return the angle that every casing element spans (casing_node,) [rad]."""
    first = dataset["casing_angle"].values
    return np.asarray(np.mod(np.roll(first, -1) - first, 2 * np.pi))


def wall_rows(dataset: xr.Dataset, weights: Array) -> Array:
    """Return radial and tangential displacements of every casing element for unit modal
    coordinates, (casing_node, station, 2, casing_mode), with `weights` (4, station) from
    `cubic_weights`. With weights from `slope_weights` or `curvature_weights` return instead the
    first or second derivatives of the displacements with respect to the position in the element,
    which goes from 0 to 1.
    """
    shape = dataset["casing_shape"].values
    nodal = shape.reshape(len(shape), 2, 2, -1)  # node, (w, u), (value, slope), mode
    ends = np.stack([nodal, np.roll(nodal, -1, axis=0)], axis=1)
    length = element_lengths(dataset)[:, None, None, None]
    rows = np.einsum("es,lecm->lscm", weights[::2], ends[:, :, :, 0])
    rows += length * np.einsum("es,lecm->lscm", weights[1::2], ends[:, :, :, 1])
    return np.asarray(rows)


def element_lengths(dataset: xr.Dataset) -> Array:
    """Return the arc length of every casing element (casing_node,) [m]."""
    return np.asarray(dataset.attrs["casing_radius"] * _arcs(dataset))


def casing_rows(dataset: xr.Dataset, angle: Array) -> Array:
    """Return radial (outward) and tangential (+theta) displacements of the casing at the angles
    (point,) for unit modal coordinates, (point, 2, casing_mode), by cubic interpolation.
    """
    node = dataset["casing_angle"].values
    inside = np.mod(angle - node[0], 2 * np.pi)
    left = np.searchsorted(node - node[0], inside, side="right") - 1
    weights = cubic_weights((inside - (node[left] - node[0])) / _arcs(dataset)[left])
    weights[1::2] *= element_lengths(dataset)[left]
    shape = dataset["casing_shape"].values
    pairs = shape.reshape(len(shape), 2, 2, -1)  # node, (w, u), (value, slope), mode
    at_left = np.einsum("kp,pckm->pcm", weights[:2], pairs[left])
    at_right = np.einsum("kp,pckm->pcm", weights[2:], pairs[(left + 1) % len(node)])
    return np.asarray(at_left + at_right)


def smallest_clearance(dataset: xr.Dataset) -> float:
    """Return the smallest clearance plus the smallest `tip_recess` [m]. The clearance is measured
    from the tip radius of the stage; `tip_recess` is the distance by which a tip lies inside this
    radius. Vibration is not included; the static growth of the tips at speed is subtracted if the
    case gives the clearance at rest. NaN for a shaft line without a wheel, which has no wall."""
    stage = dataset.variables
    clearance, recess = stage["clearance"].values, stage["tip_recess"].values
    return float(clearance.min() + recess.min()) if recess.size else float("nan")


def clearance_at(dataset: xr.Dataset, angle: Array) -> Array:
    """Return the clearance (point,) [m] at static angles [rad], linear between the angles
    at which it is stored."""
    node, clearance = dataset["wall_angle"].values, dataset["clearance"].values
    return np.asarray(np.interp(angle, node, clearance, period=2 * np.pi))


def table_of_result(dataset: xr.Dataset, name: str, kind: type[TableT]) -> TableT:
    """Return a table of the case of a run, such as [casing]. Return the default table for motions
    that are not marched, such as those of modes: their attribute `case` is only a title."""
    text = str(dataset.attrs.get("case", "")) if "time_step" in dataset.attrs else ""
    return table_of(text, name, kind)


def closure_change(dataset: xr.Dataset, records: IntArray, angle: Array) -> Array:
    """Return the change of the clearance since the start by `casing.closure` at static angles
    [rad], (record, point) [m]."""
    closure = table_of_result(dataset, "casing", Casing).closure
    if closure is None:
        return np.zeros((len(records), len(angle)))
    time = dataset["time"].values[records]
    return np.asarray(-closure.value(time)[:, None] * closure.around.value(angle))


def track_strains(dataset: xr.Dataset, records: IntArray, angle: Array) -> Array:
    """Return the plastic strain of each track of the coating at static angles [rad] and at records,
    (record, track, point). The strain at a record is that of the last profile stored before this
    record."""
    time, stored = dataset["time"].values[records], dataset["wear_time"].values
    profile = np.maximum(np.searchsorted(stored, time, side="right") - 1, 0)
    rods = dataset.sizes["rod"]
    rod = np.floor(np.mod(angle, 2 * np.pi) * rods / (2 * np.pi)).astype(np.int64) % rods
    return np.asarray(dataset["coating_strain"].values[profile][..., rod])


def record_lengths(dataset: xr.Dataset) -> Array:
    """Return the time since the previous record (time,) [s]: the record step, or less for the last
    record of a run that ended early."""
    time = dataset["time"].values
    return np.diff(time, prepend=time[0] - dataset.attrs["record_step"])


def contact_forces(dataset: xr.Dataset, records: IntArray, *, rotating: bool = False) -> Array:
    """Return the force of the casing on each contact node (record, contact_node, 3) [N], normal and
    friction together.

    The force is the impulse since the previous record divided by the time since that record. This
    mean force converges as the time step decreases, while the peak force does not. The normal part
    pushes inward; positive friction drags the blade towards -theta. The force is zero for a Dataset
    without contact impulses, such as a mode.
    """
    if "contact_impulse" not in dataset:
        return np.zeros((len(records), dataset.sizes["contact_node"], 3))
    pushed = [-history(dataset, f"{kind}_impulse", records) for kind in ("contact", "friction")]
    polar = (
        np.stack([*pushed, history(dataset, "axial_impulse", records)], axis=-1)
        / record_lengths(dataset)[records, None, None]
    )
    angle = dataset["tip_angle"].values[None]
    return rotate(polar, angle if rotating else angle + turn(dataset, records)[:, None])


def radial_part(vectors: Array, points: Array) -> Array:
    """Return the radial component (...), positive outward, of vectors (..., 2) at points (..., 2);
    zero at the centre, where no direction is radial.
    """
    radius = np.linalg.norm(points, axis=-1)
    dot = np.sum(vectors * points, axis=-1)
    return np.asarray(np.divide(dot, radius, out=np.zeros_like(dot), where=radius > 0))
