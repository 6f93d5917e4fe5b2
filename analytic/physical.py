"""The `physical` form: every body with its true absolute velocity, for N planar geared joints.

The bodies are those of Eqs. 16-19; where the paper drops a velocity (the elbow's planets share no
rotation of link 1 in Eq. 18) the true one stands here.
"""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from analytic.kinematics import gear_angles
from analytic.lagrange import Body, Form, christoffel_bias, mass_matrix, virtual_work
from analytic.symbols import geared_variables, m_payload, stage_symbols


@lru_cache
def physical_form(joints: int) -> Form:
    """Equations of motion of an arm with this many geared joints, in the paper's coordinates."""
    variables = geared_variables(joints)
    q, v = variables.q, variables.v
    mass = mass_matrix(all_bodies(joints), link_angles(joints), q)
    return Form(
        "physical", q, v, mass, christoffel_bias(mass, q, v), virtual_work(_efforts(joints), q)
    )


def link_angles(joints: int) -> list[sp.Expr]:
    """Absolute angle of every link: the joint angles summed from the base on."""
    theta = geared_variables(joints).q[2::3]
    return [sp.Add(*theta[: k + 1]) for k in range(joints)]


def all_bodies(joints: int) -> list[Body]:
    """Every body of the arm."""
    bodies = [body for joint in range(1, joints + 1) for body in link_bodies(joint, joints)]
    for joint in range(1, joints + 1):
        bodies += carrier_bodies(joint, joints) + spinning_bodies(joint, joints)
    return bodies


def link_bodies(joint: int, joints: int) -> list[Body]:
    """The link behind a joint, and the payload at the end of the last one (Eqs. 17, 19)."""
    stage = stage_symbols(joint)
    angle = link_angles(joints)[joint - 1]
    origin = _joint_centre(joint)
    bodies = [Body(f"link {joint}", stage.m, stage.I_l, angle, (*origin, stage.d))]
    if joint == joints:
        bodies.append(Body("payload", m_payload, sp.S.Zero, angle, (*origin, stage.L)))
    return bodies


def carrier_bodies(joint: int, joints: int) -> list[Body]:
    """What turns with the links at a joint, and the masses that it carries.

    The planets' centres, equally spaced on the carrier, act as their mass on the joint axis and
    as N m_p r_c^2 about it.
    """
    stage = stage_symbols(joint)
    angles = [sp.S.Zero, *link_angles(joints)]
    centre = _joint_centre(joint)
    carrier = stage.M_c * stage.r_cp**2
    orbit = stage.N * stage.m_p * stage.r_c**2
    return [
        Body(f"ring {joint}", stage.m_r, stage.J_r, angles[joint - 1], centre),
        Body(f"carrier {joint}", stage.m_c, carrier, angles[joint], centre),
        Body(f"planet centres {joint}", stage.N * stage.m_p, orbit, angles[joint], centre),
        Body(f"sun centre {joint}", stage.m_s, sp.S.Zero, angles[joint - 1], centre),
    ]


def spinning_bodies(joint: int, joints: int) -> list[Body]:
    """Spin of sun and planets about their own axes (their masses are in `carrier_bodies`)."""
    stage = stage_symbols(joint)
    theta_s, theta_p = _gear_angles(joint, joints)
    base = ([sp.S.Zero, *link_angles(joints)])[joint - 1]
    sun, planet = stage.M_s * stage.r_s**2, stage.M_p * stage.r_p**2
    return [
        Body(f"sun {joint}", sp.S.Zero, sun, base + theta_s),
        Body(f"planets {joint}", sp.S.Zero, stage.N * planet, base - theta_p),
    ]


def _joint_centre(joint: int) -> tuple[sp.Symbol, ...]:
    return tuple(stage_symbols(k).L for k in range(1, joint))


def _gear_angles(joint: int, joints: int) -> tuple[sp.Expr, sp.Expr]:
    stage = stage_symbols(joint)
    x_sp, x_pr, theta = geared_variables(joints).q[3 * joint - 3 : 3 * joint]
    return gear_angles(x_sp, x_pr, theta, stage.r_s, stage.r_p, stage.r_cp)


def _efforts(joints: int) -> list[tuple[sp.Expr, sp.Expr]]:
    """Mesh forces against their displacements; T/n on the sun, reacting on the previous link."""
    variables = geared_variables(joints)
    efforts = []
    for joint in range(1, joints + 1):
        stage = stage_symbols(joint)
        x_sp, x_pr, _ = variables.q[3 * joint - 3 : 3 * joint]
        F_sp, F_pr = variables.mesh_forces[2 * joint - 2 : 2 * joint]
        theta_s, _ = _gear_angles(joint, joints)
        efforts += [(-stage.N * F_sp, x_sp), (-stage.N * F_pr, x_pr)]
        efforts += [(variables.torques[joint - 1] / stage.n, theta_s)]
    return efforts
