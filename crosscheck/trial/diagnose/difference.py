"""Symbolic equations of motion: yours minus right, entry by entry, and the error in it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from crosscheck.trial.diagnose.explain import Observed, explain
from crosscheck.trial.diagnose.force_terms import rate_name
from crosscheck.trial.diagnose.keys import Key, Wave
from crosscheck.trial.diagnose.polynomial import Monomial, from_sympy
from crosscheck.trial.diagnose.reference_terms import ReferenceTerms
from crosscheck.trial.diagnose.values import related, unrelated
from crosscheck.trial.diagnose.words import latex_name
from crosscheck.trial.input.equations import Symbolic
from crosscheck.trial.judge.places import Explanation, Place

ARMS = 3  # sets of numbers that the same error must explain
ROUNDING = 1e-12  # of yours and right, beside which their difference is nothing
Waves = dict[Key, sp.Expr]  # coefficients before waves of x, and signals
Exponentials = dict[Wave, sp.Expr]  # before exp(i w . x)


class NotWaves(ValueError):
    """An expression that is no sum of cosines and sines of whole sums of coordinates."""


@dataclass(frozen=True)
class Difference:
    """Yours minus right of an entry, as typeset, and the errors that make it.

    observed: its coefficients with several sets of numbers.
    """

    expression: sp.Expr
    latex: str
    observed: tuple[Observed, ...]
    explanation: Explanation | None


def symbolic_difference(
    place: Place, symbolic: Symbolic, terms: ReferenceTerms, values: Mapping[str, float]
) -> Difference | None:
    """What is wrong in an entry, or None where nothing is. values: of the arm's quantities.

    Raises NotWaves where it cannot be taken apart: it must be made of sums, products, whole powers,
    cosines and sines of whole sums of coordinates; a force also linear in rates and torques, its
    mesh forces being symbols that ``values`` calls by their names; and all its other symbols
    quantities of the arm.
    """
    yours, right = entry_waves(place, symbolic, terms), right_waves(place, terms)
    _require_meshes(place, symbolic, terms)
    unknown = {s.name for c in yours.values() for s in c.free_symbols} - set(values)
    if unknown:
        raise NotWaves(f"{', '.join(sorted(unknown))} are no quantities of the arm")
    numeric = any(not isinstance(value, str) for value in symbolic.values.values())
    sets = [dict(values)] if numeric else [related(values, seed) for seed in range(ARMS)]
    observed = _observed(yours, right, sets, terms)
    wrong = {key for each in observed for key, off in each.coefficients.items() if off}
    if not wrong:
        return None
    # What is one thing by the arm's geometry, r_s + r_p and r_cp, may be told apart as written.
    written = _observed(yours, right, [] if numeric else [unrelated(values)], terms)
    explanation = explain(place, (*observed, *written), terms)
    if explanation is not None:
        observed = (*observed, *written)
    else:
        explanation = explain(place, observed, terms)
    parts = {
        key: sp.expand(yours.get(key, 0) - right.get(key, 0))
        for key in {**yours, **right}
        if _by_joints(key, terms.angles)[0] in wrong
    }
    expression = _expression(parts, place, terms.names)
    return Difference(expression, latex_of(expression), observed, explanation)


def _observed(
    yours: Waves, right: Waves, sets: Sequence[Mapping[str, float]], terms: ReferenceTerms
) -> tuple[Observed, ...]:
    """Differences with sets of numbers, before waves of the joint angles; rounding is none."""
    coefficients: list[dict[Key, float]] = [{} for _ in sets]
    noise: list[dict[Key, float]] = [{} for _ in sets]
    for key in {**yours, **right}:
        own, sign = _by_joints(key, terms.angles)
        mine, theirs = (_evaluated(c.get(key, sp.S.Zero), sets) for c in (yours, right))
        for place, ((a, size_a), (b, size_b)) in enumerate(zip(mine, theirs, strict=True)):
            rounding = ROUNDING * (size_a + size_b)
            coefficients[place][own] = sign * (a - b) if abs(a - b) > rounding else 0.0
            noise[place][own] = rounding
    return tuple(map(Observed, sets, coefficients, noise))


def _evaluated(
    coefficient: sp.Expr, sets: Sequence[Mapping[str, float]]
) -> list[tuple[float, float]]:
    """With sets of numbers, and the size of its parts."""
    polynomial = from_sympy(coefficient)
    if polynomial is None:
        found = [float(sp.re(coefficient.subs(numbers))) for numbers in sets]
        return [(value, abs(value)) for value in found]
    parts = [[m.value(numbers) for m in polynomial.monomials] for numbers in sets]
    return [(sum(each), sum(map(abs, each))) for each in parts]


def mesh_signals(terms: ReferenceTerms) -> list[str]:
    """Mesh forces of a planet, and what else of meshes is no polynomial."""
    return [name for name in terms.signals if name[:2] in ("F_", "D_", "Q_")]


def _require_meshes(place: Place, symbolic: Symbolic, terms: ReferenceTerms) -> None:
    """Raise NotWaves if a force that should have mesh forces has no symbol for any."""
    meshes = set(mesh_signals(terms))
    if place.part == "force" and meshes:
        own = sp.Matrix(symbolic.force).free_symbols
        if not meshes & {str(symbolic.values.get(symbol, symbol)) for symbol in own}:
            raise NotWaves("mesh forces are no symbols")


def entry_waves(place: Place, symbolic: Symbolic, terms: ReferenceTerms) -> Waves:
    """An entry of the user's, of a bias that of its rates. Raises NotWaves."""
    whole = getattr(symbolic, place.part)
    if whole is None:
        raise NotWaves(f"there is no {place.part}")
    column = place.column if place.column is not None else 0
    entry = sp.Matrix(whole)[place.row, column]
    if place.rates is not None:
        j, k = place.rates
        entry = sp.diff(entry, symbolic.v[j], symbolic.v[k]) / (2 if j == k else 1)
    if place.part != "force":
        return _waves(entry, symbolic, "")
    signals = {rate: rate_name(x.name) for x, rate in zip(symbolic.x, symbolic.v, strict=True)}
    signals |= {torque: f"T_{j + 1}" for j, torque in enumerate(symbolic.torque)}
    named = {symbol: str(symbolic.values.get(symbol, symbol)) for symbol in entry.free_symbols}
    meshes = mesh_signals(terms)
    signals |= {symbol: name for symbol, name in named.items() if name in meshes}
    still = dict.fromkeys(signals, 0)
    found = _waves(entry.subs(still), symbolic, "")
    for symbol, name in signals.items():
        found |= _waves(sp.diff(entry, symbol), symbolic, name)
    return found


def _waves(entry: sp.Expr, symbolic: Symbolic, signal: str) -> Waves:
    """Cosines and sines of an expression without rates and torques."""
    if entry.free_symbols & {*symbolic.v, *symbolic.torque}:
        raise NotWaves("it is not linear in the torques and rates")
    own = {symbol: symbolic.values.get(symbol, symbol.name) for symbol in entry.free_symbols}
    known = {
        symbol: sp.Symbol(value) if isinstance(value, str) else sp.Float(value)
        for symbol, value in own.items()
        if symbol not in symbolic.x
    }
    whole = exponentials(entry.subs(known), symbolic.x)
    found: Waves = {}
    for wave in {max(w, _minus(w)) for w in whole}:
        up, down = whole.get(wave, sp.S.Zero), whole.get(_minus(wave), sp.S.Zero)
        pair = (("cos", up + down), ("sin", sp.I * (up - down)))
        for function, coefficient in pair if any(wave) else (("cos", up),):
            if (own_part := sp.expand(coefficient)) != 0:
                found[Key(wave, function, signal)] = own_part
    return found


def _minus(wave: Wave) -> Wave:
    return tuple(-entry for entry in wave)


def exponentials(entry: sp.Expr, x: Sequence[sp.Symbol]) -> Exponentials:
    """Coefficients free of x before exp(i w . x). Raises NotWaves."""
    still = (0,) * len(x)
    if not entry.has(*x):
        return {still: entry}
    if isinstance(entry, sp.Add):
        total: defaultdict[Wave, sp.Expr] = defaultdict(lambda: sp.S.Zero)
        for part in entry.args:
            for wave, coefficient in exponentials(part, x).items():
                total[wave] += coefficient
        return dict(total)
    if isinstance(entry, sp.Mul):
        product: Exponentials = {still: sp.S.One}
        for factor in entry.args:
            product = _product(product, exponentials(factor, x))
        return product
    if isinstance(entry, sp.Pow) and entry.exp.is_Integer and entry.exp > 0:
        base, power = exponentials(entry.base, x), {still: sp.S.One}
        for _ in range(int(entry.exp)):
            power = _product(power, base)
        return power
    if isinstance(entry, sp.cos | sp.sin):
        return _exponentials_of(entry, x)
    raise NotWaves(f"{entry.func.__name__} of coordinates")


def _exponentials_of(entry: sp.Expr, x: Sequence[sp.Symbol]) -> Exponentials:
    """Of a cosine or sine."""
    slopes = [sp.diff(entry.args[0], coordinate) for coordinate in x]
    if not all(slope.is_Integer for slope in slopes):
        raise NotWaves(f"{entry} of no whole sum of coordinates")
    wave = tuple(map(int, slopes))
    rest = sp.expand(entry.args[0] - sum(s * own for s, own in zip(slopes, x, strict=True)))
    lead = sp.cos(rest) + sp.I * sp.sin(rest)
    follow = sp.cos(rest) - sp.I * sp.sin(rest)
    if isinstance(entry, sp.sin):
        lead, follow = -sp.I * lead, sp.I * follow
    return {wave: lead / 2, _minus(wave): follow / 2}


def _product(left: Exponentials, right: Exponentials) -> Exponentials:
    total: defaultdict[Wave, sp.Expr] = defaultdict(lambda: sp.S.Zero)
    for a, of_a in left.items():
        for b, of_b in right.items():
            total[tuple(i + j for i, j in zip(a, b, strict=True))] += of_a * of_b
    return dict(total)


def right_waves(place: Place, terms: ReferenceTerms) -> Waves:
    """The reference's entry before waves of x. Raises NotWaves where those are not whole."""
    found: defaultdict[Key, sp.Expr] = defaultdict(lambda: sp.S.Zero)
    for key, monomial in terms.entry(place):
        turned = np.array(key.wave) @ terms.angles
        if not np.allclose(turned, np.round(turned)):
            raise NotWaves("the map is not one of whole numbers")
        wave = tuple(int(entry) for entry in np.round(turned))
        upward = max(wave, _minus(wave))
        sign = -1 if key.function == "sin" and upward != wave else 1
        found[Key(upward, key.function, key.signal)] += sign * expression_of(monomial)
    return dict(found)


def expression_of(monomial: Monomial) -> sp.Expr:
    """In sympy's symbols."""
    return sp.sympify(monomial.number) * sp.prod(
        [sp.Symbol(name) ** power for name, power in monomial.powers]
    )


def _by_joints(key: Key, angles: np.ndarray) -> tuple[Key, int]:
    """A key of x by joint angles; of an angle that is none of theirs, a signal of its own."""
    wave = np.array(key.wave, dtype=float)
    solved = np.round(np.linalg.pinv(angles.T) @ wave)
    still = (0,) * len(angles)
    if not np.allclose(solved @ angles, wave):
        return Key(still, "cos", f"{key.function} {key.wave} {key.signal}"), 1
    own = tuple(int(entry) for entry in solved)
    upward = max(own, _minus(own))
    return Key(
        upward, key.function, key.signal
    ), -1 if own != upward and key.function == "sin" else 1


def _expression(parts: Waves, place: Place, names: Sequence[str]) -> sp.Expr:
    """The difference itself, each coefficient in factors."""
    x = [sp.Symbol(name) for name in names]
    total = sp.S.Zero
    for key, coefficient in parts.items():
        angle = sum(w * own for w, own in zip(key.wave, x, strict=True))
        wave = sp.sin(angle) if key.function == "sin" else sp.cos(angle)
        signal = sp.Symbol(key.signal) if key.signal else 1
        total += sp.factor_terms(coefficient) * wave * signal
    for rate in place.rates or ():
        total *= sp.Symbol(rate_name(names[rate]))
    return total


def latex_of(expression: sp.Expr) -> str:
    """As TeX that matplotlib can set."""
    names = {symbol: latex_name(symbol.name) for symbol in expression.free_symbols}
    text = str(sp.latex(expression, symbol_names=names))
    return text.replace(r"\left", "").replace(r"\right", "")
