"""Lagrange's equations for planar chains, in symbols.

A planar chain of links with absolute angles Theta_k places every body's centre at
sum_k c_k e(Theta_k), e being the unit vector along link k. Its velocity is sum_k c_k n(Theta_k)
Theta_k', with n normal to e, and n(Theta_k) . n(Theta_l) = cos(Theta_k - Theta_l). So the mass
matrix sum J^T m J has only cosines of differences of absolute angles in it, and needs no
simplification.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp


@dataclass(frozen=True)
class Body:
    """A rigid body of a planar chain.

    mass [kg] and inertia [kg m^2] about its centre; angle: absolute angle [rad], linear in q;
    centre: per link, the distance c_k [m] of its centre along that link (empty: on the base).
    """

    name: str
    mass: sp.Expr
    inertia: sp.Expr
    angle: sp.Expr
    centre: tuple[sp.Expr, ...] = ()


@dataclass(frozen=True)
class Form:
    """A set of equations of motion M(q) q'' + bias(q, q') = force, in symbols.

    Each is a sympy Matrix over q, v; ``force`` is linear in the mesh forces and the torques.
    Damping is not part of a form.
    """

    name: str
    q: tuple[sp.Symbol, ...]
    v: tuple[sp.Symbol, ...]
    mass_matrix: sp.ImmutableMatrix
    bias: sp.ImmutableMatrix
    force: sp.ImmutableMatrix


def mass_matrix(
    bodies: Iterable[Body], link_angles: Sequence[sp.Expr], q: Sequence[sp.Symbol]
) -> sp.ImmutableMatrix:
    """M(q) = sum over bodies of J_v^T m J_v + J_w^T I J_w, shape (n, n).

    link_angles: absolute angle of each link, linear in q.
    """
    rows = [_gradient(angle, q) for angle in link_angles]
    total = sp.zeros(len(q), len(q))
    for body in bodies:
        spin = _gradient(body.angle, q)
        total += body.inertia * spin.T * spin
        for k, c_k in enumerate(body.centre):
            for j, c_j in enumerate(body.centre):
                overlap = sp.cos(link_angles[k] - link_angles[j])
                total += body.mass * c_k * c_j * overlap * rows[k].T * rows[j]
    return sp.ImmutableMatrix(total.applyfunc(sp.expand))


def christoffel_bias(
    mass: sp.ImmutableMatrix, q: Sequence[sp.Symbol], v: Sequence[sp.Symbol]
) -> sp.ImmutableMatrix:
    """C(q, v) v, shape (n, 1), from d/dt(dT/dv) - dT/dq with T = v^T M v / 2."""
    rate = sp.Matrix(v)
    momentum = sp.Matrix(mass) * rate
    kinetic = (rate.T * momentum)[0] / 2
    changing = sp.zeros(len(q), 1)
    for angle, velocity in zip(q, v, strict=True):
        changing += momentum.diff(angle) * velocity
    slope = sp.Matrix([kinetic.diff(angle) for angle in q])
    return sp.ImmutableMatrix((changing - slope).applyfunc(sp.expand))


def virtual_work(
    efforts: Iterable[tuple[sp.Expr, sp.Expr]], q: Sequence[sp.Symbol]
) -> sp.ImmutableMatrix:
    """Generalized force, shape (n, 1), of efforts (force, the displacement that it works on)."""
    total = sp.zeros(len(q), 1)
    for effort, displacement in efforts:
        total += effort * _gradient(displacement, q).T
    return sp.ImmutableMatrix(total.applyfunc(sp.expand))


def _gradient(expression: sp.Expr, q: Sequence[sp.Symbol]) -> sp.Matrix:
    return sp.Matrix([[sp.diff(expression, coordinate) for coordinate in q]])
