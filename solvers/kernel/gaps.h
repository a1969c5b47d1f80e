/* Displacements of contact nodes and gaps in a step, slip in it, and directions of sliding; the
 * equations are in `nodes.h`. */
#ifndef GAPS_H
#define GAPS_H

#include "forces.h"

/* Return whether a contact node can touch the wall, as it is in no joint. */
static inline int at_wall(const March *m, int64_t node)
{
    return !m->stage.joints || !m->stage.joints->joined.at[node];
}

/* Part of the forces of joints at steps n + 1, n, n - 1 and n - 2 in those that act on the modes at step
 * n; see `joints.h`. */
static const double JOINT_PARTS[] = {0.4, 0.3, 0.2, 0.1};

/* Return the displacements of nodes times forces of joints, as forces on the nodes: a part of those at
 * step n + 1, or of those before. */
static void spread_joints(const Joints *joints, const double *force, double part, double *out)
{
    for (int64_t end = 0; end < joints->node.size; end++) {
        if (joints->node.at[end] < 0)
            continue;
        const double *axes = joints->axes.at + DIRECTIONS * DIRECTIONS * end;
        const double *own = force + DIRECTIONS * (end / 2);
        double *to = out + DIRECTIONS * joints->node.at[end];
        for (int k = 0; k < DIRECTIONS; k++)
            for (int direction = 0; direction < DIRECTIONS; direction++)
                to[direction] += part * axes[DIRECTIONS * k + direction] * own[k];
    }
}

/* Return the forces of step n and before that act on the modes at step n. */
static const double *acting_forces(const March *m)
{
    const Joints *joints = m->stage.joints;
    const State *state = m->state;
    double *out = m->scratch->joints.acting.at;
    for (int64_t i = 0; i < state->force.rows * state->force.columns; i++)
        out[i] = at_wall(m, i / DIRECTIONS) ? state->force.at[i] : 0.0;
    for (int64_t past = 0; past < state->joint_force.rows; past++)
        spread_joints(joints, state->joint_force.at + past * state->joint_force.columns,
                      JOINT_PARTS[past + 1], out);
    return out;
}

/* Return whether any node of a copy has a contact force. */
static int is_pushed(const Rotor *rotor, const double *force, int64_t copy)
{
    int64_t width = rotor->compliance.rows;
    for (int64_t i = copy * width; i < (copy + 1) * width; i++)
        if (force[i] != 0.0)
            return 1;
    return 0;
}

/* Let copies be wanted that have a contact force. Returns whether there are any. */
static int want_pushed(const March *m, const double *force)
{
    int64_t any = 0, *wanted = m->scratch->nodes.wanted.at;
    for (int64_t copy = 0; copy < m->stage.rotor->copies; copy++)
        any |= wanted[copy] = is_pushed(m->stage.rotor, force, copy);
    return (int)any;
}

/* Let the copies of the nodes of the list be wanted. */
static void want_listed(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t copies = m->stage.rotor->copies, count = s->listed.size / copies;
    for (int64_t copy = 0; copy < copies; copy++)
        s->wanted.at[copy] = copies == 1;
    for (int64_t i = 0; i < size && copies > 1; i++)
        s->wanted.at[s->list.at[i] / count] = 1;
}

/* List the nodes at the wall with a force, or with one of two unless `before` is NULL, and let their
 * copies be wanted. Returns the number of nodes. */
static int64_t list_pushed(const March *m, const double *force, const double *before)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t size = 0;
    for (int64_t n = 0; n < s->listed.size; n++) {
        int64_t k = DIRECTIONS * n + RADIAL;
        if ((force[k] < 0.0 || (before && before[k] < 0.0)) && at_wall(m, n))
            s->list.at[size++] = n;
    }
    want_listed(m, size);
    return size;
}

/* Return the work of forces in a direction on the nodes of the list for their displacements. */
static double work_of(const March *m, int64_t size, int direction, const double *force,
                      const double *moved)
{
    const int64_t *list = m->scratch->nodes.list.at;
    double sum = 0.0;
    for (int64_t i = 0; i < size; i++)
        sum += force[DIRECTIONS * list[i] + direction] * moved[i];
    return sum;
}

/* Add a component of the displacements due to forces and the compliance of the nodes, of copies that
 * are `wanted`, or of all of them if it is NULL. */
static void add_flexible(const Rotor *rotor, int64_t direction, const IntVector *wanted,
                         const double *force, double factor, double *out)
{
    int64_t width = rotor->compliance.rows, count = width / DIRECTIONS;
    for (int64_t copy = 0; copy < rotor->copies; copy++) {
        if (wanted && !wanted->at[copy])
            continue;
        for (int64_t k = copy * width; k < (copy + 1) * width; k++) {
            const double *by = rotor->compliance.at + k * width + direction * count;
            double push = factor * force[k], *to = out + copy * count;
            for (int64_t i = 0; push != 0.0 && i < count; i++)
                to[i] += push * by[i];
        }
    }
}

/* Add a component of the displacements of the nodes of the list due to forces and their compliance. */
static void add_flexible_listed(const March *m, int64_t direction, int64_t size, const double *force,
                                double factor, double *out)
{
    const Rotor *rotor = m->stage.rotor;
    const int64_t *list = m->scratch->nodes.list.at;
    int64_t width = rotor->compliance.rows, count = width / DIRECTIONS;
    for (int64_t k = 0; k < rotor->copies * width; k++) {
        int64_t first = k / width * count;
        const double *by = rotor->compliance.at + k * width + direction * count - first;
        double push = factor * force[k];
        for (int64_t i = 0; push != 0.0 && i < size; i++)
            if (first <= list[i] && list[i] < first + count)
                out[i] += push * by[list[i]];
    }
}

/* Compute a component of the displacements of the nodes of the list, of wanted copies, for modal
 * coordinates x. */
static void listed_field(const March *m, int64_t direction, int64_t size, const double *x, double *out)
{
    const Rotor *rotor = m->stage.rotor;
    FieldScratch *f = &m->scratch->fields;
    const int64_t *list = m->scratch->nodes.list.at;
    int64_t each = rotor->own.layers / DIRECTIONS, columns = rotor->own.columns;
    if (rotor->half == 0) {
        node_field(rotor, direction, x, &m->scratch->nodes.wanted, f, f->moved.at);
        for (int64_t i = 0; i < size; i++)
            out[i] = f->moved.at[list[i]];
        return;
    }
    for (int64_t node = 0; node < each; node++)
        for (int64_t i = 0, summed = 0; i < size; i++) {
            int64_t blade = list[i] / each;
            if (list[i] - blade * each != node)
                continue;
            if (!summed)
                component_sums(rotor, DIRECTIONS * node + direction, x, f);
            summed = 1;
            out[i] = dot(rotor->spread.at + blade * columns, f->sums.at, columns);
        }
}

/* Store the change of the displacements of a body. */
static void store_change(Motion x, const double *from, double *out)
{
    for (int64_t i = 0; i < x.entries; i += LANES)
        store(out + i, sub(load(x.new + i), load(from + i)));
}

/* Add the response to forces on massless nodes to x_{n+1}; with a matrix A that is not diagonal, it is
 * computed with its inverse or, if `inverse` is NULL, later. */
static void add_response(const March *m, const double *force, const Gyroscopic *inverse)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t size = 0;
    if (!want_pushed(m, force))
        return;
    if (m->stage.rotor->half == 0) {
        push_copies(m, force, inverse, m->x.new);
        return;
    }
    for (int64_t n = 0; n < s->listed.size; n++)
        if (force[DIRECTIONS * n + RADIAL] != 0.0 || !at_wall(m, n))
            s->list.at[size++] = n;
    double ignored[2];
    push_blades(m, size, NULL, force, m->x.now, m->x.new, ignored);
}

/* Add the response to the contact forces on massless nodes at step n. */
static void add_node_forces(const March *m)
{
    if (m->stage.joints)
        add_response(m, acting_forces(m), NULL);
    else if (m->held)
        add_response(m, m->state->force.at, NULL);
}

/* Find the element under each node and its Hermite weights at x_{n+1}. The angle of a node follows
 * its tangential displacement if that of tips does; contact forces are those of step n. */
static void place_nodes(const March *m)
{
    const Rotor *rotor = m->stage.rotor;
    const Casing *casing = m->stage.casing;
    FieldScratch *f = &m->scratch->fields;
    const double *places = rotor->position.at;
    double *moved = f->moved.at, elements = (double)casing->nodes / (2.0 * PI);
    if (m->stage.numbers->tip_rotation > 0.0) {
        node_field(rotor, TANGENTIAL, m->x.new, NULL, f, moved);
        if (rotor->massless > 0.0 && m->held)
            add_flexible(rotor, TANGENTIAL, NULL, m->state->force.at, 1.0, moved);
        for (int64_t n = 0; n < f->element.size; n++)
            f->at.at[n] = places[n] + elements * moved[n] / rotor->radius.at[n];
        places = f->at.at;
    }
    hermite_weights(places, m->rotation.elements, (double)casing->nodes, casing->element_length,
                    f->element.size, f->hermite.columns, f->element.at, f->hermite.at);
    for (int64_t n = 0; n < rotor->wall.size; n++)
        f->element.at[n] += rotor->wall.at[n];
}

/* Compute the gaps of radial displacements from the sums of w and w' by column. Returns whether all
 * displacements are within the limit. */
static int find_gaps(const March *m, const double *radial, const double *recess, double *gap)
{
    const Casing *casing = m->stage.casing;
    FieldScratch *f = &m->scratch->fields;
    const double *part = m->stage.rotor->normal_part.at;
    double limit = m->stage.numbers->displacement_limit;
    int64_t within = 0, count = f->element.size;
    if (!field_at_nodes(nodal_field(casing, &casing->radial, f), f, gap))
        return 0;
    for (int64_t n = 0; n < count; n++) {
        gap[n] = gap[n] * part[n] + (recess[n] - radial[n]);
        within += fabs(radial[n]) <= limit; /* 0 for NaN */
    }
    return within == count;
}

/* Compute the gaps without contact forces of this step. Returns whether displacements are within the
 * limit. */
static int find_free_gaps(const March *m, const double *recess)
{
    const NodalField *field = &m->stage.casing->radial;
    FieldScratch *f = &m->scratch->fields;
    node_field(m->stage.rotor, RADIAL, m->x.new, NULL, f, f->radial.at);
    column_sums(&field->weight, m->y.new, field->half, f->value.at);
    column_sums(&field->slope_weight, m->y.new, field->slope_half, f->slope.at);
    return find_gaps(m, f->radial.at, recess, f->free_gap.at);
}

/* Return whether the displacements of all nodes at x_{n+1}, in each direction, and the radial ones of
 * the casing are within the limit. */
static int keeps_limit(const March *m)
{
    const Rotor *rotor = m->stage.rotor;
    const Casing *casing = m->stage.casing;
    FieldScratch *f = &m->scratch->fields;
    double limit = m->stage.numbers->displacement_limit;
    int within = 1;
    for (int64_t i = 0; casing->modes > 0 && i < casing->radial.spread.rows; i++)
        within &= fabs(f->nodal.at[i] - casing->radial.start.at[i]) <= limit;
    for (int direction = 0; direction < DIRECTIONS; direction++) {
        node_field(rotor, direction, m->x.new, NULL, f, f->moved.at);
        if (rotor->massless > 0.0)
            add_flexible(rotor, direction, NULL, m->scratch->nodes.force.at, 1.0, f->moved.at);
        for (int64_t n = 0; n < f->element.size; n++)
            within &= fabs(f->moved.at[n]) <= limit;
    }
    return within;
}

/* Compute a change of the tangential displacement of a flexible casing under each node. */
static void casing_slip(const March *m, const double *change, double *out)
{
    const Casing *casing = m->stage.casing;
    const NodalField *field = &casing->tangential;
    FieldScratch *f = &m->scratch->fields;
    column_sums(&field->weight, change, field->half, f->value.at);
    column_sums(&field->slope_weight, change, field->slope_half, f->slope.at);
    field_at_nodes(nodal_field(casing, field, f), f, out);
}

/* Compute the displacements of the nodes of the list in the step relative to the casing, and to those
 * of the last contact forces, without new ones. */
static void find_slip(const March *m, int64_t size)
{
    const Rotor *rotor = m->stage.rotor;
    NodeScratch *s = &m->scratch->nodes;
    FieldScratch *f = &m->scratch->fields;
    double *moved = f->other.at;
    store_change(m->x, m->x.now, f->change.at);
    for (int direction = 0; direction < DIRECTIONS; direction++) {
        listed_field(m, direction, size, f->change.at, moved);
        if (rotor->massless > 0.0 && m->held)
            add_flexible_listed(m, direction, size, m->state->force.at, -1.0, moved);
        if (m->stage.joints)
            add_flexible_listed(m, direction, size, m->scratch->joints.on_nodes.at, 1.0, moved);
        for (int64_t i = 0; i < size; i++)
            s->slide.at[DIRECTIONS * i + direction] = moved[i];
    }
    if (m->stage.casing->modes == 0)
        return;
    store_change(m->y, m->y.now, f->change.at);
    casing_slip(m, f->change.at, s->along.at);
    for (int64_t i = 0; i < size; i++)
        s->slide.at[DIRECTIONS * i + TANGENTIAL] -= s->along.at[s->list.at[i]];
}

/* Compute the direction of sliding of each node: that of the rotation, or if it is signed that of the
 * tangential motion in the last step. */
static void find_signs(const March *m)
{
    const Rotor *rotor = m->stage.rotor;
    FieldScratch *f = &m->scratch->fields;
    double speed = m->rotation.speed, dt = m->stage.numbers->time_step;
    double *sign = m->scratch->nodes.sign.at, way = (speed > 0.0) - (speed < 0.0);
    int64_t count = f->element.size;
    if (m->stage.numbers->is_signed == 0.0) {
        for (int64_t n = 0; n < count; n++)
            sign[n] = way;
        return;
    }
    store_change((Motion){.new = m->x.now, .entries = m->x.entries}, m->x.old, f->change.at);
    node_field(rotor, TANGENTIAL, f->change.at, NULL, f, f->moved.at);
    store_change((Motion){.new = m->y.now, .entries = m->y.entries}, m->y.old, f->change.at);
    casing_slip(m, f->change.at, f->other.at);
    for (int64_t n = 0; n < count; n++) {
        double slip = speed * rotor->radius.at[n] + (f->moved.at[n] - f->other.at[n]) / dt;
        sign[n] = (slip > 0.0) - (slip < 0.0);
    }
}

#endif
