"""The rigid baseline of Eq. 1 at four levels, by the same Lagrange derivation.

`links` is the paper's rigid arm; each further level adds what the gears bring along rigidly.
"""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from analytic.lagrange import Form, christoffel_bias, mass_matrix
from analytic.physical import carrier_bodies, link_angles, link_bodies, spinning_bodies
from analytic.symbols import geared_variables, rigid_variables, stage_symbols

LEVELS = ("links", "carriers", "armature", "coupled")


@lru_cache
def rigid_form(joints: int, level: str) -> Form:
    """Equations of motion over the joint angles; the drive is the output-side torque."""
    variables = rigid_variables(joints)
    numbers = range(1, joints + 1)
    bodies = [body for joint in numbers for body in link_bodies(joint, joints)]
    if level != "links":
        bodies += [body for joint in numbers for body in carrier_bodies(joint, joints)]
    if level == "coupled":
        bodies += [body for joint in numbers for body in spinning_bodies(joint, joints)]
    mass = _without_mesh(mass_matrix(bodies, link_angles(joints), geared_variables(joints).q))
    if level == "armature":
        mass += sp.diag(*(reflected_inertia(joint) for joint in numbers))
    mass = sp.ImmutableMatrix(mass)
    return Form(
        level,
        variables.q,
        variables.v,
        mass,
        christoffel_bias(mass, variables.q, variables.v),
        sp.ImmutableMatrix(variables.torques),
    )


def reflected_inertia(joint: int) -> sp.Expr:
    """a_1i of Eq. 21 [kg m^2]: sun and planets, geared to the carrier, as seen by the joint."""
    stage = stage_symbols(joint)
    return (4 * stage.M_s + stage.N * stage.M_p) * stage.r_cp**2


def _without_mesh(mass: sp.ImmutableMatrix) -> sp.ImmutableMatrix:
    """The rows and columns of the joint angles: x_sp = x_pr = 0 throughout."""
    keep = list(range(2, mass.rows, 3))
    return mass.extract(keep, keep)
