"""Points of the bladed disk, the cells between them, and the recovery of their motion.

A solid has the points and triangles of its file, copy by copy. Beams have their nodes, and then
stations along each beam; the cells are the pieces between stations. The displacement of a station
follows from those of both ends of its beam by the shape functions of the finite elements.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import absent
from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.postprocess.fields.blades import line_blades, member_names
from bladewhirl.postprocess.fields.drawback import drawn_back
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    IntArray,
    ViewError,
    history,
    line_rows,
)
from bladewhirl.postprocess.fields.lost_blades import lost_beams, lost_blades
from bladewhirl.postprocess.fields.mitres import Mitres, mitres_of
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.point_stresses import PointStresses, has_stresses
from bladewhirl.postprocess.fields.strains import rotor_sections, rotor_strain_rows

NO_POINTS = "expected a superelement whose file has points and recovery"
WITHOUT_WALL = "wheel without a wall"  #: name of a wheel whose blades have no numbers
NO_VALUES = np.zeros((0, 0, 0))


class Recovered(NamedTuple):
    """A field that is recovered at points, or a label for one."""

    name: str
    unit: str
    signed: bool
    at: Callable[[IntArray], Array] = lambda _: NO_VALUES
    """Function of records that returns the values (record, point, side); surfaces have one side."""
    steady: bool = False  #: whether it has the part of steady rotation


@dataclass(frozen=True, kw_only=True)
class Points:
    """Points and cells at rest, in rotating axes, with what recovers their motion."""

    rest: Array  #: (point, 3) [m]
    cells: IntArray  #: points of each line (cell, 2), triangle (cell, 3) or point (cell, 1)
    blade: IntArray  #: blade of each point, -1 for none (point,)
    members: list[str]  #: names of the blades, and of the other parts of beams
    member: IntArray  #: position in `members` of each point, -1 for none (point,)
    parts: list[str]  #: names of the parts of the mesh
    part: IntArray  #: position in `parts` of each point, -1 for none (point,)
    shape: Array
    """Displacement of the points of a copy for unit modal coordinates of the copy [kg^-1/2], (point
    of a copy, 3, mode)."""
    copy_angle: Array  #: angle of each copy (copy,) [rad]
    centre: Array
    """Displacement of the centre for unit modal coordinates [kg^-1/2], (2, modes of all copies);
    zero for blades without a common centre."""
    contact: IntArray  #: point nearest to each contact node (contact_node,)
    recovered: Mapping[str, Recovered]  #: strains and stresses, as named in `choices.Field`
    lost_from: float = np.inf  #: time from which blades are lost [s]
    lost: IntArray = absent()  #: points that are lost (lost,)
    cut: IntArray = absent()  #: point at the fracture that is nearest to each of them (lost,)
    modulus: Array = field(default_factory=lambda: np.zeros(0))
    """Young's modulus of beams at their stations (line, station), or at the points of a copy (point
    of a copy,) [Pa]; empty if it is not known."""
    thickness: Array = field(default_factory=lambda: np.zeros((0, 1)))
    """Thickness of beams at their stations (line, station) [m]."""
    ends: IntArray = absent()  #: stations at tips, among all stations of all beams
    mitres: Mitres = field(default_factory=Mitres)  #: joints at which beams go on from each other
    drawn_back: Callable[[IntArray], Array | None] = lambda _: None
    """Function of records that returns the distance by which each point draws back at them (record,
    point) [m], or None."""

    @property
    def of_copy(self) -> Array:
        """Points of the first copy (point of a copy, 3) [m]."""
        return self.rest[: len(self.shape)]

    @property
    def flat(self) -> bool:
        """Whether the cells are lines in a plane."""
        return bool(self.cells.shape[1] == 2)

    def moved(self, coordinates: Array) -> Array:
        """Return displacements or velocities (point, 3) [m] or [m/s] in axes that turn with the
        first copy, for modal coordinates or their rates (modes of all copies,)."""
        copies = len(self.copy_angle)
        flat = self.shape.reshape(-1, self.shape.shape[-1])
        vectors = coordinates.reshape(copies, -1) @ flat.T
        return rotate(vectors.reshape(copies, -1, 3), self.copy_angle[:, None]).reshape(-1, 3)

    def stations(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the values (point, ...) of the stations of beams, (line, station, ...)."""
        lines, stations = self.thickness.shape
        return values[len(values) - lines * stations :].reshape(lines, stations, *values.shape[1:])


def points_of(dataset: xr.Dataset, pieces: int) -> Points:
    """Return the points of the bladed disk, with stations that divide each beam into `pieces`.

    Raises:
        ViewError: the stage has no points.
    """
    return _of_beams(dataset, pieces) if has(dataset, "lines") else _of_solids(dataset)


def contact_nodes(dataset: xr.Dataset) -> Array:
    """Return the undeformed contact nodes, (contact_node, 3) [m]."""
    radius, axial = dataset["contact_radius"].values, dataset["axial_position"].values
    return np.column_stack([radius[:, None] * directions(dataset["tip_angle"].values), axial])


def _of_beams(dataset: xr.Dataset, pieces: int) -> Points:
    nodes, ends = dataset["rotor_point"].values, dataset["rotor_line"].values
    tips, shape = dataset["tip_node"].values, dataset["rotor_shape"].values[:, :2]
    line, rows = line_rows(dataset, pieces)
    lines, stations = line.shape[:2]
    number = len(nodes) + np.arange(lines * stations).reshape(lines, stations)
    of_line = line_blades(dataset)
    members, member = member_names(dataset)
    part = dataset["rotor_part"].values.astype(str).tolist()
    parts = list(dict.fromkeys(part))

    def on_points(values: IntArray) -> IntArray:
        return np.append(np.full(len(nodes), -1), np.repeat(values, stations))

    def recovered(name: str) -> Callable[[IntArray], Array]:
        def at(records: IntArray) -> Array:
            motion = history(dataset, "rotor_displacement", records)
            strains = rotor_strain_rows(dataset, pieces).at(motion)
            values = strains.at_surfaces(name, rotor_sections(dataset, "young_modulus", pieces))
            none = np.full((len(records), len(nodes), 2), np.nan)
            return np.hstack([none, values.reshape(len(records), -1, 2)])

        return at

    of_node = np.full(len(nodes), -1)
    of_node[ends[of_line >= 0]] = of_line[of_line >= 0, None]
    beams, end = np.nonzero(np.isin(ends, tips) & (of_line >= 0)[:, None])
    loss = lost_blades(dataset)
    lost = dict[str, Any]()
    if loss is not None:
        beam_cuts = lost_beams(dataset, loss)
        lost = {
            "lost_from": loss.time,
            "lost": np.append(beam_cuts.nodes, number[beam_cuts.lines]),
            "cut": np.append(beam_cuts.node_cuts, np.repeat(beam_cuts.line_cuts, stations)),
        }
    thickness = rotor_sections(dataset, "thickness", pieces)
    return Points(
        rest=np.pad(np.vstack([nodes, line.reshape(-1, 2)]), ((0, 0), (0, 1))),
        cells=np.stack([number[:, :-1], number[:, 1:]], axis=-1).reshape(-1, 2),
        blade=np.append(of_node, np.repeat(of_line, stations)),
        members=members,
        member=on_points(member),
        parts=[name or "other beams" for name in parts],
        part=on_points(np.array([parts.index(name) for name in part])),
        shape=np.pad(
            np.vstack([shape, rows.reshape(-1, *rows.shape[2:])]), ((0, 0), (0, 1), (0, 0))
        ),
        copy_angle=np.zeros(1),
        centre=shape[int(dataset["centre_node"])],
        contact=tips,
        recovered={
            "axial-strain": Recovered("axial strain", "m/m", True, recovered("axial-strain")),
            "bending-strain": Recovered("bending strain", "m/m", True, recovered("bending-strain")),
            "stress": Recovered("surface stress", "Pa", True, recovered("stress")),
        },
        modulus=rotor_sections(dataset, "young_modulus", pieces),
        thickness=thickness,
        mitres=mitres_of(nodes, ends, thickness[:, [0, -1]]),
        ends=stations * beams + np.where(end == 1, stations - 1, 0),
        drawn_back=lambda records: drawn_back(dataset, records, pieces),
        **lost,
    )


def _of_solids(dataset: xr.Dataset) -> Points:
    if not (dataset.sizes["contact_node"] or has(dataset, "points")):
        raise ViewError(
            "expected a bladed disk; `bladewhirl export` writes a series of a shaft line"
        )
    if not has(dataset, "points"):
        raise ViewError(NO_POINTS)
    from scipy.spatial import KDTree  # long to load

    points, copies = dataset.sizes["point"], dataset.sizes["copy"]
    angle = dataset["copy_angle"].values
    rest = rotate(dataset["point"].values, angle[:, None]).reshape(-1, 3)
    cells = dataset["triangle"].values if "triangle" in dataset else np.arange(points)[:, None]
    nodes, recovered = contact_nodes(dataset), dict[str, Recovered]()
    blade = np.repeat(np.arange(copies), points)
    if not len(nodes):  # a wheel without a wall, whose blades are not known
        blade = np.full(len(rest), -1)
    elif copies == 1:  # with several blades, that of the nearest contact node
        blade = dataset["blade"].values[KDTree(nodes).query(rest)[1]]
    loss, lost = lost_blades(dataset), dict[str, Any]()
    if loss is not None:
        gone = loss.blades[np.isin(loss.blades, blade)]  # none of further wheels
        own = [np.flatnonzero(blade == number) for number in gone]
        roots = [each[np.hypot(*rest[each, :2].T).argmin()] for each in own]
        lost = {
            "lost_from": loss.time,
            "lost": np.concatenate([np.zeros(0, dtype=np.int64), *own]),
            "cut": np.repeat(np.array(roots, dtype=np.int64), [len(each) for each in own]),
        }
    modes = dataset.sizes["rotor_mode"]
    if has_stresses(dataset):
        stresses = PointStresses(dataset)
        recovered["stress"] = Recovered(
            "von Mises stress", "Pa", False, stresses.on_sides, stresses.steady
        )
    return Points(
        rest=rest,
        cells=np.vstack([cells + points * number for number in range(copies)]),
        blade=blade,
        members=[f"blade {number}" for number in range(blade.max() + 1)] or [WITHOUT_WALL],
        member=np.maximum(blade, 0),
        parts=["bladed disk"],
        part=np.zeros(len(rest), dtype=np.int64),
        shape=dataset["point_shape"].values,
        copy_angle=angle,
        centre=dataset["centre_shape"].values if has(dataset, "centre") else np.zeros((2, modes)),
        contact=KDTree(rest).query(nodes)[1],
        modulus=dataset.get("point_young_modulus", xr.DataArray([])).values,
        recovered=recovered,
        **lost,
    )
