"""A symbolic form with an arm's numbers put in, as flat arrays for the compiled kernel.

Every planar chain's mass matrix is a sum of cosines of sums of joint angles, and its bias a sum of
sines times products of two rates. Both become lists of terms, so one kernel runs every form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import sympy as sp

from analytic.lagrange import Form


class Terms(NamedTuple):
    """M[row, col] += coeff cos(waves[wave] . q); bias[row] += coeff sin(waves[wave] . q) v_a v_b.

    waves (K, n); mass (terms, 3) and bias (terms, 4) hold the integer indices row, col, wave and
    row, wave, a, b; the coefficients are in SI units. mesh_map (n, meshes) and drive_map
    (n, joints) turn mesh forces per planet [N] and output torques [N m] into generalized force.
    """

    waves: np.ndarray
    mass: np.ndarray
    mass_coeff: np.ndarray
    bias: np.ndarray
    bias_coeff: np.ndarray
    mesh_map: np.ndarray
    drive_map: np.ndarray


def numeric_terms(
    form: Form,
    values: Mapping[sp.Symbol, float],
    mesh_forces: Sequence[sp.Symbol],
    torques: Sequence[sp.Symbol],
) -> Terms:
    """The form's terms for these parameter values.

    Raises ValueError if an entry is not of the shape described above.
    """
    waves = _Waves(form.q)
    mass, mass_coeff = _mass_terms(form, values, waves)
    bias, bias_coeff = _bias_terms(form, values, waves)
    return Terms(
        waves.table(),
        np.array(mass, dtype=np.int64).reshape(-1, 3),
        np.array(mass_coeff, dtype=float),
        np.array(bias, dtype=np.int64).reshape(-1, 4),
        np.array(bias_coeff, dtype=float),
        _linear_map(form.force, mesh_forces, values),
        _linear_map(form.force, torques, values),
    )


Indexed = tuple[list[tuple[int, ...]], list[float]]


class _Waves:
    """Numbers the distinct angle sums w . q; sign is the caller's business."""

    def __init__(self, q: Sequence[sp.Symbol]) -> None:
        self.q = q
        self.index: dict[tuple[float, ...], int] = {}

    def number(self, argument: sp.Expr) -> int:
        polynomial = sp.Poly(argument, *self.q)
        if polynomial.total_degree() > 1:
            raise ValueError(f"not linear in the coordinates: {argument}")
        wave = tuple(float(polynomial.coeff_monomial(coordinate)) for coordinate in self.q)
        return self.index.setdefault(wave, len(self.index))

    def table(self) -> np.ndarray:
        return np.array(list(self.index), dtype=float).reshape(-1, len(self.q))


def _mass_terms(form: Form, values: Mapping[sp.Symbol, float], waves: _Waves) -> Indexed:
    indices: list[tuple[int, ...]] = []
    coefficients: list[float] = []
    for (row, col), entry in _entries(form.mass_matrix):
        for term in _summands(entry, values):
            factor, rest = term.as_independent(*form.q, as_Add=False)
            wave = waves.number(_argument(rest, sp.cos) if rest != 1 else sp.S.Zero)
            indices.append((row, col, wave))
            coefficients.append(float(factor))
    return indices, coefficients


def _bias_terms(form: Form, values: Mapping[sp.Symbol, float], waves: _Waves) -> Indexed:
    indices: list[tuple[int, ...]] = []
    coefficients: list[float] = []
    for (row, _), entry in _entries(form.bias):
        for term in _summands(entry, values):
            factor, rest = term.as_independent(*form.q, *form.v, as_Add=False)
            rates, sine = rest.as_independent(*form.q, as_Add=False)
            a, b = _two_rates(rates, form.v)
            indices.append((row, waves.number(_argument(sine, sp.sin)), a, b))
            coefficients.append(float(factor))
    return indices, coefficients


def _entries(matrix: sp.ImmutableMatrix) -> list[tuple[tuple[int, int], sp.Expr]]:
    return sorted(matrix.todok().items())


def _summands(entry: sp.Expr, values: Mapping[sp.Symbol, float]) -> tuple[sp.Expr, ...]:
    """The terms left after the numbers are in; they are put in exactly, so that they cancel."""
    exact = {symbol: sp.Rational(value) for symbol, value in values.items()}
    left = sp.expand(entry.subs(exact))
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
    force: sp.ImmutableMatrix, inputs: Sequence[sp.Symbol], values: Mapping[sp.Symbol, float]
) -> np.ndarray:
    """Coefficient of every input in every row, shape (rows, inputs)."""
    jacobian = [[sp.diff(entry, symbol).subs(values) for symbol in inputs] for entry in force]
    return np.array(jacobian, dtype=float).reshape(force.rows, len(inputs))
