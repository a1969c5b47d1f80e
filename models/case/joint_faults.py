"""Errors between the joints of a case."""

from collections.abc import Iterator

from bladewhirl.models.case.bladed_disk import BladedDisk
from bladewhirl.models.case.joint import Joint
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs.rules import Inconsistency


def joint_faults(joints: tuple[Joint, ...], table: SuperelementTable) -> Iterator[Inconsistency]:
    """Yield names, nodes and joints of a superelement that do not fit together."""
    taken: dict[int, int] = {}
    yield from _name_faults(joints)
    for number, joint in enumerate(joints):
        if joint.ring is not None:
            yield Inconsistency(f"joint.{number}.ring", "not allowed with a superelement")
        try:
            left, right = table.joint_nodes(joint)
        except ValueError as reason:
            yield Inconsistency(f"joint.{number}.left", str(reason), list(joint.left))
            continue
        for node in {*left, *right}:
            first = taken.setdefault(node, number)
            if first != number:
                expected = f"nodes that no other joint has; joint[{first}] has node {node}"
                yield Inconsistency(f"joint.{number}.left", expected, list(joint.left))
                break


def ring_faults(joints: tuple[Joint, ...], disk: BladedDisk) -> Iterator[Inconsistency]:
    """Yield names and rings of the joints of a bladed disk of beams that do not fit together."""
    taken: dict[int, int] = {}
    yield from _name_faults(joints)
    for number, joint in enumerate(joints):
        ring, rings = joint.cut_ring, len(disk.shrouds)
        first = taken.setdefault(ring, number)
        if not ring < rings:
            expected = f"a row of bladed_disk.shrouds, from 0 to {rings - 1}"
            yield Inconsistency(f"joint.{number}.ring", expected, ring)
        elif first != number:
            expected = f"a ring that no other joint cuts; joint[{first}] cuts ring {ring}"
            yield Inconsistency(f"joint.{number}.ring", expected, ring)
        elif disk.shrouds[ring].cuts:
            expected = f"no cuts, as joint[{number}] cuts this ring between all blades"
            yield Inconsistency(f"bladed_disk.shrouds.{ring}.cuts", expected)
        if joint.left or joint.right:
            expected = "not allowed with beams; ring chooses the shroud whose ends touch"
            yield Inconsistency(f"joint.{number}.left", expected)
        if joint.direction[2]:
            key = "angle" if joint.normal is None else "normal"
            expected = "a normal in the plane of the disk, as beams do not move along the axis"
            yield Inconsistency(f"joint.{number}.{key}", expected)


def _name_faults(joints: tuple[Joint, ...]) -> Iterator[Inconsistency]:
    names: dict[str, int] = {}
    for number, joint in enumerate(joints):
        first = names.setdefault(joint.name, number)
        if first != number:
            expected = f"a different name; joint[{first}] has this one"
            yield Inconsistency(f"joint.{number}.name", expected, joint.name)
