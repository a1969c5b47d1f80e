/* Contact of nodes in three directions at the end of a step, in a rigid wall or a flexible casing.
 *
 * Displacements of the contact nodes are u = P q + C f. The modes follow central differences,
 *
 *     q_{n+1} = a q_n + b q_{n-1} + c (loads + P^T f).
 *
 * If the contact nodes have no mass, f is the contact force at step n, and C is the residual
 * flexibility. Otherwise f is the contact force at step n + 1, and C = P c P^T. In both cases the
 * contact forces at step n + 1 close the gaps by C only:
 *
 *     0 <= lambda  perp  g = g_free + W lambda >= 0,      W = C_rr + mu (C_rt d_t + C_ra d_a)
 *
 * with the direction of sliding (d_t, d_a) of each node. With full sliding it is the direction of
 * the slip velocity at the end of the step, which depends on the forces: a fixed point. Otherwise it
 * is that of the rotation, or that of the tangential motion in the last step.
 *
 * In a rigid wall each copy is solved separately. In a flexible casing all nodes that may touch are
 * solved together: the casing keeps its mass, and its response to forces within the step, H c H^T
 * with its displacements H under the nodes, is added to C.
 *
 * With massless nodes the work of a contact force in a step is its mean over the step times the
 * change of the displacement. The sum of the works is then exactly the change of
 *
 *     |v|^2 / 2 + q_n^T W^2 q_{n-1} / 2 + f_n^T C f_n / 2 + f_n^T P (q_n - q_{n-1}) / 2.
 */
#ifndef NODES_H
#define NODES_H

#include "compliance.h"
#include "gaps.h"
#include "joints.h"

/* Collect the state of the nodes of the list before their contact forces are computed. */
static void collect(const March *m, int64_t size)
{
    const Rotor *rotor = m->stage.rotor;
    const State *state = m->state;
    NodeScratch *s = &m->scratch->nodes;
    int full = rotor->full > 0.0;
    for (int64_t i = 0; i < size; i++) {
        int64_t n = s->list.at[i];
        s->gap.at[i] = m->scratch->fields.free_gap.at[n];
        s->before.at[i] = state->force.at[DIRECTIONS * n + RADIAL];
        s->direction.at[2 * i] = full ? state->direction.at[2 * n] : s->sign.at[n];
        s->direction.at[2 * i + 1] = full ? state->direction.at[2 * n + 1] : 0.0;
    }
    for (int64_t i = 0; full && i < size; i++)
        s->radius.at[i] = rotor->radius.at[s->list.at[i]];
}

/* Add the response of the bodies to the forces of the nodes of the list, and compute their works. */
static void push_bodies(March *m, int64_t size, const double *ratio)
{
    const Rotor *rotor = m->stage.rotor;
    NodeScratch *s = &m->scratch->nodes;
    double *work = m->scratch->contact.work.at, twice[2];
    work[0] = work[1] = 0.0;
    if (m->stage.casing->modes > 0)
        push_casing(m, size, ratio, s->force.at);
    if (rotor->massless > 0.0)
        return;
    if (m->stage.foreshortening)
        m->drawn = push_along(m->stage.foreshortening, s->list.at, size, s->multiplier.at,
                              rotor->body.c.at, m->x.new, &m->scratch->bending);
    if (rotor->half == 0) {
        push_copies(m, s->force.at, m->stage.gyroscopic, m->x.new);
        return;
    }
    push_blades(m, size, ratio, s->force.at, m->x.old, m->x.new, twice);
    for (int k = 0; k < 2 && rotor->own.layers == DIRECTIONS; k++)
        work[k] += 0.5 * twice[k];
}

/* Distribute the forces and directions of the group to its nodes, and compute the response of the
 * bodies. */
static void distribute(March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    double friction = m->stage.numbers->friction, ratio = friction * s->direction.at[0];
    int full = m->stage.rotor->full > 0.0, mixed = full;
    for (int64_t i = 0; i < size; i++) {
        int64_t n = s->list.at[i];
        for (int64_t k = 0; k < DIRECTIONS; k++)
            s->force.at[DIRECTIONS * n + k] = s->group_force.at[DIRECTIONS * i + k];
        for (int64_t k = 0; k < 2 && full; k++)
            m->state->direction.at[2 * n + k] = s->direction.at[2 * i + k];
        mixed |= s->direction.at[2 * i] != s->direction.at[0];
    }
    push_bodies(m, size, mixed ? NULL : &ratio);
}

/* Take the response of the bodies to the forces of the nodes of the list back. */
static void take_back(March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    for (int64_t i = 0; i < size; i++) {
        s->multiplier.at[i] *= -1.0;
        for (int64_t k = 0; k < DIRECTIONS; k++)
            s->force.at[DIRECTIONS * s->list.at[i] + k] *= -1.0;
    }
    push_bodies(m, size, NULL);
}

/* Compute the gaps of all nodes of some copies with contact, and add the nodes inside the wall to the
 * list. Returns the number of nodes that were added, or -1 if a displacement is above the limit or not
 * a number. */
static int64_t join_nodes(const March *m, int64_t first, int64_t last, int64_t size,
                          const double *recess)
{
    const Rotor *rotor = m->stage.rotor;
    const Casing *casing = m->stage.casing;
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    RodScratch *r = &m->scratch->rods;
    int64_t count = rotor->compliance.rows / DIRECTIONS, joined = 0;
    double slope, reach = 0.0, *radial = f->moved.at, *opened = f->other.at;
    for (int64_t n = first * count; n < last * count; n++)
        radial[n] = f->radial.at[n];
    if (rotor->massless > 0.0)
        add_flexible(rotor, RADIAL, &s->wanted, s->force.at, 1.0, radial);
    else if (rotor->own.layers == DIRECTIONS && !rotor->crosses.at[RADIAL])
        blade_values(rotor, f->sums.at, radial); /* from `push_blades` */
    else
        node_field(rotor, RADIAL, m->x.new, &s->wanted, f, radial);
    if (casing->modes == 0) {
        for (int64_t n = first * count; n < last * count; n++)
            f->gap.at[n] = f->free_gap.at[n] - (radial[n] - f->radial.at[n]);
    } else if (!find_gaps(m, radial, recess, f->gap.at))
        return -1;
    if (m->stage.foreshortening) {
        open_further(&m->scratch->bending, s, size, opened);
        for (int64_t n = 0; n < f->element.size; n++)
            f->gap.at[n] += casing->modes > 0 ? opened[n] : opened[n] - m->scratch->bending.opened.at[n];
    }
    if (m->stage.coating)
        reach = r->reach;
    for (int64_t n = first * count; n < last * count; n++) {
        double gap = f->gap.at[n];
        if (s->listed.at[n])
            continue;
        int inside = gap < -LEAST_GAP * m->stage.numbers->gap_scale;
        if (m->stage.coating && gap < reach) {
            if (!r->near.at[n])
                place_rods(m, n);
            inside |= press_node(m, n, gap, &slope) > 0.0;
        }
        if (inside) {
            s->listed.at[n] = 1;
            s->list.at[size + joined++] = n;
        }
    }
    return joined;
}

/* Note the complementarity residual of a group, and whether its contact problem was solved; `lack` is
 * what `contact_forces` returned. */
static void note_residual(const March *m, int64_t size, double lack)
{
    const NodeScratch *s = &m->scratch->nodes;
    const FieldScratch *f = &m->scratch->fields;
    const double *place = m->scratch->pieces.place.at;
    double worst = 0.0, scale = m->stage.numbers->gap_scale;
    for (int64_t i = 0; i < size; i++) {
        int64_t n = s->list.at[i];
        double gap = f->gap.at[n], closed = s->multiplier.at[i]; /* gap that the metal closes */
        closed *= fabs(s->response.at[i * s->response.columns + i]);
        if (m->stage.coating)
            closed = -smaller(place[i], 0.0);
        scale = larger(scale, fabs(f->free_gap.at[n]));
        worst = larger(worst, closed > 0.0 ? fabs(smaller(gap, closed)) : -gap);
    }
    double *residual = m->state->counts.at + RESIDUAL;
    *residual = larger(*residual, worst / scale);
    if (!(lack > SAME_DIRECTION))
        return;
    double largest = 0.0, wrong = 0.0, slope;
    for (int64_t i = 0; i < size; i++) {
        double gap = f->gap.at[s->list.at[i]];
        largest = larger(largest, s->multiplier.at[i]);
        if (gap > 0.0)
            wrong = larger(wrong, fabs(force_at(m, i, gap, &slope) - s->multiplier.at[i]));
    }
    m->state->counts.at[UNSOLVED] += 1.0;
    wrong = largest > 0.0 ? wrong / largest : 0.0;
    *residual = larger(*residual, lack < INFINITY ? lack : wrong);
}

/* Compute the contact of some copies that are solved together. Returns the number of nodes of the
 * group, which is 0 if no node touches the wall, or -1 if a displacement is above the limit. */
static int64_t touch_copies(March *m, int64_t first, int64_t last, const double *recess)
{
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    int64_t count = m->stage.rotor->compliance.rows / DIRECTIONS, size = 0, touching = 0;
    for (int64_t n = first * count; n < last * count; n++) {
        int touches = f->free_gap.at[n] < 0.0
                      || (m->stage.coating && m->scratch->rods.near.at[n] == 2);
        s->listed.at[n] =
            touches || (m->state->force.at[DIRECTIONS * n + RADIAL] < 0.0 && at_wall(m, n));
        touching += touches;
        if (s->listed.at[n])
            s->list.at[size++] = n;
    }
    if (touching == 0)
        return 0;
    double lack = 0.0;
    for (int64_t joined = size; joined > 0; size += joined) {
        if (joined < size)
            take_back(m, size - joined);
        want_listed(m, size);
        if (m->stage.rotor->full > 0.0)
            find_slip(m, size);
        respond_group(m, size);
        collect(m, size);
        lack = contact_forces(m, size);
        distribute(m, size);
        joined = join_nodes(m, first, last, size, recess);
        if (joined < 0)
            return -1;
    }
    note_residual(m, size, lack);
    return size;
}

/* Compute the contact of nodes inside the wall. Returns whether x_{n+1} is within the displacement limit;
 * `touching` gets the number of nodes in contact or near it. */
static int touch_wall(March *m, double later, const double *recess, int64_t *touching)
{
    const Rotor *rotor = m->stage.rotor;
    const Casing *casing = m->stage.casing;
    FieldScratch *f = &m->scratch->fields;
    int64_t together = casing->modes > 0 ? rotor->copies : 1, count = f->element.size;
    int touches = 0;
    *touching = 0;
    if (m->stage.coating)
        touches = find_rods(m, later);
    for (int64_t n = 0; n < count; n++)
        touches |= f->free_gap.at[n] < 0.0;
    if (!touches)
        return 1;
    m->pushed = 1;
    m->scratch->contact.work.at[0] = m->scratch->contact.work.at[1] = 0.0;
    for (int64_t n = 0; n < count && casing->modes == 0; n++)
        f->gap.at[n] = f->free_gap.at[n];
    find_signs(m);
    for (int64_t first = 0; first < rotor->copies; first += together) {
        int64_t size = touch_copies(m, first, first + together, recess);
        if (size < 0)
            return 0;
        *touching += size;
    }
    return 1;
}

/* Compute the contact at the wall and in the joints, in turn until the forces at the wall do not change
 * relative to all forces: large forces of joints are rounded, and with them small ones at the wall. The
 * result is that of `touch_wall`. */
static int touch_all(March *m, int64_t step, const double *recess, int64_t *touching)
{
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    JointScratch *j = &m->scratch->joints;
    double later = (double)(step + 1) * m->stage.numbers->time_step;
    double change = 0.0, largest = 0.0;
    int64_t forces = j->wall.size, turn = 0;
    int solved = 1;
    free_pairs(m, step);
    *touching = 0;
    do {
        wall_pairs(m, *touching > 0);
        solved = solve_joints(m);
        push_nodes(m);
        for (int64_t i = 0; i < forces; i++)
            j->wall.at[i] = s->force.at[i];
        if (*touching > 0 && m->stage.casing->modes > 0)
            take_back(m, *touching);
        for (int64_t i = 0; i < forces; i++)
            s->force.at[i] = 0.0;
        if (!touch_wall(m, later, recess, touching))
            return 0;
        change = largest = 0.0;
        for (int64_t i = 0; i < forces; i++) {
            change = larger(change, fabs(s->force.at[i] - j->wall.at[i]));
            largest = larger(largest, fabs(s->force.at[i]));
        }
        for (int64_t i = 0; i < j->force.size; i++)
            largest = larger(largest, fabs(j->force.at[i]));
    } while (change > SAME_FORCES * largest && ++turn < TURNS);
    for (int64_t i = 0; i < forces; i++)
        s->force.at[i] += j->on_nodes.at[i];
    if (!solved || turn == TURNS)
        m->state->counts.at[UNSOLVED] += 1.0;
    m->pushed = 1;
    double limit = m->stage.numbers->displacement_limit;
    for (int64_t i = 0; i < j->body.size; i++)
        if (!(fabs(j->body.at[i]) <= limit))
            return 0;
    return 1;
}

/* Compute x_{n+1} with contact of the nodes. Returns whether x_{n+1} is within the displacement
 * limit; `touching` gets the number of nodes in contact or near it. */
static int solve_nodes(March *m, int64_t step, int64_t *touching)
{
    const Rotor *rotor = m->stage.rotor;
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    BendScratch *bending = &m->scratch->bending;
    double later = (double)(step + 1) * m->stage.numbers->time_step;
    *touching = 0;
    if (f->element.size == 0) {
        m->pushed = 0;
        return 1;
    }
    place_nodes(m);
    const double *recess = recess_at(rotor, m->stage.closure, later, f);
    if (!find_free_gaps(m, recess))
        return 0;
    if (m->stage.foreshortening) {
        if (bend_tips(m->stage.foreshortening, rotor, m->state, f->free_gap.at, step + 1, m->x, f,
                      bending))
            s->known.at[0] = -1;
        open_gaps(bending, m->x.new, f->free_gap.at);
    }
    if (m->pushed)
        for (int64_t i = 0; i < s->force.rows * s->force.columns; i++)
            s->force.at[i] = 0.0;
    m->pushed = m->drawn = 0;
    if (m->stage.joints)
        return touch_all(m, step, recess, touching);
    return touch_wall(m, later, recess, touching);
}

/* Add the works of the contact forces on the rotor in the step, unless `push_blades` computes them. */
static void contact_works(const March *m)
{
    const Rotor *rotor = m->stage.rotor;
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    const double *before = m->state->force.at, *force = s->force.at;
    double *work = m->state->work.at, *moved = f->other.at;
    int massless = rotor->massless > 0.0;
    int directions = rotor->axial > 0.0 ? DIRECTIONS : 2;
    int64_t size = list_pushed(m, force, massless ? before : NULL);
    if (size == 0)
        return;
    store_change(m->x, massless ? m->x.now : m->x.old, f->change.at);
    for (int direction = 0; direction < directions; direction++) {
        listed_field(m, direction, size, f->change.at, moved);
        if (massless) {
            add_flexible_listed(m, direction, size, force, 1.0, moved);
            add_flexible_listed(m, direction, size, before, -1.0, moved);
        }
        double sum = work_of(m, size, direction, force, moved);
        if (massless)
            sum += work_of(m, size, direction, before, moved);
        work[direction == RADIAL ? NORMAL : FRICTION] += 0.5 * sum;
    }
}

/* Return the work of the contact forces along the gradients of tips that draw back. */
static double work_along(const March *m)
{
    const double *force = m->scratch->bending.force.at;
    int64_t entries = m->x.entries;
    return 0.5 * (dot(force, m->x.new, entries) - dot(force, m->x.old, entries));
}

/* Add the impulses and works of an accepted step to the state, and wear the coating. `gap` and
 * `before` are the gaps after this step and one step before it. */
static void account_nodes(March *m, int touching, const double *gap, const double *before)
{
    State *state = m->state;
    NodeScratch *s = &m->scratch->nodes;
    double dt = m->stage.numbers->time_step;
    int64_t contacts = 0;
    if (m->stage.coating)
        state->coating.at[STORED] = 0.0;
    if (!m->pushed && !m->held)
        return;
    if (m->stage.rotor->own.layers != DIRECTIONS || m->stage.rotor->massless > 0.0)
        contact_works(m);
    if (m->drawn)
        state->work.at[NORMAL] += work_along(m);
    if (m->stage.coating && touching)
        wear_rods(m, gap);
    for (int64_t n = 0; n < state->touched.size; n++) {
        const double *force = s->force.at + DIRECTIONS * n;
        if (!(force[RADIAL] < 0.0) || !at_wall(m, n))
            continue;
        contacts++;
        state->touched.at[n] += 1.0;
        state->impulse.at[n] -= force[RADIAL] * dt;
        state->drag.at[n] -= force[TANGENTIAL] * dt;
        state->axial.at[n] += force[AXIAL] * dt;
        double metal = -force[RADIAL];
        if (m->stage.coating)
            metal -= m->scratch->rods.push.at[n];
        if (!(m->stage.rotor->massless > 0.0)) /* without mass, nothing has to be stopped */
            state->work.at[CLOSING] += 0.5 * metal * (gap[n] - before[n]);
    }
    for (int64_t i = 0; i < state->force.rows * state->force.columns; i++)
        state->force.at[i] = s->force.at[i];
    m->held = m->pushed;
    state->counts.at[STEP_CONTACTS] = (double)contacts;
    if (!touching)
        return;
    state->work.at[NORMAL] += m->scratch->contact.work.at[0];
    state->work.at[FRICTION] += m->scratch->contact.work.at[1];
    state->counts.at[CONTACT_STEPS] += 1.0;
}

/* Return the energy of the residual flexibility of massless nodes half a step before step n. */
static double flexible_energy(const March *m)
{
    FieldScratch *f = &m->scratch->fields;
    const double *force = m->state->force.at;
    double energy = m->stage.joints ? joint_energy(m) : 0.0, *moved = f->other.at;
    int64_t size = m->stage.rotor->massless > 0.0 ? list_pushed(m, force, NULL) : 0;
    if (size == 0)
        return energy;
    store_change((Motion){.new = m->x.now, .entries = m->x.entries}, m->x.old, f->change.at);
    for (int direction = 0; direction < DIRECTIONS; direction++) {
        listed_field(m, direction, size, f->change.at, moved);
        add_flexible_listed(m, direction, size, force, 1.0, moved);
        energy += 0.5 * work_of(m, size, direction, force, moved);
    }
    return energy;
}

#endif
