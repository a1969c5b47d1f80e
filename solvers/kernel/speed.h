/* Speed of rotation that varies over time.
 *
 * In rotating axes the displacements x of the rotor from the state of steady rotation at the speed
 * `base` follow
 *
 *     x'' + (D + 2 Omega G) x' + (K + (Omega^2 - base^2) K_1 + (Omega^4 - base^4) K_2 + Omega' G) x = f
 *
 * in modal coordinates at that speed. The centrifugal and the Euler force on the undeformed rotor
 * are load patterns. The step differs from that at constant speed by
 *
 *     - the inverse of A at a speed near Omega, which is interpolated every REFRESH steps between
 *       the inverses at a few speeds. It is a polynomial but for (dt Omega)^points;
 *     - the force of the rest of the speed, -2 (Omega - centre) G (x_n - x_{n-1}) / dt, whose
 *       velocity is half a step late: an error of dt (Omega - centre) in the acceleration;
 *     - the forces -(Omega^2 - base^2) K_1 x_n, -(Omega^4 - base^4) K_2 x_n and -Omega' G x_n.
 *
 * The stored energy includes x_{n-1}^T K_1 x_n / 2 times the difference of the squares at n - 1, and
 * the same of K_2. The work of the drive on the rotating axes is PARAMETRIC; it includes the change of
 * the energy of flexible contact nodes with the speed.
 */
#ifndef SPEED_H
#define SPEED_H

#include "nodes.h"

enum { REFRESH = 256 }; /* steps for which arrays that depend on the speed are kept */

/* Return the last piece that begins at or before a time, or the first one. */
static const double *piece_at(const Matrix *pieces, double time)
{
    int64_t below = 0, above = pieces->rows;
    while (above - below > 1) {
        int64_t middle = (below + above) / 2;
        if (pieces->at[middle * PIECE_NUMBERS] <= time)
            below = middle;
        else
            above = middle;
    }
    return pieces->at + below * PIECE_NUMBERS;
}

/* Compute angle, speed and acceleration at a step. Returns the angle that the change of the speed
 * adds to that of rotation at the speed `base`. */
static double course_at(const Speed *s, const Numbers *n, double step, double *angle, double *speed,
                        double *acceleration)
{
    double time = step * n->time_step;
    const double *piece = piece_at(&s->pieces, time), *c = piece + PIECE_SPEED;
    double t = time - piece[PIECE_START];
    double added = piece[PIECE_ANGLE]
                   + t * (c[0] + t * (c[1] / 2.0 + t * (c[2] / 3.0 + t * c[3] / 4.0)));
    *acceleration = c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
    *speed = s->base + (c[0] + t * (c[1] + t * (c[2] + t * c[3])));
    *angle = n->angle_per_step * step + added;
    return added;
}

/* Interpolate the arrays that depend on the speed. */
static void set_speed(const Speed *s, double speed)
{
    double weight[MOST_POINTS];
    int64_t size = s->current.size; /* a whole number of registers */
    for (int64_t k = 0; k < s->points.size; k++) {
        weight[k] = 1.0;
        for (int64_t j = 0; j < s->points.size; j++)
            if (j != k)
                weight[k] *= (speed - s->points.at[j]) / (s->points.at[k] - s->points.at[j]);
    }
    for (int64_t i = 0; i < size; i += LANES) {
        Lanes sum = splat(0.0);
        for (int64_t k = 0; k < s->points.size; k++)
            sum = muladd(splat(weight[k]), load(s->samples.at + k * size + i), sum);
        store(s->current.at + i, sum);
    }
}

/* Compute the rotation in a step at constant speed. */
static void rotate_steadily(March *m, int64_t step)
{
    const Numbers *n = m->stage.numbers;
    m->rotation = (Rotation){.angle = {n->angle_per_step * (double)(step - 1),
                                       n->angle_per_step * (double)step},
                             .elements = n->elements_per_step * (double)(step + 1),
                             .speed = n->speed,
                             .circulation = 1.0,
                             .now = n->speed};
}

/* Compute G x + b for a free speed. */
static void couple(const March *m, const double *x, double *out)
{
    const double *across = m->stage.drive->across.at;
    add_product(m->stage.rotor, &m->stage.speed->coriolis, m->x.entries, x, across, out);
}

/* Compute K_1 x_n, and the force due to the change of the speed: that of K_1 and that of G, which
 * acts on the acceleration and on the part of the speed that the inverse of A lacks. With a free
 * speed the products of the last step and of this one give that of G. */
static void speed_forces(March *m, int first)
{
    const Speed *speed = m->stage.speed;
    const Rotation *r = &m->rotation;
    Motion x = m->x;
    double *stiffened = m->scratch->speed.stiffened.at, *force = m->scratch->speed.force.at;
    double *input = m->scratch->speed.input.at;
    double late = 2.0 * (r->now - r->centre) / m->stage.numbers->time_step;
    int steady = late == 0.0 && r->acceleration == 0.0;
    int changed = m->stage.drive || r->square[0] != 0.0 || r->square[1] != 0.0;
    for (int64_t i = 0; i < x.entries; i += LANES)
        store(stiffened + i, splat(0.0));
    if (changed && speed->direct)
        blocks_product(m->stage.rotor, &speed->stiffening, x.now, stiffened, stiffened, 0);
    else if (changed)
        add_product(m->stage.rotor, &speed->stiffening, x.entries, x.now, stiffened, stiffened);
    Lanes by_old = splat(late), by_now = splat(-r->acceleration - late), by = splat(-r->square[1]);
    if (m->stage.drive) {
        const double *across = m->stage.drive->across.at;
        double *coupled = m->scratch->speed.coupled.at;
        if (first)
            couple(m, x.old, coupled);
        for (int64_t i = 0; i < x.entries; i += LANES)
            store(input + i, mul(by_old, sub(load(coupled + i), load(across + i))));
        couple(m, x.now, coupled);
        for (int64_t i = 0; i < x.entries; i += LANES) {
            Lanes turned = muladd(by_now, sub(load(coupled + i), load(across + i)), load(input + i));
            store(force + i, muladd(by, load(stiffened + i), turned));
        }
        return;
    }
    for (int64_t i = 0; i < x.entries; i += LANES) {
        store(input + i, muladd(by_now, load(x.now + i), mul(by_old, load(x.old + i))));
        store(force + i, mul(by, load(stiffened + i)));
    }
    double *more = m->scratch->speed.stiffened4.at;
    for (int64_t i = 0; i < m->scratch->speed.stiffened4.size; i += LANES)
        store(more + i, splat(0.0));
    if (m->scratch->speed.stiffened4.size > 0) {
        add_product(m->stage.rotor, &speed->stiffening4, x.entries, x.now, more, more);
        by = splat(-fourth(speed, r->square[1]));
        for (int64_t i = 0; i < x.entries; i += LANES)
            store(force + i, muladd(by, load(more + i), load(force + i)));
    }
    if (!steady)
        add_product(m->stage.rotor, &speed->coriolis, x.entries, input, force, force);
}

/* Let the arrays that depend on the speed be those at another speed. */
static void refresh_speed(March *m, double centre)
{
    IntVector *known = &m->scratch->nodes.known;
    m->rotation.centre = centre;
    set_speed(m->stage.speed, centre);
    if (known->size > 0)
        known->at[0] = -1;
}

/* Let these arrays be those in the middle of the steps around a step. If this begins another group of
 * steps, the energy of flexible contact nodes changes. */
static void follow_speed(March *m, int64_t step, int first)
{
    double angle, centre, ignored, stored;
    if (first && step > 0) {
        int64_t last = step - 1;
        course_at(m->stage.speed, m->stage.numbers, (double)(last - last % REFRESH) + 0.5 * REFRESH,
                  &angle, &centre, &ignored);
        refresh_speed(m, centre);
    }
    if (step % REFRESH > 0)
        return;
    course_at(m->stage.speed, m->stage.numbers, (double)step + 0.5 * REFRESH, &angle, &centre, &ignored);
    if (step > 0 && centre == m->rotation.centre)
        return;
    stored = flexible_energy(m);
    refresh_speed(m, centre);
    m->state->work.at[PARAMETRIC] += flexible_energy(m) - stored;
}

/* Compute the rotation in a step, and the forces due to its change. */
static void prepare_speed(March *m, int64_t step, int first)
{
    const Speed *speed = m->stage.speed;
    if (!speed) {
        rotate_steadily(m, step);
        return;
    }
    const Numbers *n = m->stage.numbers;
    Rotation *r = &m->rotation;
    double square = speed->base * speed->base, ignored;
    if (first) {
        course_at(speed, n, (double)(step - 1), &r->angle[1], &r->now, &ignored);
        course_at(speed, n, (double)step, &r->next, &r->speed, &r->later);
    }
    r->angle[0] = r->angle[1];
    r->angle[1] = r->next;
    r->square[0] = r->now * r->now - square;
    r->now = r->speed;
    r->acceleration = r->later;
    double added = course_at(speed, n, (double)(step + 1), &r->next, &r->speed, &r->later);
    r->elements = n->elements_per_step * (double)(step + 1)
                  + added * (double)m->stage.casing->nodes / (2.0 * PI);
    r->circulation = speed->base != 0.0 ? r->now / speed->base : 0.0;
    r->square[1] = r->now * r->now - square;
    if (m->scratch->speed.force.size == 0)
        return;
    follow_speed(m, step, first);
    speed_forces(m, first);
}

/* Return the product of x_n-1 and what changes of the stiffness times x_n, for a change of Omega^2. */
static double strained(const March *m, const double *x, double square)
{
    const SpeedScratch *s = &m->scratch->speed;
    double energy = square * dot(x, s->stiffened.at, s->stiffened.size);
    if (s->stiffened4.size > 0)
        energy += fourth(m->stage.speed, square) * dot(x, s->stiffened4.at, s->stiffened4.size);
    return energy;
}

/* Record angle and speed. Returns the energy x_{n-1}^T (K - K_base) x_n / 2. */
static double record_speed(const March *m, Records *records, int64_t row)
{
    double *to = records->rotation.at + row * ROTATION_NUMBERS;
    to[ANGLE] = m->rotation.angle[1];
    to[SPEED] = m->rotation.now;
    return 0.5 * strained(m, m->x.old, m->rotation.square[0]);
}

/* Add the work of the drive on the rotating axes in a step: that of the force, and the increase of
 * the energy of `record_speed`. */
static void account_speed(const March *m)
{
    const SpeedScratch *s = &m->scratch->speed;
    const double *force = s->force.at, *squares = m->rotation.square;
    Motion x = m->x;
    Lanes work = splat(0.0);
    for (int64_t i = 0; i < s->force.size; i += LANES)
        work = muladd(sub(load(x.new + i), load(x.old + i)), load(force + i), work);
    double further = strained(m, x.new, squares[1]) - strained(m, x.old, squares[0]);
    m->state->work.at[PARAMETRIC] += 0.5 * (total(work) + further);
}

#endif
