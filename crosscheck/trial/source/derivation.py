"""A derivation by SymPy in which edits are judged without deriving anew.

Idea: an edit changes what an expression of the source is, from e to e + d, and all that is derived
from it depends on d and its derivatives alone. So it is derived once with a function in the place
of d that is not known yet, and of an edit only d is worked out, which takes a millisecond.
Difficulty: an expression is evaluated many times, and may be a matrix or a vector; and some must be
what they are, as a coordinate by which another line differentiates. Remedy: each time and each
element has a function of its own; where a derivation with them fails, or takes long, the edits are
derived one by one. So is whatever seems to mend anything: this is a sieve.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from itertools import count, islice
from types import MappingProxyType
from typing import Any

from crosscheck.trial.source.answer_key import Answer, AnswerKey
from crosscheck.trial.source.differences import (
    Difference,
    Element,
    add,
    is_vector,
    list_elements,
    list_variables,
)
from crosscheck.trial.source.hooks import Hook, Thunk, find_keeper, make_hook
from crosscheck.trial.source.recorder import Extent, Recorder, VariedPlace
from crosscheck.trial.source.sandbox import limit_processor_time
from crosscheck.trial.source.syntax import SourceTree

MOST_TOGETHER = 4  # places of one derivation: with more of them it takes longer than twice
# Times that a derivation takes as long as the plain one, on top one for each place; and least [s].
LONGER, LEAST_S = 2.0, 0.8
LONGEST_S = 3.0  # [s] of processor time, of one derivation for many edits
MOST_ELEMENTS = 9  # of a variation, with those of other frames
SHARE = 0.37  # by which values are scaled: no symmetric or usual factor
EMPTY: Mapping[Any, float] = MappingProxyType({})
SCALING_S = 6.0  # [s] of processor time, of the derivation with a factor at every place
RECORDING_S = 5.0  # [s] of processor time, of the recording of many differences
# Of nodes: what is no value of its own, or no number to compute with.
UNVARIED = ("func", "slice", "test", "decorator_list", "annotation", "returns", "targets")
_numbers = count()  # of differences, which those of no other derivation share
Run = Callable[[AnswerKey, Hook], Answer]  # makes the equations
ChosenAnswer = Callable[[Sequence[float]], Answer]  # the answers of an edit with numbers for gaps


class Derivation:
    """The places of a source whose equations SymPy derives.

    Raises what the code raises while its expressions are observed.

    Args:
        tree: The source.
        answer_key: What it must answer.
        seconds: Processor time [s] of the derivation as it is.
        compile_tree: Compiles the source as its tree is.
        is_intact: Whether answers are those of the equations as they are.
    """

    def __init__(
        self,
        tree: SourceTree,
        answer_key: AnswerKey,
        seconds: float,
        compile_tree: Callable[[], Run],
        is_intact: Callable[[Answer], bool],
    ) -> None:
        self.tree, self.answer_key, self.seconds = tree, answer_key, seconds
        self.is_intact = is_intact
        self.families = list[frozenset[Any]]()
        self.places = self._find_places(compile_tree)

    def find_place(self, node: ast.AST) -> VariedPlace | None:
        """The place that an expression is, or is in; None where it cannot be varied."""
        below = node
        for above in self._list_around(node):
            place = self.places.get(id(above))
            if place is not None:
                is_method = below is getattr(above, "func", None)
                is_other = is_method and find_keeper(self.tree, above) is not None
                return None if place.has_failed or is_other else place
            below = above
        return None

    def scale(self, run: Run) -> dict[VariedPlace, Answer]:
        """The answers with the value of each place larger by a share; none where that fails.

        One derivation has a factor at every place, which takes hardly longer than the plain one. A
        number is no such place.
        """
        from crosscheck.trial.source.variations import Variation

        numbers = {k: next(_numbers) for k, each in self.places.items() if not each.is_number}

        def hook(key: int, evaluate: Thunk) -> Any:
            value = evaluate()
            return value * Variation.begin(numbers[key], ()) if key in numbers else value

        try:
            with limit_processor_time(max(SCALING_S, self.seconds * 2 * LONGER)):
                answer = run(self.answer_key, hook)
        except BaseException:  # whatever the code raises
            return {}
        plain = dict.fromkeys(numbers.values(), 1.0)
        return {
            self.places[key]: self._set(plain | {number: 1 + SHARE}, answer)
            for key, number in numbers.items()
        }

    def record(
        self,
        run: Run,
        choices: Mapping[int, Sequence[int]],
        choose: Callable[[int], None],
    ) -> dict[int, Difference | None]:
        """The differences that edits make, by their number, of those that make any.

        None of those that make one which cannot be varied, or is not known: the code takes long.

        Args:
            run: Makes the equations of code with hooks around expressions.
            choices: By the identity of an expression, a place or another one, the numbers of the
                edits in it.
            choose: Chooses one of them, or NONE.
        """
        recorder = Recorder(self.places, choices, choose)
        with suppress(BaseException), limit_processor_time(RECORDING_S):  # whatever the code raises
            run(self.answer_key, recorder.hook)
            recorder.is_over = True
        return recorder.differences

    def vary(
        self,
        differences: Mapping[VariedPlace, Mapping[int, Difference]],
        run: Run,
        gaps: Sequence[Any] = (),
    ) -> dict[int, ChosenAnswer | None]:
        """The answers with each of the differences at places; None of those that cannot be.

        run: of code with hooks in the places; gaps: symbols of numbers to be chosen.
        """
        larger = dict[VariedPlace, Extent]()
        extents = {
            number: _measure_extent(difference, gaps)
            for by_edit in differences.values()
            for number, difference in by_edit.items()
        }
        for place, by_edit in differences.items():
            fitting = (
                extents[n] for n in by_edit if extents[n].variables <= place.extent.variables
            )
            elements = place.extent.elements.union(*(each.elements for each in fitting))
            if not place.can_grow or len(elements) > MOST_ELEMENTS:
                elements = place.extent.elements
            if place.answer is None or elements != place.extent.elements:
                larger[place] = place.extent._replace(elements=elements)
        alone = [place for place in larger if place.is_alone]
        remaining = (each for each in larger if not each.is_alone)
        groups = [[each] for each in alone]
        groups += iter(lambda: list(islice(remaining, MOST_TOGETHER)), [])
        for group in groups:
            edits = sum(len(differences[place]) for place in group)
            if len(group) == 1 or not self._derive({each: larger[each] for each in group}, run):
                for place in group:
                    place.is_alone |= len(group) > 1
                    self._derive_alone(place, larger[place], run, edits // len(group))
        return {
            number: self._choose(place, difference, gaps)
            if place.extent.includes(extents[number])
            else None
            for place, by_edit in differences.items()
            for number, difference in by_edit.items()
        }

    def _derive_alone(self, place: VariedPlace, extent: Extent, run: Run, edits: int) -> None:
        """Derive the equations with one place varied, as far as that is possible.

        edits: how many would be derived one by one.
        """
        longest_s = min(LONGEST_S, edits * self.seconds / 2)
        for each in self._list_extents(place, extent):
            if self._derive({place: each}, run, longest_s):
                return
            place.can_grow &= each.elements == place.extent.elements
        place.has_failed = place.answer is None

    def _list_extents(self, place: VariedPlace, extent: Extent) -> Iterator[Extent]:
        """Extents of variations to be tried in turn, from all elements and variables on.

        Kane's method takes velocities that are linear in the rates, which are known to be so where
        each rate has a variation of its own.
        """
        yield extent
        if place.answer is None:
            if extent.elements != place.extent.elements:
                yield place.extent
            if not place.extent.variables <= place.dependencies:
                yield place.extent._replace(variables=place.extent.variables & place.dependencies)
            for family in self.families:
                rates = frozenset(each for each in family if not each.is_Symbol)
                if rates & place.dependencies:
                    yield place.extent._replace(rates=rates)

    def _derive(
        self, extents: Mapping[VariedPlace, Extent], run: Run, longest_s: float = 0.0
    ) -> bool:
        """Derive the equations with variations at places, and whether that is possible.

        longest_s: processor time [s] that it may take, if not longer in any case.
        """
        from crosscheck.trial.source.variations import Variation

        places = {id(place.node): place for place in extents}
        numbers = {
            place: {each: next(_numbers) for each in extent.list_variations()}
            for place, extent in extents.items()
        }
        ordered = {
            place: sorted(each.variables - each.rates, key=str) for place, each in extents.items()
        }
        evaluations = dict.fromkeys(places, 0)

        def hook(key: int, evaluate: Thunk) -> Any:
            value = evaluate()
            if key not in places:
                return value
            place, number = places[key], evaluations[key]
            evaluations[key] += 1
            variations = dict[Element, Any]()
            for (at, element, rate), variation in numbers[place].items():
                if at == number:
                    begun = Variation.begin(variation, ordered[place])
                    variations[element] = variations.get(element, 0) + begun * rate
            return add(value, variations)

        limit_s = max(LEAST_S, self.seconds * (LONGER + len(extents)), longest_s)
        try:
            with limit_processor_time(limit_s):
                answer = run(self.answer_key, hook)
                is_intact = self.is_intact(self._set({}, answer))
        except BaseException:  # whatever the code raises
            return False
        if is_intact:
            for place, extent in extents.items():
                place.answer, place.extent, place.numbers = answer, extent, numbers[place]
                place.answers = {}
        return is_intact

    def _choose(
        self, place: VariedPlace, difference: Difference, gaps: Sequence[Any]
    ) -> ChosenAnswer | None:
        """The answers with a difference at a place, of numbers for its gaps; None of no such."""
        whole, divided = place.answer, place.extent.divide(difference)
        if whole is None or divided is None:
            return None
        chosen = {place.numbers[at]: each for at, each in divided.items()}

        def choose(values: Sequence[float]) -> Answer:
            given = dict(zip(gaps, values, strict=True)) if gaps else {}
            answer = self._set(chosen, whole, given)
            # Edits with the same difference are one.
            key = frozenset(difference.items())
            return answer if gaps else place.answers.setdefault(key, answer)

        return choose

    def _set(
        self, differences: Mapping[int, Any], whole: Answer, gaps: Mapping[Any, float] = EMPTY
    ) -> Answer:
        """The answers of varied equations with differences by their numbers."""
        from crosscheck.trial.source.variations import Variation

        @cache
        def answer(part: str, state: int) -> Any:
            Variation.differences, Variation.gaps = differences, gaps
            return whole(part, state)

        return answer

    def _find_places(self, compile_tree: Callable[[], Run]) -> dict[int, VariedPlace]:
        """The outermost expressions whose values can be varied, by their identity."""
        nodes = {
            id(node): node
            for statement in self.tree.list_statements()
            for node in _list_expressions(statement)
            if id(node) in self.tree.places and self.tree.has_run(node, self.tree.lines)
        }
        evaluations, variables = dict[int, int](), dict[int, set[Any]]()
        listed = dict[int, set[tuple[int, Element]]]()
        varied, fixed, symbols = set[int](), set[int](), set[int]()

        def hook(key: int, evaluate: Thunk) -> Any:
            value = evaluate()
            try:
                elements = list_elements(value)
                if find_keeper(self.tree, nodes[key]) is not None and not is_vector(value):
                    raise TypeError
            except TypeError:
                fixed.add(key)
                return value
            number = evaluations.get(key, 0)
            variables.setdefault(key, set()).update(list_variables(elements.values()))
            listed.setdefault(key, set()).update((number, at) for at in elements if elements[at])
            evaluations[key] = number + 1
            if getattr(value, "is_Symbol", False):
                symbols.add(key)
            elif not all(map(_is_coordinate, elements.values())) and not _is_axis(value):
                varied.add(key)
            return value

        try:
            for node in nodes.values():
                self.tree.put(node, make_hook(self.tree, node, node))
            run = compile_tree()
        finally:
            for node in nodes.values():
                self.tree.put(node, node)
        with _observe_derivatives() as differentiated:
            run(self.answer_key, hook)
        self.families = [*dict.fromkeys(self._list_families())]
        # Of symbols that stand alone those that a function is given, but not to differentiate by.
        varied |= {
            key
            for key in symbols
            if isinstance(self.tree.parent(nodes[key]), ast.Call)
            and variables[key].isdisjoint(differentiated)
        }
        places, parameters, free = dict[int, VariedPlace](), set[Any](), varied - fixed
        for key, direct in variables.items():
            parameters |= {each for each in direct if each.is_Symbol} - differentiated
            _, *around = self._list_around(nodes[key])
            if key in free and free.isdisjoint(map(id, around)):
                dependencies = frozenset(direct | parameters)
                alike = dependencies.union(*(e for e in self.families if not e.isdisjoint(direct)))
                # An axis of another frame brings its angle into a rate.
                angles = {each.expr for each in alike if each.is_Derivative}
                extent = Extent(frozenset(listed[key]), alike | angles)
                places[key] = VariedPlace(
                    nodes[key], evaluations[key], dependencies, not direct, extent
                )
        return places

    def _list_families(self) -> Iterator[frozenset[Any]]:
        """Variables that stand in one list of the code, or are one: all rates for example."""
        import sympy as sp

        for scope in dict.fromkeys(self.tree.scopes.values()):
            values = scope.list_values()
            displays = [each for each in scope.nodes if isinstance(each, ast.List | ast.Tuple)]
            names = [[getattr(each, "id", "") for each in display.elts] for display in displays]
            lists = [[values.get(name) for name in each] for each in names]
            for each in (*scope.values.values(), *lists):
                elements = list(each) if isinstance(each, list | tuple | sp.MatrixBase) else []
                if elements and all(map(_is_coordinate, elements)):
                    yield frozenset(elements)

    def _list_around(self, node: ast.AST) -> Iterator[ast.AST]:
        """An expression and those that it is in, the innermost first."""
        above: ast.AST | None = node
        while isinstance(above, ast.expr | ast.keyword | ast.comprehension):
            yield above
            above = self.tree.parent(above)


def _list_expressions(node: ast.AST) -> Iterator[ast.expr]:
    """The expressions of a statement that may be varied: no function that is called, no index."""
    leaves = ast.Name | ast.Attribute | ast.Subscript | ast.Constant
    for name, value in ast.iter_fields(node):
        for each in value if isinstance(value, list) else [value]:
            if name in UNVARIED or not isinstance(each, ast.expr | ast.keyword | ast.comprehension):
                continue
            if isinstance(each, leaves):
                is_read = isinstance(getattr(each, "ctx", None), ast.Load | None)
                if is_read and not isinstance(node, ast.Attribute | ast.Subscript):
                    yield each
                continue
            if isinstance(each, ast.BinOp | ast.UnaryOp | ast.Call):
                yield each
            if not isinstance(each, ast.JoinedStr | ast.Starred):
                yield from _list_expressions(each)


def _measure_extent(difference: Difference, gaps: Collection[Any]) -> Extent:
    variables = list_variables(difference.values()) - {*gaps}
    return Extent(frozenset(difference), frozenset(variables))


@contextmanager
def _observe_derivatives() -> Iterator[set[Any]]:
    """See by what SymPy differentiates meanwhile."""
    import sympy as sp

    differentiated, differentiate = set[Any](), sp.Expr.diff

    def observe(expression: Any, *by: Any, **more: Any) -> Any:
        differentiated.update(each for each in by if isinstance(each, sp.Basic))
        return differentiate(expression, *by, **more)

    sp.Expr.diff = observe
    try:
        yield differentiated
    finally:
        sp.Expr.diff = differentiate


def _is_coordinate(value: Any) -> bool:
    """Whether others may differentiate by a value."""
    import sympy as sp

    return isinstance(value, sp.Expr) and value._diff_wrt


def _is_axis(value: Any) -> bool:
    """Whether it is a vector of a frame, about which something may turn."""
    from sympy.physics.vector import Vector

    return isinstance(value, Vector) and [e for e in list_elements(value).values() if e] == [1]
