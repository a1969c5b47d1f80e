"""The stage: what loads, contact, studies and results need of a bladed disk in its casing.

It has two sources: finite elements of beams (`beams`), and the matrices of a file (`matrices`).
`build` is the only module that knows which of them a case has.
"""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder, Harmonic
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.bearings import Bearings
from bladewhirl.models.stage.coating import coating_of
from bladewhirl.models.stage.cone import in_cone
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades
from bladewhirl.models.stage.foreshortening import Foreshortening
from bladewhirl.models.stage.kept_modes import KeptModes
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.ring import Ring
from bladewhirl.models.stage.varying_speed import ComplianceOverSpeeds
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.models.stage.wall_coating import WallCoating
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

LOWEST = 12  #: number of frequencies listed for a body without cyclic symmetry


@dataclass(frozen=True, kw_only=True)
class Turning:
    """Matrices and loads of a bladed disk whose speed varies, in its modes."""

    rotor: Rotating[FloatArray]  #: a copy at the speed of the stage, (modes, modes)
    patterns: Mapping[str, FloatArray]
    """Loads of the rotation in the steady state at the speed of the stage, (modes,), by the names
    of their factors, see `Load`."""
    factor: FloatArray = field(default_factory=lambda: np.ones(1))
    """Factor on the stiffness of each copy, (copies,)."""


class Basis(NamedTuple):
    """Number of modes of a reduction."""

    key: str  #: key of the case that gives the number
    used: int  #: number used, which may have one more to complete a pair


@dataclass(frozen=True, kw_only=True)
class BladeStiffness:
    """Stiffness of the blades of a tuned bladed disk on its modes."""

    blades: FloatArray  #: stiffness of each blade [1/s2], (blades, modes, modes)
    slope: FloatArray
    """Change of the stiffness with the square of the speed, (modes, modes)."""
    at_rest: FloatArray | None
    """Stiffness at rest [1/s2], (modes, modes), if all modes have the damping of the structure at
    rest; None if the modes at speed are damped."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Stage(Ring, ABC):
    """A bladed disk and its casing, reduced. The bladed disk consists of one or more copies, see
    `ReducedRotor`."""

    reference_frequency: float  #: frequency of which speeds are multiples [rad/s]
    kept: KeptModes  #: the modes selected for time integration
    blade: IntArray  #: number of the blade of each contact node of a copy, (nodes,)
    factor: FloatArray = field(default_factory=lambda: np.ones(1))
    """Factor on the stiffness of each copy, (copies,)."""
    omega: float | None = None  #: speed of rotation [rad/s]; that of the case if None

    def with_case(self, case: Case) -> "Stage":
        """Return the stage of a case that differs only in load, contact and march."""
        shaft = self.case.shaft  # its springs can follow from a required frequency
        case = case.model_copy(update={"shaft": shaft}).in_seconds(self.reference_frequency)
        return replace(self, case=case)

    @abstractmethod
    def at(self, omega: float) -> "Stage":
        """Return the stage at another speed of rotation [rad/s]."""

    def of_diameters(self, diameters: Collection[int]) -> "Stage":
        """Return a stage that need have only the modes of some nodal diameters at other speeds, see
        `at`; those of superelements that are equal sectors then take less time."""
        return self

    def check_speed(self, omega: float) -> None:
        """Check that the structure is stable at a speed of rotation [rad/s].

        Raises:
            CaseError: it is not.
        """

    @property
    def speed(self) -> float:
        """Speed of rotation Omega [rad/s], counter-clockwise."""
        if self.omega is not None:
            return self.omega
        return self.case.march.speed.rad_per_s(self.reference_frequency)

    @property
    def displacement_limit(self) -> float:
        """Displacement at which a march ends [m]; by default the length of a blade."""
        return self.case.march.displacement_limit or self.blade_length

    def to_superelement(self, kind: Literal["wheel", "sector", "blade"] = "wheel") -> Superelement:
        """Return the full model of a bladed disk of beams as a superelement, with the blade tips as
        contact nodes; see `write_superelement`.

        Args:
            kind: "wheel", without the springs of the shaft; "sector", of a disk of beams with equal
                sectors and a clamped centre; "blade", one blade clamped at its root.

        Raises:
            SuperelementError: there is no such sector or blade, or the bladed disk does not consist
                of beams.
        """
        raise SuperelementError("expected a bladed disk of beams: this one is a superelement")

    @property
    @abstractmethod
    def rotor(self) -> ReducedRotor:
        """The bladed disk in all of its modes."""

    @property
    def rotor_rest(self) -> FloatArray:
        """Modal forces of zero on the bladed disk, (modes,)."""
        return np.zeros(len(self.rotor.frequency))

    @property
    def casing_rest(self) -> FloatArray:
        """Modal forces of zero on the casing, (casing modes,)."""
        return np.zeros(len(self.reduced_casing.frequency))

    @cached_property
    def bodies(self) -> tuple[ReducedRotor, ReducedCasing]:
        """Bladed disk and casing in the modes of `kept`, in the axes of the wall."""
        kept = self.kept
        rotor, casing = self.rotor.take(kept.rotor), self.reduced_casing.take(kept.casing)
        return in_cone(rotor, casing, self.slope)

    def clearance_key(self, node: int) -> str:
        """Return the key of the clearance of a contact node of a copy."""
        return "casing.clearance"

    @property
    def slope(self) -> float | FloatArray:
        """Slope of the wall [rad]; under a contour that at each contact node, (nodes,)."""
        return 0.0

    @property
    @abstractmethod
    def blade_length(self) -> float:
        """Length of a blade [m]."""

    @property
    @abstractmethod
    def blade_angle(self) -> FloatArray:
        """Angle of each blade at t = 0 [rad], (copies, blades of a copy)."""

    @property
    @abstractmethod
    def axial_position(self) -> FloatArray:
        """Axial position of each contact node of a copy [m], (nodes,)."""

    @abstractmethod
    def footprint(self) -> FloatArray:
        """Return the arc that each contact node of a copy covers on the wall [m], (nodes,).

        Raises:
            CaseError: it does not follow from the geometry.
        """

    @cached_property
    def coating(self) -> WallCoating | None:
        """Coating of the wall; None if there is none.

        Raises:
            CaseError: see `coating_of`.
        """
        return coating_of(
            self.case,
            self.axial_position,
            self.rotor.contact_radius,
            self.footprint,
            self.reduced_casing.radius,
        )

    def recess_at(self, speed: float) -> FloatArray:
        """Return `ReducedRotor.tip_recess` at a speed [rad/s]."""
        return self.rotor.tip_recess

    def answer(self, along: FloatArray, speed: float) -> FloatArray:
        """Return the radial displacement of each tip due to a steady unit force at the centre
        [m/N], (tips,).

        Args:
            along: direction of the force in rotating axes, (2,).
            speed: speed of rotation [rad/s].
        """
        rotor = self.rotor
        return rotor.at_tips(rotor.tip_radial, (along @ rotor.centre) / rotor.stiffness)

    def pushed(self, load: Harmonic) -> FloatArray:
        """Return the modal forces of unit forces along x and y of rotating axes where a harmonic
        force acts [kg^-1/2], (2, modes)."""
        return self.rotor.centre

    @abstractmethod
    def unit_forces(self, load: EngineOrder) -> FloatArray:
        """Return the modal forces of an engine order with a unit amplitude on each blade of a copy,
        (blades, modes)."""

    def static_answer(self, load: EngineOrder) -> FloatArray | None:
        """Return the displacements of the contact nodes of a copy with the factor 1 by the modes
        that are left out, for `unit_forces` [m/N], (blades, 3 * nodes); None without them."""
        return None

    @property
    def has_centre(self) -> bool:
        """True if the bladed disk has a node at its centre."""
        return True

    @property
    def bearings(self) -> Bearings | None:
        """Bearings, whose stiffness is not part of that of the rotor; None without them."""
        return None

    @property
    def steady_centre(self) -> FloatArray:
        """Displacement of the centre in the state of steady rotation [m], (2,)."""
        return np.zeros(2)

    @property
    @abstractmethod
    def inertia(self) -> float:
        """Moment of inertia about the axis of all that turns, as far as it is known, in the state
        of steady rotation [kg m2]."""

    @property
    @abstractmethod
    def turning(self) -> Turning:
        """The bladed disk, on which the rotation acts, for speeds that vary."""

    def compliance_over(self, course: SpeedCourse) -> ComplianceOverSpeeds | None:
        """Return the flexibility of massless contact nodes at the speeds of a course, in the axes
        of the wall; None if it does not change."""
        return None

    @property
    def foreshortening(self) -> Foreshortening | None:
        """Foreshortening of the blades in the modes of `kept`; None if the case has none."""
        return None

    @abstractmethod
    def without_blades(self, given: ContactProblem, turning: ContactProblem) -> LostBlades:
        """Return the contact problem after the loss of blades of the case.

        Args:
            given: contact problem at `speed`.
            turning: the same with the speed over time of the case.

        Raises:
            CaseError: the loss is not possible.
        """

    @abstractmethod
    def blade_stiffness(self, omega: float) -> "tuple[Stage, BladeStiffness]":
        """Return the stage with equal blades at a speed [rad/s], and their stiffness on its modes.

        Raises:
            UserError: the stiffness of the blades is not known.
        """

    def own_faults(self) -> Iterator[Fault]:
        """Yield errors that prevent time integration and that not every stage can have."""
        yield from ()

    @property
    @abstractmethod
    def fewer_modes(self) -> str:
        """Changes of the case that raise the critical time step, in words."""

    @property
    @abstractmethod
    def basis(self) -> Basis:
        """Modes to which the bladed disk, or the shaft, is reduced."""

    @property
    def frequency_error(self) -> Mapping[str, float]:
        """Largest relative error of the frequencies by the reduction, by family; empty if it is not
        known."""
        return {}

    def own_hints(self) -> Iterator[str]:
        """Yield warnings about implausible values that not every stage can have, one line each."""
        yield from ()

    @property
    def symmetry(self) -> Mapping[str, str]:
        """Symmetry of each body in words; empty if the march does not use it."""
        return {}

    def rate(self, rad_per_s: float) -> dict[str, float]:
        """Return an angular frequency or speed [rad/s] by unit: rad_per_s, hz (turns or cycles per
        second), rpm, and normalised (multiples of the reference frequency)."""
        return {
            "rad_per_s": float(rad_per_s),
            "hz": float(rad_per_s / (2.0 * np.pi)),
            "rpm": float(rad_per_s * 30.0 / np.pi),
            "normalised": float(rad_per_s / self.reference_frequency),
        }

    def listed(self, nodal_diameter: int, frequency: float, purity: float) -> dict[str, Any]:
        """Return a mode for JSON: its dominant nodal diameter (-1 without sectors), its frequency
        [rad/s] and its purity, the share of this nodal diameter."""
        rate = self.rate(frequency)
        return {"nodal_diameter": nodal_diameter, "frequency": rate, "purity": purity}

    @property
    def own_loads(self) -> tuple[Load, ...]:
        """Loads besides the excitations of the case, in all modes."""
        return ()

    @property
    def start(self) -> Start | None:
        """State at the start; None if `loads.initial_state` gives it."""
        return None

    @property
    @abstractmethod
    def own_properties(self) -> dict[str, Any]:
        """Properties by name, for JSON, that not every stage has."""

    @property
    @abstractmethod
    def node_sets(self) -> Mapping[str, IntArray]:
        """Numbers of nodes by the name of their set."""

    @property
    def attributes(self) -> Mapping[str, str | float | int]:
        """Attributes of a result that describe the stage."""
        return {
            **self.case.material.lowest_limits,
            "casing_radius": self.reduced_casing.radius,
            "tip_radius": float(self.rotor.contact_radius.max()),
            "blade_length": self.blade_length,
        }

    @cached_property
    def arrays(self) -> StageArrays:
        """Arrays of the stage in a result, with the modes selected for time integration."""
        arrays, march = self.shown_arrays, self.case.march
        changes = sum(
            each is not None for each in (self.case.blade_loss, self.case.shaft.fuse_force)
        )
        if changes:
            arrays = replace(arrays, sudden_changes=changes)
        if not march.varies:
            return arrays
        arrays = replace(arrays, modes_speed=self.speed, **self.over_speeds)
        if march.drive is not None:
            drive = march.drive
            arrays = replace(arrays, drive_torque=drive.torque, drive_loss=drive.loss)
        return arrays

    @property
    @abstractmethod
    def shown_arrays(self) -> StageArrays:
        """Arrays that show and measure the motion of the stage."""

    @property
    def over_speeds(self) -> dict[str, Any]:
        """Further arrays of a stage whose speed varies, by name."""
        return {}

    def fields(self, coordinates: FloatArray) -> FloatArray:
        """Return the motion of the bladed disk, given in modal coordinates, in coordinates that do
        not depend on the speed."""
        return coordinates

    def coordinates(self, fields: FloatArray) -> FloatArray:
        """Return the modal coordinates of a motion of the bladed disk, see `fields`."""
        return fields
