/* The march for processors with AVX2; see `variants.h`. */
#include "variants.h"

#if VARIANTS
#define march march_avx2
#define WIDTH 4
#define HALF_WIDTH 4
TARGET("avx2")
#include "march.c"
TARGET_END
#else
typedef int nothing; /* ISO C forbids empty files */
#endif
