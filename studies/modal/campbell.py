"""Coincidence speeds of bladed disk and casing: as a Dataset, as a list, as a table, as figures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import numpy as np
import xarray as xr
from rich import box
from rich.console import Console
from rich.table import Table

from bladewhirl.meshes.files.manifest import claim_file
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.models.inputs.units import Speed
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.modal.campbell import Frame, drawn_part, plot_campbell
from bladewhirl.solvers.stability.coincidence import coincidences
from bladewhirl.studies.modal.campbell_at_speed import at_speed, disk_waves, meetings, names_of
from bladewhirl.studies.modal.modes import full_stage, rows_of
from bladewhirl.studies.runs.figures_folder import save_figures

Interval = tuple[float | str, float | str]
"""First and last speed: each a multiple of the reference frequency, or text such as "2500 rpm"."""

CASING_FAMILIES = ("rigid", "1F", "2F")
"""Families of the casing: as a whole, in bending, in extension."""


def campbell(
    case_or_stage: Case | Stage | ModalStage,
    *,
    families: int = 5,
    speeds: Interval = (0.0, 3.0),
    operating: Interval = (0.6, 2.0),
) -> xr.Dataset:
    """Speeds at which waves on bladed disk and casing coincide, Eq. (14), and the modes behind.

    Over `coincidence`, ascending: normalised_speed (over the reference frequency), speed [rpm],
    the frequency of both modes [Hz] and whether the speed lies in the operating range. A
    coincidence is selected by family (of the bladed disk), casing_family and nodal_diameter::

        found = bladewhirl.campbell(case)
        found.normalised_speed.sel(family="1F", nodal_diameter=1)

    Over `mode`, a pair given once: mode_frequency [Hz] and normalised_mode_frequency, with
    mode_body, mode_family and mode_nodal_diameter. `found.reset_index("coincidence")` goes into a
    file; `bladewhirl.plot.campbell` draws it.

    Over `critical`, critical_speed (normalised) and critical_rpm: there are none without rotation
    effects, and none is looked for beyond `speeds`. With them, critical_family (of the branch at
    rest), critical_nodal_diameter and critical_spring_share, the share of the strain energy in the
    shaft springs, and over `engine_order` the same of the speeds at which a wave's frequency in the
    rotating frame is k times that of rotation: it stands still in the static frame, as what forces
    it there does; over `branch` and `line_speed` (normalised), branch_frequency in the rotating
    frame [Hz], positive backward, with branch_family, branch_nodal_diameter and branch_direction;
    over `line_speed`, tip_growth [m]. Attributes are speeds, normalised, nan where there is none:
    clearance_gone, at which the tips have grown by the clearance, and waves_meet, from which two
    waves of the bladed disk have met and one grows.

    Args:
        case_or_stage: a case, or a stage of it; the centre is held as the case says.
        families: how many of the bladed disk, the suspension pair apart.
        speeds: of the diagrams and of what is looked for, each a multiple of the reference
            frequency or text such as "2500 rpm".
        operating: operating range, alike.

    Raises:
        CaseError: numbers that finite elements can't be made of.
        UserError: speeds that are none, or not in order.
    """
    stage = full_stage(case_or_stage)
    reference = stage.reference_frequency
    shown = _multiples("speeds", speeds, reference)
    operated = _multiples("operating", operating, reference)
    ranks = range(1, min(families, stage.disk_modes.count) + 1)
    chosen = {"suspension", *(f"{rank}F" for rank in ranks)}
    rotor = _of_families(stage.disk_modes, chosen)
    casing = _of_families(stage.casing_modes, set(CASING_FAMILIES))
    found = coincidences(
        rotor_frequency=rotor.frequency,
        rotor_nodal_diameter=rotor.nodal_diameter,
        casing_frequency=casing.frequency,
        casing_nodal_diameter=casing.nodal_diameter,
    )
    rotor_frequency = rotor.frequency[found.rotor]
    name = "critical speed: none without rotation.effects"
    moving = xr.Dataset(
        {
            each: ("critical", np.empty(0), {"units": unit, "long_name": name})
            for each, unit in (("critical_speed", "1"), ("critical_rpm", "rpm"))
        }
    )
    if stage.turning is not None:
        own, names = disk_waves(stage, stage.turning), names_of(stage.disk_modes)
        found, rotor_frequency = meetings(own, rotor, casing, names, shown[1] * reference)
        moving = at_speed(stage, stage.turning, own, names, chosen, shown)
    normalised = found.speed / reference
    frequency = np.concatenate([rotor.frequency, casing.frequency])
    body = np.repeat(np.array(["bladed-disk", "casing"], dtype=object), [rotor.count, casing.count])
    hertz, one = {"units": "Hz"}, {"units": "1"}
    speed = {"long_name": "coincidence speed, Eq. (14)"}
    met = "coincidence"
    diagram = xr.Dataset(
        {
            "normalised_speed": (met, normalised, one | speed),
            "speed": (met, found.speed * 30.0 / np.pi, {"units": "rpm"} | speed),
            "rotor_frequency": (met, rotor_frequency / (2.0 * np.pi), hertz),
            "casing_frequency": (met, casing.frequency[found.casing] / (2.0 * np.pi), hertz),
            "in_operating_range": (
                met,
                (operated[0] <= normalised) & (normalised <= operated[1]),
            ),
            "mode_frequency": ("mode", frequency / (2.0 * np.pi), hertz),
            "normalised_mode_frequency": ("mode", frequency / reference, one),
        },
        coords={
            "family": (met, _names(rotor)[found.rotor]),
            "casing_family": (met, _names(casing)[found.casing]),
            "nodal_diameter": (met, found.nodal_diameter),
            "mode_body": ("mode", body),
            "mode_family": ("mode", np.concatenate([_names(rotor), _names(casing)])),
            "mode_nodal_diameter": (
                "mode",
                np.concatenate([rotor.nodal_diameter, casing.nodal_diameter]),
            ),
        },
        attrs={
            "title": "Campbell diagram",
            "case": stage.case.title,
            "reference_frequency_hz": reference / (2.0 * np.pi),
            "speeds": shown,
            "operating_range": operated,
        },
    ).set_index(coincidence=["family", "casing_family", "nodal_diameter"])
    return diagram.merge(moving).assign_attrs(moving.attrs)


def _multiples(name: str, ends: Interval, reference: float) -> tuple[float, float]:
    """Both speeds as multiples of the reference frequency."""
    try:
        first, last = (Speed(each).multiple(reference) for each in ends)
    except ValueError as error:
        raise UserError(
            f"campbell: {name} {ends!r}: expected two speeds, each a multiple of the reference"
            f' frequency or text such as "2500 rpm" ({error})'
        ) from None
    if not 0.0 <= first < last:
        raise UserError(
            f"campbell: {name} {ends!r}: expected zero or more, and the second above the first"
        )
    return first, last


def coincidence_list(found: xr.Dataset) -> dict[str, Any]:
    """All coincidences, ascending in speed, and what they are measured in.

    Args:
        found: from `campbell`.
    """
    keys = {
        "nodal_diameter": "nodal_diameter",
        "rotor_family": "family",
        "casing_family": "casing_family",
        "rotor_frequency_hz": "rotor_frequency",
        "casing_frequency_hz": "casing_frequency",
        "speed": "normalised_speed",
        "speed_rpm": "speed",
        "in_operating_range": "in_operating_range",
    }
    return {
        "reference_frequency_hz": found.attrs["reference_frequency_hz"],
        "operating_range": list(found.attrs["operating_range"]),
        "coincidences": rows_of(found, keys),
        **(_speeds_at_speed(found) if "branch" in found.dims else {}),
    }


def _speeds_at_speed(found: xr.Dataset) -> dict[str, Any]:
    """What else JSON tells of a bladed disk that feels that it turns."""
    rpm, met = 60.0 * found.attrs["reference_frequency_hz"], float(found.attrs["waves_meet"])
    parts = {
        "ratio": "speed",
        "rpm": "rpm",
        "k": "nodal_diameter",
        "family": "family",
        "spring_share": "spring_share",
    }

    def listed(kind: str) -> list[dict[str, Any]]:
        return rows_of(found, {key: f"{kind}_{part}" for key, part in parts.items()})

    return {
        "rotation_effects": found.attrs["rotation_effects"],
        "critical_speeds": listed("critical"),
        "engine_orders": listed("engine_order"),
        "waves_meet": None if np.isnan(met) else {"ratio": met, "rpm": rpm * met},
        "clearance_gone": {
            "ratio": found.attrs["clearance_gone"],
            "rpm": rpm * found.attrs["clearance_gone"],
        },
    }


def print_coincidences(found: xr.Dataset) -> None:
    """Print the coincidences inside the diagrams; those in the operating range are bold.

    Args:
        found: from `campbell`.
    """
    first, last = found.attrs["speeds"]
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
    for row in coincidence_list(found)["coincidences"]:
        if first <= row["speed"] <= last:
            table.add_row(
                str(row["nodal_diameter"]),
                row["rotor_family"],
                row["casing_family"],
                f"{row['speed']:.4f}",
                f"{row['speed_rpm']:.1f}",
                "inside" if row["in_operating_range"] else "",
                style="bold" if row["in_operating_range"] else None,
            )
    console = Console()
    console.print(table if table.row_count else f"No coincidence from {first:g} to {last:g}.")
    if "branch" in found.dims:
        for line in _lines_at_speed(found):
            console.print(line)


def _lines_at_speed(found: xr.Dataset) -> Iterator[str]:
    """Critical speeds, and the speed at which growth takes the clearance, in words."""
    told = _speeds_at_speed(found)
    for each in told["critical_speeds"]:
        yield (
            f"Critical speed {each['ratio']:.5f} ω₁ = {each['rpm']:.1f} rpm: {each['family']},"
            f" k = {each['k']} (branches are named as at rest), with"
            f" {100.0 * each['spring_share']:.3g} % of its strain energy in the shaft springs."
        )
    if not told["critical_speeds"]:
        yield f"No critical speed up to {found.attrs['speeds'][1]:g} ω₁."
    met = told["waves_meet"]
    if met is not None:
        yield (
            f"From {met['ratio']:.4f} ω₁ = {met['rpm']:.1f} rpm on two waves of the bladed disk"
            " have one frequency: there it is unstable by itself, without contact."
        )
    gone = told["clearance_gone"]
    yield (
        "The growth of the tips takes a clearance measured cold at"
        f" {gone['ratio']:.4f} ω₁ = {gone['rpm']:.1f} rpm."
    )


def draw_campbell(found: xr.Dataset, folder: Path, *, overwrite: bool = False) -> None:
    """Draw both diagrams into a folder, with the part of the data that they show.

    Raises:
        UserError: a file cannot be written, or is there and not the program's.
    """
    shown = drawn_part(found).reset_index("coincidence")
    frames: tuple[Frame, ...] = get_args(Frame)
    drawn = {f"campbell-{frame}": (plot_campbell(found, frame), shown) for frame in frames}
    save_figures(folder, drawn, overwrite=overwrite)


def write_campbell_page(found: xr.Dataset, path: Path, *, overwrite: bool = False) -> None:
    """Write both diagrams as a page to point at.

    Raises:
        UserError: it cannot be written, or is there and not the program's.
    """
    from bladewhirl.postprocess.reports.campbell import campbell_page  # takes long to load
    from bladewhirl.postprocess.reports.page import write_page

    with writing(path):
        claim_file(path, overwrite=overwrite)
        write_page(campbell_page(found), path)


def _of_families(modes: LabelledModes, wanted: set[str]) -> LabelledModes:
    """Modes of some families, a pair given once."""
    one = modes.one_a_pair()
    return modes.take(one[[modes.family[mode] in wanted for mode in one]])


def _names(modes: LabelledModes) -> np.ndarray[Any, np.dtype[np.object_]]:
    return np.array(modes.family, dtype=object)
