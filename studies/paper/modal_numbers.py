"""Numbers of the source paper on uncoupled modes (Sections 3.1, 3.2, 4.2)."""

from typing import Any

import numpy as np
import scipy.linalg as la

from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.cyclic import wave_shares
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.studies.convergence.study import FAMILIES
from bladewhirl.studies.modal.campbell import campbell
from bladewhirl.studies.modal.scenarios import CASING_SHARES, whirling_modes
from bladewhirl.studies.modal.veering import clamping_shifts, suspension_frequency, veering

SHOWN_FAMILIES = 12
"""Number of families in the paper's Fig. 7(a)."""

PURE = 0.99  #: smallest share of a nodal diameter in a mode that is assigned to this nodal diameter

OPERATING = (0.6, 2.0)
CROSSINGS = (0.7, 1.3)
"""Normalised speeds of operation, among which are the paper's coincidences of the family 1F."""


def modal_measures(case: Case, stage: ModalModel) -> dict[str, Any]:
    """Compute the modal numbers of a case with a free centre.

    Frequencies and speeds are normalised, changes and errors are in per cent, phases in degrees.
    `errors` and `error_FAMILY` are frequency errors of the reduced bladed disk.

    Raises:
        UserError: the stage lacks some of the modes.
    """
    diagrams = veering(stage, families=SHOWN_FAMILIES)
    reduced = build_beams(case)
    coincidences = campbell(stage, families=2, operating=OPERATING)["normalised_speed"]
    met: dict[tuple[str, int], float] = {}
    for (family, _, k), speed in zip(
        coincidences["coincidence"].values, coincidences.values, strict=True
    ):
        # Speeds ascend, so the first speed belongs to the lowest casing mode.
        met.setdefault((family, int(k)), float(speed))
    crossings = {
        k: speed
        for (family, k), speed in sorted(met.items())
        if family == "1F" and CROSSINGS[0] <= speed <= CROSSINGS[1]
    }
    errors = {family: 100 * error for family, error in reduced.frequency_error.items()}
    worst = max(FAMILIES, key=lambda family: errors[family])
    scenarios = {
        name: whirling_modes(stage, casing_share=share).scenario
        for name, share in CASING_SHARES.items()
    }
    centre, shift = centre_motion(stage), clamping_shifts(diagrams)
    suspension = suspension_frequency(diagrams) or 0.0
    free = stage.disks["free"].labelled
    second = free.frequency[np.array(free.family) == "2F"]
    second_family = float(second.min() / stage.reference_frequency)
    listed = ", ".join(f"k = {k} at {speed:.3g}" for k, speed in crossings.items())
    return {
        "centre_one": centre.pop(1),
        "centre_others": max(centre.values()),
        "shift_one": 100 * shift.pop(1),
        "shift_others": 100 * max(shift.values()),
        "suspension": suspension,
        "second_family": second_family,
        "relative": suspension / second_family,
        "shaft_over_blade": case.shaft.stiffness / blade_stiffness(stage),
        "size": reduced.reduction.modes.count,
        "errors": errors,
        "worst": worst,
        "largest": errors[worst],
        **{f"error_{family}": errors[family] for family in FAMILIES},
        "first_coincidence": met["1F", 1],
        "suspension_coincidence": met["suspension", 1],
        "crossings": len(crossings),
        "crossing_speeds": listed or "none",
        **{name: scenario.kind for name, scenario in scenarios.items()},
        **{f"{name}_lead": abs(float(np.degrees(s.lead))) for name, s in scenarios.items()},
    }


def centre_motion(stage: ModalModel) -> dict[int, float]:
    """Return the largest motion of the centre relative to the largest motion of the mode, by nodal
    diameter.

    The modes up to the last family of Fig. 7(a) are computed without cyclic symmetry, which would
    imply the result. Modes that are not dominated by one nodal diameter are left out: modes of
    different nodal diameters but nearly equal frequencies mix.
    """
    disk = stage.disks["free"].beams
    structure = disk.structure
    assert structure.layout is not None  # the bladed disk of a case consists of sectors
    count = min(SHOWN_FAMILIES * structure.layout.sectors, structure.size) - 1
    shapes = la.eigh(
        structure.stiffness.toarray(), structure.mass.toarray(), subset_by_index=(0, count)
    )[1]
    shares = wave_shares(shapes, structure.mass.diagonal(), structure.layout)
    size = np.linalg.norm(disk.cartesian(shapes)[:, :2], axis=1)
    centre = size[int(disk.mesh.node_sets["centre"][0])] / size.max(axis=0)
    return {k: float(centre[shares[k] >= PURE].max(initial=0.0)) for k in range(shares.shape[0])}


def blade_stiffness(stage: ModalModel) -> float:
    """Return the tangential stiffness at the tip of a blade clamped at its root [N/m]."""
    disk = stage.disks["free"].beams
    sectors = disk.mesh.sectors
    assert sectors is not None  # the bladed disk of a case consists of sectors
    root = disk.mesh.node_sets["roots"][0]
    nodes = sectors[0][sectors[0] != root]
    dofs = disk.structure.node_dofs[nodes].ravel()
    blade = disk.structure.stiffness[dofs][:, dofs].toarray()
    force = (dofs == disk.tip_tangential[0]).astype(np.float64)
    return float(1.0 / (force @ la.solve(blade, force, assume_a="pos")))
