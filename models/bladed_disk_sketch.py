"""The sketch of a bladed disk that a few numbers describe."""

from __future__ import annotations

from bladewhirl.models.sections import Section
from bladewhirl.models.sketch import Sketch


def bladed_disk_sketch(
    *,
    blades: int,
    tip_radius: float,
    disk_radius: float,
    elements_per_blade: int,
    blade: Section,
    disk: Section,
) -> Sketch:
    """Draw the bladed disk of the paper's Fig. 3(a).

    Each sector holds one blade of equal elements from ``disk_radius`` to ``tip_radius`` [m], one
    spoke from the centre to the blade root, and one straight rim line to the next root.

    Node sets: ``tips``, ``roots``, ``centre``. Line sets: ``blades``, ``spokes``, ``rim``.
    """
    sketch = Sketch(blades, tip_radius=tip_radius)
    sketch.node("centre", 0.0, 0.0, shared=True)
    sketch.node("root", disk_radius)
    sketch.node("tip", tip_radius)
    sketch.member("blades", "root", "tip", blade, elements=elements_per_blade)
    sketch.member("spokes", "centre", "root", disk)
    sketch.member("rim", "root", "root+1", disk)
    for name, node in (("centre", "centre"), ("tips", "tip"), ("roots", "root")):
        sketch.set(name, node)
    return sketch
