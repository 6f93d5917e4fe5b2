"""Why entries are wrong: their differences on the arm, and on others, taken apart into errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations

import numpy as np
import sympy as sp

from crosscheck.planning.comparison import Results
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.differences import fold_rate_pairs
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.coordinates.states import UserState
from crosscheck.trial.diagnose.mistake_search import (
    BEHIND,
    MatchingMistake,
    PartDifference,
    find_mistakes,
)
from crosscheck.trial.diagnose.mistakes import Derivation
from crosscheck.trial.diagnose.terms.accelerations import BalanceBasis
from crosscheck.trial.diagnose.terms.angle_units import SampledDifference, explain_by_unit
from crosscheck.trial.diagnose.terms.explain import (
    UNEXPLAINED,
    compute_bias_differences,
    error_signature,
    explain,
    is_caused_by_mass,
)
from crosscheck.trial.diagnose.terms.force_variants import ForceDifferences
from crosscheck.trial.diagnose.terms.harmonic_fit import (
    HarmonicBasis,
    HarmonicFit,
    minimum_state_count,
)
from crosscheck.trial.diagnose.terms.messages import (
    compute_symbolic_difference,
    format_latex,
    make_difference_terms,
)
from crosscheck.trial.diagnose.terms.polynomial import TermKey, from_sympy
from crosscheck.trial.diagnose.terms.reference_terms import (
    ForceStates,
    ReferenceTerms,
    build_reference_terms,
)
from crosscheck.trial.diagnose.terms.values import collect_arm_values
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge import entries
from crosscheck.trial.judge.entries import (
    EntryMismatch,
    EntryPlace,
    Explanation,
    NaturalSizes,
    Part,
    Term,
    TermError,
)
from crosscheck.trial.judge.questions import StateQuestion, VerificationProblem
from crosscheck.trial.judge.suite import (
    compute_natural_sizes,
    get_trusted_answers,
    make_size_questions,
)

SAME = 1e-12  # tolerance between two readings of a map, relative to its row
ROUNDING = 1e-10  # largest entry of dy/dx that counts as 0, relative to its row
# Where each part is looked at entry by entry.
BY_ENTRY = {
    "mass_matrix": "mass_matrix",
    "bias": "rate_terms",
    "gravity": "gravity",
    "force": "force",
}
OPPOSITE = 1e-9  # tolerance of the sum of two opposite entries, relative to them
MOST_EQUAL = 6  # mistakes that make the same, beside the first
MOST_ERRORS = 2  # errors of a part, above which one mistake in some of its entries is likelier
FOLLOWS = "follows from the wrong M"
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
        S = np.linalg.inv(self._coordinate_jacobian(self.frame))
        return [state._replace(x=S @ state.x, u=S @ state.u) for state in self.problem.states]

    @cached_property
    def sizes(self) -> NaturalSizes:
        """Natural sizes of the entries in the coordinates in use."""
        if self.coordinates is None:
            return compute_natural_sizes(self.problem, self.results, self.level)
        S = self._coordinate_jacobian(self.frame)
        trusted = get_trusted_answers(self.problem, self.results, self.level)
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
        terms = build_reference_terms(
            self.frame, arm, chosen, self.level, has_gravity=self.problem.has_gravity
        )
        return terms if self.problem.count >= minimum_state_count(terms) else None

    @cached_property
    def forces(self) -> ForceDifferences:
        """The fit by which differences of forces are taken apart."""
        case, states = self.problem.case, self.states
        q, v, torque, rates = (np.array([s[k] for s in states]) for k in (3, 4, 5, 2))
        at = ForceStates(np.array([state.t for state in states]), q, v, torque)
        arm, chosen = case.arm, case.switches
        if self.problem.has_gravity:
            arm = arm.model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
        return ForceDifferences(self.frame, arm, chosen, at, rates, self.level)

    @cached_property
    def harmonic_basis(self) -> HarmonicBasis:
        """The fit by which differences of M's entries and of the bias's terms are taken apart."""
        assert self.terms is not None  # else nobody asks
        angles = np.array([state.q[self.frame.layout.theta] for state in self.states])
        return HarmonicBasis.from_angle_sums(self.terms, angles)

    @cached_property
    def numbers(self) -> Mapping[str, float]:
        """The arm's quantities by the names of their symbols."""
        return collect_arm_values(self.problem.case.arm)

    @cached_property
    def derivation(self) -> Derivation:
        """The derivation of what is right, and its mistakes. Only of a linear map."""
        x = np.array([state.x for state in self.states])
        arm = self.problem.case.arm
        return Derivation(self.frame, arm, self.level, self.numbers, x)

    def sample_part(self, quantity: str) -> PartDifference:
        """Difference of a part at every state; for accelerations, the force that causes it."""
        difference = self.user_values[quantity] - self.reference_values[quantity]
        sizes, tolerance = self.sizes.entry_sizes(quantity), self.sizes.tolerance(quantity)
        if quantity != "acceleration":
            unit = np.where(sizes > 0, sizes, 1.0)
            sign = -1.0 if quantity == "gravity" else 1.0  # of the force that the weights are
            return PartDifference(self.derivation, sign * difference, unit, tolerance)
        mass = get_trusted_answers(self.problem, self.results, self.level).mass
        a, u = self.user_values[quantity], np.array([state.u for state in self.states])
        forces = np.einsum("sij,sj->si", mass, difference)
        return PartDifference(self.derivation, forces, self.sizes.force, tolerance, a, u)

    @cached_property
    def bias_from_mass(self) -> Mapping[EntryPlace, Mapping[TermKey, float]]:
        """Differences of the bias that follow from the wrong entries of M, by place."""
        mass = {
            (wrong.place.row, wrong.place.column): self.fit_difference(wrong.place).coefficients
            for wrong in self.wrong_entries
            if wrong.place.column is not None
        }
        assert self.terms is not None  # else nobody asks
        return compute_bias_differences(mass, self.terms.angles)

    def is_caused_by_mass(self, place: EntryPlace) -> bool:
        """Whether an entry of the bias is wrong for no other reason than M."""
        expected = self.bias_from_mass.get(place, {})
        return bool(expected) and is_caused_by_mass(self.fit_difference(place), expected)

    def has_weight_twice(self, place: EntryPlace) -> bool:
        """Whether an entry of the force has the weights too, which are a part of their own."""
        gravity = self.user_values.get("gravity")
        if gravity is None:
            return False
        difference, size = self.difference(place)
        left = np.abs(difference + gravity[:, place.row]).max()
        return bool(left <= self.sizes.tolerance("force") * size)

    def difference(self, place: EntryPlace) -> tuple[np.ndarray, float]:
        """Yours minus right of an entry at every state (count,), and the entry's size."""
        quantity, index = QUANTITIES[place.part], _find_index(place)
        differences = self.user_values[quantity] - self.reference_values[quantity]
        return differences[(slice(None), *index)], float(self.sizes.entry_sizes(quantity)[index])

    def sample_difference(self, place: EntryPlace) -> SampledDifference:
        """The difference of an entry at every state, beside what its terms are made of there."""
        difference, size = self.difference(place)
        angles = np.array([state.q[self.frame.layout.theta] for state in self.states])
        signals = self.forces.signals if place.part == "force" else {}
        return SampledDifference(difference, size, self.numbers, angles, signals)

    def fit_difference(self, place: EntryPlace) -> HarmonicFit:
        """The difference of an entry, taken apart into waves and signals."""
        values, scale = self.difference(place)
        if place.part == "force":
            return self.forces.fit_difference(values, scale)
        return self.harmonic_basis.fit(values, scale, self.numbers)


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


def list_entry_questions(
    problem: VerificationProblem, levels: Sequence[str], quantities: Sequence[str]
) -> Iterator[StateQuestion]:
    """Questions for a look entry by entry: to the equations, and to each level's reference."""
    for level in levels:
        yield from make_size_questions(problem, level)
        yield from (problem.ask(problem.reference(level), part) for part in quantities)
    yield from map(problem.ask_equations, quantities)


def list_entry_quantities(problem: VerificationProblem) -> list[str]:
    """Parts that are compared entry by entry; the acceleration only where nothing else is there."""
    quantities = [quantity for part, quantity in BY_ENTRY.items() if part in problem.has]
    return quantities or ["acceleration"]


def compare_entries(
    problem: VerificationProblem, level: str, quantities: Sequence[str], results: Results
) -> EntryComparison:
    """Both answers to every part that both answer. Raises MissingResult without a reference's M."""
    reference = problem.reference(level)
    user_values: dict[str, np.ndarray] = {}
    reference_values: dict[str, np.ndarray] = {}
    for quantity in quantities:
        user_answer = results.get(problem.ask_equations(quantity))
        reference_answer = results.get_if_finished(problem.ask(reference, quantity))
        if user_answer is not None and reference_answer is not None:
            user_values[quantity], reference_values[quantity] = user_answer, reference_answer
    return EntryComparison(
        problem, level, results, user_values, reference_values, problem.frame.symbolic
    )


def explain_entries(arm: EntryComparison, probes: Sequence[EntryComparison]) -> list[EntryMismatch]:
    """The wrong entries with their reasons; then those that only another arm shows.

    probes: the same on arms of the same structure and other numbers. Coordinates of a matrix are
    looked at in the built-in ones too: where fewer errors explain a part of the equations there,
    these are reported.
    """
    if probes and probes[0].symbolic is not None and _is_same_map(probes[0].symbolic, arm):
        arm = replace(arm, symbolic=probes[0].symbolic)  # equal numbers are no symbol's own
    if set(arm.user_values) == {"acceleration"} and arm.terms is not None:
        return list(_explain_accelerations(arm, probes))
    wrong_entries = list(_name_moved_terms(arm, list(_explain_arms(arm, probes))))
    wrong_entries = list(_name_mistakes((arm, *probes), wrong_entries))
    if arm.problem.equations.coordinates.matrix is None:
        return wrong_entries
    groups = {(wrong.place.part, wrong.shown_on) for wrong in wrong_entries if not wrong.notes}
    rank = 0 if arm.symbolic is not None else 2
    short = {
        group: _explanation_length(_select_group(wrong_entries, *group), rank) for group in groups
    }
    spread = any(rank or length[:2] > (0, 1) for length in short.values())
    gearing = arm.problem.gearing
    built_in = [Coordinates(gearing), Coordinates(gearing, "absolute")]
    if gearing != "rigid":
        built_in += [replace(each, gears="angles") for each in built_in]
    for coordinates in built_in if spread else ():
        seen = arm.transform_to(coordinates)
        there = list(_explain_arms(seen, [probe.transform_to(coordinates) for probe in probes]))
        for group, length in short.items():
            group_entries = _select_group(there, *group)
            if group_entries and _explanation_length(group_entries, 1) < length:
                short[group] = _explanation_length(group_entries, 1)
                wrong_entries = [
                    _explain_in_coordinates(wrong, group_entries, seen)
                    if wrong in _select_group(wrong_entries, *group)
                    else wrong
                    for wrong in wrong_entries
                ]
    return wrong_entries


def _explain_accelerations(
    arm: EntryComparison, probes: Sequence[EntryComparison]
) -> Iterator[EntryMismatch]:
    """The wrong entries of accelerations alone: by what M times their difference is of the force.

    That is reported if it explains every row; otherwise, what is wrong in M and bias too.
    """
    comparisons = arm, *probes
    pushed = [_balance_accelerations(each) for each in comparisons]
    rows = [each for each in _explain_arms(pushed[0], pushed[1:]) if not each.shown_on]
    explanations = {each.place: each.explanation for each in rows if each.explanation}
    if not rows or len(explanations) < len(rows):
        explanations = _explain_balances(comparisons, pushed, [each.place.row for each in rows])
    errors = {error_signature(e): e for each in explanations.values() for e in each.errors}
    if len(errors) != 1 and (explanation := _explain_by_mistakes_behind(comparisons)):
        for wrong in _explain_arms(arm, probes):
            yield wrong if wrong.shown_on else replace(wrong, explanation=explanation)
        return
    if not explanations:
        yield from _explain_arms(arm, probes)
        return
    names = arm.frame.names
    where = ", ".join(entries.format_entry(place, names) for place in explanations)
    left = max(each.left_over for each in explanations.values())
    explanation = Explanation(tuple(errors.values()), left, (), f"{where}, which M x'' shows")
    for wrong in _explain_arms(arm, probes):
        yield wrong if wrong.shown_on else replace(wrong, explanation=explanation)


def _explain_balances(
    comparisons: Sequence[EntryComparison], pushed: Sequence[EntryComparison], rows: Sequence[int]
) -> dict[EntryPlace, Explanation]:
    """Explanations of all entries that are wrong behind accelerations; none if one has none.

    pushed: of the same arms, with the forces that M makes of the accelerations.
    """
    fits: list[dict[EntryPlace, HarmonicFit]] = [{} for _ in comparisons]
    for each, forced, of_arm in zip(comparisons, pushed, fits, strict=True):
        if each.terms is None or "force" not in forced.user_values:
            return {}
        basis = BalanceBasis(
            each.terms,
            each.forces.angles,
            each.user_values["acceleration"],
            np.array([state.u for state in each.states]),
            each.forces.signals,
            each.forces.harmonic_basis.keys,
        )
        if not basis.is_determined:
            return {}
        for row in rows:
            values, scale = forced.difference(EntryPlace("force", row))
            of_arm |= basis.fit(row, values, scale, each.numbers)
    terms, here = comparisons[0].terms, fits[0]
    assert terms is not None  # as just seen
    mass = {
        (place.row, place.column): fit.significant_coefficients
        for place, fit in here.items()
        if place.column is not None
    }
    follows = compute_bias_differences(mass, terms.angles)
    wrong_fits = {
        place: [of_arm[place] for of_arm in fits if place in of_arm]
        for place, fit in here.items()
        if fit.significant_coefficients
        and not (follows.get(place) and is_caused_by_mass(fit, follows[place]))
    }
    for row in rows:  # one wrong throughout may be the right one times a number, and its torque not
        if {place for place in terms.entries if place.row == row} <= set(wrong_fits):
            return {}
    explanations = {p: explain(p, observed, terms) for p, observed in wrong_fits.items()}
    explained = {place: each for place, each in explanations.items() if each is not None}
    return explained if len(explained) == len(explanations) else {}


def _balance_accelerations(comparison: EntryComparison) -> EntryComparison:
    """The comparison of the forces that M makes of accelerations, beside the right force."""
    problem, level = comparison.problem, comparison.level
    mass, force, *_ = get_trusted_answers(problem, comparison.results, level)
    if force is None:
        return replace(comparison, user_values={}, reference_values={})
    key = "acceleration"
    difference = comparison.user_values[key] - comparison.reference_values[key]
    pushed = force + np.einsum("sij,sj->si", mass, difference)
    return replace(comparison, user_values={"force": pushed}, reference_values={"force": force})


def _name_moved_terms(
    arm: EntryComparison, wrong_entries: Sequence[EntryMismatch]
) -> Iterator[EntryMismatch]:
    """The wrong entries, a term of the bias that stands before other rates or in another row.

    It is missing in its own place, and the difference in the other is the opposite.
    """
    moved, names = dict[EntryPlace, Explanation](), arm.frame.names
    open_entries = [w for w in wrong_entries if w.place.rates and not (w.notes or w.shown_on)]
    for here, there in permutations(open_entries, 2):
        in_row = here.place.row == there.place.row
        if here.explanation is None or not (in_row or here.place.rates == there.place.rates):
            continue
        error, *more = here.explanation.errors
        if more or error.kind != "dropped":
            continue
        (left, size), (right, other) = map(arm.difference, (here.place, there.place))
        if np.abs(left + right).max() <= OPPOSITE * max(np.abs(left).max(), size, other):
            yours, belongs = (
                entries.format_rates(place.rates or (0, 0), names)
                if in_row
                else f"row {names[place.row]}"
                for place in (there.place, here.place)
            )
            error = replace(error, kind="swapped", yours=yours, right=belongs)
            explanation = replace(here.explanation, errors=(error,), others=())
            moved |= {here.place: explanation, there.place: explanation}
    for each in wrong_entries:
        yield replace(each, explanation=moved.get(each.place, each.explanation))


def _name_mistakes(
    comparisons: Sequence[EntryComparison], wrong_entries: Sequence[EntryMismatch]
) -> Iterator[EntryMismatch]:
    """The wrong entries, those of a part that no single error makes by a derivation's mistake."""
    explanations = dict[EntryPlace, Explanation]()
    open_entries = [w for w in wrong_entries if not (w.notes or w.shown_on)]
    for part in dict.fromkeys(wrong.place.part for wrong in open_entries):
        group = [wrong for wrong in open_entries if wrong.place.part == part]
        explanations |= _explain_by_mistakes(comparisons, part, group)
    for each in wrong_entries:
        yield (
            each
            if each.shown_on
            else replace(each, explanation=explanations.get(each.place, each.explanation))
        )


def _explain_by_mistakes(
    comparisons: Sequence[EntryComparison], part: Part, group: Sequence[EntryMismatch]
) -> dict[EntryPlace, Explanation]:
    """Explanations of wrong entries of a part by one mistake; of open ones by one each."""
    quantity = QUANTITIES[part]
    errors = {error_signature(e): e for w in group if w.explanation for e in w.explanation.errors}
    is_single = len(errors) == 1 and all(wrong.explanation for wrong in group)
    if is_single and {e.kind for e in errors.values()}.isdisjoint(("swapped", "extra")):
        return {}
    if any(each.terms is None or quantity not in each.user_values for each in comparisons):
        return {}
    indices = {_find_index(wrong.place): wrong for wrong in group}
    wrong = np.zeros(comparisons[0].user_values[quantity].shape[1:], dtype=bool)
    wrong[tuple(np.transpose([*indices]))] = True
    if comparisons[0].problem.has_gravity and part == "force":
        return {}  # without weights there is nothing to derive
    derived: Part = "force" if part == "gravity" else part
    matching = find_mistakes(
        [each.sample_part(quantity) for each in comparisons], wrong, (derived,)
    )
    is_swap = is_single and all(e.kind == "swapped" for e in errors.values())
    is_open = len(errors) > MOST_ERRORS or not all(wrong.explanation for wrong in group)
    making = [each for each in matching if each.covers.sum() == wrong.sum()]
    making = [each for each in making if each.is_whole or is_open]
    if part == "bias" and "mass_matrix" in comparisons[0].user_values and not is_open:
        # M is right: rather a term is wrong than the energy that M and bias both come from.
        making = [each for each in making if each.parts == (part,)]
    if making and (not is_swap or making[0].error.kind == "exchanged"):
        explanation = _make_explanation(
            [each for each in making if each.is_whole == making[0].is_whole]
        )
        return {wrong.place: explanation for wrong in group}
    explanations = dict[EntryPlace, Explanation]()
    for index, entry in indices.items():
        making = [each for each in matching if each.covers[index]]
        if making and (entry.explanation is None or len(entry.explanation.errors) > 1):
            equal = [each for each in making if (each.covers == making[0].covers).all()]
            explanations[entry.place] = _make_explanation(equal)
    return explanations


def _explain_by_mistakes_behind(comparisons: Sequence[EntryComparison]) -> Explanation | None:
    """The explanation of accelerations by a mistake in all of the equations, or in some parts."""
    quantity = "acceleration"
    if any(each.terms is None or quantity not in each.user_values for each in comparisons):
        return None
    arms = [each.sample_part(quantity) for each in comparisons]
    every = np.ones(arms[0].sizes.shape, dtype=bool)
    for parts in BEHIND:
        if matching := [each for each in find_mistakes(arms, every, parts) if each.is_whole]:
            seen = [part for part in matching[0].parts if part in parts]
            where = " and ".join(part.replace("mass_matrix", "M") for part in seen)
            return _make_explanation(matching, f"{where}, which M x'' shows")
    return None


def _find_index(place: EntryPlace) -> tuple[int, ...]:
    """Where an entry stands in the arrays of its part."""
    beside = place.rates or () if place.column is None else (place.column,)
    return (place.row, *beside)


def _make_explanation(matching: Sequence[MatchingMistake], seen_in: str = "") -> Explanation:
    """The first of mistakes that make the same, and the others beside it."""
    first, *others = (each.error for each in matching[: MOST_EQUAL + 1])
    return Explanation((first,), 0.0, tuple((each,) for each in others), seen_in)


def _is_same_map(symbolic: sp.ImmutableMatrix, arm: EntryComparison) -> bool:
    """Whether a map in symbols has the same numbers as the user's map of an arm."""
    values, matrix = collect_arm_values(arm.problem.case.arm), arm.problem.frame.matrix
    polynomials = [from_sympy(entry) for entry in symbolic]
    if matrix is None or None in polynomials:
        return False
    numbers = np.array(
        [sum(m.value(values) for m in e.monomials) for e in polynomials if e is not None]
    )
    off = np.abs(numbers.reshape(matrix.shape) - matrix)
    return bool((off <= SAME * np.abs(matrix).max(axis=1, keepdims=True)).all())


def _select_group(
    wrong_entries: Sequence[EntryMismatch], part: str, shown_on: str
) -> list[EntryMismatch]:
    return [
        w for w in wrong_entries if (w.place.part, w.shown_on) == (part, shown_on) and not w.notes
    ]


def _explanation_length(
    wrong_entries: Sequence[EntryMismatch], rank: int
) -> tuple[int, int, int, int]:
    """Length of an explanation: unexplained entries, errors in the others, rank, all entries."""
    open_ones = sum(wrong.explanation is None for wrong in wrong_entries)
    errors = {
        error_signature(e) for w in wrong_entries if w.explanation for e in w.explanation.errors
    }
    return open_ones, len(errors), rank, len(wrong_entries)


def _explain_in_coordinates(
    wrong: EntryMismatch, there: Sequence[EntryMismatch], comparison: EntryComparison
) -> EntryMismatch:
    """A wrong entry, explained by those entries that make it in other coordinates."""
    turns = np.abs(np.linalg.inv(comparison._coordinate_jacobian(comparison.frame)))  # dy/dx
    turns = turns > ROUNDING * turns.max(axis=1, keepdims=True)
    making = [each for each in there if _is_part_of(each.place, wrong.place, turns)]
    if not making or any(each.explanation is None for each in making):
        return wrong
    explanations = [each.explanation for each in making if each.explanation]
    ways = 1 + max(len(each.others) for each in explanations)
    error_sets = []
    for way in range(ways):  # each error once; of each entry as likely ones as there are
        of_each = ((each.errors, *each.others) for each in explanations)
        errors = (
            error
            for alternatives in of_each
            for error in alternatives[min(way, len(alternatives) - 1)]
        )
        error_sets.append(tuple({error_signature(error): error for error in errors}.values()))
    left = max(each.left_over for each in explanations)
    where = ", ".join(entries.format_entry(each.place, comparison.frame.names) for each in making)
    return replace(
        wrong, explanation=Explanation(error_sets[0], left, tuple(error_sets[1:]), where)
    )


def _is_part_of(there: EntryPlace, here: EntryPlace, turns: np.ndarray) -> bool:
    """Whether an entry in y is a part of one in x; turns (n, n): where dy/dx is not 0."""
    pairs = [(there.row, here.row)]
    if there.column is not None and here.column is not None:
        pairs.append((there.column, here.column))
    if there.rates is not None and here.rates is not None:
        (j, k), (a, b) = there.rates, here.rates
        if not (turns[j, a] and turns[k, b]) and not (turns[j, b] and turns[k, a]):
            return False
    return all(turns[pair] for pair in pairs)


def _explain_arms(
    arm: EntryComparison, probes: Sequence[EntryComparison]
) -> Iterator[EntryMismatch]:
    seen = set()
    for wrong in arm.wrong_entries:
        seen.add(wrong.place)
        yield _explain_entry(wrong, arm, probes)
    for number, probe in enumerate(probes):
        for wrong in probe.wrong_entries:
            if wrong.place not in seen:
                seen.add(wrong.place)
                hidden = _explain_entry(wrong, probe, probes[number + 1 :])
                yield replace(hidden, shown_on=probe.problem.case.arm.name)


def _explain_entry(
    wrong: EntryMismatch, arm: EntryComparison, others: Sequence[EntryComparison]
) -> EntryMismatch:
    if arm.terms is None or wrong.place.part == "acceleration":
        return wrong
    if wrong.place.rates is not None and arm.is_caused_by_mass(wrong.place):
        return replace(wrong, notes=(FOLLOWS,))
    symbolic = arm.problem.equations.symbolic
    if symbolic is not None and arm.coordinates is None:
        difference = compute_symbolic_difference(wrong.place, symbolic, arm.terms, arm.numbers)
        wrong = replace(wrong, latex="" if difference is None else format_latex(difference))
    quantity = QUANTITIES[wrong.place.part]
    more = [other.fit_difference(wrong.place) for other in others if quantity in other.user_values]
    observed = arm.fit_difference(wrong.place)
    if observed.left_over > UNEXPLAINED:
        samples = [
            each.sample_difference(wrong.place)
            for each in (arm, *others)
            if quantity in each.user_values
        ]
        explanation = explain_by_unit(wrong.place, samples, arm.terms)
        if explanation is not None:
            return replace(wrong, explanation=explanation)
    if wrong.place.part == "force":
        values, scale = arm.difference(wrong.place)
        if arm.has_weight_twice(wrong.place):
            weight = TermError("extra", Term("the weight of every body"), right="gravity")
            return replace(wrong, explanation=Explanation((weight,), 0.0))
        explanation = arm.forces.explain(wrong.place, values, scale, more)
    else:
        explanation = explain(wrong.place, [observed, *more], arm.terms)
    if explanation is not None or observed.left_over > UNEXPLAINED:
        return replace(wrong, explanation=explanation)
    return replace(
        wrong, difference=make_difference_terms(observed.significant_coefficients, arm.terms)
    )
