"""A form that is written in symbols, with an arm's numbers put in."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
import sympy as sp

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.derivation.symbols import geared_variables, rational_values
from crosscheck.analytic.derivation.terms import AngleSums, Terms, indices
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import lumped_layout

TermCoefficients = defaultdict[tuple[int, ...], float]
Numbers = Mapping[sp.Symbol, sp.Rational]  # values of parameters


def build_form_terms(form: Form, arm: Arm) -> Terms:
    """The terms of a form in the paper's coordinates; it knows no gravity and no friction.

    Raises ValueError if an entry is not of the shape that Terms describe.
    """
    exact, variables = rational_values(arm), geared_variables(len(arm.joints))
    waves = AngleSums(len(form.q))
    mass, bias = _mass_terms(form, exact, waves), _bias_terms(form, exact, waves)
    mesh_map = _linear_map(form.force, variables.mesh_forces, exact)
    drive_map = _linear_map(form.force, variables.torques, exact)
    return Terms(
        waves.table(),
        indices(mass, 3),
        np.array([*mass.values()], dtype=float),
        indices(bias, 4),
        np.array([*bias.values()], dtype=float),
        indices({}, 2),
        np.zeros((0, 2)),
        mesh_map,
        drive_map,
        lumped_layout(arm).theta,
        np.zeros(len(arm.joints)),
    )


def _mass_terms(form: Form, exact: Numbers, angle_sums: AngleSums) -> TermCoefficients:
    coefficients: TermCoefficients = defaultdict(float)
    for (row, column), entry in _entries(form.mass_matrix):
        for term in _summands(entry, exact):
            factor, rest = term.as_independent(*form.q, as_Add=False)
            argument = _argument(rest, sp.cos) if rest != 1 else sp.S.Zero
            coefficients[row, column, angle_sums.number(_angle_sum(argument, form.q))] += float(
                factor
            )
    return coefficients


def _bias_terms(form: Form, exact: Numbers, angle_sums: AngleSums) -> TermCoefficients:
    coefficients: TermCoefficients = defaultdict(float)
    for (row, _), entry in _entries(form.bias):
        for term in _summands(entry, exact):
            factor, rest = term.as_independent(*form.q, *form.v, as_Add=False)
            rates, sine = rest.as_independent(*form.q, as_Add=False)
            a, b = _two_rates(rates, form.v)
            coefficients[
                row, angle_sums.number(_angle_sum(_argument(sine, sp.sin), form.q)), a, b
            ] += float(factor)
    return coefficients


@cache  # a form has hundreds of terms and a handful of angles
def _angle_sum(argument: sp.Expr, q: tuple[sp.Symbol, ...]) -> tuple[float, ...]:
    polynomial = sp.Poly(argument, *q)
    if polynomial.total_degree() > 1:
        raise ValueError(f"not linear in the coordinates: {argument}")
    return tuple(float(polynomial.coeff_monomial(coordinate)) for coordinate in q)


def _entries(matrix: sp.ImmutableMatrix) -> list[tuple[tuple[int, int], sp.Expr]]:
    return sorted(matrix.todok().items())


def _summands(entry: sp.Expr, exact: Numbers) -> tuple[sp.Expr, ...]:
    """The terms left after the numbers are in; they are put in exactly, so that they cancel."""
    left = sp.expand(entry.xreplace(exact))
    return sp.Add.make_args(left) if left != 0 else ()


def _argument(factor: sp.Expr, function: type[sp.Function]) -> sp.Expr:
    if not isinstance(factor, function):
        raise ValueError(f"neither constant nor a single {function.__name__}: {factor}")
    return factor.args[0]


def _two_rates(product: sp.Expr, v: Sequence[sp.Symbol]) -> tuple[int, int]:
    powers = product.as_powers_dict()
    rates = [v.index(symbol) for symbol, power in powers.items() for _ in range(int(power))]
    if len(rates) != 2:
        raise ValueError(f"not a product of two rates: {product}")
    return rates[0], rates[1]


def _linear_map(
    force: sp.ImmutableMatrix, inputs: Sequence[sp.Symbol], exact: Numbers
) -> np.ndarray:
    """Coefficient of every input in every row, shape (rows, inputs)."""
    jacobian = [[sp.diff(entry, symbol).xreplace(exact) for symbol in inputs] for entry in force]
    return np.array(jacobian, dtype=float).reshape(force.rows, len(inputs))
