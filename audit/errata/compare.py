"""Two symbolic forms, entry by entry: what one says and the other does not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Literal, get_args

import sympy as sp

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.derivation.symbols import stage_symbols

Matrix = Literal["mass_matrix", "bias", "force"]  # of a Form


@dataclass(frozen=True)
class EntryDifference:
    """Entries of one matrix of a form that differ from the derived ones in the same way.

    entries: row and column counted from 0;
    printed, derived: the terms that only one side has.
    """

    matrix: Matrix
    entries: tuple[tuple[int, int], ...]
    printed: sp.Expr
    derived: sp.Expr

    @property
    def where(self) -> str:
        """The place of the entries in the paper's notation, counted from 1."""
        if self.matrix == "mass_matrix":
            names = [f"M_{row + 1}{column + 1}" for row, column in self.entries]
            return f"Eq. 21, {' = '.join(names)}"
        row = self.entries[0][0] + 1
        return f"Eq. 21, row {row} of C q'" if self.matrix == "bias" else f"Eq. 22, F_{row}"


def same(one: sp.Expr, other: sp.Expr) -> bool:
    """Whether two entries are equal given the geometry of a planetary stage.

    That is three planets, r_cp = r_s + r_p and n = 2 r_cp / r_s.
    """
    geometry: dict[sp.Symbol, sp.Expr] = {}
    for stage in map(stage_symbols, (1, 2)):
        geometry[stage.N] = sp.Integer(3)
        geometry[stage.n] = 2 * stage.r_cp / stage.r_s
        geometry[stage.r_p] = stage.r_cp - stage.r_s
    return sp.expand(sp.expand(one - other).subs(geometry)) == 0


def differences(printed: Form, derived: Form) -> list[EntryDifference]:
    """Every entry in which the printed form differs from the derived one.

    M and F are compared entry by entry; C is not unique, so the force C q' is compared by rows.
    M_ij and M_ji are one difference if they differ in the same way.
    """
    found = []
    for matrix in get_args(Matrix):
        ours, theirs = getattr(printed, matrix), getattr(derived, matrix)
        for row, column in product(range(ours.rows), range(ours.cols)):
            sides = ours[row, column], theirs[row, column]
            if not same(*sides):
                left, right = (set(sp.Add.make_args(sp.expand(side))) for side in sides)
                own = sp.Add(*(left - right)), sp.Add(*(right - left))
                found.append(EntryDifference(matrix, ((row, column),), *own))
    together = []
    for one in found:
        row, column = one.entries[0]
        mirror = replace(one, entries=((column, row),))
        if row == column or mirror not in found or one.matrix != "mass_matrix":
            together.append(one)
        elif row < column:
            together.append(replace(one, entries=((row, column), (column, row))))
    return together


def corrected(printed: Form, derived: Form, difference: EntryDifference) -> Form:
    """The printed form with this one difference put right."""
    matrix = sp.Matrix(getattr(printed, difference.matrix))
    for row, column in difference.entries:
        matrix[row, column] = getattr(derived, difference.matrix)[row, column]
    return replace(printed, **{difference.matrix: sp.ImmutableMatrix(matrix)})
