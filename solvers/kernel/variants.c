/* The marches for the instruction set of all processors, and the choice between instruction
 * sets. */
#include "variants.h"

#if VARIANTS
#define march march_baseline
#define dense_march dense_march_baseline
#endif

#include "march.c"

#include "dense.c"

#if VARIANTS
#undef march
#undef dense_march

/* Declare a march for two more instruction sets, and define the function that calls the march for
 * this processor. */
#define CHOOSE(type, name, parameters, arguments)                                                  \
    type name##_avx2 parameters;                                                                   \
    type name##_avx512 parameters;                                                                 \
    type name parameters                                                                           \
    {                                                                                              \
        if (__builtin_cpu_supports("avx512f"))                                                     \
            return name##_avx512 arguments;                                                        \
        if (__builtin_cpu_supports("avx2"))                                                        \
            return name##_avx2 arguments;                                                          \
        return name##_baseline arguments;                                                          \
    }

CHOOSE(int, march,
       (const Stage *stage, State *state, Records *records, Scratch *scratch, int64_t step,
        int64_t steps, int64_t record_every, int64_t *reached),
       (stage, state, records, scratch, step, steps, record_every, reached))
CHOOSE(int64_t, dense_march,
       (const DenseStage *stage, const Closure *closure, const DenseLaw *law, DenseState *state,
        DenseScratch *scratch, double h, int64_t first, int64_t steps),
       (stage, closure, law, state, scratch, h, first, steps))
#endif
