"""Nothing but a mass matrix: it is judged, and what is missing is said.

    crosscheck trial examples/mass_matrix_alone.py:model paper-labelled

Any number of links without gears, turned by absolute angles: M_ij = c_ij cos(phi_i - phi_j).
"""

import numpy as np

from crosscheck import Coordinates, Equations


def model(arm):
    constants = np.zeros((len(arm.links), len(arm.links)))
    lever = np.zeros(len(arm.links))  # how far each link carries a body that hangs on all before it
    for number, link in enumerate(arm.links):
        mass, inertia = mass_and_inertia(link)
        lever[number] = link.com_m
        constants += mass * np.outer(lever, lever)
        constants[number, number] += inertia
        lever[number] = link.length_m
    constants += arm.payload_mass_kg * np.outer(lever, lever)

    def mass_matrix(q):
        return constants * np.cos(q[:, None] - q)

    return Equations(
        mass_matrix=mass_matrix, coordinates=Coordinates(links="absolute"), level="links"
    )


def mass_and_inertia(link):
    if link.mass_kg is not None:
        return link.mass_kg, link.inertia_kg_m2
    mass = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m
    return mass, mass * link.length_m**2 / 12
