"""`bladewhirl import`: the tables that it prints, and its file."""

from pathlib import Path

from command_line import answer, refusal
from places import ROOT

from bladewhirl.models.superelements.file import read_superelement

DECK = ROOT / "tests" / "data" / "solids" / "matrices.inp"


def test_an_import_is_told_and_written(tmp_path: Path) -> None:
    target = tmp_path / "blade.npz"
    messages = answer("import", DECK, "--contact", "tip", "--name", "rotor 37", "-o", target).stdout
    words = " ".join(messages.split())
    assert "name rotor 37 source matrices.inp of CalculiX coordinates 24" in words
    assert "rigid modes 0 first frequencies" in words
    assert "300.23" in words  # radius of a corner of the tip [mm]
    part = read_superelement(target)
    assert (part.name, part.contacts) == ("rotor 37", 4)
    again = " ".join(answer("import", target).stdout.split())
    assert words.split("first frequencies")[1].split("contact")[0] in again
    assert "already exists" in refusal("import", DECK, "--contact", "tip", "-o", target)


def test_groups_are_listed_if_there_is_no_such_group() -> None:
    assert "all, every, root, tip" in refusal("import", DECK, "--contact", "top")
