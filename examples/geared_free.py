"""Planetary gears, every planet by itself, in the angles that an encoder would see.

    crosscheck trial examples/geared_free.py:model paper-labelled

x: of each joint the angles of its sun and of each planet, relative to the ring; then the links'
absolute angles. So sun and planets turn at the rate of the link before plus or minus their own.
Any number of geared joints, rods or bodies, under gravity; sine stiffness alone.
"""

import math

import numpy as np

from crosscheck import Coordinates, Equations


def model(arm):
    gears, n = [], 0
    for joint in arm.joints:
        gears.append(Gear(joint, n))
        n += 1 + joint.planet_count
    links = np.arange(n, n + len(arm.links))
    n += len(arm.links)
    constants, moments = link_numbers(arm, gears)
    fixed = sum(gear.inertia(stage, links, n) for stage, gear in enumerate(gears))
    g_x, g_y = arm.gravity_m_per_s2

    def mass_matrix(x):
        phi = x[links]
        found = fixed.copy()
        found[np.ix_(links, links)] += constants * np.cos(phi[:, None] - phi)
        return found

    def bias(x, v):
        phi, found = x[links], np.zeros(n)
        found[links] = (constants * np.sin(phi[:, None] - phi)) @ v[links] ** 2
        return found

    def force(t, x, v, torque):
        phi, found = x[links], np.zeros(n)
        found[links] = moments * (g_y * np.cos(phi) - g_x * np.sin(phi))
        for stage, gear in enumerate(gears):
            found += gear.force(stage, links, x, v, torque[stage])
        return found

    return Equations(
        mass_matrix=mass_matrix,
        bias=bias,
        force=force,
        coordinates=Coordinates(gearing="free", links="absolute", gears="angles"),
    )


class Gear:
    """A planetary stage: its sun's angle has place ``sun``, the planets' follow."""

    def __init__(self, joint, sun):
        cosine = math.cos(math.radians(joint.pressure_angle_deg))
        self.joint, self.sun, self.N = joint, sun, joint.planet_count
        self.planets = range(sun + 1, sun + 1 + self.N)
        self.r_s = joint.module_m * joint.sun_teeth / 2 * cosine
        self.r_p = joint.module_m * joint.planet_teeth / 2 * cosine
        self.r_c = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
        self.r_cp = self.r_c * cosine
        self.J_s = inertia(joint, "sun", self.r_s)
        self.J_p = inertia(joint, "planet", self.r_p)
        self.J_c = inertia(joint, "carrier", self.r_cp)
        self.mass = joint.sun_mass_kg + joint.carrier_mass_kg + joint.ring_mass_kg
        self.mass += self.N * joint.planet_mass_kg

    def inertia(self, stage, links, n):
        """Of everything that turns."""
        unit = np.eye(n)
        before = unit[links[stage - 1]] if stage else np.zeros(n)
        orbit = self.J_c + self.N * self.joint.planet_mass_kg * self.r_c**2
        found = self.J_s * square(before + unit[self.sun]) + orbit * square(unit[links[stage]])
        found += self.joint.ring_inertia_kg_m2 * square(before)
        return found + sum(self.J_p * square(before - unit[planet]) for planet in self.planets)

    def force(self, stage, links, x, v, torque):
        """The motor on the sun, friction on the link, and two meshes of every planet."""
        unit, n = np.eye(len(x)), 1 + self.joint.ring_teeth / self.joint.sun_teeth
        theta = unit[links[stage]] - (unit[links[stage - 1]] if stage else 0)
        found = torque / n * unit[self.sun]
        found -= self.joint.friction_N_m_s_per_rad * (theta @ v) * theta
        phase = self.joint.ring_teeth * (theta @ x)  # of both meshes
        for number, planet in enumerate(self.planets):
            x_pr = self.r_p * unit[planet] - self.r_cp * theta
            x_sp = self.r_s * unit[self.sun] - self.r_p * unit[planet] - self.r_cp * theta
            masses = inertia(self.joint, "sun", self.r_s) / self.r_s**2, self.J_p / self.r_p**2
            for row, mesh, mass in (
                (x_sp, self.joint.sun_mesh.planet_mesh(number), masses[0]),
                (x_pr, self.joint.ring_mesh.planet_mesh(number), self.N * masses[1]),
            ):
                found -= (mesh_force(mesh, phase, row @ x) + self.damper(mesh, mass, row @ v)) * row
        return found

    def damper(self, mesh, mass, rate):
        """An N-th of what damps all planets together."""
        d = mesh.damping_N_s_per_m
        if d is None:
            k = self.N * mesh.stiffness.mean_N_per_m
            d = 2 * mesh.damping_ratio * math.sqrt(k * mass)
        return d / self.N * rate


def mesh_force(mesh, phase, x):
    """Eqs. 4, 5, 8 and 14."""
    phase += mesh.phase_rad
    error = mesh.tooth_error_m * math.sin(phase + mesh.tooth_error_phase_rad)
    gap = x - mesh.static_error_m - error
    pressed = gap - min(max(gap, -mesh.backlash_m), mesh.backlash_m)
    k = mesh.stiffness.mean_N_per_m + mesh.stiffness.amplitude_N_per_m * math.sin(phase)
    return k * pressed


def link_numbers(arm, gears):
    """c_ij of M_ij = c_ij cos(phi_i - phi_j), and first moments: of links and what they carry."""
    count = len(arm.links)
    constants, moments, lever = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    for number, link in enumerate(arm.links):
        mass, J = mass_and_inertia(link)
        constants += gears[number].mass * square(lever)
        moments += gears[number].mass * lever
        lever[number] = link.com_m
        constants += mass * square(lever)
        constants[number, number] += J
        moments += mass * lever
        lever[number] = link.length_m
    return constants + arm.payload_mass_kg * square(lever), moments + arm.payload_mass_kg * lever


def inertia(joint, part, radius):
    """J [kg m^2], given as it is or as J / r^2."""
    given = getattr(joint, f"{part}_inertia_kg_m2")
    return getattr(joint, f"{part}_equivalent_mass_kg") * radius**2 if given is None else given


def square(row):
    return np.outer(row, row)


def mass_and_inertia(link):
    if link.mass_kg is not None:
        return link.mass_kg, link.inertia_kg_m2
    mass = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m
    return mass, mass * link.length_m**2 / 12
