"""Properties of a stage: masses, frequencies, time step, speed, loads, sizes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import W
from bladewhirl.models.case.excitation import CasingDistortion, Imbalance
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.elements.cyclic import NO_COLUMN
from bladewhirl.models.modal.modes import Modes
from bladewhirl.models.stage.build import marched_bodies
from bladewhirl.models.stage.contact_problem import critical_time_step
from bladewhirl.models.stage.loads import closing_unbalance, imbalance_force, radial_mode, unbalance
from bladewhirl.models.stage.stage import Stage
from bladewhirl.solvers.march.recorder import description_bytes, result_bytes

TURN = 2.0 * np.pi

LOWEST = 12
"""Number of frequencies listed for a body without cyclic symmetry."""


@dataclass(frozen=True, kw_only=True)
class Rate:
    """An angular frequency or speed, in common units."""

    rad_per_s: float
    hz: float  #: turns or cycles per second
    rpm: float
    normalised: float  #: multiples of the reference frequency


@dataclass(frozen=True, kw_only=True)
class Mode:
    """Natural frequency of a mode, its dominant nodal diameter, and the share of this nodal
    diameter."""

    nodal_diameter: int  #: -1 without sectors
    frequency: Rate
    purity: float = 1.0


@dataclass(frozen=True, kw_only=True)
class ReductionFigures:
    """Size and accuracy of the Craig-Bampton reduction of the bladed disk."""

    boundary: dict[str, int]  #: number of boundary degrees of freedom, by node set
    #: number used; with complete pairs, possibly one more than requested
    fixed_interface_modes: int
    wanted: int  #: number of fixed-interface modes requested
    internal: int  #: number of internal degrees of freedom of the full model
    modes: int  #: number of modes of the reduced model
    marched: dict[str, int]  #: number of modes in a march, by body
    frequency_error: dict[str, float]  #: largest relative error to the full model, by family


@dataclass(frozen=True, kw_only=True)
class ImbalanceFigures:
    """The load of an imbalance at the case's speed."""

    unbalance: float  #: m e [kg m]
    force: float  #: m e Omega^2 [N]
    closing: float  #: share of the clearance closed by the static response, at the nearest tip


MARCHES = {True: "harmonic by harmonic", False: "by dense products"}
"""Method of the march for a body, by whether its cyclic symmetry is used."""


@dataclass(frozen=True, kw_only=True)
class DistortionFigures:
    """The casing mode that is loaded by a distortion."""

    frequency: Rate
    static_displacement: float  #: largest radial displacement under the constant force [m]


@dataclass(frozen=True, kw_only=True)
class StageProperties:
    """Properties of a stage that follow from its case."""

    bladed_disk_mass: float  #: mass of the bladed disk [kg]
    bladed_disk_parts: dict[str, float]  #: mass of the beams of each part, and point masses [kg]
    casing_mass: float  #: mass of the casing with its struts [kg]
    reference_frequency: Rate  #: lowest frequency of the full bladed disk with free centre, at rest
    speed: Rate
    rotation_effects: str  #: "none", or the effects included in the frequencies below
    bladed_disk: tuple[Mode, ...]
    """Lowest mode of each nodal diameter in the full model; with unequal sectors the lowest
    modes."""
    shaft_stiffness: tuple[float, float] | None  #: springs along x and y [N/m]; None if clamped
    suspension: Rate | None
    """Lower frequency of the suspension pair, which at speed is named as at rest; None if
    clamped."""
    suspension_spring_share: float | None  #: share of the shaft springs in its strain energy
    casing: tuple[Mode, ...]  #: lowest mode of each nodal diameter
    reduction: ReductionFigures
    symmetry: dict[str, str]  #: symmetry of each body, as text
    cyclic: dict[str, bool]  #: whether a body is marched by harmonics (or by dense products)
    critical_time_step: float  #: critical time step [s]
    dt_over_critical: float  #: ratio of the time step to the critical time step
    steps: int
    records: int
    result_bytes: int  #: approximate size of result.nc [bytes]
    imbalance: ImbalanceFigures | None
    distortion: DistortionFigures | None


def stage_properties(stage: Stage) -> StageProperties:
    """Compute masses, frequencies, time step, loads and sizes of a stage.

    Raises:
        CaseError: a property exceeds the largest float.
    """
    with numbers_within_reach(stage.case):
        return _properties(stage)


def _properties(stage: Stage) -> StageProperties:
    case, disk, modes = stage.case, stage.disk, stage.reduction.modes
    casing, boundary = stage.casing, stage.boundary_sets
    pair = [mode for mode, name in enumerate(stage.disk_family) if name == "suspension"]
    rotor, wall = marched_bodies(stage)
    critical = critical_time_step(rotor, wall, stage.kept.springs)
    records = case.march.timing.records
    kept = {name: len(dofs) for name, dofs in boundary.items()}
    return StageProperties(
        bladed_disk_mass=disk.model.mass,
        bladed_disk_parts=disk.model.part_masses,
        casing_mass=casing.mass,
        reference_frequency=_rate(stage, stage.reference_frequency),
        speed=_rate(stage, stage.speed),
        rotation_effects=case.rotation.effects,
        bladed_disk=_lowest_of_disk(stage),
        shaft_stiffness=None if case.shaft.clamped else case.shaft.springs,
        suspension=_rate(stage, modes.frequency[pair[0]]) if pair else None,
        suspension_spring_share=float(modes.spring_share[pair[0]]) if pair else None,
        casing=_lowest_of_casing(stage),
        reduction=ReductionFigures(
            boundary=kept,
            fixed_interface_modes=stage.reduction.kept,
            wanted=case.reduction.fixed_interface_modes,
            internal=disk.structure.size - sum(kept.values()),
            modes=modes.count,
            marched={"bladed_disk": len(stage.kept.rotor), "casing": len(stage.kept.casing)},
            frequency_error=stage.frequency_error,
        ),
        symmetry=stage.symmetry,
        cyclic={"bladed_disk": rotor.by_harmonics, "casing": wall.by_harmonics},
        critical_time_step=critical,
        dt_over_critical=case.march.time_step / critical,
        steps=case.march.steps,
        records=records,
        result_bytes=description_bytes(stage.arrays)
        + result_bytes(len(stage.kept.rotor), len(stage.kept.casing), case.blades, records),
        imbalance=_imbalance(stage),
        distortion=_distortion(stage),
    )


def _rate(stage: Stage, rad_per_s: float) -> Rate:
    return Rate(
        rad_per_s=float(rad_per_s),
        hz=float(rad_per_s / TURN),
        rpm=float(60.0 * rad_per_s / TURN),
        normalised=float(rad_per_s / stage.reference_frequency),
    )


def _lowest_of_disk(stage: Stage) -> tuple[Mode, ...]:
    """Return the modes of the full model; mistuned modes get the names of those of the reduced
    model."""
    frequencies, modes = stage.disk_frequencies, stage.reduction.modes
    if NO_COLUMN not in frequencies:
        lowest = {k: values[0] for k, values in frequencies.items()}
        return tuple(Mode(nodal_diameter=k, frequency=_rate(stage, f)) for k, f in lowest.items())
    return _modes(stage, modes, range(min(LOWEST, modes.count)), frequencies[NO_COLUMN])


def _lowest_of_casing(stage: Stage) -> tuple[Mode, ...]:
    modes = stage.casing_modes  # in ascending order
    diameters, first = np.unique(modes.nodal_diameter, return_index=True)
    numbers = range(min(LOWEST, modes.count)) if diameters[0] < 0 else first.tolist()
    return _modes(stage, modes, numbers, modes.frequency)


def _modes(
    stage: Stage, modes: Modes, numbers: Iterable[int], frequencies: FloatArray
) -> tuple[Mode, ...]:
    """Return modes by number, with their frequencies [rad/s]."""
    return tuple(
        Mode(
            nodal_diameter=int(modes.nodal_diameter[i]),
            frequency=_rate(stage, frequencies[i]),
            purity=float(modes.purity[i]),
        )
        for i in numbers
    )


def _imbalance(stage: Stage) -> ImbalanceFigures | None:
    if not isinstance(stage.case.excitation, Imbalance):
        return None
    size = unbalance(stage)
    return ImbalanceFigures(
        unbalance=size,
        force=imbalance_force(stage),
        closing=size / closing_unbalance(stage, stage.speed),
    )


def _distortion(stage: Stage) -> DistortionFigures | None:
    """Return the static response; None without a distortion, or if the mode has no stiffness."""
    load = stage.case.excitation
    if not isinstance(load, CasingDistortion):
        return None
    number = radial_mode(stage, load.nodal_diameter)
    frequency = stage.casing_modes.frequency[number]
    if frequency == 0.0:
        return None
    wall = np.abs(stage.reduced_casing.nodal[:, W, number]).max()
    return DistortionFigures(
        frequency=_rate(stage, frequency),
        static_displacement=float(wall * load.modal_force / frequency**2),
    )
