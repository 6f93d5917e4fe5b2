"""Two planetary gears, all planets of a stage together: the paper's coordinates and laws.

    crosscheck trial examples/geared_lumped.py:model paper-labelled

x = (x_sp1, x_pr1, theta_1, x_sp2, x_pr2, theta_2) of Eq. 20. M is a sum over bodies of inertia
times row times row, where a row says how fast the body moves at given rates; unlike in Eq. 18, the
elbow's planets turn with link 1. Sine stiffness (Eq. 8), backlash (Eq. 5), tooth error (Eq. 14).
"""

import math

import numpy as np

from crosscheck import Coordinates, Equations

X_SP, X_PR, THETA = (0, 3), (1, 4), (2, 5)
UNIT = np.eye(6)
PHI = (UNIT[2], UNIT[2] + UNIT[5])  # rates of the links


def model(arm):
    gears = [Gear(joint) for joint in arm.joints]
    first, second = arm.links
    (m_1, I_1), (m_2, I_2) = map(mass_and_inertia, arm.links)
    reach, payload = first.length_m, arm.payload_mass_kg
    coupling = reach * (m_2 * second.com_m + payload * second.length_m)
    hanging = m_2 + payload + gears[1].mass

    rigid = (I_1 + m_1 * first.com_m**2 + hanging * reach**2) * square(PHI[0])
    rigid += (I_2 + m_2 * second.com_m**2 + payload * second.length_m**2) * square(PHI[1])
    for stage, gear in enumerate(gears):
        rigid += gear.inertia(stage)
    both = np.outer(*PHI) + np.outer(*PHI).T

    def mass_matrix(x):
        return rigid + coupling * math.cos(x[5]) * both

    def bias(x, v):
        rate_1, rate_2 = PHI[0] @ v, PHI[1] @ v
        return coupling * math.sin(x[5]) * (rate_1**2 * PHI[1] - rate_2**2 * PHI[0])

    def force(t, x, v, torque):
        pairs = zip(gears, torque, strict=True)
        return sum(gear.force(stage, x, v, T) for stage, (gear, T) in enumerate(pairs))

    return Equations(
        mass_matrix=mass_matrix,
        bias=bias,
        force=force,
        coordinates=Coordinates(gearing="lumped"),
    )


class Gear:
    """A planetary stage, its numbers as in Section 2."""

    def __init__(self, joint):
        cosine = math.cos(math.radians(joint.pressure_angle_deg))
        self.joint, self.N = joint, joint.planet_count
        self.r_s = joint.module_m * joint.sun_teeth / 2 * cosine
        self.r_p = joint.module_m * joint.planet_teeth / 2 * cosine
        self.r_c = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
        self.r_cp = self.r_c * cosine
        self.n = 1 + joint.ring_teeth / joint.sun_teeth
        self.M_s, self.M_p = joint.sun_equivalent_mass_kg, joint.planet_equivalent_mass_kg
        self.mass = joint.sun_mass_kg + joint.carrier_mass_kg + joint.ring_mass_kg
        self.mass += self.N * joint.planet_mass_kg

    def inertia(self, stage):
        """Of everything that turns: sun, planets, their orbit, carrier and ring."""
        before = PHI[0] if stage else 0 * PHI[0]
        x_sp, x_pr, theta = UNIT[X_SP[stage]], UNIT[X_PR[stage]], UNIT[THETA[stage]]
        sun = x_sp + x_pr + 2 * self.r_cp * theta + self.r_s * before
        planet = x_pr + self.r_cp * theta - self.r_p * before
        orbit = self.joint.carrier_equivalent_mass_kg * self.r_cp**2
        orbit += self.N * self.joint.planet_mass_kg * self.r_c**2
        return (
            self.M_s * square(sun)
            + self.N * self.M_p * square(planet)
            + orbit * square(PHI[stage])
            + self.joint.ring_inertia_kg_m2 * square(before)
        )

    def force(self, stage, x, v, torque):
        """Meshes, their dampers, and the drive, T / n on the sun."""
        total, (sp, pr, theta) = np.zeros(6), (X_SP[stage], X_PR[stage], THETA[stage])
        total[[sp, pr, theta]] = torque / self.n * np.array([1, 1, 2 * self.r_cp]) / self.r_s
        total[theta] -= self.joint.friction_N_m_s_per_rad * v[theta]
        meshes = (sp, self.joint.sun_mesh, self.M_s), (pr, self.joint.ring_mesh, self.N * self.M_p)
        for place, mesh, mass in meshes:
            sine = math.sin(self.joint.ring_teeth * x[theta] + mesh.phase_rad)
            gap = x[place] - mesh.tooth_error_m * sine
            pressed = gap - min(max(gap, -mesh.backlash_m), mesh.backlash_m)
            k = mesh.stiffness.mean_N_per_m + mesh.stiffness.amplitude_N_per_m * sine
            d = damping(mesh, self.N, mass)
            total[place] -= self.N * k * pressed + d * v[place]
        return total


def damping(mesh, count, mass):
    if mesh.damping_N_s_per_m is not None:
        return mesh.damping_N_s_per_m
    return 2 * mesh.damping_ratio * math.sqrt(count * mesh.stiffness.mean_N_per_m * mass)


def square(row):
    return np.outer(row, row)


def mass_and_inertia(link):
    mass = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m
    return mass, mass * link.length_m**2 / 12
