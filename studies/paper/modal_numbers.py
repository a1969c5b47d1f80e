"""Numbers of the source paper on uncoupled modes (Sections 3.1, 3.2, 4.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.cyclic import wave_shares
from bladewhirl.models.modal.full_stage import ModalStage, modal_stage
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.stability.scenario import Scenario
from bladewhirl.studies.modal.campbell import campbell
from bladewhirl.studies.modal.scenarios import CASING_SHARES, whirling_modes
from bladewhirl.studies.modal.veering import clamping_shifts, suspension_frequency, veering

LOOKED_AT = 12
"""Families that the paper's Fig. 7(a) shows."""

PURE = 0.99
"""Least share of a nodal diameter with which a mode without symmetry is assigned to it."""

OPERATING = (0.6, 2.0)
CROSSINGS = (0.7, 1.3)
"""Normalised speeds: the paper's operating range, and where it has first-family crossings."""


@dataclass(frozen=True, kw_only=True)
class ModalClaims:
    """Numbers of a case where the paper claims something; no verdicts."""

    centre_motion: dict[int, float]
    """Largest motion of the centre over that of the mode, by nodal diameter (claim 1)."""
    clamping_shift: dict[int, float]
    """Largest relative change of a frequency by clamping, by nodal diameter (claim 2)."""
    suspension: float  #: frequency of the suspension pair, normalised (claim 3)
    second_family: float  #: lowest frequency of 2F, normalised; 1F's lowest is about 1 (claim 3)
    shaft_over_blade: float  #: stiffness of a shaft spring over a blade's tangential one (claim 4)
    reduced_size: int  #: degrees of freedom of the reduced bladed disk (claim 5)
    reduction_error: dict[str, float]  #: largest relative one, by family (claim 5)
    first_coincidence: float  #: of 1F with k = 1, normalised (claim 6)
    suspension_coincidence: float  #: of the suspension pair, normalised (claim 7)
    first_family_crossings: dict[int, float]
    """Coincidence speeds of 1F inside `CROSSINGS`, by nodal diameter (claim 8)."""
    scenarios: dict[str, Scenario]
    """Contact scenario of 1F, k = 1 by whether the casing moves less or more (claim 9)."""


def modal_claims(case: Case) -> ModalClaims:
    """Compute the modal numbers of a case with a free centre.

    Raises:
        UserError: the stage has no such modes.
    """
    stage = modal_stage(case)
    diagrams = veering(stage, families=LOOKED_AT)
    reduced = build_stage(case)
    coincidences = campbell(stage, families=2, operating=OPERATING)["normalised_speed"]
    met: dict[tuple[str, int], float] = {}
    for (family, _, k), speed in zip(
        coincidences["coincidence"].values, coincidences.values, strict=True
    ):
        # Ascending: the first is that with the lowest casing mode of the nodal diameter.
        met.setdefault((family, int(k)), float(speed))
    second = [name == "2F" for name in stage.free_modes.family]
    return ModalClaims(
        centre_motion=centre_motion(stage),
        clamping_shift=clamping_shifts(diagrams),
        suspension=suspension_frequency(diagrams) or 0.0,
        second_family=float(stage.free_modes.frequency[second].min() / stage.reference_frequency),
        shaft_over_blade=case.shaft.stiffness / blade_stiffness(stage),
        reduced_size=reduced.reduction.modes.count,
        reduction_error=dict(reduced.frequency_error),
        first_coincidence=met["1F", 1],
        suspension_coincidence=met["suspension", 1],
        first_family_crossings={
            k: speed
            for (family, k), speed in sorted(met.items())
            if family == "1F" and CROSSINGS[0] <= speed <= CROSSINGS[1]
        },
        scenarios={
            name: whirling_modes(stage, casing_share=share).scenario
            for name, share in CASING_SHARES.items()
        },
    )


def centre_motion(stage: ModalStage) -> dict[int, float]:
    """Largest motion of the centre over the largest of the mode, by nodal diameter.

    The modes are found without using the symmetry, which would decide the matter beforehand: all
    of them up to the frequency of the last family of Fig. 7(a), as far as one nodal diameter holds
    them (families of different nodal diameter may have one frequency and mix).
    """
    disk, structure = stage.free_disk, stage.free_disk.structure
    assert structure.layout is not None  # a case's bladed disk is made of sectors
    count = min(LOOKED_AT * structure.layout.sectors, structure.size) - 1
    shapes = la.eigh(
        structure.stiffness.toarray(), structure.mass.toarray(), subset_by_index=(0, count)
    )[1]
    shares = wave_shares(shapes, structure.mass.diagonal(), structure.layout)
    size = np.linalg.norm(disk.cartesian(shapes)[:, :2], axis=1)
    centre = size[int(disk.mesh.node_sets["centre"][0])] / size.max(axis=0)
    return {k: float(centre[shares[k] >= PURE].max(initial=0.0)) for k in range(shares.shape[0])}


def blade_stiffness(stage: ModalStage) -> float:
    """Tangential stiffness at the tip of a blade clamped at its root [N/m]."""
    disk = stage.free_disk
    sectors = disk.mesh.sectors
    assert sectors is not None  # a case's bladed disk is made of sectors
    root = disk.mesh.node_sets["roots"][0]
    nodes = sectors[0][sectors[0] != root]
    dofs = disk.structure.node_dofs[nodes].ravel()
    blade = disk.structure.stiffness[dofs][:, dofs].toarray()
    force = (dofs == disk.tip_tangential[0]).astype(np.float64)
    return float(1.0 / (force @ la.solve(blade, force, assume_a="pos")))
