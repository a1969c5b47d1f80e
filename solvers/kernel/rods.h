/* Abradable coating: elastic-plastic rods in tracks along the circumference.
 *
 * Rods harden linearly; plastic strain stands for removed material. With the depth D of the node below
 * the virgin surface, the thickness h and the plastic strain p of a rod:
 *
 *     trial stress  s = E (D / h - p);  s <= 0: no contact
 *     if s > s_y + H p:  dp = (s - s_y - H p) / (E + H),  p += dp,  s -= E dp
 *
 * All nodes at one axial position cut the same track. A node
 * touches the rods under its footprint, at depths that follow from its gap and the shape of the wall
 * near it. The forces act at the node, and depend on its displacement at the end of the step:
 *
 *     g = g_free + W (lambda + F(g)),      0 <= lambda  perp  g >= 0,
 *
 * with the gap g to the metal and the force F of the rods, which decreases with g. The equation is
 * solved by Newton's method with the slopes of F; each iteration solves the complementarity problem.
 */
#ifndef RODS_H
#define RODS_H

#include "forces.h"

#define LEAST_GAP 1e-12 /* share of the scale of gaps below which a gap is closed */

/* Return the first and the last rod under the footprint of a node; `turns` is its angle in
 * revolutions. */
static void rods_under(const Coating *c, int64_t node, double turns, int64_t range[2])
{
    double at = (turns - floor(turns)) * (double)c->rods, half = c->half.at[node];
    range[0] = (int64_t)ceil(at - half - 0.5);
    range[1] = (int64_t)floor(at + half - 0.5);
}

/* Return the number of a rod between 0 and the number of rods. */
static int64_t wrapped(const Coating *c, int64_t rod)
{
    return rod < 0 ? rod + c->rods : rod < c->rods ? rod : rod - c->rods;
}

/* Compress the rods of a node at a gap to the metal. Returns the force [N]; `slope` gets its decrease
 * with the gap [N/m]. The stresses and the growth of the plastic strains are stored. */
static double press_node(const March *m, int64_t n, double gap, double *slope)
{
    const Coating *c = m->stage.coating;
    RodScratch *r = &m->scratch->rods;
    double young = c->young_modulus, softer = young / (young + c->hardening);
    double area = c->area.at[c->track.at[n]], steep = young / c->thickness;
    const double *trial = r->trial.at + n * r->trial.columns;
    const double *plastic = r->plastic.at + n * r->plastic.columns;
    Half none = half_splat(0.0), drop = half_splat(-steep * gap), sum = none, touching = none;
    Half yielding = none, by_growth = half_splat(-1.0 / (young + c->hardening));
    Half limit = half_splat(c->limit), soft = half_splat(c->yield_stress);
    for (int64_t k = 0; k <= r->range.at[2 * n + 1] - r->range.at[2 * n]; k += HALF) {
        Half stress = half_add(half_load(trial + k), drop), before = half_load(plastic + k);
        Half most = half_sub(none, half_larger(half_sub(limit, before), none));
        Half yield = half_muladd(half_splat(c->hardening), before, soft);
        Half excess = half_larger(half_sub(stress, yield), none);
        Half shorter = half_mul(excess, by_growth); /* less the growth */
        Half grown = half_sub(none, half_larger(shorter, most));
        touching = half_add(touching, half_above(stress, none));
        yielding = half_add(yielding, half_mul(half_above(excess, none), half_above(shorter, most)));
        stress = half_sub(half_larger(stress, none), half_mul(half_splat(young), grown));
        half_store(r->stress.at + k, stress);
        half_store(r->grown.at + k, grown);
        sum = half_add(sum, stress);
    }
    *slope = area * steep * (half_total(touching) - softer * half_total(yielding));
    return area * half_total(sum);
}

/* Return the nearest gap above or below a gap at which the slope of the force of `press_node` changes,
 * or `nearest` if that is nearer. */
static double kink_of_rods(const March *m, int64_t n, double gap, int above, double nearest)
{
    const Coating *c = m->stage.coating;
    const RodScratch *r = &m->scratch->rods;
    double young = c->young_modulus;
    int64_t row = n * r->trial.columns;
    for (int64_t k = row; k <= row + r->range.at[2 * n + 1] - r->range.at[2 * n]; k++) {
        double yield = c->yield_stress + c->hardening * r->plastic.at[k];
        double worn = yield + (young + c->hardening) * larger(0.0, c->limit - r->plastic.at[k]);
        double stresses[3] = {0.0, yield, worn}; /* at the kinks, without yielding */
        for (int i = 0; i < 3; i++) {
            double kink = (r->trial.at[k] - stresses[i]) * c->thickness / young;
            if (kink > 0.0 && (above ? kink > gap : kink < gap))
                nearest = above ? smaller(nearest, kink) : larger(nearest, kink);
        }
    }
    return nearest;
}

/* Return the nodal field of the wall without contact forces of this step and without a closure. */
static const Matrix *wall_of(const March *m)
{
    const Casing *casing = m->stage.casing;
    return casing->modes > 0 ? &m->scratch->fields.nodal : &casing->radial.start;
}

/* Return that field less the closure at the place with a number. */
static double wall_under(const March *m, int64_t place)
{
    const RodScratch *r = &m->scratch->rods;
    int64_t e = r->element.at[place], width = r->weight.columns;
    const double *weight = r->weight.at + place;
    double wall = hermite_value(wall_of(m), e, weight, width);
    if (m->stage.closure)
        wall -= r->closed * hermite_value(&m->stage.closure->share, e, weight, width);
    return wall;
}

/* Find the rods under a node, and store their plastic strains and their stresses at the metal as if
 * they did not yield; the wall is that without contact forces of this step, and its shape near the node
 * moves with the node. */
static void place_rods(const March *m, int64_t n)
{
    const Coating *c = m->stage.coating;
    const Casing *casing = m->stage.casing;
    RodScratch *r = &m->scratch->rods;
    const double *plastic = m->state->strain.at + c->track.at[n] * m->state->strain.columns;
    int64_t *range = r->range.at + 2 * n, row = n * r->trial.columns, width = r->weight.columns;
    double nodes = (double)casing->nodes, rod = nodes / (double)c->rods, *place = r->place.at;
    place[0] = position_of(m, n) + m->rotation.elements;
    rods_under(c, n, place[0] / nodes, range);
    int64_t count = range[1] - range[0] + 1;
    for (int64_t k = 0; k < count; k++)
        place[k + 1] = rod * ((double)(range[0] + k) + 0.5);
    hermite_weights(place, 0.0, nodes, casing->element_length, count + 1, width, r->element.at,
                    r->weight.at);
    double here = wall_under(m, 0);
    double part = m->stage.rotor->normal_part.at[n] / c->thickness;
    for (int64_t k = 0; k < count; k++, row++) {
        double wall = wall_under(m, k + 1);
        double p = plastic[wrapped(c, range[0] + k)];
        r->trial.at[row] = c->young_modulus * (c->limit - part * (wall - here) - p);
        r->plastic.at[row] = p;
    }
    for (; row % HALF != 0; row++) { /* no rods */
        r->trial.at[row] = -INFINITY;
        r->plastic.at[row] = 0.0;
    }
    r->near.at[n] = 1;
}

/* Return an upper bound of the slope of a nodal Hermite field by the angle. */
static double steepest(const Casing *casing, const Matrix *nodal)
{
    const double *value = nodal->at, *slope = value + nodal->columns;
    double most = 0.0, length = casing->element_length;
    for (int64_t e = 0; e < casing->nodes; e++) {
        double chord = fabs(value[e + 1] - value[e]) / length;
        most = larger(most, 1.5 * chord + fabs(slope[e]) + fabs(slope[e + 1]));
    }
    return most * length * (double)casing->nodes / (2.0 * PI);
}

/* Find the gap to the metal below which the rods under a node have to be evaluated. The slopes of a
 * rigid wall and of the share of a closure are found in the first step. */
static void find_reach(const March *m)
{
    const Coating *c = m->stage.coating;
    const Casing *casing = m->stage.casing;
    RodScratch *r = &m->scratch->rods;
    double half = 0.0;
    if (r->steepest < 0.0)
        r->closing = m->stage.closure ? steepest(casing, &m->stage.closure->share) : 0.0;
    if (r->steepest < 0.0 || casing->modes > 0)
        r->steepest = steepest(casing, wall_of(m));
    for (int64_t i = 0; i < c->half.size; i++)
        half = larger(half, c->half.at[i]);
    double slope = r->steepest + fabs(r->closed) * r->closing;
    r->reach = c->limit * c->thickness + slope * (half + 0.5) * 2.0 * PI / (double)c->rods;
}

/* Find the nodes that touch the coating without contact forces of the step that ends at a time.
 * Returns whether there are any. */
static int find_rods(const March *m, double time)
{
    const Closure *closure = m->stage.closure;
    int touches = 0;
    RodScratch *r = &m->scratch->rods;
    const double *gap = m->scratch->fields.free_gap.at;
    double rate, slope;
    r->closed = closure ? closure_at(closure, time, &rate) : 0.0;
    find_reach(m);
    for (int64_t n = 0; n < r->near.size; n++) {
        r->near.at[n] = 0;
        m->scratch->rods.push.at[n] = 0.0;
        if (!(gap[n] < r->reach))
            continue;
        place_rods(m, n);
        if (press_node(m, n, gap[n], &slope) > 0.0)
            r->near.at[n] = 2;
        touches |= r->near.at[n] == 2;
    }
    return touches;
}

/* Let the plastic strains of the rods under a node grow as `press_node` stored it, unless another node
 * let them grow further in this step, and add to the sums of the coating. Returns the force. */
static double grow_strains(const March *m, int64_t n)
{
    const Coating *c = m->stage.coating;
    const RodScratch *r = &m->scratch->rods;
    const int64_t *range = r->range.at + 2 * n;
    int64_t track = c->track.at[n];
    double *plastic = m->state->strain.at + track * m->state->strain.columns, force = 0.0;
    double *sums = m->state->coating.at, area = c->area.at[track], volume = area * c->thickness;
    for (int64_t k = 0; k <= range[1] - range[0]; k++) {
        double *p = plastic + wrapped(c, range[0] + k), grown = r->grown.at[k];
        double own = r->plastic.at[n * r->plastic.columns + k] + grown;
        double after = larger(*p, own), more = after - *p; /* 0 without growth: own is *p or less */
        double stress = larger(0.0, r->stress.at[k] - c->young_modulus * (after - own));
        sums[REMOVED] += volume * more;
        sums[DISSIPATED] += volume * (c->yield_stress + 0.5 * c->hardening * (after + *p)) * more;
        sums[STORED] += 0.5 * volume * stress * stress / c->young_modulus;
        force += area * stress;
        *p = after;
    }
    return force;
}

/* Wear the rods under the nodes at their gaps after the step. */
static void wear_rods(const March *m, const double *gap)
{
    State *state = m->state;
    const RodScratch *r = &m->scratch->rods;
    double slope, *push = m->scratch->rods.push.at;
    for (int64_t n = 0; n < r->near.size; n++)
        if (m->scratch->nodes.listed.at[n] && r->near.at[n]) {
            press_node(m, n, gap[n], &slope);
            push[n] = grow_strains(m, n);
            if (gap[n] > LEAST_GAP * m->stage.numbers->gap_scale) /* not at the metal */
                push[n] = -m->scratch->nodes.force.at[DIRECTIONS * n + RADIAL];
            state->coating_impulse.at[n] += push[n] * m->stage.numbers->time_step;
        }
}

#endif
