"""Natural modes of a case: as a Dataset, as lists for programs, as tables for people."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich import box
from rich.console import Console
from rich.table import Table

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import faults_from, read_case
from bladewhirl.models.case.rotation import Effects
from bladewhirl.models.modal.full_stage import ModalStage, Whirl, modal_stage
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modes import is_first_of_pair
from bladewhirl.models.rotation.at_speed import check_effects
from bladewhirl.models.rotation.whirl_modes import Direction, WhirlModes, directions
from bladewhirl.models.stage.stage import Stage

LEVELS = {
    "body": "whose mode: bladed-disk or casing",
    "centre": "free or clamped centre of the bladed disk; empty for the casing",
    "family": "family of the mode",
    "nodal_diameter": "nodal diameter that holds most of the mode; -1 without sectors",
    "number": "place among the modes of this body and centre, ascending in frequency",
}
"""Coordinates of a mode, with what they mean; together they are the index of `mode`."""

VARIABLES = {
    "frequency": ("Hz", "natural frequency"),
    "normalised_frequency": ("1", "natural frequency over the reference frequency"),
    "purity": ("1", "share of the nodal diameter in the mode"),
    "spring_share": ("1", "share of the strain energy in springs"),
}
"""Unit and long name of what is known of a mode."""


def full_stage(case_or_stage: Case | Stage | ModalStage) -> ModalStage:
    """The full finite element models with all their modes: found, unless they are given."""
    if isinstance(case_or_stage, ModalStage):
        return case_or_stage
    return modal_stage(case_or_stage if isinstance(case_or_stage, Case) else case_or_stage.case)


def stage_of_file(
    file: Path, overrides: list[str] | None, what: str, *known: Effects
) -> ModalStage:
    """Models and modes of a case file, checked.

    Args:
        file: the case.
        overrides: "KEY=VALUE" as given to --set.
        what: the analysis that it is for, in words.
        known: rotation effects that this knows.

    Raises:
        CaseError: all faults of the case, naming the file or --set.
    """
    values = overrides or []
    case = read_case(file, values)
    with faults_from(file, values):
        check_effects(case, what, *known)
        return modal_stage(case)


def modes(case_or_stage: Case | Stage | ModalStage) -> xr.Dataset:
    """Natural modes of the full bladed disk, with a free and a clamped centre, and of the casing.

    Over `mode`: frequency [Hz], normalised_frequency (over the lowest of the bladed disk with a
    free centre), purity (share of its nodal diameter in the mode) and spring_share (of the strain
    energy). A mode is selected by any of its coordinates body, centre, family, nodal_diameter and
    number::

        found = bladewhirl.modes(case)
        found.frequency.sel(body="bladed-disk", centre="free", family="1F", nodal_diameter=1)

    gives two frequencies where blades are alike: both of a pair are there, the cosine first, as
    `pattern` says (cosine, sine or single). `direction` and `direction_static` say which way a wave
    travels in the rotating and in the static frame at the case's speed: backward, forward or
    standing. With Coriolis forces waves stand apart, and `pattern` is wave or single.
    `found.reset_index("mode")` goes into a file.

    Args:
        case_or_stage: a case, or a stage of it.

    Returns:
        The modes of each body, ascending; the attribute `centre` says how the case holds it,
        `reference_frequency_hz` what frequencies are multiples of.

    Raises:
        CaseError: numbers that finite elements can't be made of.
    """
    stage = full_stage(case_or_stage)
    lists = (
        ("bladed-disk", "free", stage.free_whirl or stage.free_modes),
        ("bladed-disk", "clamped", stage.clamped_whirl or stage.clamped_modes),
        ("casing", "", stage.casing_modes),
    )
    return xr.concat(
        [_list_of(found, body, centre, stage) for body, centre, found in lists], "mode"
    ).assign_attrs(
        title="natural modes",
        centre="clamped" if stage.case.shaft.clamped else "free",
        rotation_effects=stage.case.rotation.effects,
        reference_frequency_hz=stage.reference_frequency / (2.0 * np.pi),
    )


def _list_of(
    modes_found: LabelledModes | Whirl, body: str, centre: str, stage: ModalStage
) -> xr.Dataset:
    """All modes of one body."""
    found = modes_found.modes if isinstance(modes_found, Whirl) else modes_found
    if isinstance(found, WhirlModes):
        pattern = ["single" if way == "standing" else "wave" for way in found.direction]
        ways = found.direction, found.static_direction(stage.speed)
    else:
        pattern = [_pattern(found, number) for number in range(found.count)]
        ways = _ways_of_pairs(found, pattern, body, stage.speed)
    names = {
        "body": np.full(found.count, body, dtype=object),
        "centre": np.full(found.count, centre, dtype=object),
        "family": np.array(modes_found.family, dtype=object),
        "nodal_diameter": found.nodal_diameter,
        "number": np.arange(1, found.count + 1),
    }
    values = {
        "frequency": found.frequency / (2.0 * np.pi),
        "normalised_frequency": found.frequency / stage.reference_frequency,
        "purity": found.purity,
        "spring_share": found.spring_share,
    }
    along = {"pattern": pattern, "direction": ways[0], "direction_static": ways[1]}
    data = xr.Dataset(
        {
            name: ("mode", value, dict(zip(("units", "long_name"), VARIABLES[name], strict=True)))
            for name, value in values.items()
        },
        coords={name: ("mode", value) for name, value in names.items()}
        | {name: ("mode", np.array(value, dtype=object)) for name, value in along.items()},
    ).set_index(mode=list(LEVELS))
    for name, meaning in LEVELS.items():
        data[name].attrs["long_name"] = meaning
    return data


def _ways_of_pairs(
    found: LabelledModes, pattern: list[str], body: str, omega: float
) -> tuple[tuple[Direction, ...], tuple[Direction, ...]]:
    """Ways in the rotating and in the static frame that the waves of standing modes travel.

    Both of a degenerate pair together make a wave backward and one forward in the body's own frame:
    the first stands for the one, the second for the other.
    """
    sign = np.array([{"cosine": 1.0, "sine": -1.0}.get(each, 0.0) for each in pattern])
    turned = np.where(sign == 0.0, 0.0, found.nodal_diameter * omega)
    own = sign * found.frequency
    if body == "casing":
        return directions(own + turned, omega), directions(own, omega)
    return directions(own, omega), directions(own - turned, omega)


def _pattern(found: LabelledModes, number: int) -> str:
    if is_first_of_pair(found.column, number):
        return "cosine"
    return "sine" if number and is_first_of_pair(found.column, number - 1) else "single"


def mode_lists(found: xr.Dataset, count: int) -> dict[str, list[dict[str, Any]]]:
    """The lowest modes of each body, ascending; both of a degenerate pair are listed.

    With rotation effects the way is told that each travels in both frames.

    Args:
        found: from `modes`.
        count: of each list.
    """
    lists = {
        "bladed_disk": {"body": "bladed-disk", "centre": found.attrs["centre"]},
        "bladed_disk_free": {"body": "bladed-disk", "centre": "free"},
        "bladed_disk_clamped": {"body": "bladed-disk", "centre": "clamped"},
        "casing": {"body": "casing"},
    }
    keys = {
        "frequency_hz": "frequency",
        "normalised": "normalised_frequency",
        "nodal_diameter": "nodal_diameter",
        "family": "family",
        "purity": "purity",
    }
    if found.attrs["rotation_effects"] != "none":
        keys |= {"direction": "direction", "direction_static": "direction_static"}
    return {
        name: rows_of(found.sel(which).isel(mode=slice(count)), keys)
        for name, which in lists.items()
    }


def rows_of(data: xr.Dataset, keys: Mapping[str, str]) -> list[dict[str, Any]]:
    """Variables over one dimension as a list for programs, under other names.

    Args:
        data: that holds them.
        keys: names of the variables by those in the list.
    """
    columns = [data[variable].values.tolist() for variable in keys.values()]
    return [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]


def print_modes(found: xr.Dataset, count: int) -> None:
    """Print the lowest modes of the bladed disk as the case has it, and of the casing.

    Args:
        found: from `modes`.
        count: of each body.
    """
    centre, hertz = found.attrs["centre"], found.attrs["reference_frequency_hz"]
    own = found.sel(body="bladed-disk", centre=centre)
    console = Console()
    console.print(
        _table(own.isel(mode=slice(count)), f"Bladed disk, {centre} centre"),
        _table(found.sel(body="casing").isel(mode=slice(count)), "Casing"),
        f"ω₁ = {2.0 * np.pi * hertz:.6g} rad/s = {hertz:.6g} Hz, the lowest of the bladed"
        " disk with a free centre. Pairs share a row."
        + (MIXED if float(own["purity"].min()) < PURE else ""),
        sep="\n",
    )


MIXED = " k is the nodal diameter that holds most of a mode, purity its share."
WIDE_NAMES = ("frequency [Hz]", "/ ω₁ [–]", "purity", "in springs")
PURE = 0.999  # nothing to say about mixed modes above this purity


def _table(lowest: xr.Dataset, title: str) -> Table:
    waves = "wave" in lowest["pattern"].values
    table = Table(
        title=title,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        title_style="bold",
        collapse_padding=waves,
        pad_edge=not waves,
    )
    table.add_column("mode", style="dim", justify="right", no_wrap=True)
    table.add_column("family", no_wrap=True)
    names = ("[Hz]", "/ ω₁", "purity", "springs") if waves else WIDE_NAMES
    for name in ("k", *names):
        table.add_column(name, justify="right", no_wrap=True)
    for name in ("rotating", "static") if waves else ():
        table.add_column(name, no_wrap=True)
    for place in range(lowest.sizes["mode"]):
        mode = lowest.isel(mode=place)
        if mode["pattern"] == "sine":
            continue  # beside its cosine
        pair = mode["pattern"] == "cosine" and place + 1 < lowest.sizes["mode"]
        family, k = str(mode["family"].values), int(mode["nodal_diameter"])
        table.add_row(
            f"{place + 1}–{place + 2}" if pair else f"{place + 1}",
            family,
            str(k) if k >= 0 else "–",
            f"{float(mode['frequency']):.4f}",
            f"{float(mode['normalised_frequency']):.5f}",
            f"{float(mode['purity']):.3f}",
            _percent(float(mode["spring_share"])),
            *(str(mode[way].values) for way in ("direction", "direction_static") if waves),
            style="green" if family == "suspension" else None,
        )
    return table


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %" if share >= 5e-4 else ""
