"""Faults of a beam model of any origin: unconnected parts, unusable sets."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.inputs.errors import CaseError, Fault

AT_ORIGIN = 1e-9
"""Largest distance of the centre from the origin, in tip radii."""

ROUNDING = 1e-9
"""Largest distance of a node beyond a radius, as a share of it."""


def check_model(model: BeamModel, key: str) -> None:
    """See that a beam model can be a bladed disk.

    Args:
        model: to check.
        key: of the case that it comes from, for the messages.

    Raises:
        CaseError: with all faults, each naming the part.
    """
    faults = [
        *_sets(model, key),
        *_links(model, key),
        *_massless(model, key),
        *_doubled(model, key),
    ]
    faults = faults or [*_loose_parts(model, key)]
    if faults:
        raise CaseError(faults)


def _sets(model: BeamModel, key: str) -> Iterator[Fault]:
    sets = model.mesh.node_sets
    if len(sets["centre"]) != 1:
        yield Fault(key=key, expected=f'one node in the set "centre", not {len(sets["centre"])}')
        return
    if np.linalg.norm(model.mesh.points[model.centre]) > AT_ORIGIN * model.tip_radius:
        x, y = model.mesh.points[model.centre]
        yield Fault(key=key, expected=f"the centre at the origin, not at ({x:.6g}, {y:.6g}) m")
    tips = model.mesh.points[model.tips]
    angles = np.arctan2(tips[:, 1], tips[:, 0])
    steps = np.mod(np.diff(angles, append=angles[0]), 2.0 * np.pi)
    if model.centre in model.tips:
        yield Fault(key=key, expected='a centre that is not in the set "tips"')
    elif len(tips) > 1 and not (np.all(steps > 0.0) and abs(steps.sum() - 2.0 * np.pi) < 1e-6):
        expected = 'the set "tips" counter-clockwise, each tip at an angle of its own'
        yield Fault(key=key, expected=expected)


def _links(model: BeamModel, key: str) -> Iterator[Fault]:
    led = model.links.led
    for node in np.flatnonzero(np.bincount(led, minlength=1) > 1):
        yield Fault(key=key, expected=f"one leader for {_node(model, int(node))}, not several")
    for node in np.intersect1d(led, model.links.leader):
        expected = f"a leader that is not tied itself; {_node(model, int(node))} is"
        yield Fault(key=key, expected=expected)
    for name in ("tips", "centre"):
        for node in np.intersect1d(led, model.mesh.node_sets[name])[:1]:
            expected = f'a set "{name}" of nodes that are not tied; {_node(model, int(node))} is'
            yield Fault(key=key, expected=expected)


def _massless(model: BeamModel, key: str) -> Iterator[Fault]:
    """Yield nodes connected by springs only that lack inertia."""
    count = len(model.mesh.points)
    bare = np.ones(count, dtype=np.bool_)
    bare[model.mesh.lines] = bare[model.links.led] = False
    bare[model.links.leader] = False
    mass, inertia = np.zeros(count), np.zeros(count)
    np.add.at(mass, model.masses.node, model.masses.mass)
    np.add.at(inertia, model.masses.node, model.masses.inertia)
    inertia[model.mesh.node_sets["centre"]] = np.inf  # it does not rotate
    for node in np.flatnonzero(bare & ((mass <= 0.0) | (inertia <= 0.0))):
        expected = f"a beam, or a mass with rotary inertia, at {_node(model, int(node))}"
        yield Fault(key=key, expected=expected)


def _doubled(model: BeamModel, key: str) -> Iterator[Fault]:
    """Yield overlapping lines, whose mass would count twice."""
    parts = np.array(model.mesh.line_parts)
    ends = np.sort(model.mesh.lines, axis=1)
    _, first, number = np.unique(ends, axis=0, return_index=True, return_inverse=True)
    reported: set[tuple[str, str]] = set()
    for line in np.flatnonzero(first[number.ravel()] != np.arange(len(ends))):
        names = str(parts[first[number.ravel()[line]]]), str(parts[line])
        if names in reported:
            continue
        reported.add(names)
        between = " and ".join(_node(model, int(node)) for node in ends[line])
        which = (
            f"parts {names[0]!r} and {names[1]!r} both lie"
            if len({*names}) == 2
            else (f"two of part {names[0]!r} lie")
        )
        yield Fault(key=key, expected=f"one beam between two nodes; {which} between {between}")


def _loose_parts(model: BeamModel, key: str) -> Iterator[Fault]:
    """Parts that neither beams, springs nor links join to the centre."""
    mesh, count = model.mesh, len(model.mesh.points)
    joints = model.joints
    graph = sp.csr_array((np.ones(len(joints)), (joints[:, 0], joints[:, 1])), shape=(count, count))
    groups, group = connected_components(graph, directed=False)
    if groups == 1:
        return
    parts = np.array(mesh.line_parts)
    reported: set[str] = set()
    for number in range(groups):
        if number == group[model.centre]:
            continue
        names = sorted(set(parts[group[mesh.lines[:, 0]] == number].tolist()))
        first = int(np.flatnonzero(group == number)[0])
        what = f"part {names[0]!r}" if names and names[0] else "node"
        if what not in reported:
            reported.add(what)
            where = _node(model, first) if what == "node" else f"{what} at {_at(model, first)}"
            expected = f"all parts joined to the centre; {where} is not"
            yield Fault(key=key, expected=expected)


def part_outside(model: BeamModel, radius: float) -> str | None:
    """Return the part that exceeds a radius most [m] and its position; None if none does."""
    mesh, away = model.mesh, np.linalg.norm(model.mesh.points, axis=1)
    node = int(away.argmax())
    if away[node] <= radius * (1.0 + ROUNDING):
        return None
    lines = np.flatnonzero((mesh.lines == node).any(axis=1))
    names = [mesh.line_parts[line] for line in lines if mesh.line_parts[line]]
    where = f"part {names[0]!r} at {_at(model, node)}" if names else _node(model, node)
    return f"{where} is outside by {away[node] - radius:.3g} m"


def _node(model: BeamModel, node: int) -> str:
    names = [name for name, nodes in model.mesh.node_sets.items() if node in nodes]
    called = f" of {names[0]!r}" if names else ""
    return f"node {node}{called} at {_at(model, node)}"


def _at(model: BeamModel, node: int) -> str:
    x, y = model.mesh.points[node]
    return f"({x:.4g}, {y:.4g}) m"
