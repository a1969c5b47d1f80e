"""Arrays that the compiled march works on, as named tuples: the structs of `kernel.h`.

That header has what each holds, with its shape and unit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

Array = NDArray[Any]

LANES, HALF = 8, 4
ROWS = 4
RUNNING, DIVERGED = range(2)
W_KIND, W_SLOPE, U_KIND, U_SLOPE = range(4)
EXTERNAL, NORMAL, FRICTION, DAMPING, PARAMETRIC, WORKS = range(6)
STEP_CONTACTS, LCP_FAILURES, LCP_PIVOTS, CONTACT_STEPS = range(4)


class Body(NamedTuple):
    """Modal recurrence of one body; flat arrays of rows * columns entries, zero where padded."""

    a: Array
    b: Array
    c: Array
    stiffness: Array
    damping: Array
    load: Array
    loaded: Array


class Rotor(NamedTuple):
    """Recurrence, evaluation of the blade tips, and the parts of W that the rotor gives."""

    body: Body
    radial: Array
    tangential: Array
    crossed: Array
    shape: Array
    cross_shape: Array
    spread: Array
    drag_spread: Array
    half: int
    shared: bool
    w: Array
    position: Array
    recess: Array


class Gyroscopic(NamedTuple):
    """Inverse of the rotor's A = M / dt^2 + (D + 2 Omega G) / (2 dt), with its dampers [s2]."""

    blocks: Array
    rest: Array
    to: Array
    by: Array
    full: Array
    loss: Array
    full_loss: Array
    normal: Array
    normal_across: Array
    shear: Array
    shear_across: Array
    circulation: Array
    centre: Array


class NodalField(NamedTuple):
    """Evaluation of one displacement of the casing, w or u, and of its slope at the nodes."""

    weight: Array
    slope_weight: Array
    half: int
    slope_half: int
    shape: Array
    slope_shape: Array
    spread: Array
    slope_spread: Array
    start: Array


class Casing(NamedTuple):
    """Recurrence, evaluation of the nodes, and the parts of W that the casing gives."""

    body: Body
    radial: NodalField
    tangential: NodalField
    fold: Array
    half: int
    shared: bool
    compliance: Array
    spacing: int
    nodes: int
    element_length: float


class SpringEnds(NamedTuple):
    """Modes of one body that the springs move."""

    place: Array
    wave: Array
    amplitude: Array


class Springs(NamedTuple):
    """Springs between the bodies, by nodal diameter (harmonic)."""

    nodal_diameter: Array
    factor: Array
    rotor: SpringEnds
    casing: SpringEnds
    angle_per_step: float


class DamperEnds(NamedTuple):
    """Dampers at points of one body."""

    rows: Array
    solve: Array


class Dampers(NamedTuple):
    """Dampers at points of both bodies."""

    rotor: DamperEnds
    casing: DamperEnds


class Numbers(NamedTuple):
    """Numbers of a march that belong to no body, and its loads over time."""

    time_step: float
    elements_per_step: float
    friction: float
    sliding: float
    elements_per_metre: float
    displacement_limit: float
    gap_scale: float
    loads: Array


class State(NamedTuple):
    """Everything a march needs to go on; arrays are advanced in place."""

    rotor: Array
    casing: Array
    gap: Array
    impulse: Array
    drag: Array
    touched: Array
    held: Array
    work: Array
    residual: Array
    counts: Array


class Records(NamedTuple):
    """Rows written at record steps."""

    step: Array
    rotor: Array
    rotor_velocity: Array
    casing: Array
    casing_velocity: Array
    gap: Array
    impulse: Array
    drag: Array
    touched: Array
    contacts: Array
    energy: Array
    work: Array


class FieldScratch(NamedTuple):
    """Sums by column, nodal fields and what tips make of them."""

    rotor: Array
    value: Array
    slope: Array
    nodal: Array
    nodal_slope: Array
    moved: Array
    at: Array
    element: Array
    hermite: Array
    radial: Array
    tangential: Array
    other: Array
    free_gap: Array
    gap: Array


class ContactScratch(NamedTuple):
    """W of the active tips, its solution, and the forces that follow."""

    sign: Array
    multiplier: Array
    active: Array
    known: Array
    on_rotor: Array
    ends: Array
    system: Array
    others: Array
    diagonal: Array
    solution: Array
    tableau: Array
    basis: Array
    rows: Array
    factor: Array
    columns: Array
    work: Array


class SpringScratch(NamedTuple):
    """Waves at the springs, their stretch and forces."""

    rotor: Array
    casing: Array
    stretch: Array
    force: Array


class Scratch(NamedTuple):
    """Working arrays of one march."""

    fields: FieldScratch
    contact: ContactScratch
    springs: SpringScratch
    turned: Array
    amplitude: Array
    stroke: Array
    damper_force: Array
