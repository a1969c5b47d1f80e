"""Hints about a run whose motion is outside the range of the linear model."""

import xarray as xr

from bladewhirl.models.case.analysis import Contact
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.by_blade import (
    LARGE_DISPLACEMENT,
    WRONG_BY_A_TENTH,
    blade_length,
)
from bladewhirl.postprocess.fields.drawback import largest_drawback
from bladewhirl.postprocess.fields.kinematics import ViewError, table_of_result
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.run.joint_contact import joint_hints
from bladewhirl.postprocess.run.summary import Summary

ELASTIC = 5e-3  #: strain above which no metal is elastic


def run_hints(summary: Summary, result: xr.Dataset) -> tuple[str, ...]:
    """Return hints about large displacements, about stresses that no metal bears, and about joints
    that do not touch or do not slip."""
    hints = _of_displacements(summary, result) + _of_stress(summary, result)
    return (*hints, *joint_hints(result))


def _of_displacements(summary: Summary, result: xr.Dataset) -> tuple[str, ...]:
    """Return a hint if the displacement of a tip exceeds the limit of a linear model, which is
    `LARGE_DISPLACEMENT` times the length of a blade. The hint says by how much tips of beams drew
    back."""
    moved, length = summary.tip_displacement_max, blade_length(result)
    if moved <= LARGE_DISPLACEMENT * length:
        return ()
    hint = f"tips moved up to {moved:.3g} m, {moved / length:.2g} of the length of a blade; "
    if moved > WRONG_BY_A_TENTH * length:
        hint += "the linear model is off by a tenth or more: the regime is valid, the displacements"
        hint += " are not"
    else:
        hint += "the linear model neglects that bent blades draw back, and is off by a tenth from a"
        hint += " third of the length on"
    return (f"{hint}{_drawn_back(result)}",)


def _of_stress(summary: Summary, result: xr.Dataset) -> tuple[str, ...]:
    """Return a hint if the largest stress exceeds `ELASTIC` times Young's modulus, and the case
    gives no yield strength that the summary compares it with."""
    peak = (summary.stress_max or {}).get("bladed_disk")
    if peak is None or summary.yield_strength is not None:
        return ()
    largest = float(points_of(result, 1).modulus.max(initial=0.0))
    strain = abs(peak["stress"]) / largest if largest else 0.0
    if strain <= ELASTIC:
        return ()
    return (
        f"the largest stress is {100 * strain:.2g} % of Young's modulus, above the"
        f" {100 * ELASTIC:g} % up to which metals may be elastic: reduce the overlap of lobes and"
        " closure, the friction or the load, change the speed, or give casing.coating;"
        " material.yield_strength replaces this limit",
    )


def _drawn_back(result: xr.Dataset) -> str:
    """Return the end of the hint: the distance by which tips drew back."""
    try:
        if not points_of(result, 1).flat:
            return ""
        drawn = handy(largest_drawback(result), "m", 4)
    except ViewError:  # no points, or tips that end no beam
        return ""
    contact = table_of_result(result, "contact", Contact)
    if contact.foreshortening:
        return f"; bent blades drew back from the wall by up to {drawn}"
    return (
        f"; bent blades would draw back from the wall by up to {drawn}, which"
        " contact.foreshortening = true takes into account"
    )
