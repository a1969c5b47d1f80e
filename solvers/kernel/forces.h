/* Contact forces on tips and casing nodes, their sums by column, and the response to them. */
#ifndef FORCES_H
#define FORCES_H

#include "contact.h"

/* Friction by column on one body: `ratio` times the row `drag` of forces, for the casing also the
 * next row. */
typedef struct {
    int64_t drag;
    double ratio;
} Friction;

/* Compute the forces on the active tips and on the two casing nodes next to each tip. `factor` gets
 * the normal force and the friction force on each tip, and the forces w, w', u, u' on each node.
 * Returns whether tips slide in different directions; if not, `ratio` gets the ratio of friction to
 * normal force. */
static inline int tip_forces(int64_t size, double friction, int64_t nodes, const FieldScratch *f,
                             ContactScratch *c, double *ratio)
{
    int64_t width = f->hermite.columns, wide = c->factor.columns;
    double *factor = c->factor.at;
    int mixed = 0;
    *ratio = 0.0;
    for (int64_t m = 0; m < size; m++) {
        int64_t j = c->active.at[m], e = f->element.at[j];
        double push = c->multiplier.at[j], slides = friction * c->sign.at[j];
        mixed |= m > 0 && slides != *ratio;
        *ratio = slides;
        factor[PUSH * wide + m] = -push;
        factor[DRAG * wide + m] = -push * slides;
        for (int64_t end = 0; end < 2; end++) {
            int64_t n = 2 * m + end;
            double value = push * f->hermite.at[2 * end * width + j];
            double slope = push * f->hermite.at[(2 * end + 1) * width + j];
            c->rows.at[n] = e + end < nodes ? e + end : 0;
            factor[W_KIND * wide + n] = value;
            factor[W_SLOPE * wide + n] = slope;
            factor[U_KIND * wide + n] = slides * value;
            factor[U_SLOPE * wide + n] = slides * slope;
        }
    }
    return mixed;
}

/* Sum forces at points by column, and store the first half of the columns again after the last. */
static inline void spread(const Matrix *rows, const int64_t *index, ContactScratch *c,
                          int64_t which, int64_t count, int64_t half)
{
    const double *factor = c->factor.at + which * c->factor.columns;
    double *to = c->columns.at + which * c->columns.columns;
    for (int64_t h = 0; h < rows->columns; h += LANES) {
        Lanes x = splat(0.0);
        for (int64_t n = 0; n < count; n++)
            x = muladd(load(rows->at + index[n] * rows->columns + h), splat(factor[n]), x);
        store(to + h, x);
        if (h < half)
            store(to + rows->columns + h, x);
    }
}

/* Do the same as `spread` for two kinds of forces with the same shape, two registers at a time. */
static inline void spread_two(const Matrix *rows, const int64_t *index, ContactScratch *c,
                              int64_t which, int64_t count, int64_t half)
{
    const double *a = c->factor.at + which * c->factor.columns, *b = a + c->factor.columns;
    int64_t columns = rows->columns;
    for (int64_t h = 0; h < columns; h += 2 * LANES) {
        Lanes a0 = splat(0.0), a1 = a0, b0 = a0, b1 = a0;
        for (int64_t n = 0; n < count; n++) {
            const double *row = rows->at + index[n] * columns + h;
            Lanes x0 = load(row), x1 = load(row + LANES);
            a0 = muladd(x0, splat(a[n]), a0);
            a1 = muladd(x1, splat(a[n]), a1);
            b0 = muladd(x0, splat(b[n]), b0);
            b1 = muladd(x1, splat(b[n]), b1);
        }
        double *to = c->columns.at + which * c->columns.columns + h, *next = to + c->columns.columns;
        store(to, a0);
        store(to + LANES, a1);
        store(next, b0);
        store(next + LANES, b1);
        if (h < half) {
            store(to + columns, a0);
            store(next + columns, b0);
        }
        if (h + LANES < half) {
            store(to + columns + LANES, a1);
            store(next + columns + LANES, b1);
        }
    }
}

/* Sum the forces on the tips by column. If all tips slide in the same direction, and friction has
 * the same shape as the normal force, then friction is a multiple of the normal force. */
static inline Friction rotor_columns(const Rotor *rotor, int64_t size, int mixed, double ratio,
                                     ContactScratch *c)
{
    spread(&rotor->spread, c->active.at, c, PUSH, size, rotor->half);
    if (rotor->shared && !mixed)
        return (Friction){PUSH, ratio};
    spread(&rotor->drag_spread, c->active.at, c, DRAG, size, rotor->half);
    return (Friction){DRAG, 1.0};
}

/* Sum a number of forces on the casing nodes by column. */
static inline Friction casing_columns(const Casing *casing, int64_t count, int mixed, double ratio,
                                      ContactScratch *c)
{
    const NodalField *radial = &casing->radial, *tangential = &casing->tangential;
    const int64_t *rows = c->rows.at;
    int64_t half = casing->half;
    if (casing->shared) {
        spread_two(&radial->spread, rows, c, W_KIND, count, half);
        if (!mixed)
            return (Friction){W_KIND, ratio};
        spread_two(&tangential->spread, rows, c, U_KIND, count, half);
    } else {
        spread(&radial->spread, rows, c, W_KIND, count, half);
        spread(&radial->slope_spread, rows, c, W_SLOPE, count, half);
        spread(&tangential->spread, rows, c, U_KIND, count, half);
        spread(&tangential->slope_spread, rows, c, U_SLOPE, count, half);
    }
    return (Friction){U_KIND, 1.0};
}

/* Add the response to contact forces on the tips to x_{n+1}. `along` is the part of the normal
 * forces due to foreshortening, or NULL. Also compute the work of these forces, and the sums by
 * column of u_r. */
INLINED void correct_rotor(const Rotor *rotor, int64_t size, int mixed, double ratio,
                           const double *along, Motion x, FieldScratch *f, ContactScratch *c)
{
    Friction friction = rotor_columns(rotor, size, mixed, ratio, c);
    int64_t rows = rotor->radial.rows, columns = rotor->radial.columns;
    const double *push_at = c->columns.at + PUSH * c->columns.columns;
    const double *drag_at = c->columns.at + friction.drag * c->columns.columns;
    Lanes on_normal = splat(0.0), on_shear = on_normal, slides = splat(friction.ratio);
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes push = load(push_at + h), drag = mul(slides, load(drag_at + h));
        Lanes cross = mul(slides, load(drag_at + rotor->half + h)), column = splat(0.0);
        for (int64_t i = h; i < rows * columns; i += columns) {
            Lanes weight = load(rotor->radial.at + i), normal = mul(push, weight);
            Lanes shear = mul(cross, load(rotor->crossed.at + i));
            shear = muladd(drag, load(rotor->tangential.at + i), shear);
            if (along)
                normal = add(normal, load(along + i));
            Lanes moved = muladd(load(rotor->body.c.at + i), add(normal, shear), load(x.new + i));
            Lanes change = sub(moved, load(x.old + i));
            store(x.new + i, moved);
            on_normal = muladd(change, normal, on_normal);
            on_shear = muladd(change, shear, on_shear);
            column = muladd(weight, moved, column);
        }
        store(f->rotor.at + h, column);
    }
    c->work.at[0] = 0.5 * total(on_normal);
    c->work.at[1] = 0.5 * total(on_shear);
}

/* Add the response to contact forces on the casing to x_{n+1}. Also add the work of these forces to
 * the work on the rotor, and compute the sums by column of w and w'. */
static void correct_casing(const Casing *casing, int64_t size, int mixed, double ratio, Motion y,
                           FieldScratch *f, ContactScratch *c)
{
    Friction friction = casing_columns(casing, 2 * size, mixed, ratio, c);
    const NodalField *radial = &casing->radial, *tangential = &casing->tangential;
    int64_t rows = radial->weight.rows, columns = radial->weight.columns, half = casing->half;
    int64_t wide = c->columns.columns;
    const double *push_at = c->columns.at + W_KIND * wide;
    const double *drag_at = c->columns.at + friction.drag * wide;
    Lanes on_normal = splat(0.0), on_shear = on_normal, slides = splat(friction.ratio);
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes on_w = load(push_at + h), on_w_slope = load(push_at + wide + half + h);
        Lanes on_u = mul(slides, load(drag_at + half + h));
        Lanes on_u_slope = mul(slides, load(drag_at + wide + h));
        Lanes value = splat(0.0), slope = value;
        for (int64_t i = h; i < rows * columns; i += columns) {
            Lanes w = load(radial->weight.at + i), w_slope = load(radial->slope_weight.at + i);
            Lanes normal = muladd(on_w, w, mul(on_w_slope, w_slope));
            Lanes shear = mul(on_u_slope, load(tangential->slope_weight.at + i));
            shear = muladd(on_u, load(tangential->weight.at + i), shear);
            Lanes moved = muladd(load(casing->body.c.at + i), add(normal, shear), load(y.new + i));
            Lanes change = sub(moved, load(y.old + i));
            store(y.new + i, moved);
            on_normal = muladd(change, normal, on_normal);
            on_shear = muladd(change, shear, on_shear);
            value = muladd(w, moved, value);
            slope = muladd(w_slope, moved, slope);
        }
        store(f->value.at + h, value);
        store(f->slope.at + partner_columns(h, half), slope);
    }
    c->work.at[0] += 0.5 * total(on_normal);
    c->work.at[1] += 0.5 * total(on_shear);
}

/* Add the impulses of an accepted step with contact, and the work that stops closing tips. */
static inline void account_contact(const Numbers *numbers, State *state, const ContactScratch *c,
                                   const double *gap, const double *before)
{
    int64_t contacts = 0;
    for (int64_t j = 0; j < c->multiplier.size; j++) {
        state->held.at[j] = 0.0;
        if (c->multiplier.at[j] > 0.0) {
            double impulse = c->multiplier.at[j] * numbers->time_step;
            state->held.at[j] = 1.0;
            contacts++;
            state->impulse.at[j] += impulse;
            state->drag.at[j] += numbers->friction * c->sign.at[j] * impulse;
            state->touched.at[j] += 1.0;
            state->work.at[CLOSING] += 0.5 * c->multiplier.at[j] * (gap[j] - before[j]);
        }
    }
    state->counts.at[STEP_CONTACTS] = (double)contacts;
    state->counts.at[CONTACT_STEPS] += 1.0;
}

#endif
