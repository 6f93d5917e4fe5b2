"""When a setting supports a claim, and the verdict over all settings.

In a setting a claim is true in a share of the starts. It is true there unless they show, with 95 %
confidence, that in fewer than MOST it would be; false unless they show that in more than FEW; where
they show both, the start decides: the setting is bistable. Undefined starts are not counted;
where they are most, the setting is undefined: what happens in few starts may be chance.
Over all settings of a model of the gears, or of several, a verdict that depends on how bistable
settings are counted is `bistable`; undefined settings are counted by themselves.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from itertools import combinations
from typing import Any, NamedTuple, Protocol

import numpy as np
from scipy.special import betaincinv

from crosscheck.audit.judging import quantities
from crosscheck.audit.judging.quantities import Choices, ConditionResults, Quantity

MOST, FEW = 0.9, 0.1
DEFINED = 0.5  # of the starts: where the event is rarer, a setting says nothing of it
PARTS = (0.1, 0.5, 0.9)
READ_OFF = 0.1  # of a value: how well it is read off a plot, whatever it is and whoever reads it
PLOT = "a tenth: read off a plot"
FORETELLS = 0.5  # at least half of the wrong guesses are saved
CONFIDENCE = 0.95


class Share(NamedTuple):
    """A share: how many of several starts, at least one, are a yes."""

    yes: int
    of: int

    def __str__(self) -> str:
        return f"{self.yes} of {self.of}"

    @property
    def interval(self) -> tuple[float, float]:
        """Clopper and Pearson's 95 % interval of the probability."""
        return _interval(self.yes, self.of)


def share_of(answers: Iterable[bool | None]) -> Share | None:
    """The share of yes among the answers that are known; None if none is."""
    defined_answers = [answer for answer in answers if answer is not None]
    return Share(sum(defined_answers), len(defined_answers)) if defined_answers else None


@cache
def _interval(yes: int, of: int) -> tuple[float, float]:
    beyond = (1 - CONFIDENCE) / 2  # Clopper and Pearson's interval
    low = betaincinv(yes, of - yes + 1, beyond) if yes else 0.0
    high = betaincinv(yes + 1, of - yes, 1 - beyond) if yes < of else 1.0
    return float(low), float(high)


@dataclass(frozen=True)
class Limits:
    """Limits that a value supports if low < value < high; because: why these."""

    low: float = -math.inf
    high: float = math.inf
    because: str = ""

    def count_inside(self, ascending: Sequence[float]) -> int:
        """How many of the defined values lie within the limits."""
        return max(0, bisect_left(ascending, self.high) - bisect_right(ascending, self.low))

    def __str__(self) -> str:
        if math.isinf(self.low):
            return f"< {self.high:g}"
        return f"> {self.low:g}" if math.isinf(self.high) else f"{self.low:g} to {self.high:g}"


@dataclass(frozen=True)
class Claim:
    """A statement of the paper, and the number that decides it.

    id: section and a number that no other statement ever gets; statement: paraphrased; quantity:
    one, or one for each choice of ``free``, a parameter that the paper does not give (the first is
    the default); reading: how the statement is understood, where it could be otherwise.
    """

    id: str
    figure: int | None
    statement: str
    quantity: Quantity | Choices
    limits: Limits
    free: str = ""
    reading: str = ""

    @property
    def section(self) -> str:
        """The paper's section, which the id begins with."""
        return self.id.rpartition("-")[0]

    @property
    def choices(self) -> dict[str, Quantity]:
        """The quantity under every choice of the free parameter."""
        return {"": self.quantity} if isinstance(self.quantity, Quantity) else dict(self.quantity)

    @property
    def static(self) -> bool:
        """Whether the claim follows from the arm's data alone: no starts, laws or damping then."""
        return all(quantity.static for quantity in self.choices.values())


class State(StrEnum):
    """What a setting says of a claim."""

    YES = "yes"
    NO = "no"
    BISTABLE = "bistable"
    UNDEFINED = "undefined"


class JudgedSetting(Protocol):
    """A setting of a study: what the paper leaves open, decided."""

    @property
    def conditions(self) -> Mapping[str, Hashable]:
        """The value of each condition by its name, in the order in which verdicts name them."""
        ...

    @property
    def static_conditions(self) -> Mapping[str, Hashable]:
        """Those conditions that decide the data alone."""
        ...


class Place(NamedTuple):
    """The place where an answer was found: values by the names of conditions.

    A static claim has those alone that its data depend on; choice: of the claim's free parameter.
    """

    conditions: tuple[tuple[str, Hashable], ...] = ()
    choice: str = ""

    def value_of(self, name: str) -> Any:
        """The value of a condition; None if nothing depends on it."""
        return dict(self.conditions).get(name)


@dataclass(frozen=True)
class Answer:
    """The answer to a claim in one setting under one choice; values: the defined ones, ascending.

    Of starts that were run: those that others stand for would be counted twice.
    """

    place: Place
    values: tuple[float, ...]
    starts: int
    limits: Limits

    @property
    def undefined(self) -> int:
        """How many starts have a run that lacks what the claim is about."""
        return self.starts - len(self.values)

    @property
    def share(self) -> Share | None:
        """The share of the defined starts that support the claim; None if too few are defined."""
        return self.share_at(self.limits)

    def share_at(self, limits: Limits) -> Share | None:
        """The share of defined starts that support the claim with other limits; None if too few."""
        if len(self.values) < max(1.0, DEFINED * self.starts):
            return None
        return Share(limits.count_inside(self.values), len(self.values))

    @property
    def state(self) -> State:
        """What the setting says of the claim."""
        return state(self.share)

    @property
    def yes(self) -> int:
        """How many of the defined starts support the claim."""
        return self.limits.count_inside(self.values)

    @property
    def median(self) -> float | None:
        """The median of the values, that of a start; None without any."""
        return self.quantiles[1] if self.quantiles else None

    @property
    def quantiles(self) -> tuple[float, ...] | None:
        """The quantiles PARTS of the values, each the value of a start; None without any."""
        if not self.values:
            return None
        return tuple(map(float, np.quantile(self.values, PARTS, method="inverted_cdf")))


def collect_answer(place: Place, values: np.ndarray, limits: Limits) -> Answer:
    """The answer that the values of all starts give, (starts,), nan where undefined."""
    defined_values = tuple(map(float, np.sort(values[np.isfinite(values)])))
    return Answer(place, defined_values, values.size, limits)


def state(share: Share | None) -> State:
    """The state that a share means; bistable if starts differ and are too few to show anything."""
    if share is None:
        return State.UNDEFINED
    if share.yes in (0, share.of):
        return State.YES if share.yes else State.NO
    low, high = share.interval
    yes, no = high >= MOST, low <= FEW
    if yes == no:
        return State.BISTABLE
    return State.YES if yes else State.NO


@cache
def state_thresholds(starts: int) -> tuple[int, int]:
    """Up to how many of so many starts mean no, and from how many on they mean yes."""
    states = [state(Share(yes, starts)) for yes in range(starts + 1)]
    return starts - states[::-1].index(State.NO), states.index(State.YES)


def evaluate_claim(
    claim: Claim, settings: Iterable[tuple[JudgedSetting, ConditionResults]]
) -> list[Answer]:
    """Answers to a claim in every setting that has the experiments it needs; one if static."""
    answers: dict[Place, Answer] = {}
    for setting, results in settings:
        conditions = setting.static_conditions if claim.static else setting.conditions
        for choice, quantity in claim.choices.items():
            place = Place(tuple(conditions.items()), choice)
            if place in answers:
                continue
            tracker = quantities.ResultsTracker(results)
            try:
                values = np.atleast_1d(quantity(tracker))
            except quantities.NotSimulatedError:
                continue
            answers[place] = collect_answer(place, values[: tracker.run], claim.limits)
    return list(answers.values())


class VerdictKind(StrEnum):
    """The kind of a verdict: its first word.

    In the order in which readers look: wrong, decided by chance, decided by an unknown, the rest.
    """

    FAILS = "does not hold"
    BISTABLE = "bistable"
    DEPENDS = "depends"
    UNDEFINED = "undefined"
    NOT_SIMULATED = "not simulated"
    WHERE_DEFINED = "holds where defined"
    HOLDS = "holds"


class Counts(NamedTuple):
    """How many settings have each state; undefined: they lack what the claim is about."""

    yes: int = 0
    no: int = 0
    bistable: int = 0
    undefined: int = 0


class Verdict(NamedTuple):
    """A verdict; depends_on: the parameters that decide, where some settings say yes, others no."""

    kind: VerdictKind
    counts: Counts
    depends_on: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The verdict for JSON."""
        return {
            "verdict": self.kind,
            "depends_on": list(self.depends_on),
            "counts": self.counts._asdict(),
        }


SettingState = tuple[Place, State]


def verdict(answers: Sequence[Answer], free: str = "") -> Verdict:
    """The verdict over settings: of one model of the gears, of several, or of none where static."""
    return verdict_of([(answer.place, answer.state) for answer in answers], free)


def verdict_of(setting_states: Sequence[SettingState], free: str = "") -> Verdict:
    """The verdict over settings whose states are known."""
    states = [state for _, state in setting_states]
    kind = kind_of(states)
    clear_states = [pair for pair in setting_states if pair[1] in (State.YES, State.NO)]
    depends_on = _deciding_parameters(clear_states, free) if kind == VerdictKind.DEPENDS else ()
    return Verdict(kind, counts_of(states), depends_on)


def counts_of(states: Sequence[State]) -> Counts:
    """How many settings have each state."""
    return Counts(*map(states.count, (State.YES, State.NO, State.BISTABLE, State.UNDEFINED)))


def kind_of(states: Sequence[State]) -> VerdictKind:
    """The verdict's kind; `bistable` if counting bistable settings as yes or no decides it."""
    yes, no, bistable, undefined = counts_of(states)
    if not states:
        return VerdictKind.NOT_SIMULATED
    if undefined == len(states):
        return VerdictKind.UNDEFINED
    none_against = VerdictKind.WHERE_DEFINED if undefined else VerdictKind.HOLDS
    kinds = set()
    for with_it, against in ((yes + bistable, no), (yes, no + bistable)):
        some = VerdictKind.DEPENDS if with_it else VerdictKind.FAILS
        kinds.add(some if against else none_against)
    return kinds.pop() if len(kinds) == 1 else VerdictKind.BISTABLE


def _deciding_parameters(setting_states: Sequence[SettingState], free: str) -> tuple[str, ...]:
    """Parameters that foretell the answer, best first; where none does, all that change it alone.

    One foretells it if Goodman and Kruskal's lambda, the share of wrong guesses that knowing it
    saves, is FORETELLS or more. Settings that say yes or no.
    """
    rows = [
        ({**dict(place.conditions), free: place.choice}, state) for place, state in setting_states
    ]
    names = [name for name in rows[0][0] if len({values[name] for values, _ in rows}) > 1]
    blind = _wrong_guesses(rows, "")
    saved = {name: 1 - _wrong_guesses(rows, name) / blind for name in names}
    telling = sorted((name for name in names if saved[name] >= FORETELLS), key=lambda n: -saved[n])
    if telling:
        return tuple(telling)
    alone = set[str]()
    for (first, first_state), (second, second_state) in combinations(rows, 2):
        if first_state != second_state:
            differing = [name for name in names if first[name] != second[name]]
            alone.update(differing if len(differing) == 1 else ())
    return tuple(name for name in names if name in (alone or names))


def _wrong_guesses(rows: Sequence[tuple[Mapping[str, Hashable], State]], name: str) -> int:
    """Wrong guesses if the most frequent state is guessed for each value of a parameter, if any."""
    by_value: dict[Hashable, list[State]] = {}
    for values, state in rows:
        by_value.setdefault(values.get(name), []).append(state)
    return sum(min(states.count(State.YES), states.count(State.NO)) for states in by_value.values())
