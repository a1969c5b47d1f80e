/* Motion of a rotor with Coriolis forces, where the matrix A couples the modes.
 *
 * With A = M / dt^2 + C / (2 dt), the term (C / (2 dt) - M / dt^2) x_{n-1} of the scheme is equal
 * to (A - 2 M / dt^2) x_{n-1}. The recurrence of each mode therefore gives A (x_{n+1} - x_{n-1})
 * and does not need C. One product with A^-1 follows. Forces are added before this product, so the
 * functions of `motion.h` are used with c = 1.
 */
#ifndef TURNING_H
#define TURNING_H

#include "fields.h"

/* Return the scalar product of a row and a padded vector. */
static inline double product(const Matrix *rows, int64_t row, const double *x)
{
    return dot(rows->at + row * rows->columns, x, rows->columns);
}

/* Add the force of static dampers due to x_n; `share` is the speed divided by that of `g`. */
static inline void add_circulation(const Gyroscopic *g, double share, Motion x)
{
    for (int64_t m = 0; m < g->centre.rows; m++) {
        Lanes moved = splat(share * product(&g->centre, m, x.now));
        const double *row = g->circulation.at + m * x.entries;
        for (int64_t i = 0; i < x.entries; i += LANES)
            store(x.new + i, muladd(load(row + i), moved, load(x.new + i)));
    }
}

/* Return the work d^T f of this force with d = (x_{n+1} - x_{n-1}) / 2. */
static inline double circulation_work(const Gyroscopic *g, double share, Motion x)
{
    double work = 0.0;
    for (int64_t m = 0; m < g->centre.rows; m++) {
        double moved = product(&g->circulation, m, x.new) - product(&g->circulation, m, x.old);
        work += 0.5 * moved * product(&g->centre, m, x.now);
    }
    return share * work;
}

/* Return d^T D d from the upper triangle for all modes. */
static double full_loss(const Gyroscopic *g, const double *moved)
{
    int64_t columns = g->full_loss.columns;
    Lanes loss = splat(0.0);
    for (int64_t n = 0, own = 0; n < g->full_loss.rows; n++, own++) {
        own = own == columns ? 0 : own;
        if (g->loss_end.at[n] == 0)
            continue;
        const double *others = moved + n - own; /* the modes of the same copy */
        Lanes by = splat(moved[n]);
        for (int64_t i = own - own % LANES; i < g->loss_end.at[n]; i += LANES) {
            Lanes force = mul(by, load(g->full_loss.at + n * columns + i));
            loss = muladd(force, load(others + i), loss);
        }
    }
    return 0.25 * total(loss);
}

/* Return d^T D d with d = (x_{n+1} - x_{n-1}) / 2; `moved` is scratch. */
static double turning_loss(const Rotor *rotor, const Gyroscopic *g, Motion x, double *moved)
{
    int64_t rows = rotor->own.rows, columns = rotor->own.columns, half = rotor->half;
    int crosses = g->loss_crosses != 0;
    const double *at = g->loss.at;
    Half lost = half_splat(0.0);
    for (int64_t i = 0; i < x.entries; i += LANES)
        store(moved + i, sub(load(x.new + i), load(x.old + i)));
    if (g->loss.size == 0)
        return full_loss(g, moved);
    for (int64_t h = 0; h < half; h += HALF)
        for (int64_t m = 0; m < rows; m += ROWS) {
            Half on_cosine[ROWS], on_sine[ROWS];
            for (int k = 0; k < ROWS; k++)
                on_cosine[k] = on_sine[k] = half_splat(0.0);
            for (int64_t n = m; n < rows; n++, at += (1 + crosses) * ROWS * HALF) {
                Half cosine = half_load(moved + n * columns + h);
                Half sine = half_load(moved + n * columns + half + h);
                Half minus = half_sub(half_splat(0.0), cosine);
                for (int k = 0; k < ROWS; k++) {
                    Half d = half_load(at + k * HALF);
                    on_cosine[k] = half_muladd(d, cosine, on_cosine[k]);
                    on_sine[k] = half_muladd(d, sine, on_sine[k]);
                    if (!crosses)
                        continue;
                    Half across = half_load(at + (ROWS + k) * HALF);
                    on_cosine[k] = half_muladd(across, sine, on_cosine[k]);
                    on_sine[k] = half_muladd(across, minus, on_sine[k]);
                }
            }
            for (int k = 0; k < ROWS; k++)
                if (m + k < rows) {
                    const double *own = moved + (m + k) * columns + h;
                    lost = half_muladd(on_sine[k], half_load(own + half), lost);
                    lost = half_muladd(on_cosine[k], half_load(own), lost);
                }
        }
    return 0.25 * half_total(lost);
}

/* Store `from` plus the product of f and the rows of a copy, which begin with the row `start`, in a
 * number of registers of `out` from the column i on. */
INLINED void add_spans(const ModalMatrix *matrix, int64_t start, int64_t span, int registers,
                       int64_t i, const double *f, const double *from, double *out)
{
    const Matrix *full = &matrix->full;
    Lanes sum[LANES];
    int64_t n = matrix->first.at[span];
    const double *row = full->at + (start + n) * full->columns + i;
    for (int k = 0; k < registers; k++)
        sum[k] = load(from + i + k * LANES);
    for (; n < matrix->last.at[span]; n++, row += full->columns) {
        Lanes force = splat(f[n]);
        for (int k = 0; k < registers; k++)
            sum[k] = muladd(load(row + k * LANES), force, sum[k]);
    }
    for (int k = 0; k < registers; k++)
        store(out + i + k * LANES, sum[k]);
}

/* Store `from` + A^-1 f of a copy in `out`, for any rotor; `full` has `modes` rows for each copy. Spans
 * with the same rows are added together, as sums of few registers wait for each other. */
static void add_full(const ModalMatrix *matrix, int64_t copy, int64_t modes, const double *f,
                     const double *from, double *out)
{
    const int64_t *first = matrix->first.at, *last = matrix->last.at;
    int64_t spans = matrix->full.columns / (2 * LANES), start = copy * modes, together;
    for (int64_t k = 0, span = copy * spans; k < spans; k += together, span += together) {
        int64_t i = 2 * LANES * k;
        for (together = 1; together < 3 && k + together < spans; together++)
            if (first[span + together] != first[span] || last[span + together] != last[span])
                break;
        if (together == 3)
            add_spans(matrix, start, span, 6, i, f, from, out);
        else if (together == 2)
            add_spans(matrix, start, span, 4, i, f, from, out);
        else
            add_spans(matrix, start, span, 2, i, f, from, out);
    }
}

/* Store `from` plus the product of a matrix and f of a cyclic rotor in `out`, ROWS rows of cosine
 * and sine modes at a time. `crossing` is 0 if the blocks X are zero and left out. */
static inline void blocks_product(const Rotor *rotor, const ModalMatrix *g, const double *f,
                                  const double *from, double *out, int crossing)
{
    int64_t rows = rotor->own.rows, columns = rotor->own.columns, half = rotor->half;
    const double *at = g->blocks.at;
    for (int64_t h = 0; h < half; h += HALF)
        for (int64_t m = 0; m < rows; m += ROWS) {
            Half to_cosine[ROWS], to_sine[ROWS];
            for (int k = 0; k < ROWS; k++)
                to_cosine[k] = to_sine[k] = half_splat(0.0);
            for (int64_t n = 0; n < rows; n++, at += (1 + crossing) * ROWS * HALF) {
                Half cosine = half_load(f + n * columns + h);
                Half sine = half_load(f + n * columns + half + h);
                Half minus = half_sub(half_splat(0.0), cosine);
                for (int k = 0; k < ROWS; k++) {
                    Half own = half_load(at + k * HALF);
                    to_cosine[k] = half_muladd(own, cosine, to_cosine[k]);
                    to_sine[k] = half_muladd(own, sine, to_sine[k]);
                    if (!crossing)
                        continue;
                    Half across = half_load(at + (ROWS + k) * HALF);
                    to_cosine[k] = half_muladd(across, sine, to_cosine[k]);
                    to_sine[k] = half_muladd(across, minus, to_sine[k]);
                }
            }
            for (int k = 0; k < ROWS; k++)
                if (m + k < rows) {
                    int64_t i = (m + k) * columns + h;
                    half_store(out + i, half_add(half_load(from + i), to_cosine[k]));
                    half_store(out + i + half, half_add(half_load(from + i + half), to_sine[k]));
                }
        }
    for (int64_t k = 0; k < g->rest.size; k++)
        out[g->to.at[k]] += g->rest.at[k] * f[g->by.at[k]];
}

/* Store `from` plus the product of a matrix and f in `out`. */
static void add_product(const Rotor *rotor, const ModalMatrix *matrix, int64_t entries,
                        const double *f, const double *from, double *out)
{
    if (rotor->half > 0) {
        blocks_product(rotor, matrix, f, from, out, 1);
        return;
    }
    int64_t columns = matrix->full.columns, copies = entries / columns;
    for (int64_t copy = 0; copy < copies; copy++) {
        int64_t at = copy * columns;
        add_full(matrix, copy, matrix->full.rows / copies, f + at, from + at, out + at);
    }
}

/* Replace the forces in the place of x_{n+1} by x_{n+1} = x_{n-1} + A^-1 f, where f includes a
 * further force unless it is NULL; `f` is scratch. */
static inline void turn(const Rotor *rotor, const Gyroscopic *g, Motion x, const double *further,
                        double *f)
{
    for (int64_t i = 0; i < x.entries; i += LANES)
        store(f + i, further ? add(load(x.new + i), load(further + i)) : load(x.new + i));
    add_product(rotor, &g->inverse, x.entries, f, x.old, x.new);
}

#endif
