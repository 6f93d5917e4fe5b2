/* The scalar reference: one trajectory. See arm.h for what is computed and by which macros. */
#include <math.h>
#include <string.h>

typedef double real;
#define zero() 0.0
#define nearest(x) rint(x)
#define magnitude(x) fabs(x)
#define lesser(x, y) ((x) < (y) ? (x) : (y))
#define greater(x, y) ((x) > (y) ? (x) : (y))
#include "arm.h"

/* Records (steps / stride + 1, 2, N) every `stride` steps from the state (2, N). */
void integrate(const arm *restrict p, const double *restrict start, double h, long steps,
               long stride, double *restrict records)
{
    double q[N], v[N];
    memcpy(q, start, sizeof q);
    memcpy(v, start + N, sizeof v);
    memcpy(records, start, 2 * N * sizeof(double));
    for (long record = 1; record <= steps / stride; record++) {
        for (long k = (record - 1) * stride; k < record * stride; k++)
            runge_kutta(p, k * h, h, q, v);
        memcpy(records + record * 2 * N, q, sizeof q);
        memcpy(records + record * 2 * N + N, v, sizeof v);
    }
}

int size(void) { return sizeof(arm) / sizeof(real); }
