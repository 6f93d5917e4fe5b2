"""CasADi Functions: M and bias by automatic differentiation of the energy.

    crosscheck trial examples/casadi_two_link.py:model paper-labelled

Inputs of the Functions are distinguished by their names.
"""

import casadi as ca

from crosscheck import Equations


def model(arm):
    q, v, torque, t = ca.SX.sym("q", 2), ca.SX.sym("v", 2), ca.SX.sym("torque", 2), ca.SX.sym("t")
    energy = kinetic_energy(arm, q, v)
    momentum = ca.gradient(energy, v)
    bias = ca.jtimes(momentum, q, v) - ca.gradient(energy, q)
    return Equations(
        mass_matrix=ca.Function("mass_matrix", [q], [ca.hessian(energy, v)[0]], ["q"], ["M"]),
        bias=ca.Function("bias", [q, v], [bias], ["q", "v"], ["h"]),
        force=ca.Function("force", [t, q, v, torque], [torque], ["t", "q", "v", "torque"], ["f"]),
        level="links",
    )


def kinetic_energy(arm, q, v):
    energy, joint = 0, ca.SX.zeros(2)
    for number, link in enumerate(arm.links):
        mass = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m
        inertia = mass * link.length_m**2 / 12
        angle = ca.sum1(q[: number + 1])
        along = ca.vertcat(ca.cos(angle), ca.sin(angle))
        velocity = ca.jtimes(joint + link.com_m * along, q, v)
        rate = ca.sum1(v[: number + 1])
        energy += (mass * ca.sumsqr(velocity) + inertia * rate**2) / 2
        joint = joint + link.length_m * along
    return energy + arm.payload_mass_kg * ca.sumsqr(ca.jtimes(joint, q, v)) / 2
