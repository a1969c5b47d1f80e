/* Gaps that open as blades bend: the tip of a bent blade draws back towards its root.
 *
 * The gap of a tip opens by 1/2 sum_i s_i y_i^2 with y = F x. For a number of steps the opening of a
 * tip near the wall is linear in x, with the gradient g = F^T z, z = s y, at the displacement
 * expected in the middle of these steps. The tangents of a parabola at the middles of successive
 * intervals meet where the intervals meet, so the opening is continuous. The contact force on the
 * tip acts along the gradient of the gap. If n and t are the rows of u_r and u_t, the change of the
 * gap of tip m due to a unit force on tip n is
 *
 *     (n_m - g_m) A^-1 (n_n - g_n + mu s t_n)
 *
 * The opening of tips far from the wall has no effect; it is extrapolated from the last check.
 */
#ifndef FORESHORTENING_H
#define FORESHORTENING_H

#include "fields.h"

/* Compute the products of one to four rows with a vector; `row` numbers the rows. */
INLINED void some_products(const double *rows, const int64_t *row, int count, int64_t width,
                           const double *restrict x, double *restrict out)
{
    const double *from[4];
    Lanes sum[4];
    for (int k = 0; k < count; k++) {
        from[k] = rows + row[k] * width;
        sum[k] = splat(0.0);
    }
    for (int64_t i = 0; i < width; i += LANES) {
        Lanes with = load(x + i);
        for (int k = 0; k < count; k++)
            sum[k] = muladd(load(from[k] + i), with, sum[k]);
    }
    for (int k = 0; k < count; k++)
        out[k] = total(sum[k]);
}

/* Compute the products of rows with a vector; rows in parallel, as each sum waits for itself. */
static inline void products(const double *rows, const int64_t *row, int64_t count, int64_t width,
                            const double *x, double *out)
{
    int64_t n = 0;
    for (; n + 4 <= count; n += 4)
        some_products(rows, row + n, 4, width, x, out + n);
    if (count - n == 3)
        some_products(rows, row + n, 3, width, x, out + n);
    else if (count - n == 2)
        some_products(rows, row + n, 2, width, x, out + n);
    else if (count - n == 1)
        some_products(rows, row + n, 1, width, x, out + n);
}

/* Compute y of a tip. */
static inline void bend_of(const Foreshortening *b, int64_t tip, const double *x, double *out)
{
    int64_t terms = b->rows.rows, entries = b->rows.columns;
    products(b->rows.at + tip * terms * entries, b->order.at, terms, entries, x, out);
}

/* Compute a sum of rows of a tip, `rows`, with the factors z. */
static inline void sum_rows(const Cube *rows, int64_t tip, const double *z, double *out)
{
    int64_t entries = rows->columns;
    const double *from = rows->at + tip * rows->rows * entries;
    for (int64_t i = 0; i < entries; i += LANES) {
        Lanes sum = splat(0.0);
        for (int64_t k = 0; k < rows->rows; k++)
            sum = muladd(load(from + k * entries + i), splat(z[k]), sum);
        store(out + i, sum);
    }
}

/* Compute opening and gradient of a tip near the wall from y at the linearisation. */
static void linearise(const Foreshortening *b, int64_t tip, const double *bend, BendScratch *s)
{
    double *z = s->factor.at + tip * s->factor.columns, twice = 0.0;
    const double *sign = b->sign.at + tip * b->sign.columns;
    for (int64_t k = 0; k < b->rows.rows; k++) {
        z[k] = sign[k] * bend[k];
        twice += z[k] * bend[k];
    }
    s->start.at[tip] = -0.5 * twice;
    s->near.at[tip] = 1;
    sum_rows(&b->rows, tip, z, s->gradient.at + tip * s->gradient.columns);
    if (b->answers.layers > 0)
        sum_rows(&b->answers, tip, z, s->answer.at + tip * s->answer.columns);
}

/* Treat a tip as far from the wall. */
static inline void release(BendScratch *s, int64_t tip)
{
    s->near.at[tip] = 0;
    for (int64_t k = 0; k < s->factor.columns; k++)
        s->factor.at[tip * s->factor.columns + k] = 0.0;
}

/* Compute the openings of all tips from x_n, and their first and second differences between
 * checks, which at the start follow from the velocities. */
static void check_openings(const Foreshortening *b, State *state, int64_t step, Motion x,
                           BendScratch *s)
{
    int64_t wide = state->checked.columns;
    double steps = (double)b->check, *now = s->bend.at, *change = now + s->bend.columns;
    for (int64_t i = 0; step == 0 && i < x.entries; i += LANES)
        store(s->expected.at + i, sub(load(x.now + i), load(x.old + i)));
    for (int64_t j = 0; j < s->near.size; j++) {
        const double *sign = b->sign.at + j * b->sign.columns;
        double opening = 0.0, rate = 0.0, bent = 0.0, *checked = state->checked.at + j;
        bend_of(b, j, x.now, now);
        for (int64_t k = 0; k < b->rows.rows; k++)
            opening += 0.5 * sign[k] * now[k] * now[k];
        if (step == 0) {
            bend_of(b, j, s->expected.at, change);
            for (int64_t k = 0; k < b->rows.rows; k++) {
                rate += steps * sign[k] * now[k] * change[k];
                bent += 0.5 * steps * steps * sign[k] * change[k] * change[k];
            }
            checked[wide] = rate - bent;
            checked[2 * wide] = 2.0 * bent;
        } else {
            double difference = opening - checked[0];
            checked[2 * wide] = difference - checked[wide];
            checked[wide] = difference;
        }
        checked[0] = opening;
    }
}

/* Find the tips near the wall at a step from their gaps without foreshortening, and linearise the
 * openings of those whose linearisation has ended. Returns whether any gradient has changed. */
static int find_near(const Foreshortening *b, State *state, const double *gap, int64_t step,
                     Motion x, BendScratch *s)
{
    int64_t tips = s->near.size, count = 0;
    double end = (double)((step / b->hold + 1) * b->hold - 1);
    double ahead = 0.5 * (end - (double)step);
    int changed = 0, fresh = 0;
    for (int64_t j = 0; j < tips; j++) {
        if (state->until.at[j] < (double)step) {
            changed |= s->near.at[j] != 0;
            if (gap[j] < b->near.at[j]) {
                double *bend = state->bend.at + j * state->bend.columns;
                for (int64_t i = 0; !fresh && i < x.entries; i += LANES) {
                    Lanes moved = sub(load(x.now + i), load(x.old + i));
                    store(s->expected.at + i, muladd(splat(ahead), moved, load(x.new + i)));
                }
                bend_of(b, j, s->expected.at, bend);
                linearise(b, j, bend, s);
                state->until.at[j] = end;
                changed = fresh = 1;
            } else if (s->near.at[j] != 0)
                release(s, j);
        }
        if (s->near.at[j] != 0)
            s->list.at[count++] = j;
    }
    s->count.at[0] = count;
    return changed;
}

/* Compute the openings at a step of tips far from the wall, and find the tips near the wall.
 * Returns whether any gradient has changed. */
static inline int bend_tips(const Foreshortening *b, State *state, const double *gap, int64_t step,
                            Motion x, BendScratch *s)
{
    int64_t since = (step - 1) % b->check, wide = state->checked.columns;
    if (since == 0)
        check_openings(b, state, step - 1, x, s);
    double part = (double)(since + 1) / (double)b->check;
    Half first = half_splat(part), second = half_splat(0.5 * part * (part + 1.0)), none = half_splat(0.0), below = none;
    for (int64_t j = 0; j < wide; j += HALF) {
        Half opening = half_load(state->checked.at + j);
        opening = half_muladd(first, half_load(state->checked.at + wide + j), opening);
        opening = half_muladd(second, half_load(state->checked.at + 2 * wide + j), opening);
        half_store(s->opened.at + j, half_larger(opening, none));
        Half depth = half_sub(half_load(b->near.at + j), half_load(gap + j));
        below = half_add(below, half_larger(depth, none));
    }
    return (half_total(below) > 0.0 || s->count.at[0] > 0) && find_near(b, state, gap, step, x, s);
}

/* Add the openings at displacements x to the gaps. */
static inline void open_gaps(BendScratch *s, const double *x, double *gap)
{
    int64_t count = s->count.at[0];
    if (count > 0)
        products(s->gradient.at, s->list.at, count, s->gradient.columns, x, s->along.at);
    for (int64_t n = 0; n < count; n++) {
        int64_t j = s->list.at[n];
        s->opened.at[j] = s->start.at[j] + s->along.at[n];
    }
    for (int64_t j = 0; j < s->opened.size; j += LANES)
        store(gap + j, add(load(gap + j), load(s->opened.at + j)));
}

/* Return the change of W due to the gradients: the gap of tip m due to a unit force on tip n, with
 * `slides`, the friction coefficient times the direction of sliding. */
static inline double bend_answer(const Foreshortening *b, const BendScratch *s, int64_t n,
                                 int64_t m, double slides)
{
    int64_t wide = s->factor.columns, terms = b->rows.rows, pair = n * s->near.size + m;
    const double *z_n = s->factor.at + n * wide, *z_m = s->factor.at + m * wide;
    const double *crossed = b->crossed.at + pair * terms * wide;
    Lanes sum = splat(0.0);
    for (int64_t i = 0; i < wide; i += LANES) {
        Lanes moved = splat(0.0);
        for (int64_t k = 0; k < terms; k++)
            moved = muladd(load(crossed + k * wide + i), splat(z_n[k]), moved);
        moved = sub(moved, load(b->by_push.at + pair * wide + i));
        moved = sub(moved, mul(splat(slides), load(b->by_drag.at + pair * wide + i)));
        sum = muladd(moved, load(z_m + i), sum);
        sum = sub(sum, mul(load(b->felt.at + pair * wide + i), load(z_n + i)));
    }
    return total(sum);
}

/* Add the rows of a matrix with the contact forces of tips, and the vector `from`, to `out`. */
INLINED void add_pushes(const Matrix *rows, const int64_t *tip, const double *push, int64_t count,
                        const double *from, double *out)
{
    const double *at = rows->at;
    int64_t width = rows->columns;
    for (int64_t i = 0; i < width; i += LANES) {
        Lanes sum = load(from + i);
        for (int64_t n = 0; n < count; n++)
            sum = muladd(splat(push[n]), load(at + tip[n] * width + i), sum);
        store(out + i, sum);
    }
}

/* Compute the sum of the gradients with the contact forces of the active tips, and add the response
 * to it. Returns whether it is not zero. */
static inline int push_along(const Foreshortening *b, const ContactScratch *c, int64_t size,
                             const double *inverse, Motion x, BendScratch *s)
{
    int64_t count = 0, *active = s->pushed.at;
    for (int64_t n = 0; n < size; n++)
        if (s->near.at[c->active.at[n]] != 0) {
            s->along.at[count] = c->multiplier.at[c->active.at[n]];
            active[count++] = c->active.at[n];
        }
    if (count == 0)
        return 0;
    add_pushes(&s->gradient, active, s->along.at, count, s->none.at, s->force.at);
    if (b->answers.layers > 0)
        add_pushes(&s->answer, active, s->along.at, count, x.new, x.new);
    else
        for (int64_t i = 0; i < x.entries; i += LANES)
            store(x.new + i, muladd(load(s->force.at + i), load(inverse + i), load(x.new + i)));
    return 1;
}

/* Return the work d^T f of these forces with d = (x_{n+1} - x_{n-1}) / 2. */
static inline double bending_work(const BendScratch *s, Motion x)
{
    Lanes sum = splat(0.0);
    for (int64_t i = 0; i < x.entries; i += LANES)
        sum = muladd(sub(load(x.new + i), load(x.old + i)), load(s->force.at + i), sum);
    return 0.5 * total(sum);
}

/* Compute the gradients at the start of a number of steps from the state after `step`. */
static void resume_bending(const Foreshortening *b, const State *state, int64_t step,
                           BendScratch *s)
{
    for (int64_t j = 0; j < s->near.size; j++) {
        if (state->until.at[j] > (double)step)
            linearise(b, j, state->bend.at + j * state->bend.columns, s);
        else
            release(s, j);
    }
    s->count.at[0] = s->near.size; /* `find_near` finds the number at the next step */
}

#endif
