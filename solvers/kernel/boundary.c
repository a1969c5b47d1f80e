/* A step of structures with many contact nodes in a rigid wall.
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
 * With massless nodes the work of a contact force in a step is its mean over the step times the
 * change of the displacement. The sum of the works is then exactly the change of
 *
 *     |v|^2 / 2 + q_n^T W^2 q_{n-1} / 2 + f_n^T C f_n / 2 + f_n^T P (q_n - q_{n-1}) / 2.
 */
#include <stddef.h>

#include "motion.h"

enum { MOST_DIRECTIONS = 100 }; /* iterations of the direction of sliding */
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

/* Compute the gaps of a copy without contact at a time. Returns whether displacements are within
 * the limit. */
static int free_gaps(const Boundary *b, const Closure *closure, int64_t copy, double time,
                     const double *q, double *gap)
{
    int64_t nodes = b->radius.size, modes = b->contact.columns, within = 1;
    double rate, closed = closure ? closure_at(closure, time, &rate) : 0.0, share;
    for (int64_t i = 0; i < nodes; i++)
        gap[i] = 0.0;
    add_rows(q, b->normal.at, modes, nodes, gap);
    for (int64_t i = 0; i < nodes; i++) {
        double u = gap[i], angle = b->angle.at[copy * nodes + i] + b->speed * time;
        within &= fabs(u) <= b->limit;
        double clearance = clearance_at(&b->wall, angle, &share, closure);
        gap[i] = clearance + b->recess.at[i] - closed * share - u;
    }
    return (int)within;
}

/* Compute W for the directions of sliding of a copy: all columns, or those of nodes in contact. */
static void respond(const Boundary *b, const double *compliance, const double *direction,
                    const double *multiplier, BoundaryScratch *s)
{
    int64_t nodes = b->radius.size, width = DIRECTIONS * nodes;
    for (int64_t j = 0; j < nodes; j++) {
        if (multiplier && !(multiplier[j] > 0.0))
            continue;
        const double *entry = compliance + DIRECTIONS * j;
        double across = b->friction * direction[2 * j], along = b->friction * direction[2 * j + 1];
        for (int64_t i = 0; i < nodes; i++, entry += DIRECTIONS * width)
            s->response.at[i * nodes + j] =
                entry[RADIAL] + (entry[TANGENTIAL] * across + entry[AXIAL] * along);
    }
}

/* Solve the equations of the active nodes with partial pivoting. Returns 0 if they are singular. */
static int solve_active(const double *gap, BoundaryScratch *s, int64_t size)
{
    int64_t nodes = s->gap.columns, width = size + 1;
    double *system = s->system.at, largest = 0.0;
    const int64_t *active = s->active.at;
    for (int64_t i = 0; i < size; i++) {
        for (int64_t j = 0; j < size; j++)
            system[i * width + j] = s->response.at[active[i] * nodes + active[j]];
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

/* Solve the complementarity problem of a copy for given directions of sliding, beginning with the
 * active set in `held`. The set is changed for all nodes at a time, then node by node, which ends
 * for every matrix whose principal minors are positive (Murty 1974). Returns 0 without a solution.
 */
static int solve_normal(const double *gap, BoundaryScratch *s)
{
    int64_t nodes = s->gap.columns, *held = s->held.at;
    double *multiplier = s->multiplier.at, scale = 0.0;
    for (int64_t i = 0; i < nodes; i++)
        scale = larger(scale, fabs(gap[i]));
    for (int64_t trial = 0; trial < TOGETHER + 20 * nodes + 20; trial++) {
        int64_t size = 0, wrong = 0;
        for (int64_t i = 0; i < nodes; i++)
            if (held[i])
                s->active.at[size++] = i;
        if (!solve_active(gap, s, size))
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
                    after += s->response.at[i * nodes + s->active.at[j]]
                             * multiplier[s->active.at[j]];
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

/* Set the forces of a copy from the multipliers and the directions of sliding. */
static void set_forces(const Boundary *b, const BoundaryScratch *s, const double *direction,
                       double *force)
{
    for (int64_t i = 0; i < b->radius.size; i++) {
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
static double turn_directions(const Boundary *b, BoundaryScratch *s, const double *compliance,
                              const double *force, double *direction, double *share, int round)
{
    int64_t nodes = b->radius.size, width = DIRECTIONS * nodes;
    double most = 0.0, along = 0.0, changed = 0.0, *last = s->miss.at;
    for (int64_t i = 0; i < nodes; i++) {
        double slip[2], *d = direction + 2 * i;
        double miss[2] = {0.0, 0.0};
        if (s->multiplier.at[i] > 0.0) {
            for (int k = 0; k < 2; k++) {
                const double *row = compliance + (DIRECTIONS * i + TANGENTIAL + k) * width;
                slip[k] = s->slip.at[DIRECTIONS * i + TANGENTIAL + k];
                for (int64_t j = 0; j < nodes; j++)
                    if (s->multiplier.at[j] > 0.0)
                        for (int64_t n = DIRECTIONS * j; n < DIRECTIONS * (j + 1); n++)
                            slip[k] += row[n] * force[n];
            }
            slip[0] += b->speed * b->radius.at[i] * b->time_step;
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
        double *d = direction + 2 * i;
        double x = d[0] + *share * last[2 * i], y = d[1] + *share * last[2 * i + 1];
        double length = sqrt(x * x + y * y);
        if (s->multiplier.at[i] > 0.0 && length > 0.0) {
            d[0] = x / length;
            d[1] = y / length;
        }
    }
    return most;
}

/* Compute the contact forces of a copy in contact at the end of a step. */
static void contact_forces(const Boundary *b, BoundaryState *state, BoundaryScratch *s,
                           int64_t copy)
{
    int64_t nodes = b->radius.size, width = DIRECTIONS * nodes, solved = 1;
    const double *before = state->force.at + copy * width;
    const double *compliance = b->compliance.at + copy * width * width;
    double *gap = s->gap.at + copy * nodes, *force = s->force.at + copy * width;
    double *direction = state->direction.at + 2 * copy * nodes;
    double change = 1.0, share = 1.0, worst = 0.0, scale = b->gap_scale;
    for (int64_t i = 0; i < nodes; i++)
        s->held.at[i] = gap[i] < 0.0 || before[DIRECTIONS * i + RADIAL] < 0.0;
    for (int round = 0; round < MOST_DIRECTIONS && change > SAME_DIRECTION; round++) {
        respond(b, compliance, direction, round > 0 ? s->multiplier.at : NULL, s);
        solved = solve_normal(gap, s);
        set_forces(b, s, direction, force);
        change = b->full > 0.0 && b->friction > 0.0
                     ? turn_directions(b, s, compliance, force, direction, &share, round)
                     : 0.0;
    }
    for (int64_t i = 0; i < nodes; i++) {
        double after = gap[i], multiplier = s->multiplier.at[i];
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
    double *residual = state->counts.at + BOUNDARY_RESIDUAL;
    *residual = larger(*residual, worst / scale);
    state->counts.at[BOUNDARY_UNSOLVED] += !solved || change > SAME_DIRECTION;
}

/* Add the works of the contact forces of a copy in a step. */
static void contact_works(const Boundary *b, BoundaryState *state, BoundaryScratch *s, int64_t copy,
                          const double *old, const double *new)
{
    int64_t modes = b->contact.columns, width = b->contact.rows;
    const double *before = state->force.at + copy * width, *force = s->force.at + copy * width;
    double *work = state->work.at, *moved = s->moved.at;
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
static void record_boundary(const Boundary *b, BoundaryState *state, BoundaryRecords *r,
                            BoundaryScratch *s, int64_t row, int64_t step, int next)
{
    int64_t modes = b->contact.columns, width = b->contact.rows, copies = b->a.rows;
    int64_t nodes = copies * b->radius.size, all = copies * modes;
    const double *old = state->q.at, *now = old + all, *new = next ? s->q.at : now;
    double span = (next ? 2.0 : 1.0) * b->time_step;
    r->step.at[row] = step;
    r->energy.at[row] = 0.0;
    for (int64_t copy = 0; copy < copies; copy++)
        r->energy.at[row] += copy_energy(b, state, s, copy);
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

/* Advance a copy without contact: compute q_{n+1} and the gaps. Returns whether displacements are
 * within the limit. */
static int advance_copy(const Boundary *b, const Closure *closure, const BoundaryState *state,
                        BoundaryScratch *s, int64_t copy, double time, int loaded)
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
    for (int64_t m = 0; m < modes; m++)
        new[m] = (x[m] * now[m] + y[m] * old[m]) + z[m] * modal[m];
    return free_gaps(b, closure, copy, time + b->time_step, new,
                     s->gap.at + copy * b->radius.size);
}

/* Compute contact of a copy at the end of a step, and add works and impulses. Returns whether the
 * copy is in contact. */
static int touch_copy(const Boundary *b, BoundaryState *state, BoundaryScratch *s, int64_t copy)
{
    int64_t modes = b->contact.columns, nodes = b->radius.size, width = b->contact.rows;
    int64_t first = copy * modes;
    const double *old = state->q.at + first, *now = old + b->a.rows * modes;
    const double *gap = s->gap.at + copy * nodes;
    double *new = s->q.at + first, *force = s->force.at + copy * width;
    double *before = state->force.at + copy * width;
    int touching = 0, touched = 0;
    for (int64_t i = 0; i < nodes; i++) {
        touching |= gap[i] < 0.0;
        touched |= before[DIRECTIONS * i + RADIAL] < 0.0;
    }
    for (int64_t i = 0; i < width; i++)
        force[i] = 0.0;
    if (touching || touched) {
        for (int64_t m = 0; m < modes; m++)
            s->change.at[m] = new[m] - now[m];
        for (int64_t i = 0; i < width; i++)
            s->moved.at[i] = 0.0;
        add_rows(s->change.at, b->columns.at, modes, width, s->moved.at);
    }
    if (touching) {
        for (int64_t i = 0; i < width; i++)
            s->slip.at[i] = 0.0;
        if (b->massless > 0.0)
            add_rows(before, b->compliance.at + copy * width * width, width, width, s->slip.at);
        for (int64_t i = 0; i < width; i++)
            s->slip.at[i] = s->moved.at[i] - s->slip.at[i];
        contact_forces(b, state, s, copy);
        if (!(b->massless > 0.0)) {
            for (int64_t m = 0; m < modes; m++)
                s->modal.at[m] = 0.0;
            add_rows(force, b->contact.at, width, modes, s->modal.at);
            for (int64_t m = 0; m < modes; m++)
                new[m] += b->c.at[first + m] * s->modal.at[m];
        }
    }
    if (touching || touched)
        contact_works(b, state, s, copy, old, new);
    return touching;
}

/* Add the works of loads and damping in a step. */
static void modal_works(const Boundary *b, BoundaryState *state, const BoundaryScratch *s,
                        int loaded)
{
    int64_t all = b->a.rows * b->a.columns;
    const double *old = state->q.at, *new = s->q.at;
    double lost = 0.0, done = 0.0;
    for (int64_t i = 0; i < all; i++) {
        double moved = 0.5 * (new[i] - old[i]);
        lost += b->damping.at[i] * moved * moved;
    }
    if (loaded)
        for (int64_t p = 0; p < b->load.layers; p++)
            for (int64_t i = 0; i < all; i++)
                done += s->amplitude.at[p] * b->load.at[p * all + i] * 0.5 * (new[i] - old[i]);
    state->work.at[DAMPING] += lost / b->time_step;
    state->work.at[EXTERNAL] += done;
}

int boundary_march(const Boundary *boundary, const Closure *closure, BoundaryState *state,
                   BoundaryRecords *records, BoundaryScratch *scratch, int64_t step, int64_t steps,
                   int64_t record_every, int64_t *reached)
{
    const Boundary *b = boundary;
    int64_t copies = b->a.rows, all = copies * b->a.columns, nodes = b->radius.size;
    int64_t width = b->contact.rows, last = step + steps, rows = 0;
    for (; step < last; step++) {
        double time = (double)step * b->time_step;
        int loaded = load_amplitudes(&b->load_times, time, scratch->amplitude.at), within = 1;
        int touching = 0;
        for (int64_t copy = 0; copy < copies; copy++)
            within &= advance_copy(b, closure, state, scratch, copy, time, loaded);
        if (!within) {
            record_boundary(b, state, records, scratch, rows++, step, 0);
            break;
        }
        double works[WORKS];
        for (int i = 0; i < WORKS; i++)
            works[i] = state->work.at[i];
        for (int64_t copy = 0; copy < copies; copy++)
            touching |= touch_copy(b, state, scratch, copy);
        if (step % record_every == 0) { /* the record is from before the works of this step */
            double after[WORKS];
            for (int i = 0; i < WORKS; i++) {
                after[i] = state->work.at[i];
                state->work.at[i] = works[i];
            }
            record_boundary(b, state, records, scratch, rows++, step, 1);
            for (int i = 0; i < WORKS; i++)
                state->work.at[i] = after[i];
        }
        modal_works(b, state, scratch, loaded);
        state->counts.at[BOUNDARY_CONTACT_STEPS] += touching;
        for (int64_t copy = 0; copy < copies; copy++) {
            const double *force = scratch->force.at + copy * width;
            for (int64_t i = 0; i < nodes; i++) {
                int64_t at = copy * nodes + i;
                double normal = -force[DIRECTIONS * i + RADIAL], gap = scratch->gap.at[at];
                state->gap.at[at] = smaller(state->gap.at[at], gap);
                state->touched.at[at] += normal > 0.0;
                state->impulse.at[copy * width + DIRECTIONS * i] += normal * b->time_step;
                for (int k = TANGENTIAL; k <= AXIAL; k++)
                    state->impulse.at[copy * width + DIRECTIONS * i + k] +=
                        force[DIRECTIONS * i + k] * b->time_step;
            }
        }
        for (int64_t i = 0; i < copies * width; i++)
            state->force.at[i] = scratch->force.at[i];
        for (int64_t i = 0; i < all; i++) {
            state->q.at[i] = state->q.at[all + i];
            state->q.at[all + i] = scratch->q.at[i];
        }
    }
    reached[0] = step;
    reached[1] = rows;
    return step < last ? DIVERGED : RUNNING;
}
