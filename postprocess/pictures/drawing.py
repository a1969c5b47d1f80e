"""Geometry of a picture of the stage: beams and wall as filled ribbons, surfaces of triangles,
contact as arrows.

Points are taken from a body of `bodies` and transformed to the axes of the picture.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.plane import rotate, unit
from bladewhirl.postprocess.fields import kinematics, rotation
from bladewhirl.postprocess.fields.by_blade import (
    WRONG_BY_A_TENTH,
    blade_count,
    blade_length,
    of_blades,
)
from bladewhirl.postprocess.fields.joint_nodes import JOINT_FIELDS
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.lost_blades import masked
from bladewhirl.postprocess.fields.wheels import with_surfaces
from bladewhirl.postprocess.pictures.bodies import COATING, Body
from bladewhirl.postprocess.pictures.choices import Field, Frame, View
from bladewhirl.postprocess.pictures.colouring import colouring, is_normalised
from bladewhirl.postprocess.pictures.solids import Placed, Solid, behind
from bladewhirl.postprocess.pictures.symbols import Symbols

NUMBER_PLACE, NUMBER_ASIDE = 0.9, 0.045
"""Radius and sideways offset of a blade number, relative to the tip radius."""
HIDDEN = 0.03
"""A part hides a point if it is nearer to the viewer by more than this share of the surface's
size."""


@dataclass(frozen=True, kw_only=True)
class Ribbon:
    """Strips of quadrilaterals along beams or along the wall."""

    sides: Array  #: points on both sides (line, station, side, 2) [m]
    values: Array  #: true values of the field at the sides (line, station, side)


class Surface(NamedTuple):
    """Surface of triangles of a solid."""

    points: Array  #: places, and distance towards the viewer (point, 3) [m]
    values: Array  #: true values of the field, NaN for none (point,)


@dataclass(frozen=True, kw_only=True)
class Picture:
    """Stage at one record. Positions are as drawn, with displacements and clearance multiplied by
    the exaggeration; values of fields and forces are true."""

    time: float  #: [s]
    speed: float  #: speed of the rotor [rad/s]
    rotor: Ribbon  #: beams
    casing: Ribbon  #: the wall around beams
    solids: tuple[Surface, ...]  #: parts of the stage in space, see `Body.solids`
    shaft: Array  #: drawn centre (2,) [m]
    tips: Array  #: drawn contact nodes (contact_node, 2) [m]
    tip_values: Array
    """True values of the field at contact nodes (contact_node,); NaN where it has none, and on
    hidden nodes."""
    mark: Array  #: drawn mark on the first blade (2,) [m], which shows the rotation
    hidden: NDArray[np.bool_]
    """Whether each contact node, shaft and mark is lost or lies behind a part."""
    symbols: Symbols  #: springs, supports, masses
    forces: Array
    """True contact force on each node (contact_node, 2) [N], as seen in the picture; zero on hidden
    nodes."""
    blade_forces: Array  #: size of the contact force on each blade that is not lost (blade,) [N]
    tip_places: Array  #: drawn contact nodes with their distance towards the viewer (node, 3) [m]
    pushes: Array  #: contact forces also on hidden nodes, in the axes of the picture (node, 3) [N]


class Drawing:
    """Pictures of the stage at chosen records.

    Args:
        dataset: a result.
        records: numbers of the records.
        exaggeration: factor of displacements and clearance; a round number is chosen when None.
        frame: axes of the picture: in "static" axes the rotor turns, in "rotating" axes the casing
            turns backward. When None, "static", for a single blade "rotating".
        colour: field that colours rotor and wall, see `colouring`.
        view: direction of the view of a surface, see `Body`.

    Raises:
        ViewError: the frame, the view, the field or the exaggeration is invalid, or a rotor without
            beams has no surface.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        exaggeration: float | None = None,
        frame: Frame | None = None,
        colour: Field = "deformation",
        view: View | None = None,
    ) -> None:
        if frame not in (None, "static", "rotating"):
            raise ViewError(f'frame must be "static" or "rotating", got {frame!r}')
        dataset = with_surfaces(dataset)
        several = blade_count(dataset) > 1
        self.frame: Frame = frame or ("static" if several else "rotating")
        rotating = self.frame == "rotating"
        self.around = several or not rotating  #: whether the axis is in the picture
        self._dataset, self._colour = dataset, colour
        self._body = body = Body(dataset, records, exaggeration, around=self.around, view=view)
        self.points = [each.body for each in body.disks]  #: points of each bladed disk at rest
        self.solids = body.solids  #: triangles and colours of the solids
        if colour == "wear":  # of the coating, not of the wall behind it
            self.solids = tuple(
                replace(one, shows="wall" if one.colour == COATING else None)
                if one.shows != "disk"
                else one
                for one in body.solids
            )
        self.nodes = body.nodes  #: nodes of beams, or contact nodes, at rest (node, 2) [m]
        self._stage = stage = body.stage
        self.records = records
        self.exaggeration = stage.factor
        self.largest_displacement = max(each.largest_displacement for each in body.stages)
        self.normalised = is_normalised(dataset)  #: whether the amplitude is arbitrary
        self.times = dataset["time"].values[records]
        self.speeds = rotation.speeds(dataset)[records]  #: at each record [rad/s]
        every = dataset["time"].values
        self.record_step = float(every[1] - every[0]) if len(every) > 1 else 1.0
        """Time between records [s]; 1 for a single record, which any text of its time shows."""
        self._blade_length = blade_length(dataset)
        angle = stage.turns
        self._rotor_turn, self._casing_turn = (
            (0 * angle, -angle) if rotating else (angle, 0 * angle)
        )
        self._forces = kinematics.contact_forces(dataset, records, rotating=rotating)
        every_tip = np.zeros((len(every), dataset.sizes["contact_node"]))
        self.lost = np.isnan(masked(dataset, every_tip)[records])
        """Whether each contact node is lost (record, contact_node)."""
        per_element = len(stage.angle) // body.wheels[0].sizes.get("casing_node", 1)
        self.colouring = colouring(
            [*zip(body.wheels, self.points, strict=True)],
            *(colour, records, per_element),
            rotating=rotating,
        )

    @property
    def largest_force(self) -> float:
        """Largest contact force on a contact node in the records [N]."""
        return float(np.linalg.norm(self._forces, axis=-1).max())

    @property
    def total_force(self) -> Array:
        """Sum of the sizes of the contact forces on all contact nodes, (record,) [N]."""
        return np.asarray(np.linalg.norm(self._forces, axis=-1).sum(axis=1))

    @property
    def discs(self) -> list[str]:
        """Text with the meaning of discs, if there are any."""
        shown = "joints" if self._colour in JOINT_FIELDS else "contact nodes"
        return [f"discs: {shown}"] * bool(np.isfinite(self.colouring.nodes).any())

    @property
    def dots(self) -> list[str]:
        """Text with the meaning of the dots that are seen, if any; in a film the first blade turns
        into view."""
        if not self.around:
            return []
        centre, blade = self.picture(0).hidden[-2:]
        seen = ["centre"] * (not centre) + ["blade 0"] * (not blade or len(self) > 1)
        return [f"dots: {' and '.join(seen)}"] if seen else []

    def linear_limit(self) -> float | None:
        """Return the displacement [m] at which a linear model has an error of a tenth; None if all
        displacements at these records are smaller."""
        limit = WRONG_BY_A_TENTH * self._blade_length
        largest = max(each.largest_bend for each in self._body.stages)
        return limit if largest > limit else None

    def reach(self) -> tuple[float, float]:
        """Return the largest distance of the drawn stage, and of tips in contact, from the middle
        [m]."""
        stage = contact = 0.0
        for index in range(len(self)):
            seen = self.picture(index)
            touching = seen.tips[np.any(seen.forces, axis=1)]
            contact = max(contact, float(np.max(np.sum(touching**2, axis=-1), initial=0.0)))
            solids = [solid.points[:, :2] for solid in seen.solids]
            for shape in (seen.rotor.sides, *solids, seen.casing.sides, *seen.symbols):
                stage = max(stage, float(np.max(np.sum(shape**2, axis=-1), initial=0.0)))
        return float(np.sqrt(stage)), float(np.sqrt(contact))

    def __len__(self) -> int:
        return len(self.records)

    def picture(self, index: int) -> Picture:
        """Return the stage at the index-th of the chosen records."""
        turns = float(self._rotor_turn[index]), float(self._casing_turn[index])
        body, colours = self._body, self.colouring
        shape, values = body.shape(index, *turns), colours.points[index]
        forces = self._forces[index]
        spots = np.vstack([shape.tips, shape.centre, shape.mark])
        hidden = np.append(self.lost[index], [False, False])
        if self.around and self.solids:
            corners = [
                placed.points[solid.triangles]
                for placed, solid in zip(shape.solids, self.solids, strict=True)
                if solid.hides
            ]
            hidden |= behind(
                spots, corners, HIDDEN * float(np.ptp(shape.solids[0].points, axis=0).max())
            )
        gone = of_blades(self._dataset, 1.0 * self.lost[index]) > 0.0
        seen = body.seen(forces)
        seen[hidden[: len(seen)]] = 0.0
        return Picture(
            time=float(self.times[index]),
            speed=float(self.speeds[index]),
            rotor=Ribbon(sides=shape.ribbons, values=self.points[0].stations(values)),
            casing=Ribbon(sides=shape.wall, values=colours.casing[index][shape.stations]),
            solids=tuple(
                Surface(placed.points, self._values(index, solid, placed))
                for solid, placed in zip(self.solids, shape.solids, strict=True)
            ),
            shaft=shape.centre[:2],
            tips=shape.tips[:, :2],
            tip_values=np.where(hidden[: len(seen)], np.nan, colours.nodes[index]),
            mark=shape.mark[:2],
            hidden=hidden,
            symbols=shape.symbols,
            forces=seen,
            tip_places=shape.tips,
            pushes=np.where(self.lost[index, :, None], 0.0, body.turned(forces)),
            blade_forces=np.linalg.norm(of_blades(self._dataset, forces.T), axis=0)[~gone],
        )

    def _values(self, index: int, solid: Solid, placed: Placed) -> Array:
        """Return the values of the field on a solid at the index-th record (point,)."""
        at = placed.stations
        if solid.shows is None or not len(at):
            return np.full(len(placed.points), np.nan)
        shown = self.colouring.points if solid.shows == "disk" else self.colouring.casing
        return np.where(at < 0, np.nan, shown[index, at % shown.shape[1], 0])


def arrows(tips: Array, forces: Array, length_per_newton: float, width: float) -> Array:
    """Return outlines (blade, 7, 2) of arrows that end on the tips and point along the forces.

    Corners 0, 1, 5 and 6 belong to the shaft of the arrow, corners 2, 3 and 4 to its head, which is
    five widths long; a shorter arrow is a smaller head. The arrow of a blade without contact has
    zero size.
    """
    ahead = unit(forces)
    aside = rotate(ahead, np.pi / 2)
    length = length_per_newton * np.linalg.norm(forces, axis=1)
    head = np.minimum(5 * width, length)
    back = np.stack([length, head, head, 0 * head, head, head, length], axis=1)
    side = np.array([0.5, 0.5, 1.6, 0.0, -1.6, -0.5, -0.5]) * head[:, None] / 5
    outline = tips[:, None] - back[..., None] * ahead[:, None] + side[..., None] * aside[:, None]
    return np.asarray(outline)


def number_places(picture: Picture, first: IntArray, size: float) -> Array:
    """Return places of the numbers of blades (blade, 2) [m]: beside the tip of a beam, and on a
    blade in space, where the place beside it can be on another one, below the middle of the contact
    nodes that are seen; NaN where none is seen.

    Args:
        picture: the stage at a record.
        first: number of the first contact node of each blade, (blade,).
        size: distance from the middle to the edge of the picture [m].
    """
    seen = ~picture.hidden[: len(picture.tips), None]
    count = np.add.reduceat(1.0 * seen, first)
    sums = np.add.reduceat(np.where(seen, picture.tips - picture.shaft, 0.0), first)
    span = sums / np.where(count > 0.0, count, np.nan)
    place = picture.shaft + NUMBER_PLACE * span
    if picture.solids:
        return np.asarray(place)
    aside = rotate(unit(span), np.pi / 2)
    reach = min(float(np.max(np.nan_to_num(np.abs(span)), initial=0.0)), size)
    return np.asarray(place + NUMBER_ASIDE * reach * aside)


def widened(sides: Array, right: float, left: float) -> Array:
    """Return the sides of ribbons (line, station, 2, 2), widened by `right` and `left` [m]."""
    across = unit(sides[:, :, 1] - sides[:, :, 0])
    return np.stack([sides[:, :, 0] - right * across, sides[:, :, 1] + left * across], axis=2)
