/* Contact of nodes in three directions at the end of a step, in a rigid wall or a flexible casing.
 *
 * Displacements of the contact nodes are u = P q + C f. The modes follow central differences,
 *
 *     q_{n+1} = a q_n + b q_{n-1} + c (loads + P^T f).
 *
 * If the contact nodes have no mass, f is the contact force at step n, and C is the residual
 * flexibility. Otherwise f is the contact force at step n + 1, as for tips of beams (`march.c`), and
 * C = P c P^T. In both cases the contact forces at step n + 1 close the gaps by C only:
 *
 *     0 <= lambda  perp  g = g_free + W lambda >= 0,      W = C_rr + mu (C_rt d_t + C_ra d_a)
 *
 * with the direction of sliding (d_t, d_a) of each node. With full sliding it is the direction of
 * the slip velocity at the end of the step, which depends on the forces: a fixed point.
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

#include "sticking.h"


/* Return the modal coordinates of a copy in an array of all modes of the rotor. */
static inline int64_t first_mode(const March *m, int64_t copy)
{
    return copy * (m->x.entries / m->stage.nodes->compliance.layers);
}

/* Return whether any node of a copy has a contact force. */
static int is_pushed(const Nodes *nodes, const double *force, int64_t copy)
{
    int64_t width = nodes->contact.rows;
    for (int64_t i = copy * width; i < (copy + 1) * width; i += DIRECTIONS)
        if (force[i] < 0.0)
            return 1;
    return 0;
}

/* Compute the modal forces on a copy due to contact forces on its nodes. */
static void modal_forces(const March *m, int64_t copy, const double *force)
{
    const Nodes *nodes = m->stage.nodes;
    int64_t width = nodes->contact.rows, modes = nodes->contact.columns;
    double *modal = m->scratch->nodes.modal.at;
    for (int64_t i = 0; i < modes; i++)
        modal[i] = 0.0;
    add_rows(force + copy * width, nodes->contact.at, width, modes, modal);
}

/* Add the response to the contact forces on massless nodes at step n. */
static void add_node_forces(const March *m)
{
    const Nodes *nodes = m->stage.nodes;
    const double *modal = m->scratch->nodes.modal.at, *c = m->stage.rotor->body.c.at;
    for (int64_t copy = 0; copy < nodes->compliance.layers; copy++) {
        if (!is_pushed(nodes, m->state->force.at, copy))
            continue;
        modal_forces(m, copy, m->state->force.at);
        int64_t first = first_mode(m, copy);
        for (int64_t i = 0; i < nodes->contact.columns; i++)
            m->x.new[first + i] += c[first + i] * modal[i];
    }
}

/* Add the response of the modes of a copy to the contact forces at step n + 1. */
static void push_copy(const March *m, int64_t copy)
{
    const Gyroscopic *g = m->stage.gyroscopic;
    const double *modal = m->scratch->nodes.modal.at, *c = m->stage.rotor->body.c.at;
    int64_t modes = m->stage.nodes->contact.columns, first = first_mode(m, copy);
    double *new = m->x.new + first;
    modal_forces(m, copy, m->scratch->nodes.force.at);
    if (g)
        add_full(&g->inverse, copy, modes, modal, new, new);
    else
        for (int64_t i = 0; i < modes; i++)
            new[i] += c[first + i] * modal[i];
}

/* Compute the displacements of the nodes of a copy due to a change of its modal coordinates. */
static void move_nodes(const March *m, int64_t copy, const double *from, double factor, double *out)
{
    const Nodes *nodes = m->stage.nodes;
    int64_t modes = nodes->contact.columns, width = nodes->contact.rows;
    int64_t first = first_mode(m, copy);
    double *change = m->scratch->nodes.modal.at;
    for (int64_t i = 0; i < modes; i++)
        change[i] = factor * (m->x.new[first + i] - from[first + i]);
    for (int64_t i = 0; i < width; i++)
        out[i] = 0.0;
    add_rows(change, nodes->columns.at, modes, width, out);
}

/* Find the element under each node and its Hermite weights at x_{n+1}. The angle of a node follows
 * its tangential displacement if that of tips does; contact forces are those of step n. */
static void place_nodes(const March *m, double turned)
{
    const Nodes *nodes = m->stage.nodes;
    const Casing *casing = m->stage.casing;
    FieldScratch *f = &m->scratch->fields;
    double *moved = m->scratch->nodes.moved.at, elements = (double)casing->nodes / (2.0 * PI);
    int64_t count = nodes->radius.size, width = nodes->contact.rows;
    const double *places = m->stage.rotor->position.at;
    for (int64_t n = 0; n < f->element.size; n++)
        f->at.at[n] = places[n];
    for (int64_t copy = 0; copy < nodes->compliance.layers; copy++) {
        if (m->stage.numbers->elements_per_metre == 0.0)
            break;
        for (int64_t i = 0; i < width; i++)
            moved[i] = 0.0;
        add_rows(m->x.new + first_mode(m, copy), nodes->columns.at, nodes->contact.columns, width,
                 moved);
        if (nodes->massless > 0.0)
            add_rows(m->state->force.at + copy * width,
                     nodes->compliance.at + copy * width * width, width, width, moved);
        for (int64_t i = 0; i < count; i++)
            f->at.at[copy * count + i] +=
                elements * moved[DIRECTIONS * i + TANGENTIAL] / nodes->radius.at[i];
    }
    hermite_weights(f->at.at, turned, (double)casing->nodes, casing->element_length,
                    f->element.size, f->hermite.columns, f->element.at, f->hermite.at);
}

/* Compute the gaps without contact forces of this step. Returns whether displacements are within the
 * limit. */
static int find_node_gaps(const March *m, const double *recess)
{
    const Nodes *nodes = m->stage.nodes;
    const Casing *casing = m->stage.casing;
    FieldScratch *f = &m->scratch->fields;
    int64_t count = nodes->radius.size, within = 1, tips = f->element.size;
    for (int64_t n = 0; n < tips; n++)
        f->radial.at[n] = 0.0;
    for (int64_t copy = 0; copy < nodes->compliance.layers; copy++)
        add_rows(m->x.new + first_mode(m, copy), nodes->normal.at, nodes->contact.columns, count,
                 f->radial.at + copy * count);
    column_sums(&casing->radial.weight, m->y.new, casing->radial.half, f->value.at);
    column_sums(&casing->radial.slope_weight, m->y.new, casing->radial.slope_half, f->slope.at);
    if (!field_at_tips(nodal_field(casing, &casing->radial, f), f, f->free_gap.at))
        return 0;
    for (int64_t n = 0; n < tips; n++) {
        f->free_gap.at[n] *= m->stage.rotor->normal_part.at[n];
        f->free_gap.at[n] += recess[n] - f->radial.at[n];
        within &= fabs(f->radial.at[n]) <= m->stage.numbers->displacement_limit; /* 0 for NaN */
    }
    return (int)within;
}

/* Return whether the displacements of all nodes at x_{n+1}, in each direction, are within the
 * limit. */
static int nodes_keep_limit(const March *m)
{
    const Nodes *nodes = m->stage.nodes;
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = nodes->contact.rows;
    int within = 1;
    for (int64_t copy = 0; copy < nodes->compliance.layers; copy++) {
        for (int64_t i = 0; i < width; i++)
            s->moved.at[i] = 0.0;
        add_rows(m->x.new + first_mode(m, copy), nodes->columns.at, nodes->contact.columns, width,
                 s->moved.at);
        if (nodes->massless > 0.0 && is_pushed(nodes, s->force.at, copy))
            add_rows(s->force.at + copy * width, nodes->compliance.at + copy * width * width, width,
                     width, s->moved.at);
        for (int64_t i = 0; i < width; i++)
            within &= fabs(s->moved.at[i]) <= m->stage.numbers->displacement_limit;
    }
    return within;
}

/* Compute the displacements of the nodes of a copy in the step, relative to those of the last contact
 * forces and without new ones. */
static void slip_nodes(const March *m, int64_t copy)
{
    const Nodes *nodes = m->stage.nodes;
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = nodes->contact.rows;
    double *slip = s->slip.at + copy * width;
    move_nodes(m, copy, m->x.now, 1.0, slip);
    if (!(nodes->massless > 0.0) || !is_pushed(nodes, m->state->force.at, copy))
        return;
    for (int64_t i = 0; i < width; i++)
        s->further.at[i] = 0.0;
    add_rows(m->state->force.at + copy * width, nodes->compliance.at + copy * width * width, width,
             width, s->further.at);
    for (int64_t i = 0; i < width; i++)
        slip[i] -= s->further.at[i];
}

/* Compute the tangential displacement of a flexible casing under each node in the step. */
static void casing_slip(const March *m)
{
    const Casing *casing = m->stage.casing;
    const NodalField *field = &casing->tangential;
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    if (casing->modes == 0)
        return;
    for (int64_t i = 0; i < s->change.size; i++)
        s->change.at[i] = m->y.new[i] - m->y.now[i];
    column_sums(&field->weight, s->change.at, field->half, f->value.at);
    column_sums(&field->slope_weight, s->change.at, field->slope_half, f->slope.at);
    field_at_tips(nodal_field(casing, field, f), f, s->along.at);
}

/* Add the compliance of the casing between two nodes to the radial and tangential entries of a
 * block, and of the block of the reverse direction. */
static void add_casing(const March *m, int64_t one, int64_t two, double *block, double *back,
                       int64_t stride)
{
    const FieldScratch *f = &m->scratch->fields;
    const Matrix *response = &m->stage.nodes->response;
    int64_t width = f->hermite.columns, columns = response->columns;
    const double *row = response->at + 4 * f->element.at[one] * columns + 4 * f->element.at[two];
    const double *from = f->hermite.at + one, *to = f->hermite.at + two;
    Half near[2] = {half_splat(0.0), half_splat(0.0)}, far[2] = {near[0], near[0]};
    for (int64_t p = 0; p < 8; p++, row += columns) { /* w, w', u, u' of two casing nodes */
        int64_t kind = p / 2 % 2, weight = p % 2 + 2 * (p / 4);
        Half factor = half_splat(from[weight * width]);
        near[kind] = half_muladd(half_load(row), factor, near[kind]);
        far[kind] = half_muladd(half_load(row + HALF), factor, far[kind]);
    }
    for (int64_t kind = 0; kind < 2; kind++) {
        double sums[2][HALF], by[2];
        half_store(sums[0], near[kind]);
        half_store(sums[1], far[kind]);
        for (int64_t l = 0; l < 2; l++)
            by[l] = (sums[0][2 * l] * to[0] + sums[0][2 * l + 1] * to[width])
                    + (sums[1][2 * l] * to[2 * width] + sums[1][2 * l + 1] * to[3 * width]);
        for (int64_t l = 0; l < 2; l++) {
            block[kind * stride + l] += by[l];
            if (back != block) /* the response of the casing is symmetric */
                back[l * stride + kind] += by[l];
        }
    }
}

/* Compute the compliance of the nodes from number `from` of the list on with all nodes of the list.
 */
static void add_compliance(const March *m, int64_t from, int64_t size)
{
    const Nodes *nodes = m->stage.nodes;
    NodeScratch *s = &m->scratch->nodes;
    int64_t count = nodes->radius.size, width = nodes->contact.rows, wide = s->compliance.columns;
    for (int64_t i = from; i < size; i++)
        for (int64_t j = 0; j <= i; j++) {
            int64_t n = s->list.at[i], other = s->list.at[j], copy = n / count;
            double *to = s->compliance.at + DIRECTIONS * (i * wide + j);
            double *back = s->compliance.at + DIRECTIONS * (j * wide + i);
            const double *own = nodes->compliance.at + copy * width * width;
            const double *there = own + DIRECTIONS * (n % count * width + other % count);
            const double *here = own + DIRECTIONS * (other % count * width + n % count);
            int same = copy == other / count;
            for (int64_t k = 0; k < DIRECTIONS; k++) /* Coriolis forces: not symmetric */
                for (int64_t l = 0; l < DIRECTIONS; l++) {
                    to[k * wide + l] = same ? there[k * width + l] : 0.0;
                    back[k * wide + l] = same ? here[k * width + l] : 0.0;
                }
            if (nodes->response.rows > 0)
                add_casing(m, n, other, to, back, wide);
        }
}

/* Collect the state of the nodes of the list before their contact forces are computed. */
static void collect(const March *m, int64_t size)
{
    const Nodes *nodes = m->stage.nodes;
    const State *state = m->state;
    NodeScratch *s = &m->scratch->nodes;
    double speed = m->rotation.speed;
    for (int64_t i = 0; i < size; i++) {
        int64_t n = s->list.at[i];
        s->radius.at[i] = nodes->radius.at[n % nodes->radius.size];
        s->gap.at[i] = m->scratch->fields.free_gap.at[n];
        for (int64_t k = 0; k < 2; k++)
            s->direction.at[2 * i + k] = state->direction.at[2 * n + k];
        if (!(nodes->full > 0.0)) /* friction is opposite to the rotation */
            s->direction.at[2 * i] = (speed > 0.0) - (speed < 0.0);
        for (int64_t k = 0; k < DIRECTIONS; k++) {
            s->before.at[DIRECTIONS * i + k] = state->force.at[DIRECTIONS * n + k];
            s->slide.at[DIRECTIONS * i + k] = s->slip.at[DIRECTIONS * n + k];
        }
        if (nodes->response.rows > 0)
            s->slide.at[DIRECTIONS * i + TANGENTIAL] -= s->along.at[n];
    }
}

/* Distribute the forces and directions of the group to its nodes, and compute the response of the
 * casing. */
static void distribute(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    ContactScratch *c = &m->scratch->contact;
    int64_t active = 0;
    for (int64_t i = 0; i < size; i++) {
        int64_t n = s->list.at[i];
        for (int64_t k = 0; k < DIRECTIONS; k++)
            s->force.at[DIRECTIONS * n + k] = s->group_force.at[DIRECTIONS * i + k];
        for (int64_t k = 0; k < 2; k++)
            m->state->direction.at[2 * n + k] = s->direction.at[2 * i + k];
        c->multiplier.at[n] = -s->group_force.at[DIRECTIONS * i + RADIAL];
        c->sign.at[n] = s->direction.at[2 * i];
        if (c->multiplier.at[n] > 0.0)
            c->active.at[active++] = n;
    }
    if (m->stage.nodes->response.rows == 0)
        return;
    double ratio;
    for (int64_t i = 0; i < m->y.entries; i++)
        m->y.new[i] = s->free.at[i];
    int mixed = tip_forces(active, m->stage.numbers->friction, m->stage.casing->nodes,
                           &m->scratch->fields, c, &ratio);
    c->work.at[0] = c->work.at[1] = 0.0;
    correct_casing(m->stage.casing, active, mixed, ratio, m->y, &m->scratch->fields, c);
}

/* Compute the gaps of all nodes of some copies with contact, and add the nodes inside the wall to the
 * list. Returns the number of nodes that were added, or -1 if a displacement is not a number. */
static int64_t join_nodes(const March *m, int64_t first, int64_t last, int64_t size, double closed,
                          double turned, const double *recess)
{
    const Nodes *nodes = m->stage.nodes;
    const Casing *casing = m->stage.casing;
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    RodScratch *r = &m->scratch->rods;
    int64_t count = nodes->radius.size, width = nodes->contact.rows, joined = 0;
    const Matrix *nodal = &casing->radial.start;
    double slope, reach = 0.0;
    if (casing->modes > 0) {
        nodal = nodal_field(casing, &casing->radial, f);
        if (!field_at_tips(nodal, f, f->gap.at))
            return -1;
    }
    if (m->stage.node_coating)
        reach = reach_of_rods(m, nodal);
    for (int64_t copy = first; copy < last; copy++) {
        int pushed = is_pushed(nodes, s->force.at, copy);
        for (int64_t i = 0; i < count; i++) {
            int64_t n = copy * count + i;
            double gap = f->free_gap.at[n];
            if (casing->modes > 0)
                gap = f->gap.at[n] + (recess[n] - f->radial.at[n]);
            const double *row = nodes->compliance.at + (copy * width + DIRECTIONS * i) * width;
            for (int64_t k = 0; pushed && k < width; k++)
                gap -= row[k] * s->force.at[copy * width + k];
            f->gap.at[n] = gap;
            if (s->listed.at[n])
                continue;
            int inside = gap < -LEAST_GAP * m->stage.numbers->gap_scale;
            if (m->stage.node_coating && gap < reach) {
                if (!r->near.at[n])
                    place_rods(m, nodal, n, closed, turned);
                inside |= press_node(m, n, gap, &slope, NULL) > 0.0;
            }
            if (inside) {
                s->listed.at[n] = 1;
                s->list.at[size + joined++] = n;
            }
        }
    }
    return joined;
}

/* Compute the contact of some copies that are solved together. Returns the number of nodes of the
 * group, which is 0 if no node touches the wall, or -1 if a displacement is not a number. */
static int64_t touch_copies(const March *m, int64_t first, int64_t last, double closed,
                            double turned, const double *recess)
{
    NodeScratch *s = &m->scratch->nodes;
    const FieldScratch *f = &m->scratch->fields;
    int64_t count = m->stage.nodes->radius.size, size = 0, touching = 0;
    for (int64_t n = first * count; n < last * count; n++) {
        int touches = f->free_gap.at[n] < 0.0
                      || (m->stage.node_coating && m->scratch->rods.near.at[n] == 2);
        s->listed.at[n] = touches || m->state->force.at[DIRECTIONS * n + RADIAL] < 0.0;
        touching += touches;
        if (s->listed.at[n])
            s->list.at[size++] = n;
    }
    for (int64_t i = 0; touching == 0 && i < size; i++)
        s->listed.at[s->list.at[i]] = 0;
    if (touching == 0)
        return 0;
    if (m->stage.nodes->full > 0.0) {
        for (int64_t copy = first; copy < last; copy++)
            slip_nodes(m, copy);
        casing_slip(m);
    }
    for (int64_t known = 0, joined = size; joined > 0; known = size - joined) {
        add_compliance(m, known, size);
        collect(m, size);
        contact_forces(m, size);
        distribute(m, size);
        joined = join_nodes(m, first, last, size, closed, turned, recess);
        if (joined < 0)
            return -1;
        size += joined;
    }
    return size;
}

/* Compute x_{n+1} with contact of the nodes. Returns whether x_{n+1} is within the displacement
 * limit; `touching` gets whether any node touches the wall. */
static int solve_nodes(March *m, int64_t step, int64_t *touching)
{
    const Nodes *nodes = m->stage.nodes;
    const Casing *casing = m->stage.casing;
    const Numbers *numbers = m->stage.numbers;
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    int64_t copies = nodes->compliance.layers, together = casing->modes > 0 ? copies : 1;
    double turned = m->rotation.elements, rate, closed = 0.0;
    double later = (double)(step + 1) * numbers->time_step;
    *touching = 0;
    place_nodes(m, turned);
    const double *recess = recess_at(m->stage.rotor, m->stage.closure, later, f);
    if (!find_node_gaps(m, recess))
        return 0;
    for (int64_t i = 0; i < s->force.rows * s->force.columns; i++)
        s->force.at[i] = 0.0;
    if (m->stage.node_coating) {
        closed = m->stage.closure ? closure_at(m->stage.closure, later, &rate) : 0.0;
        find_rods(m, casing->modes > 0 ? &f->nodal : &casing->radial.start, closed, turned);
    }
    for (int64_t i = 0; i < s->free.size; i++)
        s->free.at[i] = m->y.new[i];
    m->scratch->contact.work.at[0] = m->scratch->contact.work.at[1] = 0.0;
    for (int64_t n = 0; n < f->element.size; n++)
        f->gap.at[n] = f->free_gap.at[n];
    for (int64_t first = 0; first < copies; first += together) {
        int64_t size = touch_copies(m, first, first + together, closed, turned, recess);
        if (size < 0)
            return 0;
        *touching += size;
    }
    for (int64_t copy = 0; copy < copies && !(nodes->massless > 0.0); copy++)
        if (is_pushed(nodes, s->force.at, copy))
            push_copy(m, copy);
    return 1;
}

/* Add the works of the contact forces on a copy in the step. */
static void contact_works(const March *m, int64_t copy)
{
    const Nodes *nodes = m->stage.nodes;
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = nodes->contact.rows;
    const double *before = m->state->force.at + copy * width, *force = s->force.at + copy * width;
    double *work = m->state->work.at, *moved = s->moved.at;
    int massless = nodes->massless > 0.0;
    move_nodes(m, copy, massless ? m->x.now : m->x.old, massless ? 1.0 : 0.5, moved);
    if (massless) {
        for (int64_t i = 0; i < width; i++)
            s->further.at[i] = force[i] - before[i];
        add_rows(s->further.at, nodes->compliance.at + copy * width * width, width, width, moved);
    }
    for (int64_t i = 0; i < width; i++) {
        double mean = massless ? 0.5 * (force[i] + before[i]) : force[i];
        work[i % DIRECTIONS == RADIAL ? NORMAL : FRICTION] += mean * moved[i];
    }
}

/* Add the impulses and works of an accepted step to the state, and wear the coating. `gap` and
 * `before` are the gaps after this step and one step before it. */
static void account_nodes(const March *m, int touching, const double *gap, const double *before)
{
    const Nodes *nodes = m->stage.nodes;
    State *state = m->state;
    NodeScratch *s = &m->scratch->nodes;
    double dt = m->stage.numbers->time_step;
    int64_t contacts = 0;
    for (int64_t copy = 0; copy < nodes->compliance.layers; copy++)
        if (is_pushed(nodes, s->force.at, copy) || is_pushed(nodes, state->force.at, copy))
            contact_works(m, copy);
    if (m->stage.node_coating) {
        state->coating.at[STORED] = 0.0;
        if (touching)
            wear_rods(m, gap);
    }
    for (int64_t n = 0; n < state->touched.size; n++) {
        const double *force = s->force.at + DIRECTIONS * n;
        if (!(force[RADIAL] < 0.0))
            continue;
        contacts++;
        state->touched.at[n] += 1.0;
        state->impulse.at[n] -= force[RADIAL] * dt;
        state->drag.at[n] -= force[TANGENTIAL] * dt;
        state->axial.at[n] += force[AXIAL] * dt;
        if (!(nodes->massless > 0.0)) /* without mass, nothing has to be stopped */
            state->work.at[CLOSING] -= 0.5 * force[RADIAL] * (gap[n] - before[n]);
    }
    for (int64_t i = 0; i < state->force.rows * state->force.columns; i++)
        state->force.at[i] = s->force.at[i];
    state->work.at[NORMAL] += m->scratch->contact.work.at[0];
    state->work.at[FRICTION] += m->scratch->contact.work.at[1];
    state->counts.at[STEP_CONTACTS] = (double)contacts;
    state->counts.at[CONTACT_STEPS] += touching > 0;
}

/* Return the energy of the residual flexibility of massless nodes half a step before step n. */
static double flexible_energy(const March *m)
{
    const Nodes *nodes = m->stage.nodes;
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = nodes->contact.rows, modes = nodes->contact.columns;
    double energy = 0.0;
    for (int64_t copy = 0; copy < nodes->compliance.layers; copy++) {
        const double *force = m->state->force.at + copy * width;
        int64_t first = first_mode(m, copy);
        if (!(nodes->massless > 0.0) || !is_pushed(nodes, m->state->force.at, copy))
            continue;
        for (int64_t i = 0; i < modes; i++)
            s->modal.at[i] = m->x.now[first + i] - m->x.old[first + i];
        for (int64_t i = 0; i < width; i++)
            s->further.at[i] = 0.0;
        add_rows(s->modal.at, nodes->columns.at, modes, width, s->further.at);
        add_rows(force, nodes->compliance.at + copy * width * width, width, width, s->further.at);
        for (int64_t i = 0; i < width; i++)
            energy += 0.5 * force[i] * s->further.at[i];
    }
    return energy;
}

#endif
