"""Terms, errors and explanations as people write them, and as TeX."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Literal

import numpy as np
import sympy as sp

from crosscheck.trial.diagnose.candidates import Candidate
from crosscheck.trial.diagnose.polynomial import (
    Entry,
    Monomial,
    Powers,
    Product,
    TermKey,
    power_text,
)
from crosscheck.trial.diagnose.reference_terms import ReferenceTerms, rate_name
from crosscheck.trial.diagnose.values import ORDER, named
from crosscheck.trial.input.equations import Symbolic
from crosscheck.trial.judge.places import EntryPlace, Term, TermError, Wrong

MOST_TERMS = 4  # of a sum that is written out
GREEK = ("theta", "phi", "alpha", "beta", "gamma", "psi", "omega")
ROUNDING = 1e-12  # of a coefficient's parts, beside which their sum is nothing


def error_of(candidate: Candidate, terms: ReferenceTerms) -> TermError:
    """The error that a candidate is, as it is told to the user."""
    term, yours, right = term_of(candidate.products, terms), candidate.yours, candidate.right
    if candidate.kind == "angle" and candidate.key is not None:
        yours, right = _trig(candidate.key, terms), _trig(candidate.products[0].key, terms)
        yours = yours if candidate.by == 1.0 else f"-{yours}"
    elif candidate.key is not None:
        yours, right = candidate.key.signal, candidate.products[0].key.signal
    return TermError(candidate.kind, term, yours, right, candidate.by)


def term_of(products: Entry, terms: ReferenceTerms) -> Term:
    """Terms that belong together as one, before one wave or (their angle then untold) several."""
    keys = list(dict.fromkeys(product.key for product in products))
    latex = _joined(product_latex(p, terms) for p in products[:MOST_TERMS])
    latex += r" + \dots" if len(products) > MOST_TERMS else ""
    if len(keys) > 1:
        text = " + ".join(written(term_of((p,), terms)) for p in products[:MOST_TERMS])
        return Term(_cut(text, products), latex=latex)
    key, text = keys[0], coefficient_text(products)
    sign, angle = angle_text(key, terms)
    if key.function == "sin" and sign < 0:
        text = text[1:] if text.startswith("-") else f"-{text}"
    wave: Literal["", "cos", "sin"] = "cos" if key.function == "cos" else "sin"
    return Term(text, wave if angle else "", angle, key.signal, latex)


def coefficient_text(products: Entry) -> str:
    """The sum of the terms' coefficients as text, what all have in common before it."""
    if len(products) == 1:
        return monomial_text(products[0].monomial)
    powers = [dict(product.monomial.powers) for product in products]
    least = {name: min(each.get(name, 0) for each in powers) for name in powers[0]}
    shared = {name: power for name, power in least.items() if power > 0}
    rests = []
    for number, own in (product.monomial for product in products[:MOST_TERMS]):
        rest = ((name, power - shared.get(name, 0)) for name, power in own)
        rests.append(Monomial(number, tuple((name, power) for name, power in rest if power)))
    inside = _cut(_joined(map(monomial_text, rests)), products)
    common = monomial_text(Monomial(1, tuple(shared.items()))) if shared else ""
    return f"{common} ({inside})".strip()


def monomial_text(monomial: Monomial) -> str:
    """A monomial as text: number, masses, lengths, such as 2 m_payload L1 d2, with fractions."""
    number = monomial.number
    front = f"{number:.6g}" if isinstance(number, float) else str(Fraction(number))
    ordered = _sorted(monomial.powers)
    above = [power_text(name, power) for name, power in ordered if power > 0]
    below = [power_text(name, -power) for name, power in ordered if power < 0]
    if above and front in ("1", "-1"):
        front = front[:-1]
    text = (front + " " if front not in ("", "-") else front) + " ".join(above)
    under = " ".join(below)
    return text.strip() + (f"/({under})" if len(below) > 1 else f"/{under}" if below else "")


def angle_text(key: TermKey, terms: ReferenceTerms) -> tuple[int, str]:
    """The sign that a sine takes, and the angle sum in the user's coordinates, first positive."""
    if not any(key.wave):
        return 1, ""
    turned, names = np.array(key.wave) @ terms.angles, terms.names
    if not np.allclose(turned, np.round(turned)):
        turned, names = np.array(key.wave), tuple(f"theta_{j + 1}" for j in range(len(key.wave)))
    whole = [round(entry) for entry in turned.tolist()]
    sign = 1 if next((entry for entry in whole if entry), 1) > 0 else -1
    parts = [(sign * entry, name) for entry, name in zip(whole, names, strict=True) if entry]
    once = {1: "", -1: "-"}
    return sign, _joined(f"{once.get(number, f'{number} ')}{name}" for number, name in parts)


def _joined(parts: Iterable[str]) -> str:
    """The sum of texts, which may begin with a minus."""
    return " + ".join(parts).replace("+ -", "- ")


def _cut(text: str, products: Sequence[object]) -> str:
    more = len(products) - MOST_TERMS
    return f"{text} + {more} more" if more > 0 else text


def _sorted(powers: Powers) -> list[tuple[str, int]]:
    def order(power: tuple[str, int]) -> tuple[int, int]:
        own = named(power[0])
        return ORDER.get(own.stem, len(ORDER)), own.joint

    return sorted(powers, key=order)


def _trig(key: TermKey, terms: ReferenceTerms) -> str:
    sign, angle = angle_text(key, terms)
    if not angle:
        return "1"
    return f"{'-' if key.function == 'sin' and sign < 0 else ''}{key.function}({angle})"


def written(term: Term) -> str:
    """A term in one line, such as m_payload L1 d2 cos(theta_2)."""
    wave = f"{term.wave}({term.angle})" if term.wave else ""
    behind = " ".join(filter(None, (wave, term.signal)))
    if behind and term.coefficient in ("1", "-1"):
        return term.coefficient[:-1] + behind
    return f"{term.coefficient} {behind}".strip()


def latex_name(name: str) -> str:
    """A symbol or coordinate as TeX: m_{payload}, L_{1}, \\theta_{1}, F_{sp1}; a rate dotted."""
    if name.endswith("'"):
        return rf"\dot{{{latex_name(name[:-1])}}}"
    stem, _, index = name.partition("_")
    number = re.search(r"\d+$", stem)
    if number:
        stem, index = stem[: number.start()], number.group() + (f",{index}" if index else "")
    index = index.replace("_", ",")
    base = rf"\{stem}" if stem in GREEK else stem
    return f"{base}_{{{index}}}" if index else base


def monomial_latex(monomial: Monomial) -> str:
    """A monomial as TeX that matplotlib can set."""
    parts = [
        latex_name(name) + (f"^{{{power}}}" if power != 1 else "")
        for name, power in _sorted(monomial.powers)
    ]
    if isinstance(monomial.number, float):
        return rf"{monomial.number:.6g}\," + r"\,".join(parts)
    number = Fraction(monomial.number)
    sign, size = "-" if number < 0 else "", abs(number)
    front = rf"\frac{{{size.numerator}}}{{{size.denominator}}}"
    if size.denominator == 1:
        front = "" if size == 1 and parts else str(size.numerator)
    return sign + r"\,".join(filter(None, (front, *parts)))


def product_latex(product: Product, terms: ReferenceTerms) -> str:
    """A term as TeX."""
    key, (number, powers) = product
    sign, angle = angle_text(key, terms)
    turned = re.sub(r"[A-Za-z]\w*", lambda found: latex_name(found[0]), angle)
    wave = rf"\{key.function}({turned})" if angle else ""
    behind = r"\,".join(filter(None, (wave, latex_name(key.signal) if key.signal else "")))
    negated = angle and key.function == "sin" and sign < 0
    plain = monomial_latex(Monomial(-1 * number if negated else number, powers))
    if behind and plain in ("1", "-1"):
        return plain[:-1] + behind
    return r"\,".join(filter(None, (plain, behind)))


def told(error: TermError) -> str:
    """An error in words, yours against what is right."""
    term = written(error.term)
    if error.kind == "dropped":
        return f"missing term: {term}"
    if error.kind == "sign":
        return f"yours has {term} with the opposite sign"
    if error.kind == "factor":
        by = f"{error.by:g}" if error.by is not None else error.yours
        return f"yours has {term} times {by}"
    if error.kind == "angle":
        return f"yours has {error.yours} where {error.right} belongs, in {term}"
    if error.kind == "extra":
        return f"extra term: {term}"
    # missing term: m (L2 - d2) L1: where one symbol stands for another in one product.
    coefficient, right, yours = error.term.coefficient, error.right, error.yours
    found = re.search(rf"(?<!\S){re.escape(right)}(\^\d+)?(?!\S)", coefficient)
    if found is None or "(" in coefficient or not yours.isidentifier():
        return f"{yours} where {right} belongs, in {term}"
    power = found[1] or ""
    inside = f"({right}{power} - {yours}{power})"
    short = coefficient[: found.start()] + inside + coefficient[found.end() :]
    missing = written(replace(error.term, coefficient=short))
    return f"missing term: {missing}; {yours} where {right} belongs"


def difference_of(coefficients: Mapping[TermKey, float], terms: ReferenceTerms) -> tuple[Term, ...]:
    """Yours minus right as terms: numbers before waves and signals, the largest first."""
    numbers = {key: float(f"{value:.4g}") for key, value in coefficients.items()}
    return tuple(
        term_of((Product(key, Monomial(numbers[key], ())),), terms)
        for key in sorted(numbers, key=lambda key: -abs(numbers[key]))
    )


def guess(wrong: Wrong) -> str:
    """What is wrong in an entry, as a question, for it is a guess; or its difference."""
    found = wrong.explanation
    if found is None:
        shown = _cut(_joined(map(written, wrong.difference[:MOST_TERMS])), wrong.difference)
        said = f"yours minus right is {shown}; " if shown else ""
        return f"{said}no error in few of its terms makes this difference"
    each = ("; and ".join(map(told, errors)) for errors in (found.errors, *found.others[:1]))
    return "; or ".join(each) + (f", in {found.seen_in}?" if found.seen_in else "?")


def symbolic_difference(
    place: EntryPlace, symbolic: Symbolic, terms: ReferenceTerms, values: Mapping[str, float]
) -> sp.Expr | None:
    """Yours minus right in sympy: sines and cosines of sums, rates and torques by trial's names.

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
    total, numbers = sp.S.Zero, {sp.Symbol(name): value for name, value in values.items()}
    for angle in {-a if a.could_extract_minus_sign() else a: None for a in waves}:
        up, down = waves.get(angle, sp.S.Zero), waves.get(-angle, sp.S.Zero)
        pair = ((up + down, sp.cos(angle)), (sp.I * (up - down), sp.sin(angle)))
        for coefficient, wave in pair if angle != 0 else ((up, sp.S.One),):
            there = sp.expand(coefficient)
            known = numbers | dict.fromkeys(there.free_symbols - set(numbers), 1.0)  # signals
            sizes = [complex(p.xreplace(known)) for p in sp.Add.make_args(there)]
            if abs(sum(sizes)) > ROUNDING * sum(map(abs, sizes)):
                total += sp.factor_terms(there) * wave
    for rate in place.rates or ():
        total *= sp.Symbol(rate_name(terms.names[rate]))
    return total if total != 0 else None


def _entry(place: EntryPlace, symbolic: Symbolic) -> sp.Expr | None:
    """The user's entry in the names of the trial; None without; of a bias what its rates have."""
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
    """A term of the reference as a sympy expression."""
    key, (number, powers) = product
    turned = [
        sum(w * a for w, a in zip(key.wave, column, strict=True)) for column in terms.angles.T
    ]
    angle = sum(sp.nsimplify(w) * own for w, own in zip(turned, x, strict=True))
    wave = sp.sin(angle) if key.function == "sin" else sp.cos(angle)
    signal = sp.Symbol(key.signal) if key.signal else sp.S.One
    symbols = sp.prod([sp.Symbol(name) ** power for name, power in powers])
    return sp.sympify(number) * symbols * wave * signal


def latex_of(expression: sp.Expr) -> str:
    """A sympy expression as TeX that matplotlib can set."""
    names = {symbol: latex_name(symbol.name) for symbol in expression.free_symbols}
    text = str(sp.latex(expression, symbol_names=names))
    return text.replace(r"\left", "").replace(r"\right", "")
