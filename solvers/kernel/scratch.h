/* Working arrays of a march, and their sizes. All are parts of one array of doubles, the arena, which
 * is zero before the first step; `lay_scratch` gives each its place. */
#ifndef SCRATCH_H
#define SCRATCH_H

#include "lanes.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(at, bytes) ((void)(at), (void)(bytes))
#endif

/* Part of an array of doubles that is in use; without an array, sizes are only counted. */
typedef struct {
    double *at;
    int64_t used;
} Arena;

/* Return the next `size` doubles, which start on a cache line. A sanitizer sees if the doubles behind
 * them are used. */
static double *doubles(Arena *arena, int64_t size)
{
    double *at = arena->at ? arena->at + arena->used : NULL;
    if (at)
        ASAN_POISON_MEMORY_REGION(at + size, 8 * LANES);
    arena->used += (size + 2 * LANES - 1) / LANES * LANES;
    return at;
}

static Vector vector(Arena *arena, int64_t size) { return (Vector){doubles(arena, size), size}; }

static IntVector integers(Arena *arena, int64_t size)
{
    return (IntVector){(int64_t *)doubles(arena, size), size};
}

static Matrix matrix(Arena *arena, int64_t rows, int64_t columns)
{
    return (Matrix){doubles(arena, rows * columns), rows, columns};
}

static int64_t padded(int64_t size) { return (size + LANES - 1) / LANES * LANES; }

/* Fields of rotor and casing at the contact nodes. */
typedef struct {
    Vector sums;       /* sums by column of a field of the rotor, and its first half again */
    Vector partner;    /* sums of the weights in partner columns */
    Vector blades;     /* a field at the blades */
    Vector value;      /* sums by column for the nodal values of the casing */
    Vector slope;      /* sums by column for the nodal slopes of the casing */
    Matrix nodal;      /* nodal values and slopes of a field of the casing */
    Vector change;     /* change of the displacements of a body */
    Vector at;         /* position of each node in elements */
    IntVector element; /* element under each node */
    Matrix hermite;    /* Hermite weights of each node on its element: w, w', w, w' */
    Vector recess;     /* recess of each node minus the closure above it [m] */
    Vector radial;     /* radial displacement of each node without contact forces [m] */
    Vector moved;      /* another component of the displacement of each node [m] */
    Vector other;      /* displacement of the casing under each node [m] */
    Vector free_gap;   /* gap without contact forces [m] */
    Vector gap;        /* gap with contact forces [m] */
} FieldScratch;

/* Linear systems of the complementarity problem, and forces by column. */
typedef struct {
    IntVector active; /* nodes of the active set */
    Matrix system;    /* W by column, then a right-hand side */
    Matrix others;    /* 1 off the diagonal, 0 on it */
    Vector solution;  /* solution of the linear system */
    Matrix tableau;   /* tableau of Lemke's method */
    IntVector basis;  /* basic variables of Lemke's method */
    IntVector rows;   /* numbers of the rows in a product */
    Matrix factor;    /* factors of these rows */
    Matrix columns;   /* forces by column: w, w', u, u' of the casing */
    Matrix blades;    /* forces by column for each component of a blade */
    Vector work;      /* works of the contact forces on the casing in this step, and of those on the
                       * rotor by harmonic: normal, friction [J] */
} ContactScratch;

typedef struct {
    Matrix rotor;   /* waves of the rotor at the last two steps; row by parity of step */
    Matrix casing;  /* waves of the casing at the last two steps */
    Matrix stretch; /* stretch by angle and displacement, see `stretch_springs` */
    Matrix force;   /* forces on the waves of rotor and casing */
} SpringScratch;

/* Counts of foreshortening: tips near the wall, steps since the last check of all openings, and steps
 * since the last beginning of a linearisation. */
enum { NEAR_TIPS, SINCE_CHECK, SINCE_HOLD, BEND_COUNTS };

typedef struct {
    Matrix factor;    /* z = s y of tips near the wall, zero for others */
    Matrix gradient;  /* g = F^T z of tips near the wall */
    Matrix answer;    /* A^-1 g with Coriolis forces */
    Matrix bend;      /* y of all tips, a row for each term */
    Matrix bent;      /* change of y in a step */
    Vector term;      /* scratch */
    Vector start;     /* opening of tips near the wall at x = 0 [m] */
    Vector due;       /* gap without foreshortening below which a tip needs a linearisation [m] */
    Vector opened;    /* opening of each tip without contact forces [m] */
    Matrix opens;     /* change of the openings of tips near the wall due to a unit force on each tip
                       * of the group [m/N] */
    Vector along;     /* scratch */
    Vector expected;  /* displacement at the linearisation */
    Vector force;     /* sum of the gradients with the contact forces */
    IntVector near;   /* 1 for tips near the wall, otherwise 0 */
    IntVector list;   /* tips near the wall */
    IntVector count;  /* NEAR_TIPS ... */
    IntVector pushed; /* tips near the wall that are in contact */
} BendScratch;

/* Contact nodes, and the group of nodes that are solved together, see `group.h`. */
typedef struct {
    Vector modal;       /* modal forces or changes of a copy */
    Matrix force;       /* contact forces at step n + 1, by copy */
    Vector along;       /* tangential displacement of the casing under each node in the step */
    Vector sign;        /* direction of sliding of each node, if it does not depend on the forces */
    IntVector wanted;   /* 1 for copies with contact forces, or of the group */
    IntVector listed;   /* 1 for nodes of the group */
    IntVector list;     /* numbers of the nodes of the group, or of all that are pushed */
    IntVector known;    /* nodes for which `on_rotor` is valid, -1 behind the last */
    Vector known_sign;  /* and their directions of sliding */
    Matrix on_rotor;    /* part of `response` due to the rotor */
    Vector ends;        /* Hermite weights of the nodes of the group */
    IntVector blocks;   /* and the places of their elements among the blocks of the casing */
    Vector radius;      /* radius of each node */
    Vector gap;         /* gaps without contact, then with it */
    Vector before;      /* radial forces at step n */
    Vector slide;       /* displacements in the step relative to the wall */
    Vector group_force; /* forces at step n + 1 */
    Vector direction;   /* direction of sliding */
    Matrix compliance;  /* displacements due to unit forces in each direction */
    Vector closed;      /* gaps with contact */
    Vector miss;        /* difference between the directions of slip and of sliding */
    Vector multiplier;  /* normal forces */
    Matrix response;    /* changes of all gaps due to a unit normal force with its friction, a row for
                         * each force */
    Vector held;        /* 1 for active nodes */
    IntVector stuck;    /* 1 for nodes that stick, see `sticking.h` */
    Matrix whole;       /* `compliance` with tangential forces of these nodes */
    Vector whole_slide; /* `slide` without these forces */
    Vector whole_gap;   /* `gap` without contact forces */
} NodeScratch;

/* Coating under all contact nodes. */
typedef struct {
    Vector push;     /* force of the coating on each node [N] */
    IntVector near;  /* 1 for nodes whose rods are known, 2 for nodes that touch them */
    IntVector range; /* first and last rod under each node */
    Vector place;    /* place of the node that was pressed last, then of these rods [elements] */
    IntVector element; /* their elements */
    Matrix weight;   /* Hermite weights there */
    Matrix trial;    /* stress of each of these rods at the metal if it does not yield [Pa] */
    Matrix plastic;  /* its plastic strain at the start of the step */
    Vector stress;   /* stress of each rod under the node that was pressed last [Pa] */
    Vector grown;    /* growth of its plastic strain */
    double closed;   /* closure at the end of the step [m] */
    double steepest; /* bound of the slope of the rigid wall by the angle [m]; below 0: not known yet */
    double closing;  /* that of the share of the closure */
    double reach;    /* gap to the metal below which rods have to be evaluated [m] */
} RodScratch;

/* Forces of a group, see `pieces.h`. */
typedef struct {
    Vector place;  /* place of each node on its curve of gap and force */
    Vector force;  /* force at this place [N] */
    Vector slope;  /* its decrease with the place [N/m] */
    Vector open;   /* 1 if the place is a gap, 0 if the node touches the metal */
    Vector low;    /* kink below the place */
    Vector high;   /* kink above the place */
} PieceScratch;

/* A speed that varies. */
typedef struct {
    Vector stiffened;  /* product of `stiffening` and x_n */
    Vector stiffened4; /* product of `stiffening4` and x_n */
    Vector force;      /* force due to the change of the speed */
    Vector input;      /* scratch */
    Vector coupled;    /* G x_n + b of a free speed */
} SpeedScratch;

/* Bearings; rows of three steps are those of n - 1, n and n + 1. */
typedef struct {
    Matrix place;     /* displacement of the rotor at each end, rotating axes */
    Matrix other;     /* displacement of the support, static axes; or empty */
    Matrix stretch;   /* displacement of the rotor relative to the support, static axes */
    Vector force;     /* force on the rotor at step n, rotating axes */
    Vector spring;    /* part of the springs */
    Vector on_casing; /* force on the rotor, static axes */
    Matrix system;    /* linear system, with its right-hand side, padded */
    Vector turned;    /* damping matrices in rotating axes, by rows, divided by 2 h */
    Vector turn;      /* cosine and sine of psi at n */
    double energy;    /* D_{n-1}^T K D_n */
} BearingScratch;

/* Joints. */
typedef struct {
    Matrix acting;     /* forces of step n and before that act on the modes, by copy */
    Matrix on_nodes;   /* forces of the joints on the nodes, by copy */
    Vector predicted;  /* displacements x_{n+1} without forces of joints at step n + 1 */
    Vector wall;       /* forces of the wall on the nodes in the last round */
    Vector modal;      /* displacements due to the modes and the bodies */
    Vector body;       /* displacements of bodies at step n + 1 */
    Vector pushed;     /* forces of joints on bodies */
    Vector free;       /* displacements without contact forces */
    Vector base;       /* displacements with the forces of the wall */
    Vector moved;      /* displacements with all forces */
    Vector force;      /* forces at step n + 1 */
    Vector direction;  /* unit vectors along tangential forces of pairs that slip */
    Vector share;      /* friction limit of these pairs divided by the trial force */
    IntVector state;   /* JOINT_OPEN ... of each pair */
    IntVector closed;  /* values of closed pairs */
    Vector amplitude;  /* factor of each load pattern at step n + 1 */
    Vector radial;     /* radial displacements of the nodes due to the modes [m] */
    Vector gap;        /* gaps at the wall of these displacements [m] */
    ContactScratch system; /* equations of closed pairs */
} JointScratch;

typedef struct {
    FieldScratch fields;
    ContactScratch contact;
    SpringScratch springs;
    BendScratch bending;
    NodeScratch nodes;
    RodScratch rods;
    PieceScratch pieces;
    SpeedScratch speed;
    BearingScratch bearings;
    JointScratch joints;
    Vector turned;       /* modal forces on the rotor */
    Vector amplitude;    /* factor of each load pattern */
    Vector stroke;       /* displacement of each damper in two steps */
    Matrix damper_force; /* forces phi on rotor and casing */
} Scratch;

static void lay_fields(Arena *a, const Stage *g, const State *state, FieldScratch *s)
{
    const Rotor *rotor = g->rotor;
    int64_t wide = rotor->position.size, closed = g->casing->radial.start.columns;
    int64_t columns = rotor->own.columns, wall = g->casing->radial.weight.columns;
    int64_t entries = state->rotor.columns;
    entries = entries > state->casing.columns ? entries : state->casing.columns;
    s->sums = vector(a, 2 * columns + LANES);
    s->partner = vector(a, 2 * columns + LANES);
    s->blades = vector(a, rotor->shape.columns + LANES); /* `fold_field` repeats blade 0 */
    s->value = vector(a, 2 * wall + LANES);
    s->slope = vector(a, 2 * wall + LANES);
    s->nodal = matrix(a, 2, closed);
    s->change = vector(a, entries);
    s->at = vector(a, wide);
    s->element = integers(a, state->gap.size);
    s->hermite = matrix(a, 4, wide);
    s->recess = vector(a, wide);
    s->radial = vector(a, wide + LANES);
    s->moved = vector(a, wide + LANES);
    s->other = vector(a, wide);
    s->free_gap = vector(a, wide);
    s->gap = vector(a, wide);
}

static void lay_contact(Arena *a, const Stage *g, int64_t group, ContactScratch *s)
{
    int64_t wall = g->casing->radial.weight.columns, columns = g->rotor->own.columns;
    s->active = integers(a, group);
    s->system = matrix(a, group + 1, padded(group));
    s->others = matrix(a, group, padded(group));
    s->solution = vector(a, group);
    s->tableau = matrix(a, group, 2 * group + 2);
    s->basis = integers(a, group);
    s->rows = integers(a, 2 * group); /* forces act at two casing nodes each */
    s->factor = matrix(a, KINDS, 2 * padded(group));
    s->columns = matrix(a, KINDS, 2 * wall + LANES);
    s->blades = matrix(a, g->rotor->own.layers, 2 * columns + LANES);
    s->work = vector(a, 2);
    for (int64_t n = 0; a->at && n < group; n++)
        for (int64_t i = 0; i < group; i++)
            s->others.at[n * s->others.columns + i] = i != n;
}

static void lay_springs(Arena *a, const Stage *g, SpringScratch *s)
{
    int64_t waves = g->springs ? g->springs->factor.size : 0;
    s->rotor = matrix(a, 2, waves);
    s->casing = matrix(a, 2, waves);
    s->stretch = matrix(a, 4, waves);
    s->force = matrix(a, 2, waves);
}

static void lay_bending(Arena *a, const Stage *g, const State *state, BendScratch *s)
{
    int64_t tips = state->until.size, wide = padded(tips), lanes = state->bend.columns;
    int64_t entries = tips > 0 ? state->rotor.columns : 0;
    s->factor = matrix(a, tips, lanes);
    s->gradient = matrix(a, tips, entries);
    s->answer = matrix(a, tips > 0 ? g->foreshortening->answers.layers : 0, entries);
    s->bend = matrix(a, lanes, wide);
    s->bent = matrix(a, lanes, wide);
    s->term = vector(a, lanes);
    s->start = vector(a, tips);
    s->due = vector(a, wide);
    s->opened = vector(a, wide);
    s->opens = matrix(a, tips, wide);
    s->along = vector(a, tips);
    s->expected = vector(a, entries);
    s->force = vector(a, entries);
    s->near = integers(a, tips);
    s->list = integers(a, tips);
    s->count = integers(a, BEND_COUNTS);
    s->pushed = integers(a, tips);
}

static void lay_nodes(Arena *a, const Stage *g, const State *state, int64_t group, NodeScratch *s)
{
    const Rotor *rotor = g->rotor;
    int64_t tips = state->gap.size, wide = padded(group), forces = DIRECTIONS * group;
    int64_t components = rotor->compliance.rows;
    int64_t sliding = rotor->full > 0.0 ? 0 : group, slipping = group - sliding;
    s->modal = vector(a, state->rotor.columns / rotor->copies);
    s->force = matrix(a, rotor->copies, components);
    s->along = vector(a, rotor->position.size);
    s->sign = vector(a, tips);
    s->wanted = integers(a, rotor->copies);
    s->listed = integers(a, tips);
    s->list = integers(a, tips);
    s->known = integers(a, group);
    s->known_sign = vector(a, group);
    s->on_rotor = matrix(a, sliding, wide);
    s->ends = vector(a, HALF * wide);
    s->blocks = integers(a, wide);
    s->radius = vector(a, group);
    s->gap = vector(a, group);
    s->before = vector(a, group);
    s->slide = vector(a, forces);
    s->group_force = vector(a, forces);
    s->direction = vector(a, 2 * group);
    s->compliance = matrix(a, DIRECTIONS * slipping, forces);
    s->closed = vector(a, wide);
    s->miss = vector(a, 2 * group);
    s->multiplier = vector(a, group);
    s->response = matrix(a, group, wide);
    s->held = vector(a, group);
    s->stuck = integers(a, group);
    s->whole = matrix(a, DIRECTIONS * slipping, forces);
    s->whole_slide = vector(a, forces);
    s->whole_gap = vector(a, group);
}

static void lay_rods(Arena *a, const Stage *g, const State *state, RodScratch *s)
{
    int64_t tips = g->coating ? state->gap.size : 0, under = 0;
    s->steepest = -1.0;
    for (int64_t i = 0; g->coating && i < g->coating->half.size; i++) {
        int64_t most = (int64_t)(2.0 * g->coating->half.at[i]) + 2;
        under = under > most ? under : most;
    }
    s->push = vector(a, tips);
    s->near = integers(a, tips);
    s->range = integers(a, 2 * tips);
    under = (under + HALF - 1) / HALF * HALF;
    s->place = vector(a, under + 1);
    s->element = integers(a, under + 1);
    s->weight = matrix(a, HALF, under + 1);
    s->trial = matrix(a, tips, under);
    s->plastic = matrix(a, tips, under);
    s->stress = vector(a, under);
    s->grown = vector(a, under);
}

static void lay_pieces(Arena *a, int64_t group, PieceScratch *s)
{
    s->place = vector(a, group);
    s->force = vector(a, group);
    s->slope = vector(a, group);
    s->open = vector(a, group);
    s->low = vector(a, group);
    s->high = vector(a, group);
}

static void lay_bearings(Arena *a, const Stage *g, BearingScratch *s)
{
    int64_t ends = g->bearings ? g->bearings->rotor.rows : 0;
    s->place = matrix(a, 3, ends);
    s->other = matrix(a, g->bearings && g->bearings->casing.rows > 0 ? 3 : 0, ends);
    s->stretch = matrix(a, 3, ends);
    s->force = vector(a, ends);
    s->spring = vector(a, ends);
    s->on_casing = vector(a, ends);
    s->system = matrix(a, ends, padded(ends + 1));
    s->turned = vector(a, 2 * ends);
    s->turn = vector(a, 2);
}

static void lay_speed(Arena *a, const Stage *g, const State *state, SpeedScratch *s)
{
    int64_t spun = g->speed && g->speed->samples.rows > 0 ? state->rotor.columns : 0;
    int fourth = spun > 0 && (g->speed->stiffening4.full.rows > 0
                              || g->speed->stiffening4.blocks.size > 0);
    s->stiffened = vector(a, spun);
    s->stiffened4 = vector(a, fourth ? spun : 0);
    s->force = vector(a, spun);
    s->input = vector(a, spun);
    s->coupled = vector(a, g->drive ? spun : 0);
}

static void lay_joints(Arena *a, const Stage *g, const State *state, JointScratch *s)
{
    int64_t values = state->joint_force.columns, pairs = values / DIRECTIONS, wide = padded(values);
    int64_t nodes = g->joints ? g->rotor->position.size : 0;
    s->acting = matrix(a, g->joints ? g->rotor->copies : 0, g->rotor->compliance.rows);
    s->predicted = vector(a, g->joints ? state->rotor.columns : 0);
    s->modal = vector(a, wide);
    s->body = vector(a, state->bodies.columns);
    s->pushed = vector(a, state->bodies.columns);
    s->on_nodes = matrix(a, g->joints ? g->rotor->copies : 0, g->rotor->compliance.rows);
    s->wall = vector(a, g->joints ? state->force.rows * state->force.columns : 0);
    s->free = vector(a, values);
    s->base = vector(a, values);
    s->moved = vector(a, wide);
    s->force = vector(a, values);
    s->direction = vector(a, 2 * pairs);
    s->share = vector(a, pairs);
    s->state = integers(a, pairs);
    s->closed = integers(a, values);
    s->amplitude = vector(a, g->joints ? g->numbers->loads.rows : 0);
    s->radial = vector(a, nodes);
    s->gap = vector(a, nodes);
    s->system.system = matrix(a, values + 1, wide);
    s->system.others = matrix(a, values, wide);
    s->system.solution = vector(a, values);
    for (int64_t n = 0; a->at && n < values; n++)
        for (int64_t i = 0; i < values; i++)
            s->system.others.at[n * wide + i] = i != n;
}

/* Give all working arrays their places in an arena. */
static void lay_scratch(Arena *a, const Stage *g, const State *state, Scratch *s)
{
    const Dampers *dampers = g->dampers;
    int64_t tips = state->gap.size, most = 0;
    int64_t group = g->casing->modes > 0 ? tips : tips / g->rotor->copies;
    if (dampers) {
        int64_t one = dampers->rotor.rows.rows, two = dampers->casing.rows.rows;
        most = one > two ? one : two;
    }
    lay_fields(a, g, state, &s->fields);
    lay_contact(a, g, group, &s->contact);
    lay_springs(a, g, &s->springs);
    lay_bending(a, g, state, &s->bending);
    lay_nodes(a, g, state, group, &s->nodes);
    lay_rods(a, g, state, &s->rods);
    lay_pieces(a, group, &s->pieces);
    lay_speed(a, g, state, &s->speed);
    lay_bearings(a, g, &s->bearings);
    lay_joints(a, g, state, &s->joints);
    s->turned = vector(a, state->rotor.columns);
    s->amplitude = vector(a, g->numbers->loads.rows);
    s->stroke = vector(a, most);
    s->damper_force = matrix(a, 2, most);
}

#endif
