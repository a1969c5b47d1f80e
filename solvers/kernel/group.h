/* Contact forces of nodes that are solved together, the group, with or without an abradable coating,
 * for massless nodes and for nodes with mass; the equations are in `nodes.h` and `rods.h`. Arrays of
 * the group have DIRECTIONS entries for each node if they are vectors. Nodes that stick: `sticking.h`.
 */
#ifndef GROUP_H
#define GROUP_H

#include "pieces.h"

enum { MOST_DIRECTIONS = 100 }; /* iterations of the direction of sliding */
#define LEAST_SHARE 0.01        /* smallest share of a change of the directions that is made */

/* Compute W for directions of sliding that follow the slip: all columns, or those of nodes in contact. */
static void respond(const March *m, int64_t size, const double *multiplier)
{
    NodeScratch *s = &m->scratch->nodes;
    double friction = m->stage.numbers->friction;
    int64_t width = s->compliance.columns;
    for (int64_t j = 0; j < size; j++) {
        if (multiplier && !(multiplier[j] > 0.0))
            continue;
        const double *entry = s->compliance.at + DIRECTIONS * j, *d = s->direction.at + 2 * j;
        double across = friction * d[0], along = friction * d[1];
        double *row = s->response.at + j * s->response.columns;
        for (int64_t i = 0; i < size; i++, entry += DIRECTIONS * width)
            row[i] = entry[RADIAL] + (entry[TANGENTIAL] * across + entry[AXIAL] * along);
    }
}

/* Compute the gaps with the contact forces from W. */
static void close_gaps(const Candidates *k, double *after)
{
    int64_t width = k->response->columns;
    for (int64_t i = 0; i < k->nodes; i++)
        after[i] = k->gap[i];
    for (int64_t h = 0; h < k->nodes; h += LANES) {
        Lanes sum = load(after + h);
        for (int64_t j = 0; j < k->nodes; j++)
            sum = muladd(splat(k->multiplier[j]), load(k->response->at + j * width + h), sum);
        store(after + h, sum);
    }
}

/* Solve the complementarity problem of a group for given directions of sliding, beginning with the
 * active set in `held`. Returns 0 without a solution. */
static int solve_normal(const March *m, const Candidates *k)
{
    ContactScratch *c = &m->scratch->contact;
    double *after = m->scratch->nodes.closed.at, scale = 0.0;
    int64_t trial = 1, joined = 1;
    int solved = 1;
    while (joined > 0) {
        int64_t size = contact_multipliers(&trial, &solved, k, c);
        if (trial >= LAST_TRIAL || size == k->nodes)
            return solved;
        for (int64_t i = 0; i < k->nodes; i++)
            scale = larger(scale, fabs(k->gap[i]));
        joined = 0;
        close_gaps(k, after);
        for (int64_t i = 0; i < k->nodes; i++) {
            if (k->held[i] > 0.0 || !(after[i] < -1e-14 * scale))
                continue;
            if (joined == 0 || trial <= MENDED_TOGETHER)
                k->held[i] = 1.0;
            joined++;
        }
        trial += joined > 0;
    }
    return solved;
}

/* Set the forces of a group from the multipliers and the directions of sliding. */
static void set_forces(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    const double *direction = s->direction.at;
    for (int64_t i = 0; i < size; i++) {
        double *force = s->group_force.at + DIRECTIONS * i;
        double normal = larger(0.0, s->multiplier.at[i]);
        double drag = m->stage.numbers->friction * normal;
        force[RADIAL] = -normal;
        force[TANGENTIAL] = -drag * direction[2 * i];
        force[AXIAL] = -drag * direction[2 * i + 1];
    }
}

/* Compute the slip of a node in the step for the forces of the group. */
static void slip_of(const March *m, int64_t i, int64_t size, double slip[2])
{
    const NodeScratch *s = &m->scratch->nodes;
    for (int k = 0; k < 2; k++) {
        int64_t component = DIRECTIONS * i + TANGENTIAL + k;
        slip[k] = s->slide.at[component]
                  + dot(s->compliance.at + component * s->compliance.columns, s->group_force.at,
                        DIRECTIONS * size);
    }
    slip[0] += m->rotation.speed * s->radius.at[i] * m->stage.numbers->time_step;
}

/* Move the directions of sliding of nodes in contact towards those of the slip velocities, by a
 * share of the difference. Friction against a velocity lowers this velocity, so that whole
 * differences may overshoot; the share is that of Aitken's method for vectors. Returns the largest
 * difference. */
static double turn_directions(const March *m, int64_t size, double *share, int round)
{
    NodeScratch *s = &m->scratch->nodes;
    double most = 0.0, along = 0.0, changed = 0.0, *last = s->miss.at;
    for (int64_t i = 0; i < size; i++) {
        double slip[2], *d = s->direction.at + 2 * i;
        double miss[2] = {0.0, 0.0};
        if (s->multiplier.at[i] > 0.0 && !s->stuck.at[i]) {
            slip_of(m, i, size, slip);
            double length = sqrt(slip[0] * slip[0] + slip[1] * slip[1]);
            for (int k = 0; k < 2 && length > 0.0; k++) /* 0: no direction */
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
    for (int64_t i = 0; i < size; i++) {
        double *d = s->direction.at + 2 * i;
        double x = d[0] + *share * last[2 * i], y = d[1] + *share * last[2 * i + 1];
        double length = sqrt(x * x + y * y);
        if (s->multiplier.at[i] > 0.0 && !s->stuck.at[i] && length > 0.0) {
            d[0] = x / length;
            d[1] = y / length;
        }
    }
    return most;
}

/* Compute the forces of a group whose nodes slide, but for those of `stuck`. Returns the largest change
 * of a direction of sliding in the last iteration, INFINITY without normal forces. */
static double slide_group(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    double *place = m->scratch->pieces.place.at;
    int coated = m->stage.coating != NULL, full = m->stage.rotor->full > 0.0, solved = 1;
    int turns = full && m->stage.numbers->friction > 0.0;
    double change = 1.0, share = 1.0;
    Candidates nodes = {size, s->gap.at, s->held.at, s->multiplier.at, &s->response};
    for (int64_t i = 0; i < size; i++) {
        s->held.at[i] = s->gap.at[i] < 0.0 || (!coated && s->before.at[i] < 0.0);
        place[i] = s->gap.at[i];
    }
    for (int round = 0; round < MOST_DIRECTIONS && change > SAME_DIRECTION; round++) {
        if (full)
            respond(m, size, round > 0 && !coated ? s->multiplier.at : NULL);
        solved = (!coated && solve_normal(m, &nodes)) || solve_pieces(m, size);
        set_forces(m, size);
        change = turns ? turn_directions(m, size, &share, round) : 0.0;
    }
    return solved ? change : INFINITY;
}

#endif
