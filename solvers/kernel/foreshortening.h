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
 * Its part - g_m A^-1 (...) also gives the opening after the correction by the contact forces. If
 * the blades of a cyclic rotor are equal, F consists of DFT columns like the rows of u_r and u_t,
 * see `march.c`. The gradients g of single tips have no such structure; their products with x and
 * their sums take most of the time.
 *
 * The opening of tips far from the wall has no effect; it is extrapolated from the last check.
 */
#ifndef FORESHORTENING_H
#define FORESHORTENING_H

#include <stddef.h>

#include "fields.h"

enum { AT_ONCE = 6 }; /* most rows that are read together: their sums fill the registers */

/* Return the number of rows to read together, at most AT_ONCE, of those that are left. */
static inline int64_t rows_at_once(int64_t left)
{
    int64_t parts = (left + AT_ONCE - 1) / AT_ONCE;
    return (left + parts - 1) / parts;
}

/* Compute the products of a few rows with a vector; `row` numbers the rows. */
INLINED void some_products(const double *rows, const int64_t *row, int count, int64_t width,
                           const double *restrict x, double *restrict out)
{
    const double *from[AT_ONCE];
    Lanes sum[AT_ONCE];
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

/* Add a few rows with factors to `start`, or to zero if it is NULL. */
INLINED void add_some(const double *rows, const int64_t *row, int count, int64_t width,
                      const double *factor, const double *start, double *out)
{
    const double *from[AT_ONCE];
    Lanes with[AT_ONCE];
    for (int k = 0; k < count; k++) {
        from[k] = rows + row[k] * width;
        with[k] = splat(factor[k]);
    }
    for (int64_t i = 0; i < width; i += LANES) {
        Lanes sum = start ? load(start + i) : splat(0.0);
        for (int k = 0; k < count; k++)
            sum = muladd(load(from[k] + i), with[k], sum);
        store(out + i, sum);
    }
}

/* Call a function with a constant number of rows, so that the compiler keeps sums in registers. */
#define SOME(function, count, rows, row, width, ...)                                               \
    switch (count) {                                                                               \
    case 1: function(rows, row, 1, width, __VA_ARGS__); break;                                     \
    case 2: function(rows, row, 2, width, __VA_ARGS__); break;                                     \
    case 3: function(rows, row, 3, width, __VA_ARGS__); break;                                     \
    case 4: function(rows, row, 4, width, __VA_ARGS__); break;                                     \
    case 5: function(rows, row, 5, width, __VA_ARGS__); break;                                     \
    default: function(rows, row, AT_ONCE, width, __VA_ARGS__);                                     \
    }

/* Compute the products of rows with a vector, several rows at a time, because the additions of one
 * sum have to wait for each other. */
static void products(const double *rows, const int64_t *row, int64_t count, int64_t width,
                     const double *x, double *out)
{
    for (int64_t n = 0, some; n < count; n += some) {
        some = rows_at_once(count - n);
        SOME(some_products, some, rows, row + n, width, x, out + n)
    }
}

/* Add rows with factors to `start`, which may be `out`, or to zero if it is NULL. */
static void add_chosen(const double *rows, const int64_t *row, int64_t count, int64_t width,
                       const double *factor, const double *start, double *out)
{
    for (int64_t n = 0, some; n < count; n += some) {
        some = rows_at_once(count - n);
        if (start)
            SOME(add_some, some, rows, row + n, width, factor + n, start, out)
        else
            SOME(add_some, some, rows, row + n, width, factor + n, NULL, out)
        start = out;
    }
}

/* Compute y of a tip. */
static inline void bend_of(const Foreshortening *b, int64_t tip, const double *x, double *out)
{
    int64_t terms = b->rows.rows, entries = b->rows.columns;
    products(b->rows.at + tip * terms * entries, b->order.at, terms, entries, x, out);
}

/* Compute a sum of the rows of a tip with the factors z. */
static inline void sum_rows(const Foreshortening *b, const Cube *rows, int64_t tip, const double *z,
                            double *out)
{
    int64_t terms = rows->rows, entries = rows->columns;
    add_chosen(rows->at + tip * terms * entries, b->order.at, terms, entries, z, NULL, out);
}

/* Compute the gradient of a tip with the factors z. */
static void gradient_of(const Foreshortening *b, int64_t tip, const double *z, double *out)
{
    int64_t columns = b->own.columns, size = b->own.rows * columns;
    const double *own = b->own.at, *across = b->across.at;
    const double *spread = b->spread.at + tip * b->spread.columns;
    if (b->own.layers == 0) {
        sum_rows(b, &b->rows, tip, z, out);
        return;
    }
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes shape = load(spread + h), cross_shape = load(spread + columns + h);
        for (int64_t i = h; i < size; i += columns) {
            Lanes even = splat(0.0), odd = even;
            for (int64_t k = 0; k < b->own.layers; k++) {
                even = muladd(load(own + k * size + i), splat(z[k]), even);
                odd = muladd(load(across + k * size + i), splat(z[k]), odd);
            }
            store(out + i, add(mul(even, shape), mul(odd, cross_shape)));
        }
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
    s->due.at[tip] = -INFINITY;
    gradient_of(b, tip, z, s->gradient.at + tip * s->gradient.columns);
    if (b->answers.layers > 0)
        sum_rows(b, &b->answers, tip, z, s->answer.at + tip * s->answer.columns);
}

/* Treat a tip as far from the wall. */
static inline void release(const Foreshortening *b, BendScratch *s, int64_t tip)
{
    s->near.at[tip] = 0;
    s->due.at[tip] = b->near.at[tip];
    for (int64_t k = 0; k < s->factor.columns; k++)
        s->factor.at[tip * s->factor.columns + k] = 0.0;
}

/* List the tips near the wall. */
static inline void list_near(BendScratch *s)
{
    int64_t count = 0;
    for (int64_t j = 0; j < s->near.size; j++)
        if (s->near.at[j] != 0)
            s->list.at[count++] = j;
    s->count.at[NEAR_TIPS] = count;
}

/* Compute y of all tips, a row for each term; by harmonic on a cyclic rotor. */
static void bend_of_all(const Foreshortening *b, const Rotor *rotor, const double *x,
                        FieldScratch *f, BendScratch *s, double *out)
{
    int64_t terms = b->rows.rows, wide = s->opened.size, size = b->own.rows * b->own.columns;
    for (int64_t k = 0; k < b->own.layers; k++)
        blade_field(rotor, b->own.at + k * size, b->across.at + k * size, x, f, out + k * wide);
    for (int64_t j = 0; b->own.layers == 0 && j < s->near.size; j++) {
        bend_of(b, j, x, s->term.at);
        for (int64_t k = 0; k < terms; k++)
            out[k * wide + j] = s->term.at[k];
    }
}

/* Compute the openings of all tips from x_n, and their first and second differences between
 * checks, which at the start follow from the velocities. */
static void check_openings(const Foreshortening *b, const Rotor *rotor, State *state, int64_t step,
                           Motion x, FieldScratch *f, BendScratch *s)
{
    int64_t wide = state->checked.columns;
    double steps = (double)b->check, *now = s->bend.at, *change = s->bent.at;
    bend_of_all(b, rotor, x.now, f, s, now);
    if (step == 0) {
        for (int64_t i = 0; i < x.entries; i += LANES)
            store(s->expected.at + i, sub(load(x.now + i), load(x.old + i)));
        bend_of_all(b, rotor, s->expected.at, f, s, change);
    }
    for (int64_t j = 0; j < s->near.size; j++) {
        const double *sign = b->sign.at + j * b->sign.columns;
        double opening = 0.0, rate = 0.0, bent = 0.0, *checked = state->checked.at + j;
        for (int64_t k = 0, i = j; k < b->rows.rows; k++, i += wide) {
            opening += 0.5 * sign[k] * now[i] * now[i];
            rate += steps * sign[k] * now[i] * change[i];
            bent += 0.5 * steps * steps * sign[k] * change[i] * change[i];
        }
        if (step == 0) {
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
static int find_near(const Foreshortening *b, const Rotor *rotor, State *state, const double *gap,
                     int64_t step, Motion x, FieldScratch *f, BendScratch *s)
{
    double end = (double)((step / b->hold + 1) * b->hold - 1);
    double ahead = 0.5 * (end - (double)step);
    int64_t waves = b->own.layers;
    int changed = 0, fresh = 0;
    for (int64_t j = 0; j < s->near.size; j++)
        if (state->until.at[j] < (double)step) {
            changed |= s->near.at[j] != 0;
            if (gap[j] < b->near.at[j]) {
                double *bend = state->bend.at + j * state->bend.columns;
                for (int64_t i = 0; !fresh && i < x.entries; i += LANES) {
                    Lanes moved = sub(load(x.now + i), load(x.old + i));
                    store(s->expected.at + i, muladd(splat(ahead), moved, load(x.new + i)));
                }
                if (waves > 0 && !fresh)
                    bend_of_all(b, rotor, s->expected.at, f, s, s->bend.at);
                if (waves == 0)
                    bend_of(b, j, s->expected.at, bend);
                for (int64_t k = 0; k < waves; k++)
                    bend[k] = s->bend.at[k * s->bend.columns + j];
                linearise(b, j, bend, s);
                state->until.at[j] = end;
                changed = fresh = 1;
            } else if (s->near.at[j] != 0)
                release(b, s, j);
        }
    if (changed)
        list_near(s);
    return changed;
}

/* Compute the openings at a step of tips far from the wall, and find the tips near the wall.
 * Returns whether any gradient has changed. */
static inline int bend_tips(const Foreshortening *b, const Rotor *rotor, State *state,
                            const double *gap, int64_t step, Motion x, FieldScratch *f,
                            BendScratch *s)
{
    int64_t *count = s->count.at, wide = state->checked.columns;
    if (count[SINCE_CHECK] == 0)
        check_openings(b, rotor, state, step - 1, x, f, s);
    double part = (double)++count[SINCE_CHECK] / (double)b->check;
    if (count[SINCE_CHECK] == b->check)
        count[SINCE_CHECK] = 0;
    if (++count[SINCE_HOLD] == b->hold)
        count[SINCE_HOLD] = 0;
    Half first = half_splat(part), second = half_splat(0.5 * part * (part + 1.0));
    Half none = half_splat(0.0), below = none;
    for (int64_t j = 0; j < wide; j += HALF) {
        Half opening = half_load(state->checked.at + j);
        opening = half_muladd(first, half_load(state->checked.at + wide + j), opening);
        opening = half_muladd(second, half_load(state->checked.at + 2 * wide + j), opening);
        half_store(s->opened.at + j, half_larger(opening, none));
        Half depth = half_sub(half_load(s->due.at + j), half_load(gap + j));
        below = half_add(below, half_larger(depth, none));
    }
    int ended = count[NEAR_TIPS] > 0 && count[SINCE_HOLD] == 0;
    return (ended || half_total(below) > 0.0) && find_near(b, rotor, state, gap, step, x, f, s);
}

/* Add the openings at displacements x to the gaps. */
static inline void open_gaps(BendScratch *s, const double *x, double *gap)
{
    int64_t count = s->count.at[NEAR_TIPS];
    if (count > 0)
        products(s->gradient.at, s->list.at, count, s->gradient.columns, x, s->along.at);
    for (int64_t n = 0; n < count; n++) {
        int64_t j = s->list.at[n];
        s->opened.at[j] = s->start.at[j] + s->along.at[n];
    }
    for (int64_t j = 0; j < s->opened.size; j += LANES)
        store(gap + j, add(load(gap + j), load(s->opened.at + j)));
}

/* Compute the openings with the contact forces of the group. */
static inline void open_further(const BendScratch *s, const NodeScratch *c, int64_t size,
                                double *opened)
{
    int64_t wide = s->opens.columns;
    for (int64_t j = 0; j < wide; j += LANES) {
        Lanes sum = load(s->opened.at + j);
        for (int64_t n = 0; s->count.at[NEAR_TIPS] > 0 && n < size; n++)
            sum = muladd(splat(c->multiplier.at[n]), load(s->opens.at + n * wide + j), sum);
        store(opened + j, sum);
    }
}

/* Compute the openings due to a unit force on a tip of the group, the nth, and add the change of its
 * column of W due to the gradients. `slides` is the friction coefficient times the direction of
 * sliding. */
static void bend_answers(const Foreshortening *b, BendScratch *s, const NodeScratch *c,
                         int64_t n, int64_t size, double slides)
{
    int64_t wide = s->factor.columns, terms = b->rows.rows, tips = s->near.size;
    int64_t j = c->list.at[n], bent = s->near.at[j];
    const double *z_n = s->factor.at + j * wide;
    double *opens = s->opens.at + n * s->opens.columns;
    double *on_rotor = c->on_rotor.at + n * c->on_rotor.columns;
    for (int64_t m = 0; m < s->opens.columns; m += LANES)
        store(opens + m, splat(0.0));
    for (int64_t i = 0; i < s->count.at[NEAR_TIPS]; i++) {
        int64_t m = s->list.at[i], pair = j * tips + m;
        const double *z_m = s->factor.at + m * wide, *crossed = b->crossed.at + pair * terms * wide;
        Lanes sum = splat(0.0);
        for (int64_t l = 0; l < wide; l += LANES) {
            Lanes moved = mul(splat(-slides), load(b->by_drag.at + pair * wide + l));
            moved = sub(moved, load(b->by_push.at + pair * wide + l));
            for (int64_t k = 0; bent && k < terms; k++)
                moved = muladd(load(crossed + k * wide + l), splat(z_n[k]), moved);
            sum = muladd(moved, load(z_m + l), sum);
        }
        opens[m] = total(sum);
    }
    for (int64_t i = 0; i < size; i++) {
        int64_t m = c->list.at[i];
        if (s->near.at[m] != 0)
            on_rotor[i] += opens[m];
        if (bent)
            on_rotor[i] -= dot(b->felt.at + (j * tips + m) * wide, z_n, wide);
    }
}

/* Sum the gradients of some tips with a force on each of them, and add the response to this sum to x.
 * Returns whether any of the tips is near the wall. */
static int push_along(const Foreshortening *b, const int64_t *tip, int64_t size,
                      const double *force, const double *c, double *x, BendScratch *s)
{
    int64_t count = 0, width = s->gradient.columns;
    for (int64_t n = 0; n < size; n++)
        if (s->near.at[tip[n]] != 0) {
            s->along.at[count] = force[n];
            s->pushed.at[count++] = tip[n];
        }
    add_chosen(s->gradient.at, s->pushed.at, count, width, s->along.at, NULL, s->force.at);
    if (b->answers.layers > 0)
        add_chosen(s->answer.at, s->pushed.at, count, width, s->along.at, x, x);
    for (int64_t i = 0; count > 0 && b->answers.layers == 0 && i < width; i += LANES)
        store(x + i, muladd(load(c + i), load(s->force.at + i), load(x + i)));
    return count > 0;
}

/* Compute the gradients at the start of a number of steps from the state after `step`. */
static void resume_bending(const Foreshortening *b, const State *state, int64_t step,
                           BendScratch *s)
{
    for (int64_t j = 0; j < s->due.size; j++)
        s->due.at[j] = b->near.at[j];
    for (int64_t j = 0; j < s->near.size; j++) {
        if (state->until.at[j] > (double)step)
            linearise(b, j, state->bend.at + j * state->bend.columns, s);
        else
            release(b, s, j);
    }
    list_near(s);
    s->count.at[SINCE_CHECK] = step % b->check;
    s->count.at[SINCE_HOLD] = step % b->hold;
}

#endif
