"""Two links in closed form, with payload, weight and friction."""

from math import cos, sin

from crosscheck import Equations


def planar_arm(arm):
    """M, bias and force by the angles relative to the previous link."""
    upper, fore = arm.links
    load = arm.payload_mass_kg
    L = upper.length_m
    # Moments about the elbow, second and first.
    J = fore.inertia + fore.mass * fore.com_m**2 + load * fore.length_m**2
    S = fore.mass * fore.com_m + load * fore.length_m
    beyond = fore.mass + load

    def mass_matrix(q):
        coupling = S * L * cos(q[1])
        M = [[0.0, 0.0], [0.0, 0.0]]
        M[0][0] = upper.inertia + upper.mass * upper.com_m**2 + beyond * L**2 + J + 2 * coupling
        M[0][1] = J + coupling
        M[1][0] = J + coupling
        M[1][1] = J
        return M

    def bias(q, qd):
        k = S * L * sin(q[1])
        return [-2 * k * qd[0] * qd[1] - k * qd[1] ** 2, k * qd[0] ** 2]

    def force(q, qd, tau):
        gx, gy = arm.gravity_m_per_s2
        shoulder = upper.mass * upper.com_m + beyond * L
        lift_1 = shoulder * (gy * cos(q[0]) - gx * sin(q[0]))
        lift_2 = S * (gy * cos(q[0] + q[1]) - gx * sin(q[0] + q[1]))
        d1 = arm.joints[0].friction_N_m_s_per_rad
        d2 = arm.joints[1].friction_N_m_s_per_rad
        return [tau[0] + lift_1 + lift_2 - d1 * qd[0], tau[1] + lift_2 - d2 * qd[1]]

    return Equations(mass_matrix=mass_matrix, bias=bias, force=force)
