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

/* Compress the rods of a node at a gap to the metal. Returns the force [N]; `slope` gets its
 * decrease with the gap [N/m]. If `sums` is given, plastic strains are updated, and changes are added
 * to it. */
static double press_rods(const Coating *c, int64_t node, const int64_t range[2],
                         const double *offset, double gap, const Matrix *strain, double *slope,
                         double *sums)
{
    int64_t track = c->track.at[node];
    double area = c->area.at[track], young = c->young_modulus, h = c->hardening, force = 0.0;
    double removable = c->limit * c->thickness, volume = area * c->thickness;
    double *plastic = strain->at + track * strain->columns;
    *slope = 0.0;
    for (int64_t n = range[0]; n <= range[1]; n++) {
        double *p = plastic + wrapped(c, n);
        double depth = removable - gap - offset[n - range[0]];
        double stress = young * (depth / c->thickness - *p);
        if (!(stress > 0.0))
            continue;
        double grown = larger(0.0, stress - (c->yield_stress + h * *p)) / (young + h);
        double rate = grown > 0.0 ? young * h / (young + h) : young;
        if (grown > larger(0.0, c->limit - *p)) {
            grown = larger(0.0, c->limit - *p);
            rate = young;
        }
        stress -= young * grown;
        force += area * stress;
        *slope += area * rate / c->thickness;
        if (sums) {
            double after = *p + grown;
            sums[REMOVED] += volume * grown;
            sums[DISSIPATED] += volume * (c->yield_stress + 0.5 * h * (after + *p)) * grown;
            sums[STORED] += 0.5 * volume * stress * stress / young;
            *p = after;
        }
    }
    return force;
}

/* Return the nearest gap above or below a gap at which the slope of the force of `press_rods` changes,
 * or `nearest` if that is nearer. */
static double kink_of_rods(const Coating *c, int64_t node, const int64_t range[2],
                           const double *offset, const Matrix *strain, double gap, int above,
                           double nearest)
{
    const double *plastic = strain->at + c->track.at[node] * strain->columns;
    double young = c->young_modulus, h = c->hardening;
    for (int64_t n = range[0]; n <= range[1]; n++) {
        double p = plastic[wrapped(c, n)], yield = c->yield_stress + h * p;
        double touch = c->limit * c->thickness - offset[n - range[0]] - p * c->thickness;
        double worn = yield + (young + h) * larger(0.0, c->limit - p); /* stress if all yields */
        double kinks[3] = {touch, touch - c->thickness * yield / young,
                           touch - c->thickness * worn / young};
        for (int k = 0; k < 3; k++)
            if (kinks[k] > 0.0 && (above ? kinks[k] > gap : kinks[k] < gap))
                nearest = above ? smaller(nearest, kinks[k]) : larger(nearest, kinks[k]);
    }
    return nearest;
}

/* Return the wall at a place in elements, less a closure, for the present field of the casing. */
static double wall_near(const March *m, const Matrix *nodal, double place, double closed)
{
    const Casing *casing = m->stage.casing;
    double weight[4];
    int64_t e;
    hermite_weights(&place, 0.0, (double)casing->nodes, casing->element_length, 1, 1, &e, weight);
    double wall = hermite_value(nodal, e, weight, 1);
    return m->stage.closure ? wall - closed * hermite_value(&m->stage.closure->share, e, weight, 1)
                            : wall;
}

/* Find the rods under a node, and store the wall there relative to the wall at the node, both without
 * contact forces of this step. */
static void place_rods(const March *m, int64_t n, double closed)
{
    const Coating *c = m->stage.coating;
    RodScratch *r = &m->scratch->rods;
    const Matrix *nodal = &r->nodal;
    int64_t *range = r->range.at + 2 * n;
    double nodes = (double)m->stage.casing->nodes, place = position_of(m, n) + m->rotation.elements;
    double *offset = r->offset.at + n * r->offset.columns;
    rods_under(c, n, place / nodes, range);
    double here = wall_near(m, nodal, place, closed);
    for (int64_t k = range[0]; k <= range[1]; k++) {
        double middle = nodes * ((double)wrapped(c, k) + 0.5) / (double)c->rods;
        offset[k - range[0]] = m->stage.rotor->normal_part.at[n]
                               * (wall_near(m, nodal, middle, closed) - here);
    }
    r->near.at[n] = 1;
}

/* Return an upper bound of the slope of a nodal Hermite field on an element. */
static inline double steepest(const Casing *casing, int64_t element, const Matrix *nodal)
{
    const double *value = nodal->at, *slope = value + nodal->columns;
    double chord = fabs(value[element + 1] - value[element]) / casing->element_length;
    return 1.5 * chord + fabs(slope[element]) + fabs(slope[element + 1]);
}

/* Return the gap to the metal below which the rods under a node have to be evaluated. */
static double reach_of_rods(const March *m)
{
    const Coating *c = m->stage.coating;
    const Casing *casing = m->stage.casing;
    double slope = 0.0, half = 0.0;
    for (int64_t i = 0; i < c->half.size; i++)
        half = larger(half, c->half.at[i]);
    for (int64_t e = 0; casing->modes > 0 && e < casing->nodes; e++)
        slope = larger(slope, steepest(casing, e, &m->scratch->rods.nodal));
    slope *= casing->element_length * (double)casing->nodes / (2.0 * PI);
    slope += c->steepest;
    return c->limit * c->thickness + slope * (half + 0.5) * 2.0 * PI / (double)c->rods;
}

/* Return the force of the rods under a node at a gap to the metal, see `press_rods`. */
static double press_node(const March *m, int64_t n, double gap, double *slope, double *sums)
{
    const RodScratch *r = &m->scratch->rods;
    return press_rods(m->stage.coating, n, r->range.at + 2 * n,
                      r->offset.at + n * r->offset.columns, gap, &m->state->strain, slope, sums);
}

/* Find the nodes that touch the coating without contact forces of this step. Returns whether there
 * are any. */
static int find_rods(const March *m, double closed)
{
    const Casing *casing = m->stage.casing;
    const Matrix *nodal = casing->modes > 0 ? &m->scratch->fields.nodal : &casing->radial.start;
    int touches = 0;
    RodScratch *r = &m->scratch->rods;
    const double *gap = m->scratch->fields.free_gap.at;
    for (int64_t i = 0; i < 2 * nodal->columns; i++)
        r->nodal.at[i] = nodal->at[i];
    double reach = reach_of_rods(m), slope;
    for (int64_t n = 0; n < r->near.size; n++) {
        r->near.at[n] = 0;
        m->scratch->rods.push.at[n] = 0.0;
        if (!(gap[n] < reach))
            continue;
        place_rods(m, n, closed);
        if (press_node(m, n, gap[n], &slope, NULL) > 0.0)
            r->near.at[n] = 2;
        touches |= r->near.at[n] == 2;
    }
    return touches;
}

/* Wear the rods under the nodes at their gaps after the step, and add to the sums of the coating. */
static void wear_rods(const March *m, const double *gap)
{
    State *state = m->state;
    const RodScratch *r = &m->scratch->rods;
    double slope, *push = m->scratch->rods.push.at;
    for (int64_t n = 0; n < r->near.size; n++)
        if (m->scratch->nodes.listed.at[n] && r->near.at[n]) {
            push[n] = press_node(m, n, gap[n], &slope, state->coating.at);
            if (gap[n] > LEAST_GAP * m->stage.numbers->gap_scale) /* not at the metal */
                push[n] = -m->scratch->nodes.force.at[DIRECTIONS * n + RADIAL];
            state->coating_impulse.at[n] += push[n] * m->stage.numbers->time_step;
        }
}

/* Solve linear equations with `count` right-hand sides, in place;
 * `system` has the matrix, then the right-hand sides, by row. Returns 0 if it is singular. */
static int eliminate_rows(double *system, int64_t size, int64_t count)
{
    int64_t width = size + count;
    for (int64_t k = 0; k < size; k++) {
        double pivot = system[k * width + k]; /* near one or above: W has a positive diagonal */
        if (!(fabs(pivot) > 1e-300))
            return 0;
        for (int64_t i = 0; i < size; i++) {
            double ratio = system[i * width + k] / pivot;
            if (i == k || ratio == 0.0)
                continue;
            for (int64_t j = k + 1; j < width; j++)
                system[i * width + j] -= ratio * system[k * width + j];
        }
    }
    for (int64_t k = 0; k < size; k++)
        for (int64_t j = size; j < width; j++)
            system[k * width + j] /= system[k * width + k];
    return 1;
}

#endif
