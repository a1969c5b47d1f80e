/* Abradable coating on the inner face of the casing: rods that are compressed by the tips.
 *
 * Each rod is elastic-plastic with linear hardening; plastic strain stands for removed material. With
 * the depth D of the tip below the virgin surface, the thickness h and the plastic strain p of a rod:
 *
 *     trial stress  s = E (D / h - p);  s <= 0: no contact
 *     if s > s_y + H p:  dp = (s - s_y - H p) / (E + H),  p += dp,  s -= E dp
 *
 * The depth follows from the displacements x_p without contact; clearance, displacement of the casing
 * and tip are taken at the angle of the rod. The forces are added to the loads, and x_p is computed
 * again before the contact with the metal behind the coating.
 */
#ifndef COATING_H
#define COATING_H

#include "turning.h"

/* Return the stress of a rod at a depth, and update its plastic strain and the sums. */
static inline double rod_stress(const Coating *coating, double depth, double *strain, double *sums)
{
    double p = *strain, energy = coating->area * coating->thickness;
    double stress = coating->young_modulus * (depth / coating->thickness - p);
    if (!(stress > 0.0))
        return 0.0;
    double excess = stress - (coating->yield_stress + coating->hardening * p);
    if (excess > 0.0) {
        double after = p + excess / (coating->young_modulus + coating->hardening);
        after = smaller(after, larger(coating->limit, p));
        stress -= coating->young_modulus * (after - p);
        sums[REMOVED] += energy * (after - p);
        sums[DISSIPATED] += energy * (coating->yield_stress * (after - p)
                                      + 0.5 * coating->hardening * (after * after - p * p));
        *strain = after;
    }
    sums[STORED] += 0.5 * energy * stress * stress / coating->young_modulus;
    return stress;
}

/* Return the value of a nodal Hermite field at a rod. */
static inline double at_rod(const Coating *coating, int64_t rod, const double *value,
                            const double *slope)
{
    int64_t rods = coating->element.size, e = coating->element.at[rod];
    const double *weight = coating->hermite.at + rod;
    return weight[0] * value[e] + weight[rods] * slope[e] + weight[2 * rods] * value[e + 1]
           + weight[3 * rods] * slope[e + 1];
}

/* Press a tip into the rods under its footprint. Adds the forces of the rods on the casing to
 * `on_nodes` (w, w', u and u' by node), and returns the force on the tip [N]. `slides` is the
 * friction coefficient times the direction of sliding. */
static inline double press_tip(const Coating *coating, const Closure *closure, double closed,
                               int64_t tip, double place, double recess, double slides,
                               const FieldScratch *f, double *strain, CoatingScratch *s)
{
    int64_t rods = coating->element.size, width = s->on_nodes.columns;
    double at = place * coating->rods_per_element, half = coating->half.at[tip], total = 0.0;
    int64_t last = (int64_t)floor(at + half - 0.5);
    for (int64_t n = (int64_t)ceil(at - half - 0.5); n <= last; n++) {
        int64_t rod = n < 0 ? n + rods : n < rods ? n : n - rods;
        double room = at_rod(coating, rod, f->nodal.at, f->nodal_slope.at) + recess;
        if (closure)
            room -= closed * at_rod(coating, rod, closure->share.at,
                                    closure->share.at + closure->share.columns);
        double stress =
            rod_stress(coating, f->radial.at[tip] - room, strain + rod, s->sums.at);
        if (stress == 0.0)
            continue;
        double force = stress * coating->area, drag = slides * force;
        double *to = s->on_nodes.at + coating->element.at[rod];
        const double *weight = coating->hermite.at + rod;
        for (int64_t end = 0; end < 2; end++, weight += 2 * rods) {
            to[end] += force * weight[0];
            to[width + end] += force * weight[rods];
            to[2 * width + end] += drag * weight[0];
            to[3 * width + end] += drag * weight[rods];
        }
        total += force;
    }
    return total;
}

/* Move the forces on the casing nodes that are not zero to `factor`. Returns their number. */
static int64_t gather_nodes(const Casing *casing, CoatingScratch *s, ContactScratch *c)
{
    int64_t count = 0, width = s->on_nodes.columns, wide = c->factor.columns;
    for (int64_t row = 0; row < 4; row++) { /* the node after the last is the first */
        double *values = s->on_nodes.at + row * width;
        values[0] += values[casing->nodes];
        values[casing->nodes] = 0.0;
    }
    for (int64_t n = 0; n < casing->nodes; n++) {
        double *value = s->on_nodes.at + n;
        if (value[0] == 0.0 && value[width] == 0.0)
            continue;
        c->rows.at[count] = n;
        for (int64_t row = 0; row < 4; row++) {
            c->factor.at[(W_KIND + row) * wide + count] = value[row * width];
            value[row * width] = 0.0;
        }
        count++;
    }
    return count;
}

/* Compute the modal forces on the rotor from the forces on tips: normal, then friction. */
static void rotor_coating_force(const Rotor *rotor, int64_t size, ContactScratch *c, Matrix *force)
{
    spread(&rotor->spread, c->active.at, c, PUSH, size, rotor->half);
    spread(&rotor->drag_spread, c->active.at, c, DRAG, size, rotor->half);
    int64_t rows = rotor->radial.rows, columns = rotor->radial.columns;
    const double *push = c->columns.at + PUSH * c->columns.columns;
    const double *drag = c->columns.at + DRAG * c->columns.columns;
    for (int64_t h = 0; h < columns; h += LANES)
        for (int64_t i = h; i < rows * columns; i += columns) {
            Lanes shear = mul(load(drag + rotor->half + h), load(rotor->crossed.at + i));
            shear = muladd(load(drag + h), load(rotor->tangential.at + i), shear);
            store(force->at + i, mul(load(push + h), load(rotor->radial.at + i)));
            store(force->at + force->columns + i, shear);
        }
}

/* Compute the modal forces on the casing from the forces on nodes: normal, then friction. */
static void casing_coating_force(const Casing *casing, int64_t count, ContactScratch *c,
                                 Matrix *force)
{
    const NodalField *radial = &casing->radial, *tangential = &casing->tangential;
    int64_t half = casing->half, wide = c->columns.columns;
    const Matrix *spreads[4] = {&radial->spread, &radial->slope_spread, &tangential->spread,
                                &tangential->slope_spread};
    for (int64_t row = 0; row < 4; row++)
        spread(spreads[row], c->rows.at, c, W_KIND + row, count, half);
    int64_t rows = radial->weight.rows, columns = radial->weight.columns;
    const double *on = c->columns.at + W_KIND * wide;
    for (int64_t h = 0; h < columns; h += LANES)
        for (int64_t i = h; i < rows * columns; i += columns) {
            Lanes slope = mul(load(on + wide + half + h), load(radial->slope_weight.at + i));
            Lanes turn = mul(load(on + 3 * wide + h), load(tangential->slope_weight.at + i));
            store(force->at + i, muladd(load(on + h), load(radial->weight.at + i), slope));
            store(force->at + force->columns + i,
                  muladd(load(on + 2 * wide + half + h), load(tangential->weight.at + i), turn));
        }
}

/* Add the response to the forces of the coating to x_p of a body. */
static inline void add_coating(const Body *body, const Matrix *force, Motion x)
{
    for (int64_t i = 0; i < x.entries; i += LANES) {
        Lanes both = add(load(force->at + i), load(force->at + force->columns + i));
        store(x.new + i, muladd(both, load(body->c.at + i), load(x.new + i)));
    }
}

/* Return the work d^T f of modal forces (a row of `force`) with d = (x_{n+1} - x_{n-1}) / 2. */
static inline double coating_work(const Matrix *force, int64_t row, Motion x)
{
    Lanes sum = splat(0.0);
    for (int64_t i = 0; i < x.entries; i += LANES)
        sum = muladd(sub(load(x.new + i), load(x.old + i)),
                     load(force->at + row * force->columns + i), sum);
    return 0.5 * total(sum);
}

/* Add impulses, works and contacts of the coating in an accepted step to the state; `metal` is true
 * if tips touch the metal in the same step. */
static void account_coating(const Coating *coating, const Numbers *numbers, State *state,
                            const CoatingScratch *s, const ContactScratch *c, Motion x, Motion y,
                            int metal)
{
    double normal = coating_work(&s->rotor, 0, x) + coating_work(&s->casing, 0, y);
    state->coating.at[COATING_WORK] += normal;
    state->coating.at[REMOVED] += s->sums.at[REMOVED];
    state->coating.at[DISSIPATED] += s->sums.at[DISSIPATED];
    state->coating.at[STORED] = s->sums.at[STORED];
    state->work.at[NORMAL] += normal;
    state->work.at[FRICTION] += coating_work(&s->rotor, 1, x) + coating_work(&s->casing, 1, y);
    for (int64_t j = 0; j < s->push.size; j++) {
        double impulse = s->push.at[j] * numbers->time_step;
        if (impulse == 0.0)
            continue;
        state->impulse.at[j] += impulse;
        state->coating_impulse.at[j] += impulse;
        state->drag.at[j] += coating->friction * c->sign.at[j] * impulse;
        if (!metal || state->held.at[j] == 0.0) {
            state->touched.at[j] += 1.0;
            state->counts.at[STEP_CONTACTS] += 1.0;
        }
    }
    state->counts.at[CONTACT_STEPS] += !metal;
}

#endif
