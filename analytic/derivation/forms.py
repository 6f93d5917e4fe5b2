"""Equations of motion in symbols."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from crosscheck.analytic.derivation.lagrange import AngleSum, MassTerms


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


def mass_matrix(mass: MassTerms, q: Sequence[sp.Symbol]) -> sp.ImmutableMatrix:
    """Mass matrix M(q) in symbols, shape (n, n)."""
    total = sp.zeros(len(q), len(q))
    for (row, column, wave), coefficient in mass.items():
        total[row, column] += coefficient * sp.cos(_argument(wave, q))
    return sp.ImmutableMatrix(total.applyfunc(sp.expand))


def _argument(angle_sum: AngleSum, q: Sequence[sp.Symbol]) -> sp.Expr:
    return sp.Add(*(w * coordinate for w, coordinate in zip(angle_sum, q, strict=True)))


def christoffel_bias(
    mass: sp.ImmutableMatrix, q: Sequence[sp.Symbol], v: Sequence[sp.Symbol]
) -> sp.ImmutableMatrix:
    """C(q, v) v of any M, shape (n, 1), from d/dt(dT/dv) - dT/dq with T = v^T M v / 2."""
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
        total += effort * sp.Matrix([sp.diff(displacement, coordinate) for coordinate in q])
    return sp.ImmutableMatrix(total.applyfunc(sp.expand))
