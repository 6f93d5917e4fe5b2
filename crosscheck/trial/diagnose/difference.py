"""Yours minus right of an entry of symbolic equations, as an expression and typeset."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import sympy as sp

from crosscheck.trial.diagnose.force_terms import rate_name
from crosscheck.trial.diagnose.polynomial import Product
from crosscheck.trial.diagnose.reference_terms import ReferenceTerms
from crosscheck.trial.diagnose.words import latex_name
from crosscheck.trial.input.equations import Symbolic
from crosscheck.trial.judge.places import EntryPlace

ROUNDING = 1e-12  # of a coefficient's parts, beside which their sum is nothing


def symbolic_difference(
    place: EntryPlace, symbolic: Symbolic, terms: ReferenceTerms, values: Mapping[str, float]
) -> sp.Expr | None:
    """Yours minus right, sines and cosines of sums, with rates and torques by the trial's names.

    None where there is no such part, or it has other functions of coordinates, as mesh forces that
    are not symbols are. values: of the arm's quantities; what vanishes with them is left out.
    """
    yours = _entry(place, symbolic)
    if yours is None:
        return None
    x = [sp.Symbol(name) for name in terms.names]
    right = sum((_right(product, terms, x) for product in terms.entry(place)), sp.S.Zero)
    waves: defaultdict[sp.Expr, sp.Expr] = defaultdict(lambda: sp.S.Zero)
    for part in sp.Add.make_args(sp.expand((yours - right).rewrite(sp.exp))):
        coefficient, moving = part.as_independent(*x, as_Add=False)
        factors = [factor for factor in sp.Mul.make_args(moving) if factor != 1]
        if not all(isinstance(factor, sp.exp) for factor in factors):
            return None
        waves[sp.expand(sum(f.exp for f in factors) / sp.I)] += coefficient
    total = sp.S.Zero
    for angle in {-a if a.could_extract_minus_sign() else a: None for a in waves}:
        up, down = waves.get(angle, sp.S.Zero), waves.get(-angle, sp.S.Zero)
        pair = ((up + down, sp.cos(angle)), (sp.I * (up - down), sp.sin(angle)))
        for coefficient, wave in pair if angle != 0 else ((up, sp.S.One),):
            there = sp.expand(coefficient)
            if not _vanishes(there, values):
                total += sp.factor_terms(there) * wave
    for rate in place.rates or ():
        total *= sp.Symbol(rate_name(terms.names[rate]))
    return total if total != 0 else None


def _entry(place: EntryPlace, symbolic: Symbolic) -> sp.Expr | None:
    """The user's entry, of a bias that of its rates, in the names of the trial."""
    whole = getattr(symbolic, place.part)
    if whole is None:
        return None
    entry = sp.Matrix(whole)[place.row, place.column if place.column is not None else 0]
    if place.rates is not None:
        j, k = place.rates
        entry = sp.diff(entry, symbolic.v[j], symbolic.v[k]) / (2 if j == k else 1)
    names: dict[sp.Symbol, float | str] = {symbol: symbol.name for symbol in entry.free_symbols}
    names |= symbolic.values
    names |= {v: rate_name(q.name) for q, v in zip(symbolic.x, symbolic.v, strict=True)}
    names |= {torque: f"T_{j + 1}" for j, torque in enumerate(symbolic.torque)}
    own = {s: sp.Symbol(n) if isinstance(n, str) else sp.Float(n) for s, n in names.items()}
    return entry.xreplace(own)


def _right(product: Product, terms: ReferenceTerms, x: list[sp.Symbol]) -> sp.Expr:
    """A term of the reference's."""
    key, (number, powers) = product
    turned = [
        sum(w * a for w, a in zip(key.wave, column, strict=True)) for column in terms.angles.T
    ]
    angle = sum(sp.nsimplify(w) * own for w, own in zip(turned, x, strict=True))
    wave = sp.sin(angle) if key.function == "sin" else sp.cos(angle)
    signal = sp.Symbol(key.signal) if key.signal else sp.S.One
    symbols = sp.prod([sp.Symbol(name) ** power for name, power in powers])
    return sp.sympify(number) * symbols * wave * signal


def _vanishes(coefficient: sp.Expr, values: Mapping[str, float]) -> bool:
    numbers = {sp.Symbol(name): value for name, value in values.items()}
    signals = dict.fromkeys(coefficient.free_symbols - set(numbers), 1.0)
    parts = [complex(p.xreplace(numbers | signals)) for p in sp.Add.make_args(coefficient)]
    return abs(sum(parts)) <= ROUNDING * sum(map(abs, parts))


def latex_of(expression: sp.Expr) -> str:
    """As TeX that matplotlib can set."""
    names = {symbol: latex_name(symbol.name) for symbol in expression.free_symbols}
    text = str(sp.latex(expression, symbol_names=names))
    return text.replace(r"\left", "").replace(r"\right", "")
