"""What Python prints of models: one line."""

from __future__ import annotations

import pytest

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.check import case_from
from bladewhirl.models.case.file import with_values
from bladewhirl.models.elements.build import case_beam_model
from bladewhirl.models.inputs.errors import CaseError


def test_a_beam_model_is_a_line() -> None:
    model = case_beam_model(Case())
    nodes, lines = len(model.mesh.points), len(model.mesh.lines)
    expected = f"<BeamModel: {nodes} nodes, {lines} lines, 22 tips, {model.mass:.4g} kg>"
    assert repr(model) == expected


def test_nested_tables_make_a_case_with_a_line_a_fault() -> None:
    assert case_from({"march": {"speed": 1.2}}) == with_values(Case(), {"march.speed": 1.2})
    with pytest.raises(CaseError, match=r"^march.duration = -1: expected"):
        case_from({"march": {"duration": -1}})
