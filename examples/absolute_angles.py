"""Absolute angles, weight and friction: any number of links without gears.

crosscheck trial examples/absolute_angles.py:model three-unlike
"""

import numpy as np

from crosscheck import Coordinates, Equations


def model(arm):
    count = len(arm.links)
    constants, moments, lever = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    for number, link in enumerate(arm.links):
        mass, inertia = mass_and_inertia(link)
        lever[number] = link.com_m
        constants += mass * np.outer(lever, lever)
        constants[number, number] += inertia
        moments += mass * lever
        lever[number] = link.length_m
    constants += arm.payload_mass_kg * np.outer(lever, lever)
    moments += arm.payload_mass_kg * lever
    friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
    g_x, g_y = arm.gravity_m_per_s2

    def mass_matrix(q):
        return constants * np.cos(q[:, None] - q)

    def bias(q, v):
        return (constants * np.sin(q[:, None] - q)) @ v**2

    def force(t, q, v, torque):
        on_joints = torque - friction * np.diff(v, prepend=0.0)
        on_links = on_joints - np.append(
            on_joints[1:], 0.0
        )  # a joint pushes back on the link before
        return on_links + moments * (g_y * np.cos(q) - g_x * np.sin(q))

    return Equations(
        mass_matrix=mass_matrix,
        bias=bias,
        force=force,
        coordinates=Coordinates(links="absolute"),
        level="links",
    )


def mass_and_inertia(link):
    if link.mass_kg is not None:
        return link.mass_kg, link.inertia_kg_m2
    mass = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m
    return mass, mass * link.length_m**2 / 12
