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

/* Sums over the rods of one element under a tip, in four lanes each. */
typedef struct {
    Half value, slope, next_value, next_slope; /* stress times the Hermite weights of the rod */
    Half stress, removed, dissipated, stored;  /* stress; sums over volume and strain */
} RodSums;

/* Numbers for open lanes (zero) and for lanes beyond the last rod, which touch no rod (1e200). */
static const double CLOSED_LANES[2 * HALF] = {0.0, 0.0, 0.0, 0.0, 1e200, 1e200, 1e200, 1e200};

/* Return the value of a nodal Hermite field at HALF rods of an element. */
static inline Half at_rods(const Matrix *hermite, int64_t rod, int64_t element,
                           const double *value, const double *slope)
{
    int64_t wide = hermite->columns;
    const double *weight = hermite->at + rod;
    Half out = half_mul(half_load(weight), half_splat(value[element]));
    out = half_muladd(half_load(weight + wide), half_splat(slope[element]), out);
    out = half_muladd(half_load(weight + 2 * wide), half_splat(value[element + 1]), out);
    return half_muladd(half_load(weight + 3 * wide), half_splat(slope[element + 1]), out);
}

/* Compress HALF rods by depths, update their plastic strain, and add to the sums. */
static inline void compress_rods(const Coating *coating, int64_t rod, Half depth, double *strain,
                                 RodSums *sums)
{
    double young = coating->young_modulus;
    int64_t wide = coating->hermite.columns;
    const double *weight = coating->hermite.at + rod;
    Half p = half_load(strain), none = half_splat(0.0), h = half_splat(coating->hardening);
    Half stress = half_mul(depth, half_splat(young / coating->thickness));
    stress = half_larger(half_sub(stress, half_mul(half_splat(young), p)), none);
    Half yield = half_muladd(h, p, half_splat(coating->yield_stress));
    Half grown = half_larger(half_sub(stress, yield), none);
    grown = half_mul(grown, half_splat(1.0 / (young + coating->hardening)));
    Half left = half_larger(half_sub(half_splat(coating->limit), p), none);
    grown = half_sub(grown, half_larger(half_sub(grown, left), none)); /* the smaller of both */
    stress = half_sub(stress, half_mul(half_splat(young), grown));
    Half after = half_add(p, grown), twice = half_add(after, p);
    Half loss = half_muladd(half_mul(half_splat(0.5), h), twice, half_splat(coating->yield_stress));
    half_store(strain, after);
    sums->value = half_muladd(stress, half_load(weight), sums->value);
    sums->slope = half_muladd(stress, half_load(weight + wide), sums->slope);
    sums->next_value = half_muladd(stress, half_load(weight + 2 * wide), sums->next_value);
    sums->next_slope = half_muladd(stress, half_load(weight + 3 * wide), sums->next_slope);
    sums->stress = half_add(sums->stress, stress);
    sums->removed = half_add(sums->removed, grown);
    sums->dissipated = half_muladd(loss, grown, sums->dissipated);
    sums->stored = half_muladd(stress, stress, sums->stored);
}

/* Add the sums of the rods of an element to the forces on its nodes and to the sums of the step.
 * Returns the force on the tip [N]. */
static inline double add_rods(const Coating *coating, const RodSums *sums, int64_t element,
                              double slides, CoatingScratch *s)
{
    double on[HALF], of[HALF], area = coating->area, volume = area * coating->thickness;
    half_store(of, half_totals(sums->stress, sums->removed, sums->dissipated, sums->stored));
    if (of[0] == 0.0)
        return 0.0;
    half_store(on, half_totals(sums->value, sums->slope, sums->next_value, sums->next_slope));
    double *to = s->on_nodes.at + element;
    int64_t width = s->on_nodes.columns;
    for (int64_t end = 0; end < 2; end++) {
        to[end] += area * on[2 * end];
        to[width + end] += area * on[2 * end + 1];
        to[2 * width + end] += slides * area * on[2 * end];
        to[3 * width + end] += slides * area * on[2 * end + 1];
    }
    s->sums.at[REMOVED] += volume * of[1];
    s->sums.at[DISSIPATED] += volume * of[2];
    s->sums.at[STORED] += 0.5 * volume * of[3] / coating->young_modulus;
    return area * of[0];
}

/* Return an upper bound of the slope of a nodal Hermite field on the element of a rod. */
static inline double steepest(const Casing *casing, int64_t element, const Matrix *nodal)
{
    const double *value = nodal->at, *slope = value + nodal->columns;
    double chord = fabs(value[element + 1] - value[element]) / casing->element_length;
    return 1.5 * chord + fabs(slope[element]) + fabs(slope[element + 1]);
}

/* Press a tip into the rods under its footprint. Adds the forces of the rods on the casing to
 * `on_nodes` (w, w', u and u' by node), and returns the force on the tip [N]. `place` is the
 * position of the tip in elements, `room` the gap to the virgin surface there, and `slides` the
 * friction coefficient times the direction of sliding. */
static inline double press_tip(const Coating *coating, const Casing *casing, const Closure *closure,
                               double closed, int64_t tip, double place, double room,
                               double recess, double slides, const FieldScratch *f,
                               double *strain, CoatingScratch *s)
{
    const Matrix *nodal = casing->modes > 0 ? &f->nodal : &casing->radial.start;
    const double *value = nodal->at, *slope = value + nodal->columns;
    const double *share = closure ? closure->share.at : 0;
    int64_t rods = coating->element.size;
    double at = place * coating->rods_per_element, half = coating->half.at[tip], force = 0.0;
    int64_t first = (int64_t)ceil(at - half - 0.5), last = (int64_t)floor(at + half - 0.5);
    if (room > 0.0) { /* no rod is touched if the wall is not steep enough */
        double reach = (half + 0.5) / coating->rods_per_element * casing->element_length;
        double most = 0.0;
        for (int64_t n = first; n <= last;) {
            int64_t rod = n < 0 ? n + rods : n < rods ? n : n - rods, e = coating->element.at[rod];
            double here = steepest(casing, e, nodal);
            if (closure)
                here += fabs(closed) * steepest(casing, e, &closure->share);
            most = larger(most, here);
            n += coating->until.at[rod] - rod;
        }
        if (room > most * reach)
            return 0.0;
    }
    double outward = f->radial.at[tip] - recess;
    for (int64_t n = first; n <= last;) {
        int64_t rod = n < 0 ? n + rods : n < rods ? n : n - rods, e = coating->element.at[rod];
        int64_t count = coating->until.at[rod] - rod;
        count = count < last - n + 1 ? count : last - n + 1;
        Half none = half_splat(0.0);
        RodSums sums = {none, none, none, none, none, none, none, none};
        for (int64_t k = 0; k < count; k += HALF) {
            int64_t open = count - k < HALF ? count - k : HALF;
            Half wall = at_rods(&coating->hermite, rod + k, e, value, slope);
            if (closure) {
                Half lost = at_rods(&coating->hermite, rod + k, e, share,
                                    share + closure->share.columns);
                wall = half_sub(wall, half_mul(half_splat(closed), lost));
            }
            wall = half_add(wall, half_load(CLOSED_LANES + HALF - open));
            compress_rods(coating, rod + k, half_sub(half_splat(outward), wall), strain + rod + k,
                          &sums);
        }
        force += add_rods(coating, &sums, e, slides, s);
        n += count;
    }
    return force;
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
static void rotor_coating_force(const Rotor *rotor, int64_t size, int mixed, double ratio,
                                ContactScratch *c, Matrix *force)
{
    Friction friction = rotor_columns(rotor, size, mixed, ratio, c);
    int64_t rows = rotor->radial.rows, columns = rotor->radial.columns;
    const double *push = c->columns.at + PUSH * c->columns.columns;
    const double *drag = c->columns.at + friction.drag * c->columns.columns;
    Lanes slides = splat(friction.ratio);
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes normal = load(push + h), along = mul(slides, load(drag + h));
        Lanes across = mul(slides, load(drag + rotor->half + h));
        for (int64_t i = h; i < rows * columns; i += columns) {
            Lanes shear = mul(across, load(rotor->crossed.at + i));
            shear = muladd(along, load(rotor->tangential.at + i), shear);
            store(force->at + i, mul(normal, load(rotor->radial.at + i)));
            store(force->at + force->columns + i, shear);
        }
    }
}

/* Compute the modal forces on the casing from the forces on nodes: normal, then friction. */
static void casing_coating_force(const Casing *casing, int64_t count, int mixed, double ratio,
                                 ContactScratch *c, Matrix *force)
{
    Friction friction = casing_columns(casing, count, mixed, ratio, c);
    const NodalField *radial = &casing->radial, *tangential = &casing->tangential;
    int64_t half = casing->half, wide = c->columns.columns;
    int64_t rows = radial->weight.rows, columns = radial->weight.columns;
    const double *push = c->columns.at + W_KIND * wide;
    const double *drag = c->columns.at + friction.drag * wide;
    Lanes slides = splat(friction.ratio);
    for (int64_t h = 0; h < columns; h += LANES) {
        Lanes w = load(push + h), w_slope = load(push + wide + half + h);
        Lanes u = mul(slides, load(drag + half + h)), u_slope = mul(slides, load(drag + wide + h));
        for (int64_t i = h; i < rows * columns; i += columns) {
            Lanes slope = mul(w_slope, load(radial->slope_weight.at + i));
            Lanes turn = mul(u_slope, load(tangential->slope_weight.at + i));
            store(force->at + i, muladd(w, load(radial->weight.at + i), slope));
            store(force->at + force->columns + i,
                  muladd(u, load(tangential->weight.at + i), turn));
        }
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
