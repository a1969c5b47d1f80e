"""The bladed disk of a stage as modal analysis needs it: with a free or a clamped centre, by nodal
diameter. Its sources are beams (`beam_disk`) and matrices (`stage.matrix_disk`)."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.plausibility import linear_hints
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modes import ListedModes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.touching import Tips
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.models.structure.waves import Waves

UNEQUAL_SECTORS = (
    "expected equal sectors, without bladed_disk.mistuning, on equal shaft"
    ' springs or on springs with shaft.frame = "static"; each wave then has one nodal'
    " diameter"
)
"""Error of studies of waves, which need a nodal diameter of each wave."""


@dataclass(frozen=True, kw_only=True)
class ModalDisk(ABC):
    """A bladed disk with one state of its centre, in its modes."""

    of_lines: ClassVar[bool] = False  #: true if the bladed disk consists of lines

    case: Case
    effects: Effects  #: effects of the rotation that act on the bladed disk

    @property
    @abstractmethod
    def labelled(self) -> LabelledModes:
        """Modes without Coriolis forces, at the speed of the case with "centrifugal" effects only,
        else at rest."""

    @property
    @abstractmethod
    def listed(self) -> ListedModes:
        """Modes at the speed of the case with all effects of the rotation."""

    @property
    @abstractmethod
    def waves(self) -> Mapping[int, Waves]:
        """Waves of each nodal diameter, on springs of the shaft with their mean stiffness.

        Raises:
            UserError: the sectors of the bladed disk differ.
        """

    @property
    @abstractmethod
    def centre(self) -> ComplexArray:
        """Displacement of the centre along x and y in the waves of nodal diameter 1, (2, n); (0, n)
        for a clamped centre."""

    @property
    @abstractmethod
    def tips(self) -> Mapping[int, Tips]:
        """Contact nodes of each nodal diameter, on the coordinates of `waves`.

        Raises:
            UserError: the sectors of the bladed disk differ.
        """

    @abstractmethod
    def arrays(self, modes: ListedModes, numbers: IntArray, wall: Mapping[str, Any]) -> StageArrays:
        """Return the arrays of a stage with some modes of the bladed disk, which is one copy: the
        whole structure, or one of several separate blades.

        Args:
            modes: `listed` or `labelled`.
            numbers: numbers of modes among them; each has `ListedModes.REAL_FIELDS` fields.
            wall: arrays of the wall by name.

        Raises:
            UserError: the points of the bladed disk are not known.
        """

    @property
    def tip_motions(self) -> tuple[str, ...]:
        """What the tip of a blade mostly does in each of the `listed` modes, see `tip_motion`; ""
        if it is not known."""
        return ("",) * self.listed.count

    @property
    def has_surface(self) -> bool:
        """True if films can show the bladed disk: as lines, or as triangles between its points."""
        return self.of_lines

    @property
    def beams(self) -> BladedDiskModel:
        """Finite elements of a bladed disk of beams, to which `labelled` belongs.

        Raises:
            UserError: the bladed disk does not consist of beams.
        """
        raise UserError("expected a bladed disk of beams: this one is a superelement")

    def growth(self, omegas: FloatArray) -> FloatArray | None:
        """Return the largest static growth of a tip at each speed [m], (speeds,); None if it is not
        known."""
        return None

    @property
    def clearance_gone(self) -> float:
        """Speed at which the growth of the tips equals the clearance [rad/s]; nan if not known."""
        return np.nan

    @property
    def hints(self) -> tuple[str, ...]:
        """Warnings about what the modes leave out, one line each."""
        return tuple(linear_hints(self.case))
