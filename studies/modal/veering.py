"""Frequencies against nodal diameter and shaft stiffness: Dataset, JSON document, figures."""

from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.fields import SMALLEST
from bladewhirl.models.inputs.units import ascending
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.stage.modal import Modelled, modal_model
from bladewhirl.solvers.stability.veering import ShaftVeering, shaft_veering, whirl_veering
from bladewhirl.studies.modal.modes import modes
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, facts, quantity, rows_of

STIFFNESSES, DECADES = 241, 3
"""Number of shaft stiffnesses, and decades below and above the stiffness of the case."""

BRANCHES = 5  #: number of modes drawn against the stiffness of the shaft

CLOSE_UP = 2  #: number of families of the second diagram, which also shows the suspension pair

MODE_LEVELS = ("centre", "family", "nodal_diameter")  #: coordinates that select a mode


def veering(
    case_or_stage: Modelled,
    *,
    families: int = 12,
    stiffnesses: FloatArray | None = None,
) -> xr.Dataset:
    """Compute frequencies by nodal diameter, with free and clamped centre, and for many stiffnesses
    of the shaft.

    Variables over `mode`, one mode for each pair of the bladed disk: frequency [Hz],
    normalised_frequency (divided by the reference frequency), purity and spring_share. A mode is
    selected by centre, family and nodal_diameter::

        diagrams = bladewhirl.veering(case)
        diagrams.frequency.sel(centre="clamped", family="1F", nodal_diameter=1)

    Variables over `stiffness` of each shaft spring [N/m] and `branch` (modes with one nodal
    diameter): branch_frequency [Hz], normalised_branch_frequency and branch_spring_share, the share
    of the strain energy in the shaft springs. Variables over `branch`: clamped_frequency [Hz], the
    limit for rigid springs, and normalised_clamped_frequency. With Coriolis forces, modes and
    branches are waves of both directions: modes have `direction`, branches branch_direction.
    branch_family is the family of the mode of a branch at the stiffness of the case, as in `modes`.
    `diagrams.reset_index("mode")` can be saved to a file; `bladewhirl.plot.veering` and
    `shaft_veering` draw the frequencies.

    Args:
        case_or_stage: a case, or its stage.
        families: number of families of the bladed disk, without the suspension pair.
        stiffnesses: stiffnesses of each shaft spring [N/m], ascending, (stiffness,); by default
            from `spring_stiffnesses`.

    Raises:
        UserError: the stage has no cyclic symmetry, so that modes with one nodal diameter cannot be
            separated, or no centre on shaft springs.
    """
    stage = modal_model(case_or_stage, families=families)
    families = min(families, stage.disk_modes.count)
    springs = spring_stiffnesses(stage.case, None, stiffnesses)
    branches, computed = _over_shaft(stage, springs), modes(stage)
    reference, hertz = stage.reference_frequency, 2.0 * np.pi
    share = "share of the strain energy in the shaft springs"
    plane = ("stiffness", "branch")
    return (
        _families(computed, families)
        .assign(
            branch_frequency=quantity(plane, branches.frequency / hertz, "Hz"),
            normalised_branch_frequency=quantity(plane, branches.frequency / reference, "1"),
            branch_spring_share=quantity(plane, branches.spring_share, "1", share),
            clamped_frequency=quantity("branch", branches.clamped / hertz, "Hz"),
            normalised_clamped_frequency=quantity("branch", branches.clamped / reference, "1"),
            branch_direction=quantity("branch", list(branches.direction), ""),
            branch_family=quantity("branch", _families_at_case(stage, computed), ""),
        )
        .assign_coords(stiffness=quantity("stiffness", branches.stiffness, "N/m"))
        .assign_attrs(
            title="veering diagrams",
            case=stage.case.title,
            families=families,
            case_stiffness=stage.case.shaft.stiffness,
            speed=stage.speed if stage.turns else 0.0,
            reference_frequency=reference,
        )
    )


def veering_facts(diagrams: xr.Dataset) -> dict[str, str]:
    """Return texts on the effect of clamping the centre, and on the suspension frequencies."""
    shifts = clamping_shifts(diagrams)
    others = max((shift for k, shift in shifts.items() if k != 1), default=0.0)
    texts = {
        "largest change by clamping the centre, k = 1": f"{100 * shifts[1]:.3g} %",
        "largest change by clamping the centre, other k": f"{100 * others:.1g} %",
    }
    pair = diagrams.isel(mode=diagrams["family"].values == "suspension")
    frequencies = [f"{frequency:.4g} ω₁" for frequency in pair["normalised_frequency"].values]
    if "direction" in diagrams.indexes["mode"].names:
        waves = zip(pair["direction"].values, frequencies, strict=True)
        frequencies = [f"{direction} {frequency}" for direction, frequency in waves]
    return texts | ({"suspension, rotating frame": ", ".join(frequencies)} if frequencies else {})


def report(diagrams: xr.Dataset) -> Study:
    """Return the document, facts and figures of `veering`."""
    columns = [Column(str(name)) for name in diagrams.indexes["mode"].names]
    columns += [Column("frequency_hz", variable="frequency")]
    columns += [Column("normalised", variable="normalised_frequency")]
    document = {
        "reference_frequency_hz": diagrams.attrs["reference_frequency_hz"],
        "modes": rows_of(diagrams, columns),
        "shaft": {
            "stiffness": diagrams["stiffness"].values.tolist(),
            "normalised": diagrams["normalised_branch_frequency"].values.tolist(),
            "spring_share": diagrams["branch_spring_share"].values.tolist(),
        },
    }

    def figures() -> Figures:
        from bladewhirl.postprocess.modal.veering import plot_families, plot_shaft_veering

        families = diagrams.drop_dims(("stiffness", "branch")).reset_index("mode")
        return {
            "families": (plot_families(diagrams), families),
            "first-families": (plot_families(diagrams, CLOSE_UP), families),
            "shaft": (plot_shaft_veering(diagrams), diagrams.drop_dims("mode")),
        }

    return Study(
        name="veering", document=document, tables=[facts(veering_facts(diagrams))], figures=figures
    )


def clamping_shifts(diagrams: xr.Dataset) -> dict[int, float]:
    """Return by nodal diameter the largest relative change that clamping the centre causes in a
    frequency; the diagrams are from `veering`."""
    frequency = diagrams["frequency"].to_series()
    # Above a critical speed both waves of a pair can travel backward: waves are distinguished by
    # their order.
    order = frequency.groupby(level=frequency.index.names).cumcount().rename("order")
    ordered = frequency.to_frame().set_index(order, append=True)["frequency"]
    centres = ordered.unstack("centre")
    changes = (centres["clamped"] / centres["free"] - 1.0).abs()
    largest = changes.groupby(level="nodal_diameter").max()
    return {int(k): float(shift) for k, shift in largest.items()}


def suspension_frequency(diagrams: xr.Dataset) -> float | None:
    """Return the normalised frequency of the suspension (with Coriolis forces, of its lower wave)
    from diagrams of `veering`; None without a suspension."""
    here = diagrams["family"].values == "suspension"
    return float(diagrams["normalised_frequency"].values[here][0]) if here.any() else None


def spring_stiffnesses(
    case: Case, interval: FloatArray | None, given: FloatArray | None = None
) -> FloatArray:
    """Return the stiffnesses of the shaft springs [N/m] that a caller gave or, if None, stiffnesses
    equally spaced on a logarithmic scale, from the first to the last of an interval, or, if the
    interval is None, around that of the case.

    Raises:
        UserError: the first stiffness is zero, or the given ones are not positive and ascending.
    """
    if given is not None:
        return np.array(
            ascending("stiffnesses", given, "positive stiffnesses, ascending", SMALLEST)
        )
    if interval is None:
        interval = case.shaft.stiffness * 10.0 ** np.array([-DECADES, DECADES])
    if not interval[0] > 0.0:
        raise UserError(f"--stiffnesses {interval[0]:g}: expected a START above zero")
    first, last = interval.tolist()
    return np.geomspace(first, last, STIFFNESSES)


def _families(computed: xr.Dataset, families: int) -> xr.Dataset:
    """Return the first families of the bladed disk and the suspension, one mode of each pair."""
    names = ["suspension", *(f"{rank}F" for rank in range(1, families + 1))]
    chosen = (
        (computed["body"].values == "bladed-disk")
        & np.isin(computed["family"].values, names)
        & (computed["pattern"].values != "sine")
    )
    data = computed.isel(mode=chosen).reset_index("mode").drop_vars(("body", "number", "pattern"))
    whirls = computed.attrs["rotation_effects"] == "full"
    return data.set_index(mode=[*MODE_LEVELS, *(("direction",) if whirls else ())])


def _families_at_case(stage: ModalModel, computed: xr.Dataset) -> list[str]:
    """Return the family of each branch at the stiffness of the case, from all modes `computed`."""
    at_case = _over_shaft(stage, np.array([stage.case.shaft.stiffness])).frequency[0]
    chosen = computed.sel(body="bladed-disk", centre="free", nodal_diameter=1)
    distance = np.abs(at_case[:, None] / (2.0 * np.pi) - chosen["frequency"].values)
    return [str(name) for name in chosen["family"].values[distance.argmin(axis=1)]]


def _over_shaft(stage: ModalModel, springs: FloatArray) -> ShaftVeering:
    block, omega = stage.shaft_block, stage.speed
    centre = np.zeros(block.size, dtype=np.complex128)
    centre[-1] = 1.0
    options: dict[str, Any] = {"springs": springs, "branches": min(BRANCHES, len(centre) - 1)}
    matrices: tuple[ComplexArray, ...] = (
        block.mass,
        block.stiffness_at(omega),
        omega * block.known("gyroscopic"),
    )
    elastic = block.stiffness
    if omega < 0.0:  # waves against the rotation then travel backward
        matrices, elastic = tuple(map(np.conj, matrices)), elastic.conj()
    if block.gyroscopic is None:
        return shaft_veering(matrices[1], matrices[0], centre, **options)
    return whirl_veering(matrices, elastic, centre, **options)
