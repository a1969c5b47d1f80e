/* Builds of the marches for the instruction sets of x86-64, of which a run takes the widest that its
 * processor has; all give the same bits (`lanes.h`). Only a portable build (BLADEWHIRL_PORTABLE=1)
 * has them: any other is made for the machine that it is built on.
 */
#ifndef VARIANTS_H
#define VARIANTS_H

#include <math.h>
#include <stdint.h>

#if defined(PORTABLE) && defined(__x86_64__)
#define VARIANTS 1
#else
#define VARIANTS 0
#endif

/* Compile what follows for an instruction set; clang wants an end, too. */
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
