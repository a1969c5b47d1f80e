"""Files appear whole, past links and folders in the way."""

import os
from pathlib import Path

import pytest

from bladewhirl.files import MANIFEST_NAME, claim, replacing, write_atomically


def test_a_planted_link_is_not_followed(tmp_path: Path) -> None:
    theirs = tmp_path / "theirs.txt"
    theirs.write_text("precious")
    target = tmp_path / "out" / "case.toml"
    target.parent.mkdir()
    for name in ("case.toml", ".case.toml", ".case.part.toml", "case.toml.part"):
        (target.parent / name).symlink_to(theirs)
    write_atomically(target, "new")
    assert theirs.read_text() == "precious"
    assert target.read_text() == "new"
    assert not target.is_symlink()


def test_drafts_are_private_and_go(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")

    def break_off() -> None:
        with replacing(target) as draft:
            draft.write_text("half")
            assert draft.parent.stat().st_mode & 0o077 == 0
            raise KeyError

    with pytest.raises(KeyError):
        break_off()
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_neither_a_folder_nor_a_pipe_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    for name in ("folder", "pipe"):
        with pytest.raises(OSError, match="not a regular file"):
            write_atomically(tmp_path / name, "new")
    assert sorted(os.listdir(tmp_path)) == ["folder", "pipe"]


@pytest.mark.parametrize(("folder", "name"), [("run/plots", "a.png"), ("run", "frames/a.vtu")])
def test_a_folder_that_is_a_link_elsewhere_is_refused(
    tmp_path: Path, folder: str, name: str
) -> None:
    (tmp_path / "theirs").mkdir()
    claim(tmp_path / "run", ["case.toml"])
    place = (tmp_path / folder / name).parent
    place.symlink_to(tmp_path / "theirs")
    with pytest.raises(OSError, match="it is a link to another folder"):
        claim(tmp_path / folder, [name])
    assert not os.listdir(tmp_path / "theirs")
    assert (tmp_path / "run" / MANIFEST_NAME).exists()
