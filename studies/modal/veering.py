"""Frequencies over nodal diameter and over shaft stiffness: as a Dataset, in words, as figures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.modal.veering import plot_families, plot_shaft_veering
from bladewhirl.solvers.stability.veering import ShaftVeering, shaft_veering, whirl_veering
from bladewhirl.studies.modal.modes import full_stage, modes, rows_of
from bladewhirl.studies.runs.figures_folder import save_figures

STIFFNESSES, DECADES = 241, 3
"""Stiffnesses of the shaft, and how many decades they reach to either side of the case's."""

BRANCHES = 5
"""Modes followed over the stiffness of the shaft."""

CLOSE_UP = 2
"""Families of the second diagram, which shows the suspension pair between them."""

MODE_LEVELS = ("centre", "family", "nodal_diameter")
"""Index of the modes."""


def veering(
    case_or_stage: Case | Stage | ModalStage,
    *,
    families: int = 12,
    stiffnesses: FloatArray | None = None,
) -> xr.Dataset:
    """Frequencies over nodal diameter with a free and a clamped centre, and over shaft stiffness.

    Over `mode`, of the bladed disk and a pair given once: frequency [Hz], normalised_frequency
    (over the reference frequency), purity and spring_share. A mode is selected by centre, family
    and nodal_diameter::

        found = bladewhirl.veering(case)
        found.frequency.sel(centre="clamped", family="1F", nodal_diameter=1)

    Over `stiffness` of each shaft spring [N/m] and `branch`, the modes with one nodal diameter:
    branch_frequency [Hz], normalised_branch_frequency and branch_spring_share, the share of the
    strain energy in the shaft springs; over `branch` clamped_frequency [Hz], which each branch
    approaches, and normalised_clamped_frequency. With Coriolis forces modes have `direction` in
    their index, and branches a branch_direction: waves both ways, at the case's speed.
    `found.reset_index("mode")` goes into a file; `bladewhirl.plot.veering` and `shaft_veering` draw
    it.

    Args:
        case_or_stage: a case, or a stage of it.
        families: how many of the bladed disk, the suspension pair apart.
        stiffnesses: of each shaft spring [N/m], ascending, (stiffness,); by default those of
            `spring_stiffnesses`.

    Raises:
        UserError: a stage without cyclic symmetry, whose modes with one nodal diameter don't
            stand apart.
    """
    stage = full_stage(case_or_stage)
    families = min(families, stage.disk_modes.count)
    springs = spring_stiffnesses(stage.case, None) if stiffnesses is None else stiffnesses
    branches = _over_shaft(stage, springs)
    reference = stage.reference_frequency
    hertz, one = {"units": "Hz"}, {"units": "1"}
    share = {"units": "1", "long_name": "share of the strain energy in the shaft springs"}
    plane = ("stiffness", "branch")
    return (
        _families(modes(stage), families)
        .assign(
            branch_frequency=(plane, branches.frequency / (2.0 * np.pi), hertz),
            normalised_branch_frequency=(plane, branches.frequency / reference, one),
            branch_spring_share=(plane, branches.spring_share, share),
            clamped_frequency=("branch", branches.clamped / (2.0 * np.pi), hertz),
            normalised_clamped_frequency=("branch", branches.clamped / reference, one),
            branch_direction=("branch", list(branches.direction), {"units": ""}),
        )
        .assign_coords(stiffness=("stiffness", branches.stiffness, {"units": "N/m"}))
        .assign_attrs(
            title="veering diagrams",
            case=stage.case.title,
            families=families,
            case_stiffness=stage.case.shaft.stiffness,
            speed=0.0 if stage.at_speed is None else stage.speed,
            reference_frequency=reference,
        )
    )


def report_lines(found: xr.Dataset) -> Iterator[str]:
    """The findings in words.

    Args:
        found: from `veering`.
    """
    shifts = clamping_shifts(found)
    others = max((shift for k, shift in shifts.items() if k != 1), default=0.0)
    yield (
        f"Clamping the centre changes families with k = 1 by up to {100 * shifts[1]:.3g} %,"
        f" with other k by up to {100 * others:.1g} %."
    )
    if (found["family"] == "suspension").any():
        yield _suspension_words(found)


def veering_document(found: xr.Dataset) -> dict[str, Any]:
    """Everything drawn, for programs.

    Args:
        found: from `veering`.
    """
    keys = {
        **{str(name): str(name) for name in found.indexes["mode"].names},
        "frequency_hz": "frequency",
        "normalised": "normalised_frequency",
    }
    return {
        "reference_frequency_hz": found.attrs["reference_frequency_hz"],
        "modes": rows_of(found, keys),
        "shaft": {
            "stiffness": found["stiffness"].values.tolist(),
            "normalised": found["normalised_branch_frequency"].values.tolist(),
            "spring_share": found["branch_spring_share"].values.tolist(),
        },
    }


def clamping_shifts(found: xr.Dataset) -> dict[int, float]:
    """Largest relative change of a family's frequency by clamping the centre, by nodal diameter.

    Args:
        found: from `veering`.
    """
    frequency = found["frequency"].to_series()
    # Past a critical speed both waves of a pair may go backward: these are told by their order.
    twin = frequency.groupby(level=frequency.index.names).cumcount()
    each = frequency.to_frame().set_index(twin.rename("twin"), append=True)["frequency"]
    centres = each.unstack("centre")
    changes = (centres["clamped"] / centres["free"] - 1.0).abs()
    largest = changes.groupby(level="nodal_diameter").max()
    return {int(k): float(shift) for k, shift in largest.items()}


def suspension_frequency(found: xr.Dataset) -> float | None:
    """Normalised frequency of the suspension pair, or its lower wave; None where there is none.

    Args:
        found: from `veering`.
    """
    here = found["family"].values == "suspension"
    return float(found["normalised_frequency"].values[here][0]) if here.any() else None


def _suspension_words(found: xr.Dataset) -> str:
    """Normalised frequencies of the suspension: of the pair, or of its waves in rotating axes."""
    if "direction" not in found.indexes["mode"].names:
        return f"Suspension pair at {suspension_frequency(found):.4g} ω₁."
    own = found.isel(mode=found["family"].values == "suspension")
    waves = zip(own["direction"].values, own["normalised_frequency"].values, strict=True)
    told = ", ".join(f"{way} at {frequency:.4g} ω₁" for way, frequency in waves)
    return f"Waves of the suspension, rotating frame: {told}."


def spring_stiffnesses(case: Case, interval: tuple[float, float] | None) -> FloatArray:
    """Stiffnesses of the shaft to look at [N/m], evenly spread over decades, (stiffnesses,)."""
    given = case.shaft.stiffness
    first, last = interval or (given * 10.0**-DECADES, given * 10.0**DECADES)
    return np.geomspace(first, last, STIFFNESSES)


def draw_veering(found: xr.Dataset, folder: Path, *, overwrite: bool = False) -> None:
    """Draw the diagrams into a folder.

    Args:
        found: from `veering`.
        folder: where to.
        overwrite: replace files that are there, whosever they are.

    Raises:
        UserError: a file cannot be written, or is there and not the program's.
    """
    families = found.drop_dims(("stiffness", "branch")).reset_index("mode")
    drawn = {
        "families": (plot_families(found), families),
        "first-families": (plot_families(found, CLOSE_UP), families),
        "shaft": (plot_shaft_veering(found), found.drop_dims("mode")),
    }
    save_figures(folder, drawn, overwrite=overwrite)


def _families(found: xr.Dataset, families: int) -> xr.Dataset:
    """First families of the bladed disk and the suspension, a pair given once, from `modes`."""
    wanted = ["suspension", *(f"{rank}F" for rank in range(1, families + 1))]
    chosen = (
        (found["body"].values == "bladed-disk")
        & np.isin(found["family"].values, wanted)
        & (found["pattern"].values != "sine")
    )
    kept = found.isel(mode=chosen).reset_index("mode").drop_vars(("body", "number", "pattern"))
    whirls = found.attrs["rotation_effects"] == "full"
    return kept.set_index(mode=[*MODE_LEVELS, *(("direction",) if whirls else ())])


def _over_shaft(stage: ModalStage, springs: FloatArray) -> ShaftVeering:
    disk = stage.free_disk if stage.at_speed is None else stage.at_speed[0].disk
    structure, layout = disk.structure, disk.structure.layout
    if layout is None or not structure.is_cyclic:
        found = structure.symmetry.partition(":")[0]
        raise UserError(
            "veering: expected equal sectors on equal shaft springs, whose modes with one nodal"
            f" diameter stand apart, not {found}; bladewhirl modes lists the frequencies"
        )
    basis = layout.basis(1)

    def block(matrix: sp.csr_array) -> ComplexArray:
        return np.asarray((basis.conj().T @ matrix @ basis).toarray())

    mass, stiffness = block(structure.mass), block(structure.stiffness - structure.springs)
    centre = np.zeros(len(mass), dtype=np.complex128)
    centre[-1] = 1.0  # the centre's whirl stands last, see `SectorLayout.basis`
    options: dict[str, Any] = {"springs": springs, "branches": min(BRANCHES, len(mass) - 1)}
    if structure.gyroscopic is None:
        return shaft_veering(stiffness, mass, centre, **options)
    elastic = block(structure.elastic - structure.springs)
    matrices = mass, stiffness, block(structure.gyroscopic)
    return whirl_veering(matrices, elastic, centre, **options)
