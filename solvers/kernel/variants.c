/* The march for the instruction set of all processors, and the choice between instruction sets. */
#include "variants.h"

#if VARIANTS
#define march march_baseline
#endif

#include "march.c"

#if VARIANTS
#undef march

#define PARAMETERS                                                                                 \
    const Stage *stage, State *state, Records *records, Vector scratch, int64_t step,              \
        int64_t steps, int64_t record_every, int64_t *reached
#define ARGUMENTS stage, state, records, scratch, step, steps, record_every, reached

int march_avx2(PARAMETERS);
int march_avx512(PARAMETERS);

/* Call the march for this processor. */
int march(PARAMETERS)
{
    if (__builtin_cpu_supports("avx512f"))
        return march_avx512(ARGUMENTS);
    if (__builtin_cpu_supports("avx2"))
        return march_avx2(ARGUMENTS);
    return march_baseline(ARGUMENTS);
}
#endif

int64_t scratch_size(const Stage *stage, const State *state)
{
    Scratch scratch;
    Arena arena = {.at = NULL};
    lay_scratch(&arena, stage, state, &scratch);
    return arena.used;
}
