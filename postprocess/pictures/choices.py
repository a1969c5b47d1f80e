"""Choices for pictures of a stage: field that colours beams and wall, frame of reference,
view of surfaces."""

from typing import Literal

Field = Literal[
    "displacement",
    "deformation",
    "velocity",
    "axial-strain",
    "bending-strain",
    "stress",
    "gap",
    "wear",
    "part",
    "joint-state",
    "joint-force",
    "joint-slip",
]

Frame = Literal["static", "rotating"]

View = Literal["oblique", "axial", "side", "line"]
