"""Messages of errors are short, and name file and reason."""

import pytest

from bladewhirl.models.inputs.errors import LONGEST, CaseError, Fault, UserError


@pytest.mark.parametrize("make", [UserError, lambda text: CaseError([Fault(expected=text)])])
def test_long_messages_are_cut_in_the_middle(make: type[UserError]) -> None:
    (line,) = make("file.inp: " + "a" * 200_000 + " (the reason)").lines
    assert "file.inp: aa" in line[:30]
    assert line.endswith("aa (the reason)")
    assert " ... " in line
    assert len(line) <= LONGEST
    (same,) = make("short text").lines
    assert same.endswith("short text")
