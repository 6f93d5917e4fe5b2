"""A wrong term and the right one as TeX, in pieces, so that what differs can be marked."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import NamedTuple

from crosscheck.trial.changes.arms.term_words import format_text_latex
from crosscheck.trial.judge.entries import TermError

LARGEST_DENOMINATOR = 100


class Piece(NamedTuple):
    """A piece of TeX; is_marked: whether it is what differs."""

    latex: str
    is_marked: bool = False


class TypesetError(NamedTuple):
    """A term as the user has it, and as it must be."""

    yours: tuple[Piece, ...]
    right: tuple[Piece, ...]


def typeset_error(error: TermError) -> TypesetError | None:
    """Both lines of an error; None for one that is not written as a change of one term."""
    latex = error.term.latex
    if not latex:
        return None
    nothing, whole = (Piece("0", True),), (Piece(latex, True),)
    if error.kind == "dropped":
        return TypesetError(nothing, whole)
    if error.kind == "extra":
        return TypesetError(whole, nothing)
    if error.kind == "sign":
        return _typeset_sign(latex)
    if error.kind == "factor":
        factor = format_text_latex(error.yours) if error.by is None else _format_factor(error.by)
        return TypesetError((Piece(factor, True), Piece(rf"\,({latex})")), (Piece(latex),))
    return _typeset_exchange(latex, error.yours, error.right)


def _typeset_sign(latex: str) -> TypesetError:
    negative = latex.startswith("-")
    rest = Piece(latex.removeprefix("-") if negative or "+" not in latex else f"({latex})")
    signs = ("+", "-") if negative else ("-", "+")
    yours, right = (Piece(sign, True) for sign in signs)
    return TypesetError((yours, rest), (right, rest))


def _typeset_exchange(latex: str, user_text: str, reference_text: str) -> TypesetError | None:
    """One factor of a term that stands in the place of another."""
    if reference_text in ("", "1"):
        return TypesetError(
            (Piece(latex), Piece(rf"\,{format_text_latex(user_text)}", True)), (Piece(latex),)
        )
    expected = format_text_latex(reference_text)
    pieces = re.split(rf"(?<![A-Za-z\\]){re.escape(expected)}", latex)
    if len(pieces) == 1:
        return None
    replacement = format_text_latex(user_text or "1")
    is_compound = not re.fullmatch(r"\w+(\^\d+)?|\w*\(.*\)", user_text or "1")
    inserted = f"({replacement})" if is_compound else replacement
    yours, right = [Piece(pieces[0])], [Piece(pieces[0])]
    for piece in pieces[1:]:
        yours += [Piece(inserted, True), Piece(piece)]
        right += [Piece(expected, True), Piece(piece)]
    return TypesetError(*(tuple(p for p in line if p.latex) for line in (yours, right)))


def _format_factor(by: float) -> str:
    factor = Fraction(by).limit_denominator(LARGEST_DENOMINATOR)
    if abs(float(factor) - by) > 1e-12 * abs(by):
        return f"{by:.6g}"
    if factor.denominator == 1:
        return str(factor.numerator)
    sign = "-" if factor < 0 else ""
    return rf"{sign}\frac{{{abs(factor.numerator)}}}{{{factor.denominator}}}"
