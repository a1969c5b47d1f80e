/* Motion of a body between contacts: recurrence, loads, springs, dampers, energy, records. */
#ifndef MOTION_H
#define MOTION_H

#include <math.h>

#include "scratch.h"

/* Return a product rounded to double. Without this function, GCC 12 fuses a difference of products
 * next to a sum of products in spite of -ffp-contract=off (its SLP pass makes a vfmaddsub). */
static inline double rounded(double product)
{
    volatile double value = product;
    return value;
}

#define PI 3.141592653589793238462643383279502884

/* Pointers to x_{n-1}, x_n, x_{n+1} of a body, which are exchanged after each step. */
typedef struct {
    double *old, *now, *new;
    int64_t entries;
} Motion;

/* Rotation of the rotor in a step from n to n + 1. */
typedef struct {
    double angle[2];     /* psi at n - 1 and at n [rad] */
    double elements;     /* psi at n + 1, in casing elements */
    double speed;        /* Omega at n + 1 [rad/s] */
    double circulation;  /* Omega at n divided by the speed of the arrays of `Gyroscopic` */
    double square[2];    /* Omega^2 at n - 1 and at n, less that of the stiffness [rad2/s2] */
    double grown;        /* change of the latter since the prediction of a free speed [rad2/s2] */
    double acceleration; /* Omega' at n [rad/s2] */
    double now;          /* Omega at n [rad/s] */
    double next;         /* psi at n + 1 [rad] */
    double later;        /* Omega' at n + 1 [rad/s2] */
    double half;         /* Omega at n + 1/2 of a free speed [rad/s] */
    double torque;       /* torque on the rotor without contact forces, of a free speed [N m] */
    double centre;       /* speed of the arrays that depend on the speed [rad/s] */
} Rotation;

/* The stage and the working data of a march. */
typedef struct {
    Stage stage;
    State *state;
    Scratch *scratch;
    Motion x, y; /* motion of rotor and of casing */
    Rotation rotation;
    int loaded;  /* whether any load acts at this step */
    int held;    /* whether any node may have a contact force at step n */
    int pushed;  /* whether any node may have a contact force at step n + 1 */
    int drawn;   /* whether contact forces act on tips that draw back, see `foreshortening.h` */
} March;

static inline Motion motion_of(const Matrix *state)
{
    double *x = state->at;
    return (Motion){x, x + state->columns, x + 2 * state->columns, state->columns};
}

/* Exchange the pointers for the next step. */
static inline void turn_slots(Motion *x) { *x = (Motion){x->now, x->new, x->old, x->entries}; }

/* Compute x_{n+1} without forces from x_n and x_{n-1}, with the coefficients a and b. */
static inline void predict_body(const Body *body, Motion x)
{
    const double *a = body->a.at, *b = body->b.at;
    for (int64_t i = 0; i < x.entries; i += LANES) {
        Lanes before = mul(load(b + i), load(x.old + i));
        store(x.new + i, muladd(load(a + i), load(x.now + i), before));
    }
}

/* Return Omega^4 - base^4 from Omega^2 - base^2. */
static inline double fourth(const Speed *s, double square)
{
    return square * (square + 2.0 * s->base * s->base);
}

/* Return the rotation on which load patterns at n + 1 depend; `speed` is NULL if it is constant. */
static inline Rotation next_rotation(const Speed *speed, const Rotation *now)
{
    if (!speed)
        return *now;
    return (Rotation){.angle = {now->angle[1], now->next},
                      .square = {now->square[1], now->speed * now->speed - speed->base * speed->base},
                      .acceleration = now->later};
}

/* Compute the factor of each load pattern; `speed` is NULL if it is constant. Returns whether any
 * factor is not zero. */
static inline int load_amplitudes(const Matrix *loads, const Speed *speed, const Rotation *turn,
                                  double time, double *out)
{
    int loaded = 0;
    for (int64_t p = 0; p < loads->rows; p++) {
        const double *load = loads->at + p * LOAD_NUMBERS;
        double factor = 0.0;
        if (time < load[LOAD_END]) {
            double phase = load[LOAD_PHASE], scale = 1.0;
            if (speed) {
                const double *by = speed->factors.at + p * SPEED_FACTORS;
                phase += by[BY_ANGLE] * turn->angle[1];
                scale = by[CONSTANT] + by[BY_SQUARE] * turn->square[1]
                        + by[BY_FOURTH] * fourth(speed, turn->square[1])
                        + by[BY_ACCELERATION] * turn->acceleration;
            }
            double angle = load[LOAD_FREQUENCY] * time + phase;
            factor = angle == 0.0 ? scale : scale * cos(angle);
            if (time < load[LOAD_RAMP])
                factor *= 0.5 - 0.5 * cos(PI * time / load[LOAD_RAMP]);
        }
        out[p] = factor;
        loaded |= factor != 0.0;
    }
    return loaded;
}

/* Return the closure at a time; `rate` gets its rate of change [m/s]. */
static double closure_at(const Closure *closure, double time, double *rate)
{
    const double *row = closure->table.at;
    int64_t below = 0, above = closure->table.rows - 1;
    if (above < 0) {
        *rate = closure->amount * closure->rate * exp(-closure->rate * time);
        return -closure->amount * expm1(-closure->rate * time);
    }
    *rate = 0.0;
    if (time <= row[0] || time >= row[2 * above])
        return time <= row[0] ? row[1] : row[2 * above + 1];
    while (above - below > 1) {
        int64_t middle = (below + above) / 2;
        if (row[2 * middle] <= time)
            below = middle;
        else
            above = middle;
    }
    row += 2 * below;
    *rate = (row[3] - row[1]) / (row[2] - row[0]);
    return row[1] + *rate * (time - row[0]);
}

/* Add the response to the load patterns, in the registers in which they are not zero. */
static inline void add_loads(const Body *body, const double *amplitude, Motion x)
{
    for (int64_t p = 0; p < body->loaded.rows; p++) {
        const double *pattern = body->load.at + p * x.entries;
        const int64_t *places = body->loaded.at + p * body->loaded.columns;
        for (; *places >= 0; places++) {
            int64_t i = *places;
            Lanes force = mul(splat(amplitude[p]), load(pattern + i));
            store(x.new + i, muladd(force, load(body->c.at + i), load(x.new + i)));
        }
    }
}

/* Return the work d^T f of the loads with d = (x_{n+1} - x_{n-1}) / 2. */
static inline double external_work(const Body *body, const double *amplitude, Motion x)
{
    double work = 0.0;
    for (int64_t p = 0; p < body->loaded.rows; p++) {
        const double *pattern = body->load.at + p * x.entries;
        const int64_t *places = body->loaded.at + p * body->loaded.columns;
        Lanes sum = splat(0.0);
        for (; *places >= 0; places++) {
            int64_t i = *places;
            sum = muladd(sub(load(x.new + i), load(x.old + i)), load(pattern + i), sum);
        }
        work += 0.5 * amplitude[p] * total(sum);
    }
    return work;
}

/* Compute the waves of the radial displacement of a body at the springs. */
static inline void spring_waves(const SpringEnds *ends, const double *x, double *out, int64_t waves)
{
    for (int64_t i = 0; i < waves; i++)
        out[i] = 0.0;
    for (int64_t i = 0; i < ends->place.size; i++)
        out[ends->wave.at[i]] += ends->amplitude.at[i] * x[ends->place.at[i]];
}

/* Compute the stretch of the springs, which is the displacement of the casing minus that of the
 * rotor, at the angles of the rotor at the previous and the present step. Rows 0 and 1 are at the previous angle for the previous and the present displacement, rows
 * 2 and 3 are at the present angle for both displacements. */
static void stretch_springs(const Springs *springs, const double *angles, SpringScratch *s,
                            int64_t step)
{
    int64_t waves = springs->factor.size;
    for (int turned = 0; turned < 2; turned++)
        for (int64_t h = 0; h < springs->nodal_diameter.size; h++) {
            double phase = springs->nodal_diameter.at[h] * angles[turned];
            double c = cos(phase), sine = sin(phase);
            for (int moved = 0; moved < 2; moved++) {
                int64_t row = (step + 1 + moved) % 2 * waves + 2 * h;
                double u_c = s->rotor.at[row], u_s = s->rotor.at[row + 1];
                double *to = s->stretch.at + (2 * turned + moved) * waves + 2 * h;
                to[0] = s->casing.at[row] - (u_c * c - rounded(u_s * sine));
                to[1] = s->casing.at[row + 1] - (u_c * sine + u_s * c);
            }
        }
}

/* Return x_{n-1}^T K* x_n / 2 from the stretches for both displacements at the same angle. */
static inline double spring_energy(const Springs *springs, const double *stretch)
{
    int64_t waves = springs->factor.size;
    double energy = 0.0;
    for (int64_t i = 0; i < waves; i++)
        energy += springs->factor.at[i] * stretch[i] * stretch[waves + i];
    return 0.5 * energy;
}

/* Compute the forces -C^T f kappa C x_n of the springs on the waves of rotor and casing. `energy`
 * gets the energy of the springs at step n - 1/2, and the work of the rotation of the springs to
 * step n. */
static inline void turn_springs(const Springs *springs, const double *angles, Motion x, Motion y,
                                SpringScratch *s, int64_t step, double energy[2])
{
    int64_t waves = springs->factor.size, row = step % 2 * waves;
    spring_waves(&springs->rotor, x.now, s->rotor.at + row, waves);
    spring_waves(&springs->casing, y.now, s->casing.at + row, waves);
    stretch_springs(springs, angles, s, step);
    double *on_rotor = s->force.at, *on_casing = s->force.at + waves;
    for (int64_t h = 0; h < springs->nodal_diameter.size; h++) {
        double phase = springs->nodal_diameter.at[h] * angles[1];
        double c = cos(phase), sine = sin(phase);
        int64_t i = 2 * h;
        double pull_c = springs->factor.at[i] * s->stretch.at[3 * waves + i];
        double pull_s = springs->factor.at[i + 1] * s->stretch.at[3 * waves + i + 1];
        on_rotor[i] = c * pull_c + sine * pull_s;
        on_rotor[i + 1] = c * pull_s - rounded(sine * pull_c);
        on_casing[i] = -pull_c;
        on_casing[i + 1] = -pull_s;
    }
    energy[0] = spring_energy(springs, s->stretch.at);
    energy[1] = spring_energy(springs, s->stretch.at + 2 * waves) - energy[0];
}

/* Add the response to the spring forces, with the amplitude of each mode in its wave. */
static inline void add_springs(const SpringEnds *ends, const double *force, const double *c,
                               double *new)
{
    for (int64_t i = 0; i < ends->place.size; i++) {
        int64_t at = ends->place.at[i];
        new[at] += c[at] * ends->amplitude.at[i] * force[ends->wave.at[i]];
    }
}

/* Compute the displacements G (x_{n+1} - x_{n-1}) of the dampers in two steps. */
static inline void damper_strokes(const Matrix *rows, Motion x, double *out)
{
    for (int64_t m = 0; m < rows->rows; m++) {
        const double *row = rows->at + m * rows->columns;
        Lanes sum = splat(0.0);
        for (int64_t i = 0; i < x.entries; i += LANES)
            sum = muladd(load(row + i), sub(load(x.new + i), load(x.old + i)), sum);
        out[m] = total(sum);
    }
}

/* Compute the forces phi of the dampers from the predicted x_{n+1}, and add the response to
 * them. */
static inline void add_dampers(const DamperEnds *ends, const double *c, Motion x, double *stroke,
                               double *force)
{
    int64_t count = ends->rows.rows;
    damper_strokes(&ends->rows, x, stroke);
    for (int64_t m = 0; m < count; m++) {
        force[m] = 0.0;
        for (int64_t k = 0; k < count; k++)
            force[m] -= ends->solve.at[m * count + k] * stroke[k];
    }
    for (int64_t i = 0; i < x.entries; i += LANES) {
        Lanes pull = splat(0.0);
        for (int64_t m = 0; m < count; m++)
            pull = muladd(load(ends->rows.at + m * x.entries + i), splat(force[m]), pull);
        store(x.new + i, muladd(load(c + i), pull, load(x.new + i)));
    }
}

/* Return the energy loss -d^T G^T phi with d = (x_{n+1} - x_{n-1}) / 2. */
static inline double damper_loss(const DamperEnds *ends, Motion x, double *stroke,
                                 const double *force)
{
    double loss = 0.0;
    damper_strokes(&ends->rows, x, stroke);
    for (int64_t m = 0; m < ends->rows.rows; m++)
        loss -= 0.5 * force[m] * stroke[m];
    return loss;
}

/* Return d^T D d with d = (x_{n+1} - x_{n-1}) / 2. */
static inline double damping_loss(const Body *body, Motion x)
{
    Lanes loss = splat(0.0);
    for (int64_t i = 0; i < x.entries; i += LANES) {
        Lanes moved = sub(load(x.new + i), load(x.old + i));
        loss = muladd(mul(load(body->damping.at + i), moved), moved, loss);
    }
    return 0.25 * total(loss);
}

/* Return E_{n-1/2} = v^T v / 2 + x_{n-1}^T K x_n / 2 with v = (x_n - x_{n-1}) / dt. */
static double half_step_energy(const Body *body, Motion x, double time_step)
{
    Lanes energy = splat(0.0), rate = splat(1.0 / time_step);
    for (int64_t i = 0; i < x.entries; i += LANES) {
        Lanes now = load(x.now + i), old = load(x.old + i), v = mul(sub(now, old), rate);
        energy = muladd(mul(load(body->stiffness.at + i), now), old, muladd(v, v, energy));
    }
    return 0.5 * total(energy);
}

/* Record displacement and velocity of a body. */
static void record_motion(Motion x, const double *later, double interval, double *displacement,
                          double *velocity)
{
    for (int64_t i = 0; i < x.entries; i++) {
        displacement[i] = x.now[i];
        velocity[i] = (later[i] - x.old[i]) / interval;
    }
}

/* Write a record of step n before x_{n+1} is accepted, and reset the sums since the last record.
 * The velocity is a central difference or, if x_{n+1} is not within the limit, a backward
 * difference. `stored` is the energy of springs and of residual flexibilities. */
static void write_record(Records *r, int64_t row, State *state, const Rotor *rotor,
                         const Casing *casing, Motion x, Motion y, double time_step,
                         double stored, int64_t step, int within)
{
    double interval = within ? 2.0 * time_step : time_step;
    int64_t tips = state->gap.size, first = row * tips;
    r->step.at[row] = step;
    r->contacts.at[row] = state->counts.at[STEP_CONTACTS];
    r->energy.at[row] = half_step_energy(&rotor->body, x, time_step)
                        + half_step_energy(&casing->body, y, time_step) + stored;
    record_motion(x, within ? x.new : x.now, interval, r->rotor.at + row * x.entries,
                  r->rotor_velocity.at + row * x.entries);
    if (r->casing.columns > 0)
        record_motion(y, within ? y.new : y.now, interval, r->casing.at + row * y.entries,
                      r->casing_velocity.at + row * y.entries);
    for (int64_t i = 0; i < WORKS; i++)
        r->work.at[row * WORKS + i] = state->work.at[i];
    for (int64_t i = 0; i < state->coating.size; i++)
        r->coating.at[row * COATING_SUMS + i] = state->coating.at[i];
    for (int64_t j = 0; j < state->coating_impulse.size; j++) {
        r->coating_impulse.at[first + j] = state->coating_impulse.at[j];
        state->coating_impulse.at[j] = 0.0;
    }
    for (int64_t j = 0; j < tips; j++) {
        r->gap.at[first + j] = state->gap.at[j];
        r->impulse.at[first + j] = state->impulse.at[j];
        r->drag.at[first + j] = state->drag.at[j];
        r->touched.at[first + j] = state->touched.at[j];
        state->gap.at[j] = INFINITY;
        state->impulse.at[j] = state->drag.at[j] = state->touched.at[j] = 0.0;
    }
    for (int64_t j = 0; j < state->axial.size; j++) {
        r->axial.at[first + j] = state->axial.at[j];
        state->axial.at[j] = 0.0;
    }
    int64_t components = state->force.rows * state->force.columns;
    for (int64_t i = 0; i < components; i++)
        r->force.at[row * components + i] = state->force.at[i];
}

/* Store x_{n-1} and x_n in rows 0 and 1. */
static void settle(Matrix *state, Motion x)
{
    for (int64_t i = 0; i < x.entries; i++) {
        double old = x.old[i], now = x.now[i], new = x.new[i];
        state->at[i] = old;
        state->at[x.entries + i] = now;
        state->at[2 * x.entries + i] = new;
    }
}

#endif
