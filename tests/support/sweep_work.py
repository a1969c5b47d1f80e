"""A small sweep, and stand-ins for its work in a module that workers can import."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from bladewhirl.models.case.file import loads
from bladewhirl.studies.sweeps.points import Outcome, Point, Work, march_point

CASE = loads("""
bladed_disk = { blades = 8, elements_per_blade = 2 }
casing.elements = 16
reduction.fixed_interface_modes = 16
excitation = { type = "imbalance", ramp = 1e-3 }
march = { duration = 6e-3, record_step = 5e-5 }
""")
OVER = {"march.speed": [0.95, 1.05, 1.15], "contact.friction": [0.05, 0.1]}


def march_in_process(
    work: Work, points: Iterable[Point], **_: object
) -> Iterator[tuple[int, Outcome]]:
    """March points one after the other, without the processes of a cluster."""
    for point in points:
        yield point.number, march_point(work, point)


def same_bits(one: Path, other: Path) -> bool:
    """Return whether two folders hold the same dataset, byte by byte."""
    return (one / "sweep.nc").read_bytes() == (other / "sweep.nc").read_bytes()


DEADLY = 2
"""The point that kills whoever marches it."""


def deadly(work: Work, point: Point) -> Outcome:
    """Die at one point."""
    if point.number == DEADLY:
        os._exit(1)
    return {"number": np.array(point.number)}


def of_another_version(work: Work, point: Point) -> Outcome:
    """Fail as a worker does that lacks the code of a point."""
    raise ModuleNotFoundError("No module named 'old'")
