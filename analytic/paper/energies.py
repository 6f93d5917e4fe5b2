"""The `energies` form: Eqs. 16-19 as the paper writes them, through Lagrange's equations alone.

The paper treats two joints with three planets each; the literal 3 and the indices are its own.
"""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from crosscheck.analytic.derivation.forms import Form, christoffel_bias, virtual_work
from crosscheck.analytic.derivation.symbols import geared_variables, m_payload, stage_symbols
from crosscheck.analytic.paper.kinematics import gear_angles

JOINTS = 2
STAGE_1, STAGE_2 = stage_symbols(1), stage_symbols(2)


def gear_rates(joint: int) -> tuple[sp.Expr, sp.Expr]:
    """(theta_s', theta_p') of a joint, relative to the ring's body: Eqs. 2-3 solved for them."""
    stage = stage_symbols(joint)
    dx_sp, dx_pr, dtheta = geared_variables(JOINTS).v[3 * joint - 3 : 3 * joint]
    return gear_angles(dx_sp, dx_pr, dtheta, stage.r_s, stage.r_p, stage.r_cp)


def kinetic_energies() -> dict[str, sp.Expr]:
    """T_j1, T_L1, T_j2, T_L2 by equation, over the rates of the paper's coordinates."""
    return {
        "Eq. 16": shoulder_joint(),
        "Eq. 17": first_link(),
        "Eq. 18": elbow_joint(),
        "Eq. 19": second_link_and_payload(),
    }


def shoulder_joint() -> sp.Expr:
    """Kinetic energy T_j1 of the shoulder joint, Eq. 16."""
    s = STAGE_1
    dtheta_1 = geared_variables(JOINTS).v[2]
    dtheta_s, dtheta_p = gear_rates(1)
    I_s, I_p, I_c = s.M_s * s.r_s**2, s.M_p * s.r_p**2, s.M_c * s.r_cp**2
    return (
        I_s * dtheta_s**2 / 2
        + 3 * I_p * dtheta_p**2 / 2
        + (I_c + 3 * s.m_p * s.r_c**2) * dtheta_1**2 / 2
    )


def joint_mass() -> sp.Expr:
    """m_j below Eq. 21; its 3 m_p is the planets' mass, although m_p is the payload elsewhere."""
    s = STAGE_2
    return s.m_s + 3 * s.m_p + s.m_c + s.m_r


def first_link() -> sp.Expr:
    """Kinetic energy T_L1 of the first link, Eq. 17."""
    s = STAGE_1
    dtheta_1 = geared_variables(JOINTS).v[2]
    return (s.I_l + s.m * s.d**2) * dtheta_1**2 / 2 + joint_mass() * s.L**2 * dtheta_1**2 / 2


def elbow_joint() -> sp.Expr:
    """Kinetic energy T_j2 of the elbow joint, Eq. 18."""
    s = STAGE_2
    dtheta_1, dtheta_2 = geared_variables(JOINTS).v[2::3]
    dtheta_s, dtheta_p = gear_rates(2)
    I_s, I_p, I_c = s.M_s * s.r_s**2, s.M_p * s.r_p**2, s.M_c * s.r_cp**2
    return (
        I_s * (dtheta_1 + dtheta_s) ** 2 / 2
        + 3 * I_p * dtheta_p**2 / 2
        + (I_c + 3 * s.m_p * s.r_c**2) * (dtheta_1 + dtheta_2) ** 2 / 2
    )


def second_link_and_payload() -> sp.Expr:
    """Kinetic energy T_L2 of the second link and the payload, Eq. 19."""
    s = STAGE_2
    theta_2 = geared_variables(JOINTS).q[5]
    dtheta_1, dtheta_2 = geared_variables(JOINTS).v[2::3]

    def point_energy(distance: sp.Expr, mass: sp.Expr) -> sp.Expr:
        along = STAGE_1.L * dtheta_1 * sp.cos(theta_2) + (dtheta_1 + dtheta_2) * distance
        return mass * (along**2 + (STAGE_1.L * dtheta_1 * sp.sin(theta_2)) ** 2) / 2

    return (
        s.I_l * (dtheta_1 + dtheta_2) ** 2 / 2
        + point_energy(s.d, s.m)
        + point_energy(s.L, m_payload)
    )


@lru_cache
def build_energies_form() -> Form:
    """Equations of motion from Eqs. 16-19; generalized force by the virtual work of Section 2.4."""
    variables = geared_variables(JOINTS)
    q, v = variables.q, variables.v
    kinetic = sp.Add(*kinetic_energies().values())
    mass = sp.hessian(kinetic, v).applyfunc(remove_sine_squares)
    mass = sp.ImmutableMatrix(mass)
    return Form("energies", q, v, mass, christoffel_bias(mass, q, v), generalized_force())


def generalized_force() -> sp.ImmutableMatrix:
    """Virtual work of three planets' mesh forces, and of T_i / n on each sun (Section 3)."""
    variables = geared_variables(JOINTS)
    efforts = []
    for joint in (1, 2):
        stage = stage_symbols(joint)
        x_sp, x_pr, theta = variables.q[3 * joint - 3 : 3 * joint]
        F_sp, F_pr = variables.mesh_forces[2 * joint - 2 : 2 * joint]
        theta_s, _ = gear_angles(x_sp, x_pr, theta, stage.r_s, stage.r_p, stage.r_cp)
        efforts += [(-3 * F_sp, x_sp), (-3 * F_pr, x_pr)]
        efforts.append((variables.torques[joint - 1] / stage.n, theta_s))
    return virtual_work(efforts, variables.q)


def remove_sine_squares(entry: sp.Expr) -> sp.Expr:
    """An entry expanded, with sin^2 theta_2 as 1 - cos^2 theta_2: the one identity needed."""
    theta_2 = geared_variables(JOINTS).q[5]
    return sp.expand(sp.expand(entry).subs(sp.sin(theta_2) ** 2, 1 - sp.cos(theta_2) ** 2))
