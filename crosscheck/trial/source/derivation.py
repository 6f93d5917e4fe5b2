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
MOST_ELEMENTS = 9  # of a variation, with those of other frames
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

    def includes(self, other: Extent) -> bool:
        """Whether differences of another extent are differences of this one."""
        return self.elements >= other.elements and self.variables >= other.variables


class Unvaried(Exception):
    """An error for a difference that nothing stands for in a derivation."""


@dataclass(eq=False)
class VariedPlace:
    """An expression that can be varied, and the answers of equations in which it is.

    evaluations: how often it is evaluated while the equations are made; dependencies: what it
    depends on, with all parameters; is_number: whether it depends on nothing; extent: of its
    variations, with their numbers; answer: of the equations with them; None before these are made,
    and where that fails; can_grow: whether it may have more elements.
    """

    node: ast.expr
    evaluations: int
    dependencies: frozenset[Any]
    is_number: bool
    extent: Extent
    numbers: Mapping[tuple[int, Element], int] = field(default_factory=dict)
    answer: Answer | None = None
    has_failed: bool = False
    can_grow: bool = True
    answers: dict[Any, Answer] = field(default_factory=dict)


class _Recorder:
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
            raise _Enough
        return value

    def _record(self, edit: int, key: int, value: Any, plain: Any) -> None:
        if key not in self.places:
            self.unvaried |= set() if _are_equal(value, plain) else {edit}
            return
        try:
            difference = _subtract(value, plain)
        except Unvaried:
            self.unvaried.add(edit)
        else:
            number = self.evaluations[key]
            elements = {(number, element): each for element, each in difference.items()}
            self.recorded.setdefault(edit, {}).update(elements)


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
        recorder = _Recorder(self.places, choices, choose)
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
            fitting = (extents[n] for n in by_edit if extents[n].variables <= place.extent.variables)
            elements = place.extent.elements.union(*(each.elements for each in fitting))
            if not place.can_grow or len(elements) > MOST_ELEMENTS:
                elements = place.extent.elements
            if place.answer is None or elements != place.extent.elements:
                larger[place] = place.extent._replace(elements=elements)
        remaining = iter(larger.items())
        while together := dict(islice(remaining, MOST_TOGETHER)):
            self._derive(together, run)
        return {
            number: self._choose(place, difference, gaps)
            if place.answer is not None and place.extent.includes(extents[number])
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
        """Derive the equations with each of some places varied, one as far as that is possible.

        That is with its own elements if not with more; then with its own variables.
        """
        if len(extents) > 1:
            for place, extent in extents.items():
                self._derive({place: extent}, run)
            return
        ((place, extent),) = extents.items()
        restricted = extent.variables & place.dependencies
        if extent.elements != place.extent.elements:
            place.can_grow = False
            if place.answer is None:
                self._derive({place: place.extent}, run)
        elif restricted != extent.variables:
            place.extent = extent._replace(variables=restricted)
            self._derive({place: place.extent}, run)
        else:
            place.has_failed = True

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
        varied, fixed, symbols = set[int](), set[int](), set[int]()

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
            if getattr(value, "is_Symbol", False):
                symbols.add(key)
            elif not all(map(_is_coordinate, elements.values())) and not _is_axis(value):
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
            # What a statement calls, it calls for its effect.
            if isinstance(each, ast.BinOp | ast.UnaryOp | ast.Call) and not isinstance(
                node, ast.Expr
            ):
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
    """Whether it is a vector of a frame, about which something may turn."""
    from sympy.physics.vector import Vector

    return isinstance(value, Vector) and [e for e in _list_elements(value).values() if e] == [1]


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


def _are_equal(value: Any, other: Any) -> bool:
    try:
        return bool(value == other)
    except Exception:  # whatever an object of the code raises
        return False


def _subtract(value: Any, other: Any) -> dict[Element, Any]:
    """The elements of a difference that are not 0.

    Raises TypeError for values of another kind, and Unvaried for a vector 0, which has no frame.
    """
    elements, others = _list_elements(value), _list_elements(other)
    if not {*map(len, elements)} <= {*map(len, others)}:
        raise TypeError if others else Unvaried
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
