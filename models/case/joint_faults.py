"""Errors of joints that a case cannot have."""

from collections.abc import Iterator

from bladewhirl.models.case.joint import Joint
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs.rules import Inconsistency


def joint_faults(
    joints: tuple[Joint, ...], table: SuperelementTable | None, boundary: str
) -> Iterator[Inconsistency]:
    """Yield the joints that a case cannot have.

    Args:
        joints: all joints of the case.
        table: superelement of the case, if it has one.
        boundary: reduction.boundary of the case.
    """
    if not joints:
        return
    if table is None:
        yield Inconsistency("joint", "not allowed without bladed_disk.superelement")
        return
    if boundary != "massless":
        yield Inconsistency("reduction.boundary", '"massless" with [[joint]]')
    if table.copies < 2:
        expected = "at least 2 blades with [[joint]], as a single one would touch itself"
        yield Inconsistency("bladed_disk.superelement.copies", expected)
    names: dict[str, int] = {}
    taken: dict[int, int] = {}
    for number, joint in enumerate(joints):
        first = names.setdefault(joint.name, number)
        if first != number:
            expected = f"a different name; joint[{first}] has this one"
            yield Inconsistency(f"joint.{number}.name", expected, joint.name)
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
