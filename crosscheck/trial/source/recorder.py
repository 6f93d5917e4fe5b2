"""What edits make of expressions, while the equations are made once as they are."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from crosscheck.trial.source.answer_key import Answer
from crosscheck.trial.source.differences import (
    Difference,
    Element,
    NotVariable,
    are_equal,
    subtract,
)
from crosscheck.trial.source.edit import NONE
from crosscheck.trial.source.hooks import Thunk

Variation = tuple[int, Element, Any]  # of an evaluation's element, by a rate, or whole by 1


class Enough(BaseException):
    """What ends a run after the last evaluation that counts."""


class Extent(NamedTuple):
    """What differences consist of: their elements, and what these depend on.

    rates: of the latter, those in which differences are linear; none if they need not be.
    """

    elements: frozenset[tuple[int, Element]]
    variables: frozenset[Any]
    rates: frozenset[Any] = frozenset()

    def includes(self, other: Extent) -> bool:
        """Whether differences of another extent are differences of this one."""
        return self.elements >= other.elements and self.variables >= other.variables

    def list_variations(self) -> Iterator[Variation]:
        """The variations that make a difference together: of each element, or by each rate."""
        for at, element in self.elements:
            yield from ((at, element, rate) for rate in self.rates or (1,))

    def divide(self, difference: Difference) -> dict[Variation, Any] | None:
        """The variations that a difference consists of; None if it is not linear in the rates."""
        if not self.rates:
            return {(*at, 1): each for at, each in difference.items()}
        divided = dict[Variation, Any]()
        for at, each in difference.items():
            slopes = {rate: each.diff(rate) for rate in self.rates}
            rest = each - sum(slope * rate for rate, slope in slopes.items())
            if rest.expand() != 0 or any(slope.has(*self.rates) for slope in slopes.values()):
                return None
            divided |= {(*at, rate): slope for rate, slope in slopes.items() if slope != 0}
        return divided


@dataclass(eq=False)
class VariedPlace:
    """An expression that can be varied, and the answers of equations in which it is.

    evaluations: how often it is evaluated while the equations are made; dependencies: what it
    depends on, with all parameters; is_number: whether it depends on nothing; extent: of its
    variations, with their numbers; answer: of the equations with them; None before these are made,
    and where that fails; can_grow: whether it may have more elements; is_alone: whether it may not
    be varied with others.
    """

    node: ast.expr
    evaluations: int
    dependencies: frozenset[Any]
    is_number: bool
    extent: Extent
    numbers: Mapping[Variation, int] = field(default_factory=dict)
    answer: Answer | None = None
    has_failed: bool = False
    can_grow: bool = True
    is_alone: bool = False
    answers: dict[Any, Answer] = field(default_factory=dict)


class Recorder:
    """What edits make of expressions while the equations are made once, as they are.

    is_over: whether all that counts has been evaluated; else that of which something has not been
    is unknown.
    """

    def __init__(
        self,
        places: Mapping[int, VariedPlace],
        choices: Mapping[int, Sequence[int]],
        choose: Callable[[int], None],
    ) -> None:
        self.choices, self.choose = choices, choose
        self.places = {
            key: places[key] for key in choices if key in places and not places[key].has_failed
        }
        self.evaluations, self.is_over, self.is_busy = dict.fromkeys(choices, 0), False, False
        self.recorded = dict[int, dict[tuple[int, Element], Any]]()
        self.failed, self.unvaried = set[int](), set[int]()

    @property
    def differences(self) -> dict[int, Difference | None]:
        """Those that are not 0, by the number of the edit; None of those that cannot be varied."""
        differences = {**self.recorded, **dict.fromkeys(sorted(self.unvaried), None)}
        for key, edits in self.choices.items():
            if not self.is_over and not self._is_complete(key):
                differences |= dict.fromkeys(edits)
        return {n: each for n, each in differences.items() if each != {} and n not in self.failed}

    def _is_complete(self, key: int) -> bool:
        """Whether a place has been evaluated as often as it is."""
        return key in self.places and self.evaluations[key] == self.places[key].evaluations

    def hook(self, key: int, evaluate: Thunk) -> Any:
        """The value of an expression as it is, after those of its edits."""
        value = evaluate()
        if self.is_busy or key not in self.choices:
            return value
        self.is_busy = True
        for edit in self.choices[key]:
            self.choose(edit)
            try:
                self._record(edit, key, evaluate(), value)
            except Exception:  # whatever an edit leads to
                self.failed.add(edit)
        self.choose(NONE)
        self.is_busy = False
        self.evaluations[key] += 1
        self.is_over = all(map(self._is_complete, self.choices))
        if self.is_over:
            raise Enough
        return value

    def _record(self, edit: int, key: int, value: Any, plain: Any) -> None:
        if key not in self.places:
            self.unvaried |= set() if are_equal(value, plain) else {edit}
            return
        try:
            difference = subtract(value, plain)
        except NotVariable:
            self.unvaried.add(edit)
        else:
            number = self.evaluations[key]
            elements = {(number, element): each for element, each in difference.items()}
            self.recorded.setdefault(edit, {}).update(elements)
