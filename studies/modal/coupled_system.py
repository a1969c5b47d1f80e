"""Coupled modes of a stage for a stability study.

If each mode has one nodal diameter, the equations of different nodal diameters are uncoupled, and
have constant coefficients in the frame that turns at half speed: `EvenSystem`. Otherwise waves of
different nodal diameters are coupled, and the coefficients are constant in rotating axes or
periodic in all frames: `System`. `couple` chooses between the two classes.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.equations import CoupledEquations
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.models.coupling.stage_modes import StageModes, at_speed, stage_modes
from bladewhirl.models.coupling.stage_waves import coupled_waves, standing_obstacles
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.mode_names import ALL, SIX, chosen_modes
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.rotation.at_speed import lowest_critical_speed
from bladewhirl.models.rotation.internal_growth import internal_growth
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.solvers.stability.floquet import exponents
from bladewhirl.solvers.stability.growth import Progress, growth_rate, is_unstable


@dataclass(frozen=True, kw_only=True)
class System:
    """Coupled modes of a stage, with the options of a stability study."""

    modes: CouplingModes | CoupledEquations  #: chosen modes
    damped: bool  #: whether the damping of the case is included
    physical: bool  #: whether modes have physical amplitudes, not unit amplitudes
    reference: float  #: reference frequency by which speeds are normalised [rad/s]
    case: str = ""  #: title of the case

    def spectrum(self, omega: float, kappa: float) -> ComplexArray:
        """Compute eigenvalues or Floquet exponents [1/s], the fastest growing first, at a speed
        [rad/s] and a spring stiffness [N/m]."""
        return exponents(self.modes, speed=omega, kappa=kappa)

    def growth(
        self, omegas: FloatArray, kappas: FloatArray, progress: Progress | None = None
    ) -> FloatArray:
        """Compute growth rates [1/s] at speeds [rad/s] and stiffnesses [N/m], (kappa, omega).

        Growth rates are exactly zero where undamped modes do not grow.
        """
        return growth_rate(self.modes, speed=omegas, kappa=kappas[:, None], progress=progress)

    def rotor_alone(self, omega: float) -> dict[str, Any]:
        """Compute the stability of the uncoupled bladed disk at a speed [rad/s], see `EvenSystem`;
        empty where it is not computed."""
        return {}

    def options(self) -> dict[str, object]:
        """Return the options for reports."""
        return {
            "modes": list(self.modes.name),
            "damped": self.damped,
            "pi": self.modes.with_pi,
            "amplitude": "physical" if self.physical else "paper",
            "reference_frequency": self.reference,
        }

    def attributes(self) -> dict[str, object]:
        """Return options and case as attributes of a Dataset; NetCDF has no booleans."""
        options = self.options() | {"case": self.case}
        return {name: int(v) if isinstance(v, bool) else v for name, v in options.items()}


@dataclass(frozen=True, kw_only=True)
class EvenSystem(System):
    """System whose modes have a single nodal diameter each."""

    modes: CouplingModes  #: chosen modes
    stage: StageModes  #: chosen modes, with finite elements
    all_modes: StageModes  #: all modes that springs can couple, with physical amplitudes
    disk: BladedDiskModel | None = None
    """Bladed disk with the matrices of its rotation; None without rotation effects."""

    @property
    def six(self) -> CouplingModes:
        """Six modes of the paper; their amplitudes are physical or unit, as in `modes`."""
        six = self.all_modes.six_modes()
        return (six if self.physical else six.with_unit_amplitudes()).modes

    def options(self) -> dict[str, object]:
        """Return the options for reports, including rotation effects if the case has any."""
        effects = self.stage.modal.case.rotation.effects
        return super().options() | ({} if effects == "none" else {"rotation_effects": effects})

    def rotor_alone(self, omega: float) -> dict[str, Any]:
        """Compute the stability of the uncoupled bladed disk at a speed [rad/s].

        Returns:
            an empty dictionary without rotation effects; otherwise critical_speed (normalised),
            above which the stiffness matrix is indefinite; rotor_growth_rate [1/s] with
            rotor_nodal_diameter; holding_damping [N s/m], the damping of each of two static
            bearings that stabilises a growing disk (None if bearings cannot); and waves_met, true
            for growth without damping.
        """
        if self.disk is None:
            return {}
        case = self.stage.modal.case
        effects = case.rotation.effects
        damped, undamped = (
            internal_growth(self.disk, omega, effects, damping_ratio=ratio)
            for ratio in (case.damping.ratio if self.damped else 0.0, 0.0)
        )
        critical = lowest_critical_speed(self.disk.structure) / self.reference
        return {
            "critical_speed": critical if np.isfinite(critical) else None,
            "rotor_growth_rate": damped.rate,
            "rotor_nodal_diameter": damped.nodal_diameter,
            "holding_damping": damped.holding,
            "waves_met": bool(is_unstable(undamped.rate, omega)),
        }

    def of_diameter(self, k: int) -> "EvenSystem":
        """Return the system of the modes with nodal diameter k."""
        part = self.stage.take(np.flatnonzero(self.modes.nodal_diameter == k))
        return replace(self, stage=part, modes=part.modes)


def couple(
    modal: ModalModel,
    *,
    modes: str,
    damped: bool,
    with_pi: bool,
    physical: bool,
    chart: bool = False,
) -> System:
    """Couple modes of a full stage.

    Args:
        modal: finite element models with all their modes.
        modes: "six", "all" or names as in `reduction.modes`.
        damped: whether the damping of the case is included.
        with_pi: whether the factor pi of Eq. (8) is kept.
        physical: whether modes have physical amplitudes; otherwise all amplitudes are equal.
        chart: whether several points are to be computed, which requires a frame with constant
            coefficients.

    Raises:
        UserError: the stage lacks a mode, springs couple no chosen mode, equal amplitudes are
            requested for modes with several nodal diameters, or a chart for a periodic system.
    """
    one_each = modal.casing.structure.is_cyclic and not np.any(
        modal.beams.blade_columns(modal.disk_modes.column) < 0
    )
    obstacles = standing_obstacles(modal, damped=damped)
    if chart and obstacles:
        options = "--speed and --kappa" if one_each else "--speed, --kappa and --physical"
        raise UserError(
            "stability: a chart requires constant coefficients in some frame, but"
            f" {', '.join(obstacles)}; {options} compute a single point"
        )
    effects, shaft = modal.case.rotation.effects, modal.case.shaft
    even = shaft.clamped or len({*shaft.stiffnesses}) == len({*shaft.dampings}) == 1
    uneven = "blades differ" if even else "the springs or dampers of the shaft are unequal"
    if effects != "none" and (obstacles or not one_each):
        raise UserError(
            "stability: expected equal blades, equal shaft springs and an axisymmetric casing"
            f' for rotation.effects = "{effects}"; here'
            f" {', '.join(obstacles or (uneven,))}"
        )
    if one_each and not obstacles:
        return couple_even(modal, modes=modes, damped=damped, with_pi=with_pi, physical=physical)
    if not (physical or one_each):
        raise UserError(
            "stability: expected --physical (in Python physical=True) where blades differ or"
            " shaft or casing are uneven; by default all modes get the same amplitude, which"
            " requires that each mode has a single nodal diameter"
        )
    try:
        equations = coupled_waves(modal, modes=modes, damped=damped, physical=physical)
    except ValueError as error:
        raise UserError(f"--modes {error}") from None
    equations = replace(equations, with_pi=with_pi)
    return System(
        modes=equations,
        damped=damped,
        physical=physical,
        reference=modal.reference_frequency,
        case=modal.case.title,
    )


def couple_even(
    modal: ModalModel, *, modes: str, damped: bool, with_pi: bool, physical: bool
) -> EvenSystem:
    """Couple modes of a stage with cyclic symmetry; see `couple`.

    With rotation effects the matrices at speed are projected onto the modes at rest.
    """
    case, disk = modal.case, None
    if case.rotation.effects == "centrifugal":  # couple modes at rest, not at speed
        effects = case.rotation.model_copy(update={"effects": "none"})
        at_rest = modal_model(case.model_copy(update={"rotation": effects}))
        modal = replace(at_rest, case=case)
    try:
        all_modes = stage_modes(modal, damping_ratio=modal.case.damping.ratio if damped else 0.0)
    except ValueError as error:
        raise UserError(f"stability: {error}") from None
    all_modes = replace(all_modes, modes=replace(all_modes.modes, with_pi=with_pi))
    if case.rotation.effects != "none":
        disk = replace(modal.beams, structure=rotation_matrices(modal.beams))
        all_modes = at_speed(all_modes, disk.structure.under(case.rotation.effects))
    stage = _chosen(all_modes, modes)
    stage = stage if physical else stage.with_unit_amplitudes()
    return EvenSystem(
        modes=stage.modes,
        stage=stage,
        all_modes=all_modes,
        disk=disk,
        damped=damped,
        physical=physical,
        reference=modal.reference_frequency,
        case=case.title,
    )


def _chosen(all_modes: StageModes, text: str) -> StageModes:
    if text == ALL:
        return all_modes
    if text == SIX:
        try:
            return all_modes.six_modes()
        except ValueError as error:
            raise UserError(f"--modes six: {error}") from None
    disk, casing = all_modes.modal.disk_modes, all_modes.modal.casing_modes
    try:
        numbers = chosen_modes(text, disk.named, casing.named, all_modes.radial)
    except ValueError as error:
        raise UserError(f"--modes {error}") from None
    coupled = all_modes.among(*numbers)
    if not coupled.size:
        families = dict.fromkeys(name.split()[0] for name in all_modes.modes.name)
        names = ", ".join(["six", "all", *families])
        raise UserError(
            f"--modes {text}: expected modes that can be coupled by springs, from {names}"
        )
    return all_modes.take(coupled)
