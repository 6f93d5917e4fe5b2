"""Entries of a model beside the reference's on one arm, in the user's coordinates or others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from crosscheck.models.arm.arm import Arm
from crosscheck.planning.comparison import ModelTask, Results
from crosscheck.trial.arms.questions import VerificationProblem
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.changes.arms.mesh_forces import ForceStates, compute_signals
from crosscheck.trial.changes.arms.segments import (
    ReferenceTerms,
    TermKey,
    build_reference_terms,
    evaluate_wave,
    rate_name,
)
from crosscheck.trial.changes.arms.waves import (
    FOLLOWS,
    WaveBasis,
    derive_bias_change,
    list_keys,
    minimum_state_count,
)
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.differences import fold_rate_pairs
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.coordinates.states import UserState
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge import entries
from crosscheck.trial.judge.entries import EntryMismatch, EntryPlace, NaturalSizes

# Where each part is looked at entry by entry.
BY_ENTRY = {
    "mass_matrix": "mass_matrix",
    "bias": "rate_terms",
    "gravity": "gravity",
    "force": "force",
}
Perform = Callable[[Sequence[ModelTask]], Results]
QUANTITIES = {part: quantity for quantity, part in entries.PARTS.items() if quantity != "bias"}


@dataclass(frozen=True)
class EntryComparison:
    """A model and the reference on one arm: answers of both for every part, at every state.

    coordinates: built-in coordinates in which all of this is, None for the user's. symbolic: the
    user's map in symbols of the arm.
    """

    problem: VerificationProblem
    level: str
    results: Results
    user_values: Mapping[str, np.ndarray]
    reference_values: Mapping[str, np.ndarray]
    symbolic: sp.ImmutableMatrix | None = None
    coordinates: Coordinates | None = None

    def transform_to(self, coordinates: Coordinates) -> EntryComparison:
        """The comparison carried into built-in coordinates. Only of a linear map."""
        frame = build_frame(coordinates, self.problem.case.arm)
        S = self._coordinate_jacobian(frame)
        user_values, reference_values = (
            {quantity: _transform_values(quantity, values, S) for quantity, values in each.items()}
            for each in (self.user_values, self.reference_values)
        )
        return replace(
            self,
            user_values=user_values,
            reference_values=reference_values,
            symbolic=frame.symbolic,
            coordinates=coordinates,
        )

    def _coordinate_jacobian(self, frame: Frame) -> np.ndarray:
        """dx/dy (n, n) of the user's x by coordinates y of a frame."""
        user_matrix, built_in = self.problem.frame.matrix, frame.matrix
        assert user_matrix is not None  # or nobody asks
        assert built_in is not None
        return np.linalg.solve(user_matrix, built_in)

    @cached_property
    def frame(self) -> Frame:
        """The frame of the coordinates in use, its map in symbols where it has any."""
        if self.coordinates is not None:
            return build_frame(self.coordinates, self.problem.case.arm)
        return replace(self.problem.frame, symbolic=self.symbolic)

    @cached_property
    def states(self) -> Sequence[UserState]:
        """The states at which both were asked, in the coordinates in use."""
        if self.coordinates is None:
            return self.problem.states
        turns = np.linalg.inv(self._coordinate_jacobian(self.frame))
        return [
            state._replace(x=turns @ state.x, u=turns @ state.u) for state in self.problem.states
        ]

    @cached_property
    def rates(self) -> np.ndarray:
        """Rates of the coordinates in use at the states (K, n)."""
        return np.array([state.u for state in self.states])

    @cached_property
    def sizes(self) -> NaturalSizes:
        """Natural sizes of the entries in the coordinates in use."""
        if self.coordinates is None:
            return self.problem.compute_sizes(self.level)
        S = self._coordinate_jacobian(self.frame)
        trusted = self.problem.list_trusted_answers(self.level)
        parts = ("mass_matrix", "force", "acceleration", "gravity")
        mass, force, acceleration, gravity = (
            None if values is None else _transform_values(part, values, S)
            for part, values in zip(parts, trusted, strict=True)
        )
        assert mass is not None  # or it would have been missed
        return entries.compute_sizes(self.frame, self.states, mass, force, acceleration, gravity)

    @property
    def wrong_entries(self) -> Iterator[EntryMismatch]:
        """The entries that differ, part by part."""
        for quantity, values in self.user_values.items():
            yield from entries.find_wrong_entries(
                quantity, values, self.reference_values[quantity], self.sizes
            )

    @property
    def relative_errors(self) -> dict[str, np.ndarray]:
        """Difference of each entry from the reference's, relative to its size, part by part."""
        return {
            quantity: entries.deviations(
                values, self.reference_values[quantity], self.sizes.entry_sizes(quantity)
            )
            for quantity, values in self.user_values.items()
        }

    @cached_property
    def terms(self) -> ReferenceTerms | None:
        """Terms that belong in every entry; None where these cannot be determined.

        They cannot be if the map is not linear, nor at fewer states than an entry may have terms.
        """
        if self.frame.matrix is None:
            return None
        arm, chosen = self.problem.case.arm, self.problem.case.switches
        has_gravity = self.problem.has_gravity
        terms = build_reference_terms(self.frame, arm, chosen, self.level, has_gravity=has_gravity)
        return terms if self.problem.count >= minimum_state_count(terms) else None

    @cached_property
    def values(self) -> Mapping[str, float]:
        """The arm's quantities by their letters."""
        return collect_arm_values(self.problem.case.arm)

    @cached_property
    def angles(self) -> np.ndarray:
        """Joint angles at the states (K, joints)."""
        return np.array([state.q[self.frame.layout.theta] for state in self.states])

    @cached_property
    def force_states(self) -> ForceStates:
        """What forces depend on at the states."""
        t, q, v, torque = (np.array([state[k] for state in self.states]) for k in (0, 3, 4, 5))
        return ForceStates(t, q, v, torque)

    @cached_property
    def signals(self) -> dict[str, np.ndarray]:
        """Torques, mesh forces and rates at the states."""
        arm: Arm = self.problem.case.arm
        layout, chosen = self.frame.layout, self.problem.case.switches
        signals = compute_signals(arm, layout, chosen, self.force_states)
        return signals | {
            rate_name(name): self.rates[:, k] for k, name in enumerate(self.frame.names)
        }

    def difference(self, place: EntryPlace) -> tuple[np.ndarray, float]:
        """Yours minus right of an entry at every state (K,), and the entry's size."""
        quantity, index = QUANTITIES[place.part], place.index
        differences = self.user_values[quantity] - self.reference_values[quantity]
        return differences[(slice(None), *index)], float(self.sizes.entry_sizes(quantity)[index])

    def noise(self, place: EntryPlace) -> float:
        """Rounding of an entry's difference."""
        quantity = QUANTITIES[place.part]
        rounding = self.sizes.tolerance(quantity) - entries.LOOSEST
        return rounding * float(self.sizes.entry_sizes(quantity)[place.index])

    @cached_property
    def _bases(self) -> dict[str, WaveBasis]:
        return {}

    def fit_waves(self, place: EntryPlace) -> dict[TermKey, float] | None:
        """The difference of an entry, taken apart into waves and signals; None where none do."""
        values, size = self.difference(place)
        kind = "force" if place.part in ("force", "gravity") else "mass_matrix"
        if kind not in self._bases:
            assert self.terms is not None  # else nobody asks
            signals = self.signals if kind == "force" else {}
            keys = list_keys(self.terms, signals, kind)
            self._bases[kind] = WaveBasis(keys, self.angles, signals)
        return self._bases[kind].fit(values, size)

    @cached_property
    def _bias_from_mass(self) -> Mapping[EntryPlace, Mapping[TermKey, float]]:
        """Differences of the bias that follow from the wrong entries of M, by place."""
        mass = {
            (wrong.place.row, wrong.place.column): self.fit_waves(wrong.place) or {}
            for wrong in self.wrong_entries
            if wrong.place.column is not None
        }
        assert self.terms is not None  # else nobody asks
        return derive_bias_change(mass, self.terms.angles)

    def is_caused_by_mass(self, place: EntryPlace) -> bool:
        """Whether an entry of the bias is wrong for no other reason than M."""
        expected = self._bias_from_mass.get(place)
        if not expected or self.terms is None:
            return False
        total = sum(n * evaluate_wave(key, self.angles) for key, n in expected.items())
        difference, _ = self.difference(place)
        allowed = FOLLOWS * np.abs(difference).max() + self.noise(place)
        return bool(np.abs(difference - total).max() <= allowed)


def _transform_values(quantity: str, values: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Values (count, ...) of a part, carried from x to coordinates y; S: dx/dy."""
    if quantity == "mass_matrix":
        return np.einsum("sij,ia,jb->sab", values, S, S)
    if quantity == "rate_terms":
        turned = np.einsum("sijk,ia,jb,kc->sabc", values, S, S, S, optimize=True)
        return fold_rate_pairs(turned)
    if quantity == "acceleration":
        return values @ np.linalg.inv(S).T
    return values @ S


def list_entry_quantities(problem: VerificationProblem) -> list[str]:
    """Parts that are compared entry by entry; the acceleration only where nothing else is there."""
    quantities = [quantity for part, quantity in BY_ENTRY.items() if part in problem.has]
    return quantities or ["acceleration"]


def compare_entries(
    problem: VerificationProblem, level: str, quantities: Sequence[str], results: Results
) -> EntryComparison:
    """Both answers to every part that both answer."""
    user_values, reference_values = dict[str, np.ndarray](), dict[str, np.ndarray]()
    for quantity in quantities:
        user_answer = results.get(problem.ask_equations(quantity))
        right = None if user_answer is None else problem.find_right(level, quantity)
        if user_answer is not None and right is not None:
            user_values[quantity], reference_values[quantity] = user_answer, right
    return EntryComparison(
        problem, level, results, user_values, reference_values, problem.frame.symbolic
    )


def ask_and_compare(
    problems: Sequence[VerificationProblem],
    level: str,
    quantities: Sequence[str],
    perform: Perform,
) -> list[EntryComparison]:
    """The comparison on each arm, of whose equations these quantities are asked now."""
    asked = [problem.ask_equations(quantity) for problem in problems for quantity in quantities]
    results = perform(list(dict.fromkeys(asked)))
    return [compare_entries(each, level, quantities, results) for each in problems]
