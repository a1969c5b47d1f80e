/* Contact in a step: the matrix W of the active tips, and the contact forces (multipliers). */
#ifndef CONTACT_H
#define CONTACT_H

#include "foreshortening.h"

enum { LAST_TRIAL = 1000000 }; /* number that means that the problem was solved for all tips */
enum { MENDED_TOGETHER = 6 };  /* trials of the active set before tips are changed one by one */
#define SINGULAR 1e-11 /* share of the largest diagonal entry below which a pivot counts as zero */

/* Return the row for a direction of sliding: 0 for -1, 1 for 0 and 2 for 1. */
static inline int64_t sense(double sign) { return sign > 0.0 ? 2 : sign < 0.0 ? 0 : 1; }

/* Copy the part of W due to the rotor for the active tips, unless it is there from the last
 * step. */
static inline void take_rotor(const Cube *rotor_w, const Foreshortening *bending,
                              BendScratch *bent, double friction, ContactScratch *c, int64_t size)
{
    int64_t tips = c->known.columns, *tip = c->known.at, *slides = c->known.at + tips;
    int same = size < tips ? tip[size] < 0 : 1;
    for (int64_t n = 0; n < size; n++) {
        int64_t j = c->active.at[n];
        same = same && tip[n] == j && slides[n] == sense(c->sign.at[j]);
    }
    if (same)
        return;
    for (int64_t n = 0; n < tips; n++)
        tip[n] = -1;
    for (int64_t n = 0; n < size; n++) {
        int64_t j = c->active.at[n];
        tip[n] = j;
        slides[n] = sense(c->sign.at[j]);
        const double *from = rotor_w->at + (slides[n] * tips + j) * rotor_w->columns;
        double *to = c->on_rotor.at + n * c->on_rotor.columns;
        for (int64_t m = 0; m < c->on_rotor.columns; m++)
            to[m] = m < size ? from[c->active.at[m]] : 0.0;
        if (bending && bent->count.at[NEAR_TIPS] > 0)
            bend_answers(bending, bent, c, n, size, friction * c->sign.at[j]);
    }
}

/* Return four products whose sum is the change of the gap of a tip due to a unit force of
 * another. */
static inline Half answer(const double *block, Half n0, Half n1, Half n2, Half n3,
                          const double *end)
{
    Half one = half_mul(half_load(block), n0), two = half_mul(half_load(block + 2 * HALF), n2);
    one = half_muladd(half_load(block + HALF), n1, one);
    two = half_muladd(half_load(block + 3 * HALF), n3, two);
    return half_mul(half_add(one, two), half_load(end));
}

/* Compute W of the active tips by column: entry [n, m] is the change of the gap of tip m due to a
 * unit force of tip n.
 *
 * The part of W due to the casing is n_i^T C (n_j + mu s t_j), where n_i and n_j are the four nodal
 * values at each tip. C is a block of 4 x 4 in `compliance` for each direction of sliding s and
 * each pair of elements. If only the distance of the elements matters (`spacing` is one), there is
 * a block for each distance. */
static inline void delassus(const Casing *casing, const FieldScratch *f, ContactScratch *c,
                            int64_t size)
{
    const int64_t block = HALF * HALF, senses = casing->compliance.size / 3;
    int64_t padded = (size + HALF - 1) / HALF * HALF, width = f->hermite.columns;
    int64_t *rows = c->rows.at;
    double *ends = c->ends.at;
    for (int64_t m = 0; m < padded; m++) {
        int64_t j = m < size ? c->active.at[m] : 0;
        rows[m] = block * casing->spacing * f->element.at[j];
        for (int k = 0; k < HALF; k++)
            ends[HALF * m + k] = m < size ? f->hermite.at[k * width + j] : 0.0;
    }
    for (int64_t n = 0; n < size; n++) {
        int64_t j = c->active.at[n], e = f->element.at[j];
        double *w = c->system.at + n * c->system.columns;
        const double *on_rotor = c->on_rotor.at + n * c->on_rotor.columns;
        const double *from = casing->compliance.at + senses * sense(c->sign.at[j])
                             + block * (casing->spacing == 1 ? casing->nodes - e : e);
        const double *hermite = f->hermite.at + j;
        Half n0 = half_splat(hermite[0]), n1 = half_splat(hermite[width]);
        Half n2 = half_splat(hermite[2 * width]), n3 = half_splat(hermite[3 * width]);
        for (int64_t m = 0; m < padded; m += HALF) {
            const double *end = ends + HALF * m;
            Half on_casing =
                half_totals(answer(from + rows[m], n0, n1, n2, n3, end),
                            answer(from + rows[m + 1], n0, n1, n2, n3, end + HALF),
                            answer(from + rows[m + 2], n0, n1, n2, n3, end + 2 * HALF),
                            answer(from + rows[m + 3], n0, n1, n2, n3, end + 3 * HALF));
            half_store(w + m, half_add(on_casing, half_load(on_rotor + m)));
        }
        if (padded % LANES != 0)
            half_store(w + padded, half_splat(0.0));
        c->diagonal.at[j] = w[n];
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

/* Compute the contact forces that close the gaps of the active tips, and remove tips with negative
 * forces from the active set (`held`). Returns the number of tips with negative forces, where 0
 * means that the set is complete, or -1 if W is singular. */
static inline int64_t active_multipliers(const double *gap, double *held, ContactScratch *c,
                                         int64_t size, int one_by_one)
{
    double *right = c->system.at + size * c->system.columns;
    int64_t released = 0;
    for (int64_t i = 0; i < size; i += LANES)
        store(right + i, splat(0.0));
    for (int64_t i = 0; i < size; i++)
        right[i] = -gap[c->active.at[i]];
    if (!eliminate(c, size))
        return -1;
    for (int64_t j = 0; j < c->multiplier.size; j++)
        c->multiplier.at[j] = 0.0;
    for (int64_t i = 0; i < size; i++) {
        if (c->solution.at[i] < 0.0) {
            if (released == 0 || !one_by_one)
                held[c->active.at[i]] = 0.0;
            released++;
        } else
            c->multiplier.at[c->active.at[i]] = c->solution.at[i];
    }
    return released;
}

/* Fill the tableau of Lemke's method. Returns the row of the most negative gap. */
static int64_t fill_tableau(const double *gap, ContactScratch *c, double gap_scale, double w_scale)
{
    int64_t tips = c->multiplier.size, row = 0;
    for (int64_t i = 0; i < tips; i++) {
        double *t = c->tableau.at + i * c->tableau.columns;
        for (int64_t j = 0; j < tips; j++) {
            t[j] = i == j ? 1.0 : 0.0;
            t[tips + j] = -c->system.at[j * c->system.columns + i] / w_scale;
        }
        t[2 * tips] = -1.0;
        t[2 * tips + 1] = gap[i] / gap_scale;
        c->multiplier.at[i] = 0.0;
        c->basis.at[i] = i;
        if (gap[i] < gap[row])
            row = i;
    }
    return row;
}

/* Make the entering variable the basic variable of a row. */
static void pivot(ContactScratch *c, int64_t row, int64_t entering)
{
    int64_t width = c->tableau.columns;
    double *own = c->tableau.at + row * width, divisor = own[entering];
    for (int64_t j = 0; j < width; j++)
        own[j] /= divisor;
    for (int64_t i = 0; i < c->tableau.rows; i++) {
        double *other = c->tableau.at + i * width, ratio = other[entering];
        if (i != row && ratio != 0.0)
            for (int64_t j = 0; j < width; j++)
                other[j] -= ratio * own[j];
    }
    c->basis.at[row] = entering;
}

/* Return the row with the smallest ratio, -1 if there is none. Among equal ratios, the row of the
 * covering variable is preferred. */
static int64_t least_ratio(const ContactScratch *c, int64_t entering)
{
    int64_t width = c->tableau.columns, cover = width - 2, row = -1;
    double best = INFINITY;
    for (int64_t i = 0; i < c->tableau.rows; i++) {
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
static int lemke(const double *gap, ContactScratch *c)
{
    int64_t tips = c->multiplier.size, cover = 2 * tips, entering = cover;
    double gap_scale = 0.0, w_scale = 0.0;
    for (int64_t i = 0; i < tips; i++) {
        gap_scale = larger(gap_scale, fabs(gap[i]));
        w_scale = larger(w_scale, fabs(c->system.at[i * c->system.columns + i]));
    }
    int64_t row = fill_tableau(gap, c, gap_scale, w_scale);
    for (int64_t pivots = 0; pivots < 50 * tips && row >= 0; pivots++) {
        int64_t leaving = c->basis.at[row];
        pivot(c, row, entering);
        if (leaving == cover) {
            for (int64_t i = 0; i < tips; i++) {
                int64_t basic = c->basis.at[i];
                double value = c->tableau.at[i * c->tableau.columns + cover + 1];
                if (tips <= basic && basic < cover)
                    c->multiplier.at[basic - tips] = larger(0.0, value * gap_scale / w_scale);
            }
            return 1;
        }
        entering = leaving < tips ? leaving + tips : leaving - tips;
        row = least_ratio(c, entering);
    }
    return 0;
}

/* Improve the contact forces by projected Gauss-Seidel iterations, if Lemke's method has failed. */
static void gauss_seidel(const double *gap, ContactScratch *c)
{
    int64_t tips = c->multiplier.size, width = c->system.columns;
    const double *w = c->system.at;
    double *multiplier = c->multiplier.at;
    for (int round = 0; round < 2000; round++) {
        double change = 0.0, largest = 0.0;
        for (int64_t i = 0; i < tips; i++) {
            double closing = gap[i];
            for (int64_t j = 0; j < tips; j++)
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

/* Return max |min(g_j, W_jj lambda_j)| / max(clearance, max |g_p|), with gaps g of the corrected
 * displacements. */
static inline double complementarity_residual(double scale, const FieldScratch *f,
                                              const ContactScratch *c)
{
    double worst = 0.0;
    for (int64_t j = 0; j < c->multiplier.size; j++) {
        double multiplier = c->multiplier.at[j], gap = f->gap.at[j];
        scale = larger(scale, fabs(f->free_gap.at[j]));
        if (multiplier > 0.0)
            worst = larger(worst, fabs(smaller(gap, c->diagonal.at[j] * multiplier)));
        else
            worst = larger(worst, -gap);
    }
    return scale > 0.0 ? worst / scale : worst;
}

/* Compute the contact forces of the active set without tensile forces; tips with tensile forces are
 * removed from the set. If W is singular or the search for the set does not end, the
 * complementarity problem is solved for all tips. Returns the number of active tips. `trial` is
 * increased for each change of the set, and set to LAST_TRIAL if the problem was solved for all
 * tips. */
static int64_t contact_multipliers(int64_t *trial, const Stage *stage, State *state,
                                   const FieldScratch *f, BendScratch *bent, ContactScratch *c)
{
    int64_t tips = c->multiplier.size, released = 1, size = 0;
    int together = 0;
    const double *gap = f->free_gap.at;
    while (released > 0 || together) {
        size = 0;
        for (int64_t j = 0; j < tips; j++)
            if (together || state->held.at[j] > 0.0)
                c->active.at[size++] = j;
        take_rotor(&stage->rotor->w, stage->foreshortening, bent, stage->numbers->friction, c, size);
        delassus(stage->casing, f, c, size);
        if (together) {
            if (!lemke(gap, c)) {
                state->counts.at[UNSOLVED] += 1.0;
                gauss_seidel(gap, c);
            }
            *trial = LAST_TRIAL;
            return size;
        }
        released = active_multipliers(gap, state->held.at, c, size, *trial > MENDED_TOGETHER);
        if (released > 0)
            *trial += 1;
        together = released < 0 || (released == 0 && *trial > MENDED_TOGETHER + 4 * tips);
    }
    return size;
}

/* Make the first active set: the tips in contact at the last step and the tips that penetrate.
 * Returns the number of tips that penetrate; if it is 0, the set is empty. Most tips in contact at
 * the last step remain in contact, even if the forces of other tips have opened their gaps. */
static inline int64_t propose_contacts(const double *gap, Vector *held)
{
    int64_t penetrating = 0;
    for (int64_t j = 0; j < held->size; j++)
        penetrating += gap[j] < 0.0;
    for (int64_t j = 0; j < held->size; j++) {
        if (penetrating == 0)
            held->at[j] = 0.0;
        else if (gap[j] < 0.0)
            held->at[j] = 1.0;
    }
    return penetrating;
}

/* Add the tips that penetrate after the correction to the active set. Returns their number. */
static inline int64_t join_contacts(const double *gap, Vector *held, int one_by_one)
{
    int64_t joined = 0;
    for (int64_t j = 0; j < held->size; j++)
        if (held->at[j] == 0.0 && gap[j] < 0.0) {
            if (joined == 0 || !one_by_one)
                held->at[j] = 1.0;
            joined++;
        }
    return joined;
}

#endif
