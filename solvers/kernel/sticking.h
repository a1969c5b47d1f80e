/* Coulomb friction of a group with stick and slip, node by node.
 *
 * The directions of sliding are iterated for all nodes together, see `group.h`. Where this does not
 * converge, as it cannot where a node sticks, the forces of one node after another are computed with
 * those of the others (Jourdan, Alart and Jean 1998, Computer Methods in Applied Mechanics and
 * Engineering 155). A node with the normal force p and the tangential force t has
 *
 *     gap = g + C_nn p - C_nt t,      slip = u - C_tn p + C_tt t,
 *
 * and either sticks, slip = 0 and |t| <= friction p, or slides, t = -friction p slip / |slip|.
 */
#ifndef STICKING_H
#define STICKING_H

#include "pieces.h"

enum { MOST_SWEEPS = 2000 }; /* sweeps over all nodes with the same share of the change */
enum { SHARES = 4 };         /* shares 1, 1/2, 1/4 and so on, where forces alternate */
enum { ANGLES = 64 };        /* directions that are tried in a circle */
enum { HALVINGS = 60 };      /* of an interval, to rounding */

/* A node between the forces of the others. */
typedef struct {
    const March *m;
    int64_t node;   /* number in the group */
    int64_t size;   /* number of nodes of the group */
    double gap;     /* without its force */
    double slip[2]; /* without its force, along the circumference and the axis */
    double c[DIRECTIONS][DIRECTIONS];
    double force[DIRECTIONS]; /* -p, t */
    double place;             /* place on the curve of `pieces.h` */
} Alone;

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

/* Find the place where max(s, 0) = gap + w p(s) for w > 0. Returns p. */
static double press_alone(Alone *a, double gap, double w)
{
    double slope, low = smaller(gap, -1.0), high = larger(gap, 0.0), force;
    for (;; high = 2.0 * high + 1e-9 * a->m->stage.numbers->gap_scale) {
        force = force_at(a->m, a->node, a->size, high, &slope);
        if (high - gap - w * force >= 0.0)
            break;
    }
    while (larger(low, 0.0) - gap - w * force_at(a->m, a->node, a->size, low, &slope) > 0.0)
        low *= 2.0;
    double place = smaller(larger(a->place, low), high);
    for (int n = 0; n < 2 * HALVINGS && high - low > 1e-16 * (fabs(low) + fabs(high)); n++) {
        force = force_at(a->m, a->node, a->size, place, &slope);
        double miss = larger(place, 0.0) - gap - w * force;
        if (miss > 0.0)
            high = place;
        else
            low = place;
        double next = place - miss / ((place >= 0.0) + w * slope);
        if (next == place)
            break;
        place = next > low && next < high ? next : 0.5 * (low + high);
    }
    a->place = place;
    return force_at(a->m, a->node, a->size, place, &slope);
}

/* Compute the force of a node that slides in a direction. Returns the part of its slip across the
 * direction, counter-clockwise; `along` gets that along the direction. */
static double slide_alone(Alone *a, double angle, double *along)
{
    double friction = a->m->stage.numbers->friction, d[2] = {cos(angle), sin(angle)}, slip[2];
    double w = a->c[RADIAL][RADIAL]
               + friction * (a->c[RADIAL][TANGENTIAL] * d[0] + a->c[RADIAL][AXIAL] * d[1]);
    double p = press_alone(a, a->gap, larger(w, 1e-3 * a->c[RADIAL][RADIAL]));
    a->force[RADIAL] = -p;
    for (int k = 0; k < 2; k++)
        a->force[TANGENTIAL + k] = -friction * p * d[k];
    for (int k = 0; k < 2; k++)
        slip[k] = a->slip[k] + a->c[TANGENTIAL + k][0] * a->force[0]
                  + a->c[TANGENTIAL + k][1] * a->force[1] + a->c[TANGENTIAL + k][2] * a->force[2];
    *along = slip[0] * d[0] + slip[1] * d[1];
    return slip[1] * d[0] - slip[0] * d[1];
}

/* Compute the force of a node that sticks. Returns whether friction can hold it. */
static int stick_alone(Alone *a)
{
    double (*c)[DIRECTIONS] = a->c;
    double det = c[1][1] * c[2][2] - c[1][2] * c[2][1], t[2][2];
    int flat = !(fabs(det) > 1e-12 * (c[1][1] * c[1][1] + c[2][2] * c[2][2])); /* no axial motion */
    if (flat && (c[2][2] != 0.0 || !(c[1][1] > 0.0)))
        return 0;
    for (int k = 0; k < 2; k++) { /* tangential forces without and with a unit normal force */
        double one = k ? c[1][0] : -a->slip[0], two = k ? c[2][0] : -a->slip[1];
        t[k][0] = flat ? one / c[1][1] : (c[2][2] * one - c[1][2] * two) / det;
        t[k][1] = flat ? 0.0 : (c[1][1] * two - c[2][1] * one) / det;
    }
    double gap = a->gap - c[0][1] * t[0][0] - c[0][2] * t[0][1];
    double w = c[0][0] - c[0][1] * t[1][0] - c[0][2] * t[1][1];
    if (!(w > 0.0))
        return 0;
    double p = press_alone(a, gap, w), held = a->m->stage.numbers->friction * p;
    a->force[RADIAL] = -p;
    for (int k = 0; k < 2; k++)
        a->force[TANGENTIAL + k] = t[0][k] + p * t[1][k];
    return a->force[1] * a->force[1] + a->force[2] * a->force[2] <= held * held;
}

/* Compute the force of a node between the others; `angle` is its direction of sliding. */
static void solve_alone(Alone *a, double *angle)
{
    double along, before[2], across[2], step = 2.0 * PI / ANGLES;
    if (stick_alone(a)) {
        if (a->force[TANGENTIAL] != 0.0 || a->force[AXIAL] != 0.0)
            *angle = atan2(-a->force[AXIAL], -a->force[TANGENTIAL]);
        return;
    }
    before[0] = before[1] = slide_alone(a, *angle, &along);
    for (int n = 1; n <= ANGLES / 2; n++) /* the nearest direction on either side */
        for (int side = 0; side < 2; side++) {
            double sign = side ? -1.0 : 1.0, inner = *angle + sign * (n - 1) * step, ahead;
            across[side] = slide_alone(a, inner + sign * step, &ahead);
            if ((across[side] > 0.0) == (before[side] > 0.0)) {
                before[side] = across[side];
                continue;
            }
            double outer = inner + sign * step, found = inner;
            for (int h = 0; h < HALVINGS && found != 0.5 * (inner + outer); h++) {
                found = 0.5 * (inner + outer);
                if ((slide_alone(a, found, &along) > 0.0) == (before[side] > 0.0))
                    inner = found;
                else
                    outer = found;
            }
            if (along > 0.0) {
                *angle = found;
                return;
            }
            before[side] = across[side];
        }
    slide_alone(a, *angle, &along);
}

/* Compute the forces of a group with stick and slip from those of the last iteration. Returns the
 * change of the forces in the last sweep, divided by the largest force. */
static double sweep_nodes(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = s->compliance.columns;
    double *place = m->scratch->pieces.place.at;
    double change = INFINITY, largest = 1.0, share = 1.0;
    for (int n = 0; n < SHARES * MOST_SWEEPS && change > SAME_DIRECTION * share * largest; n++) {
        change = largest = 0.0;
        share = 1.0 / (1 << n / MOST_SWEEPS);
        for (int64_t i = 0; i < size; i++) {
            double *force = s->group_force.at + DIRECTIONS * i, *d = s->direction.at + 2 * i;
            double angle = atan2(d[1], d[0]), last[DIRECTIONS];
            Alone a = {.m = m, .node = i, .size = size, .gap = s->gap.at[i], .place = place[i]};
            for (int k = 0; k < DIRECTIONS; k++) {
                last[k] = force[k];
                force[k] = 0.0;
                for (int l = 0; l < DIRECTIONS; l++)
                    a.c[k][l] = s->compliance.at[(DIRECTIONS * i + k) * width + DIRECTIONS * i + l];
            }
            slip_of(m, i, size, a.slip);
            a.gap -= dot(s->compliance.at + DIRECTIONS * i * width, s->group_force.at,
                         DIRECTIONS * size);
            solve_alone(&a, &angle);
            d[0] = cos(angle);
            d[1] = sin(angle);
            place[i] = a.place;
            for (int k = 0; k < DIRECTIONS; k++) {
                force[k] = last[k] + share * (a.force[k] - last[k]);
                change = larger(change, fabs(force[k] - last[k]));
                largest = larger(largest, fabs(force[k]));
            }
            s->multiplier.at[i] = -force[RADIAL];
        }
    }
    return largest > 0.0 ? change / largest : 0.0;
}

#endif
