"""Nothing but the acceleration, solved by hand: two links and a payload.

crosscheck trial examples/acceleration_alone.py:model paper-labelled
"""

import math

from crosscheck import Equations


def model(arm):
    first, second = arm.links
    m1, m2 = (link.cross_section_m2 * link.density_kg_per_m3 * link.length_m for link in arm.links)
    payload, L1, L2 = arm.payload_mass_kg, first.length_m, second.length_m
    a = m1 * (L1**2 / 12 + first.com_m**2) + (m2 + payload) * L1**2
    b = m2 * (L2**2 / 12 + second.com_m**2) + payload * L2**2
    c = (m2 * second.com_m + payload * L2) * L1

    def acceleration(t, q, v, torque):
        """In absolute angles first: there the equations are short."""
        cosine, sine = c * math.cos(q[1]), c * math.sin(q[1])
        on_1 = torque[0] - torque[1] + sine * (v[0] + v[1]) ** 2
        on_2 = torque[1] - sine * v[0] ** 2
        determinant = a * b - cosine**2
        phi_1 = (b * on_1 - cosine * on_2) / determinant
        phi_2 = (a * on_2 - cosine * on_1) / determinant
        return phi_1, phi_2 - phi_1

    return Equations(acceleration=acceleration, level="links")
