"""Nested dissection: an order of elimination that keeps the triangular factor of a sparse matrix
small (George 1973, SIAM J. Numer. Anal. 10(2)).

Unknowns with the same neighbours, such as the displacements of one node, form a group. The graph of
the groups is split by a small separator into two parts, which are split further; a separator is
eliminated after the two parts. A split is where the differences of the distances from two remote
groups have their median; its separator is the smallest set of groups that touches all edges across
it, which follows from a largest matching of the groups on both sides (Koenig's theorem).
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import (
    breadth_first_order,
    connected_components,
    maximum_bipartite_matching,
)

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

SMALLEST = 150
"""Number of unknowns of a part that is not split any further."""

SHARES = (0.4, 0.45, 0.5, 0.55, 0.6)
"""Shares of the unknowns on one side of the splits that are compared."""


def dissected(matrix: sp.csr_array) -> list[IntArray]:
    """Return sets of unknowns in the order of their elimination.

    Unknowns of two sets are neighbours only if one of the sets separates the part in which the
    other one lies.

    Args:
        matrix: matrix with a symmetric pattern and a full diagonal, (n, n).
    """
    group = _groups(matrix)
    size = np.bincount(group)
    one_of_each = np.unique(group, return_index=True)[1]
    rows = matrix[one_of_each]
    pairs = np.repeat(np.arange(len(size)), np.diff(rows.indptr)), group[rows.indices]
    graph = sp.csr_array((np.ones(rows.nnz), pairs), shape=(len(size), len(size)))
    graph.setdiag(0.0)
    graph.eliminate_zeros()
    graph.data[:] = 1.0
    members = np.split(np.argsort(group, kind="stable"), np.cumsum(size)[:-1])
    found: list[IntArray] = []
    waiting = [(np.arange(len(size)), graph)]
    # Parts come before their separator: the list is made from its end.
    while waiting:
        groups, within = waiting.pop()
        if size[groups].sum() <= SMALLEST:
            parts, last = list[IntArray](), groups
        else:
            parts, last = _split(within, size[groups])
            last = groups[last]
        if len(last):
            found.append(np.concatenate([members[one] for one in last]))
        waiting += [(groups[part], within[part][:, part]) for part in parts]
    return found[::-1]


def _groups(matrix: sp.csr_array) -> IntArray:
    """Return the number of the group of each unknown; a group has the same pattern of its rows."""
    marks = np.random.default_rng(0).integers(1, 2**40, matrix.shape[0])
    pattern = sp.csr_array(
        (np.ones(matrix.nnz, dtype=np.int64), matrix.indices, matrix.indptr), shape=matrix.shape
    )
    return np.asarray(np.unique(pattern @ marks, return_inverse=True)[1])


def _split(graph: sp.csr_array, size: IntArray) -> tuple[list[IntArray], IntArray]:
    """Return the parts of a graph and their separator, as numbers of groups; no parts if the graph
    is not worth splitting."""
    count, label = connected_components(graph, directed=False)
    if count > 1:
        return [np.flatnonzero(label == one) for one in range(count)], np.zeros(0, dtype=np.int64)
    best, smallest = None, np.inf
    for key in _directions(graph):
        order = np.argsort(key, kind="stable")
        share = np.cumsum(size[order]) / size.sum()
        for wanted in SHARES:
            low = np.zeros(len(size), dtype=bool)
            low[order[: np.searchsorted(share, wanted) + 1]] = True
            edges = low & (graph @ ~low > 0), ~low & (graph @ low > 0)
            cost = min(size[edge].sum() for edge in edges) * (1.0 + abs(wanted - 0.5))
            if cost < smallest:
                best, smallest = low, cost
    assert best is not None
    between = _cover(graph, best)
    sides = np.flatnonzero(best & ~between), np.flatnonzero(~best & ~between)
    if not all(map(len, sides)):
        return [], np.arange(len(size))
    return list(sides), np.flatnonzero(between)


def _directions(graph: sp.csr_array) -> list[FloatArray]:
    """Return for three pairs of remote groups the difference of the distances from them."""
    found: list[FloatArray] = []
    near = np.zeros(graph.shape[0])
    start = int(_distance(graph, 0).argmax())
    for _ in range(3):
        first = _distance(graph, start)
        last = _distance(graph, int((first - 0.5 * sum(map(abs, found), near)).argmax()))
        found.append(first - last)
        near = near + first + last
        start, near_there = int(near.argmax()), near
        near = near_there
    return found


def _distance(graph: sp.csr_array, start: int) -> FloatArray:
    """Return the number of edges from a group to each group of a connected graph."""
    order, before = breadth_first_order(graph, start)
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    reached_from, ends = place[before[order[1:]]], [0, 1]  # ascending; places where distances begin
    while ends[-1] < len(order):
        ends.append(1 + int(np.searchsorted(reached_from, ends[-1])))
    distance = np.empty(len(order))
    distance[order] = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
    return distance


def _cover(graph: sp.csr_array, low: IntArray) -> IntArray:
    """Return the smallest set of groups that touches all edges between groups that are low and
    those that are not, as a mask."""
    below, above = np.flatnonzero(low), np.flatnonzero(~low)
    across = sp.csr_array(graph[below][:, above])
    partner = maximum_bipartite_matching(across, perm_type="column")  # of each low group
    of_above = np.full(len(above), -1)
    of_above[partner[partner >= 0]] = np.flatnonzero(partner >= 0)
    reached_below, reached_above = partner < 0, np.zeros(len(above), dtype=bool)
    front = np.flatnonzero(reached_below)
    while len(front):
        new = np.unique(across[front].indices)
        new = new[~reached_above[new]]
        reached_above[new] = True
        back = of_above[new]  # each has a partner, otherwise the matching would not be the largest
        front = back[~reached_below[back]]
        reached_below[front] = True
    mask = np.zeros(len(low), dtype=bool)
    mask[below[~reached_below]] = True
    mask[above[reached_above]] = True
    return mask
