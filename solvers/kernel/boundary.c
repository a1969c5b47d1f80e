/* A step of structures with many contact nodes in a rigid wall or in a flexible ring.
 *
 * Displacements of the contact nodes are u = P q + C f. The modes follow central differences,
 *
 *     q_{n+1} = a q_n + b q_{n-1} + c (loads + P^T f).
 *
 * If the contact nodes have no mass, f is the contact force at step n, and C is the residual
 * flexibility. Otherwise f is the contact force at step n + 1, as in the forward increment method
 * of Carpenter, Taylor and Katona (1991), and C = P c P^T. In both cases the contact forces at step
 * n + 1 close the gaps by C only:
 *
 *     0 <= lambda  perp  g = g_free + W lambda >= 0,      W = C_rr + mu (C_rt d_t + C_ra d_a)
 *
 * with the direction of sliding (d_t, d_a) of each node. With full sliding it is the direction of
 * the slip velocity at the end of the step, which depends on the forces: a fixed point.
 *
 * In a rigid wall each copy is solved separately. In a flexible ring all nodes that may touch are
 * solved together: the ring keeps its mass, and its response to forces within the step, H c H^T with
 * its displacements H under the nodes, is added to C.
 *
 * With massless nodes the work of a contact force in a step is its mean over the step times the
 * change of the displacement. The sum of the works is then exactly the change of
 *
 *     |v|^2 / 2 + q_n^T W^2 q_{n-1} / 2 + f_n^T C f_n / 2 + f_n^T P (q_n - q_{n-1}) / 2.
 */
#include "group.h"

#define LEAST_GAP 1e-12 /* share of the scale of gaps below which a gap is closed */

/* Compute the gaps of a copy without contact at a time. Returns whether displacements are within
 * the limit. */
static int free_gaps(const Boundary *b, const Closure *closure, int64_t copy, double time,
                     const double *q, RingScratch *ring, double *gap)
{
    int64_t nodes = b->radius.size, modes = b->contact.columns, within = 1;
    double rate, closed = closure ? closure_at(closure, time, &rate) : 0.0, share;
    for (int64_t i = 0; i < nodes; i++)
        gap[i] = 0.0;
    add_rows(q, b->normal.at, modes, nodes, gap);
    for (int64_t i = 0; i < nodes; i++) {
        double u = gap[i], angle = b->angle.at[copy * nodes + i] + b->speed * time;
        within &= fabs(u) <= b->limit;
        if (ring) {
            ring->reach.at[copy * nodes + i] = b->recess.at[i] - u;
            gap[i] = ring->wall.at[copy * nodes + i] + ring->reach.at[copy * nodes + i];
            continue;
        }
        double clearance = clearance_at(&b->wall, angle, &share, closure);
        gap[i] = clearance + b->recess.at[i] - closed * share - u;
    }
    return (int)within;
}

/* Add the works of the contact forces of a copy in a step. */
static void contact_works(const Boundary *b, BoundaryState *state, BoundaryScratch *s, int64_t copy)
{
    int64_t modes = b->contact.columns, width = b->contact.rows;
    const double *before = state->force.at + copy * width, *force = s->force.at + copy * width;
    const double *old = state->q.at + copy * modes, *new = s->q.at + copy * modes;
    double *work = state->work.at, *moved = s->moved.at + copy * width;
    if (b->massless > 0.0) {
        for (int64_t i = 0; i < width; i++)
            s->further.at[i] = force[i] - before[i];
        add_rows(s->further.at, b->compliance.at + copy * width * width, width, width, moved);
    } else { /* the mean change over two steps */
        for (int64_t m = 0; m < modes; m++)
            s->change.at[m] = 0.5 * (new[m] - old[m]);
        for (int64_t i = 0; i < width; i++)
            moved[i] = 0.0;
        add_rows(s->change.at, b->columns.at, modes, width, moved);
    }
    for (int64_t i = 0; i < width; i++) {
        double mean = b->massless > 0.0 ? 0.5 * (force[i] + before[i]) : force[i];
        work[i % DIRECTIONS == RADIAL ? NORMAL : FRICTION] += mean * moved[i];
    }
}

/* Return the energy of a copy, see above. */
static double copy_energy(const Boundary *b, const BoundaryState *state, BoundaryScratch *s,
                          int64_t copy)
{
    int64_t modes = b->contact.columns, width = b->contact.rows, first = copy * modes;
    const double *old = state->q.at + first, *now = old + b->a.rows * modes;
    const double *stiffness = b->stiffness.at + first, *force = state->force.at + copy * width;
    double energy = 0.0;
    for (int64_t m = 0; m < modes; m++) {
        double v = (now[m] - old[m]) / b->time_step;
        energy += 0.5 * (v * v + stiffness[m] * now[m] * old[m]);
        s->change.at[m] = now[m] - old[m];
    }
    if (b->massless > 0.0) {
        for (int64_t i = 0; i < width; i++)
            s->further.at[i] = 0.0;
        add_rows(s->change.at, b->columns.at, modes, width, s->further.at);
        add_rows(force, b->compliance.at + copy * width * width, width, width, s->further.at);
        for (int64_t i = 0; i < width; i++)
            energy += 0.5 * force[i] * s->further.at[i];
    }
    return energy;
}

/* Record the state at step n, with velocities from q_{n+1} and q_{n-1}, or from q_n and q_{n-1} if
 * there is no next step. */
static void record_boundary(const Boundary *b, const Ring *ring, BoundaryState *state,
                            BoundaryRecords *r, BoundaryScratch *s, Motion y, int64_t row,
                            int64_t step, int next)
{
    int64_t modes = b->contact.columns, width = b->contact.rows, copies = b->a.rows;
    int64_t nodes = copies * b->radius.size, all = copies * modes;
    const double *old = state->q.at, *now = old + all, *new = next ? s->q.at : now;
    double span = (next ? 2.0 : 1.0) * b->time_step;
    r->step.at[row] = step;
    r->energy.at[row] = 0.0;
    for (int64_t copy = 0; copy < copies; copy++)
        r->energy.at[row] += copy_energy(b, state, s, copy);
    if (ring) {
        r->energy.at[row] += half_step_energy(&ring->casing.body, y, b->time_step);
        record_motion(y, next ? y.new : y.now, span, r->casing.at + row * y.entries,
                      r->casing_velocity.at + row * y.entries);
    }
    for (int64_t i = 0; i < all; i++) {
        r->q.at[row * all + i] = now[i];
        r->velocity.at[row * all + i] = (new[i] - old[i]) / span;
    }
    for (int64_t i = 0; i < copies * width; i++) {
        r->force.at[row * copies * width + i] = state->force.at[i];
        r->impulse.at[row * copies * width + i] = state->impulse.at[i];
        state->impulse.at[i] = 0.0;
    }
    for (int64_t i = 0; i < nodes; i++) {
        r->gap.at[row * nodes + i] = state->gap.at[i];
        r->touched.at[row * nodes + i] = state->touched.at[i];
        state->gap.at[i] = INFINITY;
        state->touched.at[i] = 0.0;
    }
    for (int64_t i = 0; i < WORKS; i++)
        r->work.at[row * WORKS + i] = state->work.at[i];
}

/* Add the response of coupled modes of a copy to modal forces. */
static void add_response(const Boundary *b, int64_t copy, const double *force, double *new)
{
    int64_t modes = b->contact.columns;
    const double *row = b->response.at + copy * modes * modes;
    for (int64_t m = 0; m < modes; m++, row += modes) {
        double sum = 0.0;
        for (int64_t n = 0; n < modes; n++)
            sum += row[n] * force[n];
        new[m] += sum;
    }
}

/* Record the sums of the coating at the start of a step. */
static void record_coating(const double *sums, BoundaryState *state, BoundaryRecords *r, int64_t row)
{
    int64_t nodes = state->coating_impulse.rows * state->coating_impulse.columns;
    for (int64_t i = 0; i < COATING_SUMS; i++)
        r->coating.at[row * COATING_SUMS + i] = sums[i];
    for (int64_t n = 0; n < nodes; n++) {
        r->coating_impulse.at[row * nodes + n] = state->coating_impulse.at[n];
        state->coating_impulse.at[n] = 0.0;
    }
}

/* Advance a copy without contact: compute q_{n+1} and the gaps. Returns whether displacements are
 * within the limit. */
static int advance_copy(const Boundary *b, const Ring *ring, const Closure *closure,
                        const BoundaryState *state, BoundaryScratch *s, int64_t copy, double time,
                        int loaded)
{
    int64_t modes = b->contact.columns, width = b->contact.rows, first = copy * modes;
    const double *old = state->q.at + first, *now = old + b->a.rows * modes;
    const double *x = b->a.at + first, *y = b->b.at + first, *z = b->c.at + first;
    double *new = s->q.at + first, *modal = s->modal.at;
    for (int64_t m = 0; m < modes; m++)
        modal[m] = 0.0;
    if (loaded)
        for (int64_t p = 0; p < b->load.layers; p++)
            for (int64_t m = 0; m < modes; m++)
                modal[m] += s->amplitude.at[p] * b->load.at[(p * b->a.rows + copy) * modes + m];
    if (b->massless > 0.0)
        add_rows(state->force.at + copy * width, b->contact.at, width, modes, modal);
    if (b->response.layers > 0) {
        for (int64_t m = 0; m < modes; m++) {
            modal[m] += x[m] * now[m] + y[m] * old[m];
            new[m] = old[m];
        }
        add_response(b, copy, modal, new);
    } else
        for (int64_t m = 0; m < modes; m++)
            new[m] = (x[m] * now[m] + y[m] * old[m]) + z[m] * modal[m];
    return free_gaps(b, closure, copy, time + b->time_step, new, ring ? &s->ring : NULL,
                     s->gap.at + copy * b->radius.size);
}

/* Return whether a node of a copy touches the wall at the end of the step without contact, or was
 * in contact at its start: the second and the first bit. */
static int copy_contact(const Boundary *b, const NodeCoating *coating, const BoundaryState *state,
                        const BoundaryScratch *s, int64_t copy)
{
    int64_t nodes = b->radius.size;
    const double *gap = s->gap.at + copy * nodes, *before = state->force.at + copy * b->contact.rows;
    int touching = 0, touched = 0;
    for (int64_t i = 0; i < nodes; i++) {
        touching |= gap[i] < 0.0 || (coating && s->rods.near.at[copy * nodes + i] == 2);
        touched |= before[DIRECTIONS * i + RADIAL] < 0.0;
    }
    return 2 * touching + touched;
}

/* Compute the change of the displacements of a copy in the step without new contact forces: `moved`
 * that of the modes, `slip` also that of the flexible part. */
static void move_copy(const Boundary *b, const BoundaryState *state, BoundaryScratch *s,
                      int64_t copy)
{
    int64_t modes = b->contact.columns, width = b->contact.rows, all = b->a.rows * modes;
    const double *now = state->q.at + all + copy * modes, *new = s->q.at + copy * modes;
    const double *before = state->force.at + copy * width;
    double *moved = s->moved.at + copy * width, *slip = s->slip.at + copy * width;
    for (int64_t m = 0; m < modes; m++)
        s->change.at[m] = new[m] - now[m];
    for (int64_t i = 0; i < width; i++)
        moved[i] = slip[i] = 0.0;
    add_rows(s->change.at, b->columns.at, modes, width, moved);
    if (b->massless > 0.0)
        add_rows(before, b->compliance.at + copy * width * width, width, width, slip);
    for (int64_t i = 0; i < width; i++)
        slip[i] = moved[i] - slip[i];
}

/* Add the response of the modes of a copy to contact forces within the step. */
static void push_copy(const Boundary *b, BoundaryScratch *s, int64_t copy)
{
    int64_t modes = b->contact.columns, width = b->contact.rows, first = copy * modes;
    for (int64_t m = 0; m < modes; m++)
        s->modal.at[m] = 0.0;
    add_rows(s->force.at + copy * width, b->contact.at, width, modes, s->modal.at);
    if (b->response.layers > 0)
        add_response(b, copy, s->modal.at, s->q.at + first);
    else
        for (int64_t m = 0; m < modes; m++)
            s->q.at[first + m] += b->c.at[first + m] * s->modal.at[m];
}

/* Compute contact of a copy with a rigid wall at the end of a step, and add works. Returns whether
 * the copy is in contact. */
static int touch_copy(const Boundary *b, const NodeCoating *coating, BoundaryState *state,
                      BoundaryScratch *s, int64_t copy)
{
    int64_t nodes = b->radius.size, width = b->contact.rows;
    int contact = copy_contact(b, coating, state, s, copy);
    double *force = s->force.at + copy * width;
    for (int64_t i = 0; i < width; i++)
        force[i] = 0.0;
    if (contact)
        move_copy(b, state, s, copy);
    if (contact >= 2) {
        for (int64_t i = 0; i < nodes; i++)
            s->number.at[i] = copy * nodes + i;
        Group group = {nodes,
                       s->number.at,
                       b->radius.at,
                       b->compliance.at + copy * width * width,
                       state->force.at + copy * width,
                       s->slip.at + copy * width,
                       s->gap.at + copy * nodes,
                       force,
                       state->direction.at + 2 * copy * nodes};
        contact_forces(b, coating, state, s, &group);
        if (coating)
            wear_rods(b, coating, state, s, &group);
        if (!(b->massless > 0.0))
            push_copy(b, s, copy);
    }
    if (contact)
        contact_works(b, state, s, copy);
    return contact >= 2;
}

/* Collect the nodes in `list` into a group, with the compliance of their copies and of the ring. */
static Group collect(const Boundary *b, const Ring *ring, const BoundaryState *state,
                     BoundaryScratch *s, int64_t size)
{
    RingScratch *r = &s->ring;
    int64_t nodes = b->radius.size, width = b->contact.rows, wide = DIRECTIONS * size;
    for (int64_t i = 0; i < size; i++) {
        int64_t n = r->list.at[i];
        r->radius.at[i] = b->radius.at[n % nodes];
        r->gap.at[i] = s->gap.at[n];
        for (int64_t k = 0; k < 2; k++)
            r->direction.at[2 * i + k] = state->direction.at[2 * n + k];
        for (int64_t k = 0; k < DIRECTIONS; k++) {
            r->before.at[DIRECTIONS * i + k] = state->force.at[DIRECTIONS * n + k];
            r->slip.at[DIRECTIONS * i + k] = s->slip.at[DIRECTIONS * n + k];
        }
        if (b->full > 0.0)
            r->slip.at[DIRECTIONS * i + TANGENTIAL] -= r->fields.other.at[n];
        for (int64_t j = 0; j <= i; j++) {
            int64_t m = r->list.at[j], copy = n / nodes;
            double block[DIRECTIONS * DIRECTIONS] = {0.0};
            const double *from = b->compliance.at + copy * width * width
                                 + DIRECTIONS * (n % nodes) * width + DIRECTIONS * (m % nodes);
            double back[DIRECTIONS * DIRECTIONS] = {0.0}; /* Coriolis forces: not symmetric */
            const double *other = b->compliance.at + copy * width * width
                                  + DIRECTIONS * (m % nodes) * width + DIRECTIONS * (n % nodes);
            for (int64_t k = 0; copy == m / nodes && k < DIRECTIONS * DIRECTIONS; k++) {
                block[k] = from[k / DIRECTIONS * width + k % DIRECTIONS];
                back[k] = other[k / DIRECTIONS * width + k % DIRECTIONS];
            }
            add_ring_compliance(ring, &r->fields, n, m, block, DIRECTIONS);
            add_ring_compliance(ring, &r->fields, m, n, back, DIRECTIONS);
            double *to = r->compliance.at + DIRECTIONS * i * wide + DIRECTIONS * j;
            double *mirrored = r->compliance.at + DIRECTIONS * j * wide + DIRECTIONS * i;
            for (int64_t k = 0; k < DIRECTIONS; k++)
                for (int64_t l = 0; l < DIRECTIONS; l++) {
                    mirrored[k * wide + l] = back[k * DIRECTIONS + l];
                    to[k * wide + l] = block[k * DIRECTIONS + l];
                }
        }
    }
    return (Group){size,         r->list.at, r->radius.at, r->compliance.at, r->before.at,
                   r->slip.at,   r->gap.at,  r->force.at,  r->direction.at};
}

/* Distribute the forces and directions of a group to its nodes, and compute the response of the
 * ring. */
static void distribute(const Boundary *b, const Ring *ring, BoundaryState *state,
                       BoundaryScratch *s, const Group *g, Motion y)
{
    RingScratch *r = &s->ring;
    int64_t size = 0;
    for (int64_t i = 0; i < g->size; i++) {
        int64_t n = r->list.at[i];
        for (int64_t k = 0; k < DIRECTIONS; k++)
            s->force.at[DIRECTIONS * n + k] = g->force[DIRECTIONS * i + k];
        for (int64_t k = 0; k < 2; k++)
            state->direction.at[2 * n + k] = g->direction[2 * i + k];
        r->contact.multiplier.at[n] = -g->force[DIRECTIONS * i + RADIAL];
        r->contact.sign.at[n] = g->direction[2 * i];
        if (g->force[DIRECTIONS * i + RADIAL] < 0.0)
            r->contact.active.at[size++] = n;
    }
    push_ring(ring, b->friction, size, y, r);
}

/* Compute the gaps of all nodes with contact. Returns the number of nodes outside the group that
 * are inside the wall, which are added to `list`. */
static int64_t join_group(const Boundary *b, const Ring *ring, const NodeCoating *coating,
                          const Closure *closure, double time, BoundaryState *state,
                          BoundaryScratch *s, int64_t size)
{
    double rate, closed = closure ? closure_at(closure, time, &rate) : 0.0, slope;
    double reach = coating ? reach_of_rods(ring, coating, s) : 0.0;
    RingScratch *r = &s->ring;
    int64_t nodes = b->radius.size, width = b->contact.rows, joined = 0;
    for (int64_t copy = 0; copy < b->a.rows; copy++)
        for (int64_t i = 0; i < nodes; i++) {
            int64_t n = copy * nodes + i;
            double gap = r->wall.at[n] + r->reach.at[n];
            const double *row = b->compliance.at + (copy * width + DIRECTIONS * i) * width;
            for (int64_t k = 0; r->pushed.at[copy] && k < width; k++)
                gap -= row[k] * s->force.at[copy * width + k];
            int inside = gap < -LEAST_GAP * b->gap_scale;
            r->closed.at[n] = gap;
            if (coating && !r->listed.at[n] && gap < reach) {
                if (!s->rods.near.at[n])
                    place_rods(b, ring, coating, closure, closed, time, n, s);
                inside |= press_rods(coating, i, s->rods.range.at + 2 * n,
                                     s->rods.offset.at + n * s->rods.offset.columns, gap,
                                     state->strain.at, &slope, NULL)
                          > 0.0;
            }
            if (!r->listed.at[n] && inside) {
                r->listed.at[n] = 1;
                r->list.at[size + joined++] = n;
            }
        }
    return joined;
}

/* Compute contact of all copies with a ring at the end of a step, and add works. Returns whether
 * any node is in contact, or -1 if the displacement of the ring is not a number. */
static int touch_ring(const Boundary *b, const Ring *ring, const NodeCoating *coating,
                      const Closure *closure, BoundaryState *state, BoundaryScratch *s,
                      double time, Motion y)
{
    RingScratch *r = &s->ring;
    int64_t copies = b->a.rows, nodes = b->radius.size, size = 0;
    int contact = 0, finite = 1;
    for (int64_t i = 0; i < copies * b->contact.rows; i++)
        s->force.at[i] = 0.0;
    for (int64_t copy = 0; copy < copies; copy++)
        contact |= copy_contact(b, coating, state, s, copy);
    for (int64_t n = 0; n < copies * nodes; n++) {
        int near = s->gap.at[n] < 0.0 || state->force.at[DIRECTIONS * n + RADIAL] < 0.0
                   || (coating && s->rods.near.at[n] == 2);
        r->listed.at[n] = contact >= 2 && near;
        if (r->listed.at[n])
            r->list.at[size++] = n;
    }
    for (int64_t copy = 0; copy < copies; copy++)
        r->pushed.at[copy] = 0;
    if (contact >= 2 && b->full > 0.0) { /* tangential displacement of the ring in the step */
        for (int64_t i = 0; i < y.entries; i++)
            r->change.at[i] = y.new[i] - y.now[i];
        ring_field(ring, &ring->casing.tangential, r->change.at, r, r->fields.other.at);
    }
    for (int64_t first = 0, joined = size; joined > 0; first = size - joined) {
        for (int64_t i = first; i < size; i++) {
            int64_t copy = r->list.at[i] / nodes;
            if (!r->pushed.at[copy])
                move_copy(b, state, s, copy);
            r->pushed.at[copy] = 1;
        }
        Group group = collect(b, ring, state, s, size);
        contact_forces(b, coating, state, s, &group);
        distribute(b, ring, state, s, &group, y);
        finite = ring_wall(ring, closure, time, r);
        joined = finite ? join_group(b, ring, coating, closure, time, state, s, size) : 0;
        if (coating && joined == 0)
            wear_rods(b, coating, state, s, &group);
        size += joined;
    }
    for (int64_t copy = 0; copy < copies; copy++) {
        int pushed = r->pushed.at[copy] != 0;
        if (!pushed && (copy_contact(b, coating, state, s, copy) & 1))
            move_copy(b, state, s, copy);
        else if (!pushed)
            continue;
        if (pushed && !(b->massless > 0.0))
            push_copy(b, s, copy);
        contact_works(b, state, s, copy);
    }
    if (contact >= 2) {
        for (int64_t n = 0; n < copies * nodes; n++)
            s->gap.at[n] = r->closed.at[n];
        state->work.at[NORMAL] += r->contact.work.at[0];
        state->work.at[FRICTION] += r->contact.work.at[1];
    }
    return finite ? contact >= 2 : -1;
}

/* Add the works of loads and damping in a step. */
static void modal_works(const Boundary *b, const Ring *ring, BoundaryState *state,
                        BoundaryScratch *s, Motion y, int loaded)
{
    int64_t all = b->a.rows * b->a.columns;
    const double *old = state->q.at, *new = s->q.at;
    double lost = 0.0, done = 0.0;
    for (int64_t i = 0; i < all; i++) {
        double moved = 0.5 * (new[i] - old[i]);
        lost += b->damping.at[i] * moved * moved;
    }
    for (int64_t first = 0; b->coupled.rows > 0 && first < all; first += b->a.columns)
        for (int64_t m = 0; m < b->a.columns; m++) {
            double moved = 0.5 * (new[first + m] - old[first + m]);
            const double *row = b->coupled.at + m * b->a.columns;
            for (int64_t n = 0; n < b->a.columns; n++)
                lost += moved * row[n] * 0.5 * (new[first + n] - old[first + n]);
        }
    if (loaded)
        for (int64_t p = 0; p < b->load.layers; p++)
            for (int64_t i = 0; i < all; i++)
                done += s->amplitude.at[p] * b->load.at[p * all + i] * 0.5 * (new[i] - old[i]);
    if (ring) {
        const Body *body = &ring->casing.body;
        lost += damping_loss(body, y);
        if (loaded)
            done += external_work(body, s->amplitude.at, y);
        if (ring->dampers.rows.rows > 0)
            state->work.at[DAMPING] +=
                damper_loss(&ring->dampers, y, s->ring.stroke.at, s->ring.damper_force.at);
    }
    state->work.at[DAMPING] += lost / b->time_step;
    state->work.at[EXTERNAL] += done;
}

/* Add the contact of a step to the sums since the last record. */
static void sum_contact(const Boundary *b, const NodeCoating *coating, BoundaryState *state,
                        const BoundaryScratch *s)
{
    for (int64_t n = 0; n < b->a.rows * b->radius.size; n++) {
        const double *force = s->force.at + DIRECTIONS * n;
        double normal = -force[RADIAL], *impulse = state->impulse.at + DIRECTIONS * n;
        state->gap.at[n] = smaller(state->gap.at[n], s->gap.at[n]);
        state->touched.at[n] += normal > 0.0;
        impulse[RADIAL] += normal * b->time_step;
        if (coating)
            state->coating_impulse.at[n] += s->rods.pressed.at[n] * b->time_step;
        for (int k = TANGENTIAL; k <= AXIAL; k++)
            impulse[k] += force[k] * b->time_step;
    }
}

int boundary_march(const Boundary *boundary, const Ring *ring, const NodeCoating *coating,
                   const Closure *closure, BoundaryState *state, BoundaryRecords *records,
                   BoundaryScratch *scratch, int64_t step, int64_t steps, int64_t record_every,
                   int64_t *reached)
{
    const Boundary *b = boundary;
    int64_t copies = b->a.rows, all = copies * b->a.columns, width = b->contact.rows;
    int64_t last = step + steps, rows = 0;
    Motion y = motion_of(&state->casing);
    for (; step < last; step++) {
        double time = (double)step * b->time_step, later = time + b->time_step;
        int loaded = load_amplitudes(&b->load_times, time, scratch->amplitude.at), within = 1;
        int touching = 0;
        if (ring) {
            double turned = ring->elements_per_step * (double)(step + 1);
            predict_ring(ring, scratch->amplitude.at, turned, y, &scratch->ring);
            within &= ring_field(ring, &ring->casing.radial, y.new, &scratch->ring,
                                 scratch->ring.wall.at);
            within &= step % CHECK_EVERY != 0 || ring_keeps(ring, b->limit, &scratch->ring);
            if (closure)
                close_ring(closure, later, &scratch->ring);
        }
        for (int64_t copy = 0; copy < copies; copy++)
            within &= advance_copy(b, ring, closure, state, scratch, copy, time, loaded);
        double works[WORKS], worn[COATING_SUMS];
        for (int i = 0; i < WORKS; i++)
            works[i] = state->work.at[i];
        for (int i = 0; coating && i < COATING_SUMS; i++)
            worn[i] = state->coating.at[i];
        if (within && coating)
            find_rods(b, ring, coating, closure, later, state, scratch);
        if (within && ring) {
            touching = touch_ring(b, ring, coating, closure, state, scratch, later, y);
            within = touching >= 0;
        } else if (within)
            for (int64_t copy = 0; copy < copies; copy++)
                touching |= touch_copy(b, coating, state, scratch, copy);
        if (!within || step % record_every == 0) { /* a record is from before the works of the step */
            double after[WORKS];
            for (int i = 0; i < WORKS; i++) {
                after[i] = state->work.at[i];
                state->work.at[i] = works[i];
            }
            if (coating)
                record_coating(worn, state, records, rows);
            record_boundary(b, ring, state, records, scratch, y, rows++, step, within);
            for (int i = 0; i < WORKS; i++)
                state->work.at[i] = within ? after[i] : works[i];
        }
        if (!within)
            break;
        modal_works(b, ring, state, scratch, y, loaded);
        state->counts.at[CONTACT_STEPS] += touching;
        sum_contact(b, coating, state, scratch);
        for (int64_t i = 0; i < copies * width; i++)
            state->force.at[i] = scratch->force.at[i];
        for (int64_t i = 0; i < all; i++) {
            state->q.at[i] = state->q.at[all + i];
            state->q.at[all + i] = scratch->q.at[i];
        }
        turn_slots(&y);
    }
    settle(&state->casing, y);
    reached[0] = step;
    reached[1] = rows;
    return step < last ? DIVERGED : RUNNING;
}
