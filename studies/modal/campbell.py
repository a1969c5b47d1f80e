"""What `bladewhirl campbell` finds, draws and reports."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.postprocess.modal.campbell import campbell_dataset, plot_campbell
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.solvers.stability.coincidence import Coincidences, coincidences
from bladewhirl.studies.runs.figures_folder import written_to

Interval = tuple[float, float]

CASING_FAMILIES = ("rigid", "1F", "2F")
"""Families of the casing: as a whole, in bending, in extension."""

DRAWN_FAMILIES = ("1F", "suspension")
"""Families of the bladed disk that are drawn even where nothing coincides."""


@dataclass(frozen=True, kw_only=True)
class Campbell:
    """Modes of both bodies, a pair given once, and where they coincide."""

    rotor: LabelledModes
    casing: LabelledModes
    found: Coincidences
    reference: float  #: frequency that speeds are multiples of [rad/s]
    speeds: Interval  #: of the diagrams, normalised
    operating: Interval  #: operating range, normalised

    @property
    def shown(self) -> Coincidences:
        """Coincidences inside the diagrams."""
        first, last = self.speeds
        return self.found.between(first * self.reference, last * self.reference)


def find_coincidences(
    stage: ModalStage, *, families: int, speeds: Interval, operating: Interval
) -> Campbell:
    """Find the coincidence speeds of the bladed disk as the case has it and its casing.

    Args:
        stage: full finite element models with their modes.
        families: how many of the bladed disk, the suspension pair apart.
        speeds: of the diagrams, normalised.
        operating: operating range, normalised.
    """
    wanted = {"suspension", *(f"{rank}F" for rank in range(1, families + 1))}
    rotor = _of_families(stage.disk_modes, wanted)
    casing = _of_families(stage.casing_modes, set(CASING_FAMILIES))
    return Campbell(
        rotor=rotor,
        casing=casing,
        found=_meet(rotor, casing),
        reference=stage.reference_frequency,
        speeds=speeds,
        operating=operating,
    )


def coincidence_list(campbell: Campbell) -> dict[str, Any]:
    """All coincidences, ascending in speed, and what they are measured in."""
    reference = campbell.reference
    first, last = campbell.operating
    return {
        "reference_frequency_hz": reference / (2.0 * np.pi),
        "operating_range": [first, last],
        "coincidences": [
            {
                "nodal_diameter": int(k),
                "rotor_family": campbell.rotor.family[rotor],
                "casing_family": campbell.casing.family[casing],
                "rotor_frequency_hz": float(campbell.rotor.frequency[rotor] / (2.0 * np.pi)),
                "casing_frequency_hz": float(campbell.casing.frequency[casing] / (2.0 * np.pi)),
                "speed": float(speed / reference),
                "speed_rpm": float(speed * 30.0 / np.pi),
                "in_operating_range": bool(first <= speed / reference <= last),
            }
            for rotor, casing, k, speed in _rows(campbell.found)
        ],
    }


def print_coincidences(campbell: Campbell) -> None:
    """Print the coincidences inside the diagrams; those in the operating range are bold."""
    first, last = campbell.speeds
    table = Table(
        title=f"Coincidence speeds from {first:g} to {last:g} ω₁",
        box=box.SIMPLE_HEAD,
        title_justify="left",
        title_style="bold",
    )
    table.add_column("k", justify="right")
    table.add_column("bladed disk")
    table.add_column("casing")
    for name in ("Ω / ω₁ [–]", r"\[rpm]", "operating range"):
        table.add_column(name, justify="right", no_wrap=True)
    low, high = campbell.operating
    for rotor, casing, k, speed in _rows(campbell.shown):
        ratio = speed / campbell.reference
        inside = low <= ratio <= high
        table.add_row(
            str(k),
            campbell.rotor.family[rotor],
            campbell.casing.family[casing],
            f"{ratio:.4f}",
            f"{speed * 30.0 / np.pi:.1f}",
            "inside" if inside else "",
            style="bold" if inside else None,
        )
    console = Console()
    console.print(table if campbell.shown.count else f"No coincidence from {first:g} to {last:g}.")


def draw_campbell(campbell: Campbell, folder: Path) -> None:
    """Draw both diagrams into a folder: families that coincide inside them, with the casing's
    lowest mode of each nodal diameter.

    Raises:
        UserError: the folder or a file cannot be written.
    """
    rotor = _of_families(campbell.rotor, _drawn_families(campbell))
    casing = _lowest_of_each(campbell.casing, int(rotor.nodal_diameter.max()))
    data = campbell_dataset(
        rotor,
        casing,
        _meet(rotor, casing),
        reference=campbell.reference,
        speeds=campbell.speeds,
        operating=campbell.operating,
    )
    with written_to(folder):
        save_figure(plot_campbell(data, "rotating"), folder / "campbell-rotating", data)
        save_figure(plot_campbell(data, "static"), folder / "campbell-static", data)


def _rows(found: Coincidences) -> list[tuple[int, int, int, float]]:
    return [
        (int(rotor), int(casing), int(k), float(speed))
        for rotor, casing, k, speed in zip(
            found.rotor, found.casing, found.nodal_diameter, found.speed, strict=True
        )
    ]


def _meet(rotor: LabelledModes, casing: LabelledModes) -> Coincidences:
    return coincidences(
        rotor_frequency=rotor.frequency,
        rotor_nodal_diameter=rotor.nodal_diameter,
        casing_frequency=casing.frequency,
        casing_nodal_diameter=casing.nodal_diameter,
    )


def _of_families(modes: LabelledModes, wanted: set[str]) -> LabelledModes:
    """Modes of some families, a pair given once."""
    one = modes.one_a_pair()
    return modes.take(one[[modes.family[mode] in wanted for mode in one]])


def _drawn_families(campbell: Campbell) -> set[str]:
    meeting = {campbell.rotor.family[rotor] for rotor in campbell.shown.rotor}
    return meeting | set(DRAWN_FAMILIES)


def _lowest_of_each(modes: LabelledModes, highest: int) -> LabelledModes:
    """The lowest mode of each nodal diameter from 1 to the highest that the rotor has."""
    first: IntArray = np.unique(modes.nodal_diameter, return_index=True)[1]
    travels = (modes.nodal_diameter[first] >= 1) & (modes.nodal_diameter[first] <= highest)
    return modes.take(np.sort(first[travels]))
