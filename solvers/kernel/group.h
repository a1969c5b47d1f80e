/* Contact forces of nodes that are solved together, with or without an abradable coating, for massless
 * nodes and for nodes with mass; the equations are in `boundary.c` and `rods.h`. */
#ifndef GROUP_H
#define GROUP_H

#include <stddef.h>

#include "rods.h"

enum { MOST_DIRECTIONS = 100 }; /* iterations of the direction of sliding */
enum { MOST_NEWTON = 60 };      /* iterations of the forces of a coating */
enum { TOGETHER = 6 };          /* changes of the active set before nodes are changed one by one */
#define SAME_DIRECTION 1e-10    /* change of the direction of sliding at which iterations end */
#define LEAST_SHARE 0.01        /* smallest share of a change of the directions that is made */
#define NO_PIVOT 1e-13          /* share of the largest diagonal entry that counts as zero */

/* Contact nodes whose forces are computed together: a copy in a rigid wall, or all nodes that may
 * touch a ring. Vectors have DIRECTIONS entries for each node. */
typedef struct {
    int64_t size;
    const int64_t *node;      /* number among the nodes of all copies */
    const double *radius;
    const double *compliance; /* change of displacements due to unit forces, row by row */
    const double *before;     /* forces at step n */
    const double *slip;       /* displacements of the step relative to the wall, without forces at
                               * step n + 1 */
    double *gap;              /* gaps without contact, then with it */
    double *force;            /* forces at step n + 1 */
    double *direction;        /* tangential and axial part of the direction of sliding */
} Group;

/* Add the product of a vector and a matrix that is stored row by row. */
static void add_rows(const double *factor, const double *matrix, int64_t rows, int64_t columns,
                     double *out)
{
    for (int64_t i = 0; i < rows; i++) {
        double f = factor[i];
        const double *row = matrix + i * columns;
        if (f != 0.0)
            for (int64_t j = 0; j < columns; j++)
                out[j] += f * row[j];
    }
}

/* Return the clearance at an angle [rad]. */
static double clearance_at(const Matrix *wall, double angle, double *share, const Closure *closure)
{
    int64_t cells = wall->columns - 1;
    double turns = angle / (2.0 * PI), place = (turns - floor(turns)) * (double)cells;
    int64_t e = (int64_t)place;
    e = e < cells ? e : cells - 1;
    double x = place - (double)e, y = 1.0 - x;
    double w0 = y * y * (1.0 + 2.0 * x), w1 = x * y * y, w2 = x * x * (3.0 - 2.0 * x);
    double w3 = -x * x * y;
    const double *value = wall->at + e, *slope = value + wall->columns;
    *share = 0.0;
    if (closure) {
        const double *lost = closure->share.at + e, *rate = lost + closure->share.columns;
        *share = (w0 * lost[0] + w1 * rate[0]) + (w2 * lost[1] + w3 * rate[1]);
    }
    return (w0 * value[0] + w1 * slope[0]) + (w2 * value[1] + w3 * slope[1]);
}

/* Compute W for the directions of sliding of a group: all columns, or those of nodes in contact. */
static void respond(const Boundary *b, const Group *g, const double *multiplier, BoundaryScratch *s)
{
    int64_t nodes = g->size, width = DIRECTIONS * nodes;
    for (int64_t j = 0; j < nodes; j++) {
        if (multiplier && !(multiplier[j] > 0.0))
            continue;
        const double *entry = g->compliance + DIRECTIONS * j, *d = g->direction + 2 * j;
        double across = b->friction * d[0], along = b->friction * d[1];
        for (int64_t i = 0; i < nodes; i++, entry += DIRECTIONS * width)
            s->response.at[i * nodes + j] =
                entry[RADIAL] + (entry[TANGENTIAL] * across + entry[AXIAL] * along);
    }
}

/* Solve the equations of the active nodes with partial pivoting. Returns 0 if they are singular. */
static int solve_active(int64_t nodes, const double *gap, const double *response,
                        BoundaryScratch *s, int64_t size)
{
    int64_t width = size + 1;
    double *system = s->system.at, largest = 0.0;
    const int64_t *active = s->active.at;
    for (int64_t i = 0; i < size; i++) {
        for (int64_t j = 0; j < size; j++)
            system[i * width + j] = response[active[i] * nodes + active[j]];
        system[i * width + size] = -gap[active[i]];
        largest = larger(largest, fabs(system[i * width + i]));
    }
    for (int64_t k = 0; k < size; k++) {
        int64_t best = k;
        for (int64_t i = k + 1; i < size; i++)
            if (fabs(system[i * width + k]) > fabs(system[best * width + k]))
                best = i;
        if (!(fabs(system[best * width + k]) > NO_PIVOT * largest))
            return 0;
        for (int64_t j = k; best != k && j < width; j++) {
            double swapped = system[k * width + j];
            system[k * width + j] = system[best * width + j];
            system[best * width + j] = swapped;
        }
        for (int64_t i = k + 1; i < size; i++) {
            double ratio = system[i * width + k] / system[k * width + k];
            for (int64_t j = k + 1; ratio != 0.0 && j < width; j++)
                system[i * width + j] -= ratio * system[k * width + j];
        }
    }
    for (int64_t i = size - 1; i >= 0; i--) {
        double sum = system[i * width + size];
        for (int64_t j = i + 1; j < size; j++)
            sum -= system[i * width + j] * system[j * width + size];
        system[i * width + size] = sum / system[i * width + i];
    }
    return 1;
}

/* Solve the complementarity problem of a group for given directions of sliding, beginning with the
 * active set in `held`. The set is changed for all nodes at a time, then node by node, which ends
 * for every matrix whose principal minors are positive (Murty 1974). Returns 0 without a solution.
 */
static int solve_normal(int64_t nodes, const double *gap, const double *response,
                        double *multiplier, BoundaryScratch *s)
{
    int64_t *held = s->held.at;
    double scale = 0.0;
    for (int64_t i = 0; i < nodes; i++)
        scale = larger(scale, fabs(gap[i]));
    for (int64_t trial = 0; trial < TOGETHER + 20 * nodes + 20; trial++) {
        int64_t size = 0, wrong = 0;
        for (int64_t i = 0; i < nodes; i++)
            if (held[i])
                s->active.at[size++] = i;
        if (!solve_active(nodes, gap, response, s, size))
            return 0;
        for (int64_t i = 0; i < nodes; i++)
            multiplier[i] = 0.0;
        for (int64_t i = 0; i < size; i++)
            multiplier[s->active.at[i]] = s->system.at[i * (size + 1) + size];
        for (int64_t i = 0; i < nodes; i++) {
            int change = multiplier[i] < 0.0;
            if (!held[i]) {
                double after = gap[i];
                for (int64_t j = 0; j < size; j++)
                    after += response[i * nodes + s->active.at[j]] * multiplier[s->active.at[j]];
                change = after < -1e-14 * scale;
            }
            if (change) {
                if (wrong == 0 || trial < TOGETHER)
                    held[i] = !held[i];
                wrong++;
            }
        }
        if (wrong == 0)
            return 1;
    }
    return 0;
}

/* Set the forces of a group from the multipliers and the directions of sliding. */
static void set_forces(const Boundary *b, const BoundaryScratch *s, const Group *g)
{
    const double *direction = g->direction;
    double *force = g->force;
    for (int64_t i = 0; i < g->size; i++) {
        double normal = larger(0.0, s->multiplier.at[i]), drag = b->friction * normal;
        force[DIRECTIONS * i + RADIAL] = -normal;
        force[DIRECTIONS * i + TANGENTIAL] = -drag * direction[2 * i];
        force[DIRECTIONS * i + AXIAL] = -drag * direction[2 * i + 1];
    }
}

/* Move the directions of sliding of nodes in contact towards those of the slip velocities, by a
 * share of the difference. Friction against a velocity lowers this velocity, so that whole
 * differences may overshoot; the share is that of Aitken's method for vectors. Returns the largest
 * difference. */
static double turn_directions(const Boundary *b, BoundaryScratch *s, const Group *g, double *share,
                              int round)
{
    int64_t nodes = g->size, width = DIRECTIONS * nodes;
    const double *force = g->force;
    double most = 0.0, along = 0.0, changed = 0.0, *last = s->miss.at;
    for (int64_t i = 0; i < nodes; i++) {
        double slip[2], *d = g->direction + 2 * i;
        double miss[2] = {0.0, 0.0};
        if (s->multiplier.at[i] > 0.0) {
            for (int k = 0; k < 2; k++) {
                const double *row = g->compliance + (DIRECTIONS * i + TANGENTIAL + k) * width;
                slip[k] = g->slip[DIRECTIONS * i + TANGENTIAL + k];
                for (int64_t j = 0; j < nodes; j++)
                    if (s->multiplier.at[j] > 0.0)
                        for (int64_t n = DIRECTIONS * j; n < DIRECTIONS * (j + 1); n++)
                            slip[k] += row[n] * force[n];
            }
            slip[0] += b->speed * g->radius[i] * b->time_step;
            double length = sqrt(slip[0] * slip[0] + slip[1] * slip[1]);
            for (int k = 0; k < 2 && length > 0.0; k++) /* 0: the node sticks to the wall */
                miss[k] = slip[k] / length - d[k];
        }
        for (int k = 0; k < 2; k++) {
            double difference = miss[k] - last[2 * i + k];
            along += last[2 * i + k] * difference;
            changed += difference * difference;
            last[2 * i + k] = miss[k];
            most = larger(most, fabs(miss[k]));
        }
    }
    if (round > 0 && changed > 0.0)
        *share = smaller(1.0, larger(LEAST_SHARE, -*share * along / changed));
    for (int64_t i = 0; i < nodes; i++) {
        double *d = g->direction + 2 * i;
        double x = d[0] + *share * last[2 * i], y = d[1] + *share * last[2 * i + 1];
        double length = sqrt(x * x + y * y);
        if (s->multiplier.at[i] > 0.0 && length > 0.0) {
            d[0] = x / length;
            d[1] = y / length;
        }
    }
    return most;
}

/* Compute the wall at an angle and a time, without the recess of the node. */
static double wall_near(const Boundary *b, const Ring *ring, const Closure *closure, double angle,
                        double closed, const RingScratch *r)
{
    double share;
    if (!ring) {
        double clearance = clearance_at(&b->wall, angle, &share, closure);
        return clearance - closed * share;
    }
    const FieldScratch *f = &r->fields;
    int64_t nodes = ring->casing.nodes, e;
    double place = angle * (double)nodes / (2.0 * PI), weight[4];
    hermite_weights(&place, 0.0, (double)nodes, ring->casing.element_length, 1, 1, &e, weight);
    const double *value = f->nodal.at + e, *slope = f->nodal_slope.at + e;
    double wall = (weight[0] * value[0] + weight[1] * slope[0])
                  + (weight[2] * value[1] + weight[3] * slope[1]);
    if (closure) {
        value = closure->share.at + e;
        slope = value + closure->share.columns;
        wall -= closed
                * ((weight[0] * value[0] + weight[1] * slope[0])
                   + (weight[2] * value[1] + weight[3] * slope[1]));
    }
    return wall;
}

/* Find the rods under a node, and the wall there relative to the wall at the node. */
static void place_rods(const Boundary *b, const Ring *ring, const NodeCoating *c,
                       const Closure *closure, double closed, double time, int64_t n,
                       BoundaryScratch *s)
{
    int64_t *range = s->rods.range.at + 2 * n;
    double angle = b->angle.at[n] + b->speed * time, *offset = s->rods.offset.at;
    offset += n * s->rods.offset.columns;
    rods_under(c, n % b->radius.size, angle, range);
    double here = wall_near(b, ring, closure, angle, closed, &s->ring);
    for (int64_t k = range[0]; k <= range[1]; k++) {
        double place = 2.0 * PI * ((double)wrapped(c, k) + 0.5) / (double)c->rods;
        offset[k - range[0]] = wall_near(b, ring, closure, place, closed, &s->ring) - here;
    }
    s->rods.near.at[n] = 1;
}

/* Return the gap to the metal below which the rods under a node have to be evaluated. */
static double reach_of_rods(const Ring *ring, const NodeCoating *c, const BoundaryScratch *s)
{
    double slope = 0.0, half = 0.0;
    for (int64_t i = 0; i < c->half.size; i++)
        half = larger(half, c->half.at[i]);
    if (ring) {
        const Casing *casing = &ring->casing;
        const FieldScratch *f = &s->ring.fields;
        for (int64_t e = 0; e < casing->nodes; e++)
            slope = larger(slope, steepest(casing, e, f->nodal.at, f->nodal_slope.at));
        slope *= casing->element_length * (double)casing->nodes / (2.0 * PI);
    }
    slope += c->steepest;
    return c->limit * c->thickness + slope * (half + 0.5) * 2.0 * PI / (double)c->rods;
}

/* Find the nodes that touch the coating without contact forces of this step. */
static void find_rods(const Boundary *b, const Ring *ring, const NodeCoating *c,
                      const Closure *closure, double time, BoundaryState *state,
                      BoundaryScratch *s)
{
    double rate, closed = closure ? closure_at(closure, time, &rate) : 0.0, slope;
    double reach = reach_of_rods(ring, c, s);
    int64_t nodes = b->radius.size;
    for (int64_t n = 0; n < b->a.rows * nodes; n++) {
        s->rods.near.at[n] = 0;
        s->rods.pressed.at[n] = 0.0;
        if (!(s->gap.at[n] < reach))
            continue;
        place_rods(b, ring, c, closure, closed, time, n, s);
        if (press_rods(c, n % nodes, s->rods.range.at + 2 * n,
                       s->rods.offset.at + n * s->rods.offset.columns, s->gap.at[n],
                       state->strain.at, &slope, NULL)
            > 0.0)
            s->rods.near.at[n] = 2;
    }
    state->coating.at[STORED] = 0.0;
}

/* Compute the forces of metal and coating on a group, for given directions of sliding, and their
 * gaps; see `rods.h`. Returns 0 without a solution. */
static int solve_coated(const Boundary *b, const NodeCoating *c, BoundaryState *state,
                        BoundaryScratch *s, const Group *g)
{
    RodScratch *r = &s->rods;
    int64_t size = g->size, wide = size + 1, solved = 0;
    const double *w = s->response.at;
    double scale = b->gap_scale;
    for (int64_t i = 0; i < size; i++)
        scale = larger(scale, fabs(g->gap[i]));
    for (int trial = 0; trial < MOST_NEWTON && !solved; trial++) {
        int metal = 0;
        for (int64_t i = 0; i < size; i++) {
            int64_t n = g->node[i];
            r->force.at[i] = r->slope.at[i] = r->metal.at[i] = 0.0;
            if (r->near.at[n])
                r->force.at[i] = press_rods(c, n % b->radius.size, r->range.at + 2 * n,
                                            r->offset.at + n * r->offset.columns, r->gap.at[i],
                                            state->strain.at, r->slope.at + i, NULL);
        }
        for (int with = 0; with < 2; with++) { /* first without metal, then with it */
            int64_t count = with ? size + 1 : 1, columns = size + count;
            double *system = r->system.at;
            for (int64_t i = 0; i < size; i++) {
                double right = g->gap[i];
                for (int64_t j = 0; j < size; j++) {
                    double flexible = w[i * size + j];
                    system[i * columns + j] = (i == j) + flexible * r->slope.at[j];
                    right += flexible * (r->force.at[j] + r->slope.at[j] * r->gap.at[j]);
                    if (with)
                        system[i * columns + wide + j] = flexible;
                }
                system[i * columns + size] = right;
            }
            if (!eliminate_rows(system, size, count))
                return 0;
            for (int64_t i = 0; i < size; i++) {
                r->free.at[i] = system[i * columns + size];
                metal |= r->free.at[i] < 0.0;
                for (int64_t j = 0; with && j < size; j++)
                    r->response.at[i * size + j] = system[i * columns + wide + j];
            }
            if (!metal)
                break;
        }
        if (metal && !solve_normal(size, r->free.at, r->response.at, r->metal.at, s))
            return 0;
        double change = 0.0;
        for (int64_t i = 0; i < size; i++) {
            double after = r->free.at[i];
            for (int64_t j = 0; metal && j < size; j++)
                after += r->response.at[i * size + j] * r->metal.at[j];
            change = larger(change, fabs(after - r->gap.at[i]));
            r->gap.at[i] = after;
        }
        solved = change <= 1e-14 * scale;
    }
    for (int64_t i = 0; i < size; i++)
        s->multiplier.at[i] = r->metal.at[i] + r->force.at[i];
    return (int)solved;
}

/* Wear the rods under a group at its final gaps, and add to the sums of the coating. */
static void wear_rods(const Boundary *b, const NodeCoating *c, BoundaryState *state,
                      BoundaryScratch *s, const Group *g)
{
    double slope;
    for (int64_t i = 0; i < g->size; i++) {
        int64_t n = g->node[i];
        if (s->rods.near.at[n])
            s->rods.pressed.at[n] =
                press_rods(c, n % b->radius.size, s->rods.range.at + 2 * n,
                           s->rods.offset.at + n * s->rods.offset.columns, s->rods.gap.at[i],
                           state->strain.at, &slope, state->coating.at);
    }
}

/* Compute the contact forces of a group in contact at the end of a step, and its gaps. */
static void contact_forces(const Boundary *b, const NodeCoating *coating, BoundaryState *state,
                           BoundaryScratch *s, const Group *g)
{
    int64_t nodes = g->size, solved = 1;
    double *gap = g->gap;
    double change = 1.0, share = 1.0, worst = 0.0, scale = b->gap_scale;
    for (int64_t i = 0; i < nodes; i++)
        s->held.at[i] = gap[i] < 0.0 || (!coating && g->before[DIRECTIONS * i + RADIAL] < 0.0);
    for (int64_t i = 0; coating && i < nodes; i++)
        s->rods.gap.at[i] = gap[i];
    for (int round = 0; round < MOST_DIRECTIONS && change > SAME_DIRECTION; round++) {
        respond(b, g, round > 0 && !coating ? s->multiplier.at : NULL, s);
        solved = coating ? solve_coated(b, coating, state, s, g)
                         : solve_normal(nodes, gap, s->response.at, s->multiplier.at, s);
        set_forces(b, s, g);
        change = b->full > 0.0 && b->friction > 0.0 ? turn_directions(b, s, g, &share, round) : 0.0;
    }
    for (int64_t i = 0; i < nodes; i++) {
        double after = gap[i];
        double multiplier = coating ? s->rods.metal.at[i] : s->multiplier.at[i];
        for (int64_t j = 0; j < nodes; j++)
            after += s->response.at[i * nodes + j] * s->multiplier.at[j];
        scale = larger(scale, fabs(gap[i]));
        if (multiplier > 0.0)
            worst = larger(worst, fabs(smaller(after, s->response.at[i * nodes + i] * multiplier)));
        else
            worst = larger(worst, -after);
        s->closed.at[i] = after;
    }
    for (int64_t i = 0; i < nodes; i++)
        gap[i] = s->closed.at[i];
    double *residual = state->counts.at + RESIDUAL;
    *residual = larger(*residual, worst / scale);
    state->counts.at[UNSOLVED] += !solved || change > SAME_DIRECTION;
}

#endif
