"""Entries of a model beside the reference's on one arm, in the user's coordinates or others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.planning.comparison import ModelTask, Results
from crosscheck.trial.arms.questions import StateQuestion, VerificationProblem
from crosscheck.trial.changes.arms import segments
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.changes.arms.mesh_forces import compute_signals
from crosscheck.trial.changes.arms.waves import FOLLOWS, WaveBasis, list_keys, minimum_state_count
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.coordinates.states import UserState, stack_states
from crosscheck.trial.judge import entries
from crosscheck.trial.judge.entries import EntryMismatch, EntryPlace, NaturalSizes

UNQUADRATIC = "is not a sum of products of two rates"
Rates = tuple[int, int]
Perform = Callable[[Sequence[ModelTask]], Results]


@dataclass(frozen=True)
class EntryComparison:
    """A model and the reference on one arm: answers of both for every part, at the first states.

    Those of many calls for a state are asked at fewer of them. letters: the user's map in letters,
    where those of the arm do not decide. whole_bias: both answers (K, n) to the bias at the states,
    of which the terms by rates are its values at others.
    """

    problem: VerificationProblem
    level: str
    user_values: Mapping[str, np.ndarray]
    reference_values: Mapping[str, np.ndarray]
    letters: np.ndarray | None = None
    whole_bias: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def frame(self) -> Frame:
        """The frame of the coordinates."""
        return self.problem.frame

    @cached_property
    def states(self) -> UserState:
        """The states at which both were asked, K of them, as arrays."""
        return stack_states(self.problem.states)

    @property
    def sizes(self) -> NaturalSizes:
        """Natural sizes of the entries."""
        return self.problem.compute_sizes(self.level)

    @property
    def wrong_entries(self) -> Iterator[EntryMismatch]:
        """The entries that differ, part by part."""
        for quantity, values in self.user_values.items():
            yield from entries.find_wrong_entries(
                quantity, values, self.reference_values[quantity], self.sizes
            )
        yield from self._unquadratic_entries

    @cached_property
    def _unquadratic_entries(self) -> list[EntryMismatch]:
        """The rows of the bias that are wrong although all their products of rates are right."""
        if self.whole_bias is None:
            return []
        yours, right = (each["rate_terms"] for each in (self.user_values, self.reference_values))
        terms = entries.find_wrong_entries("rate_terms", yours, right, self.sizes)
        rows = {each.place.row for each in terms}
        wrong_rows = entries.find_wrong_entries("bias", *self.whole_bias, self.sizes)
        return [
            replace(each, notes=(UNQUADRATIC,)) for each in wrong_rows if each.place.row not in rows
        ]

    @property
    def relative_errors(self) -> dict[str, np.ndarray]:
        """Difference of each entry from the reference's, relative to its size, part by part."""
        pairs = {part: (v, self.reference_values[part]) for part, v in self.user_values.items()}
        if self._unquadratic_entries and self.whole_bias:
            pairs["bias"] = self.whole_bias
            if not any(entries.find_wrong_entries("rate_terms", *pairs["rate_terms"], self.sizes)):
                del pairs["rate_terms"]  # which are right, and say nothing
        return {
            part: entries.deviations(*pair, self.sizes.entry_sizes(part))
            for part, pair in pairs.items()
        }

    @cached_property
    def columns(self) -> np.ndarray | None:
        """The user's map in letters of the arm; None if it is not linear."""
        if self.letters is not None or self.frame.matrix is None:
            return self.letters
        return segments.find_columns(self.frame, self.problem.case.arm)

    @cached_property
    def terms(self) -> segments.ReferenceTerms | None:
        """Terms that belong in every entry; None where these cannot be determined.

        They cannot be if the map is not linear, nor at fewer states than an entry may have terms.
        """
        if self.columns is None:
            return None
        arm, chosen = self.problem.case.arm, self.problem.case.switches
        has_gravity, columns = self.problem.has_gravity, self.columns
        terms = segments.build_reference_terms(
            self.frame, arm, chosen, self.level, has_gravity=has_gravity, columns=columns
        )
        return terms if self.problem.count >= minimum_state_count(terms) else None

    @cached_property
    def values(self) -> Mapping[str, float]:
        """The arm's quantities by their letters."""
        return collect_arm_values(self.problem.case.arm)

    @cached_property
    def angles(self) -> np.ndarray:
        """Joint angles at the states (K, joints)."""
        return self.states.q[:, self.frame.layout.theta]

    @cached_property
    def signals(self) -> dict[str, np.ndarray]:
        """Torques, mesh forces and rates at the states."""
        arm: Arm = self.problem.case.arm
        layout, chosen = self.frame.layout, self.problem.case.switches
        signals = compute_signals(arm, layout, chosen, self.states)
        return signals | {
            segments.rate_name(name): self.states.u[:, k] for k, name in enumerate(self.frame.names)
        }

    def difference(self, place: EntryPlace) -> tuple[np.ndarray, float]:
        """Yours minus right of an entry at the first states (K,), and the entry's size."""
        quantity, index = place.quantity, place.index
        differences = self.user_values[quantity] - self.reference_values[quantity]
        return differences[(slice(None), *index)], float(self.sizes.entry_sizes(quantity)[index])

    def noise(self, place: EntryPlace) -> float:
        """Rounding of an entry's difference."""
        rounding = self.sizes.tolerance(place.quantity) - entries.LOOSEST
        return rounding * float(self.sizes.entry_sizes(place.quantity)[place.index])

    @cached_property
    def _bases(self) -> dict[tuple[str, int], WaveBasis]:
        return {}

    def fit_waves(self, place: EntryPlace) -> dict[segments.TermKey, float] | None:
        """The difference of an entry, taken apart into waves and signals; None where none do."""
        values, size = self.difference(place)
        kind = "force" if place.part in ("force", "gravity") else "mass_matrix"
        key, first = (kind, len(values)), slice(len(values))
        if key not in self._bases:
            assert self.terms is not None  # else nobody asks
            signals = self.signals if kind == "force" else {}
            keys = list_keys(self.terms, signals, kind)
            signals = {name: signal[first] for name, signal in signals.items()}
            self._bases[key] = WaveBasis(keys, self.angles[first], signals)
        return self._bases[key].fit(values, size)

    @cached_property
    def _bias_from_mass(self) -> Mapping[tuple[EntryPlace, segments.TermKey], float]:
        """Differences of the bias that follow from the wrong entries of M."""
        places = [w.place for w in self.wrong_entries if w.place.column is not None]
        fits = [(place, self.fit_waves(place) or {}) for place in places]
        assert self.terms is not None  # else nobody asks
        mass = [(place, key, number) for place, fit in fits for key, number in fit.items()]
        return segments.derive_bias(mass, self.terms.angles)

    def is_caused_by_mass(self, place: EntryPlace) -> bool:
        """Whether an entry of the bias is wrong for no other reason than M."""
        difference, _ = self.difference(place)
        made = [
            number * segments.evaluate_wave(key, self.angles[: len(difference)])
            for (at, key), number in self._bias_from_mass.items()
            if at == place
        ]
        allowed = FOLLOWS * np.abs(difference).max() + self.noise(place)
        return bool(made) and bool(np.abs(difference - sum(made)).max() <= allowed)

    def find_exchanged_rates(self, place: EntryPlace) -> tuple[Rates, Rates] | None:
        """The product of rates whose term stands at another product of a row, and that one.

        None unless an entry of the bias lacks what another one of its row has too much.
        """
        yours, right = (
            each["rate_terms"][:, place.row] for each in (self.user_values, self.reference_values)
        )
        there = place.rates or (0, 0)
        size = self.sizes.entry_sizes("rate_terms")[place.row]
        allowed = self.sizes.tolerance("rate_terms") * size
        off = yours - right
        for other in combinations_with_replacement(range(len(size)), 2):
            if other != there and (np.abs(off[:, *other] + off[:, *there]) <= allowed[there]).all():
                for lacks, has in ((there, other), (other, there)):
                    is_moved = np.abs(yours[:, *lacks]).max() <= allowed[lacks]
                    if is_moved and np.abs(right[:, *has]).max() <= allowed[has]:
                        return lacks, has
        return None


def list_entry_quantities(problem: VerificationProblem) -> list[str]:
    """Parts that are compared entry by entry; the acceleration only where nothing else is there."""
    parts = [part for part in ("mass_matrix", "bias", "gravity", "force") if part in problem.has]
    return ["rate_terms" if part == "bias" else part for part in parts] or ["acceleration"]


def compare_entries(problem: VerificationProblem, level: str, results: Results) -> EntryComparison:
    """Both answers to every part that both answer."""
    user_values, reference_values = dict[str, np.ndarray](), dict[str, np.ndarray]()
    for quantity in list_entry_quantities(problem):
        user_answer = results.get(problem.ask_equations(quantity))
        right = None if user_answer is None else problem.find_right(level, quantity)
        if user_answer is not None and right is not None:
            user_values[quantity], reference_values[quantity] = user_answer, right
    whole = None
    if "rate_terms" in user_values:
        answer = results.get(problem.ask_equations("bias"))
        right = problem.find_right(level, "bias")
        whole = None if answer is None or right is None else (answer, right)
    return EntryComparison(problem, level, user_values, reference_values, whole_bias=whole)


def ask_and_compare(
    problems: Sequence[VerificationProblem], level: str, perform: Perform
) -> list[EntryComparison]:
    """The comparison on each arm, whose equations are asked now."""
    results = perform([task for each in problems for task in list_entry_questions(each)])
    return [compare_entries(each, level, results) for each in problems]


def list_entry_questions(problem: VerificationProblem) -> list[StateQuestion]:
    """What equations are asked to be compared entry by entry."""
    return [problem.ask_equations(quantity) for quantity in list_entry_quantities(problem)]
