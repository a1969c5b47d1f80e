"""What `bladewhirl veering` finds, draws and reports."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.postprocess.modal.veering import (
    families_dataset,
    plot_families,
    plot_shaft_veering,
    shaft_dataset,
)
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.solvers.stability.veering import ShaftVeering, shaft_veering
from bladewhirl.studies.runs.figures_folder import written_to

STIFFNESSES, DECADES = 241, 3
"""Stiffnesses of the shaft, and how many decades they reach to either side of the case's."""

BRANCHES = 5
"""Modes followed over the stiffness of the shaft."""

CLOSE_UP = 2
"""Families of the second diagram, which shows the suspension pair between them."""


@dataclass(frozen=True, kw_only=True)
class Veering:
    """Veering diagrams of a stage."""

    families: xr.Dataset  #: from `families_dataset`
    shaft: xr.Dataset  #: from `shaft_dataset`

    def lines(self) -> Iterator[str]:
        """The findings in words."""
        shifts = clamping_shifts(self.families)
        others = max((shift for k, shift in shifts.items() if k != 1), default=0.0)
        yield (
            f"Clamping the centre changes families with k = 1 by up to {100 * shifts[1]:.3g} %,"
            f" with other k by up to {100 * others:.1g} %."
        )
        suspension = suspension_frequency(self.families)
        if suspension is not None:
            yield f"Suspension pair at {suspension:.4g} ω₁."

    def as_json(self) -> dict[str, Any]:
        """Everything drawn."""
        names = ("centre", "family", "nodal_diameter", "frequency_hz", "normalised")
        data = self.families
        columns = [
            data["centre"].values.tolist(),
            data["family"].values.tolist(),
            data["nodal_diameter"].values.tolist(),
            (data["frequency"].values / (2.0 * np.pi)).tolist(),
            data["normalised"].values.tolist(),
        ]
        return {
            "reference_frequency_hz": data.attrs["reference_frequency"] / (2.0 * np.pi),
            "modes": [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)],
            "shaft": {
                "stiffness": self.shaft["stiffness"].values.tolist(),
                "normalised": self.shaft["normalised"].values.tolist(),
                "spring_share": self.shaft["spring_share"].values.tolist(),
            },
        }


def clamping_shifts(families: xr.Dataset) -> dict[int, float]:
    """Largest relative change of a family's frequency by clamping the centre, by nodal diameter.

    Args:
        families: from `families_dataset`.
    """
    names = ("centre", "nodal_diameter", "family", "frequency")
    rows = list(zip(*(families[name].values for name in names), strict=True))
    free = {(k, family): value for centre, k, family, value in rows if centre == "free"}
    found: dict[int, float] = {}
    for centre, k, family, value in rows:
        if centre == "clamped":
            change = abs(float(value / free[k, family]) - 1.0)
            found[int(k)] = max(found.get(int(k), 0.0), change)
    return found


def suspension_frequency(families: xr.Dataset) -> float | None:
    """Normalised frequency of the suspension pair; None where there is none.

    Args:
        families: from `families_dataset`.
    """
    here = families["family"].values == "suspension"
    return float(families["normalised"].values[here][0]) if here.any() else None


def spring_stiffnesses(case: Case, interval: tuple[float, float] | None) -> FloatArray:
    """Stiffnesses of the shaft to look at [N/m], evenly spread over decades, (stiffnesses,)."""
    given = case.shaft.stiffness
    first, last = interval or (given * 10.0**-DECADES, given * 10.0**DECADES)
    return np.geomspace(first, last, STIFFNESSES)


def veering_report(stage: ModalStage, *, families: int, springs: FloatArray) -> Veering:
    """Find what the diagrams show.

    Args:
        stage: full finite element models with their modes.
        families: how many of the bladed disk, the suspension pair apart.
        springs: stiffnesses of each shaft spring [N/m], ascending, (stiffnesses,).

    Raises:
        UserError: a stage without cyclic symmetry, whose modes with one nodal diameter don't
            stand apart.
    """
    reference = stage.reference_frequency
    return Veering(
        families=families_dataset(
            stage.free_modes, stage.clamped_modes, families=families, reference=reference
        ),
        shaft=shaft_dataset(
            _over_shaft(stage, springs), reference=reference, given=stage.case.shaft.stiffness
        ),
    )


def draw_veering(found: Veering, folder: Path) -> None:
    """Draw the diagrams into a folder.

    Raises:
        UserError: the folder or a file cannot be written.
    """
    with written_to(folder):
        families = found.families
        save_figure(plot_families(families), folder / "families", families)
        save_figure(plot_families(families, CLOSE_UP), folder / "first-families", families)
        save_figure(plot_shaft_veering(found.shaft), folder / "shaft", found.shaft)


def _over_shaft(stage: ModalStage, springs: FloatArray) -> ShaftVeering:
    structure = stage.free_disk.structure
    layout = structure.layout
    if layout is None or not structure.is_cyclic:
        found = structure.symmetry.partition(":")[0]
        raise UserError(
            "veering: expected equal sectors on equal shaft springs, whose modes with one nodal"
            f" diameter stand apart, not {found}; bladewhirl modes lists the frequencies"
        )
    basis = layout.basis(1)
    held = structure.stiffness - structure.springs
    stiffness, mass = (
        (basis.conj().T @ matrix @ basis).toarray() for matrix in (held, structure.mass)
    )
    centre = np.zeros(len(mass), dtype=np.complex128)
    centre[-1] = 1.0  # the centre's whirl stands last, see `SectorLayout.basis`
    return shaft_veering(
        stiffness, mass, centre, springs=springs, branches=min(BRANCHES, len(mass) - 1)
    )
