/* Contact forces on rotor and casing, their sums by column, and the response to them. */
#ifndef FORCES_H
#define FORCES_H

#include "turning.h"

/* Return the position of a node without the rotation of the rotor [elements], see `place_nodes`. */
static inline double position_of(const March *m, int64_t node)
{
    int turns = m->stage.numbers->tip_rotation > 0.0;
    return (turns ? m->scratch->fields.at.at : m->stage.rotor->position.at)[node];
}

/* Sum a number of forces of some kinds at points by column, with the same shape, and store the first
 * half of the columns again after the last. There is a row of factors, and of sums, for each kind. */
INLINED void spread(const Matrix *rows, const int64_t *index, const double *factor, int64_t wide,
                    int kinds, int64_t count, int64_t half, double *sums, int64_t width)
{
    int64_t columns = rows->columns;
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes sum[KINDS];
        for (int k = 0; k < kinds; k++)
            sum[k] = splat(0.0);
        for (int64_t n = 0; n < count; n++) {
            Lanes row = load(rows->at + index[n] * columns + h);
            for (int k = 0; k < kinds; k++)
                sum[k] = muladd(row, splat(factor[k * wide + n]), sum[k]);
        }
        for (int k = 0; k < kinds; k++) {
            store(sums + k * width + h, sum[k]);
            if (h < half)
                store(sums + k * width + columns + h, sum[k]);
        }
    }
}

/* Sum the forces on the nodes of the list by column, for each component of a blade. `ratio` is that of
 * tangential to radial forces if it is the same for all, otherwise NULL. */
static void blade_columns(const March *m, int64_t size, const double *ratio, const double *force)
{
    const Rotor *rotor = m->stage.rotor;
    const int64_t *list = m->scratch->nodes.list.at;
    ContactScratch *c = &m->scratch->contact;
    int64_t each = rotor->own.layers / DIRECTIONS, wide = c->factor.columns, half = rotor->half;
    int64_t width = c->blades.columns;
    int directions = rotor->axial > 0.0 ? 3 : 2;
    double *factor = c->factor.at;
    for (int64_t i = 0; i < each; i++) {
        double *sums = c->blades.at + DIRECTIONS * i * width;
        int64_t count = 0, *rows = c->rows.at;
        for (int64_t n = 0; n < size; n++) {
            int64_t blade = each > 1 ? list[n] / each : list[n];
            if (list[n] - blade * each != i)
                continue;
            rows[count] = blade;
            for (int k = 0; k < directions; k++)
                factor[k * wide + count] = force[DIRECTIONS * list[n] + k];
            count++;
        }
        if (ratio) {
            spread(&rotor->spread, rows, factor, wide, 1, count, half, sums, width);
            for (int64_t h = 0; h < width; h += LANES)
                store(sums + width + h, mul(splat(*ratio), load(sums + h)));
        } else if (directions == 2)
            spread(&rotor->spread, rows, factor, wide, 2, count, half, sums, width);
        else
            spread(&rotor->spread, rows, factor, wide, 3, count, half, sums, width);
    }
}

/* Weights of a component of a blade, and forces on it by column. */
typedef struct {
    const double *own, *across, *answer, *answer_across, *by;
} Component;

static inline Component component_of(const March *m, int64_t part)
{
    const Rotor *rotor = m->stage.rotor;
    const Matrix *by = &m->scratch->contact.blades;
    int64_t at = part * rotor->own.rows * rotor->own.columns;
    return (Component){rotor->own.at + at, rotor->across.at + at, rotor->answer.at + at,
                       rotor->answer_across.at + at, by->at + part * by->columns};
}

/* Add products of forces in columns and in their partners, and of two rows of weights. */
INLINED Lanes weighted(const double *own, const double *across, int crosses, Lanes here, Lanes there,
                       int64_t n, Lanes sum)
{
    sum = muladd(here, load(own + n), sum);
    return crosses ? muladd(there, load(across + n), sum) : sum;
}

/* Add the response to forces by column on a node of each blade to modal coordinates, by harmonic, and
 * to `twice` twice the work of these forces for the change since the coordinates `old`: of normal
 * forces and of friction. The scratch gets the sums by column of radial displacements, if these do not
 * cross. `turning` is true if Coriolis forces couple the response of the modes. */
INLINED void respond_blades(const March *m, int64_t node, int turning, int crosses, int axial,
                            const double *old, double *x, double twice[2])
{
    int64_t columns = m->stage.rotor->own.columns, half = m->stage.rotor->half;
    int64_t entries = m->stage.rotor->own.rows * columns, first = DIRECTIONS * node;
    const Component r = component_of(m, first), t = component_of(m, first + 1);
    const Component z = component_of(m, first + 2);
    const double *c = m->stage.rotor->body.c.at;
    double *sums = m->scratch->fields.sums.at;
    Lanes zero = splat(0.0), on_normal = zero, on_shear = zero;
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes push = load(r.by + h), drag = load(t.by + h), along = axial ? load(z.by + h) : zero;
        Lanes push_across = load(r.by + half + h), drag_across = load(t.by + half + h);
        Lanes along_across = axial ? load(z.by + half + h) : zero, sum = zero;
        for (int64_t n = h; n < entries; n += columns) {
            Lanes moved = load(x + n), normal, shear;
            normal = weighted(r.own, r.across, crosses, push, push_across, n, zero);
            shear = weighted(t.own, t.across, 1, drag, drag_across, n, zero);
            if (axial)
                shear = weighted(z.own, z.across, 1, along, along_across, n, shear);
            if (turning) {
                moved = weighted(r.answer, r.answer_across, 1, push, push_across, n, moved);
                moved = weighted(t.answer, t.answer_across, 1, drag, drag_across, n, moved);
            } else
                moved = muladd(load(c + n), add(normal, shear), moved);
            if (turning && axial)
                moved = weighted(z.answer, z.answer_across, 1, along, along_across, n, moved);
            store(x + n, moved);
            Lanes change = sub(moved, load(old + n));
            on_normal = muladd(change, normal, on_normal);
            on_shear = muladd(change, shear, on_shear);
            sum = muladd(load(r.own + n), moved, sum);
        }
        store(sums + h, sum);
    }
    twice[0] += total(on_normal);
    twice[1] += total(on_shear);
}

/* Add the response to forces on the nodes of the list to modal coordinates x, by harmonic. `ratio` is as
 * in `blade_columns`. If a blade has one node, `twice` gets twice the work of normal forces and of
 * friction for the change since the coordinates `old`. */
static void push_blades(const March *m, int64_t size, const double *ratio, const double *force,
                        const double *old, double *x, double twice[2])
{
    const Rotor *rotor = m->stage.rotor;
    blade_columns(m, size, ratio, force);
    twice[0] = twice[1] = 0.0;
    int plain = rotor->answer.layers == 0 && !(rotor->axial > 0.0);
    for (int64_t node = 0; node < rotor->own.layers / DIRECTIONS; node++)
        if (plain && !rotor->crosses.at[DIRECTIONS * node])
            respond_blades(m, node, 0, 0, 0, old, x, twice);
        else
            respond_blades(m, node, rotor->answer.layers > 0, 1, rotor->axial > 0.0, old, x, twice);
}

/* Add the response of the modes of the wanted copies to contact forces to modal coordinates x, with the
 * inverse of the matrix A of `g` unless it is NULL. */
static void push_copies(const March *m, const double *force, const Gyroscopic *g, double *x)
{
    const Rotor *rotor = m->stage.rotor;
    double *modal = m->scratch->nodes.modal.at;
    int64_t width = rotor->contact.rows, modes = rotor->contact.columns;
    int64_t entries = m->x.entries / rotor->copies;
    for (int64_t copy = 0; copy < rotor->copies; copy++) {
        const double *c = rotor->body.c.at + copy * entries;
        double *to = x + copy * entries;
        if (!m->scratch->nodes.wanted.at[copy])
            continue;
        for (int64_t i = 0; i < modes; i++)
            modal[i] = 0.0;
        add_rows(force + copy * width, rotor->contact.at, width, modes, modal);
        if (g)
            add_full(&g->inverse, copy, modes, modal, to, to);
        else
            for (int64_t i = 0; i < modes; i++)
                to[i] += c[i] * modal[i];
    }
}

/* Compute the forces of some nodes on the two casing nodes next to each of them. */
static void casing_forces(const March *m, int64_t size, const double *force)
{
    const FieldScratch *f = &m->scratch->fields;
    const int64_t *list = m->scratch->nodes.list.at;
    ContactScratch *c = &m->scratch->contact;
    int64_t width = f->hermite.columns, wide = c->factor.columns;
    double *factor = c->factor.at;
    for (int64_t n = 0; n < size; n++) {
        int64_t j = list[n], e = f->element.at[j];
        double push = -force[DIRECTIONS * j + RADIAL], drag = -force[DIRECTIONS * j + TANGENTIAL];
        for (int64_t end = 0; end < 2; end++) {
            int64_t to = 2 * n + end;
            double value = f->hermite.at[2 * end * width + j];
            double slope = f->hermite.at[(2 * end + 1) * width + j];
            c->rows.at[to] = e + end;
            factor[W_KIND * wide + to] = push * value;
            factor[W_SLOPE * wide + to] = push * slope;
            factor[U_KIND * wide + to] = drag * value;
            factor[U_SLOPE * wide + to] = drag * slope;
        }
    }
}

/* Sum a number of forces on the casing nodes by column; friction is left out if it is `shared`, that is
 * a multiple of the normal forces with the same shape. */
static void casing_columns(const Casing *casing, int64_t count, int shared, ContactScratch *c)
{
    const Matrix *shapes[KINDS] = {&casing->radial.spread, &casing->radial.slope_spread,
                                   &casing->tangential.spread, &casing->tangential.slope_spread};
    int64_t wide = c->factor.columns, width = c->columns.columns, half = casing->half;
    const int64_t *rows = c->rows.at;
    const double *factor = c->factor.at;
    double *sums = c->columns.at;
    if (shared)
        spread(shapes[0], rows, factor, wide, 2, count, half, sums, width);
    else if (casing->shared)
        spread(shapes[0], rows, factor, wide, KINDS, count, half, sums, width);
    for (int k = 0; !casing->shared && k < KINDS; k++)
        spread(shapes[k], rows, factor + k * wide, wide, 1, count, half, sums + k * width, width);
}

/* Add the response to forces of the nodes of the list on the casing to y_{n+1}. Also compute the work
 * of these forces, and the sums by column of w and w'. `ratio` is as in `push_blades`. */
static void push_casing(const March *m, int64_t size, const double *ratio, const double *force)
{
    const Casing *casing = m->stage.casing;
    FieldScratch *f = &m->scratch->fields;
    ContactScratch *c = &m->scratch->contact;
    Motion y = m->y;
    casing_forces(m, size, force);
    int shared = ratio && casing->shared;
    casing_columns(casing, 2 * size, shared, c);
    const NodalField *radial = &casing->radial, *tangential = &casing->tangential;
    int64_t rows = radial->weight.rows, columns = radial->weight.columns, half = casing->half;
    int64_t wide = c->columns.columns;
    const double *by = c->columns.at, *drag = shared ? by : by + U_KIND * wide;
    Lanes slides = splat(shared ? *ratio : 1.0);
    Lanes on_normal = splat(0.0), on_shear = on_normal;
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes on_w = load(by + W_KIND * wide + h);
        Lanes on_w_slope = load(by + W_SLOPE * wide + half + h);
        Lanes on_u = mul(slides, load(drag + half + h));
        Lanes on_u_slope = mul(slides, load(drag + wide + h));
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
    c->work.at[0] = 0.5 * total(on_normal);
    c->work.at[1] = 0.5 * total(on_shear);
}

#endif
