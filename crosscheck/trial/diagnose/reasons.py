"""Why entries are wrong: their differences on the arm, and on others, taken apart into slips."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crosscheck.planning.comparison import Results
from crosscheck.trial.diagnose.alternates import ForceDifferences
from crosscheck.trial.diagnose.dictionary import Dictionary, dictionary_of
from crosscheck.trial.diagnose.difference import NotWaves, symbolic_difference
from crosscheck.trial.diagnose.explain import Observed, explain
from crosscheck.trial.diagnose.force_terms import States
from crosscheck.trial.diagnose.keys import Key
from crosscheck.trial.diagnose.summary import bias_of, follows
from crosscheck.trial.diagnose.values import values_of
from crosscheck.trial.diagnose.waves import Fitting, states_wanted
from crosscheck.trial.judge.bench import Bench
from crosscheck.trial.judge.entries import PARTS, deviations, wrong_entries
from crosscheck.trial.judge.places import Place, Wrong
from crosscheck.trial.judge.sizes import Sizes
from crosscheck.trial.judge.suite import reference_of, sizes_in

FOLLOWS = "follows from the wrong M"
QUANTITIES = {part: quantity for quantity, part in PARTS.items() if quantity != "bias"}


@dataclass(frozen=True)
class Compared:
    """A model and the reference on one arm: yours minus right of every part, at every state."""

    bench: Bench
    level: str
    sizes: Sizes
    yours: Mapping[str, np.ndarray]
    right: Mapping[str, np.ndarray]

    @property
    def wrong(self) -> Iterator[Wrong]:
        """Entries that differ, part by part."""
        for quantity, own in self.yours.items():
            yield from wrong_entries(quantity, own, self.right[quantity], self.sizes)

    @property
    def apart(self) -> dict[str, np.ndarray]:
        """How far each entry is from the reference's, relative to its size, part by part."""
        return {
            quantity: deviations(own, self.right[quantity], self.sizes.of(quantity))
            for quantity, own in self.yours.items()
        }

    @cached_property
    def dictionary(self) -> Dictionary | None:
        """What belongs in every entry; None where that cannot be told.

        In coordinates that are no linear map, and at fewer states than an entry may have terms.
        """
        if self.bench.frame.matrix is None:
            return None
        arm, chosen = self.bench.case.arm, self.bench.case.switches
        found = dictionary_of(self.bench.frame, arm, chosen, self.level)
        return found if self.bench.count >= states_wanted(found) else None

    @cached_property
    def forces(self) -> ForceDifferences:
        """What forces are taken apart by."""
        case, states = self.bench.case, self.bench.states
        q, v, torque, rates = (np.array([s[k] for s in states]) for k in (3, 4, 5, 2))
        at = States(np.array([state.t for state in states]), q, v, torque)
        arm, chosen = case.arm, case.switches
        return ForceDifferences(self.bench.frame, arm, chosen, at, rates, self.level)

    @cached_property
    def fitting(self) -> Fitting:
        """What entries of M and terms of the bias are taken apart by."""
        assert self.dictionary is not None  # else nobody asks
        layout = self.bench.frame.layout
        angles = np.array([state.q[layout.theta] for state in self.bench.states])
        return Fitting.of_waves(self.dictionary, angles)

    @cached_property
    def demanded(self) -> Mapping[Place, Mapping[Key, float]]:
        """What the wrong entries of M make of a bias that follows from them."""
        mass = {
            (wrong.place.row, wrong.place.column): self.observed(wrong.place).coefficients
            for wrong in self.wrong
            if wrong.place.column is not None
        }
        assert self.dictionary is not None  # else nobody asks
        return bias_of(mass, self.dictionary.angles)

    def follows(self, place: Place) -> bool:
        """Whether a bias is wrong for no other reason than M."""
        expected = self.demanded.get(place, {})
        return bool(expected) and follows(self.observed(place), expected)

    def difference(self, place: Place) -> tuple[np.ndarray, float]:
        """Yours minus right of an entry at every state (count,), and the entry's size."""
        quantity, index = QUANTITIES[place.part], _index(place)
        apart = self.yours[quantity] - self.right[quantity]
        return apart[(slice(None), *index)], float(self.sizes.of(quantity)[index])

    def observed(self, place: Place) -> Observed:
        """The same, taken apart."""
        values, scale = self.difference(place)
        if place.part == "force":
            return self.forces.observed(values, scale)
        fit = self.fitting.fit(values, scale)
        arm = values_of(self.bench.case.arm)
        return Observed(arm, fit.coefficients, fit.noise, fit.left_over)


def _index(place: Place) -> tuple[int, ...]:
    if place.rates is not None:
        return (place.row, *place.rates)
    return (place.row,) if place.column is None else (place.row, place.column)


def compared(bench: Bench, level: str, quantities: Sequence[str], results: Results) -> Compared:
    """Of every part that both answer. Raises Unavailable without a reference's inertia."""
    reference = reference_of(bench, level)
    yours: dict[str, np.ndarray] = {}
    right: dict[str, np.ndarray] = {}
    for quantity in quantities:
        one = results.found(bench.yours(quantity))
        other = results.settled(bench.ask(reference, quantity))
        if one is not None and other is not None:
            yours[quantity], right[quantity] = one, other
    return Compared(bench, level, sizes_in(bench, results, level), yours, right)


def reasoned(arm: Compared, probes: Sequence[Compared]) -> Iterator[Wrong]:
    """The wrong entries with their reasons; then those that only another arm shows.

    probes: the same on arms of the same structure and other numbers.
    """
    seen = set()
    for wrong in arm.wrong:
        seen.add(wrong.place)
        yield _explained(wrong, arm, probes)
    for number, probe in enumerate(probes):
        for wrong in probe.wrong:
            if wrong.place not in seen:
                seen.add(wrong.place)
                hidden = _explained(wrong, probe, probes[number + 1 :])
                yield replace(hidden, shown_on=probe.bench.case.arm.name)


def _explained(wrong: Wrong, arm: Compared, others: Sequence[Compared]) -> Wrong:
    if arm.dictionary is None or wrong.place.part == "acceleration":
        return wrong
    if wrong.place.rates is not None and arm.follows(wrong.place):
        return replace(wrong, notes=(FOLLOWS,))
    exact = _in_symbols(wrong, arm)
    if exact is not None:
        return exact
    quantity = QUANTITIES[wrong.place.part]
    more = [other.observed(wrong.place) for other in others if quantity in other.yours]
    if wrong.place.part == "force":
        values, scale = arm.difference(wrong.place)
        return replace(wrong, explanation=arm.forces.explain(wrong.place, values, scale, more))
    observed = [arm.observed(wrong.place), *more]
    return replace(wrong, explanation=explain(wrong.place, observed, arm.dictionary))


def _in_symbols(wrong: Wrong, arm: Compared) -> Wrong | None:
    """Of symbolic equations, if they can be taken apart."""
    symbolic, dictionary = arm.bench.equations.symbolic, arm.dictionary
    if symbolic is None or dictionary is None:
        return None
    values = values_of(arm.bench.case.arm)
    try:
        found = symbolic_difference(wrong.place, symbolic, dictionary, values)
    except NotWaves:
        return None
    if found is None:
        return None
    return replace(wrong, explanation=found.explanation, latex=found.latex)
