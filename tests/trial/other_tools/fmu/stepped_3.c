/* The same, for Co-Simulation. */
int fmi3EnterStepMode(void *c) { return 0; }
void *fmi3InstantiateCoSimulation(const char *name, const char *token) {
    return calloc(1, sizeof(Unit));
}
int fmi3GetFloat64(void *c, const unsigned *r, size_t n, double *x, size_t m) {
    for (size_t k = 0; k < n; k++) x[k] = ((Unit *)c)->state[r[k]];
    return 0;
}
/* A hundred midpoint steps. */
int fmi3DoStep(void *c, double t, double h, _Bool keep, _Bool *event, _Bool *stop, _Bool *early,
               double *last) {
    Unit *u = c;
    double part = h / 100, a[N], *q = u->state, *v = u->state + N, middle[2 * N];
    for (int step = 0; step < 100; step++) {
        PREFIX_acceleration(t, q, v, u->torque, a);
        for (int k = 0; k < N; k++) {
            middle[k] = q[k] + part / 2 * v[k];
            middle[N + k] = v[k] + part / 2 * a[k];
        }
        PREFIX_acceleration(t, middle, middle + N, u->torque, a);
        for (int k = 0; k < N; k++) q[k] += part * middle[N + k], v[k] += part * a[k];
    }
    *event = *stop = *early = 0, *last = t + h;
    return 0;
}
