"""The energies from which SymPy derives equations, as code that an edit is judged by in no time.

Idea: whoever derives equations by Lagrange forms T and V, or T - V, and differentiates. Difficulty:
these derivatives take seconds, so hardly any edit could be tried. Remedy: the code up to the energy
is code of its own, of which M is the second derivative by the rates, and gravity the first by the
coordinates at rest. Its edits take milliseconds; what makes it right is tried on the whole. Numbers
of symbols that are stated further down are part of it.
"""

from __future__ import annotations

import ast
import copy
import functools
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import permutations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.trial.input.equations import Equations, Symbolic
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.syntax import Scope, SourceTree

if TYPE_CHECKING:
    import sympy as sp

SEED = 5  # of the numbers at which expressions are compared
CLOSE = 1e-8  # relative difference of expressions that are the same
STEP = 1e-30  # of complex steps
BindSymbols = Callable[[Equations], Equations]


@dataclass(frozen=True)
class Energies:
    """The variables of a code that are its energies, and the code that ends with them.

    last_line: of the statement that completes them.
    """

    code: UserCode
    last_line: int


class _Roles(NamedTuple):
    """Names of the variables of which M and gravity are derivatives, and gravity's sign."""

    kinetic: str = ""
    potential: str = ""
    sign: int = 1


def find_energies(
    tree: SourceTree, equations: Equations, bind_symbols: BindSymbols | None
) -> Energies | None:
    """The energies of a code that has run under observation; None if it has none.

    equations: as the code makes them, with their symbols; bind_symbols: as in AnswerKey.
    """
    stated = _state_gravity(equations.symbolic)
    code, top = tree.code, tree.scopes[id(tree.code.statements[0])]
    factory = ""
    with suppress(KeyError):  # of a name that a function around it has
        factory = getattr(code.select(top.values), "__name__", "")
    factories = [tree.functions[factory]] if factory in tree.functions else []
    for scope in (top, *factories):
        symbolic = stated or _recognize_symbols(scope, equations)
        if symbolic is None:
            continue
        values = dict(_list_expressions(scope, symbolic.x, symbolic.v))
        roles = _find_roles(values, symbolic)
        names = [name for name in roles[:2] if name]
        body = getattr(scope.node, "body", None) or code.statements
        end = _find_assignment(body, names)
        if end is not None:
            make = functools.partial(
                _make_equations,
                equations=replace(equations, symbolic=equations.symbolic or symbolic),
                roles=roles,
                bind_symbols=bind_symbols,
            )
            numbers = (n for n, each in scope.values.items() if _is_equal(each, symbolic.values))
            return _cut_code(code, scope, end, [*dict.fromkeys(names)], next(numbers, ""), make)
    return None


def _recognize_symbols(scope: Scope, equations: Equations) -> Symbolic | None:
    """The symbols behind functions that SymPy wrote, and the M and gravity of their energies.

    Two lists of a function are the coordinates and rates if one of its expressions has the answers
    of the equations' functions at a place as its derivatives by them. Numbers of its other symbols
    may be in a dictionary.
    """
    import sympy as sp

    values = list(scope.list_values().values())
    tables = [each for each in values if isinstance(each, dict) and _are_numbers(each.values())]
    listed = (tuple(each) for each in values if isinstance(each, list | tuple | sp.MatrixBase))
    vectors = {each: None for each in listed if all(isinstance(s, sp.Symbol) for s in each)}
    energies = [each for each in scope.values.values() if isinstance(each, sp.Expr)]
    for x, v in permutations(vectors, 2) if energies else ():
        place = np.linspace(0.5, 1.5, len(x))
        here = dict(zip(x, map(float, place), strict=True))
        symbolic = Symbolic(x, v)
        with suppress(Exception):  # of functions that ask for something else
            for energy in energies if len(x) == len(v) else ():
                mass = _differentiate_twice(energy, v)
                weights = _differentiate_at_rest(energy, symbolic)
                others = energy.free_symbols - {*x, *v}
                table = next(each for each in ({}, *tables) if others <= {*_use_numbers(each)})
                numbers = here | _use_numbers(table)
                for part, slopes in (
                    ("mass_matrix", mass),
                    ("gravity", weights),
                    ("gravity", -weights),
                ):
                    function = getattr(equations, part)
                    if function and _is_same(slopes.xreplace(numbers), sp.Matrix(function(place))):
                        symbolic = replace(symbolic, values=table, **{part: slopes})
        if symbolic != Symbolic(x, v):
            return symbolic
    return None


def _are_numbers(values: Iterable[Any]) -> bool:
    return all(isinstance(each, int | float | np.floating) for each in values)


def _use_numbers(numbers: Mapping[Any, float | str]) -> dict[Any, float | str]:
    """Numbers by symbols, for those that a dictionary has by their names."""
    import sympy as sp

    return {sp.Symbol(n) if isinstance(n, str) else n: each for n, each in numbers.items()}


def _is_equal(value: Any, numbers: Mapping[Any, float | str]) -> bool:
    """Whether a variable is the numbers of all symbols."""
    return isinstance(value, dict) and bool(numbers) and value == numbers


def _state_gravity(symbolic: Symbolic | None) -> Symbolic | None:
    """The expressions with their gravity, which a force holds at rest without torques."""
    if symbolic is None or symbolic.gravity is not None or symbolic.force is None:
        return symbolic
    import sympy as sp

    rest = dict.fromkeys((*symbolic.v, *symbolic.torque), sp.Integer(0))
    return replace(symbolic, gravity=-symbolic.force.xreplace(rest))


def _list_expressions(
    scope: Scope, x: Sequence[sp.Symbol], v: Sequence[sp.Symbol]
) -> Iterator[tuple[str, sp.Expr]]:
    """The scalar expressions that a function's variables are, in the symbols of the equations."""
    import sympy as sp

    for name, value in scope.values.items():
        if not isinstance(value, sp.Expr) or hasattr(value, "shape"):  # a matrix may be one
            continue
        plain = _use_plain_symbols(value, x, v)
        if plain is not None and plain.free_symbols & {*x, *v}:
            yield name, plain


def _use_plain_symbols(
    value: sp.Expr, x: Sequence[sp.Symbol], v: Sequence[sp.Symbol]
) -> sp.Expr | None:
    """An expression with symbols for functions of time, by name, or else in the names' order."""
    import sympy as sp
    from sympy.core.function import AppliedUndef

    names = list(map(str, x))
    functions = sorted(
        value.atoms(AppliedUndef),
        key=lambda each: (
            names.index(str(each.func)) if str(each.func) in names else len(names),
            _split_digits(str(each.func)),
        ),
    )
    if not functions:
        return value
    if len(functions) != len(x):
        return None
    time = functions[0].args[0]
    rates = {each.diff(time): rate for each, rate in zip(functions, v, strict=True)}
    plain = value.xreplace(rates).xreplace(dict(zip(functions, x, strict=True)))
    return None if plain.atoms(sp.Derivative) else plain


def _split_digits(name: str) -> list[Any]:
    return [int(each) if each.isdigit() else each for each in re.split(r"(\d+)", name)]


def _find_roles(values: Mapping[str, sp.Expr], symbolic: Symbolic) -> _Roles:
    """Which variables have M and gravity of the equations as their derivatives.

    One that has both, T - V, comes before two.
    """
    kinetic, potential = list[str](), dict[str, int]()
    for name, value in values.items():
        if symbolic.mass_matrix is not None:
            mass = _differentiate_twice(value, symbolic.v)
            if _is_same(mass, symbolic.mass_matrix):
                kinetic.append(name)
        for sign in (1, -1) if symbolic.gravity is not None else ():
            if _is_same(sign * _differentiate_at_rest(value, symbolic), symbolic.gravity):
                potential[name] = sign
    both = [name for name in kinetic if name in potential]
    if both:
        return _Roles(both[0], both[0], potential[both[0]])
    second = next(iter(potential), "")
    return _Roles(next(iter(kinetic), ""), second, potential.get(second, 1))


def _differentiate_twice(value: sp.Expr, rates: Sequence[sp.Symbol]) -> sp.Matrix:
    import sympy as sp

    slopes = [value.diff(rate) for rate in rates]
    return sp.Matrix([[slope.diff(rate) for rate in rates] for slope in slopes])


def _differentiate_at_rest(value: sp.Expr, symbolic: Symbolic) -> sp.Matrix:
    import sympy as sp

    rest = value.xreplace(dict.fromkeys(symbolic.v, sp.Integer(0)))
    return sp.Matrix([rest.diff(each) for each in symbolic.x])


def _is_same(matrix: sp.Matrix, other: sp.Matrix) -> bool:
    """Whether two matrices have the same values at random numbers, not all of them 0."""
    symbols = sorted(matrix.free_symbols | other.free_symbols, key=str)
    draws = np.random.default_rng(SEED).uniform(0.5, 1.5, len(symbols))
    numbers = dict(zip(symbols, map(float, draws), strict=True))
    try:
        first, second = (
            np.array(each.xreplace(numbers).evalf().tolist(), dtype=float)
            for each in (matrix, other)
        )
    except TypeError:  # the rest has no number
        return False
    size = np.max(np.abs(second))
    return bool(size > 0 and np.max(np.abs(first - second)) <= CLOSE * size)


def _find_assignment(body: Sequence[ast.stmt], names: Sequence[str]) -> int | None:
    """Find the last statement of a body that assigns one of some names."""
    storing = [
        number
        for number, statement in enumerate(body)
        for each in ast.walk(statement)
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store) and each.id in names
    ]
    return max(storing, default=None)


def _list_needed(statements: Sequence[ast.stmt]) -> list[ast.stmt]:
    """The last of some statements, after those that give values to names in it."""
    needed, kept = set[str](), list[ast.stmt]()
    for statement in reversed(statements):
        names = [each for each in ast.walk(statement) if isinstance(each, ast.Name)]
        stored = {each.id for each in names if isinstance(each.ctx, ast.Store)}
        if not kept or stored & needed:
            kept.insert(0, statement)
            needed |= {each.id for each in names} - stored
    return kept


def _cut_code(
    code: UserCode,
    scope: Scope,
    end: int,
    names: Sequence[str],
    numbers: str,
    make: Callable[[Sequence[Any]], Equations],
) -> Energies:
    """The code that ends with its energies, of the same statements, and makes equations of them.

    numbers: name of the symbols' numbers, '' of none; stated behind the energies they are kept.
    """
    body = getattr(scope.node, "body", None) or code.statements
    line, stating = body[end].end_lineno or body[end].lineno, _find_assignment(body, [numbers])
    kept = [*body[: end + 1], *_list_needed(body[end + 1 : (stating or end) + 1])]

    def select(defined: Mapping[str, Any]) -> Any:
        return make([*(defined[name] for name in names), defined.get(numbers)])

    if not isinstance(scope.node, ast.FunctionDef):
        return Energies(replace(code, statements=kept, select=select), line)

    shorter = copy.copy(scope.node)
    answer = ast.parse(f"return [{', '.join(names)}, {numbers or None}]").body[0]
    shorter.body = [*kept, ast.copy_location(answer, kept[-1])]
    ast.fix_missing_locations(shorter)
    statements = [shorter if each is scope.node else each for each in code.statements]

    def select_factory(defined: Mapping[str, Any]) -> Any:
        factory = defined[shorter.name]

        @functools.wraps(factory)
        def make_equations(*arguments: Any, **more: Any) -> Equations:
            return make(factory(*arguments, **more))

        return make_equations

    return Energies(replace(code, statements=statements, select=select_factory), line)


def _make_equations(
    values: Sequence[Any],
    *,
    equations: Equations,
    roles: _Roles,
    bind_symbols: BindSymbols | None,
) -> Equations:
    """Equations with M and gravity of the energies, of whose values they are differences.

    values: the energies, then the numbers of their symbols or None. The energies take the places of
    a bias and of a force, by which a mechanism's numbers get into them.
    """
    import sympy as sp

    from crosscheck.trial.input.symbolic import from_sympy

    symbolic, coordinates = equations.symbolic, equations.coordinates
    assert symbolic is not None  # as the caller has seen
    x, v, (*energies, numbers) = symbolic.x, symbolic.v, values
    zeros = [sp.Integer(0)] * (len(x) - 1)
    expressions = [_use_plain_symbols(sp.sympify(each), x, v) for each in energies]
    if None in expressions:
        raise ValueError("an edit's energy is not one of the coordinates and rates")
    kinetic, potential = (sp.Matrix([expressions[place], *zeros]) for place in (0, -1))
    stated = _use_numbers(symbolic.values if numbers is None else numbers)
    inner = from_sympy(x, v, bias=kinetic, force=potential, values=stated, coordinates=coordinates)

    def complete(bound: Equations) -> Equations:
        """The equations of energies that are bound to a mechanism."""
        assert bound.bias is not None  # as inner has both
        assert bound.force is not None
        mass = functools.partial(_compute_mass_matrix, bound.bias)
        gravity = functools.partial(_compute_gravity, bound.force, roles.sign)
        return Equations(
            mass_matrix=(lambda x: mass(x)) if roles.kinetic else None,
            gravity=(lambda x: gravity(x)) if roles.potential else None,
            coordinates=bound.coordinates,
        )

    if bind_symbols is not None:
        return complete(bind_symbols(inner))

    def rebuild(arm: Arm, scenario: Scenario | None) -> Equations:
        return complete(inner.adapt_to_arm(arm, scenario))

    return Equations(bias=inner.bias, coordinates=inner.coordinates, rebuild=rebuild)


def _compute_mass_matrix(energy: Callable[..., np.ndarray], x: np.ndarray) -> np.ndarray:
    """M of an energy that is quadratic in v: of the energies of two rates, less those of each.

    Raises ValueError for one that is another at opposite rates: what is linear in them is in no M.
    """
    unit = np.eye(len(x))

    def evaluate(v: np.ndarray) -> float:
        return float(energy(x, v)[0, 0])

    rest, single, opposite = evaluate(0 * x), [*map(evaluate, unit)], [*map(evaluate, -unit)]
    if not np.allclose(single, opposite, rtol=CLOSE, atol=0.0):
        raise ValueError("a kinetic energy is the same at opposite rates")
    both = np.array([[evaluate(a + b) for b in unit] for a in unit])
    return both - np.add.outer(single, single) + rest


def _compute_gravity(energy: Callable[..., np.ndarray], sign: int, x: np.ndarray) -> np.ndarray:
    """The slopes of an energy at rest, by complex steps, which lose no digits."""
    steps = x + 1j * STEP * np.eye(len(x))
    slopes = [np.imag(energy(0.0, step, 0 * x)[0, 0]) / STEP for step in steps]
    return sign * np.array(slopes)
