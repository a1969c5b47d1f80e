/* The march for processors with AVX512F; see `variants.h`. */
#include "variants.h"

#if VARIANTS
#define march march_avx512
#define WIDTH 8
#define HALF_WIDTH 4
TARGET("avx512f")
#include "march.c"
TARGET_END
#else
typedef int nothing; /* ISO C forbids empty files */
#endif
