"""A small sweep, and stand-ins for its work in a module that workers can import."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from bladewhirl.models.case.case import Case, March
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.studies.sweeps.points import Failure, Group, Outcome, Work, march_group

CASE = Case(excitation=Imbalance(ramp=1e-3), march=March(duration=6e-3, record_step=5e-5))
OVER = {"march.speed": [0.95, 1.05, 1.15], "contact.friction": [0.05, 0.1]}


def march_in_process(
    work: Work, groups: Iterable[Group], **_: object
) -> Iterator[Mapping[int, Outcome]]:
    """March the groups one after the other, without the processes of a cluster."""
    for group in groups:
        yield march_group(work, group)


def same_bits(one: Path, other: Path) -> bool:
    """Return whether two folders hold the same dataset, byte by byte."""
    return (one / "sweep.nc").read_bytes() == (other / "sweep.nc").read_bytes()


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
