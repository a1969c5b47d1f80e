"""Hints about a case, as warnings of Python."""

from pathlib import Path

import pytest
from small_run import small

from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.studies.runs.run import run


@pytest.mark.usefixtures("pictures_unsaved")
def test_a_path_is_read_and_implausible_values_are_warned_of(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(small(**{"contact.friction": 30.0})))
    with pytest.warns(Hint, match=r"contact.friction = 30.0: expected at most 2 for dry metals"):
        done = run(file, tmp_path / "run", frames=0)
    assert done.summary.steps > 0
