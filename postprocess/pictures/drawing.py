"""Geometry of a picture of the stage: beams and wall as filled ribbons, contact as arrows.

Points are taken from `EnlargedStage` and transformed to the axes of the picture.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import rotate, unit
from bladewhirl.postprocess.fields import kinematics
from bladewhirl.postprocess.fields.enlarged import LARGE_DISPLACEMENT, EnlargedStage
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.rigid_wall import with_wall
from bladewhirl.postprocess.pictures.choices import Field, Frame
from bladewhirl.postprocess.pictures.colouring import Stations, colouring
from bladewhirl.postprocess.pictures.symbols import StageSymbols, Symbols

BEAM_STATIONS = 6  #: number of straight pieces of a beam
RING_STATIONS = 720  #: smallest number of straight pieces of the casing
MARK = 0.7  #: radius of the mark on the first blade, relative to the tip radius


@dataclass(frozen=True, kw_only=True)
class Ribbon:
    """Strips of quadrilaterals along beams or along the wall."""

    sides: Array  #: points on both sides (line, station, side, 2) [m]
    values: Array  #: true values of the field at the sides (line, station, side)


@dataclass(frozen=True, kw_only=True)
class Picture:
    """Stage at one record. Positions are as drawn, with displacements and clearance multiplied by
    the exaggeration; values of fields and forces are true."""

    time: float  #: [s]
    rotor: Ribbon
    casing: Ribbon
    shaft: Array  #: drawn centre (2,) [m]
    tips: Array  #: drawn tips (blade, 2) [m]
    mark: Array  #: drawn mark on the first blade (2,) [m], which shows the rotation
    symbols: Symbols  #: springs, supports, masses
    forces: Array  #: true contact force on each tip (blade, 2) [N], in the axes of the picture


class Drawing:
    """Pictures of the stage at chosen records.

    Args:
        dataset: a result.
        records: numbers of the records.
        exaggeration: factor of displacements and clearance; a round number is chosen when None.
        frame: axes of the picture: in "static" axes the rotor turns, in "rotating" axes the casing
            turns backward.
        colour: field that colours beams and wall, see `colouring`.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        exaggeration: float | None = None,
        frame: Frame = "static",
        colour: Field = "displacement",
    ) -> None:
        if frame not in ("static", "rotating"):
            raise ViewError(f'frame must be "static" or "rotating", got {frame!r}')
        dataset = with_wall(dataset)
        per_element = -(-RING_STATIONS // dataset.sizes["casing_node"])
        self._stage = stage = EnlargedStage(
            dataset, records, factor=exaggeration, per_line=BEAM_STATIONS, per_element=per_element
        )
        self.records = records
        self.frame = frame
        self.exaggeration = stage.factor
        self.largest_displacement = stage.largest_displacement
        self.nodes = stage.nodes
        self.times = dataset["time"].values[records]
        angle = stage.turns
        self._rotor_turn, self._casing_turn = (
            (angle, 0 * angle) if frame == "static" else (0 * angle, -angle)
        )
        self._forces = kinematics.contact_forces(dataset, records, rotating=frame == "rotating")
        self._tips = dataset["tip_node"].values
        from_mark = stage.line.reshape(-1, 2) - MARK * stage.nodes[self._tips[0]]
        self._mark = int(np.argmin(np.sum(from_mark**2, axis=1)))
        self._symbols = StageSymbols(dataset, stage.angle, stage.outward_reach())
        self.colouring = colouring(
            dataset, colour, records, Stations(BEAM_STATIONS, per_element), frame == "rotating"
        )

    @property
    def largest_force(self) -> float:
        """Largest contact force in the records [N]."""
        return float(np.linalg.norm(self._forces, axis=-1).max())

    def linear_limit(self) -> float | None:
        """Return the displacement [m] at which a linear model has an error of a tenth; None if all
        displacements at these records are smaller."""
        bent = self._stage.rotor_displacement - self._stage.centre[:, None]
        limit = LARGE_DISPLACEMENT * self._stage.tip_radius
        return limit if np.linalg.norm(bent, axis=-1).max() > limit else None

    def reach(self) -> tuple[float, float]:
        """Return the largest distance of the drawn stage, and of tips in contact, from the origin
        [m]."""
        stage = contact = 0.0
        for index in range(len(self)):
            seen = self.picture(index)
            touching = seen.tips[np.any(seen.forces, axis=1)]
            contact = max(contact, float(np.max(np.sum(touching**2, axis=-1), initial=0.0)))
            for shape in (seen.rotor.sides, seen.casing.sides, *seen.symbols):
                stage = max(stage, float(np.max(np.sum(shape**2, axis=-1), initial=0.0)))
        return float(np.sqrt(stage)), float(np.sqrt(contact))

    def __len__(self) -> int:
        return len(self.records)

    def picture(self, index: int) -> Picture:
        """Return the stage at the index-th of the chosen records."""
        stage, turned = self._stage, self._rotor_turn[index]
        line, nodes, wall = stage.rotor_line(index), stage.rotor_nodes(index), stage.wall(index)
        centre = stage.factor * stage.centre[index]
        closed = np.append(np.arange(len(wall)), 0)  # the first station is repeated at the end
        return Picture(
            time=float(self.times[index]),
            rotor=Ribbon(
                sides=rotate(stage.rotor_sides(index, line, wall), turned),
                values=self.colouring.rotor[index],
            ),
            casing=Ribbon(
                sides=rotate(wall[closed], self._casing_turn[index])[None],
                values=self.colouring.casing[index][closed][None],
            ),
            shaft=rotate(centre, turned),
            tips=rotate(nodes[self._tips], turned),
            mark=rotate(line.reshape(-1, 2)[self._mark], turned),
            symbols=self._symbols.together(
                self._symbols.drawn(
                    wall[:, 1], stage.wall_at_rest(), centre, nodes, float(stage.turns[index])
                ),
                self._casing_turn[index],
                turned,
            ),
            forces=self._forces[index],
        )


def arrows(tips: Array, forces: Array, length_per_newton: float, width: float) -> Array:
    """Return outlines (blade, 7, 2) of arrows that end on the tips and point along the forces.

    Corners 0, 1, 5 and 6 belong to the shaft of the arrow, corners 2, 3 and 4 to its head, which is
    up to five widths long. The arrow of a blade without contact has zero size.
    """
    ahead = unit(forces)
    aside = rotate(ahead, np.pi / 2)
    length = length_per_newton * np.linalg.norm(forces, axis=1)
    head = np.minimum(5 * width, length)
    back = np.stack([length, head, head, 0 * head, head, head, length], axis=1)
    side = np.array([0.5, 0.5, 1.6, 0.0, -1.6, -0.5, -0.5]) * width
    outline = tips[:, None] - back[..., None] * ahead[:, None] + side[:, None] * aside[:, None]
    return np.asarray(outline)


def widened(sides: Array, right: float, left: float) -> Array:
    """Return the sides of ribbons (line, station, 2, 2), widened by `right` and `left` [m]."""
    across = unit(sides[:, :, 1] - sides[:, :, 0])
    return np.stack([sides[:, :, 0] - right * across, sides[:, :, 1] + left * across], axis=2)
