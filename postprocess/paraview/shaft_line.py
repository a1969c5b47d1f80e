"""Grids of a shaft line at some records: its surface as a body of revolution."""

from collections.abc import Iterator

import meshio
import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history

AROUND = 24  #: number of points around a section
DRAWN = 0.05  #: largest displacement in a picture, as a fraction of the length of the shaft


def exaggeration_of(dataset: xr.Dataset, records: IntArray, given: float | None) -> float:
    """Return the factor of displacements in `warp`; chosen from the largest one if None.

    Raises:
        ViewError: it is not positive.
    """
    if given is not None:
        if not given > 0.0:
            raise ViewError(f"exaggeration {given:g}: expected a positive number")
        return given
    moved = history(dataset, "shaft_displacement", records)[..., :2]
    largest = float(np.linalg.norm(moved, axis=-1).max())
    length = float(np.ptp(dataset["shaft_position"].values))
    return DRAWN * length / largest if largest else 1.0


def line_grids(
    dataset: xr.Dataset, records: IntArray, *, rotating: bool, exaggeration: float
) -> Iterator[dict[str, meshio.Mesh]]:
    """Yield the grid of the part `rotor` at each record: quadrilaterals between sections at the
    nodes, with `displacement` and `warp` [m]; in rotating axes the surface does not turn."""
    place, radius = dataset["shaft_position"].values, dataset["shaft_radius"].values
    node, corner = np.divmod(np.arange(len(place) * AROUND), AROUND)
    first = np.arange((len(place) - 1) * AROUND)
    following = first - first % AROUND + (first + 1) % AROUND
    cells = np.stack([first, following, following + AROUND, first + AROUND], axis=1)
    angles = rotation.angles(dataset)
    for record in records.tolist():
        turned = float(angles[record])
        around = 2.0 * np.pi / AROUND * corner + (0.0 if rotating else turned)
        points = np.stack(
            [radius[node] * np.cos(around), radius[node] * np.sin(around), place[node]], axis=1
        )
        motion = dataset["shaft_displacement"].values[record]
        back = turned if rotating else 0.0
        moved = _moved(motion, back)[node]
        displacement = moved[:, :3] + np.cross(moved[:, 3:], points * [1.0, 1.0, 0.0])
        arrays = {"displacement": displacement, "warp": exaggeration * displacement}
        yield {"rotor": meshio.Mesh(points, [("quad", cells)], arrays)}


def _moved(motion: Array, back: float) -> Array:
    """Return displacements and rotations of nodes, (nodes, 6), in axes turned by an angle [rad]."""
    out = motion.copy()
    for x in (0, 3):
        whole = (motion[:, x] + 1j * motion[:, x + 1]) * np.exp(-1j * back)
        out[:, x], out[:, x + 1] = whole.real, whole.imag
    return out
