/* Evaluation of displacements of blades and casing nodes.
 *
 * Modal coordinates are first summed over rows with weights, which gives a number for each column.
 * A shape matrix then converts these numbers to values at blades or casing nodes; see `march.c`.
 */
#ifndef FIELDS_H
#define FIELDS_H

#include "motion.h"

/* Return the position of the partner columns of a register. */
static inline int64_t partner_columns(int64_t h, int64_t half)
{
    return h < half ? h + half : h - half;
}

/* Sum modal coordinates over rows with weights. Each sum is stored in the partner of its column, or
 * in its column if `half` is zero. */
INLINED void column_sums(const Matrix *weight, const double *x, int64_t half, double *out)
{
    int64_t rows = weight->rows, columns = weight->columns;
    for (int64_t h = 0; h < columns; h += LANES) {
        const double *w = weight->at + h, *v = x + h;
        Lanes even = splat(0.0), odd = splat(0.0); /* two independent sums run in parallel */
        int64_t m = 0;
        for (; m + 1 < rows; m += 2, w += 2 * columns, v += 2 * columns) {
            even = muladd(load(w), load(v), even);
            odd = muladd(load(w + columns), load(v + columns), odd);
        }
        if (m < rows)
            even = muladd(load(w), load(v), even);
        store(out + partner_columns(h, half), add(even, odd));
    }
}

/* Compute a linear combination of all rows of a matrix. */
INLINED void combine_rows(const Matrix *rows, const double *factor, double *out)
{
    int64_t width = rows->columns, i = 0;
    for (; i + 3 * LANES <= width; i += 3 * LANES) {
        Lanes first = splat(0.0), second = splat(0.0), third = splat(0.0);
        const double *row = rows->at + i;
        for (int64_t n = 0; n < rows->rows; n++, row += width) {
            Lanes f = splat(factor[n]);
            first = muladd(load(row), f, first);
            second = muladd(load(row + LANES), f, second);
            third = muladd(load(row + 2 * LANES), f, third);
        }
        store(out + i, first);
        store(out + i + LANES, second);
        store(out + i + 2 * LANES, third);
    }
    for (; i < width; i += LANES) {
        Lanes first = splat(0.0);
        for (int64_t n = 0; n < rows->rows; n++)
            first = muladd(load(rows->at + n * width + i), splat(factor[n]), first);
        store(out + i, first);
    }
}

/* Store the sums of `fold_field` at the points n, N/2 - n, N/2 + n and N - n; `start` is added, or
 * NULL. */
INLINED void unfold(Lanes cos_even, Lanes cos_odd, Lanes sin_even, Lanes sin_odd, int64_t i,
                    int64_t middle, const double *start, double *out)
{
    Lanes near = add(cos_even, cos_odd), far = sub(cos_even, cos_odd);
    Lanes turned = add(sin_even, sin_odd), back = sub(sin_even, sin_odd);
    Lanes first = add(near, turned), second = add(far, back);
    int64_t x = middle - i - LANES + 1;
    store(out + i, start ? add(first, load(start + i)) : first);
    store(out + middle + i, start ? add(second, load(start + middle + i)) : second);
    store_reversed(out + x, sub(far, back), start ? start + x : NULL);
    store_reversed(out + middle + x, sub(near, turned), start ? start + middle + x : NULL);
}

/* Compute a field at an even number of points of the circle, N = 2 `middle`, from its columns, four
 * points at a time; point 0 is repeated. The cosines and sines at the points n, N/2 - n, N/2 + n and
 * N - n differ only by their signs, which depend on the parity of the harmonic. The rows of `fold`
 * are cosines of even harmonics, cosines of odd ones, sines of even ones, sines of odd ones, and the
 * cosine of N/2 in the position of a sine. `slopes` are the columns of a second field, or NULL; the
 * rows of `start` are added to the rows of `out`, unless `start` is NULL. */
INLINED void fold_field(const Matrix *fold, int64_t half, int64_t middle, const double *values,
                        const double *slopes, const Matrix *start, double *out, int64_t wide)
{
    int64_t width = fold->columns, used = fold->rows / 4;
    for (int64_t i = 0; i < width; i += LANES) {
        Lanes ce = splat(0.0), co = ce, se = ce, so = ce, de = ce, d_o = ce, te = ce, to = ce;
        const double *row = fold->at + i;
        for (int64_t h = 0; h < used; h++, row += width) {
            Lanes even = load(row), odd = load(row + used * width);
            ce = muladd(even, splat(values[h]), ce);
            co = muladd(odd, splat(values[used + h]), co);
            if (slopes) {
                de = muladd(even, splat(slopes[h]), de);
                d_o = muladd(odd, splat(slopes[used + h]), d_o);
            }
            even = load(row + 2 * used * width);
            odd = load(row + 3 * used * width);
            se = muladd(even, splat(values[half + h]), se);
            so = muladd(odd, splat(values[half + used + h]), so);
            if (slopes) {
                te = muladd(even, splat(slopes[half + h]), te);
                to = muladd(odd, splat(slopes[half + used + h]), to);
            }
        }
        Lanes last = load(fold->at + 4 * used * width + i);
        ce = muladd(last, splat(values[half + used - 1]), ce);
        unfold(ce, co, se, so, i, middle, start ? start->at : NULL, out);
        if (slopes) {
            de = muladd(last, splat(slopes[half + used - 1]), de);
            unfold(de, d_o, te, to, i, middle, start->at + start->columns, out + wide);
        }
    }
}

/* Compute values and slopes of a field at the casing nodes from its columns.
 * Returns the values and slopes: those of the start for a rigid wall. */
static const Matrix *nodal_field(const Casing *casing, const NodalField *field, FieldScratch *f)
{
    const Matrix *start = &field->start;
    double *value = f->nodal.at, *slope = f->nodal.at + f->nodal.columns;
    if (casing->modes == 0)
        return start;
    if (casing->fold.rows > 0) {
        fold_field(&casing->fold, casing->half, casing->nodes / 2, f->value.at, f->slope.at, start,
                   f->nodal.at, f->nodal.columns);
        return &f->nodal;
    }
    for (int64_t wall = 0, width = field->shape.columns; wall + 1 < casing->first.size; wall++) {
        int64_t first = casing->first.at[wall], rows = casing->first.at[wall + 1] - first;
        Matrix own = {.at = field->shape.at + first * width, .rows = rows, .columns = width};
        combine_rows(&own, f->value.at + first, value + wall * width);
        own.at = field->slope_shape.at + first * width;
        combine_rows(&own, f->slope.at + first, slope + wall * width);
    }
    for (int64_t i = 0; i < start->columns; i += LANES) {
        store(value + i, add(load(value + i), load(start->at + i)));
        store(slope + i, add(load(slope + i), load(start->at + start->columns + i)));
    }
    return &f->nodal;
}

/* Return the value of a nodal Hermite field on an element, with the weights of a place on it. */
static inline double hermite_value(const Matrix *nodal, int64_t element, const double *weight,
                                   int64_t width)
{
    const double *value = nodal->at + element, *slope = value + nodal->columns;
    return (weight[0] * value[0] + weight[width] * slope[0])
           + (weight[2 * width] * value[1] + weight[3 * width] * slope[1]);
}

/* Compute a field of the rotor at the blades from its sums by column. */
INLINED void blade_values(const Rotor *rotor, const double *sums, double *out)
{
    if (rotor->fold.rows > 0)
        fold_field(&rotor->fold, rotor->half, rotor->spread.rows / 2, sums, NULL, NULL, out, 0);
    else
        combine_rows(&rotor->shape, sums, out);
}

/* Sum a field of the rotor by column, by harmonic, from the weights of the modes in their columns and,
 * unless `across` is NULL, in the partner columns. */
INLINED void blade_sums(const Rotor *rotor, const double *own, const double *across, const double *x,
                        FieldScratch *f)
{
    int64_t columns = rotor->own.columns, half = rotor->half;
    Matrix weight = {.at = (double *)own, .rows = rotor->own.rows, .columns = columns};
    column_sums(&weight, x, 0, f->sums.at);
    if (across) {
        double *partner = f->partner.at;
        weight.at = (double *)across;
        column_sums(&weight, x, 0, partner);
        for (int64_t h = 0; h < half; h++)
            partner[columns + h] = partner[h];
        for (int64_t h = 0; h < columns; h += LANES)
            store(f->sums.at + h, add(load(f->sums.at + h), load(partner + half + h)));
    }
}

/* Compute this field at the blades. */
INLINED void blade_field(const Rotor *rotor, const double *own, const double *across,
                         const double *x, FieldScratch *f, double *out)
{
    blade_sums(rotor, own, across, x, f);
    blade_values(rotor, f->sums.at, out);
}

/* Sum a component of the displacements of a blade by column. */
INLINED void component_sums(const Rotor *rotor, int64_t component, const double *x, FieldScratch *f)
{
    int64_t at = component * rotor->own.rows * rotor->own.columns;
    const double *across = rotor->crosses.at[component] ? rotor->across.at + at : NULL;
    blade_sums(rotor, rotor->own.at + at, across, x, f);
}

/* Compute a component of the displacements of all nodes for modal coordinates x. Without harmonics,
 * only copies that are `wanted` are computed, or all of them if it is NULL. */
INLINED void node_field(const Rotor *rotor, int64_t direction, const double *x,
                        const IntVector *wanted, FieldScratch *f, double *out)
{
    if (rotor->half > 0) {
        int64_t blades = rotor->spread.rows, each = rotor->own.layers / DIRECTIONS;
        for (int64_t i = 0; i < each; i++) {
            double *to = each > 1 ? f->blades.at : out;
            component_sums(rotor, DIRECTIONS * i + direction, x, f);
            blade_values(rotor, f->sums.at, to);
            for (int64_t b = 0; each > 1 && b < blades; b++)
                out[b * each + i] = to[b];
        }
        return;
    }
    int64_t modes = rotor->columns.rows, count = rotor->columns.columns;
    int64_t entries = rotor->body.a.size / rotor->copies;
    for (int64_t copy = 0; copy < rotor->copies; copy++) {
        double *to = out + copy * count;
        if (wanted && !wanted->at[copy])
            continue;
        for (int64_t i = 0; i < count; i++)
            to[i] = 0.0;
        add_rows(x + copy * entries, rotor->columns.at + direction * modes * count, modes, count, to);
    }
}

/* Compute the element at each position and the Hermite weights; a row of `hermite` has `width`
 * numbers. */
static inline void hermite_weights(const double *restrict places, double turned, double nodes,
                                   double length, int64_t count, int64_t width,
                                   int64_t *restrict element, double *restrict hermite)
{
    double turn = 1.0 / nodes;
    for (int64_t j = 0; j < count; j++) {
        double at = places[j] + turned;
        at -= nodes * floor(at * turn);
        at = at < 0.0 ? 0.0 : at; /* negative only by rounding of the product */
        double start = floor(at), xi = at - start, rest = 1.0 - xi;
        /* By rounding, the position may be node `nodes`, which is node 0. If displacements diverge,
         * which ends the march, the position may be any number. */
        start = start >= 0.0 ? start : 0.0;
        element[j] = (int32_t)(start < nodes ? start : 0.0); /* unlike int64_t, with AVX2 */
        hermite[j] = rest * rest * (1.0 + 2.0 * xi);
        hermite[width + j] = length * xi * rest * rest;
        hermite[2 * width + j] = xi * xi * (3.0 - 2.0 * xi);
        hermite[3 * width + j] = -length * xi * xi * rest;
    }
}

/* Compute the value of a nodal Hermite field under each node. Returns 0 if any value is NaN. */
static inline int field_at_nodes(const Matrix *nodal, const FieldScratch *f, double *out)
{
    int finite = 1;
    for (int64_t j = 0; j < f->element.size; j++) {
        double at_node =
            hermite_value(nodal, f->element.at[j], f->hermite.at + j, f->hermite.columns);
        out[j] = at_node;
        finite &= at_node == at_node;
    }
    return finite;
}

/* Return the recess of each node minus the closure above it at a time, for the present positions of
 * the nodes. */
static inline const double *recess_at(const Rotor *rotor, const Closure *closure, double time,
                                      FieldScratch *f)
{
    if (!closure)
        return rotor->recess.at;
    double rate, closed = closure_at(closure, time, &rate);
    for (int64_t j = 0; j < f->element.size; j++) {
        double share = hermite_value(&closure->share, f->element.at[j], f->hermite.at + j,
                                     f->hermite.columns);
        f->recess.at[j] = rotor->recess.at[j] - rotor->normal_part.at[j] * closed * share;
    }
    return f->recess.at;
}

#endif
