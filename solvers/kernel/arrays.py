"""Arrays that the compiled march works on, bundled by stage of a step, and what addresses them."""

from __future__ import annotations

from typing import NamedTuple

from bladewhirl.solvers.kernel.compilation import Array

RUNNING, DIVERGED = 0, 1
W_KIND, W_SLOPE, U_KIND, U_SLOPE = 0, 1, 2, 3
ROWS = 4  # of a block that are summed at a time
PUSH, DRAG = 4, 5  # of the tips, behind the nodal forces
EXTERNAL, NORMAL, FRICTION, DAMPING, PARAMETRIC = 0, 1, 2, 3, 4
WORKS = 5
STEP_CONTACTS, LCP_FAILURES, LCP_PIVOTS, CONTACT_STEPS = 0, 1, 2, 3
LOAD_END, LOAD_RAMP, LOAD_FREQUENCY, LOAD_PHASE = 0, 1, 2, 3


class Slots(NamedTuple):
    """Rows of a body's state that hold x_{n-1}, x_n, x_{n+1}; they turn with each step."""

    old: int
    now: int
    new: int


class BodyArrays(NamedTuple):
    """Modal recurrence of one body; flat arrays of rows * columns entries, zero where padded.

    Where Coriolis forces couple modes, A is not diagonal and a, b, c give A (x_{n+1} - x_{n-1}).
    """

    a: Array  #: multiplies x_n
    b: Array  #: multiplies x_{n-1}
    c: Array  #: multiplies forces: inverse of the scheme's diagonal [s2]
    stiffness: Array  #: omega^2 [rad2/s2]
    damping: Array  #: 2 xi omega [rad/s]
    load: Array  #: load patterns, (patterns, entries)
    loaded: Array  #: registers of each pattern that are not zero, then -1, (patterns, most + 1)


class RotorArrays(NamedTuple):
    """Recurrence, evaluation of the blade tips, and the parts of W that the rotor gives."""

    body: BodyArrays
    radial: Array  #: weights, (rows, columns)
    tangential: Array  #: weights with the radial shape, (rows, columns)
    crossed: Array  #: weights with the tangential shape, (rows, columns)
    shape: Array  #: (columns, padded tips)
    cross_shape: Array  #: the same for the tangential direction
    spread: Array  #: shape by tip, (tips, columns)
    drag_spread: Array  #: what friction is spread with: the same, or cross_shape by tip
    half: int  #: columns from one to its partner, see `Arrangement`
    shared: bool  #: whether friction is spread as the normal force is
    w: Array  #: r c (r + mu s t)^T for s = -1, 0, 1, by column, (3 tips, tips)
    position: Array  #: angle of each tip in elements of the casing, (padded tips,)
    recess: Array  #: of each tip at rest, on top of the clearance, (padded tips,)


class GyroscopicArrays(NamedTuple):
    """Inverse of the rotor's A = M / dt^2 + (D + 2 Omega G) / (2 dt), with its dampers [s2].

    On a cyclic rotor it is blocks: modes of a column get R of its own and X of its partner's if
    the column is a cosine, R and -X if it is a sine.
    """

    blocks: Array
    """By half registers of cosines, `ROWS` rows at a time, and rows: R of these, then X; flat."""
    rest: Array  #: entries that this leaves out, those of single harmonics among them
    to: Array  #: what each of these moves
    by: Array  #: and the force that does it
    full: Array  #: without symmetry: what all modes get of each, (modes, entries); else no rows
    loss: Array
    """Damping of cosine and sine alike: upper triangle, twice what is beside the diagonal. By half
    registers, groups of `ROWS` rows and rows from the group's first on; flat, zero where padded."""
    full_loss: Array  #: the triangle of all, where columns are damped together; else no rows
    normal: Array  #: answer to forces by column, (rows, columns); of one column without symmetry
    normal_across: Array  #: by the partner column
    shear: Array  #: to friction
    shear_across: Array
    circulation: Array  #: forces of dampers that stand still, by ``centre``, (0 or 2, entries)
    centre: Array  #: what moves them, (0 or 2, entries)


class NodalField(NamedTuple):
    """Evaluation of one displacement of the casing, w or u, and of its slope at the nodes."""

    weight: Array  #: of the values, (rows, columns)
    slope_weight: Array
    half: int  #: columns from one to that which its sum goes to, see `column_sums`
    slope_half: int
    shape: Array  #: (columns, padded nodes)
    slope_shape: Array
    spread: Array  #: shape by node, (nodes, columns)
    slope_spread: Array
    start: Array  #: what is added: nodal clearance and its slope, or zero, (2, padded nodes)


class CasingArrays(NamedTuple):
    """Recurrence, evaluation of the nodes, and the parts of W that the casing gives."""

    body: BodyArrays
    radial: NodalField
    tangential: NodalField
    fold: Array  #: shape on a quarter of the circle, see `_folded_fields`; without rows if unused
    half: int  #: columns from one to its partner, see `Arrangement`
    shared: bool  #: whether all nodal values have one shape
    compliance: Array  #: blocks of 4 x 4 for s = -1, 0, 1, see `_delassus`, flat
    spacing: int  #: blocks from one element to the next
    nodes: int
    element_length: float  #: [m]


class SpringEnds(NamedTuple):
    """Modes of one body that the springs move."""

    place: Array  #: among the body's flat entries, (modes,)
    wave: Array  #: wave of each: twice its harmonic, and one more for a sine
    amplitude: Array  #: of each at the springs [kg^-1/2]


class SpringArrays(NamedTuple):
    """Springs between the bodies, by nodal diameter (harmonic).

    A wave is the cosine or sine part of a body's radial displacement in one harmonic. Springs under
    the shaft are a harmonic of their own, with one nodal diameter and no mode of the casing.
    """

    nodal_diameter: Array  #: of each harmonic, (harmonics,)
    factor: Array  #: stiffness f_k kappa of each wave [N/m], (waves,)
    rotor: SpringEnds
    casing: SpringEnds
    angle_per_step: float  #: turn of the rotor a step [rad]


class DamperEnds(NamedTuple):
    """Dampers at points of one body."""

    rows: Array  #: G, motion of each damper times the root of its strength, (dampers, entries)
    solve: Array  #: (2 dt + G c G^T)^-1, (dampers, dampers)


class DamperArrays(NamedTuple):
    """Dampers at points of both bodies."""

    rotor: DamperEnds
    casing: DamperEnds


class MarchNumbers(NamedTuple):
    """Numbers of a march that belong to no body, and its loads over time."""

    time_step: float  #: [s]
    elements_per_step: float  #: turn of the rotor a step, in casing elements
    friction: float
    sliding: float  #: sign of permanent sliding
    elements_per_metre: float  #: tip rotation: casing elements a metre of u_t; 0 when neglected
    displacement_limit: float  #: of a tip, or of the casing radially [m]
    gap_scale: float  #: smallest scale of the complementarity residual [m]
    loads: Array  #: end, ramp, frequency, phase of each pattern, (patterns, 4)


class State(NamedTuple):
    """Everything a march needs to go on; arrays are advanced in place."""

    rotor: Array  #: x_{n-1}, x_n and scratch, (3, entries)
    casing: Array  #: the same for the casing
    gap: Array  #: smallest gap of each tip since the last record [m], (tips,)
    impulse: Array  #: normal impulse since the last record [N s], (tips,)
    drag: Array  #: friction impulse since the last record [N s], (tips,)
    touched: Array  #: steps with contact since the last record, (tips,)
    held: Array  #: 1 for tips in contact at the last step, (tips,)
    work: Array  #: external, normal, friction work, damping loss, parametric work [J], (WORKS,)
    residual: Array  #: largest complementarity residual, (1,)
    counts: Array  #: contacts at the last step, LCP failures, LCP pivots, steps with contact, (4,)


class Records(NamedTuple):
    """Rows written at record steps."""

    step: Array  #: (records,)
    rotor: Array  #: displacement, (records, entries)
    rotor_velocity: Array
    casing: Array
    casing_velocity: Array
    gap: Array  #: (records, tips)
    impulse: Array
    drag: Array
    touched: Array
    contacts: Array  #: (records,)
    energy: Array  #: half-step energy [J], (records,)
    work: Array  #: (records, WORKS)


class FieldScratch(NamedTuple):
    """Sums by column, nodal fields and what tips make of them."""

    rotor: Array  #: sums by column of the rotor, (columns,)
    value: Array  #: sums by column of nodal values of the casing, (columns,)
    slope: Array
    nodal: Array  #: nodal values of the casing's field, node 0 again, (padded nodes,)
    nodal_slope: Array
    moved: Array  #: displacement over a step, rotor and casing, (2, entries)
    at: Array  #: place of each tip in elements, (padded tips,)
    element: Array  #: element under each tip, (tips,)
    hermite: Array  #: weights of each tip on its element: w, w', w, w', (4, padded tips)
    radial: Array  #: of each tip [m], (padded tips,)
    tangential: Array
    other: Array  #: scratch of the tips, (padded tips,)
    free_gap: Array  #: without contact [m], (padded tips,)
    gap: Array  #: after the correction [m], (padded tips,)


class ContactScratch(NamedTuple):
    """W of the active tips, its solution, and the forces that follow."""

    sign: Array  #: direction of sliding, (tips,)
    multiplier: Array  #: [N], (tips,)
    active: Array  #: tips of the active set, (tips,)
    known: Array  #: tips and senses that ``on_rotor`` stands for, (2, tips)
    on_rotor: Array  #: the rotor's part of W of the active tips, by column, (tips, padded tips)
    ends: Array  #: Hermite weights by active tip, (4 padded tips,)
    system: Array  #: W by column, then a right-hand side, (tips + 1, padded tips)
    others: Array  #: 1 off the diagonal, 0 on it, (tips, padded tips)
    diagonal: Array  #: W_jj of the active tips, (tips,)
    solution: Array  #: (tips,)
    tableau: Array  #: of Lemke's method, (tips, 2 tips + 2)
    basis: Array  #: of Lemke's method, (tips,)
    rows: Array  #: rows that a product takes, (2 tips,)
    factor: Array  #: and with what factors, (6, 2 tips)
    columns: Array  #: forces by column: casing w, w', u, u', rotor normal, friction, (6, columns)
    work: Array  #: of the contact forces over this step [J], (2,)


class SpringScratch(NamedTuple):
    """Waves at the springs, their stretch and forces."""

    rotor: Array  #: waves at the last step and at this, by its parity, (2, waves)
    casing: Array
    stretch: Array  #: by angle and displacement as in `_stretch`, (4, waves)
    force: Array  #: on the waves of rotor and casing, (2, waves)


class Scratch(NamedTuple):
    """Working arrays of one march."""

    fields: FieldScratch
    contact: ContactScratch
    springs: SpringScratch
    turned: Array  #: modal forces on the rotor, (entries,)
    amplitude: Array  #: of each load pattern, (patterns,)
    stroke: Array  #: of each damper over two steps, (most dampers,)
    damper_force: Array  #: phi on rotor and casing, (2, most dampers)
