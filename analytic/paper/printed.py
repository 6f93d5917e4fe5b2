"""The `printed` form: M, C and F of Eqs. 21-22 entry for entry, errata included.

Nothing here is corrected; the errata finder says what differs from the paper's own energies.
"""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.derivation.stage import Stage
from crosscheck.analytic.derivation.symbols import geared_variables, m_payload
from crosscheck.analytic.paper.energies import JOINTS, STAGE_1, STAGE_2, joint_mass


def primed_inertia(s: Stage) -> sp.Expr:
    """I'_ci = I_ci + 3 m_pi r_ci^2 + I_i, with I_ci = M_ci r_cip^2."""
    return s.M_c * s.r_cp**2 + 3 * s.m_p * s.r_c**2 + s.I_l


def coefficients() -> dict[str, sp.Expr]:
    """a_11, a_12, a_2, a_3, a_4 below Eq. 21."""
    a_6 = STAGE_2.m * STAGE_2.d + m_payload * STAGE_2.L
    return {
        "a_11": (4 * STAGE_1.M_s + 3 * STAGE_1.M_p) * STAGE_1.r_cp**2,
        "a_12": (4 * STAGE_2.M_s + 3 * STAGE_2.M_p) * STAGE_2.r_cp**2,
        "a_2": primed_inertia(STAGE_1)
        + STAGE_1.m * STAGE_1.d**2
        + (STAGE_2.m + joint_mass() + m_payload) * STAGE_1.L**2,
        "a_3": primed_inertia(STAGE_2) + STAGE_2.m * STAGE_2.d**2 + m_payload * STAGE_2.L**2,
        "a_4": STAGE_1.L * a_6,
    }


def mass_entries() -> dict[tuple[int, int], sp.Expr]:
    """The upper triangle of M as listed, by row and column counted from 1."""
    a = coefficients()
    cos_2 = sp.cos(geared_variables(JOINTS).q[5])
    return {
        (1, 1): STAGE_1.M_s,
        (1, 2): STAGE_1.M_s,
        (1, 3): 2 * STAGE_1.M_s * STAGE_1.r_cp,
        (2, 2): STAGE_1.M_s + 3 * STAGE_1.M_p,
        (2, 3): (2 * STAGE_1.M_s + 3 * STAGE_1.M_p) * STAGE_1.r_cp,
        (3, 3): a["a_11"]
        + a["a_2"]
        + STAGE_2.M_s * STAGE_1.r_cp**2
        + a["a_3"]
        + 2 * a["a_4"] * cos_2,
        (3, 4): STAGE_2.M_s * STAGE_1.r_cp,
        (3, 5): STAGE_2.M_s * STAGE_1.r_cp,
        (3, 6): 2 * STAGE_2.M_s * STAGE_2.r_s * STAGE_2.r_cp + a["a_3"] + a["a_4"] * cos_2,
        (4, 4): STAGE_2.M_s,
        (4, 5): STAGE_2.M_s,
        (4, 6): 2 * STAGE_2.M_s * STAGE_2.r_cp,
        (5, 5): STAGE_2.M_s + 3 * STAGE_2.M_p,
        (5, 6): (2 * STAGE_2.M_s + 3 * STAGE_2.M_p) * STAGE_2.r_cp,
        (6, 6): a["a_12"] + a["a_3"],
    }


def coriolis_entries() -> dict[tuple[int, int], sp.Expr]:
    """The entries of C as listed, by row and column counted from 1."""
    a_4 = coefficients()["a_4"]
    variables = geared_variables(JOINTS)
    sin_2 = sp.sin(variables.q[5])
    dtheta_1, dtheta_2 = variables.v[2::3]
    return {
        (3, 3): -2 * a_4 * sin_2 * dtheta_2,
        (3, 6): -a_4 * sin_2 * dtheta_2,
        (6, 3): a_4 * sin_2 * dtheta_1,
    }


def force_entries() -> list[sp.Expr]:
    """F of Eq. 22; its T_i is the motor's torque, T / n in terms of the output side (Section 3)."""
    F_sp1, F_pr1, F_sp2, F_pr2 = geared_variables(JOINTS).mesh_forces
    T_1, T_2 = geared_variables(JOINTS).torques
    motor_1, motor_2 = T_1 / STAGE_1.n, T_2 / STAGE_2.n
    return [
        -3 * F_sp1 + motor_1 / STAGE_1.r_s,
        -3 * F_pr1 + motor_1 / STAGE_1.r_s,
        2 * motor_1 * STAGE_1.r_cp / STAGE_1.r_s,
        -3 * F_sp2 + motor_2 / STAGE_2.r_s,
        -3 * F_pr2 + motor_2 / STAGE_2.r_s,
        2 * motor_2 * STAGE_2.r_cp / STAGE_2.r_s,
    ]


@lru_cache
def build_printed_form() -> Form:
    """Eqs. 21-22 as a form; unlisted elements are zero."""
    variables = geared_variables(JOINTS)
    size = len(variables.q)
    mass, coriolis = sp.zeros(size, size), sp.zeros(size, size)
    for (row, column), entry in mass_entries().items():
        mass[row - 1, column - 1] = mass[column - 1, row - 1] = sp.expand(entry)
    for (row, column), entry in coriolis_entries().items():
        coriolis[row - 1, column - 1] = entry
    bias = (coriolis * sp.Matrix(variables.v)).applyfunc(sp.expand)
    return Form(
        "printed",
        variables.q,
        variables.v,
        sp.ImmutableMatrix(mass),
        sp.ImmutableMatrix(bias),
        sp.ImmutableMatrix([sp.expand(entry) for entry in force_entries()]),
    )
