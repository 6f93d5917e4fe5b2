/* The SIMD reference: trajectories side by side, each with its own numbers, eight doubles to a vector
 * by GCC's vector extensions, VECTORS of them in turn so that one fills the other's waiting times.
 * See arm.h for what is computed and by which macros. */
#include <immintrin.h>
#include <string.h>

#define LANES 8
#ifndef VECTORS
#define VECTORS 1
#endif
typedef double real __attribute__((vector_size(8 * LANES)));
typedef long bits __attribute__((vector_size(8 * LANES)));
#define INLINED static inline __attribute__((always_inline))
#define SIGN ((bits){} + (long)0x8000000000000000L)

INLINED real zero(void) { return (real){}; }
INLINED real magnitude(real x) { return (real)((bits)x & ~SIGN); }
#ifdef __AVX512F__
INLINED real nearest(real x) { return (real)_mm512_roundscale_pd((__m512d)x, 0); }
INLINED real lesser(real x, real y) { return (real)_mm512_min_pd((__m512d)x, (__m512d)y); }
INLINED real greater(real x, real y) { return (real)_mm512_max_pd((__m512d)x, (__m512d)y); }
#else
/* Adding 1.5 * 2^52 leaves no digits behind the point: rounds to the nearest, as rint does. */
INLINED real nearest(real x) { return (x + 6755399441055744.0) - 6755399441055744.0; }
INLINED real chosen(bits of, real x, real y) { return (real)(((bits)x & of) | ((bits)y & ~of)); }
INLINED real lesser(real x, real y) { return chosen(x < y, x, y); }
INLINED real greater(real x, real y) { return chosen(x > y, x, y); }
#endif
#include "arm.h"

/* Of every vector, records (steps / stride + 1, 2, N, LANES) every `stride` steps from its state
 * (2, N, LANES). */
void integrate(const arm *restrict p, const real *restrict start, double h, long steps, long stride,
               real *restrict records)
{
    real q[VECTORS][N], v[VECTORS][N];
    long count = steps / stride + 1;
    for (int i = 0; i < VECTORS; i++) {
        memcpy(q[i], start + 2 * i * N, sizeof q[i]);
        memcpy(v[i], start + 2 * i * N + N, sizeof v[i]);
    }
    for (long record = 0; record < count; record++) {
        for (long k = record ? (record - 1) * stride : 0; k < record * stride; k++)
            UNROLL for (int i = 0; i < VECTORS; i++)
                runge_kutta(p + i, k * h, h, q[i], v[i]);
        for (int i = 0; i < VECTORS; i++) {
            memcpy(records + (i * count + record) * 2 * N, q[i], sizeof q[i]);
            memcpy(records + (i * count + record) * 2 * N + N, v[i], sizeof v[i]);
        }
    }
}

int size(void) { return sizeof(arm) / sizeof(real); }
