"""Stand-ins for the work of a sweep, in a module that workers can import."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from bladewhirl.studies.sweeps.points import Failure, Group, Outcome, Work

DEADLY = 2
"""The point that kills whoever marches it."""


def deadly(work: Work, group: Group) -> dict[int, Outcome]:
    """Dies at one point; at others leaves a note of having been there."""
    if DEADLY in group.points:
        os._exit(1)
    for point in group.points:
        with (Path(work.histories) / str(point)).open("a") as note:
            note.write("done\n")
    return {point: {"number": np.array(point)} for point in group.points}


def deadly_once(work: Work, group: Group) -> dict[int, Outcome]:
    """Dies at one point the first time only."""
    mark = Path(work.histories) / "died"
    if DEADLY in group.points and not mark.exists():
        mark.touch()
        os._exit(1)
    return {point: Failure(reason=f"point {point}") for point in group.points}


def of_another_version(work: Work, group: Group) -> dict[int, Outcome]:
    """Fails as a worker does that lacks the code of a group."""
    raise ModuleNotFoundError("No module named 'old'")
