"""Where in equations of motion something stands, and what is wrong there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Part = Literal["mass_matrix", "bias", "force", "acceleration"]


@dataclass(frozen=True)
class EntryPlace:
    """An entry, counted from 0: M[row, column]; bias[row] in v_j v_k, j <= k; force[row]."""

    part: Part
    row: int
    column: int | None = None
    rates: tuple[int, int] | None = None


@dataclass(frozen=True)
class Term:
    """coefficient * cosine or sine of an angle sum: what stands in an entry for too much or little.

    coefficient, angle, signal: text as one writes it (``m_payload L2 L1``, ``theta_1 - theta_2``,
    ``F_sp1``), empty for 1, no angle, none; latex: the whole term.
    """

    coefficient: str
    wave: Literal["", "cos", "sin"] = ""
    angle: str = ""
    signal: str = ""
    latex: str = ""


@dataclass(frozen=True)
class TermError:
    """A term of an entry as it must be, and what stands there instead.

    kind: ``sign``, ``factor`` (``by``: yours over right), ``dropped``, ``swapped`` (``yours`` where
    ``right`` belongs), ``angle`` (the same of an angle sum), ``extra``. term: the right one, of
    ``extra`` the one too many.
    """

    kind: Literal["sign", "factor", "dropped", "swapped", "angle", "extra"]
    term: Term
    yours: str = ""
    right: str = ""
    by: float | None = None


@dataclass(frozen=True)
class Explanation:
    """Errors that together make a difference, and what they leave of it, relative to that.

    others: explanations that fit as well with the arm's numbers (equal lengths, say), likeliest
    first. seen_in: in words, where the errors are, if not in this entry: entries in other
    coordinates, in which they are fewer.
    """

    errors: tuple[TermError, ...]
    left_over: float
    others: tuple[tuple[TermError, ...], ...] = ()
    seen_in: str = ""


@dataclass(frozen=True)
class Wrong:
    """An entry that is wrong: by how much (relative to the entry's natural size), and perhaps why.

    difference: yours minus right in numbers, of an entry that nothing explains. latex: the same
    typeset, of symbolic equations. shown_on: name of the arm that shows it, where the one on trial
    cannot.
    """

    place: EntryPlace
    relative: float
    explanation: Explanation | None = None
    difference: tuple[Term, ...] = ()
    latex: str = ""
    shown_on: str = ""
    notes: tuple[str, ...] = field(default=())
