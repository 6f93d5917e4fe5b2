"""Right answers of equations on a mechanism: the table that trials of arms and robots fill."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

Answer = Callable[[str, int], np.ndarray]  # of a part, at the state of a number
Entry = tuple[Any, ...]  # the part, and the entry's row, of M also its column
EQUAL = 1e-9  # relative difference of numbers that are the same
# Motions at which inverse dynamics are asked too, since of two errors one may be without effect.
AT_REST, WITHOUT_RATES = "inverse_dynamics at rest", "inverse_dynamics without rates"
# The part that is asked there, and the words behind an entry.
MOTIONS = {
    AT_REST: ("inverse_dynamics", " at rest"),
    WITHOUT_RATES: ("inverse_dynamics", " without rates"),
}


FACTORS = 0.7, 1.4  # factors by which numbers of other mechanisms differ
# Numbers that formulas have too: they stay as they are where a code's numbers are exchanged.
USUAL_FACTORS = 0.0, 0.25, 0.5, 1.0, 2.0, 3.0, 4.0


class NumberExchange:
    """Another number for each one of a file, the same wherever it stands.

    kept: numbers that stay as they are, since code may mean something else by them: angles.
    """

    def __init__(self, kept: Iterable[float] = ()) -> None:
        self.kept = np.array([*USUAL_FACTORS, *map(abs, kept)])

    def __call__(self, number: float) -> float:
        """The other number."""
        if np.isclose(abs(number), self.kept, rtol=EQUAL, atol=0.0).any():
            return number
        (bits,) = np.array([abs(number)]).view(np.uint64)
        return number * float(np.random.default_rng(int(bits)).uniform(*FACTORS))

    def exchange_array(self, numbers: np.ndarray) -> np.ndarray:
        """An array of the other numbers, of the same shape."""
        return np.reshape(list(map(self, np.ravel(numbers))), np.shape(numbers))

    def exchange_code(self, answer_key: AnswerKey, numbers: Iterable[float]) -> AnswerKey:
        """The answer key of a mechanism of the other numbers, for code that has those of the file.

        numbers: of the file, as often as they stand there.
        """
        counts = Counter(abs(number) for number in numbers if number)
        exchanged = {number: self(number) for number in counts}
        equal = (each for each, count in counts.items() if count > 1 or each in self.kept)
        return replace(answer_key, exchanged=exchanged, equal=frozenset(equal))


@dataclass(frozen=True)
class LevelAnswers:
    """The right answers at a level, at a few states.

    Args:
        right: By part, M (states, n, n), others (states, n).
        allowed: By part, what entries may differ by, in a shape that fits.
        holds: By part, one that is a summand of it, or from which it follows: where that is wrong,
            so is the part.
    """

    right: Mapping[str, np.ndarray]
    allowed: Mapping[str, np.ndarray]
    holds: Mapping[str, str] = field(default_factory=dict)

    @property
    def states(self) -> range:
        """Numbers of the states."""
        return range(min((len(each) for each in self.right.values()), default=0))

    def allowance(self, part: str, state: int) -> np.ndarray:
        """What the entries of a part may differ by at a state."""
        return np.broadcast_to(self.allowed[part], self.right[part].shape)[state]

    def find_wrong_entries(
        self, answer: Answer, parts: Iterable[str], states: Iterable[int] | None = None
    ) -> set[Entry]:
        """The entries of parts that are wrong at any state, of some states or of all."""
        wrong = set[Entry]()
        for part in parts:
            right = self.right[part]
            for state in self.states if states is None else states:
                distance = np.abs(answer(part, state) - right[state])
                beyond = ~(distance <= self.allowance(part, state))
                wrong |= {(part, *index) for index in np.argwhere(beyond).tolist()}
        return wrong


@dataclass(frozen=True)
class AnswerKey:
    """Right answers of equations on a mechanism: those of a level, or of another level.

    Args:
        bind: Makes equations for the mechanism, of the object that a user's code defines, and
            returns their answers, as the trial asks for them. It raises what their code raises.
        levels: The right answers by level, that of the trial first.
        names: Of the coordinates.
        numbers: Those of the mechanism's file: what the code has in common with it is right.
        exchanged: Numbers of code that has them for the file's, with those of this mechanism.
        equal: Those of them that may stand for another: of several things, or a formula's too.
    """

    bind: Callable[[Any], Answer]
    levels: Mapping[str, LevelAnswers]
    names: Sequence[str]
    numbers: frozenset[float] = frozenset()
    exchanged: Mapping[float, float] = field(default_factory=dict)
    equal: frozenset[float] = frozenset()

    def is_stated(self, number: float) -> bool:
        """Whether the file states a number of the code, and not one that code has in any case."""
        is_plain = number == float(f"{number:.1g}")  # 0.5 and 2 are factors too
        return not is_plain and self.has_number(number)

    def has_number(self, number: float) -> bool:
        """Whether a number, or its opposite, stands in the file and is no usual factor."""
        return self.has_signed_number(number) or self.has_signed_number(-number)

    def has_signed_number(self, number: float) -> bool:
        """Whether a number stands in the file, and is no usual factor."""
        near = EQUAL * abs(number)
        is_there = any(abs(number - each) <= near for each in self.numbers)
        return is_there and abs(number) not in USUAL_FACTORS

    def format_entry(self, entry: Entry) -> str:
        """An entry in words, such as M[theta_1, theta_2]."""
        part, *place = entry
        quantity, motion = MOTIONS.get(part, (part, ""))
        letter = "M" if part == "mass_matrix" else quantity
        return f"{letter}[{', '.join(self.names[number] for number in place)}]{motion}"
