/* Support of the centre that fuses: a march ends when the force in the springs at the centre passes
 * a limit, and goes on with other arrays. */
#ifndef FUSE_H
#define FUSE_H

#include "turning.h"

/* Return whether the force in the springs at the centre is above its limit. */
static int fuses(const Fuse *fuse, const double *x)
{
    double square = 0.0;
    for (int k = 0; k < 2; k++) {
        double force = fuse->constant.at[k] + product(&fuse->force, k, x);
        square += force * force;
    }
    return square > fuse->limit * fuse->limit;
}

#endif
