/* A unit of FMI 3.0 around the exported C, PREFIX its names': what a model exchange calls. */
#include <stddef.h>
#include <stdlib.h>
typedef struct { double t, state[2 * N], torque[JOINTS]; } Unit;
void *fmi3InstantiateModelExchange(const char *name, const char *token) {
    return calloc(1, sizeof(Unit));
}
void fmi3FreeInstance(void *c) { free(c); }
const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3EnterInitializationMode(void *c) { return 0; }
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3EnterContinuousTimeMode(void *c) { return 0; }
int fmi3UpdateDiscreteStates(void *c, _Bool *a, _Bool *b, _Bool *d, _Bool *e, _Bool *f, double *t) {
    *a = *b = *d = *e = *f = 0, *t = 0;
    return 0;
}
int fmi3SetTime(void *c, double t) { ((Unit *)c)->t = t; return 0; }
int fmi3SetFloat64(void *c, const unsigned *r, size_t n, const double *x, size_t m) {
    for (size_t k = 0; k < n; k++) ((Unit *)c)->torque[r[k] - 4 * N] = x[k];
    return 0;
}
int fmi3SetContinuousStates(void *c, const double *x, size_t n) {
    memcpy(((Unit *)c)->state, x, 8 * n);
    return 0;
}
int fmi3GetContinuousStates(void *c, double *x, size_t n) {
    memcpy(x, ((Unit *)c)->state, 8 * n);
    return 0;
}
int fmi3GetContinuousStateDerivatives(void *c, double *x, size_t n) {
    Unit *u = c;
    memcpy(x, u->state + N, 8 * N);
    PREFIX_acceleration(u->t, u->state, u->state + N, u->torque, x + N);
    return 0;
}
