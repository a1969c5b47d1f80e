/* Normal forces of a group of contact nodes by pieces on which gaps and forces are linear.
 *
 * The state of a node is its place s on a curve of gap and force: for s > 0 the gap is s and the force
 * is that F(s) of the rods of a coating; for s < 0 the node touches the metal, with the force
 * F(0) - s / |W_ii|. The places of all nodes follow from
 *
 *     max(s, 0) = g_free + W p(s)
 *
 * with the forces p. Both sides are linear between kinks. Newton's method solves this in a few
 * iterations; where it cycles, the straight line from the residual to zero is followed from piece to
 * piece (Katzenelson 1965, Bell System Technical Journal 44(8)). With friction the line can turn back
 * in a piece; it is then followed backward, so that every solution that it reaches is found.
 */
#ifndef PIECES_H
#define PIECES_H

#include "complementarity.h"
#include "rods.h"

#define SAME_DIRECTION 1e-10 /* change of the direction of sliding at which iterations end */
enum { MOST_NEWTON = 40, MOST_PIECES = 4000 }; /* iterations, and pieces on a line */

/* Return the force of a node of the group at a place; `slope` gets its decrease with the place. */
static double force_at(const March *m, int64_t i, double place, double *slope)
{
    const NodeScratch *s = &m->scratch->nodes;
    double force = 0.0;
    *slope = 0.0;
    if (m->stage.coating && m->scratch->rods.near.at[s->list.at[i]])
        force = press_node(m, s->list.at[i], larger(place, 0.0), slope);
    if (place < 0.0) {
        *slope = 1.0 / larger(fabs(s->response.at[i * s->response.columns + i]), 1e-300);
        force -= place * *slope;
    }
    return force;
}

/* Return the nearest kink of a node of the group above or below a place. */
static double next_kink(const March *m, int64_t i, double place, int above)
{
    int64_t n = m->scratch->nodes.list.at[i];
    double kink = above ? (place < 0.0 ? 0.0 : INFINITY) : (place > 0.0 ? 0.0 : -INFINITY);
    if (!m->stage.coating || !m->scratch->rods.near.at[n])
        return kink;
    return kink_of_rods(m, n, place, above, kink);
}

/* Compute the change of the places that solves the equations if forces are linear, as the solution of
 * the contact system. Returns 0 if they are singular. */
static int linear_step(const March *m, int64_t size)
{
    const PieceScratch *p = &m->scratch->pieces;
    const Matrix *response = &m->scratch->nodes.response;
    ContactScratch *c = &m->scratch->contact;
    double *column = c->system.at, *right = column + size * c->system.columns;
    for (int64_t i = 0; i < size; i++)
        right[i] = m->scratch->nodes.gap.at[i] - larger(p->place.at[i], 0.0);
    for (int64_t j = 0; j < size; j++, column += c->system.columns) {
        const double *from = response->at + j * response->columns;
        Lanes slope = splat(p->slope.at[j]), force = splat(p->force.at[j]);
        for (int64_t i = 0; i < size; i += LANES) {
            store(column + i, mul(load(from + i), slope));
            store(right + i, muladd(load(from + i), force, load(right + i)));
        }
        column[j] += p->open.at[j];
    }
    return eliminate(c, size);
}

/* Take a place of a node of the group, with the force there and its slope. */
static void take_place(const March *m, int64_t i, double place)
{
    PieceScratch *p = &m->scratch->pieces;
    p->place.at[i] = place;
    p->force.at[i] = force_at(m, i, place, p->slope.at + i);
    p->open.at[i] = place >= 0.0;
}

/* Solve the equations by Newton's method from the places. Returns 0 if it does not converge. */
static int newton(const March *m, int64_t size, double scale)
{
    PieceScratch *p = &m->scratch->pieces;
    const double *steps = m->scratch->contact.solution.at;
    double share = 1.0, last = INFINITY; /* of a step, and its size before */
    int refined = 0;                     /* whether the step before was exact too */
    for (int64_t i = 0; i < size; i++)
        take_place(m, i, p->place.at[i]);
    for (int trial = 0; trial < MOST_NEWTON; trial++) {
        if (!linear_step(m, size))
            return 0;
        double change = 0.0;
        int exact = 1; /* whether gaps and forces at the new places are those that were assumed */
        for (int64_t i = 0; i < size; i++) {
            double from = p->place.at[i], slope = p->slope.at[i], open = p->open.at[i];
            double assumed = p->force.at[i] - slope * steps[i], to = from + steps[i];
            take_place(m, i, to);
            double force = p->force.at[i];
            change = larger(change, fabs(steps[i]));
            exact &= fabs(force - assumed) <= 1e-13 * fabs(force) + 1e-14 * scale * slope;
            exact &= fabs(open > 0.0 ? smaller(to, 0.0) : larger(to, 0.0)) <= 1e-14 * scale;
        }
        share = exact || !(change > 0.5 * last) ? 1.0 : larger(0.5 * share, 0.125);
        last = change;
        for (int64_t i = 0; i < size && share < 1.0; i++)
            take_place(m, i, p->place.at[i] - (1.0 - share) * steps[i]);
        if (exact && (refined || change <= 1e-14 * scale))
            return 1;
        refined = exact;
    }
    return 0;
}

/* Solve the equations by following the line from the places. Returns 0 if it ends without a solution.
 */
static int follow_pieces(const March *m, int64_t size)
{
    PieceScratch *p = &m->scratch->pieces;
    int64_t crossed = -1;
    double way = 1.0, slope;
    for (int64_t i = 0; i < size; i++) {
        p->low.at[i] = next_kink(m, i, p->place.at[i], 0);
        p->high.at[i] = next_kink(m, i, p->place.at[i], 1);
    }
    for (int64_t piece = 0; piece < MOST_PIECES; piece++) {
        for (int64_t i = 0; i < size; i++) {
            double low = p->low.at[i], high = p->high.at[i], middle = 0.5 * (low + high);
            if (!isfinite(middle))
                middle = isfinite(low) ? low + fabs(low) + 1.0 : high - fabs(high) - 1.0;
            force_at(m, i, middle, p->slope.at + i);
            p->force.at[i] = force_at(m, i, p->place.at[i], &slope);
            p->open.at[i] = middle > 0.0;
        }
        if (!linear_step(m, size))
            return 0;
        const double *step = m->scratch->contact.solution.at;
        double forward = crossed >= 0 && way * step[crossed] < 0.0 ? -1.0 : 1.0;
        double length = forward > 0.0 ? 1.0 : INFINITY;
        crossed = -1;
        for (int64_t i = 0; i < size; i++) {
            double move = forward * step[i];
            double to = move > 0.0 ? p->high.at[i] : p->low.at[i];
            if (move != 0.0 && (to - p->place.at[i]) / move < length) {
                length = larger(0.0, (to - p->place.at[i]) / move);
                crossed = i;
            }
        }
        if (!isfinite(length))
            return 0;
        for (int64_t i = 0; i < size; i++)
            p->place.at[i] += length * forward * step[i];
        if (crossed < 0)
            return 1;
        way = forward * step[crossed] > 0.0 ? 1.0 : -1.0;
        double *low = p->low.at + crossed, *high = p->high.at + crossed;
        p->place.at[crossed] = way > 0.0 ? *high : *low;
        *(way > 0.0 ? low : high) = p->place.at[crossed];
        *(way > 0.0 ? high : low) = next_kink(m, crossed, p->place.at[crossed], way > 0.0);
    }
    return 0;
}

/* Compute the forces of coating and metal on a group for given directions of sliding, from the gaps
 * without contact. Returns 0 without a solution. */
static int solve_pieces(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    PieceScratch *p = &m->scratch->pieces;
    double scale = m->stage.numbers->gap_scale, slope;
    for (int64_t i = 0; i < size; i++)
        scale = larger(scale, fabs(s->gap.at[i]));
    int solved = newton(m, size, scale);
    if (!solved) {
        for (int64_t i = 0; i < size; i++)
            p->place.at[i] = s->gap.at[i];
        solved = follow_pieces(m, size) && newton(m, size, scale);
    }
    for (int64_t i = 0; i < size; i++)
        s->multiplier.at[i] = solved ? p->force.at[i] : force_at(m, i, p->place.at[i], &slope);
    return solved;
}

#endif
