/* A flexible casing, the ring, around contact nodes: its motion, the gaps, and the response to
 * contact forces within a step. */
#ifndef RING_H
#define RING_H

#include "forces.h"

/* Compute y_{n+1} without contact forces, and the position of each contact node on the ring. `y_p`
 * is stored for further trials. */
static void predict_ring(const Ring *ring, const double *amplitude, double turned, Motion y,
                         RingScratch *r)
{
    const Casing *casing = &ring->casing;
    FieldScratch *f = &r->fields;
    predict_body(&casing->body, y);
    add_loads(&casing->body, amplitude, y);
    if (ring->dampers.rows.rows > 0)
        add_dampers(&ring->dampers, casing->body.c.at, y, r->stroke.at, r->damper_force.at);
    for (int64_t i = 0; i < y.entries; i++)
        r->start.at[i] = y.new[i];
    hermite_weights(ring->place.at, turned, (double)casing->nodes, casing->element_length,
                    f->element.size, f->hermite.columns, f->element.at, f->hermite.at);
}

/* Compute the sums by column of a field of the ring for displacements y, then its value under each
 * contact node. Returns 0 if any value is NaN. */
static int ring_field(const Ring *ring, const NodalField *field, const double *y, RingScratch *r,
                      double *out)
{
    FieldScratch *f = &r->fields;
    column_sums(&field->weight, y, field->half, f->value.at);
    column_sums(&field->slope_weight, y, field->slope_half, f->slope.at);
    nodal_field(&ring->casing, field, f);
    return field_at_tips(f, out);
}

/* Subtract the closure at a time from the wall under each contact node. */
static void close_ring(const Closure *closure, double time, RingScratch *r)
{
    const FieldScratch *f = &r->fields;
    double rate, closed = closure_at(closure, time, &rate);
    const double *value = closure->share.at, *slope = value + closure->share.columns;
    int64_t width = f->hermite.columns;
    for (int64_t j = 0; j < f->element.size; j++) {
        int64_t e = f->element.at[j];
        const double *weight = f->hermite.at + j;
        r->wall.at[j] -= closed
                         * ((weight[0] * value[e] + weight[width] * slope[e])
                            + (weight[2 * width] * value[e + 1] + weight[3 * width] * slope[e + 1]));
    }
}

/* Compute the wall at each contact node, clearance and displacement of the ring, from the sums by
 * column. Returns 0 if any value is NaN. */
static int ring_wall(const Ring *ring, const Closure *closure, double time, RingScratch *r)
{
    nodal_field(&ring->casing, &ring->casing.radial, &r->fields);
    int finite = field_at_tips(&r->fields, r->wall.at);
    if (closure)
        close_ring(closure, time, r);
    return finite;
}

/* Return whether radial displacements of the ring are within a limit, after `ring_wall`. */
static int ring_keeps(const Ring *ring, double limit, const RingScratch *r)
{
    int within = 1;
    for (int64_t i = 0; i < ring->casing.nodes; i++)
        within &= fabs(r->fields.nodal.at[i] - ring->casing.radial.start.at[i]) <= limit;
    return within;
}

/* Add the compliance of the ring between two contact nodes to a block of radial and tangential
 * displacements. */
static void add_ring_compliance(const Ring *ring, const FieldScratch *f, int64_t one, int64_t two,
                                double *block, int64_t stride)
{
    int64_t width = f->hermite.columns, columns = ring->response.columns;
    const double *row = ring->response.at + 4 * f->element.at[one] * columns
                        + 4 * f->element.at[two];
    double sum[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
    for (int64_t p = 0; p < 4; p++) {
        double weight = f->hermite.at[p * width + one];
        for (int64_t kind = 0; kind < 2; kind++) { /* w, w' then u, u' of a node */
            const double *from = row + ((p & 1) + 4 * (p >> 1) + 2 * kind) * columns;
            for (int64_t q = 0; q < 4; q++) {
                double product = weight * f->hermite.at[q * width + two];
                const double *at = from + (q & 1) + 4 * (q >> 1);
                sum[kind][0] += product * at[0];
                sum[kind][1] += product * at[2];
            }
        }
    }
    block[0] += sum[0][0];
    block[1] += sum[0][1];
    block[stride] += sum[1][0];
    block[stride + 1] += sum[1][1];
}

/* Compute y_{n+1} with the normal forces and directions of sliding in the contact scratch, and the
 * works of these forces on the ring. */
static void push_ring(const Ring *ring, double friction, int64_t size, Motion y, RingScratch *r)
{
    double ratio;
    for (int64_t i = 0; i < y.entries; i++)
        y.new[i] = r->start.at[i];
    int mixed = tip_forces(size, friction, ring->casing.nodes, &r->fields, &r->contact, &ratio);
    r->contact.work.at[0] = r->contact.work.at[1] = 0.0;
    correct_casing(&ring->casing, size, mixed, ratio, y, &r->fields, &r->contact);
}

#endif
