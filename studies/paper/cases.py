"""The cases that the paper is judged by: its stage for modal work, and its two scenarios.

The files in examples/ say the same with reasons; a test holds them together.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values

Scenario = Literal["modal", "distortion", "imbalance"]

CONTACT = {"casing.support": 7.975e6, "damping.ratio": 0.001}
"""In which the stage of the two scenarios differs from that of modal work."""

CASES: Mapping[Scenario, Case] = {
    "modal": Case(),
    "distortion": with_values(
        Case(title="Casing distortion of one nodal diameter"),
        {**CONTACT, "excitation": {"type": "casing-distortion", "duration": 0.01}},
    ),
    "imbalance": with_values(
        Case(title="Mass imbalance"),
        {**CONTACT, "excitation": {"type": "imbalance", "ramp": 0.1}},
    ),
}
"""Cases by scenario."""


def changed(scenario: Scenario, changes: Mapping[str, Any]) -> Case:
    """A case with other values, by dotted key.

    Keys of `excitation` that belong to the other scenario's load are left out, and so is the title.

    Raises:
        CaseError: all faults of the new case.
    """
    case = CASES[scenario]
    keys = type(case.excitation).model_fields
    prefix = "excitation."
    values = {
        key: value
        for key, value in changes.items()
        if not key.startswith(prefix) or key.removeprefix(prefix) in keys
    }
    return with_values(case, values)
