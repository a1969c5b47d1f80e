/* Contact of tips in a step: the matrix W of the active tips, and the active set. */
#ifndef CONTACT_H
#define CONTACT_H

#include "complementarity.h"
#include "foreshortening.h"

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
 * a block for each distance; a rigid wall (`spacing` is zero) has one block of zeros. */
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
                             + block * (casing->spacing == 1 ? casing->nodes - e
                                        : casing->spacing > 1 ? e : 0);
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

/* Compute W of the active tips; see `FillSystem`. */
static inline void fill_tips(const March *m, const Candidates *k, int64_t size)
{
    (void)k;
    ContactScratch *c = &m->scratch->contact;
    take_rotor(&m->stage.rotor->w, m->stage.foreshortening, &m->scratch->bending,
               m->stage.numbers->friction, c, size);
    delassus(m->stage.casing, &m->scratch->fields, c, size);
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
