"""Coincidence speeds of bladed disk and casing: Dataset, JSON document, figures, page."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.files import claim_file
from bladewhirl.models.case.applied_orders import applied_orders
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.models.inputs.units import speed_of
from bladewhirl.models.modal.labels import LabelledModes, names_of
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.stage.modal import Modelled, modal_model
from bladewhirl.postprocess.modal.operating_range import UNKNOWN, operating_range
from bladewhirl.solvers.stability.coincidence import coincidences
from bladewhirl.studies.modal.campbell_at_speed import (
    dataset_at_speed,
    meetings,
    refuse_unequal_bearings,
)
from bladewhirl.studies.modal.resonances import COLUMNS as RESONANCES
from bladewhirl.studies.modal.resonances import resonances
from bladewhirl.studies.modal.speeds_to_avoid import COLUMNS as AVOID
from bladewhirl.studies.modal.speeds_to_avoid import NEAR, speeds_to_avoid
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, facts, quantity, rows_of, table, texts

Interval = tuple[float | str, float | str]
"""First and last speed: each a multiple of the reference frequency, or text such as "2500 rpm"."""

WIDEST = 3.0
"""Upper end of the diagrams by default, as a multiple of the reference frequency; that of the speed
of the case if this is lower."""

CASING_FAMILIES = ("rigid", "1F", "2F")  #: families of the casing: rigid motion, bending, extension


def campbell(
    case_or_stage: Modelled,
    *,
    families: int = 5,
    speeds: Interval | None = None,
    operating: Interval | None = None,
    orders: Sequence[int] = (),
) -> xr.Dataset:
    """Compute the speeds at which waves on bladed disk and casing coincide, Eq. (14), and these
    waves.

    Variables over `coincidence`, ascending: normalised_speed (divided by the reference frequency),
    speed [rpm], the frequency of both modes [Hz] and whether the speed lies in the operating range.
    A coincidence is selected by family (of the bladed disk), casing_family and nodal_diameter::

        diagram = bladewhirl.campbell(case)
        diagram.normalised_speed.sel(family="1F", nodal_diameter=1)

    Over `mode`, once per pair: mode_frequency [Hz] and normalised_mode_frequency, with
    mode_body, mode_family and mode_nodal_diameter. `diagram.reset_index("coincidence")` can be
    saved to a file; `bladewhirl.plot.campbell` draws it.

    Over `resonance`, if all blades are equal: the speeds at which waves of the wall and of engine
    orders excite the bladed disk, with free and with held tips, see `resonances.resonances`. The
    orders are the lobes of the wall and the engine orders of the case, and those given.

    Over `critical`: critical_speed (normalised) and critical_rpm, up to the last of `speeds`; empty
    without rotation effects. With rotation effects, the Dataset also has:

    - critical_nodal_diameter, critical_spring_share (share of the strain energy in the shaft
      springs), critical_family and critical_family_at_rest;
    - over `engine_order` the same variables for the speeds at which the frequency of a wave in the
      rotating frame is k times the frequency of rotation, so that a static force excites the wave;
    - over `branch` and `line_speed` (normalised), branch_frequency in the rotating frame [Hz],
      positive backward, with branch_family at the first speed, branch_family_at_rest,
      branch_nodal_diameter and branch_direction;
    - over `line_speed`, tip_growth [m];
    - the attributes clearance_gone, the normalised speed at which the growth of the tips equals the
      clearance, and waves_meet, the normalised speed above which two waves of the bladed disk have
      merged and one of them grows; nan if there is no such speed.

    A family follows from the strain energy at the speed: the branch with most of its energy in the
    shaft springs is the suspension. `family_at_rest` is the name of the same branch at rest.

    Args:
        case_or_stage: a case, or its stage; the centre is free or clamped as in the case.
        families: number of families of the bladed disk, without the suspension pair.
        speeds: ends of the diagrams, each a multiple of the reference frequency or text such as
            "2500 rpm"; when None 0 and 3, or thrice the speed of the case if that is lower. With
            rotation effects, coincidences are computed up to the second end only;
            a mode, such as 1F with nodal diameter 1, can have none below this speed.
        operating: ends of the operating range, in the form of `speeds`; None if it is not known.
        orders: numbers of waves around the wall, besides those of the case.

    Raises:
        CaseError: finite elements cannot be computed with the numbers of the case.
        UserError: a range does not consist of two speeds in ascending order, or orders are given
            and blades differ.
    """
    stage = modal_model(case_or_stage, families=families)
    refuse_unequal_bearings("campbell", stage.case, allowed="full")
    reference = stage.reference_frequency
    if speeds is None:
        own = abs(stage.speed) / reference
        speeds = (0.0, WIDEST * min(own or 1.0, 1.0))
    shown = _multiples("speeds", speeds, reference)
    stage = stage.covering(shown[1] * reference)
    operated = UNKNOWN if operating is None else _multiples("operating", operating, reference)
    ranks = range(1, min(families, stage.disk_modes.count) + 1)
    chosen = {"suspension", *(f"{rank}F" for rank in ranks)}
    rotor = _of_families(stage.disk_modes, chosen)
    casing = _of_families(stage.casing_modes, set(CASING_FAMILIES))
    met = coincidences(
        rotor_frequency=rotor.frequency,
        rotor_nodal_diameter=rotor.nodal_diameter,
        casing_frequency=casing.frequency,
        casing_nodal_diameter=casing.nodal_diameter,
    )
    rotor_frequency, family = rotor.frequency[met.rotor], _families(rotor)[met.rotor]
    at_rest = family
    name = "critical speed, only with rotation effects"
    at_speed = xr.Dataset(
        {
            "critical_speed": quantity("critical", np.empty(0), "1", name),
            "critical_rpm": quantity("critical", np.empty(0), "rpm", name),
        }
    )
    if stage.turns:
        waves, names = stage.waves, names_of(stage.disk_modes)
        met, rotor_frequency, renamed = meetings(waves, rotor, casing, names, shown[1] * reference)
        family = np.array(renamed, dtype=object)
        at_rest = np.array(rotor.at_rest or rotor.family, dtype=object)[met.rotor]
        at_speed = dataset_at_speed(stage, waves, names, chosen, shown)
    if (turned := _excited(stage, chosen, orders, shown, operated)) is not None:
        at_speed = at_speed.merge(turned)
    normalised, hertz = met.speed / reference, 2.0 * np.pi
    frequency = np.concatenate([rotor.frequency, casing.frequency])
    diameter = np.concatenate([rotor.nodal_diameter, casing.nodal_diameter])
    body = np.repeat(np.array(["bladed-disk", "casing"], dtype=object), [rotor.count, casing.count])
    inside = (operated[0] <= normalised) & (normalised <= operated[1])
    speed, along = "coincidence speed, Eq. (14)", "coincidence"
    diagram = xr.Dataset(
        {
            "normalised_speed": quantity(along, normalised, "1", speed),
            "speed": quantity(along, met.speed * 30.0 / np.pi, "rpm", speed),
            "rotor_frequency": quantity(along, rotor_frequency / hertz, "Hz"),
            "casing_frequency": quantity(along, casing.frequency[met.casing] / hertz, "Hz"),
            "in_operating_range": (along, inside),
            "mode_frequency": quantity("mode", frequency / hertz, "Hz"),
            "normalised_mode_frequency": quantity("mode", frequency / reference, "1"),
        },
        coords={
            "family": (along, family),
            "family_at_rest": (along, at_rest),
            "casing_family": (along, _families(casing)[met.casing]),
            "nodal_diameter": (along, met.nodal_diameter),
            "mode_body": ("mode", body),
            "mode_family": ("mode", np.concatenate([_families(rotor), _families(casing)])),
            "mode_nodal_diameter": ("mode", diameter),
        },
        attrs={
            "title": "Campbell diagram",
            "case": stage.case.title,
            "reference_frequency_hz": reference / hertz,
            "case_speed": stage.speed / reference,
            "speeds": shown,
            "blades": stage.case.bladed_disk.count,
            "hints": "; ".join(stage.disk.hints),
            "without_joints": int(bool(stage.case.joint)),
            "operating_range": operated,
        },
    ).set_index(coincidence=["family", "casing_family", "nodal_diameter"])
    return diagram.merge(at_speed).assign_attrs(at_speed.attrs)


def _excited(
    stage: ModalModel,
    chosen: set[str],
    orders: Sequence[int],
    shown: tuple[float, float],
    operating: tuple[float, float],
) -> xr.Dataset | None:
    """Return the resonances of the wall and of engine orders; None without orders, or if blades
    differ, so that every order excites all nodal diameters.

    Raises:
        UserError: blades differ, and orders were given.
    """
    own = applied_orders(stage.case.casing, stage.case.excitations.values())
    sources = own | dict.fromkeys(orders, "given")
    if not sources:
        return None
    try:
        waves = stage.waves
    except UserError as error:
        if orders:
            raise UserError(f"campbell: orders: {error}") from None
        return None
    reference, names = stage.reference_frequency, names_of(stage.disk_modes)
    ends = shown[0] * reference, shown[1] * reference
    operated = operating[0] * reference, operating[1] * reference
    return resonances(stage, waves, names, chosen, sources, ends, operated)


def _multiples(name: str, ends: Interval, reference: float) -> tuple[float, float]:
    """Return both speeds as multiples of the reference frequency."""
    label = f"campbell: {name} {ends!r}"
    multiples = [speed_of(end, label).multiple(reference) for end in ends]
    if len(multiples) != 2 or not 0.0 <= multiples[0] < multiples[1]:
        raise UserError(f"{label}: expected two speeds of zero or more, the second above the first")
    return multiples[0], multiples[1]


COINCIDENCES = (
    Column("nodal_diameter", "k", "d"),
    Column("rotor_family", "bladed disk", variable="family"),
    Column("casing_family", "casing"),
    Column("rotor_frequency_hz", variable="rotor_frequency"),
    Column("casing_frequency_hz", variable="casing_frequency"),
    Column("speed", "Ω / ω₁ [–]", ".4f", variable="normalised_speed"),
    Column("speed_rpm", "[rpm]", ".1f", variable="speed"),
    Column("in_operating_range", "operating"),
)
CRITICAL_SPEEDS = (
    Column("k", "k", "d", variable="nodal_diameter"),
    Column("family", "family"),
    Column("family_at_rest", "at rest"),
    Column("ratio", "Ω / ω₁ [–]", ".5f", variable="speed"),
    Column("rpm", "[rpm]", ".1f"),
    Column("spring_share", "energy in springs [%]", ".3g", 100.0),
)
"""Columns of critical speeds (variables "critical_...") and engine orders ("engine_order_...")."""

SPECIAL_SPEEDS = (
    Column("waves_meet", "two waves merge and grow without contact from", ".6g"),
    Column("clearance_gone", "tip growth equals the clearance at rest at", ".6g"),
)


def _coincidences(diagram: xr.Dataset) -> Sequence[Column]:
    """Return the columns of coincidence speeds; the last only if an operating range is given."""
    return COINCIDENCES[: -1 if operating_range(diagram) is None else None]


def _resonances(diagram: xr.Dataset) -> Sequence[Column]:
    """Return the columns of resonances; the last only if an operating range is given, and those of
    waves only with several blades."""
    columns = RESONANCES[: -1 if operating_range(diagram) is None else None]
    alone = diagram.attrs["blades"] == 1
    return [each for each in columns if not (alone and each.key in {"k", "direction"})]


def coincidence_list(diagram: xr.Dataset) -> dict[str, Any]:
    """Return the JSON document of `campbell`: coincidences, ascending, and critical speeds."""
    document = {
        "reference_frequency_hz": diagram.attrs["reference_frequency_hz"],
        "operating_range": operating_range(diagram),
        "coincidences": rows_of(diagram, _coincidences(diagram)),
    }
    if "resonance" in diagram.dims:
        document["resonances"] = rows_of(diagram, _resonances(diagram), "resonance_")
    if "branch" not in diagram.dims:
        return document

    def speed(name: str) -> dict[str, float] | None:
        ratio = float(diagram.attrs[name])
        if np.isnan(ratio):
            return None
        return {"ratio": ratio, "rpm": 60.0 * document["reference_frequency_hz"] * ratio}

    return document | {
        "rotation_effects": diagram.attrs["rotation_effects"],
        "critical_speeds": rows_of(diagram, CRITICAL_SPEEDS, "critical_"),
        "engine_orders": rows_of(diagram, CRITICAL_SPEEDS, "engine_order_"),
        "waves_meet": speed("waves_meet"),
        "clearance_gone": speed("clearance_gone"),
    }


def report(diagram: xr.Dataset, *, page: Path | None = None, overwrite: bool = False) -> Study:
    """Return the document, tables and figures of `campbell`, with both frames (rotating, static).
    Unless `page` is None, write both diagrams into this file, as an interactive page.

    Raises:
        UserError: the page cannot be written, or exists and was not written by bladewhirl.
    """
    document, operated = coincidence_list(diagram), operating_range(diagram)
    first, last = diagram.attrs["speeds"]
    rows = [row for row in document["coincidences"] if first <= row["speed"] <= last]
    tables: list[Any] = []
    if "casing" in diagram["mode_body"].values:
        title = f"Coincidence speeds from {first:g} to {last:g} ω₁"
        tables.append(table(rows, _coincidences(diagram), title))
    if document.get("resonances"):
        title = "Resonances with waves of the wall and engine orders"
        if operated is not None:
            title += ", by distance from the operating range"
        tables.append(table(document["resonances"], _resonances(diagram), title))
    if document.get("critical_speeds"):
        title = f"Critical speeds up to {last:g} ω₁"
        tables.append(table(document["critical_speeds"], CRITICAL_SPEEDS, title))
        tables.append(facts(texts(document, SPECIAL_SPEEDS)))
    if not tables:
        none = "No engine order or lobe of the wall excites a family between these speeds"
        tables.append(f"{none}; --orders adds orders.")
    if operated is not None:
        low, high = (60.0 * diagram.attrs["reference_frequency_hz"] * each for each in operated)
        avoided = document["speeds_to_avoid"] = speeds_to_avoid(document, (low, high))
        near = f"to {NEAR:.0%} from the operating range"
        near = f"for blades without joints, {near}" if diagram.attrs["without_joints"] else near
        title = f"Speeds to avoid, {near}"
        tables.append(table(avoided, AVOID, title) if avoided else f"No speeds to avoid, {near}.")
    if page is not None:
        from bladewhirl.postprocess.reports.campbell import campbell_page
        from bladewhirl.postprocess.reports.page import write_page

        with writing(page):
            claim_file(page, overwrite=overwrite)
            write_page(campbell_page(diagram), page)

    def figures() -> Figures:
        from bladewhirl.postprocess.modal.campbell import drawn_part, frames_of, plot_campbell

        data, frames = drawn_part(diagram).reset_index("coincidence"), frames_of(diagram)
        return {f"campbell-{frame}": (plot_campbell(diagram, frame), data) for frame in frames}

    return Study(
        name="campbell",
        document=document,
        tables=tables,
        figures=figures,
        hints=diagram.attrs["hints"],
        page=page,
    )


def _of_families(modes: LabelledModes, families: set[str]) -> LabelledModes:
    """Return the modes of some families, with one mode of each pair."""
    one = modes.one_a_pair()
    names = modes.at_rest or modes.family
    return modes.take(one[[names[mode] in families for mode in one]])


def _families(modes: LabelledModes) -> np.ndarray[Any, np.dtype[np.object_]]:
    return np.array(modes.family, dtype=object)
