"""Lists of natural modes: for programs, and for people."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modes import is_first_of_pair


def mode_lists(stage: ModalStage, count: int) -> dict[str, list[dict[str, Any]]]:
    """The lowest modes of each body, ascending; both of a degenerate pair are listed.

    Args:
        stage: full finite element models with their modes.
        count: of each list.
    """
    reference = stage.reference_frequency
    return {
        "bladed_disk": _entries(stage.disk_modes, count, reference),
        "bladed_disk_free": _entries(stage.free_modes, count, reference),
        "bladed_disk_clamped": _entries(stage.clamped_modes, count, reference),
        "casing": _entries(stage.casing_modes, count, reference),
    }


def print_modes(stage: ModalStage, count: int) -> None:
    """Print the lowest modes of the bladed disk as the case has it, and of the casing."""
    hertz = stage.reference_frequency / (2.0 * np.pi)
    centre = "clamped" if stage.case.shaft.clamped else "free"
    console = Console()
    console.print(
        _table(stage, stage.disk_modes, count, f"Bladed disk, {centre} centre"),
        _table(stage, stage.casing_modes, count, "Casing"),
        f"ω₁ = {stage.reference_frequency:.6g} rad/s = {hertz:.6g} Hz, the lowest of the bladed"
        " disk with a free centre. Pairs share a row.",
        sep="\n",
    )


def _entries(modes: LabelledModes, count: int, reference: float) -> list[dict[str, Any]]:
    return [
        {
            "frequency_hz": float(modes.frequency[mode] / (2.0 * np.pi)),
            "normalised": float(modes.frequency[mode] / reference),
            "nodal_diameter": int(modes.nodal_diameter[mode]),
            "family": modes.family[mode],
            "purity": float(modes.purity[mode]),
        }
        for mode in range(min(count, modes.count))
    ]


def _table(stage: ModalStage, modes: LabelledModes, count: int, title: str) -> Table:
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", title_style="bold")
    table.add_column("mode", style="dim", justify="right")
    table.add_column("family")
    for name in ("k", "frequency [Hz]", "/ ω₁ [–]", "purity", "in springs"):
        table.add_column(name, justify="right", no_wrap=True)
    shown = min(count, modes.count)
    mode = 0
    while mode < shown:
        pair = is_first_of_pair(modes.column, mode) and mode + 1 < shown
        name = modes.family[mode]
        table.add_row(
            f"{mode + 1}–{mode + 2}" if pair else f"{mode + 1}",
            name,
            str(modes.nodal_diameter[mode]) if modes.nodal_diameter[mode] >= 0 else "–",
            f"{modes.frequency[mode] / (2.0 * np.pi):.4f}",
            f"{modes.frequency[mode] / stage.reference_frequency:.5f}",
            f"{modes.purity[mode]:.3f}",
            _percent(float(modes.spring_share[mode])),
            style="green" if name == "suspension" else None,
        )
        mode += 2 if pair else 1
    return table


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %" if share >= 5e-4 else ""
