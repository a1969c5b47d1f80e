/* Operations on eight doubles at a time, with results that do not depend on the vector registers.
 *
 * A sum over an array consists of eight sums, one for each lane, which `total` adds in a fixed
 * order. The compiler may not reorder operations (-ffp-contract=off, no -ffast-math). Therefore all
 * compilers and all widths of registers give identical results. A type is an array of vectors
 * of the width of the processor; GCC and Clang support such vectors on all processors.
 */
#ifndef LANES_H
#define LANES_H

#include "kernel.h"

#if defined(WIDTH) /* a build for another processor, see `variants.h` */
#elif defined(__AVX512F__)
#define WIDTH 8
#define HALF_WIDTH 4
#elif defined(__AVX__)
#define WIDTH 4
#define HALF_WIDTH 4
#else
#define WIDTH 2
#define HALF_WIDTH 2
#endif

/* Function whose `Lanes` stay in registers: a call would pass them through memory. */
#define INLINED static inline __attribute__((always_inline))

/* Define a type of `count` lanes in vectors of `width` doubles, and its operations. */
#define DEFINE_LANES(Type, prefix, count, width)                                                   \
    typedef double Type##Vector __attribute__((vector_size(8 * (width))));                         \
    typedef double Type##Place __attribute__((vector_size(8 * (width)), aligned(8), may_alias));   \
    typedef struct {                                                                               \
        Type##Vector v[(count) / (width)];                                                         \
    } Type;                                                                                        \
    static inline Type prefix##splat(double x)                                                     \
    {                                                                                              \
        Type out;                                                                                  \
        for (int k = 0; k < (count) / (width); k++)                                                \
            out.v[k] = x - (Type##Vector){0};                                                      \
        return out;                                                                                \
    }                                                                                              \
    static inline Type prefix##load(const double *from)                                            \
    {                                                                                              \
        Type out;                                                                                  \
        for (int k = 0; k < (count) / (width); k++)                                                \
            out.v[k] = *(const Type##Place *)(from + k * (width));                                 \
        return out;                                                                                \
    }                                                                                              \
    static inline void prefix##store(double *to, Type a)                                           \
    {                                                                                              \
        for (int k = 0; k < (count) / (width); k++)                                                \
            *(Type##Place *)(to + k * (width)) = a.v[k];                                           \
    }                                                                                              \
    static inline Type prefix##add(Type a, Type b)                                                 \
    {                                                                                              \
        for (int k = 0; k < (count) / (width); k++)                                                \
            a.v[k] += b.v[k];                                                                      \
        return a;                                                                                  \
    }                                                                                              \
    static inline Type prefix##sub(Type a, Type b)                                                 \
    {                                                                                              \
        for (int k = 0; k < (count) / (width); k++)                                                \
            a.v[k] -= b.v[k];                                                                      \
        return a;                                                                                  \
    }                                                                                              \
    static inline Type prefix##mul(Type a, Type b)                                                 \
    {                                                                                              \
        for (int k = 0; k < (count) / (width); k++)                                                \
            a.v[k] *= b.v[k];                                                                      \
        return a;                                                                                  \
    }                                                                                              \
    /* a * b + c, rounded twice */                                                                 \
    static inline Type prefix##muladd(Type a, Type b, Type c)                                      \
    {                                                                                              \
        for (int k = 0; k < (count) / (width); k++)                                                \
            c.v[k] += a.v[k] * b.v[k];                                                             \
        return c;                                                                                  \
    }

DEFINE_LANES(Lanes, , LANES, WIDTH)
DEFINE_LANES(Half, half_, HALF, HALF_WIDTH)

/* Return the larger number of each lane. */
static inline Half half_larger(Half a, Half b)
{
    typedef int64_t Mask __attribute__((vector_size(8 * HALF_WIDTH)));
    for (int k = 0; k < HALF / HALF_WIDTH; k++) {
        Mask first = a.v[k] > b.v[k];
        a.v[k] = (HalfVector)((first & (Mask)a.v[k]) | (~first & (Mask)b.v[k]));
    }
    return a;
}

/* Return 1 in each lane where a is above b, otherwise 0. */
static inline Half half_above(Half a, Half b)
{
    typedef int64_t Mask __attribute__((vector_size(8 * HALF_WIDTH)));
    Half one = half_splat(1.0);
    for (int k = 0; k < HALF / HALF_WIDTH; k++)
        a.v[k] = (HalfVector)((a.v[k] > b.v[k]) & (Mask)one.v[k]);
    return a;
}

/* Sum of the lanes. */
static inline double total(Lanes a)
{
    double t[LANES];
    store(t, a);
    return ((t[0] + t[4]) + (t[2] + t[6])) + ((t[1] + t[5]) + (t[3] + t[7]));
}

static inline double half_total(Half a)
{
    double t[HALF];
    half_store(t, a);
    return (t[0] + t[2]) + (t[1] + t[3]);
}

/* Return the sums of the lanes of a, b, c and d in one lane each. */
static inline Half half_totals(Half a, Half b, Half c, Half d)
{
#if HALF_WIDTH == 4
#if defined(__clang__)
#define PICK(x, y, i, j, k, l) __builtin_shufflevector(x, y, i, j, k, l)
#else
    typedef int64_t Order __attribute__((vector_size(32)));
#define PICK(x, y, i, j, k, l) __builtin_shuffle(x, y, (Order){i, j, k, l})
#endif
    HalfVector ab = PICK(a.v[0], b.v[0], 0, 4, 2, 6) + PICK(a.v[0], b.v[0], 1, 5, 3, 7);
    HalfVector cd = PICK(c.v[0], d.v[0], 0, 4, 2, 6) + PICK(c.v[0], d.v[0], 1, 5, 3, 7);
    return (Half){{PICK(ab, cd, 0, 1, 4, 5) + PICK(ab, cd, 2, 3, 6, 7)}};
#undef PICK
#else
    double t[4 * HALF], out[HALF];
    half_store(t, a);
    half_store(t + HALF, b);
    half_store(t + 2 * HALF, c);
    half_store(t + 3 * HALF, d);
    for (int k = 0; k < HALF; k++)
        out[k] = (t[HALF * k] + t[HALF * k + 1]) + (t[HALF * k + 2] + t[HALF * k + 3]);
    return half_load(out);
#endif
}

/* Store the lanes in reverse order, after adding `start` to them. */
static inline void store_reversed(double *restrict to, Lanes a, const double *restrict start)
{
    double t[LANES];
    store(t, a);
    for (int k = 0; k < LANES; k++)
        to[k] = start ? t[LANES - 1 - k] + start[k] : t[LANES - 1 - k];
}

/* Scalar product of arrays of any length. */
static inline double dot(const double *a, const double *b, int64_t size)
{
    Lanes sum = splat(0.0);
    double rest = 0.0;
    int64_t i = 0;
    for (; i + LANES <= size; i += LANES)
        sum = muladd(load(a + i), load(b + i), sum);
    for (; i < size; i++)
        rest += a[i] * b[i];
    return total(sum) + rest;
}

/* Add the product of a vector and a matrix that is stored row by row. */
static inline void add_rows(const double *factor, const double *matrix, int64_t rows, int64_t columns,
                            double *out)
{
    for (int64_t i = 0; i < rows; i++) {
        double f = factor[i];
        const double *row = matrix + i * columns;
        if (f != 0.0)
            for (int64_t j = 0; j < columns; j++)
                out[j] += f * row[j];
    }
}

static inline double larger(double a, double b) { return a > b ? a : b; }

static inline double smaller(double a, double b) { return a < b ? a : b; }

#endif
