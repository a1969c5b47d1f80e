/* Coulomb friction of a group with stick and slip.
 *
 * Where the directions of sliding do not converge, see `group.h`, some nodes stick. For a set of nodes
 * that stick, their tangential forces follow linearly from the other forces,
 *
 *     slip = u + C f = 0,
 *
 * and are eliminated from the equations, which then are those of the nodes that slide. A node for which
 * friction does not suffice, |t| > friction p, leaves the set, one whose direction of sliding does not
 * converge enters it, first all at once, then one by one. If this does not end, the forces are relaxed
 * node by node, which converges slowly, but for any number of nodes, where friction is below that at
 * which they lock without the modes. For few nodes all sets are tried in the end, from directions of
 * sliding that spread over the circle: there can be several solutions or, above that friction, none, and
 * no rule is known that always ends.
 */
#ifndef STICKING_H
#define STICKING_H

#include "group.h"

enum { CHANGED_TOGETHER = 6 }; /* trials of a set before nodes are changed one by one */
enum { RELAXED = 4000 };       /* sweeps over the nodes in which forces are relaxed */
enum { FEW = 8 };              /* nodes of which all sets are tried */
enum { MOST_SETS = 4096 };     /* trials of all sets from different directions of sliding */
#define SETTLED 1e-13           /* change of a force in a sweep, as a share of the largest force */
#define GOLDEN 2.399963229728653 /* angle, multiples of which spread over the circle */

/* Eliminate the tangential forces of the nodes that stick: their lines of the equations become those
 * of the forces, and the others no longer depend on them. */
static void eliminate_stuck(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = s->compliance.columns, n = DIRECTIONS * size;
    double turned = m->rotation.speed * m->stage.numbers->time_step;
    for (int64_t own = 0; own < n; own++) {
        int64_t node = own / DIRECTIONS;
        double *row = s->compliance.at + own * width, pivot = row[own];
        if (own % DIRECTIONS == RADIAL || !s->stuck.at[node])
            continue;
        int moves = pivot > 1e-12 * s->whole.at[own * width + own]; /* without motion there is no force */
        double slip = s->slide.at[own] + (own % DIRECTIONS == TANGENTIAL) * turned * s->radius.at[node];
        for (int64_t j = 0; j < n; j++)
            row[j] = moves && j != own ? -row[j] / pivot : 0.0;
        s->slide.at[own] = moves ? -slip / pivot : 0.0;
        for (int64_t i = 0; i < n; i++) {
            double *other = s->compliance.at + i * width, share = other[own];
            if (i == own || share == 0.0)
                continue;
            other[own] = 0.0;
            for (int64_t j = 0; j < n; j++)
                other[j] += share * row[j];
            if (i % DIRECTIONS == RADIAL)
                s->gap.at[i / DIRECTIONS] -= share * s->slide.at[own];
            else
                s->slide.at[i] += share * s->slide.at[own];
        }
    }
}

/* Compute the parts across the directions of sliding of the slips of few nodes, for the forces that
 * follow from these directions, and in `miss` their angles and slips against the directions. Returns the
 * largest angle, INFINITY without normal forces. */
static double slip_across(const March *m, int64_t size, const int64_t *node, int64_t few, double *across)
{
    NodeScratch *s = &m->scratch->nodes;
    Candidates nodes = {size, s->gap.at, s->held.at, s->multiplier.at, &s->response};
    double largest = 0.0, least = 1e-4 * m->stage.numbers->gap_scale; /* slip that has a direction */
    respond(m, size, NULL);
    if (!(!m->stage.coating && solve_normal(m, &nodes)) && !solve_pieces(m, size))
        return INFINITY;
    set_forces(m, size);
    for (int64_t k = 0; k < few; k++) {
        double slip[2], *d = s->direction.at + 2 * node[k], *miss = s->miss.at + 2 * node[k];
        slip_of(m, node[k], size, slip);
        across[k] = d[0] * slip[1] - d[1] * slip[0];
        if (!(s->multiplier.at[node[k]] > 0.0))
            across[k] = slip[0] = slip[1] = 0.0;
        double along = d[0] * slip[0] + d[1] * slip[1];
        miss[0] = atan2(across[k], along + least);
        miss[1] = smaller(0.0, along / least); /* friction would drive the node: it sticks */
        largest = larger(largest, fabs(miss[0]));
    }
    return largest;
}

/* Turn a direction by an angle. */
static void turn_by(double *direction, double angle)
{
    double x = direction[0], y = direction[1];
    direction[0] = cos(angle) * x - sin(angle) * y;
    direction[1] = sin(angle) * x + cos(angle) * y;
}

/* Solve the equations of few nodes, in place; `system` has the matrix and the right-hand side by row.
 * Returns 0 if they are singular. */
static int eliminate_few(double *system, int64_t size)
{
    int64_t width = size + 1;
    for (int64_t k = 0; k < size; k++) {
        double pivot = system[k * width + k];
        if (!(fabs(pivot) > 1e-300))
            return 0;
        for (int64_t i = 0; i < size; i++)
            for (int64_t j = size; i != k && j >= k; j--)
                system[i * width + j] -= system[i * width + k] / pivot * system[k * width + j];
    }
    for (int64_t k = 0; k < size; k++)
        system[k * width + size] /= system[k * width + k];
    return 1;
}

/* Solve the directions of sliding of few nodes by Newton's method with differences; a step after which
 * the angles are larger is halved. Returns the largest angle that remains. */
static double solve_directions(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t node[FEW], few = 0;
    double across[FEW], other[FEW], step[FEW], system[FEW * (FEW + 1)];
    double largest = INFINITY, last = INFINITY, share = 1.0;
    for (int64_t i = 0; i < size; i++)
        if (!s->stuck.at[i]) {
            if (few == FEW)
                return PI;
            node[few++] = i;
        }
    for (int trial = 0; trial < 2 * MOST_NEWTON; trial++) {
        largest = slip_across(m, size, node, few, across);
        if (!(largest > SAME_DIRECTION))
            return largest;
        if (largest > last && share > LEAST_SHARE) {
            share *= 0.5;
            for (int64_t k = 0; k < few; k++)
                turn_by(s->direction.at + 2 * node[k], -share * step[k]);
            continue;
        }
        if (!(largest < INFINITY))
            return INFINITY;
        last = largest;
        share = 1.0;
        for (int64_t k = 0; k < few; k++) {
            double *d = s->direction.at + 2 * node[k], x = d[0], y = d[1], turn = 1e-6;
            turn_by(d, turn);
            if (!(slip_across(m, size, node, few, other) < INFINITY))
                return INFINITY;
            d[0] = x;
            d[1] = y;
            for (int64_t i = 0; i < few; i++)
                system[i * (few + 1) + k] = (other[i] - across[i]) / turn;
            if (!(s->multiplier.at[node[k]] > 0.0))
                system[k * (few + 1) + k] = 1.0;
            system[k * (few + 1) + few] = -across[k];
        }
        if (!eliminate_few(system, few))
            return INFINITY;
        for (int64_t k = 0; k < few; k++) {
            step[k] = system[k * (few + 1) + few];
            turn_by(s->direction.at + 2 * node[k], step[k]);
        }
    }
    return largest;
}

/* Set the tangential forces of the nodes that stick, and change the set where it is wrong: each node or
 * only the first. Returns the number of changes. */
static int64_t change_stuck(const March *m, int64_t size, int solved, int only_first)
{
    NodeScratch *s = &m->scratch->nodes;
    double friction = m->stage.numbers->friction;
    int64_t changes = 0;
    for (int64_t i = 0; i < size; i++) {
        double *force = s->group_force.at + DIRECTIONS * i, *miss = s->miss.at + 2 * i;
        double held = friction * s->multiplier.at[i];
        int wrong = s->multiplier.at[i] > 0.0
                    && (!solved || hypot(miss[0], miss[1]) > SAME_DIRECTION);
        if (s->stuck.at[i]) {
            for (int64_t k = DIRECTIONS * i + TANGENTIAL; k <= DIRECTIONS * i + AXIAL; k++)
                s->group_force.at[k] = s->slide.at[k]
                                       + dot(s->compliance.at + k * s->compliance.columns,
                                             s->group_force.at, DIRECTIONS * size);
            double tangential = hypot(force[TANGENTIAL], force[AXIAL]);
            wrong = tangential > held * (1.0 + SAME_DIRECTION);
            for (int k = 0; k < 2 && tangential > 0.0; k++) /* in which it slides, if it does */
                s->direction.at[2 * i + k] = -force[TANGENTIAL + k] / tangential;
        }
        if (wrong && (changes == 0 || !only_first))
            s->stuck.at[i] = !s->stuck.at[i];
        changes += wrong;
    }
    return changes;
}

/* Change the force of a node such that it is in equilibrium with those of the others. Returns the change
 * and raises `largest` to the normal force. */
static double relax_node(const March *m, int64_t i, int64_t size, double *largest)
{
    NodeScratch *s = &m->scratch->nodes;
    double *force = s->group_force.at + DIRECTIONS * i, slip[2], pull[2];
    int64_t width = s->compliance.columns;
    const double *row = s->compliance.at + DIRECTIONS * i * width, *own = row + DIRECTIONS * i;
    double gap = s->gap.at[i] - dot(row, s->group_force.at, DIRECTIONS * size);
    double normal = larger(0.0, -force[RADIAL] - gap / own[RADIAL]);
    double change = fabs(normal + force[RADIAL]), held = m->stage.numbers->friction * normal;
    force[RADIAL] = -normal;
    slip_of(m, i, size, slip);
    double a = own[TANGENTIAL * width + TANGENTIAL], b = own[AXIAL * width + AXIAL];
    double both = 0.5 * (own[TANGENTIAL * width + AXIAL] + own[AXIAL * width + TANGENTIAL]);
    double soft = 0.5 * (a + b) + hypot(0.5 * (a - b), both); /* largest flexibility along the wall */
    for (int k = 0; k < 2; k++)
        pull[k] = force[TANGENTIAL + k] - (soft > 0.0 ? slip[k] / soft : 0.0);
    double length = hypot(pull[0], pull[1]);
    for (int k = 0; k < 2; k++) {
        if (length > 0.0)
            s->direction.at[2 * i + k] = -pull[k] / length;
        if (length > held)
            pull[k] *= held / length;
        change = larger(change, fabs(pull[k] - force[TANGENTIAL + k]));
        force[TANGENTIAL + k] = pull[k];
    }
    *largest = larger(*largest, normal);
    s->multiplier.at[i] = normal;
    return change;
}

/* Compute the forces of a group node by node, by projected Gauss-Seidel iterations. Returns whether they
 * converge. */
static int relax_group(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    for (int64_t i = 0; i < DIRECTIONS * size; i++)
        s->group_force.at[i] = 0.0;
    for (int sweep = 0; sweep < RELAXED; sweep++) {
        double change = 0.0, largest = 0.0;
        for (int64_t i = 0; i < size; i++)
            change = larger(change, relax_node(m, i, size, &largest));
        if (change <= SETTLED * largest) {
            respond(m, size, NULL);
            return 1;
        }
        if (!(largest < INFINITY))
            return 0;
    }
    return 0;
}

/* Compute the forces of a group with nodes that stick. Returns whether a set of them was found. */
static int stick_group(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t length = DIRECTIONS * size, many = CHANGED_TOGETHER + 2 * size, few = 0, node[FEW];
    for (int64_t i = 0; i < length * s->compliance.columns; i++)
        s->whole.at[i] = s->compliance.at[i];
    for (int64_t i = 0; i < length; i++)
        s->whole_slide.at[i] = s->slide.at[i];
    for (int64_t i = 0; i < size; i++) {
        s->whole_gap.at[i] = s->gap.at[i];
        if (few < FEW && (size <= FEW || s->gap.at[i] < 0.0))
            node[few++] = i;
    }
    int64_t wrong = change_stuck(m, size, 0, 0);
    for (int64_t trial = 1; wrong > 0 && trial < many + MOST_SETS; trial++) {
        if (trial == many && !m->stage.coating && relax_group(m, size))
            return 1;
        for (int64_t k = 0; k < few && trial >= many; k++) {
            int64_t start = (trial - many) >> few;
            double *d = s->direction.at + 2 * node[k], angle = GOLDEN * (double)(start * (k + 1));
            s->stuck.at[node[k]] = !((trial - many) >> k & 1);
            if (start > 0) { /* otherwise against the force of the node when it stuck */
                d[0] = cos(angle);
                d[1] = sin(angle);
            }
            m->scratch->pieces.place.at[node[k]] = s->gap.at[node[k]];
        }
        eliminate_stuck(m, size);
        double change = trial < many ? slide_group(m, size) : PI;
        if (change > SAME_DIRECTION && change < INFINITY)
            change = solve_directions(m, size);
        int solved = change < INFINITY;
        wrong = change_stuck(m, size, solved, trial > CHANGED_TOGETHER) + !solved;
        for (int64_t i = 0; i < length * s->compliance.columns; i++)
            s->compliance.at[i] = s->whole.at[i];
        for (int64_t i = 0; i < length; i++)
            s->slide.at[i] = s->whole_slide.at[i];
        for (int64_t i = 0; i < size; i++)
            s->gap.at[i] = s->whole_gap.at[i];
    }
    return wrong == 0;
}

/* Compute the contact forces of a group in contact at the end of a step. Returns the change of the
 * directions of sliding in the last iteration, INFINITY without a solution. */
static double contact_forces(const March *m, int64_t size)
{
    int full = m->stage.rotor->full > 0.0;
    for (int64_t i = 0; full && i < size; i++)
        m->scratch->nodes.stuck.at[i] = 0;
    double change = slide_group(m, size);
    if (full && change > SAME_DIRECTION && m->stage.numbers->friction > 0.0 && stick_group(m, size))
        return 0.0;
    return change;
}

#endif
