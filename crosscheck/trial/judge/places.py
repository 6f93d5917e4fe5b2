"""Where in equations of motion something stands, and what is wrong there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Part = Literal["mass_matrix", "bias", "force", "acceleration"]


@dataclass(frozen=True)
class Place:
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
class Slip:
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
    """Slips that together make a difference, and what they leave of it, relative to the difference.

    others: explanations that fit as well with the arm's numbers (equal lengths, say).
    """

    slips: tuple[Slip, ...]
    left_over: float
    others: tuple[tuple[Slip, ...], ...] = ()


@dataclass(frozen=True)
class Wrong:
    """An entry that is wrong: by how much (relative to the entry's natural size), and perhaps why.

    latex: yours minus right, typeset, of symbolic equations. shown_on: name of the arm that shows
    it, where the one on trial cannot.
    """

    place: Place
    relative: float
    explanation: Explanation | None = None
    latex: str = ""
    shown_on: str = ""
    notes: tuple[str, ...] = field(default=())
