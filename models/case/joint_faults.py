"""Errors between the joints of a case."""

from collections.abc import Iterator

from bladewhirl.models.case.joint import Joint
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs.rules import Inconsistency


def joint_faults(joints: tuple[Joint, ...], table: SuperelementTable) -> Iterator[Inconsistency]:
    """Yield names, nodes and joints of a superelement that do not fit together."""
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
