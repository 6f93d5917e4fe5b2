"""What equations must answer on a mechanism: the one table that trials of arms and robots fill."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

Answer = Callable[[str, int], np.ndarray]  # of a part, at the state of a number
Entry = tuple[Any, ...]  # the part, and the entry's row, of M also its column


@dataclass(frozen=True)
class Target:
    """The right answers of equations on a mechanism, at a few states.

    Args:
        bind: Makes equations for the mechanism, of the object that a user's code defines, and
            returns their answers, as the trial asks for them. It raises what their code raises.
        right: By part, the right answers (states, n, n) of M, (states, n) of others.
        allowed: By part, what entries may differ by, in the part's unit, in a shape that fits.
        names: Of the coordinates.
    """

    bind: Callable[[Any], Answer]
    right: Mapping[str, np.ndarray]
    allowed: Mapping[str, np.ndarray]
    names: Sequence[str]

    @property
    def states(self) -> range:
        """Numbers of the states."""
        return range(min((len(each) for each in self.right.values()), default=0))

    @property
    def size(self) -> int:
        """How many entries all parts have."""
        return sum(each[0].size for each in self.right.values())

    def find_wrong_entries(
        self,
        answer: Answer,
        parts: Iterable[str] | None = None,
        states: Iterable[int] | None = None,
    ) -> set[Entry]:
        """The entries that are wrong at any state, of some parts and states or of all."""
        wrong = set[Entry]()
        for part in self.right if parts is None else parts:
            right = self.right[part]
            allowed = np.broadcast_to(self.allowed[part], right.shape)
            for state in self.states if states is None else states:
                beyond = ~(np.abs(answer(part, state) - right[state]) <= allowed[state])
                wrong |= {(part, *index) for index in np.argwhere(beyond).tolist()}
        return wrong

    def select_parts(self, parts: Iterable[str]) -> Target:
        """The target of these parts alone."""
        return replace(self, right={part: self.right[part] for part in parts})

    def format_entry(self, entry: Entry) -> str:
        """An entry in words, such as M[theta_1, theta_2]."""
        part, *place = entry
        letter = "M" if part == "mass_matrix" else part
        return f"{letter}[{', '.join(self.names[number] for number in place)}]"
