/* Contact forces of nodes that are solved together, the group, with or without an abradable coating,
 * for massless nodes and for nodes with mass; the equations are in `nodes.h` and `rods.h`. Arrays of
 * the group have DIRECTIONS entries for each node if they are vectors. */
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

/* Compute W for the directions of sliding of a group: all columns, or those of nodes in contact. */
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
        for (int64_t i = 0; i < size; i++, entry += DIRECTIONS * width)
            s->response.at[i * size + j] =
                entry[RADIAL] + (entry[TANGENTIAL] * across + entry[AXIAL] * along);
    }
}

/* Solve the equations of the active nodes with partial pivoting. Returns 0 if they are singular. */
static int solve_active(int64_t nodes, const double *gap, const double *response,
                        NodeScratch *s, int64_t size)
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
                        double *multiplier, NodeScratch *s)
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

/* Move the directions of sliding of nodes in contact towards those of the slip velocities, by a
 * share of the difference. Friction against a velocity lowers this velocity, so that whole
 * differences may overshoot; the share is that of Aitken's method for vectors. Returns the largest
 * difference. */
static double turn_directions(const March *m, int64_t size, double *share, int round)
{
    NodeScratch *s = &m->scratch->nodes;
    const Numbers *numbers = m->stage.numbers;
    int64_t width = s->compliance.columns;
    const double *force = s->group_force.at;
    double most = 0.0, along = 0.0, changed = 0.0, *last = s->miss.at;
    for (int64_t i = 0; i < size; i++) {
        double slip[2], *d = s->direction.at + 2 * i;
        double miss[2] = {0.0, 0.0};
        if (s->multiplier.at[i] > 0.0) {
            for (int k = 0; k < 2; k++) {
                const double *row = s->compliance.at + (DIRECTIONS * i + TANGENTIAL + k) * width;
                slip[k] = s->slide.at[DIRECTIONS * i + TANGENTIAL + k];
                for (int64_t j = 0; j < size; j++)
                    if (s->multiplier.at[j] > 0.0)
                        for (int64_t n = DIRECTIONS * j; n < DIRECTIONS * (j + 1); n++)
                            slip[k] += row[n] * force[n];
            }
            slip[0] += numbers->speed * s->radius.at[i] * numbers->time_step;
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
    for (int64_t i = 0; i < size; i++) {
        double *d = s->direction.at + 2 * i;
        double x = d[0] + *share * last[2 * i], y = d[1] + *share * last[2 * i + 1];
        double length = sqrt(x * x + y * y);
        if (s->multiplier.at[i] > 0.0 && length > 0.0) {
            d[0] = x / length;
            d[1] = y / length;
        }
    }
    return most;
}

/* Compute the forces of metal and coating on a group, for given directions of sliding, and their
 * gaps; see `rods.h`. Returns 0 without a solution. */
static int solve_coated(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    RodScratch *r = &m->scratch->rods;
    int64_t wide = size + 1, solved = 0;
    const double *w = s->response.at;
    double scale = m->stage.numbers->gap_scale;
    for (int64_t i = 0; i < size; i++)
        scale = larger(scale, fabs(s->gap.at[i]));
    for (int trial = 0; trial < MOST_NEWTON && !solved; trial++) {
        int metal = 0;
        for (int64_t i = 0; i < size; i++) {
            int64_t n = s->list.at[i];
            r->force.at[i] = r->slope.at[i] = r->metal.at[i] = 0.0;
            if (r->near.at[n])
                r->force.at[i] = press_node(m, n, r->gap.at[i], r->slope.at + i, NULL);
        }
        for (int with = 0; with < 2; with++) { /* first without metal, then with it */
            int64_t count = with ? size + 1 : 1, columns = size + count;
            double *system = r->system.at;
            for (int64_t i = 0; i < size; i++) {
                double right = s->gap.at[i];
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

/* Compute the contact forces of a group in contact at the end of a step, and its gaps. */
static void contact_forces(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    RodScratch *r = &m->scratch->rods;
    int coated = m->stage.node_coating != NULL, solved = 1;
    int turns = m->stage.nodes->full > 0.0 && m->stage.numbers->friction > 0.0;
    double *gap = s->gap.at;
    double change = 1.0, share = 1.0, worst = 0.0, scale = m->stage.numbers->gap_scale;
    for (int64_t i = 0; i < size; i++)
        s->held.at[i] = gap[i] < 0.0 || (!coated && s->before.at[DIRECTIONS * i + RADIAL] < 0.0);
    for (int64_t i = 0; coated && i < size; i++)
        r->gap.at[i] = gap[i];
    for (int round = 0; round < MOST_DIRECTIONS && change > SAME_DIRECTION; round++) {
        respond(m, size, round > 0 && !coated ? s->multiplier.at : NULL);
        solved = coated ? solve_coated(m, size)
                        : solve_normal(size, gap, s->response.at, s->multiplier.at, s);
        set_forces(m, size);
        change = turns ? turn_directions(m, size, &share, round) : 0.0;
    }
    for (int64_t i = 0; i < size; i++) {
        double after = gap[i];
        double multiplier = coated ? r->metal.at[i] : s->multiplier.at[i];
        for (int64_t j = 0; j < size; j++)
            after += s->response.at[i * size + j] * s->multiplier.at[j];
        scale = larger(scale, fabs(gap[i]));
        if (multiplier > 0.0)
            worst = larger(worst, fabs(smaller(after, s->response.at[i * size + i] * multiplier)));
        else
            worst = larger(worst, -after);
        s->closed.at[i] = after;
    }
    for (int64_t i = 0; i < size; i++)
        gap[i] = s->closed.at[i];
    double *residual = m->state->counts.at + RESIDUAL;
    *residual = larger(*residual, worst / scale);
    m->state->counts.at[UNSOLVED] += !solved || change > SAME_DIRECTION;
}

#endif
