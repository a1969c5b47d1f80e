"""Arrays that the compiled march works on, and the numbers that address them."""

from __future__ import annotations

from typing import NamedTuple

from bladewhirl.solvers.kernel.compilation import Array

RUNNING, DIVERGED = 0, 1
W_KIND, W_SLOPE, U_KIND, U_SLOPE = 0, 1, 2, 3
PUSH, DRAG = 4, 5  # of the tips, behind the nodal forces
EXTERNAL, NORMAL, FRICTION, DAMPING, PARAMETRIC = 0, 1, 2, 3, 4
WORKS = 5
STEP_CONTACTS, LCP_FAILURES, LCP_PIVOTS, CONTACT_STEPS = 0, 1, 2, 3
LOAD_END, LOAD_RAMP, LOAD_FREQUENCY, LOAD_PHASE = 0, 1, 2, 3


class Body(NamedTuple):
    """Modal recurrence of one body; flat arrays of rows * columns entries, zero where padded."""

    a: Array  #: multiplies x_n
    b: Array  #: multiplies x_{n-1}
    c: Array  #: inverse of the scheme's diagonal [s2]
    stiffness: Array  #: omega^2 [rad2/s2]
    damping: Array  #: 2 xi omega [rad/s]
    load: Array  #: load patterns, (patterns, entries)
    loaded: Array  #: registers of each pattern that are not zero, then -1, (patterns, most + 1)


class Dampers(NamedTuple):
    """Dampers at points of both bodies."""

    rotor: Array  #: G, motion of each damper times the root of its strength, (dampers, entries)
    rotor_solve: Array  #: (2 dt + G c G^T)^-1, (dampers, dampers)
    casing: Array
    casing_solve: Array


class KindArrays(NamedTuple):
    """One array for each kind of nodal value: w, w', u, u'."""

    w: Array
    w_slope: Array
    u: Array
    u_slope: Array


class Rotor(NamedTuple):
    """Evaluation of the blade tips, and the constant parts of W that the rotor gives."""

    radial: Array  #: weights, (rows, columns)
    tangential: Array  #: weights with the radial shape, (rows, columns)
    crossed: Array  #: weights with the tangential shape, (rows, columns)
    shape: Array  #: (columns, padded tips)
    cross_shape: Array  #: the same for the tangential direction
    spread: Array  #: shape by tip, (tips, columns)
    drag_spread: Array  #: what friction is spread with: the same, or cross_shape by tip
    half: int  #: columns from one to its partner, see `Layout`
    shared: bool  #: whether friction is spread as the normal force is
    w: Array  #: r c (r + mu s t)^T for s = -1, 0, 1, by column, (3 tips, tips)
    position: Array  #: angle of each tip in elements of the casing, (padded tips,)
    recess: Array  #: of each tip at rest, on top of the clearance, (padded tips,)


class Casing(NamedTuple):
    """Evaluation of the casing's nodal values w, w', u, u'."""

    weight: Array  #: (4, rows, columns)
    shape: KindArrays  #: (columns, padded nodes) each
    fold: Array  #: shape on a quarter of the circle, see `_folded_fields`; without rows if unused
    spread: KindArrays  #: shape by node, (nodes, columns) each
    half: int  #: columns from one to its partner, see `Layout`
    shared: bool  #: whether all kinds have one shape
    compliance: Array  #: blocks of 4 x 4 for s = -1, 0, 1, see `_delassus`, flat
    spacing: int  #: blocks from one element to the next
    clearance: Array  #: nodal clearance and its slope, node 0 again, (2, padded nodes)
    no_clearance: Array  #: zeros of the same shape
    nodes: int
    element_length: float  #: [m]


class Springs(NamedTuple):
    """Springs between the bodies, by nodal diameter (harmonic).

    A wave is the cosine or sine part of a body's radial displacement in one harmonic. Springs under
    the shaft are a harmonic of their own, with one nodal diameter and no mode of the casing.
    """

    nodal_diameter: Array  #: of each harmonic, (harmonics,)
    factor: Array  #: stiffness f_k kappa of each wave [N/m], (waves,)
    rotor_place: Array  #: coupled modes among the flat entries of the rotor, (modes,)
    rotor_wave: Array  #: wave of each: twice its harmonic, and one more for a sine
    rotor_amplitude: Array  #: of each at the springs [kg^-1/2]
    casing_place: Array
    casing_wave: Array
    casing_amplitude: Array
    angle_per_step: float  #: turn of the rotor a step [rad]


class March(NamedTuple):
    """Scalars of a march."""

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
    rotor: Array  #: (records, 2, entries): displacement, velocity
    casing: Array
    gap: Array  #: (records, tips)
    impulse: Array
    drag: Array
    touched: Array
    contacts: Array  #: (records,)
    energy: Array  #: half-step energy [J], (records,)
    work: Array  #: (records, WORKS)


class Scratch(NamedTuple):
    """Working arrays of one march."""

    columns: Array  #: sums by column, see `advance`, (4, columns)
    forces: Array  #: contact forces by column: rotor normal, friction, casing w, w', u, u'
    nodal: Array  #: values and slopes of a nodal field, (2, padded nodes)
    tip: Array  #: radial, tangential, scratch, place in elements, (4, padded tips)
    gap: Array  #: free gap, gap after the correction [m], (2, padded tips)
    hermite: Array  #: weights of each tip on its element: w, w', w, w', (4, padded tips)
    element: Array  #: element under each tip, (tips,)
    difference: Array  #: displacement over a step, rotor and casing, (2, entries)
    load: Array  #: amplitude of each load pattern, (patterns,)
    rows: Array  #: rows that a product takes, (2 tips,)
    factor: Array  #: and with what factors, (6, 2 tips)
    active: Array  #: tips of the active set, (tips,)
    known: Array  #: tips and senses that ``on_rotor`` stands for, (2, tips)
    on_rotor: Array  #: the rotor's part of W of the active tips, by column, (tips, padded tips)
    ends: Array  #: Hermite weights by active tip, (4 padded tips,)
    solve: Array  #: W by column, then a right-hand side, (tips + 1, padded tips)
    others: Array  #: 1 off the diagonal, 0 on it, (tips, padded tips)
    diagonal: Array  #: W_jj of the active tips, (tips,)
    solution: Array  #: (tips,)
    multiplier: Array  #: [N], (tips,)
    sign: Array  #: direction of sliding, (tips,)
    work: Array  #: of the contact forces over this step [J], (2,)
    tableau: Array  #: of Lemke's method, (tips, 2 tips + 2)
    basis: Array  #: of Lemke's method, (tips,)
    rotor_waves: Array  #: at the last step and at this, (2, waves)
    casing_waves: Array
    stretch: Array  #: of the springs, by angle and displacement as in `_stretches`, (4, waves)
    spring_force: Array  #: on the waves of rotor and casing, (2, waves)
    stroke: Array  #: of each damper over two steps, (most dampers,)
    damper_force: Array  #: phi on rotor and casing, (2, most dampers)
