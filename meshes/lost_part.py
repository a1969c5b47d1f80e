"""Part of a mesh of lines that is lost when blades break off."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, part_up_to


class LossError(ValueError):
    """Blades that cannot be lost as demanded; the arguments are that of `BladedMesh.lost_with` at
    fault, "blades" or "share", and a text that completes "expected ..."."""


@dataclass(frozen=True, kw_only=True)
class LostPart:
    """Nodes and lines that are lost with some blades."""

    nodes: IntArray  #: lost nodes, (nodes,)
    lines: IntArray  #: lost lines, (lines,)
    cuts: IntArray  #: node at which each blade breaks, which remains, (blades,)


@dataclass(frozen=True, kw_only=True)
class BladedMesh:
    """What determines the part of a bladed disk that is lost with a blade."""

    points: FloatArray  #: nodes [m], (nodes, 2)
    lines: IntArray  #: nodes at the ends of each line, (lines, 2)
    parts: NDArray[np.str_]  #: part of the mesh of each line, (lines,)
    joints: IntArray  #: pairs of nodes connected by lines, springs or rigid links, (joints, 2)
    tips: IntArray  #: node of each blade tip, (blades,)
    centre: int  #: centre node

    def lost_with(self, blades: IntArray, share: float) -> LostPart:
        """Return the part that is lost with some blades.

        Args:
            blades: numbers of the blades.
            share: place of the fracture as a share of the length of the blade from its root; the
                blade breaks at the nearest node.

        Raises:
            LossError: no beam ends at a tip, the nearest node is the tip, or a blade is joined to
                other parts beyond the fracture.
        """
        spans = self.points[self.lines]
        lengths = np.linalg.norm(spans[:, 1] - spans[:, 0], axis=1)
        nodes, cuts = list[IntArray](), list[int]()
        for blade in blades.tolist():
            tip = int(self.tips[blade])
            chain = part_up_to(tip, self.points, self.lines, self.parts)
            if not len(chain.lines):
                expected = f"a blade of beams; no beam ends at the tip of blade {blade}"
                raise LossError("blades", expected)
            ends = chain.ends(lengths) / chain.ends(lengths)[-1]
            place = int(np.abs(ends - share).argmin())
            if place == len(chain.lines):
                raise LossError(
                    "share",
                    f"a share nearer to {ends[-2]:.4g}, the last node of blade {blade} before its"
                    " tip, than to 1",
                )
            line = int(chain.lines[place])
            cut = int(self.lines[line, 0 if chain.outward[place] else 1])
            lost = self._beyond(cut, tip)
            others = np.setdiff1d(np.flatnonzero(np.isin(self.tips, lost)), [blade])
            if self.centre in lost or others.size:
                raise LossError(
                    "blades",
                    f"a blade that is joined to other parts at its root only; blade {blade} is"
                    " joined to them beyond the fracture",
                )
            nodes.append(lost)
            cuts.append(cut)
        gone = np.concatenate(nodes)
        lines = np.flatnonzero(np.isin(self.lines, gone).any(axis=1))
        return LostPart(nodes=np.sort(gone), lines=lines, cuts=np.array(cuts))

    def _beyond(self, cut: int, tip: int) -> IntArray:
        """Return the nodes joined to a tip without the node of the cut."""
        kept = self.joints[(self.joints != cut).all(axis=1)]
        size = len(self.points)
        graph = sp.csr_array((np.ones(len(kept)), (kept[:, 0], kept[:, 1])), shape=(size, size))
        _, group = connected_components(graph, directed=False)
        return np.flatnonzero(group == group[tip])
