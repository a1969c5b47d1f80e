"""Bladed disk and casing in their modes: what modal studies need, whatever the disk was built
from."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.casing import CasingModel
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modes import ListedModes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.touching import Tips
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.models.structure.waves import Waves

FAMILIES = 12  #: default number of modes of each nodal diameter of a superelement

UNEQUAL_SECTORS = (
    "expected equal sectors, without bladed_disk.mistuning, on equal shaft"
    ' springs or on springs with shaft.frame = "static"; each wave then has one nodal'
    " diameter"
)
"""Error of studies of waves, which need a nodal diameter of each wave."""


@dataclass(frozen=True, kw_only=True)
class ModalModel(ABC):
    """Bladed disk and casing in their modes, at any speed of rotation."""

    of_lines: ClassVar[bool] = False  #: true if the bladed disk consists of lines

    case: Case
    reference_frequency: float
    """Lowest natural frequency of the bladed disk at rest, with a free centre [rad/s]."""
    casing: CasingModel | None  #: finite element model of the casing; None for a rigid wall
    casing_modes: LabelledModes  #: modes of the casing; none for a rigid wall

    @property
    def speed(self) -> float:
        """Speed of rotation of the case [rad/s], counter-clockwise."""
        return self.case.march.speed.rad_per_s(self.reference_frequency)

    def covering(self, highest: float) -> "ModalModel":
        """Return the model for speeds up to the highest one [rad/s], on which a basis of modes may
        depend; what takes long is computed."""
        return self

    @property
    @abstractmethod
    def effects(self) -> Effects:
        """Effects of the rotation that act on the bladed disk."""

    @property
    def turns(self) -> bool:
        """True if the frequencies depend on the speed of rotation."""
        return self.effects != "none"

    @property
    @abstractmethod
    def centre(self) -> str:
        """State of the centre as the case requires it, "free" or "clamped"."""

    @property
    @abstractmethod
    def by_centre(self) -> Mapping[str, ListedModes]:
        """Modes of the bladed disk at the speed of the case, by the state of its centre."""

    @property
    @abstractmethod
    def listed_modes(self) -> ListedModes:
        """Modes of the bladed disk at the speed of the case, with a free or a clamped centre as the
        case requires."""

    @property
    def has_surface(self) -> bool:
        """True if films can show the bladed disk: as lines, or as triangles between its points."""
        return self.of_lines

    @abstractmethod
    def shown_arrays(self, disk_modes: IntArray, casing_modes: IntArray) -> StageArrays:
        """Return the arrays of the stage with some modes of both bodies. The bladed disk is one
        copy: the whole structure, or one of several separate blades.

        Args:
            disk_modes: numbers of modes among `listed_modes`; a whirling mode has two real fields.
            casing_modes: numbers of modes among `casing_modes`; none with a rigid wall.

        Raises:
            UserError: the points of the bladed disk are not known.
        """

    def tip_motions(self, modes: ListedModes) -> tuple[str, ...]:
        """Return what the tip of a blade mostly does in each mode, see `tip_motion`; "" if it is
        not known.

        Args:
            modes: modes of the bladed disk from `by_centre`.
        """
        return ("",) * len(modes.family)

    @property
    @abstractmethod
    def disk_modes(self) -> LabelledModes:
        """Modes of the bladed disk without Coriolis forces, with a free or a clamped centre as the
        case requires."""

    @property
    @abstractmethod
    def waves(self) -> Mapping[int, Waves]:
        """Waves of each nodal diameter, with a free or a clamped centre as the case requires.

        Raises:
            UserError: the sectors of the bladed disk differ.
        """

    @property
    @abstractmethod
    def tips(self) -> Mapping[int, Tips]:
        """Contact nodes of each nodal diameter, on the coordinates of `waves`.

        Raises:
            UserError: the sectors of the bladed disk differ.
        """

    @property
    @abstractmethod
    def shaft_waves(self) -> Waves:
        """Waves of nodal diameter 1 with a free centre on the springs of the shaft.

        Raises:
            UserError: the sectors differ, or the bladed disk has no centre that moves, or its
                critical speeds do not follow from its matrices.
        """

    @property
    @abstractmethod
    def shaft_block(self) -> Waves:
        """Waves of nodal diameter 1 with a free centre without the springs of the shaft. The last
        coordinate is the whirl of the centre along (1, i)/sqrt(2).

        Raises:
            UserError: the sectors differ, or the bladed disk has no centre that moves.
        """

    @abstractmethod
    def growth(self, omegas: FloatArray) -> FloatArray | None:
        """Return the largest static growth of a tip at each speed [m], (speeds,); None if it is not
        known."""

    @property
    @abstractmethod
    def clearance_gone(self) -> float:
        """Speed at which the growth of the tips equals the clearance [rad/s]; nan if not known."""

    @property
    def hints(self) -> tuple[str, ...]:
        """Warnings about what the modes leave out, one line each."""
        return ()
