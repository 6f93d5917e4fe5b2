"""Errors planted into the equations: what an agreement with another model can show of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import sympy as sp

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.paper.energies import energies_form
from crosscheck.audit.errata.compare import Matrix
from crosscheck.audit.errata.erratum import FormSide, simulated
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.checks.trajectories import largest_difference
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import load_arm, load_scenario

SCENARIO = "constant-torque"  # the run by which Section 3.1 calls the equations validated
AGREEMENT_RAD = 0.01  # the closer of the two deviations that it calls slight
Place = tuple[int, int]


@dataclass(frozen=True)
class LeftOutEntry:
    """An entry of the matrices of Eqs. 21-22, counted from 0, that is left out with its mirror.

    theta_rad: the largest change of a joint angle over the run; None if nothing can be run.
    """

    matrix: Matrix
    entry: Place
    theta_rad: float | None


@dataclass(frozen=True)
class Planted(Question[list[LeftOutEntry]]):
    """A question: every entry of the form that Eqs. 16-19 give, left out by itself."""

    cost = 2.0

    arm: str

    def records(self) -> Records:
        return load_arm(self.arm), load_scenario(SCENARIO)

    def answer(self) -> list[LeftOutEntry]:
        arm, scenario, clean = load_arm(self.arm), load_scenario(SCENARIO), energies_form()
        right = simulated(FormSide(arm, clean), scenario)
        found = []
        for matrix, entry in entries(clean):
            side = FormSide(arm, without(clean, matrix, entry))
            try:
                theta_rad = largest_difference(right, simulated(side, scenario), "theta")
            except (Diverged, ZeroDivisionError):  # an M that cannot be inverted any more
                theta_rad = None
            found.append(LeftOutEntry(matrix, entry, theta_rad))
        return found


def shown(plants: Sequence[LeftOutEntry]) -> float:
    """The share of the errors that change an angle by more than AGREEMENT_RAD, or leave no run."""
    seen = [plant.theta_rad is None or plant.theta_rad > AGREEMENT_RAD for plant in plants]
    return sum(seen) / len(seen)


def entries(form: Form) -> Iterator[tuple[Matrix, Place]]:
    """Matrix and place of all entries but zeros: the upper half of M, the rows of C q' and of F."""
    for matrix in get_args(Matrix):
        values = getattr(form, matrix)
        for row in range(values.rows):
            for column in range(row if values.cols > 1 else 0, values.cols):
                if values[row, column] != 0:
                    yield matrix, (row, column)


def without(form: Form, matrix: Matrix, entry: Place) -> Form:
    """The form with an entry set to zero, in M with its mirror too."""
    changed = sp.Matrix(getattr(form, matrix))
    for place in {entry, entry[::-1]} if changed.is_square else {entry}:
        changed[place] = sp.S.Zero
    return replace(form, **{matrix: sp.ImmutableMatrix(changed)})
