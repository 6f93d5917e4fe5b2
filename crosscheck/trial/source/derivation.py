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
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from itertools import count, islice
from types import MappingProxyType
from typing import Any, NamedTuple

from crosscheck.trial.source.answer_key import Answer, AnswerKey
from crosscheck.trial.source.edit import NONE
from crosscheck.trial.source.sandbox import limit_processor_time
from crosscheck.trial.source.syntax import SourceTree

HOOK = "_crosscheck_hook"  # name by which the code finds what is called with its expressions
MOST_TOGETHER = 4  # places of one derivation: with more of them it takes longer than twice
# Times that a derivation takes as long as the plain one, on top one for each place; and least [s].
LONGER, LEAST_S = 2.0, 0.8
SHARE = 0.37  # by which values are scaled: no symmetric or usual factor
EMPTY: Mapping[Any, float] = MappingProxyType({})
SCALING_S = 6.0  # [s] of processor time, of the derivation with a factor at every place
RECORDING_S = 5.0  # [s] of processor time, of the recording of many differences
# Of nodes: what is no value of its own, or no number to compute with.
UNVARIED = ("func", "slice", "test", "decorator_list", "annotation", "returns", "targets")
_numbers = count()  # of differences, which those of no other derivation share
Element = tuple[Any, ...]  # of a value: nothing, a row and a column, or a frame's name and an axis
Difference = Mapping[tuple[int, Element], Any]  # by evaluation and element, those that are not 0
Thunk = Callable[[], Any]
Hook = Callable[[int, Thunk], Any]  # called with an expression's identity, and what evaluates it
Run = Callable[[AnswerKey, Hook], Answer]  # makes the equations
ChosenAnswer = Callable[[Sequence[float]], Answer]  # the answers of an edit with numbers for gaps


class _Enough(BaseException):
    """What ends a run after the last evaluation that counts."""


class Extent(NamedTuple):
    """What differences consist of: their elements, and what these depend on."""

    elements: frozenset[tuple[int, Element]]
    variables: frozenset[Any]


@dataclass(eq=False)
class VariedPlace:
    """An expression that can be varied, and the answers of equations in which it is.

    evaluations: how often it is evaluated while the equations are made; dependencies: what it
    depends on, with all parameters; is_number: whether it depends on nothing; extent: of its
    variations, with their numbers; answer: of the equations with them; None before these are made,
    and where that fails.
    """

    node: ast.expr
    evaluations: int
    dependencies: frozenset[Any]
    is_number: bool
    extent: Extent
    numbers: Mapping[tuple[int, Element], int] = field(default_factory=dict)
    answer: Answer | None = None
    has_failed: bool = False
    answers: dict[Any, Answer] = field(default_factory=dict)


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
        self.places = self._find_places(compile_tree)

    def find_place(self, node: ast.AST) -> VariedPlace | None:
        """The place that an expression is, or is in; None where it cannot be varied."""
        for above in self._list_around(node):
            if id(above) in self.places:
                place = self.places[id(above)]
                return None if place.has_failed else place
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
        self, run: Run, choices: Mapping[VariedPlace, Sequence[int]], choose: Callable[[int], None]
    ) -> dict[int, Difference] | None:
        """The differences that edits make, by their number, of those that can be evaluated.

        run: of code with hooks in the places; choices: by place, the numbers of the edits there;
        choose: chooses one of them, or NONE. None if the code fails, or takes long.
        """
        left = sum(place.evaluations for place in choices)
        places = {id(place.node): place for place in choices}
        evaluations = dict.fromkeys(places, 0)
        recorded: dict[int, dict[tuple[int, Element], Any]] = {}
        failed = set[int]()
        is_busy = False

        def hook(key: int, evaluate: Thunk) -> Any:
            nonlocal left, is_busy
            value = evaluate()
            if is_busy or key not in places:
                return value
            is_busy, number = True, evaluations[key]
            for edit in choices[places[key]]:
                choose(edit)
                try:
                    difference = _subtract(evaluate(), value)
                except Exception:  # whatever an edit leads to
                    failed.add(edit)
                else:
                    elements = {(number, element): each for element, each in difference.items()}
                    recorded.setdefault(edit, {}).update(elements)
            choose(NONE)
            is_busy, left = False, left - 1
            evaluations[key] += 1
            if not left:
                raise _Enough
            return value

        with suppress(BaseException), limit_processor_time(RECORDING_S):  # whatever the code raises
            run(self.answer_key, hook)
        return None if left else {n: each for n, each in recorded.items() if n not in failed}

    def vary(
        self,
        differences: Mapping[VariedPlace, Mapping[int, Difference]],
        run: Run,
        gaps: Sequence[Any] = (),
    ) -> dict[int, ChosenAnswer | None]:
        """The answers with each of the differences at places; None of those that cannot be.

        run: of code with hooks in the places; gaps: symbols of numbers to be chosen.
        """
        larger, fitting = dict[VariedPlace, Extent](), dict[VariedPlace, list[int]]()
        for place, by_edit in differences.items():
            extents = {number: _measure_extent(each, gaps) for number, each in by_edit.items()}
            fitting[place] = [
                n for n, each in extents.items() if each.variables <= place.extent.variables
            ]
            elements = place.extent.elements.union(*(extents[n].elements for n in fitting[place]))
            if place.answer is None or elements != place.extent.elements:
                larger[place] = place.extent._replace(elements=elements)
        remaining = iter(larger.items())
        while together := dict(islice(remaining, MOST_TOGETHER)):
            self._derive(together, run)
        return {
            number: self._choose(place, difference, gaps)
            if number in fitting[place] and place.answer is not None
            else None
            for place, by_edit in differences.items()
            for number, difference in by_edit.items()
        }

    def _derive(self, extents: Mapping[VariedPlace, Extent], run: Run) -> None:
        """Derive the equations with variations at places: together, or else one by one."""
        from crosscheck.trial.source.variations import Variation

        places = {id(place.node): place for place in extents}
        numbers = {
            place: {each: next(_numbers) for each in extent.elements}
            for place, extent in extents.items()
        }
        ordered = {place: sorted(each.variables, key=str) for place, each in extents.items()}
        evaluations = dict.fromkeys(places, 0)

        def hook(key: int, evaluate: Thunk) -> Any:
            value = evaluate()
            if key not in places:
                return value
            place, number = places[key], evaluations[key]
            evaluations[key] += 1
            variations = {
                element: Variation.begin(variation, ordered[place])
                for (at, element), variation in numbers[place].items()
                if at == number
            }
            return _add(value, variations)

        try:
            with limit_processor_time(max(LEAST_S, self.seconds * (LONGER + len(extents)))):
                answer = run(self.answer_key, hook)
                is_intact = self.is_intact(self._set({}, answer))
        except BaseException:  # whatever the code raises
            is_intact = False
        if not is_intact:
            self._derive_singly(extents, run)
        else:
            for place, extent in extents.items():
                place.answer, place.extent, place.numbers = answer, extent, numbers[place]
                place.answers = {}

    def _derive_singly(self, extents: Mapping[VariedPlace, Extent], run: Run) -> None:
        """Derive the equations with each of some places varied, one with its own variables."""
        if len(extents) > 1:
            for place, extent in extents.items():
                self._derive({place: extent}, run)
            return
        ((place, extent),) = extents.items()
        place.answer, restricted = None, extent.variables & place.dependencies
        if restricted == extent.variables:
            place.has_failed = True
            return
        place.extent = extent._replace(variables=restricted)
        self._derive({place: place.extent}, run)

    def _choose(
        self, place: VariedPlace, difference: Difference, gaps: Sequence[Any]
    ) -> ChosenAnswer:
        """The answers with a difference at a place, of numbers for its gaps."""
        whole = place.answer
        assert whole is not None  # as the caller has seen
        chosen = {place.numbers[at]: each for at, each in difference.items()}

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
        varied, fixed = set[int](), set[int]()

        def hook(key: int, evaluate: Thunk) -> Any:
            value = evaluate()
            try:
                elements = _list_elements(value)
            except TypeError:
                fixed.add(key)
                return value
            number = evaluations.get(key, 0)
            variables.setdefault(key, set()).update(_list_variables(elements.values()))
            listed.setdefault(key, set()).update((number, at) for at in elements if elements[at])
            evaluations[key] = number + 1
            if not all(map(_is_coordinate, elements.values())) and not _is_axis(value):
                varied.add(key)
            return value

        try:
            for node in nodes.values():
                self.tree.put(node, make_hook(node, node))
            run = compile_tree()
        finally:
            for node in nodes.values():
                self.tree.put(node, node)
        with _observe_derivatives() as differentiated:
            run(self.answer_key, hook)
        families = [*self._list_families()]
        places, parameters, free = dict[int, VariedPlace](), set[Any](), varied - fixed
        for key, direct in variables.items():
            parameters |= {each for each in direct if each.is_Symbol} - differentiated
            _, *around = self._list_around(nodes[key])
            if key in free and free.isdisjoint(map(id, around)):
                dependencies = frozenset(direct | parameters)
                alike = dependencies.union(*(e for e in families if not e.isdisjoint(direct)))
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


def make_hook(place: ast.expr, node: ast.expr) -> ast.expr:
    """A call of the hook for a place, with what stands there now."""
    thunk = ast.Lambda(ast.arguments([], [], None, [], [], None, []), node)
    call = ast.Call(ast.Name(HOOK, ast.Load()), [ast.Constant(id(place)), thunk], [])
    return ast.fix_missing_locations(ast.copy_location(call, place))


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
    variables = _list_variables(difference.values()) - {*gaps}
    return Extent(frozenset(difference), frozenset(variables))


def _list_variables(expressions: Iterable[Any]) -> set[Any]:
    """Symbols, functions of time and their rates that expressions depend on."""
    import sympy as sp
    from sympy.core.function import AppliedUndef

    variables, waiting = set[Any](), list(expressions)
    while waiting:
        expression = waiting.pop()
        if isinstance(expression, sp.Derivative | AppliedUndef | sp.Symbol):
            variables.add(expression)
        else:
            waiting += getattr(expression, "args", ())
    return variables


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
    """Whether it is a vector of numbers alone, about which something may turn."""
    from sympy.physics.vector import Vector

    return isinstance(value, Vector) and not _list_variables(_list_elements(value).values())


def _list_elements(value: Any) -> dict[Element, Any]:
    """The elements of a number, an expression, a matrix or a vector of SymPy. Raises TypeError."""
    import sympy as sp
    from sympy.physics.vector import Vector

    if isinstance(value, Vector):
        return {
            (frame.name, axis): sp.sympify(matrix[axis])
            for matrix, frame in value.args
            for axis in range(len(matrix))
        }
    if isinstance(value, sp.MatrixBase):
        rows, columns = value.shape
        return {(i, j): value[i, j] for i in range(rows) for j in range(columns)}
    if isinstance(value, bool) or not isinstance(value, int | float | sp.Expr):
        raise TypeError
    return {(): sp.sympify(value)}


def _subtract(value: Any, other: Any) -> dict[Element, Any]:
    """The elements of a difference that are not 0. Raises TypeError for values of another kind."""
    elements, others = _list_elements(value), _list_elements(other)
    if {*map(len, elements)} != {*map(len, others)}:  # or a vector that is 0, in no frame
        raise TypeError
    differences = {
        each: elements.get(each, 0) - others.get(each, 0) for each in {**elements, **others}
    }
    return {each: difference for each, difference in differences.items() if difference != 0}


def _add(value: Any, variations: Mapping[Element, Any]) -> Any:
    """A value with a variation of each element."""
    import sympy as sp
    from sympy.physics.vector import Vector

    if not variations:
        return value
    if isinstance(value, Vector):
        frames = {each.name: (each.x, each.y, each.z) for each in _list_frames(value)}
        return sum((v * frames[name][axis] for (name, axis), v in variations.items()), value)
    if isinstance(value, sp.MatrixBase):
        changed = value.as_mutable()
        for place, variation in variations.items():
            changed[place] += variation
        return type(value)(changed)
    return value + variations[()]


def _list_frames(vector: Any) -> Iterator[Any]:
    """The frames of a vector, and all that are turned against them."""
    waiting, listed = [frame for _, frame in vector.args], set[Any]()
    while waiting:
        frame = waiting.pop()
        if frame not in listed:
            listed.add(frame)
            yield frame
            waiting += frame._dcm_dict
