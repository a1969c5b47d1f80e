/* Speed of rotation that is free: it follows from the angular momentum of the rotor
 *
 *     p = Omega (J + 2 a^T x - x^T K_1 x) + b^T x' + (G x)^T x',       p' = torques,
 *
 * the derivative of the Lagrangian by Omega, with the symbols of `speed.h`: J is the moment of
 * inertia in the state from which displacements count, Omega^2 a and -Omega' b are the load patterns.
 * The torques are those of the drive, of losses, of friction, of normal forces on a wall whose radius
 * changes with the angle, and of static dampers.
 *
 * p is taken at half steps, with x_n^T K_1 x_{n+1} and x_n^T G^T x_{n+1} / h, which is linear in
 * x_{n+1}. A step is predicted with the acceleration of the last step. The acceleration then follows
 * from p without contact forces, and changes x_{n+1} by -h^2 (b + G x_n) times its change, and by
 * h^2 (a - K_1 x_n) times the change of Omega^2, which is the product of the speeds at the half steps
 * before and after n. Contact forces of a step change p in this step, by the displacements that they
 * cause; the rest of their impulse changes the speed in the next step. With these squares, and the
 * work of each change of p at the mean speed of two half steps, energy and works close to rounding.
 */
#ifndef DRIVE_H
#define DRIVE_H

#include "bearings.h"
#include "speed.h"

/* Compute the rotation in a step from the state; the speed at n is expected from the acceleration. */
static void prepare_drive(March *m, int64_t step, int first)
{
    const Speed *speed = m->stage.speed;
    const double *s = m->state->drive.at;
    Rotation *r = &m->rotation;
    double dt = m->stage.numbers->time_step, square = speed->base * speed->base;
    r->angle[0] = s[DRIVE_BEFORE];
    r->angle[1] = s[DRIVE_ANGLE];
    r->acceleration = s[DRIVE_ACCELERATION];
    r->now = s[DRIVE_SPEED] + 0.5 * dt * r->acceleration;
    r->square[0] = s[DRIVE_SQUARE] - square;
    r->square[1] = r->now * r->now - square;
    r->circulation = r->now / speed->base;
    if (m->scratch->speed.force.size > 0) {
        if (step % REFRESH == 0)
            m->state->drive.at[DRIVE_CENTRE] = s[DRIVE_SPEED];
        if (first || step % REFRESH == 0)
            refresh_speed(m, s[DRIVE_CENTRE]);
        speed_forces(m, first);
    }
}

/* Return the torque of static dampers, with the velocity of the predicted step. */
static double damper_torque(const March *m)
{
    const Drive *d = m->stage.drive;
    const double *along = d->centre.at, *across = along + d->centre.columns;
    if (d->damping == 0.0)
        return 0.0;
    Lanes zero = splat(0.0), place[2] = {zero, zero}, change[2] = {zero, zero};
    for (int64_t i = 0; i < d->centre.columns; i += LANES) {
        Lanes now = load(m->x.now + i), moved = sub(load(m->x.new + i), load(m->x.old + i));
        place[0] = muladd(load(along + i), now, place[0]);
        place[1] = muladd(load(across + i), now, place[1]);
        change[0] = muladd(load(along + i), moved, change[0]);
        change[1] = muladd(load(across + i), moved, change[1]);
    }
    double u[2], v[2], twice = 2.0 * m->stage.numbers->time_step;
    for (int k = 0; k < 2; k++) {
        u[k] = total(place[k]);
        v[k] = total(change[k]) / twice;
    }
    double moved = u[0] * v[1] - u[1] * v[0];
    return -d->damping * (moved + m->rotation.now * (u[0] * u[0] + u[1] * u[1]));
}

/* Return the angular momentum at n + 1/2 without that of the change of the acceleration; `inertia`
 * gets the moment of inertia. */
static double momentum(const March *m, double speed, double *inertia)
{
    const Drive *d = m->stage.drive;
    const SpeedScratch *s = &m->scratch->speed;
    Motion x = m->x;
    Lanes sum = splat(0.0), carried = splat(0.0);
    for (int64_t i = 0; i < d->along.size; i += LANES) {
        Lanes now = load(x.now + i), new = load(x.new + i);
        sum = muladd(load(d->along.at + i), add(now, new), sum);
        sum = sub(sum, mul(load(s->stiffened.at + i), new));
        carried = muladd(load(s->coupled.at + i), new, carried);
        carried = sub(carried, mul(load(d->across.at + i), now));
    }
    *inertia = d->inertia + total(sum);
    return speed * *inertia + total(carried) / m->stage.numbers->time_step;
}

/* Compute the acceleration from the predicted x_{n+1}, and add its change and that of Omega^2 to
 * x_{n+1}. */
static void predict_drive(March *m)
{
    const Drive *d = m->stage.drive;
    const Numbers *n = m->stage.numbers;
    const double *s = m->state->drive.at, *coupled = m->scratch->speed.coupled.at;
    const double *stiffened = m->scratch->speed.stiffened.at;
    Rotation *r = &m->rotation;
    double dt = n->time_step, acceleration = r->acceleration;
    double base = m->stage.speed->base * m->stage.speed->base, square = r->square[1];
    r->torque = d->torque - d->loss * r->now + damper_torque(m);
    if (m->stage.bearings)
        r->torque += bearing_torque(m);
    double goal = s[DRIVE_MOMENTUM] + dt * r->torque, before = acceleration;
    Lanes zero = splat(0.0), along = zero, across = zero, pulled = zero, turned = zero;
    Lanes pulls = zero, turns = zero, both = zero;
    for (int64_t i = 0; i < d->along.size; i += LANES) {
        Lanes a = load(d->along.at + i), c = load(coupled + i), pull = sub(a, load(stiffened + i));
        Lanes now = load(m->x.now + i), new = load(m->x.new + i);
        along = muladd(a, now, along);
        across = muladd(load(d->across.at + i), now, across);
        pulled = muladd(pull, new, pulled);
        turned = muladd(c, new, turned);
        pulls = muladd(pull, pull, pulls);
        turns = muladd(c, c, turns);
        both = muladd(pull, c, both);
    }
    double inertia = d->inertia + total(along), carried = -total(across), own = total(turns);
    double outward = total(pulled), around = total(turned), mixed = total(both), most = total(pulls);
    for (int trial = 0; trial < 3; trial++) {
        double half = s[DRIVE_SPEED] + dt * acceleration;
        double lacks = goal - half * (inertia + outward) - (carried + around) / dt;
        double change = lacks / (dt * (inertia + outward - own));
        acceleration += change;
        double present = s[DRIVE_SPEED] * (s[DRIVE_SPEED] + dt * acceleration) - base;
        double by = -dt * dt * change, grown = dt * dt * (present - square);
        outward += by * mixed + grown * most;
        around += by * own + grown * mixed;
        square = present;
    }
    Lanes by = splat(dt * dt * (before - acceleration)), grown = splat(dt * dt * (square - r->square[1]));
    for (int64_t i = 0; i < d->along.size; i += LANES) {
        Lanes pull = sub(load(d->along.at + i), load(stiffened + i));
        Lanes new = muladd(by, load(coupled + i), load(m->x.new + i));
        store(m->x.new + i, muladd(grown, pull, new));
    }
    r->grown = square - r->square[1];
    r->square[1] = square;
    r->later = acceleration;
    r->half = s[DRIVE_SPEED] + dt * acceleration;
    r->next = s[DRIVE_ANGLE] + dt * r->half;
    r->speed = r->half + 0.5 * dt * acceleration;
    r->elements = r->next * (double)m->stage.casing->nodes / (2.0 * PI);
}

/* Return the change of the radius of the wall by the angle at a tip [m], with a closure [m]. */
static double wall_slope(const March *m, int64_t tip, double closed)
{
    const Casing *casing = m->stage.casing;
    const FieldScratch *f = &m->scratch->fields;
    const Matrix *nodal = casing->modes == 0 ? &casing->radial.start : &f->nodal;
    double place = position_of(m, tip) + m->rotation.elements, length = casing->element_length;
    double xi = place - floor(place), rest = 1.0 - xi;
    double weight[4] = {-6.0 * xi * rest, length * rest * (1.0 - 3.0 * xi), 6.0 * xi * rest,
                        length * xi * (3.0 * xi - 2.0)};
    double slope = hermite_value(nodal, f->element.at[tip], weight, 1);
    if (closed != 0.0)
        slope -= closed * hermite_value(&m->stage.closure->share, f->element.at[tip], weight, 1);
    return slope * (double)casing->nodes / (2.0 * PI);
}

/* Return the torque of the contact forces at the end of the step, at a time. */
static double contact_torque(const March *m, double time)
{
    const Rotor *rotor = m->stage.rotor;
    const Closure *closure = m->stage.closure;
    double torque = 0.0, rate, closed = closure ? closure_at(closure, time, &rate) : 0.0;
    for (int64_t j = 0; j < m->state->gap.size; j++) {
        const double *force = m->state->force.at + DIRECTIONS * j;
        if (force[RADIAL] < 0.0)
            torque += force[TANGENTIAL] * rotor->radius.at[j]
                      - force[RADIAL] * rotor->normal_part.at[j] * wall_slope(m, j, closed);
    }
    return torque;
}

/* Advance the state of the drive by an accepted step. */
static void account_drive(March *m, int64_t step, int touching)
{
    const Numbers *n = m->stage.numbers;
    const Rotation *r = &m->rotation;
    double *s = m->state->drive.at, dt = n->time_step;
    double contact = touching ? contact_torque(m, (double)(step + 1) * dt) : 0.0;
    /* The work of the forces that the changes of acceleration and square in `predict_drive` add. */
    const double *coupled = m->scratch->speed.coupled.at, *along = m->stage.drive->along.at;
    const double *stiffened = m->scratch->speed.stiffened.at;
    Lanes work = splat(0.0), grown = splat(r->grown), sped = splat(r->later - r->acceleration);
    double lost = m->stage.drive->loss * r->now;
    for (int64_t i = 0; i < m->scratch->speed.coupled.size; i += LANES) {
        Lanes pull = sub(load(along + i), load(stiffened + i));
        Lanes force = sub(mul(grown, pull), mul(sped, load(coupled + i)));
        work = muladd(force, sub(load(m->x.new + i), load(m->x.old + i)), work);
    }
    m->state->work.at[PARAMETRIC] += 0.5 * total(work);
    double damped = r->torque - m->stage.drive->torque + lost;
    double mean = 0.5 * (s[DRIVE_SPEED] + r->half), inertia;
    /* Contact changes the momentum of displacements in this step; the rest of its impulse acts on
     * the speed in the next step. */
    double moved = 0.0;
    if (touching)
        moved = momentum(m, r->half, &inertia) - (s[DRIVE_MOMENTUM] + dt * r->torque);
    s[DRIVE_WORK] += dt * mean * m->stage.drive->torque;
    s[DRIVE_LOSS] += dt * mean * lost;
    s[DRIVE_CONTACT] += mean * (dt * damped + s[DRIVE_IMPULSE] - s[DRIVE_MOVED] + moved);
    s[DRIVE_MOVED] = moved;
    s[DRIVE_IMPULSE] = dt * contact;
    s[DRIVE_MOMENTUM] += dt * (r->torque + contact);
    s[DRIVE_BEFORE] = r->angle[1];
    s[DRIVE_ANGLE] = r->next;
    s[DRIVE_SQUARE] = s[DRIVE_SPEED] * r->half;
    s[DRIVE_SPEED] = r->half;
    s[DRIVE_ACCELERATION] = r->later;
}

/* Record the state of the drive, and the energy Omega p - Omega^2 (J + 2 a^T x) / 2 with the potential
 * of the forces that hold the rotor in the state at the speed `base`. The energy of the tension at a
 * half step is that with the square of its speed, where `record_speed` has the product of speeds. */
static void record_drive(const March *m, Records *records, int64_t row)
{
    const Drive *d = m->stage.drive;
    const double *s = m->state->drive.at;
    double inertia = d->inertia, held = 0.0;
    for (int64_t i = 0; i < d->along.size; i++) {
        double old = m->x.old[i], now = m->x.now[i];
        inertia += d->along.at[i] * (old + now);
        held += 0.5 * d->held.at[i] * (old + now);
    }
    const SpeedScratch *tension = &m->scratch->speed;
    double speed = s[DRIVE_SPEED], gained = m->stage.numbers->time_step * s[DRIVE_ACCELERATION];
    held += 0.5 * speed * gained * dot(m->x.old, tension->stiffened.at, d->along.size);
    double present = s[DRIVE_MOMENTUM] - s[DRIVE_IMPULSE] + s[DRIVE_MOVED];
    records->rotor_energy.at[row] = speed * present - 0.5 * speed * speed * inertia + held;
    for (int64_t i = 0; i < DRIVE_NUMBERS; i++)
        records->drive.at[row * DRIVE_NUMBERS + i] = m->state->drive.at[i];
}

#endif
