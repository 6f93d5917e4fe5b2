"""Whole forms of the equations: as printed beside an engine, and with an entry left out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import get_args

import sympy as sp

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.paper.energies import build_energies_form
from crosscheck.analytic.paper.printed import build_printed_form
from crosscheck.audit.errata.differences import Matrix
from crosscheck.audit.errata.erratum import PaperSide
from crosscheck.audit.experiments.study import Question, Records
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.checks import forms
from crosscheck.checks.sampled import Subjects
from crosscheck.checks.scales import LOOSEST
from crosscheck.checks.trajectories import largest_difference
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.arms import COUNT, sample_arm
from crosscheck.planning.comparison import Results, collect_tasks

PRINTED, ENGINE = "analytic:printed", "pinocchio:gears"
SEED = 0  # of the states, as of a cross-check
EXPERIMENTS = ("constant-torque", "pd")


@dataclass(frozen=True)
class RunDifferences:
    """The largest differences of two runs: joint angle [rad], sun-planet mesh force [N]."""

    duration_s: float
    theta_rad: float
    F_sp_N: float


@dataclass(frozen=True)
class EngineComparison:
    """The largest relative differences of M and of the acceleration over random states.

    runs: of the same experiments, beside the derivation that agrees with the engines to rounding.
    """

    mass_matrix: float | None
    acceleration: float | None
    states: int
    runs: dict[str, RunDifferences]

    @property
    def agrees(self) -> bool | None:
        """Whether both differences are no more than rounding; None if one is undefined."""
        if self.mass_matrix is None or self.acceleration is None:
            return None
        return max(self.mass_matrix, self.acceleration) <= LOOSEST

    def to_dict(self) -> JsonObject:
        """The comparison as a JSON object."""
        return {"id": "finding/printed", **asdict(self)}


@dataclass(frozen=True)
class PrintedEquationsQuestion(Question[EngineComparison]):
    """A question: Eqs. 21-22 as printed beside Pinocchio, and through both experiments.

    longest_s: no run is longer.
    """

    cost = 5.0

    arm: str
    longest_s: float

    def records(self) -> Records:
        return load_arm(self.arm), *map(load_scenario, EXPERIMENTS)

    def answer(self) -> EngineComparison:
        arm, runs = load_arm(self.arm), {}
        mass, acceleration = (
            self._relative_difference(arm, name) for name in ("mass_matrix", "acceleration")
        )
        for name in EXPERIMENTS:  # as a cross-check runs and records them
            full_scenario = load_scenario(name)
            duration_s = min(full_scenario.duration_s, self.longest_s)
            scenario = full_scenario.model_copy(update={"duration_s": duration_s})
            sides = PaperSide(arm, build_printed_form()), PaperSide(arm)
            printed, derived = (side(scenario) for side in sides)
            sizes = (largest_difference(printed, derived, each) for each in ("theta", "F_sp"))
            runs[name] = RunDifferences(duration_s, *sizes)
        return EngineComparison(mass, acceleration, COUNT, runs)

    def _relative_difference(self, arm: Arm, quantity: str) -> float | None:
        """Largest relative difference as a cross-check measures it; None without a usable one."""
        (comparison,) = (
            candidate
            for candidate in forms.plan(Subjects(arms=list(sample_arm(arm, COUNT, SEED))))
            if (candidate.about.key.left, candidate.about.key.right) == (PRINTED, ENGINE)
            and candidate.about.key.quantity == quantity
        )
        outcomes = {task.key: task.perform() for task in collect_tasks([comparison])}
        return comparison.finding(Results(outcomes)).measured


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
        reference = PaperSide(arm, clean)(scenario)
        changes = list[float | None]()
        for matrix, entry in nonzero_entries(clean):
            side = PaperSide(arm, remove_entry(clean, matrix, entry))
            try:
                changes.append(largest_difference(reference, side(scenario), "theta"))
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
