/* The geared arm without gravity, phase by angle or by current frequency times time, stiffness by
 * Eq. 8, exact dead zone: right-hand side and classical RK4, for `real` a number or a vector of them.
 *
 * Structure comes as macros, so that every loop has a constant length:
 *   JOINTS            geared joints
 *   BODIES            planet bodies of all joints (lumped: one for each joint)
 *   FIRST {..}        where a joint's planets begin, JOINTS + 1 numbers
 *   PHASES            different sines of all joints
 *   PHASE_FIRST {..}  where a joint's begin, JOINTS + 1 numbers
 *   SUN {..}, RING {..}  which of its sines the meshes of a planet take, BODIES numbers each
 *   PD or CONSTANT    drive; OMEGA_T where phases follow the speed
 *
 * Coordinates: absolute angles Theta of the links, x_s of the suns, x_pr of the planets. Every gear
 * has its own body, so gears leave the links' equations by elimination beforehand:
 *   S Theta'' = r,   x'' = f / (J a^2) - (row . Theta'') / a.
 */
#define N (2 * JOINTS + BODIES)
#define SUNS JOINTS
#define RINGS (2 * JOINTS)
#define UNROLL _Pragma("GCC unroll 32")
#define INLINE static inline __attribute__((always_inline))

static const int first[JOINTS + 1] = FIRST, phase_first[JOINTS + 1] = PHASE_FIRST;
static const int sun_phase[BODIES] = SUN, ring_phase[BODIES] = RING;

typedef struct {
    real rate[PHASES], offset[PHASES]; /* cycles per rad of joint angle; cycles, less a quarter */
    real k_m[2 * BODIES], k_a[2 * BODIES]; /* N/m of all planets that a body stands for; sun, ring */
    real E[2 * BODIES], e_0[2 * BODIES], b[2 * BODIES], d[2 * BODIES];
    real per_sun[JOINTS], per_planet[BODIES]; /* 1 / (J a^2) [1/kg] */
    real sun_row[2 * JOINTS], planet_row[2 * JOINTS]; /* row / a [m]: of the link before, of its own */
    real torque_sun[JOINTS], torque_before[JOINTS];   /* of an output torque on x_s, link before */
    real friction[JOINTS], target[JOINTS], p_gain[JOINTS], d_gain[JOINTS];
    real diagonal[JOINTS], m[JOINTS * JOINTS], first_pivot; /* of S; 1 / S_11 */
} arm;

/* cos(2 pi c): the sine of what c lacks of a quarter turn, by the odd minimax polynomial of degree
 * 17 (relative error 3e-19). */
INLINE real cosine(real c)
{
    real s = 0.25 - magnitude(c - nearest(c)), z = s * s, w = z * z, u = w * w;
    real low = (6.283185307179586 + z * -41.341702240399755)
               + w * (81.60524927607341 + z * -76.70585975279849);
    real high = (42.058693923785015 + z * -15.09464162050552)
                + w * (3.819927050429838 + z * -0.7177235798689506);
    return s * (low + u * (high + u * 0.10085633003758276));
}

/* y'' of y = (Theta, x_s, x_pr). */
INLINE void acceleration(const arm *restrict p, double t, const real *restrict y,
                         const real *restrict v, real *restrict a)
{
    real sin_of[PHASES], r[JOINTS], link_sun[JOINTS], link_planet[JOINTS];
    UNROLL for (int j = 0; j < JOINTS; j++) {
        real theta = j ? y[j] - y[j - 1] : y[j], omega = j ? v[j] - v[j - 1] : v[j];
        UNROLL for (int i = phase_first[j]; i < phase_first[j + 1]; i++)
#ifdef OMEGA_T
            sin_of[i] = cosine(p->rate[i] * (omega * t) + p->offset[i]);
#else
            sin_of[i] = cosine(p->rate[i] * theta + p->offset[i]);
#endif
#ifdef PD
        real torque = p->p_gain[j] * (p->target[j] - theta) - p->d_gain[j] * omega;
#else
        real torque = p->target[j];
#endif
        real x_s = y[SUNS + j], v_s = v[SUNS + j];
        real on_sun = torque * p->torque_sun[j], meshes = zero(), planets = zero();
        UNROLL for (int i = first[j]; i < first[j + 1]; i++) {
            real x = y[RINGS + i], v_p = v[RINGS + i], force[2];
            UNROLL for (int side = 0; side < 2; side++) {
                int mesh = 2 * i + side;
                real s = sin_of[side ? ring_phase[i] : sun_phase[i]];
                real gap = (side ? x : x_s - x) - (p->e_0[mesh] + p->E[mesh] * s), b = p->b[mesh];
                real beyond = gap - lesser(greater(gap, -b), b);
                force[side] = (p->k_m[mesh] + p->k_a[mesh] * s) * beyond
                              + p->d[mesh] * (side ? v_p : v_s - v_p);
            }
            real on_planet = force[0] - force[1];
            meshes += force[0];
            planets += on_planet;
            a[RINGS + i] = on_planet * p->per_planet[i];
        }
        a[SUNS + j] = (on_sun - meshes) * p->per_sun[j];
        real friction = p->friction[j] * omega;
        r[j] = meshes * p->sun_row[2 * j + 1] - planets * p->planet_row[2 * j + 1] - friction;
        if (j) {
            r[j - 1] += meshes * p->sun_row[2 * j] - planets * p->planet_row[2 * j]
                        + torque * p->torque_before[j] + friction;
        }
    }
    /* Links: differences of angles against the first alone, all others by products. */
    real c[JOINTS], s[JOINTS], square[JOINTS];
    c[0] = zero() + 1.0;
    s[0] = zero();
    square[0] = v[0] * v[0];
    UNROLL for (int k = 1; k < JOINTS; k++) {
        real cycles = (y[k] - y[0]) * 0.15915494309189535;
        s[k] = cosine(cycles - 0.25);
        c[k] = cosine(cycles);
        square[k] = v[k] * v[k];
    }
    real S[JOINTS][JOINTS], inverse[JOINTS];
    UNROLL for (int k = 0; k < JOINTS; k++) {
        S[k][k] = p->diagonal[k];
        UNROLL for (int l = 0; l < k; l++) {
            real m = p->m[k * JOINTS + l];
            real turned = l ? m * (s[k] * c[l] - c[k] * s[l]) : m * s[k];
            S[k][l] = l ? m * (c[k] * c[l] + s[k] * s[l]) : m * c[k];
            r[k] -= turned * square[l];
            r[l] += turned * square[k];
        }
    }
    UNROLL for (int k = 0; k < JOINTS; k++) {
        inverse[k] = k ? 1.0 / S[k][k] : p->first_pivot;
        UNROLL for (int i = k + 1; i < JOINTS; i++) {
            real factor = S[i][k] * inverse[k];
            UNROLL for (int j = k + 1; j <= i; j++)
                S[i][j] -= factor * S[j][k];
            r[i] -= factor * r[k];
        }
    }
    UNROLL for (int k = JOINTS - 1; k >= 0; k--) {
        UNROLL for (int i = k + 1; i < JOINTS; i++)
            r[k] -= S[i][k] * a[i];
        a[k] = r[k] * inverse[k];
    }
    UNROLL for (int j = 0; j < JOINTS; j++) {
        real before = j ? a[j - 1] : zero();
        a[SUNS + j] -= p->sun_row[2 * j] * before + p->sun_row[2 * j + 1] * a[j];
        real back = p->planet_row[2 * j] * before + p->planet_row[2 * j + 1] * a[j];
        UNROLL for (int i = first[j]; i < first[j + 1]; i++)
            a[RINGS + i] -= back;
    }
}

/* One step of classical RK4, in place. */
INLINE void runge_kutta(const arm *restrict p, double t, double h, real *restrict q,
                        real *restrict v)
{
    real at[N], speed[N], a[N], q_end[N], v_end[N];
    acceleration(p, t, q, v, a);
    UNROLL for (int i = 0; i < N; i++) {
        q_end[i] = v[i];
        v_end[i] = a[i];
        at[i] = q[i] + h / 2 * v[i];
        speed[i] = v[i] + h / 2 * a[i];
    }
    for (int stage = 1; stage < 4; stage++) { /* unrolled it is slower: too much code */
        acceleration(p, t + (stage < 3 ? h / 2 : h), at, speed, a);
        UNROLL for (int i = 0; i < N; i++) {
            q_end[i] += (stage < 3 ? 2.0 : 1.0) * speed[i];
            v_end[i] += (stage < 3 ? 2.0 : 1.0) * a[i];
            if (stage < 3) {
                double part = stage < 2 ? h / 2 : h;
                at[i] = q[i] + part * speed[i];
                speed[i] = v[i] + part * a[i];
            }
        }
    }
    UNROLL for (int i = 0; i < N; i++) {
        q[i] += h / 6 * q_end[i];
        v[i] += h / 6 * v_end[i];
    }
}
