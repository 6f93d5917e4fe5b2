/* A unit of FMI 2.0 for Co-Simulation around the exported C. */
#include <stddef.h>
#include <stdlib.h>
typedef struct { double state[2 * N], torque[JOINTS]; } Unit;
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const void *calls, int visible, int logging) {
    return type == 1 ? calloc(1, sizeof(Unit)) : NULL;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int d, double tol, double start, int e, double stop) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *x) {
    Unit *u = c;
    for (size_t k = 0; k < n; k++)
        *(r[k] < 2 * N ? &u->state[r[k]] : &u->torque[r[k] - 4 * N]) = x[k];
    return 0;
}
int fmi2GetReal(void *c, const unsigned *r, size_t n, double *x) {
    for (size_t k = 0; k < n; k++) x[k] = ((Unit *)c)->state[r[k]];
    return 0;
}
/* Five hundred midpoint steps. */
int fmi2DoStep(void *c, double t, double h, int keep) {
    Unit *u = c;
    double part = h / 500, a[N], *q = u->state, *v = u->state + N, middle[2 * N];
    for (int step = 0; step < 500; step++) {
        PREFIX_acceleration(t + step * part, q, v, u->torque, a);
        for (int k = 0; k < N; k++) {
            middle[k] = q[k] + part / 2 * v[k];
            middle[N + k] = v[k] + part / 2 * a[k];
        }
        PREFIX_acceleration(t + (step + 0.5) * part, middle, middle + N, u->torque, a);
        for (int k = 0; k < N; k++) q[k] += part * middle[N + k], v[k] += part * a[k];
    }
    return 0;
}
