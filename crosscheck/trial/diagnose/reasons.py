"""Why entries are wrong: their differences on the arm, and on others, taken apart into errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from crosscheck.planning.comparison import Results
from crosscheck.trial.coordinates.differences import paired
from crosscheck.trial.coordinates.frame import Frame, UserState, frame_of
from crosscheck.trial.diagnose.alternates import ForceDifferences
from crosscheck.trial.diagnose.explain import UNEXPLAINED, alike, bias_of, explain, follows
from crosscheck.trial.diagnose.polynomial import TermKey, from_sympy
from crosscheck.trial.diagnose.reference_terms import (
    ForceStates,
    ReferenceTerms,
    reference_terms_of,
)
from crosscheck.trial.diagnose.values import values_of
from crosscheck.trial.diagnose.waves import Fitting, Observed, states_wanted
from crosscheck.trial.diagnose.words import difference_of, latex_of, symbolic_difference
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge import places as entries
from crosscheck.trial.judge.places import EntryPlace, Explanation, NaturalSizes, Wrong
from crosscheck.trial.judge.questions import StateQuestion, VerificationProblem
from crosscheck.trial.judge.suite import sizes_in, sizing, trusted

SAME = 1e-12  # of a row of a map: what two readings of it may differ by
ROUNDING = 1e-10  # of a row of dy/dx: what is below it is 0
# Where each part is looked at entry by entry.
BY_ENTRY = {"mass_matrix": "mass_matrix", "bias": "rate_terms", "force": "force"}
FOLLOWS = "follows from the wrong M"
QUANTITIES = {part: quantity for quantity, part in entries.PARTS.items() if quantity != "bias"}


@dataclass(frozen=True)
class Compared:
    """A model and the reference on one arm: answers of both for every part, at every state.

    seen: built-in coordinates in which all of this is, None for the user's. symbolic: the user's
    map in symbols of the arm.
    """

    problem: VerificationProblem
    level: str
    results: Results
    yours: Mapping[str, np.ndarray]
    right: Mapping[str, np.ndarray]
    symbolic: sp.ImmutableMatrix | None = None
    seen: Coordinates | None = None

    def seen_in(self, coordinates: Coordinates) -> Compared:
        """The comparison carried into built-in coordinates. Only of a linear map."""
        frame = frame_of(coordinates, self.problem.case.arm)
        S = self._columns_of(frame)
        yours, right = (
            {quantity: _carried(quantity, values, S) for quantity, values in each.items()}
            for each in (self.yours, self.right)
        )
        return replace(self, yours=yours, right=right, symbolic=frame.symbolic, seen=coordinates)

    def _columns_of(self, frame: Frame) -> np.ndarray:
        """dx/dy (n, n) of the user's x by coordinates y of a frame."""
        own, built_in = self.problem.frame.matrix, frame.matrix
        assert own is not None  # or nobody asks
        assert built_in is not None
        return np.linalg.solve(own, built_in)

    @cached_property
    def frame(self) -> Frame:
        """The frame of the coordinates in use, its map in symbols where it has any."""
        if self.seen is not None:
            return frame_of(self.seen, self.problem.case.arm)
        return replace(self.problem.frame, symbolic=self.symbolic)

    @cached_property
    def states(self) -> Sequence[UserState]:
        """The states at which both were asked, in the coordinates in use."""
        if self.seen is None:
            return self.problem.states
        S = np.linalg.inv(self._columns_of(self.frame))
        return [state._replace(x=S @ state.x, u=S @ state.u) for state in self.problem.states]

    @cached_property
    def sizes(self) -> NaturalSizes:
        """Natural sizes of the entries in the coordinates in use."""
        if self.seen is None:
            return sizes_in(self.problem, self.results, self.level)
        S = self._columns_of(self.frame)
        mass, force, acceleration = trusted(self.problem, self.results, self.level)
        return entries.sizes_of(
            self.frame,
            self.states,
            _carried("mass_matrix", mass, S),
            None if force is None else _carried("force", force, S),
            None if acceleration is None else _carried("acceleration", acceleration, S),
        )

    @property
    def wrong(self) -> Iterator[Wrong]:
        """The entries that differ, part by part."""
        for quantity, own in self.yours.items():
            yield from entries.wrong_entries(quantity, own, self.right[quantity], self.sizes)

    @property
    def apart(self) -> dict[str, np.ndarray]:
        """How far each entry is from the reference's, relative to its size, part by part."""
        return {
            quantity: entries.deviations(own, self.right[quantity], self.sizes.of(quantity))
            for quantity, own in self.yours.items()
        }

    @cached_property
    def terms(self) -> ReferenceTerms | None:
        """Terms that belong in every entry; None where these cannot be told.

        They cannot if the map is not linear, nor at fewer states than an entry may have terms.
        """
        if self.frame.matrix is None:
            return None
        arm, chosen = self.problem.case.arm, self.problem.case.switches
        found = reference_terms_of(self.frame, arm, chosen, self.level)
        return found if self.problem.count >= states_wanted(found) else None

    @cached_property
    def forces(self) -> ForceDifferences:
        """The fit by which differences of forces are taken apart."""
        case, states = self.problem.case, self.states
        q, v, torque, rates = (np.array([s[k] for s in states]) for k in (3, 4, 5, 2))
        at = ForceStates(np.array([state.t for state in states]), q, v, torque)
        arm, chosen = case.arm, case.switches
        return ForceDifferences(self.frame, arm, chosen, at, rates, self.level)

    @cached_property
    def fitting(self) -> Fitting:
        """The fit by which differences of M's entries and of the bias's terms are taken apart."""
        assert self.terms is not None  # else nobody asks
        angles = np.array([state.q[self.frame.layout.theta] for state in self.states])
        return Fitting.of_waves(self.terms, angles)

    @cached_property
    def numbers(self) -> Mapping[str, float]:
        """The arm's quantities by the names of their symbols."""
        return values_of(self.problem.case.arm)

    @cached_property
    def demanded(self) -> Mapping[EntryPlace, Mapping[TermKey, float]]:
        """Differences of the bias that follow from the wrong entries of M, by place."""
        mass = {
            (wrong.place.row, wrong.place.column): self.observed(wrong.place).coefficients
            for wrong in self.wrong
            if wrong.place.column is not None
        }
        assert self.terms is not None  # else nobody asks
        return bias_of(mass, self.terms.angles)

    def follows(self, place: EntryPlace) -> bool:
        """Whether an entry of the bias is wrong for no other reason than M."""
        expected = self.demanded.get(place, {})
        return bool(expected) and follows(self.observed(place), expected)

    def difference(self, place: EntryPlace) -> tuple[np.ndarray, float]:
        """Yours minus right of an entry at every state (count,), and the entry's size."""
        quantity, beside = QUANTITIES[place.part], place.rates or ()
        index = (place.row, *beside) if place.column is None else (place.row, place.column)
        apart = self.yours[quantity] - self.right[quantity]
        return apart[(slice(None), *index)], float(self.sizes.of(quantity)[index])

    def observed(self, place: EntryPlace) -> Observed:
        """The difference of an entry, taken apart into waves and signals."""
        values, scale = self.difference(place)
        if place.part == "force":
            return self.forces.observed(values, scale)
        return self.fitting.fit(values, scale, self.numbers)


def _carried(quantity: str, values: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Values (count, ...) of a part, carried from x to coordinates y; S: dx/dy."""
    if quantity == "mass_matrix":
        return np.einsum("sij,ia,jb->sab", values, S, S)
    if quantity == "rate_terms":
        turned = np.einsum("sijk,ia,jb,kc->sabc", values, S, S, S, optimize=True)
        return np.array([paired(each) for each in turned])
    if quantity == "acceleration":
        return values @ np.linalg.inv(S).T
    return values @ S


def entry_questions(
    problem: VerificationProblem, levels: Sequence[str], quantities: Sequence[str]
) -> Iterator[StateQuestion]:
    """Questions for a look entry by entry: to the equations, and to each level's reference."""
    for level in levels:
        yield from sizing(problem, level)
        yield from (problem.ask(problem.reference(level), part) for part in quantities)
    yield from map(problem.yours, quantities)


def entry_quantities(problem: VerificationProblem) -> list[str]:
    """Parts that are compared entry by entry; the acceleration only where nothing else is there."""
    found = [quantity for part, quantity in BY_ENTRY.items() if part in problem.has]
    return found or ["acceleration"]


def compared(
    problem: VerificationProblem, level: str, quantities: Sequence[str], results: Results
) -> Compared:
    """Both answers to every part that both answer. Raises Unavailable without a reference's M."""
    reference = problem.reference(level)
    yours: dict[str, np.ndarray] = {}
    right: dict[str, np.ndarray] = {}
    for quantity in quantities:
        one = results.found(problem.yours(quantity))
        other = results.settled(problem.ask(reference, quantity))
        if one is not None and other is not None:
            yours[quantity], right[quantity] = one, other
    return Compared(problem, level, results, yours, right, problem.frame.symbolic)


def reasoned(arm: Compared, probes: Sequence[Compared]) -> list[Wrong]:
    """The wrong entries with their reasons; then those that only another arm shows.

    probes: the same on arms of the same structure and other numbers. Coordinates of a matrix are
    looked at in the built-in ones too: where fewer errors explain a part of the equations there,
    these are told.
    """
    if probes and probes[0].symbolic is not None and _is(probes[0].symbolic, arm):
        arm = replace(arm, symbolic=probes[0].symbolic)  # equal numbers are no symbol's own
    found = list(_reasons(arm, probes))
    if arm.problem.equations.coordinates.matrix is None:
        return found
    kinds = {(wrong.place.part, wrong.shown_on) for wrong in found if not wrong.notes}
    rank = 0 if arm.symbolic is not None else 2
    short = {kind: _length(_of(found, *kind), rank) for kind in kinds}
    spread = rank or any(length[:2] > (0, 1) for length in short.values())
    gearing = arm.problem.gearing
    built_in = [Coordinates(gearing), Coordinates(gearing, "absolute")]
    if gearing != "rigid":
        built_in += [replace(each, gears="angles") for each in built_in]
    for coordinates in built_in if spread else ():
        seen = arm.seen_in(coordinates)
        there = list(_reasons(seen, [probe.seen_in(coordinates) for probe in probes]))
        for kind, length in short.items():
            own = _of(there, *kind)
            if own and _length(own, 1) < length:
                short[kind] = _length(own, 1)
                found = [
                    _seen(wrong, own, seen) if wrong in _of(found, *kind) else wrong
                    for wrong in found
                ]
    return found


def _is(symbolic: sp.ImmutableMatrix, arm: Compared) -> bool:
    """Whether a map in symbols has the same numbers as the user's map of an arm."""
    values, matrix = values_of(arm.problem.case.arm), arm.problem.frame.matrix
    polynomials = [from_sympy(entry) for entry in symbolic]
    if matrix is None or None in polynomials:
        return False
    numbers = np.array(
        [sum(m.value(values) for m in e.monomials) for e in polynomials if e is not None]
    )
    off = np.abs(numbers.reshape(matrix.shape) - matrix)
    return bool((off <= SAME * np.abs(matrix).max(axis=1, keepdims=True)).all())


def _of(found: Sequence[Wrong], part: str, shown_on: str) -> list[Wrong]:
    return [w for w in found if (w.place.part, w.shown_on) == (part, shown_on) and not w.notes]


def _length(found: Sequence[Wrong], rank: int) -> tuple[int, int, int, int]:
    """How long an explanation is: unexplained entries, errors of the others, rank, all entries."""
    open_ones = sum(wrong.explanation is None for wrong in found)
    errors = {alike(e) for w in found if w.explanation for e in w.explanation.errors}
    return open_ones, len(errors), rank, len(found)


def _seen(wrong: Wrong, there: Sequence[Wrong], seen: Compared) -> Wrong:
    """A wrong entry, explained by those entries that make it in other coordinates."""
    turns = np.abs(np.linalg.inv(seen._columns_of(seen.frame)))  # dy/dx
    turns = turns > ROUNDING * turns.max(axis=1, keepdims=True)
    making = [each for each in there if _reaches(each.place, wrong.place, turns)]
    if not making or any(each.explanation is None for each in making):
        return wrong
    explanations = [each.explanation for each in making if each.explanation]
    ways = 1 + max(len(each.others) for each in explanations)
    told = []
    for way in range(ways):  # each error once; of each entry as likely ones as there are
        of_each = ((each.errors, *each.others) for each in explanations)
        errors = (error for own in of_each for error in own[min(way, len(own) - 1)])
        told.append(tuple({alike(error): error for error in errors}.values()))
    left = max(each.left_over for each in explanations)
    where = ", ".join(entries.named(each.place, seen.frame.names) for each in making)
    return replace(wrong, explanation=Explanation(told[0], left, tuple(told[1:]), where))


def _reaches(there: EntryPlace, here: EntryPlace, turns: np.ndarray) -> bool:
    """Whether an entry in y is a part of one in x; turns (n, n): where dy/dx is not 0."""
    pairs = [(there.row, here.row)]
    if there.column is not None and here.column is not None:
        pairs.append((there.column, here.column))
    if there.rates is not None and here.rates is not None:
        (j, k), (a, b) = there.rates, here.rates
        if not (turns[j, a] and turns[k, b]) and not (turns[j, b] and turns[k, a]):
            return False
    return all(turns[pair] for pair in pairs)


def _reasons(arm: Compared, probes: Sequence[Compared]) -> Iterator[Wrong]:
    seen = set()
    for wrong in arm.wrong:
        seen.add(wrong.place)
        yield _explained(wrong, arm, probes)
    for number, probe in enumerate(probes):
        for wrong in probe.wrong:
            if wrong.place not in seen:
                seen.add(wrong.place)
                hidden = _explained(wrong, probe, probes[number + 1 :])
                yield replace(hidden, shown_on=probe.problem.case.arm.name)


def _explained(wrong: Wrong, arm: Compared, others: Sequence[Compared]) -> Wrong:
    if arm.terms is None or wrong.place.part == "acceleration":
        return wrong
    if wrong.place.rates is not None and arm.follows(wrong.place):
        return replace(wrong, notes=(FOLLOWS,))
    symbolic = arm.problem.equations.symbolic
    if symbolic is not None and arm.seen is None:
        apart = symbolic_difference(wrong.place, symbolic, arm.terms, arm.numbers)
        wrong = replace(wrong, latex="" if apart is None else latex_of(apart))
    quantity = QUANTITIES[wrong.place.part]
    more = [other.observed(wrong.place) for other in others if quantity in other.yours]
    observed = arm.observed(wrong.place)
    if wrong.place.part == "force":
        values, scale = arm.difference(wrong.place)
        found = arm.forces.explain(wrong.place, values, scale, more)
    else:
        found = explain(wrong.place, [observed, *more], arm.terms)
    if found is not None or observed.left_over > UNEXPLAINED:
        return replace(wrong, explanation=found)
    return replace(wrong, difference=difference_of(observed.found, arm.terms))
