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
    def location(self) -> str:
        """The place of the entries in the paper's notation, counted from 1."""
        if self.matrix == "mass_matrix":
            names = [f"M_{row + 1}{column + 1}" for row, column in self.entries]
            return f"Eq. 21, {' = '.join(names)}"
        row = self.entries[0][0] + 1
        return f"Eq. 21, row {row} of C q'" if self.matrix == "bias" else f"Eq. 22, F_{row}"


def are_equal_entries(first: sp.Expr, second: sp.Expr) -> bool:
    """Whether two entries are equal given the geometry of a planetary stage.

    That is three planets, r_cp = r_s + r_p and n = 2 r_cp / r_s.
    """
    geometry: dict[sp.Symbol, sp.Expr] = {}
    for stage in map(stage_symbols, (1, 2)):
        geometry[stage.N] = sp.Integer(3)
        geometry[stage.n] = 2 * stage.r_cp / stage.r_s
        geometry[stage.r_p] = stage.r_cp - stage.r_s
    return sp.expand(sp.expand(first - second).subs(geometry)) == 0


def find_entry_differences(printed: Form, derived: Form) -> list[EntryDifference]:
    """Every entry in which the printed form differs from the derived one.

    M and F are compared entry by entry; C is not unique, so the force C q' is compared by rows.
    M_ij and M_ji are one difference if they differ in the same way.
    """
    entry_differences = []
    for matrix in get_args(Matrix):
        printed_matrix, derived_matrix = getattr(printed, matrix), getattr(derived, matrix)
        for row, column in product(range(printed_matrix.rows), range(printed_matrix.cols)):
            sides = printed_matrix[row, column], derived_matrix[row, column]
            if not are_equal_entries(*sides):
                left, right = (set(sp.Add.make_args(sp.expand(side))) for side in sides)
                unshared_terms = sp.Add(*(left - right)), sp.Add(*(right - left))
                entry_differences.append(EntryDifference(matrix, ((row, column),), *unshared_terms))
    merged_differences = []
    for difference in entry_differences:
        row, column = difference.entries[0]
        mirror = replace(difference, entries=((column, row),))
        if row == column or mirror not in entry_differences or difference.matrix != "mass_matrix":
            merged_differences.append(difference)
        elif row < column:
            merged_differences.append(replace(difference, entries=((row, column), (column, row))))
    return merged_differences


def replace_entries(printed: Form, derived: Form, difference: EntryDifference) -> Form:
    """The printed form with this one difference put right."""
    matrix = sp.Matrix(getattr(printed, difference.matrix))
    for row, column in difference.entries:
        matrix[row, column] = getattr(derived, difference.matrix)[row, column]
    return replace(printed, **{difference.matrix: sp.ImmutableMatrix(matrix)})
