"""The `physical` form: every body with its true absolute velocity, for N planar geared joints."""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from crosscheck.analytic.derivation.bodies import all_bodies
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.efforts import drive_rows, mesh_rows
from crosscheck.analytic.derivation.forms import Form, bias_vector, mass_matrix
from crosscheck.analytic.derivation.lagrange import bias_terms, mass_terms
from crosscheck.analytic.derivation.symbols import geared_variables, symbolic_chain


@lru_cache
def physical_form(joints: int) -> Form:
    """Equations of motion of an arm with this many geared joints, in the paper's coordinates."""
    variables, chain = geared_variables(joints), symbolic_chain([True] * joints)
    q, v = variables.q, variables.v
    mass = mass_terms(all_bodies(chain), chain.angles[1:])
    bias = bias_vector(bias_terms(mass), q, v)
    return Form("physical", q, v, mass_matrix(mass, q), bias, _force(chain, joints))


def _force(chain: Chain, joints: int) -> sp.ImmutableMatrix:
    """Mesh forces and torques on the coordinates."""
    variables = geared_variables(joints)
    total = sp.zeros(len(variables.q), 1)
    for rows, symbols in (
        (mesh_rows(chain), variables.mesh_forces),
        (drive_rows(chain), variables.torques),
    ):
        for row, symbol in zip(rows, symbols, strict=True):
            total += symbol * sp.Matrix(list(row))
    return sp.ImmutableMatrix(total.applyfunc(sp.expand))
