/* The complementarity problem of a group of contact nodes in a step:
 *
 *     0 <= lambda  perp  g_p + W lambda >= 0
 *
 * The active set is changed for all nodes at a time, then node by node. If W is singular or the search
 * for the set does not end, the problem is solved by Lemke's method. W is stored by column. */
#ifndef COMPLEMENTARITY_H
#define COMPLEMENTARITY_H

#include "motion.h"

enum { LAST_TRIAL = 1000000 }; /* number that means that the problem was solved for all nodes */
enum { MENDED_TOGETHER = 6 };  /* trials of the active set before nodes are changed one by one */
#define SINGULAR 1e-11 /* share of the largest diagonal entry below which a pivot counts as zero */

/* Nodes whose contact forces are computed, with a number for each node. */
typedef struct {
    int64_t nodes;
    const double *gap;  /* gaps without contact forces */
    double *held;       /* 1 for nodes of the active set, otherwise 0 */
    double *multiplier; /* normal contact forces */
    const Matrix *response; /* W of all nodes by column */
} Candidates;

/* Take W of the first `size` nodes of `active` from that of all nodes, as the system. */
static void fill_system(const Candidates *k, ContactScratch *c, int64_t size)
{
    int64_t width = c->system.columns;
    for (int64_t n = 0; n < size; n++) {
        double *column = c->system.at + n * width;
        const double *from = k->response->at + c->active.at[n] * k->response->columns;
        for (int64_t i = 0; i < size && size < k->nodes; i++)
            column[i] = from[c->active.at[i]];
        for (int64_t i = 0; i < size && size == k->nodes; i += LANES)
            store(column + i, load(from + i));
        for (int64_t i = size; i < padded(size); i++)
            column[i] = 0.0;
    }
}

/* Solve a linear system that is stored by columns, with the right-hand side as the last column. The
 * system is overwritten. Returns 0 if a pivot nearly vanishes, otherwise 1.
 *
 * The method is that of Gauss and Jordan. As entire registers are used, eliminating the rows above
 * the pivot takes no additional time, and no back substitution is needed. Without friction W is
 * positive definite, so the pivots are taken from the diagonal. */
static inline int eliminate(ContactScratch *c, int64_t size)
{
    int64_t width = c->system.columns;
    double *w = c->system.at, largest = 0.0;
    for (int64_t k = 0; k < size; k++)
        largest = larger(largest, fabs(w[k * width + k]));
    for (int64_t k = 0; k < size; k++) {
        double *column = w + k * width;
        if (!(fabs(column[k]) > SINGULAR * largest))
            return 0;
        c->solution.at[k] = 1.0 / column[k];
        Lanes inverse = splat(-c->solution.at[k]);
        for (int64_t i = 0; i < size; i += LANES) {
            Lanes others = load(c->others.at + k * c->others.columns + i);
            Lanes ratio = mul(mul(load(column + i), others), inverse);
            for (double *right = column + width; right <= w + size * width; right += width)
                store(right + i, muladd(ratio, splat(right[k]), load(right + i)));
        }
    }
    for (int64_t k = 0; k < size; k++)
        c->solution.at[k] *= w[size * width + k];
    return 1;
}

/* Compute the contact forces that close the gaps of the active nodes, and remove nodes with negative
 * forces from the active set (`held`). Returns the number of nodes with negative forces, where 0
 * means that the set is complete, or -1 if W is singular. */
static inline int64_t active_multipliers(const Candidates *k, ContactScratch *c, int64_t size,
                                         int one_by_one)
{
    double *right = c->system.at + size * c->system.columns;
    int64_t released = 0;
    for (int64_t i = 0; i < size; i += LANES)
        store(right + i, splat(0.0));
    for (int64_t i = 0; i < size; i++)
        right[i] = -k->gap[c->active.at[i]];
    if (!eliminate(c, size))
        return -1;
    for (int64_t j = 0; j < k->nodes; j++)
        k->multiplier[j] = 0.0;
    for (int64_t i = 0; i < size; i++) {
        if (c->solution.at[i] < 0.0) {
            if (released == 0 || !one_by_one)
                k->held[c->active.at[i]] = 0.0;
            released++;
        } else
            k->multiplier[c->active.at[i]] = c->solution.at[i];
    }
    return released;
}

/* Fill the tableau of Lemke's method. Returns the row of the most negative gap. */
static int64_t fill_tableau(const Candidates *k, ContactScratch *c, double gap_scale, double w_scale)
{
    int64_t nodes = k->nodes, row = 0;
    for (int64_t i = 0; i < nodes; i++) {
        double *t = c->tableau.at + i * c->tableau.columns;
        for (int64_t j = 0; j < nodes; j++) {
            t[j] = i == j ? 1.0 : 0.0;
            t[nodes + j] = -c->system.at[j * c->system.columns + i] / w_scale;
        }
        t[2 * nodes] = -1.0;
        t[2 * nodes + 1] = k->gap[i] / gap_scale;
        k->multiplier[i] = 0.0;
        c->basis.at[i] = i;
        if (k->gap[i] < k->gap[row])
            row = i;
    }
    return row;
}

/* Make the entering variable the basic variable of a row. */
static void pivot(ContactScratch *c, int64_t nodes, int64_t row, int64_t entering)
{
    int64_t width = c->tableau.columns;
    double *own = c->tableau.at + row * width, divisor = own[entering];
    for (int64_t j = 0; j < width; j++)
        own[j] /= divisor;
    for (int64_t i = 0; i < nodes; i++) {
        double *other = c->tableau.at + i * width, ratio = other[entering];
        if (i != row && ratio != 0.0)
            for (int64_t j = 0; j < width; j++)
                other[j] -= ratio * own[j];
    }
    c->basis.at[row] = entering;
}

/* Return the row with the smallest ratio, -1 if there is none. Among equal ratios, the row of the
 * covering variable is preferred. */
static int64_t least_ratio(const ContactScratch *c, int64_t nodes, int64_t entering)
{
    int64_t width = c->tableau.columns, cover = 2 * nodes, row = -1;
    double best = INFINITY;
    for (int64_t i = 0; i < nodes; i++) {
        const double *t = c->tableau.at + i * width;
        if (!(t[entering] > 1e-10))
            continue;
        double ratio = t[cover + 1] / t[entering];
        int tied = row >= 0 && fabs(ratio - best) <= 1e-14 * (1.0 + fabs(best));
        if ((tied && c->basis.at[i] == cover) || (!tied && ratio < best)) {
            row = i;
            best = ratio;
        }
    }
    return row;
}

/* Solve the complementarity problem by Lemke's method, which allows a singular W. Returns whether a
 * solution was found.
 *
 * The tableau contains w - M z - z0 = q, scaled, with a row for each basic variable. The numbers of
 * variables are 0..n-1 for w (gaps), n..2n-1 for z (contact forces), 2n for the covering variable
 * z0. */
static int lemke(const Candidates *k, ContactScratch *c)
{
    int64_t nodes = k->nodes, cover = 2 * nodes, entering = cover;
    double gap_scale = 0.0, w_scale = 0.0;
    for (int64_t i = 0; i < nodes; i++) {
        gap_scale = larger(gap_scale, fabs(k->gap[i]));
        w_scale = larger(w_scale, fabs(c->system.at[i * c->system.columns + i]));
    }
    int64_t row = fill_tableau(k, c, gap_scale, w_scale);
    for (int64_t pivots = 0; pivots < 50 * nodes && row >= 0; pivots++) {
        int64_t leaving = c->basis.at[row];
        pivot(c, nodes, row, entering);
        if (leaving == cover) {
            for (int64_t i = 0; i < nodes; i++) {
                int64_t basic = c->basis.at[i];
                double value = c->tableau.at[i * c->tableau.columns + cover + 1];
                if (nodes <= basic && basic < cover)
                    k->multiplier[basic - nodes] = larger(0.0, value * gap_scale / w_scale);
            }
            return 1;
        }
        entering = leaving < nodes ? leaving + nodes : leaving - nodes;
        row = least_ratio(c, nodes, entering);
    }
    return 0;
}

/* Improve the contact forces by projected Gauss-Seidel iterations, if Lemke's method has failed. */
static void gauss_seidel(const Candidates *k, const ContactScratch *c)
{
    int64_t nodes = k->nodes, width = c->system.columns;
    const double *w = c->system.at;
    double *multiplier = k->multiplier;
    for (int round = 0; round < 2000; round++) {
        double change = 0.0, largest = 0.0;
        for (int64_t i = 0; i < nodes; i++) {
            double closing = k->gap[i];
            for (int64_t j = 0; j < nodes; j++)
                closing += w[j * width + i] * multiplier[j];
            double value = larger(0.0, multiplier[i] - closing / w[i * width + i]);
            change = larger(change, fabs(value - multiplier[i]));
            largest = larger(largest, value);
            multiplier[i] = value;
        }
        if (change <= 1e-14 * largest)
            return;
    }
}

/* Compute the contact forces of the active set without tensile forces; nodes with tensile forces are
 * removed from the set. If W is singular or the search for the set does not end, the
 * complementarity problem is solved for all nodes. Returns the number of active nodes. `trial` is
 * increased for each change of the set, and set to LAST_TRIAL if the problem was solved for all
 * nodes; `solved` is set to 0 if this failed. */
static int64_t contact_multipliers(int64_t *trial, int *solved, const Candidates *k,
                                   ContactScratch *c)
{
    int64_t released = 1, size = 0;
    int together = 0;
    while (released > 0 || together) {
        size = 0;
        for (int64_t j = 0; j < k->nodes; j++)
            if (together || k->held[j] > 0.0)
                c->active.at[size++] = j;
        fill_system(k, c, size);
        if (together) {
            if (!lemke(k, c)) {
                *solved = 0;
                gauss_seidel(k, c);
            }
            *trial = LAST_TRIAL;
            return size;
        }
        released = active_multipliers(k, c, size, *trial > MENDED_TOGETHER);
        if (released > 0)
            *trial += 1;
        together = released < 0 || (released == 0 && *trial > MENDED_TOGETHER + 4 * k->nodes);
    }
    return size;
}

#endif
