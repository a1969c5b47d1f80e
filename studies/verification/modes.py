"""Bladed disks compared with independent frame programs, beams compared with theory, and reduced
models compared with full models."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as spla
from numpy.polynomial import Legendre, Polynomial

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import tip_in_sector
from bladewhirl.models.modal.labels import structure_modes
from bladewhirl.models.modal.modes import families
from bladewhirl.models.modal.reduction import craig_bampton
from bladewhirl.models.sections.rectangular import Section
from bladewhirl.studies.verification import stages
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies

CENTRES = ("free", "clamped")
LISTED = 92  #: number of modes in the reference results

SPAN, TIP_MASS = 0.45, 0.1


@verifies(*CENTRES)
def stage_modes(centre: str) -> Pairs:
    """Compare the frequencies of the stage of the paper's Table 1 with OpenSees. No mode has a
    wrong family or nodal diameter."""
    known = reference("disk_modes")[centre]
    modes = stages.disk_modes(stages.bladed_disk(clamped=centre == "clamped"))
    names = zip(
        modes.nodal_diameter.tolist(), families(modes, "bladed-disk", modes.sectors), strict=True
    )
    expected = zip(known["nodal_diameter"], known["family"], strict=True)
    return {
        "stage_frequencies": (known["frequency_hz"], stages.hertz(modes)[:LISTED]),
        "stage_names": (0, sum(a != b for a, b in zip(expected, names, strict=False))),
    }


def static(disk: BladedDiskModel, dof: int) -> FloatArray:
    """Return displacements along x and y and rotations of all nodes under a unit force in the
    degree of freedom `dof`, (nodes, 3)."""
    force = np.zeros((disk.structure.size, 1))
    force[dof] = 1.0
    return disk.cartesian(spla.splu(disk.structure.stiffness.tocsc()).solve(force))[..., 0]


@verifies(*CENTRES)
def static_response(centre: str) -> Pairs:
    """Compare stiffnesses, and displacements under a tangential force at a tip, with OpenSees.

    Stiffnesses are tangential and radial at a tip, tangential at a root and at a free centre.
    """
    known = reference("disk_static")[centre]
    disk = stages.bladed_disk(clamped=centre == "clamped")
    nodes = disk.mesh.node_sets
    root = int(disk.structure.node_dofs[nodes["roots"][0], 1])
    places = {
        "tip0_tangential_stiffness": (int(disk.tip_tangential[0]), nodes["tips"][0], 1),
        "tip0_radial_stiffness": (int(disk.tip_radial[0]), nodes["tips"][0], 0),
        "root0_tangential_stiffness": (root, nodes["roots"][0], 1),
    }
    if centre == "free":
        places["centre_x_stiffness"] = (int(disk.centre[0]), nodes["centre"][0], 0)
    stiffness = [1.0 / static(disk, dof)[node, axis] for dof, node, axis in places.values()]
    field, tips = static(disk, int(disk.tip_tangential[0])), nodes["tips"]
    expected = (
        known["tip0_rotation_per_tangential_force"],
        *known["tip1_xy_per_tangential_force"],
        known["tip11_y_per_tangential_force"],
    )
    moved = (field[tips[0], 2], *field[tips[1], :2], field[tips[11], 1])
    return {
        "stage_stiffness": ([known[name] for name in places], stiffness),
        "stage_flexibility": (expected, moved),
    }


@verifies()
def unbalance_response() -> Pair:
    """Compare the unbalance response, (K - Omega^2 M) u = m e Omega^2, with OpenSees."""
    known, disk = reference("disk_harmonic"), stages.bladed_disk()
    tips, centre = disk.mesh.node_sets["tips"], disk.mesh.node_sets["centre"][0]
    expected, computed = [], []
    for row in known["response"]:
        square = (2.0 * np.pi * row["f_hz"]) ** 2
        force = np.zeros((disk.structure.size, 1))
        force[disk.centre[0]] = known["unbalance"] * square
        dynamic = disk.structure.stiffness - square * disk.structure.mass
        field = disk.cartesian(spla.splu(dynamic.tocsc()).solve(force))[..., 0]
        computed.append([field[centre, 0], field[tips[0], 0], *field[tips[5], :2]])
        expected.append([row[name] for name in ("centre_x", "tip0_x", "tip5_x", "tip5_y")])
    return expected, computed


def cantilever(
    taper: Section | Sequence[Section], elements: int, tip_mass: float = 0.0
) -> FloatArray:
    """Return the frequencies of a blade clamped at its root [rad/s]."""
    sketch = stages.beam(taper, elements, length=SPAN)
    if tip_mass:
        sketch.mass("end", tip_mass)
    return stages.natural_frequencies(stages.clamped(sketch))


@verifies()
def bending_cantilever(elements: int = 24) -> tuple[FloatArray, FloatArray]:
    """Compare three bending frequencies of a uniform cantilever [rad/s] with Euler-Bernoulli
    theory."""
    section = stages.steel(0.01)
    roots = np.array([1.8751040687119611, 4.694091132974175, 7.854757438237613])
    unit = np.sqrt(section.bending_stiffness / section.line_mass)
    return (roots / SPAN) ** 2 * unit, cantilever(section, elements)[:3]


def stretching(elements: int) -> tuple[FloatArray, FloatArray]:
    """Return three stretching frequencies of a uniform cantilever [rad/s], exact and by finite
    elements."""
    exact = np.pi * (np.arange(3) + 0.5) / SPAN * np.sqrt(2.1e11 / 7800.0)
    computed = cantilever(stages.steel(0.01), elements)
    return exact, computed[np.argmin(np.abs(computed[:, None] - exact), axis=0)]


def by_ritz(thickness: Sequence[float]) -> FloatArray:
    """Return the three lowest frequencies of a tapered blade with a mass at its tip [rad/s].

    The trial functions are polynomials over the span. For each inner section of the taper there are
    also third and higher powers of the distance beyond the section, at which the third derivative
    jumps.
    """
    stations = np.linspace(0.0, 1.0, len(thickness))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    x = np.concatenate([a + (b - a) * (nodes + 1) / 2 for a, b in pairwise(stations)])
    weight = np.tile(weights / 2, len(stations) - 1) / (len(stations) - 1)
    values, bends, ends = [], [], []
    for start, power in [(0.0, 2), *((s, 3) for s in stations[1:-1])]:
        for degree in range(12):
            smooth = Legendre.basis(degree, [start, 1.0]).convert(kind=Polynomial)
            function = Polynomial([-start, 1.0]) ** power * smooth
            values.append(np.where(x >= start, function(x), 0.0))
            bends.append(np.where(x >= start, function.deriv(2)(x), 0.0))
            ends.append(float(function(1.0)))
    height = np.interp(x, stations, thickness)
    w, bend, end = np.array(values), np.array(bends), np.array(ends)
    stiffness = bend * (weight * 2.1e11 * 0.1 * height**3 / 12 / SPAN**3) @ bend.T
    mass = w * (weight * 7800.0 * 0.1 * height * SPAN) @ w.T + TIP_MASS * np.outer(end, end)
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    flexible = la.eigh(
        mass * np.outer(scale, scale), stiffness * np.outer(scale, scale), eigvals_only=True
    )
    return np.asarray(1.0 / np.sqrt(flexible[::-1][:3]))


@verifies()
def tapered_blade(elements: int = 10) -> tuple[FloatArray, FloatArray]:
    """Compare three frequencies of a blade that tapers from 20 to 12 and 8 mm [rad/s] with the Ritz
    method."""
    taper = [0.020, 0.012, 0.008]
    sections = [stages.steel(size) for size in taper]
    return by_ritz(taper), cantilever(sections, elements, TIP_MASS)[:3]


@verifies()
def orders_of_convergence() -> Pairs:
    """Compare the order of convergence for bending (cubic elements) with four, and that for
    stretching (linear elements) with two."""
    pairs: dict[str, Pair] = {}
    for name, frequencies, elements, order in (
        ("order_of_bending", bending_cantilever, 6, 4.0),
        ("order_of_stretching", stretching, 32, 2.0),
        ("order_of_tapered_blades", tapered_blade, 8, 4.0),
    ):
        both = [frequencies(count) for count in (elements, 2 * elements)]
        errors = np.array([computed / exact - 1.0 for exact, computed in both])
        pairs[name] = np.full(3, order), stages.observed_order(errors)[0]
    return pairs


@verifies()
def cyclic_against_full() -> Pair:
    """Compare frequencies computed sector by sector with frequencies computed without symmetry."""
    structure = stages.bladed_disk(elements=4).structure
    whole = la.eigh(structure.stiffness.toarray(), structure.mass.toarray(), eigvals_only=True)
    return np.sqrt(whole), stages.disk_modes(stages.bladed_disk(elements=4)).frequency


@verifies()
def nearly_tuned() -> Pair:
    """Compare 60 frequencies of a stage before and after one tip is made slightly heavier."""
    disk = stages.bladed_disk(elements=4)
    mass = disk.structure.mass.copy().tolil()
    for dof in (disk.tip_radial[0], disk.tip_tangential[0]):
        mass[dof, dof] *= 1.0 + 1e-7
    nearly = structure_modes(replace(disk.structure, mass=mass.tocsr()), tip_in_sector(disk), 60)
    return stages.disk_modes(disk, 60).frequency[:60], nearly.frequency[:60]


def reduction_error(kept: int) -> FloatArray:
    """Return the relative errors of the first 22 elastic frequencies of a stage that is reduced to
    `kept` fixed-interface modes."""
    disk = stages.bladed_disk()
    boundary = np.concatenate([disk.tip_radial, disk.tip_tangential, disk.centre])
    reduced = craig_bampton(disk.structure, boundary, kept, tip_in_sector(disk)).modes
    exact = stages.disk_modes(disk).frequency[:22]
    return np.asarray(reduced.frequency[:22] / exact - 1.0)


@verifies()
def reduced_models() -> Pairs:
    """Compare two numbers with zero: the frequency error of a reduced stage, and the ratio of the
    errors after and before the number of modes is doubled."""
    coarse, fine = reduction_error(110).max(), reduction_error(220).max()
    return {"craig_bampton_error": (0.0, coarse), "craig_bampton_convergence": (0.0, fine / coarse)}
