"""Errors planted into the equations: what an agreement with another model can show of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import sympy as sp

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.paper.energies import build_energies_form
from crosscheck.audit.errata.differences import Matrix
from crosscheck.audit.errata.erratum import PaperModelFactory, run_model
from crosscheck.audit.experiments.study import Question, Records
from crosscheck.checks.trajectories import largest_difference
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import load_arm, load_scenario

SCENARIO = "constant-torque"  # the run by which Section 3.1 calls the equations validated
AGREEMENT_RAD = 0.01  # the closer of the two deviations that it calls slight
EntryIndex = tuple[int, int]


@dataclass(frozen=True)
class PlantedFaultQuestion(Question[list[float | None]]):
    """A question: every entry of the form that Eqs. 16-19 give, left out by itself with its mirror.

    The largest change of a joint angle [rad] over the run; None if nothing can be run.
    """

    cost = 2.0

    arm: str

    def records(self) -> Records:
        return load_arm(self.arm), load_scenario(SCENARIO)

    def answer(self) -> list[float | None]:
        arm, scenario, clean = load_arm(self.arm), load_scenario(SCENARIO), build_energies_form()
        reference = run_model(PaperModelFactory(arm, clean), scenario)
        changes = list[float | None]()
        for matrix, entry in nonzero_entries(clean):
            side = PaperModelFactory(arm, remove_entry(clean, matrix, entry))
            try:
                changes.append(largest_difference(reference, run_model(side, scenario), "theta"))
            except (Diverged, ZeroDivisionError):  # an M that cannot be inverted any more
                changes.append(None)
        return changes


def detectable_share(changes: Sequence[float | None]) -> float:
    """The share of the errors that change an angle by more than AGREEMENT_RAD, or leave no run."""
    return sum(change is None or change > AGREEMENT_RAD for change in changes) / len(changes)


def nonzero_entries(form: Form) -> Iterator[tuple[Matrix, EntryIndex]]:
    """Matrix and place of all entries but zeros: the upper half of M, the rows of C q' and of F."""
    for matrix in get_args(Matrix):
        values = getattr(form, matrix)
        for row in range(values.rows):
            for column in range(row if values.cols > 1 else 0, values.cols):
                if values[row, column] != 0:
                    yield matrix, (row, column)


def remove_entry(form: Form, matrix: Matrix, entry: EntryIndex) -> Form:
    """The form with an entry set to zero, in M with its mirror too."""
    changed = sp.Matrix(getattr(form, matrix))
    for place in {entry, entry[::-1]} if changed.is_square else {entry}:
        changed[place] = sp.S.Zero
    return replace(form, **{matrix: sp.ImmutableMatrix(changed)})
