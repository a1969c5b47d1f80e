"""Natural modes of a case: Dataset, JSON document and tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.modes import ListedModes
from bladewhirl.models.stage.modal import Modelled, modal_model
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

if TYPE_CHECKING:
    import xarray as xr

Values = Mapping[str, np.ndarray[Any, Any]]  #: values of modes by name, (modes,)

LEVELS = {
    "body": "bladed-disk or casing",
    "centre": "free or clamped centre of the bladed disk; empty for the casing",
    "family": "family of the mode",
    "nodal_diameter": "nodal diameter with the largest share of the mode; -1 without sectors",
    "number": "number of the mode of this body and centre, ascending in frequency",
}
"""Coordinates of a mode with their long names; together they are the index of `mode`."""

LISTS = {
    "bladed_disk_free": {"body": "bladed-disk", "centre": "free"},
    "bladed_disk_clamped": {"body": "bladed-disk", "centre": "clamped"},
    "casing": {"body": "casing"},
}
"""Selections of modes, by key of the list in JSON."""

COLUMNS = (
    Column("number", "mode", "d"),
    Column("family", "family"),
    Column("tip_motion", "tip"),
    Column("nodal_diameter", "k", "d"),
    Column("frequency_hz", "[Hz]", ".4f", variable="frequency"),
    Column("normalised", "/ ω₁", ".5f", variable="normalised_frequency"),
    Column("purity", "purity", ".3f"),
    Column("spring_share", "springs", ".1%"),
)
AT_SPEED = (
    Column("family_at_rest", "at rest"),
    Column("direction", "rotating"),
    Column("direction_static", "static"),
)
"""Further columns with rotation effects: the name at rest and the directions of waves."""

NUMBERS = {
    "frequency": ("Hz", "natural frequency"),
    "normalised_frequency": ("1", "natural frequency divided by the reference frequency"),
    "purity": ("1", "share of the nodal diameter in the mode"),
    "spring_share": ("1", "share of the strain energy in springs"),
}
"""Numbers of a mode with their units and long names."""


@dataclass(frozen=True, kw_only=True)
class ModeLists:
    """Modes of the casing and of the bladed disk with each state of its centre, see `modes`."""

    values: Values  #: values of all modes
    attrs: Mapping[str, Any]  #: attributes of the Dataset


def modes(case_or_stage: Modelled, *, count: int = 60) -> xr.Dataset:
    """Compute natural modes of the casing and of the full bladed disk, with free and clamped
    centre.

    Over `mode`: frequency [Hz], normalised_frequency (divided by the lowest frequency of the bladed
    disk with a free centre), purity (share of its nodal diameter in the mode) and spring_share
    (share of the shaft springs in the strain energy). A mode is selected by any of its coordinates
    body, centre, family, nodal_diameter and number::

        modes = bladewhirl.modes(case)
        modes.frequency.sel(body="bladed-disk", centre="free", family="1F", nodal_diameter=1)

    If all blades are equal, this selects two frequencies: of the cosine and the sine mode of a
    pair. `tip_motion` is what the tips of 3D blades with several contact nodes mostly do: flapwise,
    edgewise, torsion, chordwise, radial or mixed. `pattern` is cosine, sine or single. `direction`
    and `direction_static` are the directions of waves in the rotating and in the static frame at
    the speed of the case: standing, or forward and backward with respect to the rotation. With
    Coriolis forces the two waves of a pair differ in frequency, and `pattern` is wave or single.
    With rotation effects, the branch with most of its strain energy in the shaft springs is the
    suspension, and `family_at_rest` is the name of the same branch at rest.
    `modes.reset_index("mode")` can be saved to a file.

    A superelement is a wheel, a wheel of sectors, or one of several equal blades. The centre of a
    wheel with centre_dofs is free or clamped; otherwise it is as in the file, and counts as
    clamped. Modes of a blade have a family but no nodal diameter (-1); so have modes of a wheel
    whose blades are not known, which have no family either. Coriolis forces act if the file has
    their matrix. The casing has modes if it is a ring.

    Args:
        case_or_stage: a case, or its stage.
        count: number of modes of a superelement and each state of its centre; all of beams.

    Returns:
        The modes of each body, ascending. Attributes: `centre`, free or clamped as in the case,
        `reference_frequency_hz`, by which frequencies are normalised, and `speed_rpm`.

    Raises:
        CaseError: finite elements cannot be computed with the numbers of the case.
    """
    if count < 1:
        raise UserError(f"modes: count {count}: expected at least 1")
    import xarray as xr  # takes as long to load as the modes of a sector

    listed = mode_lists(modal_model(case_or_stage, count=count))
    numbers = {
        name: quantity("mode", listed.values[name], *about) for name, about in NUMBERS.items()
    }
    others = {name: ("mode", each) for name, each in listed.values.items() if name not in NUMBERS}
    data = xr.Dataset(numbers, coords=others).set_index(mode=list(LEVELS))
    for name, long_name in LEVELS.items():
        data[name].attrs["long_name"] = long_name
    return data.assign_attrs(title="natural modes", **listed.attrs)


def mode_lists(stage: ModalModel) -> ModeLists:
    """Return the modes of the casing and of the bladed disk, see `modes`."""
    lists = [_modes_of(disk.listed, stage, centre) for centre, disk in stage.disks.items()]
    if stage.casing_modes.count:
        lists.append(_modes_of(stage.casing_modes, stage))
    return ModeLists(
        values={name: np.concatenate([each[name] for each in lists]) for name in lists[0]},
        attrs={
            "centre": stage.centre,
            "rotation_effects": stage.effects,
            "hints": "; ".join(stage.disk.hints),
            "speed_rpm": stage.speed * 30.0 / np.pi,
            "reference_frequency_hz": stage.reference_frequency / (2.0 * np.pi),
        },
    )


def _modes_of(modes: ListedModes, stage: ModalModel, centre: str = "") -> Values:
    """Return all modes of the bladed disk with one state of its centre, or of the casing."""
    rotating, static = modes.named_directions(stage.speed, fixed=not centre)
    texts = {
        "body": ["bladed-disk" if centre else "casing"] * modes.count,
        "centre": [centre] * modes.count,
        "family": modes.family,
        "family_at_rest": modes.at_rest or modes.family,
        "tip_motion": stage.disks[centre].tip_motions if centre else [""] * modes.count,
        "pattern": modes.pattern,
        "direction": rotating,
        "direction_static": static,
    }
    return {
        "frequency": modes.frequency / (2.0 * np.pi),
        "normalised_frequency": modes.frequency / stage.reference_frequency,
        "purity": np.asarray(modes.purity),
        "spring_share": np.asarray(modes.spring_share),
        **{name: np.array(values, dtype=object) for name, values in texts.items()},
        "nodal_diameter": np.asarray(modes.nodal_diameter),
        "number": np.arange(1, modes.count + 1),
    }


def document(listed: ModeLists, count: int) -> dict[str, list[dict[str, Any]]]:
    """Return the JSON document of `modes`: the lowest modes of each body, ascending, with `count`
    frequencies, those of both modes of a degenerate pair.

    With rotation effects, directions of waves are listed too.
    """
    effects = listed.attrs["rotation_effects"] != "none"
    every = (*COLUMNS, *AT_SPEED) if effects else COLUMNS
    known = any(listed.values["tip_motion"])
    columns = [column for column in every if known or column.key != "tip_motion"]
    lists = {"bladed_disk": {"body": "bladed-disk", "centre": listed.attrs["centre"]}} | LISTS
    return {
        name: rows_of(_lowest(data, count), columns)
        for name, selection in lists.items()
        if (data := _selected(listed.values, selection)) is not None
    }


def _selected(values: Values, selection: Mapping[str, str]) -> Values | None:
    """Return the modes of a body; None if it has none."""
    chosen = np.all([values[level] == value for level, value in selection.items()], axis=0)
    return _taken(values, chosen) if chosen.any() else None


def _lowest(values: Values, count: int) -> Values:
    """Return the lowest modes of a body, of which both modes of a pair count as one."""
    counted = np.flatnonzero(values["pattern"] != "sine")
    return _taken(values, slice(counted[count] if count < len(counted) else None))


def _taken(values: Values, chosen: Any) -> Values:
    return {name: each[chosen] for name, each in values.items()}


def report(listed: ModeLists, count: int) -> Study:
    """Return the document and the tables of the lowest modes of each body, in `count` rows.

    A table has one row for both modes of a pair; the columns "purity" and "at rest" are left out if
    they contain no information.
    """
    tables, centre = [], listed.attrs["centre"]
    turning = listed.attrs["rotation_effects"] != "none"
    at = f", at {listed.attrs['speed_rpm']:.6g} rpm" if turning else ""
    columns = (*COLUMNS, *AT_SPEED) if "wave" in listed.values["pattern"] else COLUMNS
    for title, body in (
        (f"Bladed disk, {centre} centre{at}", {"body": "bladed-disk", "centre": centre}),
        ("Casing", LISTS["casing"]),
    ):
        own = _selected(listed.values, body)
        if own is None:
            continue
        data = _lowest(own, count)
        single = _taken(data, data["pattern"] != "sine")
        unknown = bool((single["nodal_diameter"] < 0).all())
        plain = {
            "nodal_diameter": unknown,
            "purity": unknown or bool((single["purity"] > 0.9995).all()),
            "tip_motion": not any(single["tip_motion"]),
            "family_at_rest": bool((single["family"] == single["family_at_rest"]).all()),
        }
        shown = [column for column in columns if not plain.get(column.key, False)]
        tables.append(table(rows_of(single, shown), shown, title))
    return Study(
        name="modes",
        document=document(listed, count),
        tables=tables,
        hints=listed.attrs["hints"],
    )
