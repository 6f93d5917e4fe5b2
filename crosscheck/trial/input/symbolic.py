"""Equations from sympy: bound to an arm's numbers by the names of its quantities."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from crosscheck.analytic.derivation.symbols import parameter_values
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.trial.input.bindings import in_arm_symbols, plain_symbols
from crosscheck.trial.input.equations import Coordinates, Equations, Level, Symbolic

WHERE = "equations"
QUADRATIC = 2
USUAL, TIME = Coordinates(), sp.Symbol("t")
PARTS = ("mass_matrix", "bias", "force")
Parts = dict[str, sp.Matrix]


def from_sympy(
    x: Sequence[Any],
    v: Sequence[Any],
    *,
    mass_matrix: Any = None,
    bias: Any = None,
    coriolis: Any = None,
    force: Any = None,
    forcing: Any = None,
    torque: Sequence[Any] = (),
    t: sp.Symbol = TIME,
    values: Mapping[Any, float | str] | None = None,
    coordinates: Coordinates = USUAL,
    level: Level = "",
    switches: Switches | None = None,
) -> Equations:
    """Equations out of sympy matrices over symbols x, v = x', torque and time t.

    Symbols may be dynamicsymbols and their derivatives. forcing, as KanesMethod and LagrangesMethod
    give it, is force - bias: what is quadratic in v is the bias, the rest is the force. values says
    what each other symbol is, a number or the name of a quantity of the arm; a symbol called like
    a quantity (``L1``, ``r_s2``, ``m_payload``) needs none. ``Equations.on`` puts an arm's numbers
    in. Raises InputError.
    """
    x, v = tuple(x), tuple(v)
    plain = plain_symbols(x, v, torque)
    own_x, own_v, own_torque = (tuple(plain[own] for own in group) for group in (x, v, torque))
    given = {
        "mass_matrix": mass_matrix,
        "bias": bias,
        "coriolis": coriolis,
        "force": force,
        "forcing": forcing,
    }
    parts = {
        name: _matrix(matrix, name, len(x)).xreplace(plain)
        for name, matrix in given.items()
        if matrix is not None
    }
    symbolic = Symbolic(
        own_x, own_v, own_torque, t=t, values=dict(values or {}), **_standard(parts, own_v)
    )
    names = coordinates.names or tuple(symbol.name for symbol in own_x)
    unbound = Equations(
        coordinates=replace(coordinates, names=names),
        level=level,
        switches=switches,
        symbolic=symbolic,
    )
    return replace(unbound, rebuild=lambda arm, scenario: _bound(unbound, symbolic, arm))


def _matrix(given: Any, name: str, n: int) -> sp.ImmutableMatrix:
    """A matrix (n, n), or a column (n, 1). Raises InputError."""
    shape = (n, n) if name in ("mass_matrix", "coriolis") else (n, 1)
    try:
        matrix = sp.ImmutableMatrix(given)
    except (TypeError, ValueError) as error:
        raise InputError(WHERE, name, None, f"is no sympy Matrix: {error}") from None
    if shape[1] == 1 and matrix.shape == (1, n):
        matrix = matrix.T
    if matrix.shape != shape:
        raise InputError(WHERE, name, None, f"has shape {matrix.shape}, must be {shape}")
    return matrix


def _standard(parts: Parts, v: Sequence[sp.Symbol]) -> Parts:
    """Mass matrix, bias and force out of whatever of them was given. Raises InputError."""
    for pair in (("bias", "coriolis"), ("force", "forcing"), ("bias", "forcing")):
        if all(name in parts for name in pair):
            raise InputError(WHERE, pair[1], None, f"give either {pair[0]} or {pair[1]}")
    found = {name: parts[name] for name in PARTS if name in parts}
    if "coriolis" in parts:
        found["bias"] = sp.ImmutableMatrix(parts["coriolis"] * sp.Matrix(v))
    if "forcing" in parts:
        if "coriolis" in parts:
            raise InputError(WHERE, "forcing", None, "give either coriolis or forcing")
        found["bias"], found["force"] = _split(parts["forcing"], v)
    return found


def _split(
    forcing: sp.ImmutableMatrix, v: Sequence[sp.Symbol]
) -> tuple[sp.ImmutableMatrix, sp.ImmutableMatrix]:
    """Bias, the part of -forcing that is quadratic in v, and the rest, the force."""
    columns = [_by_degree(entry, number, v) for number, entry in enumerate(forcing)]
    bias, force = zip(*columns, strict=True)
    return sp.ImmutableMatrix(bias), sp.ImmutableMatrix(force)


def _by_degree(entry: sp.Expr, number: int, v: Sequence[sp.Symbol]) -> tuple[sp.Expr, sp.Expr]:
    """Of a row of forcing. Raises InputError where it is no polynomial in v."""
    try:
        terms = sp.Poly(entry, *v).terms()
    except sp.PolynomialError:
        reason = "is no polynomial in v; give bias and force apart"
        raise InputError(WHERE, f"forcing[{number}]", None, reason) from None
    bias, force = sp.Integer(0), sp.Integer(0)
    for powers, factor in terms:
        term = factor * sp.prod([u**p for u, p in zip(v, powers, strict=True)])
        if sum(powers) == QUADRATIC:
            bias -= term
        else:
            force += term
    return bias, force


def of_arm(symbolic: Symbolic, arm: Arm) -> Symbolic:
    """The same with nothing but the arm's symbols (``derivation.symbols``) beside the variables.

    Raises InputError naming a symbol that is no quantity of the arm.
    """
    own = {*symbolic.x, *symbolic.v, *symbolic.torque, symbolic.t}
    parts = {
        name: in_arm_symbols(matrix, own, symbolic.values, arm, f"{WHERE}: {name}")
        for name, matrix in _parts(symbolic).items()
    }
    return replace(symbolic, values={}, **parts)


def _parts(symbolic: Symbolic) -> Parts:
    parts = {name: getattr(symbolic, name) for name in PARTS}
    return {name: matrix for name, matrix in parts.items() if matrix is not None}


def _bound(unbound: Equations, symbolic: Symbolic, arm: Arm) -> Equations:
    """With the numbers of an arm; of this arm alone where the user's own numbers are in it."""
    numbers = {symbol: float(value) for symbol, value in parameter_values(arm).items()}
    bound = of_arm(symbolic, arm)
    functions = {
        name: _function(matrix, bound, name, numbers) for name, matrix in _parts(bound).items()
    }

    def again(other: Arm, scenario: Scenario | None) -> Equations:
        return _bound(unbound, symbolic, other)

    return replace(
        unbound,
        mass_matrix=functions.get("mass_matrix"),
        bias=functions.get("bias"),
        force=functions.get("force"),
        rebuild=again,
        any_arm=_by_name(symbolic, unbound.coordinates),
    )


def _by_name(symbolic: Symbolic, coordinates: Coordinates) -> bool:
    """Whether all that hangs on an arm is there by name, and no number of one."""
    own, matrices = coordinates.function, list(_parts(symbolic).values())
    if coordinates.matrix is not None and not np.all(np.mod(coordinates.matrix, 1) == 0):
        return False
    if own is not None and not isinstance(own, sp.MatrixBase):
        return False
    matrices += [] if own is None else [own]
    floats = any(matrix.atoms(sp.Float) for matrix in matrices)
    return not floats and all(isinstance(value, str) for value in symbolic.values.values())


def _function(
    matrix: sp.ImmutableMatrix, bound: Symbolic, name: str, numbers: Mapping[sp.Symbol, float]
) -> Callable[..., np.ndarray]:
    variables = (bound.x, bound.v, bound.torque)
    quantities = tuple(sorted(matrix.free_symbols & set(numbers), key=str))
    _require_variables(matrix, name, bound)
    compiled = _compiled(matrix, bound.t, variables, quantities)
    values = [numbers[symbol] for symbol in quantities]
    if name == "mass_matrix":
        return lambda x: compiled(0.0, x, 0 * x, np.zeros(len(bound.torque)), values)
    if name == "bias":
        return lambda x, v: compiled(0.0, x, v, np.zeros(len(bound.torque)), values)
    if not bound.torque:
        return lambda t, x, v: compiled(t, x, v, (), values)
    return lambda t, x, v, torque: compiled(t, x, v, torque, values)


def _require_variables(matrix: sp.ImmutableMatrix, name: str, bound: Symbolic) -> None:
    """Raise InputError where M or the bias hangs on what it cannot hang on."""
    strange = {"mass_matrix": (*bound.v, *bound.torque, bound.t), "bias": (*bound.torque, bound.t)}
    found = sorted(map(str, matrix.free_symbols & set(strange.get(name, ()))))
    if found:
        allowed = "x alone" if name == "mass_matrix" else "x and v alone"
        reason = f"has {', '.join(found)}; must be of {allowed}"
        raise InputError(WHERE, name, None, reason)


@lru_cache(maxsize=64)
def _compiled(
    matrix: sp.ImmutableMatrix,
    t: sp.Symbol,
    variables: tuple[tuple[sp.Symbol, ...], ...],
    quantities: tuple[sp.Symbol, ...],
) -> Callable[..., np.ndarray]:
    """One function of (t, x, v, torque, quantities) for every arm of a structure."""
    function: Callable[..., np.ndarray] = sp.lambdify(
        [t, *map(list, variables), list(quantities)], matrix, "numpy", cse=True
    )
    return function
