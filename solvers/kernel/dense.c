/* A step of the dense schemes: first velocities without contact, then impulses at the tips.
 *
 * With theta = 1/2, unit masses and A = 1 + h C / 2 + h^2 K / 4, the velocities without contact are
 *
 *     A v_f = v_n - h C v_n / 2 - h K (x_n + h v_n / 4) + h f
 *
 * K is the stiffness of the bodies and C is the matrix of damping and Coriolis forces. f, at half
 * the step, contains loads, forces of springs that act in both frames, and forces of static
 * dampers. With the impulses P at the tips,
 *
 *     v_{n+1} = v_f + A^-1 (B_N P_N + B_T P_T),     x_{n+1} = x_n + h (v_n + v_{n+1}) / 2.
 *
 * The energy then changes by exactly the work of all forces. For both contact laws, P is computed
 * tip by tip until no impulse changes (projected Gauss-Seidel); see `solvers.march.dense`.
 */
#include "motion.h"

enum { MOST_ROUNDS = 2000 }; /* largest number of Gauss-Seidel iterations */
#define CLOSE 1e-12          /* change, over the largest velocity, at which iterations end */

/* The wall at one time. */
typedef struct {
    const Closure *closure; /* NULL if the clearance is constant */
    double closed, rate;    /* closure [m] and its rate of change [m/s] */
} Wall;

static Wall wall_at(const Closure *closure, double time)
{
    Wall wall = {closure, 0.0, 0.0};
    if (closure)
        wall.closed = closure_at(closure, time, &wall.rate);
    return wall;
}

/* Compute C v, in which Coriolis forces do no work. */
static void velocity_force(const DenseStage *stage, const double *v, double *out)
{
    int64_t modes = stage->damping.size, coupled = stage->by_velocity.rows;
    for (int64_t i = 0; i < modes; i++)
        out[i] = stage->damping.at[i] * v[i];
    for (int64_t m = 0; m < stage->dampers.rows; m++) {
        const double *row = stage->dampers.at + m * modes;
        double stroke = dot(row, v, modes);
        for (int64_t i = 0; i < modes; i++)
            out[i] += row[i] * stroke;
    }
    for (int64_t i = 0; i < coupled; i++)
        out[i] += dot(stage->by_velocity.at + i * coupled, v, coupled);
}

/* Add the force of springs that act in both frames. Returns their energy x^T K x / 2. */
static double turning_force(const DenseStage *stage, double angle, const double *x, double *out)
{
    int64_t size = stage->coupled.size, *coupled = stage->coupled.at;
    double energy = 0.0;
    for (int64_t n = 0; n < stage->turning_cos.layers; n++) {
        double c = cos((double)n * angle), s = sin((double)n * angle);
        const double *by_cos = stage->turning_cos.at + n * size * size;
        const double *by_sin = stage->turning_sin.at + n * size * size;
        for (int64_t i = 0; i < size; i++) {
            double force = 0.0;
            for (int64_t j = 0; j < size; j++)
                force -= (c * by_cos[i * size + j] + s * by_sin[i * size + j]) * x[coupled[j]];
            energy -= 0.5 * force * x[coupled[i]];
            if (out)
                out[coupled[i]] += force;
        }
    }
    return energy;
}

/* Compute the force of the loads. */
static void load_force(const DenseStage *stage, double time, double *out)
{
    int64_t modes = stage->loads.columns;
    for (int64_t i = 0; i < stage->stiffness.size; i++)
        out[i] = 0.0;
    for (int64_t n = 0; n < stage->loads.rows; n++) {
        const double *t = stage->load_times.at + n * LOAD_NUMBERS;
        if (time >= t[LOAD_END])
            continue;
        double rise = time < t[LOAD_RAMP] ? 0.5 - 0.5 * cos(PI * time / t[LOAD_RAMP]) : 1.0;
        double factor = rise * cos(t[LOAD_FREQUENCY] * time + t[LOAD_PHASE]);
        for (int64_t i = 0; i < modes; i++)
            out[i] += factor * stage->loads.at[n * modes + i];
    }
}

/* Add the force of static dampers at the centre. */
static void circulation_force(const DenseStage *stage, const double *x, double *out)
{
    int64_t modes = stage->stiffness.size;
    const double *across = stage->centre.at, *up = across + modes;
    double swing_x = stage->circulation * dot(across, x, modes);
    double swing_y = stage->circulation * dot(up, x, modes);
    for (int64_t i = 0; i < modes; i++)
        out[i] += swing_y * across[i] - swing_x * up[i];
}

/* Compute v_f, the velocities after a step under a force without contact. */
static void free_velocity(const DenseStage *stage, double h, const DenseState *state, double *force,
                          double *momentum, double *out)
{
    int64_t modes = stage->stiffness.size;
    const double *x = state->displacement.at, *v = state->velocity.at;
    velocity_force(stage, v, momentum);
    for (int64_t i = 0; i < modes; i++) {
        double restoring = stage->stiffness.at[i] * (x[i] + 0.25 * h * v[i]);
        momentum[i] = v[i] - 0.5 * h * momentum[i] + h * (force[i] - restoring);
    }
    for (int64_t i = 0; i < modes; i++)
        out[i] = dot(stage->inverse.at + i * modes, momentum, modes);
}

/* Return the casing element under a tip; `xi` gets the position along the element, 0 to 1. */
static int64_t tip_place(const DenseStage *stage, int64_t tip, double turn, const double *x,
                         double *xi)
{
    int64_t modes = stage->tip_radial.columns, nodes = stage->nodal.layers;
    double angle = stage->tip_angle.at[tip] + turn;
    if (stage->follows != 0.0)
        angle += dot(stage->tip_tangential.at + tip * modes, x, modes) / stage->tip_radius;
    double at = fmod(angle * (double)nodes / (2.0 * PI), (double)nodes);
    if (at < 0.0)
        at += (double)nodes;
    if (!(at >= 0.0 && at <= (double)nodes)) /* not a number: the march ends */
        at = 0.0;
    *xi = at - floor(at);
    return (int64_t)at % nodes;
}

/* Compute the cubic Hermite functions, and (`slope_weights`) their derivatives along the
 * element. */
static void value_weights(double xi, double length, double weight[4])
{
    double rest = 1.0 - xi;
    weight[0] = rest * rest * (1.0 + 2.0 * xi);
    weight[1] = length * xi * rest * rest;
    weight[2] = xi * xi * (3.0 - 2.0 * xi);
    weight[3] = -length * xi * xi * rest;
}

static void slope_weights(double xi, double length, double weight[4])
{
    double rest = 1.0 - xi, steep = 6.0 * xi * rest / length;
    weight[0] = -steep;
    weight[1] = rest * (1.0 - 3.0 * xi);
    weight[2] = steep;
    weight[3] = xi * (3.0 * xi - 2.0);
}

/* Fill a row with w (kind 0) or u (kind 2) of all casing modes under a tip. Returns the clearance
 * there, interpolated with the same weights. */
static double under_tip(const DenseStage *stage, int64_t element, const double *weight,
                        int64_t kind, double *row)
{
    int64_t modes = stage->nodal.columns, after = (element + 1) % stage->nodal.layers;
    const double *here = stage->nodal.at + (4 * element + kind) * modes;
    const double *there = stage->nodal.at + (4 * after + kind) * modes;
    const double *near = stage->clearance.at + 2 * element, *far = stage->clearance.at + 2 * after;
    for (int64_t i = 0; i < modes; i++)
        row[i] = weight[0] * here[i] + weight[1] * here[modes + i] + weight[2] * there[i]
                 + weight[3] * there[modes + i];
    return weight[0] * near[0] + weight[1] * near[1] + weight[2] * far[0] + weight[3] * far[1];
}

/* Return the share of the closure above a tip, or its slope, depending on the weights. */
static double closure_share(const Closure *closure, int64_t element, const double *weight)
{
    const double *value = closure->share.at + element, *slope = value + closure->share.columns;
    return weight[0] * value[0] + weight[1] * slope[0] + weight[2] * value[1]
           + weight[3] * slope[1];
}

/* Return the gap of a tip, and fill its row of B_N. */
static double tip_gap(const DenseStage *stage, Wall wall, int64_t tip, double turn,
                      const double *x, double *row)
{
    int64_t modes = stage->tip_radial.columns;
    double xi, weight[4];
    int64_t element = tip_place(stage, tip, turn, x, &xi);
    value_weights(xi, stage->element_length, weight);
    for (int64_t i = 0; i < modes; i++)
        row[i] = -stage->tip_radial.at[tip * modes + i];
    double clearance = under_tip(stage, element, weight, W_KIND, row + modes);
    if (wall.closure)
        clearance -= wall.closed * closure_share(wall.closure, element, weight);
    return clearance + stage->tip_recess.at[tip] + dot(row, x, stage->stiffness.size);
}

/* Return the rate of change of the gap due to the closure and due to the slope of the casing along
 * which the tip moves, and fill its row of B_T. */
static double tip_sliding(const DenseStage *stage, Wall wall, int64_t tip, double turn,
                          const double *x, const double *v, double *row)
{
    int64_t modes = stage->tip_radial.columns;
    const double *tangential = stage->tip_tangential.at + tip * modes;
    double xi, weight[4], rate = stage->speed;
    int64_t element = tip_place(stage, tip, turn, x, &xi);
    if (stage->follows != 0.0)
        rate += dot(tangential, v, modes) / stage->tip_radius;
    slope_weights(xi, stage->element_length, weight);
    double slope = under_tip(stage, element, weight, W_KIND, row + modes);
    slope += dot(row + modes, x + modes, stage->nodal.columns);
    if (wall.closure)
        slope -= wall.closed * closure_share(wall.closure, element, weight);
    for (int64_t i = 0; i < modes; i++)
        row[i] = -tangential[i];
    value_weights(xi, stage->element_length, weight);
    under_tip(stage, element, weight, U_KIND, row + modes);
    rate *= (double)stage->nodal.layers * stage->element_length / (2.0 * PI) * slope;
    return wall.closure ? rate - wall.rate * closure_share(wall.closure, element, weight) : rate;
}

/* Update the normal impulse of a tip (law of Moreau and Jean). Returns the change as a velocity. */
static double press(const DenseLaw *law, DenseScratch *s, int64_t tips, int64_t tip)
{
    const double *w = s->compliance.at + tip * 2 * tips;
    double rebound = -law->restitution * smaller(s->before.at[tip], 0.0), old = s->impulse.at[tip];
    if (law->penalty != 0.0 || !(w[tip] > 0.0))
        return 0.0;
    double speed = s->free.at[tip] + dot(w, s->impulse.at, 2 * tips) - rebound;
    s->impulse.at[tip] = larger(0.0, old - speed / w[tip]);
    return w[tip] * fabs(s->impulse.at[tip] - old);
}

/* Update the tangential impulse of a tip (both laws). Returns the change as a velocity. */
static double rub(const DenseLaw *law, DenseScratch *s, int64_t tips, int64_t tip)
{
    int64_t row = tips + tip;
    const double *w = s->compliance.at + row * 2 * tips;
    double most = law->friction * s->impulse.at[tip], free = s->free.at[row];
    double old = s->impulse.at[row], after;
    if (most == 0.0 || !(w[row] > 0.0))
        after = -most * (double)((free > 0.0) - (free < 0.0));
    else {
        double speed = free + dot(w, s->impulse.at, 2 * tips);
        double yielding = law->stick_speed / most;
        after = old - (speed + yielding * old) / (w[row] + yielding);
        after = smaller(larger(after, -most), most);
    }
    s->impulse.at[row] = after;
    return w[row] * fabs(after - old);
}

/* Compute the impulses of the tips in contact by projected Gauss-Seidel. Returns the residual. */
static double solve_impulses(const DenseLaw *law, DenseScratch *s, int64_t tips, int *solved)
{
    double scale = 1e-300, change = INFINITY, residual = 0.0;
    for (int64_t i = 0; i < 2 * tips; i++)
        scale = larger(scale, fabs(s->free.at[i]));
    for (int64_t i = 0; i < tips; i++)
        scale = larger(scale, fabs(s->before.at[i]));
    for (int round = 0; change > CLOSE * scale && round < MOST_ROUNDS; round++) {
        change = 0.0;
        for (int64_t tip = 0; tip < tips; tip++) {
            change = larger(change, press(law, s, tips, tip));
            change = larger(change, rub(law, s, tips, tip));
        }
    }
    *solved = change <= CLOSE * scale;
    for (int64_t tip = 0; tip < tips && law->penalty == 0.0; tip++) {
        const double *w = s->compliance.at + tip * 2 * tips;
        double left = s->free.at[tip] + dot(w, s->impulse.at, 2 * tips);
        left += law->restitution * smaller(s->before.at[tip], 0.0);
        residual = larger(residual, fabs(smaller(left, w[tip] * s->impulse.at[tip])) / scale);
    }
    return residual;
}

/* Compute the impulses of the tips in `active`, and v_{n+1}. Before, `impulse` contains the depth
 * of penetration of each tip. */
static void solve_contact(const DenseStage *stage, Wall wall, const DenseLaw *law,
                          DenseState *state, DenseScratch *s, double h, double turn, int64_t tips)
{
    int64_t modes = stage->stiffness.size;
    double *rows = s->rows.at, *answers = s->answers.at;
    int solved;
    for (int64_t i = 0; i < tips; i++) {
        double *normal = rows + i * modes, *tangential = rows + (tips + i) * modes;
        double drift = tip_sliding(stage, wall, s->active.at[i], turn, s->seen.at,
                                   state->velocity.at, tangential);
        s->before.at[i] = dot(normal, state->velocity.at, modes) + drift;
        s->free.at[i] = dot(normal, s->v_free.at, modes) + drift;
        s->free.at[tips + i] =
            dot(tangential, s->v_free.at, modes) - stage->tip_radius * stage->speed;
        s->impulse.at[i] *= h * law->penalty;
        s->impulse.at[tips + i] = 0.0;
    }
    for (int64_t i = 0; i < modes; i++)
        for (int64_t r = 0; r < 2 * tips; r++)
            answers[r * modes + i] =
                dot(stage->inverse.at + i * modes, rows + r * modes, modes);
    for (int64_t r = 0; r < 2 * tips; r++)
        for (int64_t c = 0; c < 2 * tips; c++)
            s->compliance.at[r * 2 * tips + c] = dot(rows + r * modes, answers + c * modes, modes);
    double residual = solve_impulses(law, s, tips, &solved);
    for (int64_t r = 0; r < 2 * tips; r++)
        for (int64_t i = 0; i < modes; i++)
            s->v_after.at[i] += s->impulse.at[r] * answers[r * modes + i];
    state->counts.at[RESIDUAL] = larger(state->counts.at[RESIDUAL], residual);
    state->counts.at[UNSOLVED] += !solved;
}

/* Return whether all displacements are within the limit. */
static int within_limit(const DenseStage *stage, int64_t step, const double *x)
{
    int64_t modes = stage->tip_radial.columns, casing = stage->nodal.columns;
    int all = step % CHECK_EVERY == 0;
    for (int64_t at = 0; at < stage->tip_radial.rows * modes; at += modes) {
        if (!(fabs(dot(stage->tip_radial.at + at, x, modes)) <= stage->limit))
            return 0;
        if (all && !(fabs(dot(stage->tip_tangential.at + at, x, modes)) <= stage->limit))
            return 0;
    }
    for (int64_t n = 0; all && n < stage->nodal.layers; n++)
        if (!(fabs(dot(stage->nodal.at + 4 * n * casing, x + modes, casing)) <= stage->limit))
            return 0;
    return 1;
}

/* Add the impulses and works of an accepted step to the state; `x` is x_{n+1}. */
static void account_dense(const DenseStage *stage, const Closure *closure, DenseState *state,
                          DenseScratch *s, double h, int64_t step, int64_t touching,
                          const double *x)
{
    int64_t modes = stage->stiffness.size, tips = stage->tip_angle.size;
    double *work = state->work.at, *counts = state->counts.at, *sums = state->sums.at;
    const double *moved = s->moved.at, *impulse = s->impulse.at;
    double now = stage->speed * (double)step * h, after = stage->speed * (double)(step + 1) * h;
    counts[STEP_CONTACTS] = 0.0;
    for (int64_t i = 0; i < touching; i++) {
        int64_t tip = s->active.at[i];
        if (!(impulse[i] > 0.0))
            continue;
        const double *normal = s->rows.at + i * modes, *shear = normal + touching * modes;
        counts[STEP_CONTACTS] += 1.0;
        sums[DENSE_IMPULSE * tips + tip] += impulse[i];
        sums[DENSE_DRAG * tips + tip] += impulse[touching + i];
        sums[DENSE_TOUCHED * tips + tip] += 1.0;
        work[NORMAL] += impulse[i] / h * dot(normal, moved, modes);
        double drift = s->before.at[i] - dot(normal, state->velocity.at, modes);
        work[CLOSING] += impulse[i] * (dot(normal, moved, modes) / h + drift);
        work[FRICTION] += impulse[touching + i] / h * dot(shear, moved, modes);
    }
    counts[CONTACT_STEPS] += counts[STEP_CONTACTS] > 0.0;
    velocity_force(stage, moved, s->force.at);
    work[EXTERNAL] += dot(moved, s->load.at, modes);
    work[DAMPING] += dot(moved, s->force.at, modes) / h;
    work[PARAMETRIC] += dot(moved, s->turned.at, modes) + turning_force(stage, after, x, 0);
    work[PARAMETRIC] -= turning_force(stage, now, state->displacement.at, 0);
    Wall wall = wall_at(closure, (double)(step + 1) * h);
    for (int64_t tip = 0; tip < tips; tip++) {
        double gap = tip_gap(stage, wall, tip, after, x, s->row.at);
        sums[DENSE_GAP * tips + tip] = smaller(sums[DENSE_GAP * tips + tip], gap);
    }
}

int64_t dense_march(const DenseStage *stage, const Closure *closure, const DenseLaw *law,
                    DenseState *state, DenseScratch *s, double h, int64_t first, int64_t steps)
{
    int64_t modes = stage->stiffness.size, tips = stage->tip_angle.size;
    double *x = state->displacement.at, *v = state->velocity.at, *seen = s->seen.at;
    for (int64_t step = first; step < first + steps; step++) {
        double half = ((double)step + 0.5) * h;
        load_force(stage, half, s->load.at);
        for (int64_t i = 0; i < modes; i++) {
            s->middle.at[i] = x[i] + 0.5 * h * v[i];
            s->turned.at[i] = 0.0;
        }
        turning_force(stage, stage->speed * half, s->middle.at, s->turned.at);
        circulation_force(stage, s->middle.at, s->turned.at);
        for (int64_t i = 0; i < modes; i++)
            s->force.at[i] = s->load.at[i] + s->turned.at[i];
        free_velocity(stage, h, state, s->force.at, s->moved.at, s->v_free.at);
        double seen_at = law->penalty > 0.0 ? half : (double)(step + 1) * h;
        double turn = stage->speed * seen_at;
        Wall wall = wall_at(closure, seen_at);
        for (int64_t i = 0; i < modes; i++) {
            s->v_after.at[i] = s->v_free.at[i];
            seen[i] = law->penalty > 0.0 ? s->middle.at[i] : x[i] + 0.5 * h * (v[i] + s->v_free.at[i]);
        }
        int64_t touching = 0;
        for (int64_t tip = 0; tip < tips; tip++) {
            double gap = tip_gap(stage, wall, tip, turn, seen, s->rows.at + touching * modes);
            if (gap < 0.0) {
                s->active.at[touching] = tip;
                s->impulse.at[touching++] = -gap;
            }
        }
        if (touching)
            solve_contact(stage, wall, law, state, s, h, turn, touching);
        for (int64_t i = 0; i < modes; i++) {
            s->moved.at[i] = 0.5 * h * (v[i] + s->v_after.at[i]);
            seen[i] = x[i] + s->moved.at[i]; /* x_{n+1} */
        }
        if (!within_limit(stage, step + 1, seen))
            return step - first;
        account_dense(stage, closure, state, s, h, step, touching, seen);
        for (int64_t i = 0; i < modes; i++) {
            x[i] = seen[i];
            v[i] = s->v_after.at[i];
        }
    }
    return steps;
}
