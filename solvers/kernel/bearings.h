/* Bearings: springs and dampers in static axes between places of the rotor and the ground or supports.
 *
 * A place of the rotor moves by u = B x in rotating axes, its support by s = S y in static axes; without
 * a support s is zero. At step n, with the rotation R by psi from rotating to static axes, the force on
 * the rotor in rotating axes is
 *
 *     f = -R^T K R d - R^T C R v,   d = u_n - R^T s_n,
 *     v = (u_{n+1} - u_{n-1}) / (2 h) + Omega J u_n - R^T (s_{n+1} - s_{n-1}) / (2 h)
 *
 * and -R f acts on the support. As the force changes x_{n+1}, the forces of all bearings follow from
 *
 *     (1 + R^T C R W / (2 h)) f = f of the predicted step,   W = B A^-1 B^T + S c S^T
 *
 * W is the same in both axes, as supports move alike along x and y. Bearings respond to a contact force
 * from the next step on. A matrix is stored as k_0 and k_2 of K u = k_0 z + k_2 conj(z) with z = u_x +
 * i u_y; in rotating axes k_2 is multiplied by exp(-2 i psi).
 *
 * The energy of the springs at n - 1/2 is D_{n-1}^T K D_n / 2 with the symmetric part of K and the
 * displacement D = R d in static axes. The work of the dampers is DAMPING; the rest is the work of the
 * drive and of forces across displacements, which is PARAMETRIC.
 */
#ifndef BEARINGS_H
#define BEARINGS_H

#include "turning.h"

/* Return the product of a matrix, stored as k_0 and k_2, and u; c and s turn k_2. */
static inline void turned_product(const double *k, double c, double s, const double *u, double *out)
{
    double a = k[2] * c + k[3] * s, b = k[3] * c - rounded(k[2] * s);
    out[0] = (k[0] + a) * u[0] + (b - k[1]) * u[1];
    out[1] = (k[1] + b) * u[0] + (k[0] - a) * u[1];
}

/* Turn a vector by the angle with cosine c and sine s. */
static inline void turn_vector(double c, double s, const double *u, double *out)
{
    double x = u[0] * c - rounded(u[1] * s);
    out[1] = u[0] * s + u[1] * c;
    out[0] = x;
}

/* Compute the products of a matrix with an even number of rows and a padded vector. */
static void all_products(const Matrix *rows, const double *x, double *out)
{
    int64_t i = 0, width = rows->columns;
    for (; i + 4 <= rows->rows; i += 4) {
        const double *row = rows->at + i * width;
        Half sum[4];
        for (int k = 0; k < 4; k++)
            sum[k] = half_splat(0.0);
        for (int64_t j = 0; j < width; j += HALF) {
            Half by = half_load(x + j);
            for (int k = 0; k < 4; k++)
                sum[k] = half_muladd(half_load(row + k * width + j), by, sum[k]);
        }
        half_store(out + i, half_totals(sum[0], sum[1], sum[2], sum[3]));
    }
    for (; i < rows->rows; i += 2) {
        const double *row = rows->at + i * width;
        Half one = half_splat(0.0), two = one;
        for (int64_t j = 0; j < width; j += HALF) {
            Half by = half_load(x + j);
            one = half_muladd(half_load(row + j), by, one);
            two = half_muladd(half_load(row + width + j), by, two);
        }
        out[i] = half_total(one);
        out[i + 1] = half_total(two);
    }
}

/* Compute the displacements of both ends for coordinates of rotor and casing. */
static void bearing_ends(const Bearings *b, const double *x, const double *y, double *place,
                         double *other)
{
    all_products(&b->rotor, x, place);
    all_products(&b->casing, y, other);
}

/* Compute D in static axes from the displacements of both ends. */
static void bearing_stretch(const Bearings *b, double c, double s, const double *place,
                            const double *other, double *out)
{
    for (int64_t i = 0; i < b->rotor.rows; i += 2) {
        turn_vector(c, s, place + i, out + i);
        if (b->casing.rows > 0) {
            out[i] -= other[i];
            out[i + 1] -= other[i + 1];
        }
    }
}

/* Return D^T K E with the symmetric part of K. */
static double bearing_energy(const Bearings *b, const double *d, const double *e)
{
    double energy = 0.0;
    for (int64_t i = 0; i < b->rotor.rows; i += 2) {
        const double *k = b->stiffness.at + 2 * i;
        double symmetric[4] = {k[0], 0.0, k[2], k[3]}, pull[2];
        turned_product(symmetric, 1.0, 0.0, e + i, pull);
        energy += d[i] * pull[0] + d[i + 1] * pull[1];
    }
    return energy;
}

/* Compute the present displacements and angle at the first step of a call. Returns the energy of the
 * springs at n - 1/2. */
static double turn_bearings(March *m, int first)
{
    const Bearings *b = m->stage.bearings;
    BearingScratch *w = &m->scratch->bearings;
    int64_t ends = b->rotor.rows;
    if (first) {
        double *stretch = w->stretch.at, *cosine = w->turn.at;
        bearing_ends(b, m->x.old, m->y.old, w->place.at, w->other.at);
        bearing_ends(b, m->x.now, m->y.now, w->place.at + ends, w->other.at + ends);
        for (int k = 0; k < 2; k++) {
            cosine[0] = cos(m->rotation.angle[k]);
            cosine[1] = sin(m->rotation.angle[k]);
            bearing_stretch(b, cosine[0], cosine[1], w->place.at + k * ends, w->other.at + k * ends,
                            stretch + k * ends);
        }
        w->energy = bearing_energy(b, w->stretch.at, w->stretch.at + ends);
    }
    return 0.5 * w->energy;
}

/* Compute the forces of `ends` / 2 bearings from those without their response, `force`: solve (1 + C W)
 * f = force, where `turned` are the entries of each matrix C, by rows, and the rows of W are padded to
 * `registers`. The diagonal dominates for small time steps. */
INLINED void solve_some(const Bearings *b, int64_t ends, int registers, const double *turned,
                        double *rows, double *force)
{
    int64_t width = registers * LANES;
    for (int64_t i = 0; i < ends; i += 2, turned += 4)
        for (int64_t j = 0; j < width; j += LANES) {
            const double *unit = b->unit.at + i * width + j, *by = b->compliance.at + i * width + j;
            Lanes x = load(by), y = load(by + width), known = load(b->unit.at + ends * width + j);
            for (int k = 0; k < 2; k++) {
                Lanes one = muladd(splat(force[i + k]), known, load(unit + k * width));
                one = muladd(splat(turned[2 * k]), x, one);
                store(rows + (i + k) * width + j, muladd(splat(turned[2 * k + 1]), y, one));
            }
        }
    for (int64_t p = 0; p < ends; p += 2) {
        double *one = rows + p * width, *two = one + width;
        double a = one[p], c = one[p + 1], d = two[p], e = two[p + 1];
        double inverse = 1.0 / (a * e - rounded(c * d));
        Lanes a_by = splat(a * inverse), c_by = splat(c * inverse);
        Lanes d_by = splat(d * inverse), e_by = splat(e * inverse);
        for (int64_t j = 0; j < width; j += LANES) {
            Lanes first = load(one + j), second = load(two + j);
            store(one + j, sub(mul(e_by, first), mul(c_by, second)));
            store(two + j, sub(mul(a_by, second), mul(d_by, first)));
        }
        for (int64_t i = 0; i < ends; i++) {
            double *row = rows + i * width;
            if (i == p || i == p + 1)
                continue;
            Lanes by_one = splat(row[p]), by_two = splat(row[p + 1]);
            for (int64_t j = 0; j < width; j += LANES) {
                Lanes left = sub(load(row + j), mul(by_one, load(one + j)));
                store(row + j, sub(left, mul(by_two, load(two + j))));
            }
        }
    }
    for (int64_t i = 0; i < ends; i++)
        force[i] = rows[i * width + ends];
}

/* Compute the forces of the bearings from those without their response. */
static void solve_bearings(const Bearings *b, BearingScratch *w)
{
    double *force = w->force.at, *rows = w->system.at;
    int64_t ends = b->rotor.rows, width = b->compliance.columns;
    if (b->inverse.rows > 0) {
        for (int64_t i = 0; i < ends; i++)
            rows[i] = dot(b->inverse.at + i * ends, force, ends);
        for (int64_t i = 0; i < ends; i++)
            force[i] = rows[i];
        return;
    }
    switch (ends) {
    case 4: solve_some(b, 4, 1, w->turned.at, rows, force); break;
    case 6: solve_some(b, 6, 1, w->turned.at, rows, force); break;
    default: solve_some(b, ends, (int)(width / LANES), w->turned.at, rows, force);
    }
}

/* Compute the velocity v of a bearing in rotating axes, with displacements at n + 1. */
static inline void bearing_velocity(const March *m, int64_t i, double c, double s, double *out)
{
    const BearingScratch *w = &m->scratch->bearings;
    int64_t ends = w->force.size;
    double rate = 0.5 / m->stage.numbers->time_step, omega = m->rotation.now;
    const double *old = w->place.at + i, *now = old + ends, *new = now + ends;
    out[0] = (new[0] - old[0]) * rate - rounded(omega * now[1]);
    out[1] = (new[1] - old[1]) * rate + omega * now[0];
    if (w->other.rows > 0) {
        const double *s_old = w->other.at + i, *s_new = s_old + 2 * ends;
        double moved[2] = {(s_new[0] - s_old[0]) * rate, (s_new[1] - s_old[1]) * rate}, turned[2];
        turn_vector(c, -s, moved, turned);
        out[0] -= turned[0];
        out[1] -= turned[1];
    }
}

/* Add the sum of rows times factors to a padded vector, in some registers from the entry i on. */
INLINED void answer_some(const Matrix *rows, int registers, int64_t i, const double *factor, double *out)
{
    Lanes sum[6];
    for (int k = 0; k < registers; k++)
        sum[k] = load(out + i + k * LANES);
    const double *row = rows->at + i;
    for (int64_t n = 0; n < rows->rows; n++, row += rows->columns) {
        Lanes by = splat(factor[n]);
        for (int k = 0; k < registers; k++)
            sum[k] = muladd(by, load(row + k * LANES), sum[k]);
    }
    for (int k = 0; k < registers; k++)
        store(out + i + k * LANES, sum[k]);
}

/* Add the sum of rows times factors to a padded vector. */
static void answer_forces(const Matrix *rows, const double *factor, double *out)
{
    int64_t i = 0;
    for (; i + 6 * LANES <= rows->columns; i += 6 * LANES)
        answer_some(rows, 6, i, factor, out);
    for (; i < rows->columns; i += LANES)
        answer_some(rows, 1, i, factor, out);
}

/* Add the response to the forces of the bearings to the predicted x_{n+1} and y_{n+1}. */
static void add_bearings(March *m)
{
    const Bearings *b = m->stage.bearings;
    BearingScratch *w = &m->scratch->bearings;
    int64_t ends = b->rotor.rows;
    double c = w->turn.at[0], s = w->turn.at[1], c2 = c * c - rounded(s * s), s2 = 2.0 * c * s;
    double *new = w->place.at + 2 * ends, *other = w->other.at + 2 * ends, *force = w->force.at;
    double rate = 0.5 / m->stage.numbers->time_step;
    bearing_ends(b, m->x.new, m->y.new, new, other);
    for (int64_t i = 0; i < ends; i += 2) {
        double turned[2], velocity[2], pull[2], drag[2];
        const double *stretch = w->place.at + ends + i;
        if (b->casing.rows > 0) {
            turn_vector(c, -s, w->stretch.at + ends + i, turned);
            stretch = turned;
        }
        bearing_velocity(m, i, c, s, velocity);
        const double *damping = b->damping.at + 2 * i;
        turned_product(b->stiffness.at + 2 * i, c2, s2, stretch, pull);
        turned_product(damping, c2, s2, velocity, drag);
        w->spring.at[i] = -pull[0];
        w->spring.at[i + 1] = -pull[1];
        force[i] = -pull[0] - drag[0];
        force[i + 1] = -pull[1] - drag[1];
        double *matrix = w->turned.at + 2 * i, a = damping[2] * c2 + damping[3] * s2;
        double turn = damping[3] * c2 - rounded(damping[2] * s2);
        matrix[0] = rate * (damping[0] + a);
        matrix[1] = rate * (turn - damping[1]);
        matrix[2] = rate * (damping[1] + turn);
        matrix[3] = rate * (damping[0] - a);
    }
    if (b->damped)
        solve_bearings(b, w);
    answer_forces(&b->answer, force, m->x.new);
    if (b->casing.rows == 0)
        return;
    for (int64_t i = 0; i < ends; i += 2) {
        turn_vector(c, s, force + i, w->on_casing.at + i);
        w->on_casing.at[i] = -w->on_casing.at[i];
        w->on_casing.at[i + 1] = -w->on_casing.at[i + 1];
    }
    answer_forces(&b->casing_answer, w->on_casing.at, m->y.new);
}

/* Return the torque of the bearings on the rotation, with the tilt of the shaft at bearings that act on
 * it. */
static double bearing_torque(const March *m)
{
    const BearingScratch *w = &m->scratch->bearings;
    const double *now = w->place.at + w->force.size, *force = w->force.at;
    double torque = 0.0;
    for (int64_t i = 0; i < w->force.size; i += 2)
        torque += now[i] * force[i + 1] - rounded(now[i + 1] * force[i]);
    return torque;
}

/* Return whether the displacements at all bearings are within the limit at n + 1. */
static int bearings_keep_limit(const March *m)
{
    const BearingScratch *w = &m->scratch->bearings;
    const double *new = w->place.at + 2 * w->force.size;
    double limit = m->stage.numbers->displacement_limit;
    for (int64_t i = 0; i < w->force.size; i++)
        if (!(new[i] <= limit && -new[i] <= limit)) /* not with NaN */
            return 0;
    return 1;
}

/* Add the works of the bearings in a step, and keep what the next step needs. */
static void account_bearings(March *m, int64_t step)
{
    const Bearings *b = m->stage.bearings;
    BearingScratch *w = &m->scratch->bearings;
    int64_t ends = b->rotor.rows;
    double c = w->turn.at[0], s = w->turn.at[1], *place = w->place.at, *other = w->other.at;
    double dt = m->stage.numbers->time_step, done = 0.0, lost = 0.0;
    bearing_ends(b, m->x.new, m->y.new, place + 2 * ends, other + 2 * ends);
    for (int64_t i = 0; i < ends; i += 2) {
        double velocity[2];
        bearing_velocity(m, i, c, s, velocity);
        for (int k = 0; k < 2; k++) {
            int64_t at = i + k;
            done += 0.5 * w->force.at[at] * (place[2 * ends + at] - place[at]);
            lost -= dt * (w->force.at[at] - w->spring.at[at]) * velocity[k];
            if (b->casing.rows > 0)
                done += 0.5 * w->on_casing.at[at] * (other[2 * ends + at] - other[at]);
        }
    }
    double angle = m->stage.speed ? m->rotation.next
                                  : m->stage.numbers->angle_per_step * (double)(step + 1);
    w->turn.at[0] = cos(angle);
    w->turn.at[1] = sin(angle);
    double *old = w->stretch.at, *now = old + ends, *new = now + ends;
    bearing_stretch(b, w->turn.at[0], w->turn.at[1], place + 2 * ends, other + 2 * ends, new);
    double energy = bearing_energy(b, now, new), stored = 0.5 * (energy - w->energy);
    w->energy = energy;
    for (int64_t i = 0; i < 2 * ends; i++) {
        place[i] = place[i + ends];
        old[i] = old[i + ends];
        if (b->casing.rows > 0)
            other[i] = other[i + ends];
    }
    m->state->work.at[DAMPING] += lost;
    m->state->work.at[PARAMETRIC] += done + stored + lost;
    if (m->stage.drive) /* which has the work of the torque */
        m->state->drive.at[DRIVE_CONTACT] += done + stored + lost;
}

#endif
