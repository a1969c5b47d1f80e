/* Variants of the march for the instruction sets of x86-64. At run time, the variant with the
 * widest registers of the processor is used; all variants give identical results (`lanes.h`). Only
 * a portable build (BLADEWHIRL_PORTABLE=1) has variants; any other build is for the machine that
 * compiles it. */
#ifndef VARIANTS_H
#define VARIANTS_H

#include <math.h>
#include <stdint.h>

#if defined(PORTABLE) && defined(__x86_64__)
#define VARIANTS 1
#else
#define VARIANTS 0
#endif

/* Compile the following code for an instruction set; clang needs TARGET_END as well. */
#if defined(__clang__)
#define PRAGMA(text) _Pragma(#text)
#define TARGET(name)                                                                               \
    PRAGMA(clang attribute push(__attribute__((target(name))), apply_to = function))
#define TARGET_END _Pragma("clang attribute pop")
#else
#define PRAGMA(text) _Pragma(#text)
#define TARGET(name) PRAGMA(GCC target(name))
#define TARGET_END
#endif

#endif
