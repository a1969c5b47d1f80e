/* Changes of displacements and gaps of a group of contact nodes due to unit forces within the step:
 * those of the rotor, and those of the casing under the nodes.
 *
 * The part of the casing is n_i^T C n_j, where n_i and n_j are the four Hermite weights at each node.
 * C is a block of 4 x 4 in a table of `compliance` for each pair of elements. If only the distance of
 * the elements matters (`spacing` is one), there is a block for each distance. With full sliding there
 * are four tables: w due to forces along w and along u, then u due to these forces. Otherwise there
 * are three: w due to a normal force with friction, for the directions of sliding -1, 0 and 1. */
#ifndef COMPLIANCE_H
#define COMPLIANCE_H

#include "foreshortening.h"
#include "sticking.h"

enum { BLOCK = HALF * HALF, SLIDING_TABLES = 3, SLIP_TABLES = 4 };

/* Store the weights and the elements of the nodes of a group. */
static void prepare_casing(const March *m, int64_t size)
{
    const FieldScratch *f = &m->scratch->fields;
    const NodeScratch *s = &m->scratch->nodes;
    int64_t step = BLOCK * m->stage.casing->spacing, width = f->hermite.columns;
    for (int64_t i = 0; i < size; i++) {
        const double *weight = f->hermite.at + s->list.at[i];
        s->blocks.at[i] = step * f->element.at[s->list.at[i]];
        for (int k = 0; k < HALF; k++)
            s->ends.at[HALF * i + k] = weight[k * width];
    }
    for (int64_t i = size; i < padded(size); i++) {
        s->blocks.at[i] = s->blocks.at[0];
        for (int k = 0; k < HALF; k++)
            s->ends.at[HALF * i + k] = 0.0;
    }
}

/* Return four products whose sum is a displacement of the casing under a node due to a force at
 * another. */
static inline Half answer(const double *block, const Half weight[HALF], const double *end)
{
    Half one = half_mul(half_load(block), weight[0]);
    Half two = half_mul(half_load(block + 2 * HALF), weight[2]);
    one = half_muladd(half_load(block + HALF), weight[1], one);
    two = half_muladd(half_load(block + 3 * HALF), weight[3], two);
    return half_mul(half_add(one, two), half_load(end));
}

/* Add the displacements of the casing under all nodes of a group due to a force under a node, with one
 * of the tables, to a padded row, after `prepare_casing`. */
INLINED void add_casing(const March *m, int64_t table, int64_t tables, int64_t node, int64_t size,
                        double *row)
{
    const Casing *casing = m->stage.casing;
    const FieldScratch *f = &m->scratch->fields;
    const int64_t *blocks = m->scratch->nodes.blocks.at;
    const double *ends = m->scratch->nodes.ends.at;
    int64_t e = f->element.at[node], first = casing->spacing == 1 ? casing->nodes - e : e;
    const double *from = casing->compliance.at + table * (casing->compliance.size / tables);
    from += BLOCK * (casing->spacing > 0 ? first : 0);
    Half weight[HALF];
    for (int k = 0; k < HALF; k++)
        weight[k] = half_splat(f->hermite.at[k * f->hermite.columns + node]);
    for (int64_t i = 0; i < size; i += HALF) {
        const double *end = ends + HALF * i;
        Half sum = half_totals(answer(from + blocks[i], weight, end),
                               answer(from + blocks[i + 1], weight, end + HALF),
                               answer(from + blocks[i + 2], weight, end + 2 * HALF),
                               answer(from + blocks[i + 3], weight, end + 3 * HALF));
        half_store(row + i, half_add(sum, half_load(row + i)));
    }
}

/* Compute the part of `response` of the rotor, for given directions of sliding, unless it is known
 * from the last step. */
static void take_rotor(const March *m, int64_t size)
{
    const Rotor *rotor = m->stage.rotor;
    NodeScratch *s = &m->scratch->nodes;
    int64_t *known = s->known.at, width = rotor->compliance.columns, count = width / DIRECTIONS;
    int same = size == s->known.size || known[size] < 0;
    for (int64_t n = 0; same && n < size; n++)
        same = known[n] == s->list.at[n] && s->known_sign.at[n] == s->sign.at[known[n]];
    if (same)
        return;
    for (int64_t j = 0; j < size; j++) {
        int64_t n = s->list.at[j], first = n / count * count; /* first node of its copy */
        double friction = m->stage.numbers->friction * s->sign.at[n];
        double *row = s->on_rotor.at + j * s->on_rotor.columns;
        const double *push = rotor->compliance.at + DIRECTIONS * n * width; /* radial displacements */
        const double *drag = push + width;
        for (int64_t i = 0; i < padded(size); i++) {
            int64_t other = i < size ? s->list.at[i] - first : -1;
            int coupled = 0 <= other && other < count;
            row[i] = coupled ? push[other] + friction * drag[other] : 0.0;
        }
        if (m->stage.foreshortening && m->scratch->bending.count.at[NEAR_TIPS] > 0)
            bend_answers(m->stage.foreshortening, &m->scratch->bending, s, j, size, friction);
        known[j] = n;
        s->known_sign.at[j] = s->sign.at[n];
    }
    if (size < s->known.size)
        known[size] = -1;
}

/* Compute W of a group for given directions of sliding. */
static void take_response(const March *m, int64_t size)
{
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = s->response.columns;
    take_rotor(m, size);
    for (int64_t j = 0; j < size; j++) {
        int64_t n = s->list.at[j];
        double *row = s->response.at + j * width;
        for (int64_t i = 0; i < size; i += LANES)
            store(row + i, load(s->on_rotor.at + j * s->on_rotor.columns + i));
        if (m->stage.casing->modes > 0)
            add_casing(m, 1 + (int64_t)s->sign.at[n], SLIDING_TABLES, n, size, row);
    }
}

/* Compute the displacements of a group in all directions due to unit forces in all directions. */
static void take_compliance(const March *m, int64_t size)
{
    const Rotor *rotor = m->stage.rotor;
    NodeScratch *s = &m->scratch->nodes;
    int64_t width = rotor->compliance.columns, count = width / DIRECTIONS;
    int64_t wide = s->compliance.columns;
    for (int64_t i = 0; i < size; i++) {
        int64_t n = s->list.at[i], first = n / count * count; /* first node of its copy */
        double *row = s->compliance.at + DIRECTIONS * i * wide;
        for (int64_t j = 0; j < size; j++) {
            int64_t other = s->list.at[j];
            const double *by = rotor->compliance.at + DIRECTIONS * other * width + (n - first);
            int coupled = first <= other && other < first + count;
            for (int64_t k = 0; k < DIRECTIONS; k++)
                for (int64_t l = 0; l < DIRECTIONS; l++)
                    row[k * wide + DIRECTIONS * j + l] = coupled ? by[l * width + k * count] : 0.0;
        }
    }
    for (int64_t j = 0; j < size && m->stage.casing->modes > 0; j++)
        for (int by = 0; by < 2; by++)
            for (int kind = 0; kind < 2; kind++) {
                double *row = s->response.at;
                for (int64_t i = 0; i < padded(size); i++)
                    row[i] = 0.0;
                add_casing(m, 2 * kind + by, SLIP_TABLES, s->list.at[j], size, row);
                for (int64_t i = 0; i < size; i++)
                    s->compliance.at[(DIRECTIONS * i + kind) * wide + DIRECTIONS * j + by] += row[i];
            }
}

/* Compute the response of the group to its forces. */
static void respond_group(const March *m, int64_t size)
{
    if (m->stage.casing->modes > 0)
        prepare_casing(m, size);
    if (m->stage.rotor->full > 0.0)
        take_compliance(m, size);
    else
        take_response(m, size);
}

#endif
