/* Abradable coating under contact nodes: elastic-plastic rods in tracks along the circumference.
 *
 * The law of a rod is that of `coating.h`. All nodes at one axial position cut the same track. A node
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

#include "coating.h"
#include "ring.h"

/* Return the first and the last rod under the footprint of a node at an angle [rad]. */
static void rods_under(const NodeCoating *c, int64_t node, double angle, int64_t range[2])
{
    double turns = angle / (2.0 * PI);
    double at = (turns - floor(turns)) * (double)c->rods, half = c->half.at[node];
    range[0] = (int64_t)ceil(at - half - 0.5);
    range[1] = (int64_t)floor(at + half - 0.5);
}

/* Return the number of a rod between 0 and the number of rods. */
static int64_t wrapped(const NodeCoating *c, int64_t rod)
{
    return rod < 0 ? rod + c->rods : rod < c->rods ? rod : rod - c->rods;
}

/* Compress the rods of a node at a gap to the metal. Returns the force [N]; `slope` gets its
 * decrease with the gap [N/m]. If `sums` is given, plastic strains are updated, and changes are added
 * to it. */
static double press_rods(const NodeCoating *c, int64_t node, const int64_t range[2],
                         const double *offset, double gap, double *strain, double *slope,
                         double *sums)
{
    int64_t track = c->track.at[node];
    double area = c->area.at[track], young = c->young_modulus, h = c->hardening, force = 0.0;
    double removable = c->limit * c->thickness, volume = area * c->thickness;
    double *plastic = strain + track * c->rods;
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

/* Solve (I + W K) x = right for the diagonal K of slopes and `count` right-hand sides, in place;
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
