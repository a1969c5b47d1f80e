/* Friction joints between contact nodes without mass, at the end of a step.
 *
 * A joint ties pairs of nodes of neighbouring blades. With the displacements d of a pair along its normal
 * and two tangents, its gap g = g_0 + d_n, and its forces l on the left node, -l on the right one,
 *
 *     d = d_free + W l,    0 <= l_n  perp  g >= 0,    |l_t| <= mu l_n,    l_t opposes the slip s
 *
 * with the slip s = d_t - d_t,n of the step. The modes feel the mean 0.4 l_{n+1} + 0.3 l_n + 0.2 l_{n-1} +
 * 0.1 l_{n-2} of the forces as those of step n, which is exact to second order. It makes the stiffest
 * joints stable at any time step: with w(z) for this mean of a motion z^n, Im w(z) >= 0 at z = exp(i phi),
 * 0 <= phi <= pi, and w(-1) <= 0, so that joints take energy from every motion, with a damping ratio of
 * 0.05 phi^3; the roots of w have absolute values below 0.75, so that forces of rigid joints do not
 * oscillate. W is the residual flexibility of the nodes and 0.4 times the response of the modes. The natural map of Alart and Curnier (1991),
 * p = l_n - g / soft and tau = l_t - s / soft, tells the state of a pair: open (p <= 0), stuck
 * (|tau| <= mu p) or slipping, with the direction e of tau. A step of Newton's method solves
 *
 *     stuck:    g = 0, s = 0
 *     slipping: g = 0, l_t - mu l_n e - a (1 - e e^T) (l_t - s / soft) = 0,    a = mu p / |tau|
 *
 * for all closed pairs. If the states do not settle, projected relaxation pair by pair finds a better
 * start. Pairs also move with the forces of the wall on the same blade; both are solved in turn.
 *
 * A pair may touch a body in place of a second blade, a damper: a point mass that moves as the modes do,
 * with a centrifugal force.
 *
 * The work of a pair in a step is that of the force that acts on the modes, (d_{n+1} - d_{n-1}) / 2 of the
 * modes times this mean, and half of l_{n+1} + l_n times the change of the rest of d; load patterns that
 * move pairs through the modes left out do the work of their mean factors.
 */
#ifndef JOINTS_H
#define JOINTS_H

#include "complementarity.h"
#include "gaps.h"

enum { JOINT_STEPS = 25, RELAXATIONS = 300, JOINT_ROUNDS = 8 };
enum { TURNS = 200 };       /* solutions of joints and wall in turn */
#define JOINT_ERROR 1e-12   /* error of a solution, relative to the displacements */
#define SAME_FORCES 1e-12   /* change of the forces of the wall at which turns end, relative to all */
#define REGULAR 1e-9        /* change of the diagonal of the equations in a step of Newton's method */

/* Add displacements of nodes in a direction to those of pairs. */
static void add_pairs(const Joints *joints, int direction, const double *moved, double *out)
{
    for (int64_t end = 0; end < joints->node.size; end++) {
        if (joints->node.at[end] < 0)
            continue;
        const double *axes = joints->axes.at + DIRECTIONS * DIRECTIONS * end + direction;
        double *to = out + DIRECTIONS * (end / 2), by = moved[joints->node.at[end]];
        for (int k = 0; k < DIRECTIONS; k++)
            to[k] += axes[DIRECTIONS * k] * by;
    }
}

/* Subtract displacements of bodies from those of pairs. */
static void subtract_bodies(const Joints *joints, const double *moved, double *out)
{
    for (int64_t pair = 0; pair < joints->body.size; pair++) {
        const double *axes = joints->body_axes.at + DIRECTIONS * DIRECTIONS * pair;
        for (int k = 0; joints->body.at[pair] >= 0 && k < DIRECTIONS; k++)
            for (int direction = 0; direction < DIRECTIONS; direction++)
                out[DIRECTIONS * pair + k] -= axes[DIRECTIONS * k + direction]
                                              * moved[DIRECTIONS * joints->body.at[pair] + direction];
    }
}

/* Move bodies by a part of the forces of joints, which act on the blades. */
static void push_bodies_by(const March *m, const double *force, double part)
{
    const Joints *joints = m->stage.joints;
    JointScratch *s = &m->scratch->joints;
    double dt = m->stage.numbers->time_step;
    for (int64_t i = 0; i < s->body.size; i++)
        s->pushed.at[i] = 0.0;
    for (int64_t pair = 0; s->body.size > 0 && pair < joints->body.size; pair++) {
        const double *axes = joints->body_axes.at + DIRECTIONS * DIRECTIONS * pair;
        for (int k = 0; joints->body.at[pair] >= 0 && k < DIRECTIONS; k++)
            for (int direction = 0; direction < DIRECTIONS; direction++)
                s->pushed.at[DIRECTIONS * joints->body.at[pair] + direction] +=
                    axes[DIRECTIONS * k + direction] * force[DIRECTIONS * pair + k];
    }
    for (int64_t i = 0; i < s->body.size; i++)
        s->body.at[i] -= part * dt * dt * joints->mobility.at[i] * s->pushed.at[i];
}

/* Compute the displacements of bodies at the end of the step without forces of joints of step n + 1. */
static void predict_bodies(const March *m)
{
    const Joints *joints = m->stage.joints;
    const State *state = m->state;
    JointScratch *s = &m->scratch->joints;
    double dt = m->stage.numbers->time_step;
    const double *old = state->bodies.at, *now = old + s->body.size;
    for (int64_t i = 0; i < s->body.size; i++)
        s->body.at[i] = 2.0 * now[i] - old[i] + dt * dt * joints->mobility.at[i] * joints->pull.at[i];
    for (int64_t past = 0; past < state->joint_force.rows; past++)
        push_bodies_by(m, state->joint_force.at + past * state->joint_force.columns,
                       JOINT_PARTS[past + 1]);
}

/* Compute the displacements of the pairs at the end of the step without contact forces of step n + 1, and
 * keep those of the modes and of the wall's nodes. */
static void free_pairs(const March *m, int64_t step)
{
    const Joints *joints = m->stage.joints;
    JointScratch *s = &m->scratch->joints;
    FieldScratch *f = &m->scratch->fields;
    double *out = s->free.at, later = (double)(step + 1) * m->stage.numbers->time_step;
    int64_t values = s->free.size;
    for (int64_t i = 0; i < s->predicted.size; i++)
        s->predicted.at[i] = m->x.new[i];
    for (int64_t n = 0; n < f->element.size; n++) {
        s->radial.at[n] = f->radial.at[n];
        s->gap.at[n] = f->free_gap.at[n];
    }
    for (int64_t i = 0; i < values; i++) {
        out[i] = 0.0;
        s->force.at[i] = m->state->joint_force.at[i];
    }
    add_pairs(joints, RADIAL, f->radial.at, out);
    for (int direction = TANGENTIAL; direction < DIRECTIONS; direction++) {
        node_field(m->stage.rotor, direction, m->x.new, NULL, f, f->moved.at);
        add_pairs(joints, direction, f->moved.at, out);
    }
    predict_bodies(m);
    subtract_bodies(joints, s->body.at, out);
    for (int64_t i = 0; i < values; i++)
        s->modal.at[i] = out[i];
    Rotation ahead = next_rotation(m->stage.speed, &m->rotation);
    load_amplitudes(&m->stage.numbers->loads, m->stage.speed, &ahead, later, s->amplitude.at);
    for (int64_t p = 0; p < joints->given.rows; p++)
        for (int64_t i = 0; i < values; i++)
            out[i] += s->amplitude.at[p] * joints->given.at[p * values + i];
}

/* Compute the displacements of the pairs with the forces of the wall, but without those of joints. */
static void wall_pairs(const March *m, int pushed)
{
    JointScratch *s = &m->scratch->joints;
    FieldScratch *f = &m->scratch->fields;
    for (int64_t i = 0; i < s->base.size; i++)
        s->base.at[i] = s->free.at[i];
    for (int direction = 0; pushed && direction < DIRECTIONS; direction++) {
        for (int64_t n = 0; n < f->element.size; n++)
            f->moved.at[n] = 0.0;
        add_flexible(m->stage.rotor, direction, NULL, m->scratch->nodes.force.at, 1.0, f->moved.at);
        add_pairs(m->stage.joints, direction, f->moved.at, s->base.at);
    }
}

/* Add the displacements of the pairs due to the forces of joints and a flexibility. */
static void add_moved(const Matrix *w, const double *force, double *out)
{
    for (int64_t j = 0; j < w->rows; j++) {
        Lanes by = splat(force[j]);
        for (int64_t i = 0; i < w->columns && force[j] != 0.0; i += LANES)
            store(out + i, muladd(load(w->at + j * w->columns + i), by, load(out + i)));
    }
}

/* Compute the displacements of the pairs with all forces. */
static void move_pairs(const March *m)
{
    JointScratch *s = &m->scratch->joints;
    for (int64_t i = 0; i < s->force.size; i++)
        s->moved.at[i] = s->base.at[i];
    add_moved(&m->stage.joints->compliance, s->force.at, s->moved.at);
}

/* Compute the trial forces of a pair: p, then tau. */
static void trial_of(const March *m, int64_t pair, double trial[DIRECTIONS])
{
    const Joints *joints = m->stage.joints;
    const JointScratch *s = &m->scratch->joints;
    const double *force = s->force.at + DIRECTIONS * pair, *moved = s->moved.at + DIRECTIONS * pair;
    const double *place = m->state->joint_place.at + DIRECTIONS * pair;
    double stiff = 1.0 / joints->soft.at[pair];
    trial[0] = force[0] - (joints->gap.at[pair] + moved[0]) * stiff;
    for (int k = 1; k < DIRECTIONS; k++)
        trial[k] = force[k] - (moved[k] - place[k]) * stiff;
}

/* Find the states of all pairs. Returns the largest error of the equations of these states relative to
 * the displacements; `changed` gets whether a state differs from the last one. */
static double find_states(const March *m, int *changed)
{
    const Joints *joints = m->stage.joints;
    JointScratch *s = &m->scratch->joints;
    double worst = 0.0, scale = 1e-300;
    *changed = 0;
    for (int64_t pair = 0; pair < s->state.size; pair++) {
        const double *force = s->force.at + DIRECTIONS * pair, *moved = s->moved.at + DIRECTIONS * pair;
        const double *place = m->state->joint_place.at + DIRECTIONS * pair;
        double trial[DIRECTIONS], *e = s->direction.at + 2 * pair, soft = joints->soft.at[pair];
        trial_of(m, pair, trial);
        double size = hypot(trial[1], trial[2]), limit = joints->friction.at[pair] * trial[0];
        int64_t state = trial[0] <= 0.0 ? JOINT_OPEN : size <= limit ? JOINT_STUCK : JOINT_SLIPPING;
        double error = 0.0, gap = joints->gap.at[pair] + moved[0];
        scale = larger(scale, larger(soft * fabs(force[0]), fabs(joints->gap.at[pair])));
        for (int k = 0; k < DIRECTIONS; k++)
            scale = larger(scale, fabs(s->base.at[DIRECTIONS * pair + k]));
        if (state == JOINT_OPEN)
            for (int k = 0; k < DIRECTIONS; k++)
                error = larger(error, soft * fabs(force[k]));
        else
            error = fabs(gap);
        for (int k = 1; k < DIRECTIONS && state != JOINT_OPEN; k++) {
            if (state == JOINT_SLIPPING)
                e[k - 1] = trial[k] / size;
            error = larger(error, state == JOINT_STUCK
                                      ? fabs(moved[k] - place[k])
                                      : soft * fabs(force[k] - joints->friction.at[pair] * force[0] * e[k - 1]));
        }
        s->share.at[pair] = state == JOINT_SLIPPING ? limit / size : 1.0;
        *changed |= s->state.at[pair] != state;
        s->state.at[pair] = state;
        worst = larger(worst, error);
    }
    return worst / scale;
}

/* Solve the linearised equations of the states. Returns 0 if they are singular. */
static int step_joints(const March *m)
{
    const Joints *joints = m->stage.joints;
    const Matrix *w = &joints->compliance;
    JointScratch *s = &m->scratch->joints;
    ContactScratch *c = &s->system;
    int64_t width = c->system.columns, size = 0, *closed = s->closed.at;
    for (int64_t pair = 0; pair < s->state.size; pair++)
        for (int k = 0; k < DIRECTIONS; k++) {
            if (s->state.at[pair] == JOINT_OPEN)
                s->force.at[DIRECTIONS * pair + k] = 0.0;
            else
                closed[size++] = DIRECTIONS * pair + k;
        }
    if (size == 0)
        return 1;
    double *right = c->system.at + size * width;
    for (int64_t j = 0; j < size; j++) {
        double *column = c->system.at + j * width;
        const double *from = w->at + closed[j] * w->columns;
        for (int64_t i = 0; i < size; i++)
            column[i] = from[closed[i]];
        for (int64_t i = size; i < padded(size); i++)
            column[i] = 0.0;
    }
    for (int64_t i = 0; i < padded(size); i++)
        right[i] = 0.0;
    for (int64_t i = 0; i < size; i += DIRECTIONS) {
        int64_t pair = closed[i] / DIRECTIONS;
        double soft = joints->soft.at[pair], regular = REGULAR * soft;
        const double *base = s->base.at + closed[i], *force = s->force.at + closed[i];
        const double *place = m->state->joint_place.at + closed[i], *e = s->direction.at + 2 * pair;
        right[i] = -(base[0] + joints->gap.at[pair]);
        right[i + 1] = place[1] - base[1];
        right[i + 2] = place[2] - base[2];
        for (int k = 0; k < DIRECTIONS; k++) {
            right[i + k] += regular * force[k];
            c->system.at[(i + k) * width + i + k] += regular;
        }
        if (s->state.at[pair] == JOINT_STUCK)
            continue;
        double share = s->share.at[pair], aside[2] = {-e[1], e[0]};
        for (double *column = c->system.at + i + 1; column <= right + i + 1; column += width) {
            double across = share * (aside[0] * column[0] + aside[1] * column[1]);
            column[0] = aside[0] * across;
            column[1] = aside[1] * across;
        }
        for (int k = 0; k < 2; k++) {
            c->system.at[i * width + i + 1 + k] -= soft * joints->friction.at[pair] * e[k];
            for (int l = 0; l < 2; l++)
                c->system.at[(i + 1 + l) * width + i + 1 + k] +=
                    soft * ((k == l) - share * aside[k] * aside[l]);
        }
    }
    if (!eliminate(c, size))
        return 0;
    for (int64_t i = 0; i < size; i++)
        s->force.at[closed[i]] = c->solution.at[i];
    return 1;
}

/* Approach the forces by projected relaxation, pair by pair. */
static void relax_joints(const March *m)
{
    const Joints *joints = m->stage.joints;
    const Matrix *w = &joints->compliance;
    JointScratch *s = &m->scratch->joints;
    for (int round = 0; round < RELAXATIONS; round++)
        for (int64_t pair = 0; pair < s->state.size; pair++) {
            double trial[DIRECTIONS], *force = s->force.at + DIRECTIONS * pair;
            trial_of(m, pair, trial);
            double size = hypot(trial[1], trial[2]), normal = larger(0.0, trial[0]);
            double limit = joints->friction.at[pair] * normal;
            double share = size > limit ? limit / size : 1.0;
            for (int k = 0; k < DIRECTIONS; k++) {
                double change = (k == 0 ? normal : share * trial[k]) - force[k];
                const double *row = w->at + (DIRECTIONS * pair + k) * w->columns;
                force[k] += change;
                for (int64_t i = 0; i < w->columns; i += LANES)
                    store(s->moved.at + i,
                          muladd(load(row + i), splat(change), load(s->moved.at + i)));
            }
        }
}

/* Solve the forces of the joints from `base`. Returns whether this succeeded. */
static int solve_joints(const March *m)
{
    JointScratch *s = &m->scratch->joints;
    int changed;
    for (int round = 0; round < JOINT_ROUNDS; round++) {
        move_pairs(m);
        double error = find_states(m, &changed);
        for (int step = 0; step < JOINT_STEPS; step++) {
            if (!step_joints(m))
                break;
            move_pairs(m);
            error = find_states(m, &changed);
            if (!changed && error <= JOINT_ERROR)
                return 1;
        }
        relax_joints(m);
    }
    move_pairs(m);
    return find_states(m, &changed) <= JOINT_ERROR;
}

/* Distribute the forces of the joints to the nodes, and compute x_{n+1} and the gaps at the wall with them.
 */
static void push_nodes(const March *m)
{
    const Rotor *rotor = m->stage.rotor;
    JointScratch *s = &m->scratch->joints;
    FieldScratch *f = &m->scratch->fields;
    double *out = s->on_nodes.at;
    for (int64_t i = 0; i < s->predicted.size; i++)
        m->x.new[i] = s->predicted.at[i];
    for (int64_t i = 0; i < s->on_nodes.rows * s->on_nodes.columns; i++)
        out[i] = 0.0;
    spread_joints(m->stage.joints, s->force.at, JOINT_PARTS[0], out);
    add_response(m, out, m->stage.gyroscopic);
    for (int64_t i = 0; i < s->on_nodes.rows * s->on_nodes.columns; i++)
        out[i] /= JOINT_PARTS[0];
    node_field(rotor, RADIAL, m->x.new, NULL, f, f->radial.at);
    add_flexible(rotor, RADIAL, NULL, out, 1.0, f->radial.at);
    for (int64_t n = 0; n < f->element.size; n++)
        f->free_gap.at[n] = s->gap.at[n] - (f->radial.at[n] - s->radial.at[n]);
}

/* Add the sums and works of an accepted step, and take its forces and displacements over. */
static void account_joints(const March *m)
{
    const Joints *joints = m->stage.joints;
    JointScratch *s = &m->scratch->joints;
    State *state = m->state;
    int64_t values = s->force.size;
    double *last[3], *place = state->joint_place.at, given = 0.0;
    double *modes = place + values, *earlier = modes + values;
    for (int past = 0; past < 3; past++)
        last[past] = state->joint_force.at + past * values;
    add_moved(&joints->modal, s->force.at, s->modal.at);
    for (int64_t p = 0; p < joints->given.rows; p++) {
        double mean = 0.5 * (m->scratch->amplitude.at[p] + s->amplitude.at[p]), sum = 0.0;
        for (int64_t i = 0; i < values; i++)
            sum += joints->given.at[p * values + i] * (s->force.at[i] - last[0][i]);
        given += mean * sum;
    }
    state->work.at[EXTERNAL] += given;
    for (int64_t pair = 0; pair < s->state.size; pair++) {
        double *sums = state->joint_sums.at + pair * JOINT_SUMS, slip[DIRECTIONS];
        for (int k = 0; k < DIRECTIONS; k++) {
            int64_t i = DIRECTIONS * pair + k;
            double force = s->force.at[i], acting = JOINT_PARTS[0] * force;
            for (int past = 0; past < 3; past++)
                acting += JOINT_PARTS[past + 1] * last[past][i];
            slip[k] = s->moved.at[i] - place[i];
            double rest = slip[k] - (s->modal.at[i] - modes[i]);
            sums[JOINT_WORK] -= 0.5 * (acting * (s->modal.at[i] - earlier[i])
                                       + (force + last[0][i]) * rest);
            if (k > 0)
                sums[JOINT_WEAR] -= force * slip[k];
        }
        sums[s->state.at[pair]] += 1.0;
        if (s->state.at[pair] == JOINT_SLIPPING)
            sums[JOINT_SLIP] += hypot(slip[1], slip[2]);
    }
    push_bodies_by(m, s->force.at, JOINT_PARTS[0]);
    for (int64_t i = 0; i < s->body.size; i++) {
        state->bodies.at[i] = state->bodies.at[s->body.size + i];
        state->bodies.at[s->body.size + i] = s->body.at[i];
    }
    for (int64_t i = 0; i < values; i++) {
        last[2][i] = last[1][i];
        last[1][i] = last[0][i];
        last[0][i] = s->force.at[i];
        place[i] = s->moved.at[i];
        earlier[i] = modes[i];
        modes[i] = s->modal.at[i];
    }
}

/* Return the energy of bodies half a step before step n: of their motion, and in the centrifugal field. */
static double body_energy(const March *m)
{
    const Joints *joints = m->stage.joints;
    const double *old = m->state->bodies.at, *now = old + m->state->bodies.columns;
    double energy = 0.0, dt = m->stage.numbers->time_step;
    for (int64_t i = 0; i < m->state->bodies.columns; i++) {
        double rate = (now[i] - old[i]) / dt, mobility = joints->mobility.at[i];
        energy -= 0.5 * joints->pull.at[i] * (now[i] + old[i]);
        energy += mobility > 0.0 ? 0.5 * rate * rate / mobility : 0.0;
    }
    return energy;
}

/* Return half of the displacements of the joints without their part in modes and bodies times their
 * forces, the energy of the load patterns in the joints at step n, and that of bodies. */
static double joint_energy(const March *m)
{
    const Joints *joints = m->stage.joints;
    const State *state = m->state;
    int64_t values = state->joint_force.columns;
    const double *force = state->joint_force.at, *place = state->joint_place.at;
    double energy = 0.5 * (dot(force, place, values) - dot(force, place + values, values));
    energy += body_energy(m);
    for (int64_t p = 0; p < joints->given.rows; p++)
        energy += 0.5 * m->scratch->amplitude.at[p]
                  * dot(joints->given.at + p * values, force, values);
    return energy;
}

/* Record forces, displacements and sums of the joints, and begin new sums of steps. */
static void record_joints(const March *m, Records *records, int64_t row)
{
    State *state = m->state;
    int64_t values = state->joint_force.columns, pairs = values / DIRECTIONS;
    for (int64_t i = 0; i < values; i++) {
        records->joint_force.at[row * values + i] = state->joint_force.at[i];
        records->joint_place.at[row * values + i] = state->joint_place.at[i];
    }
    for (int64_t i = 0; i < state->bodies.columns; i++)
        records->bodies.at[row * state->bodies.columns + i] = state->bodies.at[state->bodies.columns + i];
    for (int64_t i = 0; i < pairs * JOINT_SUMS; i++)
        records->joint_sums.at[row * pairs * JOINT_SUMS + i] = state->joint_sums.at[i];
    for (int64_t i = 0; i < pairs * JOINT_SUMS; i++)
        if (i % JOINT_SUMS <= JOINT_SLIPPING)
            state->joint_sums.at[i] = 0.0;
}

#endif
