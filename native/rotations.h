#ifndef UMG_ROTATIONS_H
#define UMG_ROTATIONS_H

/* The proper rotation r (row-major 3x3) nearest to a: it maximises tr(r^T a), also where a is singular or reflects. */
void umg_nearest_rotation(const double *a, double *r);

#endif
