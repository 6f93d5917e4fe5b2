"""Nothing but inverse dynamics M a + bias, by Newton and Euler's recursion, any number of links.

crosscheck trial examples/inverse_dynamics_alone.py:model three-unlike
"""

import numpy as np

from crosscheck import Equations


def model(arm):
    def inverse_dynamics(q, v, a):
        angle, rate, rate_dot = np.cumsum(q), np.cumsum(v), np.cumsum(a)
        along = np.exp(1j * angle)  # the plane as complex numbers
        per_metre = (1j * rate_dot - rate**2) * along  # acceleration along a link
        at_joint = np.cumsum([0, *(per_metre * [link.length_m for link in arm.links])])
        torques = np.zeros(len(q))
        pull = arm.payload_mass_kg * at_joint[-1]  # what the link has to give to what follows it
        turning = 0.0
        for number in reversed(range(len(q))):
            link = arm.links[number]
            mass, inertia = mass_and_inertia(link)
            own = mass * (at_joint[number] + link.com_m * per_metre[number])
            turning += inertia * rate_dot[number]
            turning += cross(link.com_m * along[number], own)
            turning += cross(link.length_m * along[number], pull)
            pull += own
            torques[number] = turning
        return torques

    return Equations(inverse_dynamics=inverse_dynamics, level="links")


def cross(lever, force):
    return (lever.conjugate() * force).imag


def mass_and_inertia(link):
    if link.mass_kg is not None:
        return link.mass_kg, link.inertia_kg_m2
    mass = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m
    return mass, mass * link.length_m**2 / 12
