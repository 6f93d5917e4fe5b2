"""Terms, errors and explanations as people write them, and notes on entries and numbers."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import replace
from fractions import Fraction
from typing import Literal

import numpy as np

from crosscheck.report.formatting import join_words, list_first
from crosscheck.trial.changes.arms.dependence import IgnoredNumber
from crosscheck.trial.changes.arms.letters import format_power, sort_powers
from crosscheck.trial.changes.arms.polynomial import Monomial, as_polynomial
from crosscheck.trial.changes.arms.segments import EntryTerms, Product, ReferenceTerms, TermKey
from crosscheck.trial.changes.arms.term_changes import MOST_TERMS, WEIGHT, TermChange
from crosscheck.trial.judge.entries import (
    EntryMismatch,
    Term,
    TermError,
    describe_entry_notes,
    format_entry,
    interleave,
    select_counted,
)

MOST_EQUAL = 1  # explanations named beside the first that fit as well


def make_term_error(change: TermChange, terms: ReferenceTerms) -> TermError:
    """The error that a change is, as it is reported to the user."""
    term = Term(change.group) if change.group else make_term(change.terms, terms)
    kind, yours, right = change.kind, change.yours, change.right
    if change.key is not None:
        belongs = change.terms[0].key
        if kind == "angle":
            yours, right = format_wave(change.key, terms), format_wave(belongs, terms)
            yours = yours if change.by == 1.0 else f"-{yours}".removeprefix("--")
        else:
            yours, right = change.key.signal, belongs.signal
    elif kind == "angle":
        keys = dict.fromkeys(product.key for product in change.terms if any(product.key.wave))
        right = " and ".join(format_wave(key, terms) for key in keys)
        yours = yours.format(right)
    elif kind == "extra" and change.terms:
        right = _find_entry(change, terms)
    return TermError(kind, term, yours, right, change.by)


def _find_entry(change: TermChange, terms: ReferenceTerms) -> str:
    """The first entry of the bias in which these are the terms of their wave, in words; or ''."""
    key = change.terms[0].key
    for place, entry in terms.entries.items():
        there = {product for product in entry if product.key == key}
        if place.rates is not None and there == set(change.terms):
            return format_entry(place, terms.names)
    return ""


def make_term(products: EntryTerms, terms: ReferenceTerms) -> Term:
    """Terms that belong together as one, before one wave or several."""
    keys = list(dict.fromkeys(product.key for product in products))
    if len(keys) > 1:
        text = join_terms(format_term(make_term((p,), terms)) for p in products[:MOST_TERMS])
        return Term(_cut(text, products))
    key, text = keys[0], format_coefficient(products)
    sign, angle = format_angle_sum(key, terms)
    if key.function == "sin" and sign < 0:
        text = text[1:] if text.startswith("-") else f"-{text}"
    wave: Literal["", "cos", "sin"] = "cos" if key.function == "cos" else "sin"
    return Term(text, wave if angle else "", angle, key.signal)


def format_coefficient(products: EntryTerms) -> str:
    """The sum of the terms' coefficients as text, what all have in common before it."""
    if len(products) == 1:
        return format_monomial(products[0].monomial)
    powers = [dict(product.monomial.powers) for product in products]
    least = {name: min(each.get(name, 0) for each in powers) for name in powers[0]}
    shared = {name: power for name, power in least.items() if power > 0}
    numbers = [product.monomial.number for product in products]
    whole = [Fraction(number) for number in numbers if not isinstance(number, float)]
    unit = min(map(abs, whole)) if len(whole) == len(numbers) else Fraction(1)
    unit = Fraction(1) if any(number % unit for number in whole) else unit
    front = -unit if all(number < 0 for number in numbers) else unit
    rests = []
    for number, monomial_powers in (product.monomial for product in products[:MOST_TERMS]):
        rest = ((name, power - shared.get(name, 0)) for name, power in monomial_powers)
        powers_left = tuple((name, power) for name, power in rest if power)
        rests.append(Monomial(number / front, powers_left))
    inside = _cut(join_terms(map(format_monomial, rests)), products)
    common = format_monomial(Monomial(front, tuple(shared.items()))) if shared or front != 1 else ""
    return f"{'-' if common == '-1' else common} ({inside})".strip()


def format_monomial(monomial: Monomial) -> str:
    """A monomial as text: number, masses, lengths, such as 2 m_payload L1 d2, with fractions."""
    number = monomial.number
    front = f"{number:.6g}" if isinstance(number, float) else str(Fraction(number))
    ordered = sort_powers(monomial.powers)
    above = [format_power(name, power) for name, power in ordered if power > 0]
    below = [format_power(name, -power) for name, power in ordered if power < 0]
    if above and front in ("1", "-1"):
        front = front[:-1]
    text = (front + " " if front not in ("", "-") else front) + " ".join(above)
    under = " ".join(below)
    return text.strip() + (f"/({under})" if len(below) > 1 else f"/{under}" if below else "")


def format_angle_sum(key: TermKey, terms: ReferenceTerms) -> tuple[int, str]:
    """The sign that a sine takes, and the angle sum in the user's coordinates, first positive."""
    if not any(key.wave):
        return 1, ""
    turned = np.array(key.wave, dtype=object) @ terms.turns
    monomials = [
        (monomial, name)
        for entry, name in zip(turned, terms.names, strict=True)
        for monomial in as_polynomial(entry).monomials
    ]
    if any(m.number != round(m.number) for m, _ in monomials if isinstance(m.number, float)):
        named = zip(key.wave, range(1, len(key.wave) + 1), strict=True)
        monomials = [(Monomial(times, ()), f"theta_{joint}") for times, joint in named if times]
    sign = 1 if monomials[0][0].number > 0 else -1
    return sign, join_terms(
        _format_multiple(monomial._replace(number=sign * monomial.number), name)
        for monomial, name in monomials
    )


def _format_multiple(monomial: Monomial, name: str) -> str:
    """A coordinate times a monomial: 2 theta_1, psi_1/n1."""
    above, slash, below = format_monomial(monomial).partition("/")
    front = {"1": "", "-1": "-"}.get(above, f"{above} ")
    return f"{front}{name}{slash}{below}"


def join_terms(parts: Iterable[str]) -> str:
    """The sum of texts, which may begin with a minus."""
    return " + ".join(parts).replace("+ -", "- ")


def _cut(text: str, products: Sequence[object]) -> str:
    more = len(products) - MOST_TERMS
    return f"{text} + {more} more" if more > 0 else text


def format_wave(key: TermKey, terms: ReferenceTerms) -> str:
    """A wave as text: 1, or a sine or cosine of an angle sum in the user's coordinates."""
    sign, angle = format_angle_sum(key, terms)
    minus = "-" if key.function == "sin" and sign < 0 else ""
    return f"{minus}{key.function}({angle})" if angle else "1"


def format_term(term: Term) -> str:
    """A term in one line, such as m_payload L1 d2 cos(theta_2)."""
    wave = f"{term.wave}({term.angle})" if term.wave else ""
    behind = " ".join(filter(None, (wave, term.signal)))
    if behind and term.coefficient in ("1", "-1"):
        return term.coefficient[:-1] + behind
    return f"{term.coefficient} {behind}".strip()


def describe_term_error(error: TermError) -> str:
    """An error in words, yours against what is right."""
    term = format_term(error.term)
    if error.kind == "dropped":
        return f"missing term: {term}"
    if error.kind == "sign":
        return f"yours has {term} with the opposite sign"
    if error.kind == "factor":
        if error.by == 0.5 and not error.yours:
            return f"yours has {term} half as large"
        return f"yours has {term} times {error.yours or f'{error.by:g}'}"
    if error.kind == "angle":
        return f"yours has {error.yours} where {error.right} belongs, in {term}"
    if error.kind == "extra":
        return f"extra term: {term}" + f", which stands in {error.right}" * bool(error.right)
    # missing term: m (L2 - d2) L1: where one letter stands for another in one product.
    coefficient, right, yours = error.term.coefficient, error.right, error.yours
    if not right:  # a step of the derivation, which is no term
        return yours
    match = re.search(rf"(?<!\S){re.escape(right)}(\^\d+)?(?!\S)", coefficient)
    is_product = coefficient != WEIGHT and "(" not in coefficient and "every" not in coefficient
    if match is None or not is_product or not yours.isidentifier():
        return f"{yours} where {right} belongs" + f", in {term}" * bool(term)
    power = match[1] or ""
    inside = f"({right}{power} - {yours}{power})"
    short = coefficient[: match.start()] + inside + coefficient[match.end() :]
    missing = format_term(replace(error.term, coefficient=short))
    return f"missing term: {missing}; {yours} where {right} belongs"


def make_difference_terms(
    coefficients: Mapping[TermKey, float], terms: ReferenceTerms
) -> tuple[Term, ...]:
    """Yours minus right as terms: numbers before waves and signals, the largest first."""
    numbers = {key: float(f"{value:.4g}") for key, value in coefficients.items()}
    return tuple(
        make_term((Product(key, Monomial(numbers[key], ())),), terms)
        for key in sorted(numbers, key=lambda key: -abs(numbers[key]))
    )


def guess(wrong: EntryMismatch) -> str:
    """The likely error in an entry, as a question since it is a guess; or its difference."""
    explanation = wrong.explanation
    if explanation is None:
        shown = _cut(join_terms(map(format_term, wrong.difference[:MOST_TERMS])), wrong.difference)
        difference_text = f"yours minus right is {shown}; " if shown else ""
        return f"{difference_text}no change of its terms explains it"
    others = ["; and ".join(map(describe_term_error, errors)) for errors in explanation.others]
    guesses = ["; and ".join(map(describe_term_error, explanation.errors)), *others[:MOST_EQUAL]]
    more = f"; {len(others) - MOST_EQUAL} more fit as well" * (len(others) > MOST_EQUAL)
    return ("; or ".join(guesses) + more).rstrip("?") + "?"


def group_by_errors(wrong: Sequence[EntryMismatch]) -> list[list[EntryMismatch]]:
    """The wrong entries, grouped by the errors that explain them, in order of first entries."""
    groups: defaultdict[object, list[EntryMismatch]] = defaultdict(list)
    for number, each in enumerate(wrong):
        errors, signs = each.explanation.errors if each.explanation else (), _list_signs(each)
        alike = [sign == signs[0] for sign in signs]
        groups[(*map(error_signature, errors), *alike) or number].append(each)
    return list(groups.values())


def _list_signs(wrong: EntryMismatch) -> list[bool]:
    """Whether each term of an entry that is missing or too much is a negative one."""
    errors = wrong.explanation.errors if wrong.explanation else ()
    signed = [each.term.coefficient for each in errors if each.kind in ("dropped", "extra")]
    return [each.startswith("-") for each in signed]


def error_signature(error: TermError) -> object:
    """Key that equal errors in different entries share: the swap, or else the term as well."""
    if error.kind == "swapped":
        return error.kind, error.yours, error.right
    term = error.term.coefficient.removeprefix("-")
    where = term, error.term.angle, error.term.signal
    return error.kind, error.yours, error.right, error.by, where


def name_entry(wrong: EntryMismatch, names: Sequence[str], causes: Sequence[str]) -> EntryMismatch:
    """The entry with its name, and the first cause of all or a guess at its error.

    causes: in words, what explains all entries.
    """
    words = causes[0] if causes else guess(wrong)
    return replace(wrong, name=format_entry(wrong.place, names), guess=words)


def describe_entries(wrong: Sequence[EntryMismatch]) -> tuple[list[str], list[str]]:
    """Errors, one line each, however many entries they appear in: those explained; the others."""
    explained, unexplained = defaultdict[str, list[str]](list), list[str]()
    for first, *others in group_by_errors(
        select_counted([each for each in wrong if not each.notes])
    ):
        unlike = [each for each in others if _list_signs(each) != _list_signs(first)]
        alike = ", ".join(each.name for each in others if each not in unlike)
        also = f"; also in {alike}" * bool(alike)
        also += f"; of the other sign in {', '.join(each.name for each in unlike)}" * bool(unlike)
        lines = explained[first.part] if first.explanation else unexplained
        lines.append(f"{first.name}: {first.cause}{also}")
    return [*interleave(explained.values()), *describe_entry_notes(wrong)], unexplained


def describe_point_masses(points: Sequence[str]) -> str:
    """The note on inertias of links that are judged as 0."""
    return (
        f"Your equations have no {', '.join(points)}, and the file's are less than"
        " 1e-6 of mass x com^2: judged as point masses, with 0 in their place."
    )


def describe_unfollowed(
    unfollowed: Sequence[IgnoredNumber],
    wrong_parts: Set[str] = frozenset(),
    written: Set[str] = frozenset(),
    in_file: Set[str] = frozenset(),
) -> str:
    """One note on all numbers of the arm's file that the equations do not follow; or ''.

    Of a number that is 0 in the file and in the equations there is nothing to say. wrong_parts: of
    the equations, whose values may be the error; written: names of numbers whose values stand in
    the user's file, so that they are not missing; in_file: names of all that are not 0 in the
    arm's.
    """
    literal = [each for each in unfollowed if each.value and not each.goes_with]
    tied = [each for each in unfollowed if each.goes_with]
    sentences, is_wrong = [], False
    if literal:
        parts = list(dict.fromkeys(part for each in literal for part in each.parts))
        verb = "does" if len(parts) == 1 else "do"
        names = {each.name for each in literal}
        listed_numbers = list_first([f"{each.name} = {each.value:.6g}" for each in literal])
        follows_none = names == in_file and not any(each.partly for each in literal)
        what = "any of the file's numbers" if follows_none else f"the file's {listed_numbers}"
        is_wrong = not wrong_parts.isdisjoint(parts)
        is_missing = is_wrong and not names <= written
        it, missing = "is it" if len(literal) == 1 else "are they", "missing or " * is_missing
        which = join_words(["M" if part == "mass_matrix" else part for part in parts])
        sentences.append(f"Your {which} {verb} not change with {what}: {it} {missing}hard-coded?")
    if tied:
        listed_ties = ", ".join(f"{t.name} from {' and '.join(t.goes_with)}" for t in tied)
        sentences.append(f"Your equations take {listed_ties}, which is right on this arm.")
    if sentences and not is_wrong:
        sentences.append("The trial went ahead with your values.")
    return " ".join(sentences)
