"""Casings compared with closed-form solutions of rings, and orders of convergence."""

import numpy as np

from bladewhirl.models.modal.labels import structure_modes
from bladewhirl.models.modal.modes import Modes
from bladewhirl.models.sections.rectangular import Section
from bladewhirl.models.sections.wall import Wall
from bladewhirl.studies.verification import stages
from bladewhirl.studies.verification.case import Pair, Pairs, reference, verifies


def lowest(modes: Modes, k: int) -> float:
    """Return the lowest frequency of a nodal diameter [Hz]."""
    return float(stages.hertz(modes)[modes.nodal_diameter == k][0])


def flexural(elements: int, name: str) -> Pair:
    """Return bending frequencies for two to ten nodal diameters [Hz], reference and computed
    values."""
    known, rows = reference("ring"), reference("ring")["modes"][2:]
    support = known["ring"]["foundation"] if name == "flexural_on_foundation_hz" else 0.0
    modes = stages.casing_modes(elements, support)
    return [row[name] for row in rows], [lowest(modes, row["nodal_diameter"]) for row in rows]


@verifies()
def bending_of_rings() -> Pairs:
    """Compare bending frequencies of a free ring, and of a ring on a uniform radial and tangential
    support, with closed-form solutions; compare the free ring also with a polygon of straight
    beams."""
    return {
        "free_ring": flexural(160, "flexural_hz"),
        "ring_on_foundation": flexural(160, "flexural_on_foundation_hz"),
        "ring_by_opensees": flexural(160, "opensees_800_hz"),
    }


@verifies()
def orders_of_convergence() -> Pairs:
    """Compare the order of convergence for bending with four, and that for translations with
    5.7."""
    exact, coarse = map(np.array, flexural(80, "flexural_hz"))
    fine = np.array(flexural(160, "flexural_hz")[1])
    bending = np.array([ours[-1] / exact[-1] - 1.0 for ours in (coarse, fine)])
    # The exact frequency of a translation is zero.
    translation = np.array([stages.casing_modes(n).frequency[1] ** 2 for n in (40, 80)])
    return {
        "order_of_the_ring": (4.0, stages.observed_order(bending)[0]),
        "order_of_translations": (5.7, stages.observed_order(translation)[0]),
    }


@verifies()
def stretching_ring() -> Pair:
    """Compare the stretching frequencies of a free ring with the closed-form solution."""
    modes = stages.casing_modes(80)
    exact = [row["extensional_hz"] for row in reference("ring")["modes"][:5]]
    spectra = [stages.hertz(modes)[modes.nodal_diameter == k] for k in range(5)]
    return exact, [
        f[np.argmin(np.abs(f - expected))] for f, expected in zip(spectra, exact, strict=True)
    ]


@verifies()
def pinched_ring() -> Pair:
    """Compare the displacement under two opposite unit forces with Castigliano's theorem."""
    section, modes = stages.steel(0.01), stages.casing_modes(80)
    exact = stages.RADIUS**3 / section.bending_stiffness * (np.pi / 4 - 2 / np.pi)
    exact += np.pi * stages.RADIUS / (4.0 * section.axial_stiffness)
    radial = stages.casing(80).nodal(modes.shapes)[:, 0]
    apart = radial[0] + radial[40]
    elastic = modes.frequency > 1.0
    return exact, np.sum((apart[elastic] / modes.frequency[elastic]) ** 2)


@verifies("2", "3", "4")
def nafems_ring(k: str) -> Pair:
    """Compare ring frequencies with NAFEMS; the round section, 0.1 m in diameter, is modelled as a
    rectangle of equal area and inertia."""
    diameter = 0.1
    thickness = diameter * np.sqrt(3.0) / 2.0
    section = Section(
        width=np.pi * diameter**2 / 4.0 / thickness,
        thickness=thickness,
        young_modulus=2e11,
        density=8000.0,
    )
    bar = stages.ring(wall=Wall(section=section), elements=80, radius=1.0)
    modes = structure_modes(bar.structure, stages.CASING_REFERENCE, 20)
    return reference("published")["nafems_ring_hz"][k], lowest(modes, int(k))
