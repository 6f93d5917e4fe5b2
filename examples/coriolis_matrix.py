"""A matrix C(q, v) in place of the bias C v, and an arm's numbers out of its file.

    crosscheck trial examples/coriolis_matrix.py:model paper-labelled

The function is called with an arm, so the trial may ask for the same model of other arms, too.
"""

import numpy as np

from crosscheck import Equations


def model(arm):
    first, second = arm.links
    mass_2 = second.cross_section_m2 * second.density_kg_per_m3 * second.length_m
    moment = mass_2 * second.com_m + arm.payload_mass_kg * second.length_m
    coupling = moment * first.length_m

    def coriolis(q, v):
        s = coupling * np.sin(q[1])
        return np.array([[-s * v[1], -s * (v[0] + v[1])], [s * v[0], 0.0]])

    return Equations(coriolis=coriolis, level="links")
