"""Equations from sympy: bound to an arm's numbers by the names of its quantities."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache, lru_cache
from numbers import Real
from typing import Any

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from crosscheck.analytic.derivation.symbols import parameter_values
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.input.arm_symbols import find_meant_symbols
from crosscheck.trial.input.calls import parse_motors
from crosscheck.trial.input.equations import Coordinates, Equations, Level, Motors, Symbolic

WHERE = "equations"
QUADRATIC = 2
USUAL, TIME = Coordinates(), sp.Symbol("t")
PARTS = ("mass_matrix", "bias", "force", "gravity")
NEAR, MOST_NAMED = 0.4, 4  # of names of quantities that may have been meant
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
    gravity: Any = None,
    torque: Sequence[Any] = (),
    drive: Motors | None = None,
    t: sp.Symbol = TIME,
    values: Mapping[Any, float | str] | None = None,
    coordinates: Coordinates = USUAL,
    level: Level = "",
    switches: Switches | None = None,
) -> Equations:
    """Equations out of sympy matrices over symbols x, v = x', torque and time t.

    Symbols may be dynamicsymbols and their derivatives. ``Equations.adapt_to_arm`` puts an arm's
    numbers in.

    Args:
        x: Symbols of the coordinates (n,).
        v: Symbols of their rates (n,).
        mass_matrix: M, shape (n, n).
        bias: C v, shape (n, 1), or a row.
        coriolis: C itself, shape (n, n), in place of the bias.
        force: Drive, meshes, dampers and friction, and weight where there is no gravity, shape
            (n, 1), or a row.
        gravity: What holds the weights, shape (n, 1), or a row.
        forcing: force - bias, as KanesMethod and LagrangesMethod give it: what is quadratic in v is
            the bias, the rest is the force.
        torque: Symbols of the drive's torques on the output side (joints,) [N m].
        drive: The joints that have a motor, by numbers from 1 or by names; ``torque`` then has a
            symbol for each of them, or for every joint.
        t: The symbol of time [s].
        values: What each other symbol is, a number or the name of a quantity of the arm; a symbol
            called like a quantity (``L1``, ``r_s2``, ``m_payload``, friction ``c1``, gravity
            ``g_x``) needs none.
        coordinates: What x are; joint angles [rad] relative to the previous link, if not given.
        level: The rigid level that they are meant to be, '' for whichever they are closest to.
        switches: Laws of the gear model that they follow.

    Returns:
        Equations of any arm.

    Raises:
        InputError: A matrix has another shape or is none, or two arguments say the same.
    """
    x, v = tuple(x), tuple(v)
    plain = make_plain_symbols(x, v, torque)
    x_symbols, v_symbols, torque_symbols = (
        tuple(plain[variable] for variable in group) for group in (x, v, torque)
    )
    given = {
        "mass_matrix": mass_matrix,
        "bias": bias,
        "coriolis": coriolis,
        "force": force,
        "forcing": forcing,
        "gravity": gravity,
    }
    parts = {
        name: _matrix(matrix, name, len(x)).xreplace(plain)
        for name, matrix in given.items()
        if matrix is not None
    }
    symbolic = Symbolic(
        x_symbols,
        v_symbols,
        torque_symbols,
        t=t,
        values=dict(values or {}),
        drive=drive,
        **_standard_parts(parts, v_symbols),
    )
    names = coordinates.names or tuple(symbol.name for symbol in x_symbols)
    unbound = Equations(
        coordinates=replace(coordinates, names=names),
        drive=drive,
        level=level,
        switches=switches,
        symbolic=symbolic,
    )
    return replace(unbound, rebuild=lambda arm, scenario: _bind_to_arm(unbound, symbolic, arm))


def _matrix(given: Any, name: str, n: int) -> sp.ImmutableMatrix:
    """A matrix (n, n), or a column (n, 1). Raises InputError."""
    shape = (n, n) if name in ("mass_matrix", "coriolis") else (n, 1)
    try:
        matrix = sp.ImmutableMatrix(given)
    except (TypeError, ValueError) as error:
        raise InputError(WHERE, name, None, f"is not a sympy Matrix: {error}") from None
    if shape[1] == 1 and matrix.shape == (1, n):
        matrix = matrix.T
    if matrix.shape != shape:
        raise InputError(WHERE, name, None, f"has shape {matrix.shape}, must be {shape}")
    return matrix


def _standard_parts(parts: Parts, v: Sequence[sp.Symbol]) -> Parts:
    """Mass matrix, bias and force out of whatever of them was given. Raises InputError."""
    twice = (("bias", "coriolis"), ("force", "forcing"), ("bias", "forcing"))
    for name_a, name_b in (*twice, ("coriolis", "forcing")):
        if name_a in parts and name_b in parts:
            raise InputError(WHERE, name_b, None, f"give either {name_a} or {name_b}")
    standard_parts = {name: parts[name] for name in PARTS if name in parts}
    if "coriolis" in parts:
        standard_parts["bias"] = sp.ImmutableMatrix(parts["coriolis"] * sp.Matrix(v))
    if "forcing" in parts:
        standard_parts["bias"], standard_parts["force"] = _split(parts["forcing"], v)
    return standard_parts


def _split(
    forcing: sp.ImmutableMatrix, v: Sequence[sp.Symbol]
) -> tuple[sp.ImmutableMatrix, sp.ImmutableMatrix]:
    """Bias, the part of -forcing that is quadratic in v, and the rest, the force.

    Of a row that is no polynomial in v it is the part that is the same at opposite rates.
    """
    bias, force = [sp.Integer(0)] * len(forcing), [sp.Integer(0)] * len(forcing)
    for row, entry in enumerate(forcing):
        try:
            if _list_variations(entry):
                raise sp.PolynomialError
            terms = sp.Poly(entry, *v).terms()
        except sp.PolynomialError:
            opposite = entry.xreplace({rate: -rate for rate in v})
            rest = entry.xreplace(dict.fromkeys(v, sp.Integer(0)))
            bias[row] = rest - (entry + opposite) / 2
            force[row] = rest + (entry - opposite) / 2
            continue
        for powers, factor in terms:
            term = factor * sp.prod([u**p for u, p in zip(v, powers, strict=True)])
            if sum(powers) == QUADRATIC:
                bias[row] -= term
            else:
                force[row] += term
    return sp.ImmutableMatrix(bias), sp.ImmutableMatrix(force)


def replace_symbols(symbolic: Symbolic, arm: Arm) -> Symbolic:
    """The expressions with only the arm's symbols (``derivation.symbols``) beside the variables.

    Raises InputError naming a symbol that is no quantity of the arm.
    """
    variables = {*symbolic.x, *symbolic.v, *symbolic.torque, symbolic.t}
    parts = {
        name: express_in_arm_symbols(matrix, variables, symbolic.values, arm, f"{WHERE}: {name}")
        for name, matrix in _parts(symbolic).items()
    }
    torque = _torque_by_name(symbolic, arm.coordinate_names, arm.motors)
    return replace(symbolic, values={}, torque=torque, **parts)


def _torque_by_name(
    symbolic: Symbolic, names: Sequence[str], motors: Sequence[int]
) -> tuple[sp.Symbol, ...]:
    """A symbol for each joint's torque; none for equations without any. Raises InputError."""
    count = len(symbolic.torque)
    if symbolic.drive is not None:
        motors = parse_motors(symbolic.drive, names)
    if count in (0, len(names)):
        return symbolic.torque
    if count != len(motors):
        reason = f"has {count}; must be one for each of {len(names)} joints, or of drive's motors"
        raise InputError(WHERE, "torque", None, reason)
    of_motors = dict(zip(motors, symbolic.torque, strict=True))
    return tuple(of_motors.get(number, sp.Dummy()) for number in range(len(names)))


def _list_quantities(arm: Arm) -> dict[sp.Symbol, Fraction]:
    """The number behind every symbol of an arm, and behind other names that a trial prints."""
    numbers = parameter_values(arm)
    names = {symbol.name for symbol in numbers}
    printed = {n: value for n, value in collect_arm_values(arm).items() if n not in names}
    return numbers | {sp.Symbol(n, real=True): Fraction(value) for n, value in printed.items()}


def _parts(symbolic: Symbolic) -> Parts:
    parts = {name: getattr(symbolic, name) for name in PARTS}
    return {name: matrix for name, matrix in parts.items() if matrix is not None}


def _bind_to_arm(unbound: Equations, symbolic: Symbolic, arm: Arm) -> Equations:
    """The equations with an arm's numbers; of this arm alone where the user's own are in it."""
    numbers = {symbol: float(value) for symbol, value in _list_quantities(arm).items()}
    bound = replace_symbols(symbolic, arm)
    functions: dict[str, Any] = dict.fromkeys(PARTS)
    functions |= {
        name: _make_function(matrix, bound, name, numbers) for name, matrix in _parts(bound).items()
    }
    return replace(
        unbound,
        **functions,
        rebuild=lambda other, scenario: _bind_to_arm(unbound, symbolic, other),
        any_arm=_is_by_name(symbolic, unbound.coordinates),
    )


def bind_to_robot(equations: Equations, robot: Robot) -> Equations:
    """Equations of a robot from symbols, all of which but the variables have numbers in values.

    Raises InputError for a symbol without a number.
    """
    symbolic = equations.symbolic
    assert symbolic is not None  # as the caller knows
    variables = {*symbolic.x, *symbolic.v, *symbolic.torque, symbolic.t}
    torque = _torque_by_name(symbolic, robot.coordinate_names, robot.motors)
    numbers = {str(symbol): value for symbol, value in symbolic.values.items()}
    functions: dict[str, Any] = dict.fromkeys(PARTS)
    for name, matrix in _parts(symbolic).items():
        where, meant = f"{WHERE}: {name}", dict[Any, Any]()
        for symbol in sorted(matrix.free_symbols - variables, key=str):
            value = numbers.get(symbol.name)
            if not isinstance(value, Real | sp.Number):
                reason = "needs a number in values: a robot's quantities have no symbols"
                raise InputError(where, symbol.name, value, reason)
            meant[symbol] = _meaning(symbol, {symbol: value}, {}, where)
        bound = replace(symbolic, torque=torque)
        functions[name] = _make_function(matrix.xreplace(meant), bound, name, {})
    return replace(
        equations,
        **functions,
        coordinates=replace(equations.coordinates, names=()),
        symbolic=None,
        rebuild=None,
    )


def _is_by_name(symbolic: Symbolic, coordinates: Coordinates) -> bool:
    """Whether all that depends on an arm is there by name, and no number of one."""
    function, matrices = coordinates.function, list(_parts(symbolic).values())
    if coordinates.matrix is not None and not np.all(np.mod(coordinates.matrix, 1) == 0):
        return False
    if function is not None and not isinstance(function, sp.MatrixBase):
        return False
    matrices += [] if function is None else [function]
    floats = any(matrix.atoms(sp.Float) for matrix in matrices)
    return not floats and all(isinstance(value, str) for value in symbolic.values.values())


def _make_function(
    matrix: sp.ImmutableMatrix, bound: Symbolic, name: str, numbers: Mapping[sp.Symbol, float]
) -> Callable[..., np.ndarray]:
    """The function of a part. Raises InputError where M or bias depends on what it must not."""
    moving = (*bound.v, *bound.torque, bound.t)
    strange = {"mass_matrix": moving, "gravity": moving, "bias": (*bound.torque, bound.t)}
    forbidden_symbols = sorted(map(str, _list_symbols(matrix) & set(strange.get(name, ()))))
    if forbidden_symbols:
        allowed = "x and v alone" if name == "bias" else "x alone"
        reason = f"has {', '.join(forbidden_symbols)}; must be of {allowed}"
        raise InputError(WHERE, name, None, reason)
    quantities = tuple(sorted(matrix.free_symbols & set(numbers), key=str))
    values = [numbers[symbol] for symbol in quantities]

    @cache
    def compile_part() -> Callable[..., np.ndarray]:
        return _compile(matrix, bound.t, (bound.x, bound.v, bound.torque), quantities)

    def evaluate(t: float, x: Any, v: Any, torque: Any) -> np.ndarray:
        """The part, compiled when it is first asked for: of an edited source, many are not."""
        return compile_part()(t, x, v, torque, values)

    no_torque = np.zeros(len(bound.torque))
    if name in ("mass_matrix", "gravity"):
        return lambda x: evaluate(0.0, x, 0 * x, no_torque)
    if name == "bias":
        return lambda x, v: evaluate(0.0, x, v, no_torque)
    if not bound.torque:
        return lambda t, x, v: evaluate(t, x, v, ())
    return evaluate


def _list_symbols(matrix: sp.ImmutableMatrix) -> set[sp.Symbol]:
    """The symbols of a matrix, but for those of variations, which may depend on fewer."""
    zeros = dict.fromkeys(_list_variations(matrix), sp.S.Zero)
    return (matrix.xreplace(zeros) if zeros else matrix).free_symbols


def _list_variations(expression: Any) -> list[sp.Expr]:
    """What stands for a change of an expression that is not known yet (trial.source.variations)."""
    functions = expression.atoms(sp.Function)
    return [each for each in functions if getattr(each, "is_variation", False)]


@lru_cache(maxsize=64)
def _compile(
    matrix: sp.ImmutableMatrix,
    t: sp.Symbol,
    variables: tuple[tuple[sp.Symbol, ...], ...],
    quantities: tuple[sp.Symbol, ...],
) -> Callable[..., np.ndarray]:
    """A function of (t, x, v, torque, quantities) that serves every arm of a structure."""
    function: Callable[..., np.ndarray] = sp.lambdify(
        [t, *map(list, variables), list(quantities)], matrix, "numpy", cse=True
    )
    return function


def make_plain_symbols(
    x: Sequence[Any], v: Sequence[Any] = (), torque: Sequence[Any] = ()
) -> dict[Any, sp.Symbol]:
    """A symbol for each coordinate, rate and torque, whatever sympy.physics.mechanics calls them.

    x: Symbols or dynamicsymbols; v: these, or the time derivatives of x, which mean v anyway.
    Raises InputError.
    """
    if v and len(v) != len(x):
        raise InputError("symbols", "v", None, f"has {len(v)}, x has {len(x)}; must be as many")
    symbols = {variable: _plain_symbol(variable) for variable in (*x, *v, *torque)}
    if len(set(symbols.values())) < len(x) + len(v) + len(torque):
        words = ", ".join(map(str, (*x, *v, *torque)))
        raise InputError("symbols", "", None, f"two of them are called the same: {words}")
    moving = [
        (variable, rate)
        for variable, rate in zip(x, v, strict=False)
        if variable not in symbols.values()
    ]
    return symbols | {variable.diff(variable.args[0]): symbols[rate] for variable, rate in moving}


def _plain_symbol(variable: Any) -> sp.Symbol:
    if isinstance(variable, sp.Symbol):
        return variable
    if isinstance(variable, AppliedUndef):
        return sp.Symbol(variable.func.__name__, real=True)
    if isinstance(variable, sp.Derivative) and isinstance(variable.expr, AppliedUndef):
        return sp.Symbol(f"d{variable.expr.func.__name__}", real=True)
    raise InputError("symbols", str(variable), None, "must be a Symbol or a dynamicsymbol")


def express_in_arm_symbols(
    expression: sp.Matrix,
    variables: Collection[Any],
    values: Mapping[Any, float | str],
    arm: Arm,
    where: str,
) -> sp.ImmutableMatrix:
    """An expression with each symbol that is not the user's own variable as one of the arm's.

    values: symbol, or its name, to a number or the name of a quantity of the arm; a symbol that is
    called like a quantity is this. Raises InputError naming a symbol that is nothing of this.
    """
    arm_symbols = {symbol.name: symbol for symbol in _list_quantities(arm)}
    undone = sorted(map(str, expression.atoms(AppliedUndef, sp.Derivative)))
    if undone:
        reason = "depend on time; coordinates and rates are x and v"
        raise InputError(where, ", ".join(undone), None, reason)
    unbound = sorted(expression.free_symbols - set(variables), key=str)
    meant = {symbol: _meaning(symbol, values, arm_symbols, where) for symbol in unbound}
    return sp.ImmutableMatrix(expression.xreplace(meant))


def _meaning(
    symbol: sp.Symbol,
    values: Mapping[Any, float | str],
    arm_symbols: dict[str, sp.Symbol],
    where: str,
) -> Any:
    value = values.get(symbol, values.get(symbol.name, symbol.name))
    if isinstance(value, str):
        if value in arm_symbols:
            return arm_symbols[value]
        # l_1 and L1 are called alike, but for the way of writing.
        bare = value.replace("_", "").lower()
        close = [name for name in arm_symbols if name.replace("_", "").lower() == bare]
        if not close:
            meant = find_meant_symbols(value, arm_symbols)
            like = difflib.get_close_matches(value, arm_symbols, n=MOST_NAMED, cutoff=NEAR)
            close = list(dict.fromkeys((*meant, *like)))[:MOST_NAMED]
        near = f"near it: {', '.join(close)}" if close else f"there are {', '.join(arm_symbols)}"
        reason = f"is not a quantity of the arm; give its value, or its name ({near})"
        raise InputError(where, symbol.name, None if value == symbol.name else value, reason)
    if isinstance(value, Real | sp.Number) and sp.sympify(value).is_finite:
        return sp.Rational(*Fraction(float(value)).as_integer_ratio())
    raise InputError(where, symbol.name, value, "must be a number, or the name of a quantity")


def express_in_numbers(expression: sp.Matrix, arm: Arm) -> sp.ImmutableMatrix:
    """An expression in the arm's symbols with its numbers, rounded only when it is evaluated."""
    numbers = {
        symbol: sp.Float(float(value)) if value.denominator > 1 else sp.Integer(value)
        for symbol, value in _list_quantities(arm).items()
    }
    return sp.ImmutableMatrix(expression.xreplace(numbers))
