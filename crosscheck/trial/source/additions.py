"""Edits that add what is missing: an argument's function, a factor, a summand, a statement."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations, permutations, product

import numpy as np

from crosscheck.trial.source.changes import (
    MATRIX_LENGTH,
    OPPOSITE,
    SIMPLE,
    Texts,
    list_near_names,
    write_exchanged,
)
from crosscheck.trial.source.site import (
    SUMS,
    Site,
    is_matrix_product,
    is_product,
    is_stored,
    is_sum,
    write_operand,
)
from crosscheck.trial.source.syntax import INDEX, LEAF, NUMBER, Kind, find_product_kind

VECTOR: Kind = ("array", 3)
DERIVATIVES = "diff", "jacobian"  # methods and functions of SymPy


def list_arguments(site: Site) -> Texts:
    """An argument without its function, or with it once more: u x (u x r) for u x r."""
    node = site.node
    if not isinstance(node, ast.Call) or node.keywords or not site.is_value:
        return
    if 1 <= len(node.args) <= 2:
        yield ast.unparse(node.args[-1])
        if len(node.args) == 2:
            yield f"{ast.unparse(node.func)}({ast.unparse(node.args[0])}, {site.text})"


def list_further_functions(site: Site) -> Texts:
    """A name in a call of the code in which something of its kind is an argument.

    So what is turned over to the world nearby, by a function or by einsum, is turned here too.
    """
    if not site.is_leaf or not site.is_value or site.name == "args" or site.kind is None:
        return
    texts = dict[str, None]()
    for call in site.tree.list_all_nodes():
        if not isinstance(call, ast.Call) or call.keywords:
            continue
        function, written = ast.unparse(call.func), list(map(ast.unparse, call.args))
        is_usual = "." in function or function in site.tree.functions
        for place, argument in enumerate(call.args if is_usual else ()):
            others = [each for each in call.args if each is not argument]
            has_kind = site.tree.kind(argument) in (site.kind, *([] if others else [None]))
            is_apart = all(site.tree.kind(each) != site.kind for each in others)  # unlike a x b
            if has_kind and is_apart and all(map(site.can_name, others)):
                arguments = [*written[:place], site.text, *written[place + 1 :]]
                texts[f"{function}({', '.join(arguments)})"] = None
    yield from texts


def list_conditionals(site: Site) -> Texts:
    """A name where a condition of the code holds, and another one of its kind where it does not.

    So the torque of a joint that slides is a force.
    """
    if not site.is_leaf or not site.is_value:
        return
    tests = (n.test for n in site.scope.nodes if isinstance(n, ast.If | ast.IfExp))
    for test in dict.fromkeys(map(ast.unparse, tests)):
        for other in _list_alternatives(site, site.node):
            yield f"({site.text} if {test} else {other})"
            yield f"({other} if {test} else {site.text})"


def list_further_wrappings(site: Site) -> Texts:
    """A matrix that is an argument, turned by a function of the file that makes its like of one.

    So the inverse of a transform is taken. What no line names may be it: the wrong line has lost
    its only call.
    """
    is_matrix = site.kind is not None and len(site.kind) == MATRIX_LENGTH
    if not is_matrix or not isinstance(site.parent, ast.Call) or site.name != "args":
        return
    loaded = site.tree.loaded_names
    for name, scope in site.tree.functions.items():
        arguments = site.tree.list_arguments(name)
        if len(arguments) == 1:
            is_like = scope.result == scope.kind(arguments[0]) == site.kind
            if is_like or name not in loaded:
                yield f"{name}({site.text})"


def list_unused(site: Site) -> Texts:
    """A sum, a difference or a product with what has a name that nothing reads."""
    if not site.is_value or is_sum(site.parent) or not site.scope.unused:
        return
    for text, kind in site.scope.list_leaves():
        is_unused = text.partition("[")[0] in site.scope.unused
        if is_unused and (site.kind is None or _can_be_added(site.kind, kind)):
            yield from (f"{write_operand(site.node)} {sign} {text}" for sign in (*OPPOSITE, "*"))


def list_unused_factors(site: Site) -> Texts:
    """A sum with a product of what has a name that nothing reads: friction, of one row or all."""
    kind, scope = site.kind or NUMBER, site.scope
    if not (scope.unused and site.is_sum_place(outer=True)):
        return
    numbers = [text for text in sorted(scope.unused) if scope.kind(text) == NUMBER]
    if kind == NUMBER:
        names = (text for text, other in scope.list_own_leaves() if other == NUMBER)
        for name, factor in product(names, numbers):
            yield from (f"{write_operand(site.node)} {sign} {factor} * {name}" for sign in OPPOSITE)
    called = _find_called(site, ".array") if kind[0] == "array" and len(kind) == len(VECTOR) else ""
    for factors in combinations(numbers, kind[1]) if called else ():
        for name, other in scope.list_leaves(written=True):
            if other == kind:
                terms = ", ".join(f"{each} * {name}[{n}]" for n, each in enumerate(factors))
                yield f"{write_operand(site.node)} - {called}([{terms}])"


def list_unused_levers(site: Site) -> Texts:
    """A sum of vectors with a cross product of what has a name that nothing reads, and a vector."""
    is_place = site.kind in (VECTOR, None) and site.is_sum_place(outer=True)
    cross = _find_called(site, "cross") if is_place and site.scope.unused else ""
    if not cross:
        return
    names = [text for text, kind in site.scope.list_leaves() if kind == VECTOR]
    unused = [text for text in names if text.partition("[")[0] in site.scope.unused]
    for lever, name in product(unused, names):
        if name != lever:
            yield f"{site.text} + {cross}({lever}, {name})"
            yield f"{site.text} + {cross}({name}, {lever})"


def _find_called(site: Site, end: str) -> str:
    """The text by which the code calls a function whose name ends so; '' if it calls none."""
    calls = (each for each in site.tree.list_all_nodes() if isinstance(each, ast.Call))
    names = (ast.unparse(each.func) for each in calls)
    return next((name for name in names if name.endswith(end)), "")


def _find_numpy(site: Site) -> str:
    """The name of NumPy in the code; '' if it has none."""
    return next((name for name, value in site.scope.list_values().items() if value is np), "")


def _can_be_added(kind: Kind, other: Kind) -> bool:
    """Whether the other is a number, or both are arrays of one shape but for lengths of 1."""
    is_shaped = kind[0] == other[0] == "array" and len(kind) == len(other)
    lengths = zip(kind[1:], other[1:], strict=False)
    return other == NUMBER or (is_shaped and all(a == b or 1 in (a, b) for a, b in lengths))


def list_further_factors(site: Site, *, written: bool) -> Texts:
    """A whole term with a factor more; none of it, or one."""
    if written and site.is_number and site.is_term:
        yield from ("0", "1")
    if site.is_term and not is_sum(site.node):
        for other, kind in site.scope.list_leaves(written=written):
            if kind == NUMBER:
                yield f"{other} * {site.text}"


def list_further_matrices(site: Site) -> Texts:
    """A matrix more, turned over or not, in front of a value or behind it."""
    kind, text = site.kind, write_operand(site.node)
    is_array = kind[0] == "array" if kind else is_matrix_product(site.node)
    if not is_array or not site.is_value or is_matrix_product(site.parent):
        return
    for other, shape in site.scope.list_leaves():
        if _is_square(shape) and not other.endswith(".T"):
            for matrix in (other, f"{other}.T"):
                yield f"{matrix} @ {text}"
                if kind is None or len(kind) == MATRIX_LENGTH:
                    yield f"{text} @ {matrix}"


def list_further_summands(site: Site, *, outer: bool, written: bool = True) -> Texts:
    """A sum with a summand more: what the code names, or a product of the same function."""
    if not site.is_sum_place(outer=outer):
        return
    leaves = (text for text, kind in site.scope.list_leaves(written=written) if site.can_be(kind))
    for text in dict.fromkeys([*leaves, *(site.list_products(is_product) if written else ())]):
        for sign in OPPOSITE:
            if (sign, text) != ("-", site.text):
                yield f"{write_operand(site.node)} {sign} {text}"


def list_like_summands(site: Site, *, inner: bool) -> Texts:
    """A sum or a product with a summand more that is like its own but for a name or two.

    So m2 * y2 of a body has its like, mp * yp, of the payload. inner: of the innermost products.
    """
    is_inner = is_product(site.node) and not any(map(is_product, ast.iter_child_nodes(site.node)))
    is_outer = is_sum(site.node) or (is_product(site.node) and not is_product(site.parent))
    if is_sum(site.parent) or not (is_inner if inner else is_outer):
        return
    for summand in _split_sum(site.node):
        is_square = _is_square(site.tree.kind(summand) or ()) and site.tree.is_leaf(summand)
        if is_sum(site.node) and is_square:  # the next term of a series
            yield f"{site.text} + {ast.unparse(summand)} @ {ast.unparse(summand)}"
        leaves = [node for node in ast.walk(summand) if site.tree.is_leaf(node)]
        places = {ast.unparse(node): Site(site.tree, node) for node in leaves}
        others = {
            text: [
                n for n in (*list_near_names(place), *_list_unused_names(place)) if n not in places
            ]
            for text, place in places.items()
        }
        for count in (1, 2, 3):
            for changed in combinations(others, count):
                for names in product(*(others[each] for each in changed)):
                    exchanged = dict(zip(changed, names, strict=True))
                    if len({*names}) == count and _are_alike(exchanged, site.scope.unused):
                        pairs = [(node, exchanged.get(ast.unparse(node), "")) for node in leaves]
                        like = write_exchanged(Site(site.tree, summand), [p for p in pairs if p[1]])
                        yield f"{write_operand(site.node)} + {like}"


def _list_unused_names(site: Site) -> list[str]:
    """The names of its kind that nothing reads."""
    kinds = site.scope.list_leaves()
    return [text for text, kind in kinds if text in site.scope.unused and site.can_be(kind)]


def _are_alike(exchanged: Mapping[str, str], unused: Collection[str]) -> bool:
    """Whether one body's names may stand for another's, of which only the index differs.

    Of two at least one has the same letters, m2 a2 and mp L2, but not l2 L2; of three none is read
    anywhere but one.
    """
    if len(exchanged) > 2:
        return sum(name in unused for name in exchanged.values()) >= 2
    return len(exchanged) == 1 or any(a[0] == b[0] for a, b in exchanged.items())


def list_further_derivatives(site: Site) -> Texts:
    """A sum less a derivative like one of the code: dT/dq, which Lagrange's equations have."""
    if not site.is_sum_place(outer=True):
        return
    for node in site.scope.nodes:
        name = getattr(node.func, "attr", "") if isinstance(node, ast.Call) else ""
        if name in DERIVATIVES and isinstance(node, ast.Call) and node.args:
            above, variable = site.tree.parent(node), Site(site.tree, node.args[-1])
            is_turned = isinstance(above, ast.Attribute) and above.attr == "T"
            whole = Site(site.tree, above if is_turned and above else node)
            for other in (variable.text, *list_near_names(variable)):
                like = write_exchanged(whole, [(variable.node, other)])
                yield f"{write_operand(site.node)} - {like}"


def list_further_matrix_products(site: Site) -> Texts:
    """A sum of arrays with a product of matrices more, of which the code has all but one factor.

    So a bias is reduced as the line before reduces the matrix: c - B' inv(A) b for C - B' inv(A) B.
    """
    if not site.is_sum_place(outer=True) or (site.kind or NUMBER)[0] != "array":
        return
    for node in site.scope.nodes:
        if not is_matrix_product(node) or is_matrix_product(site.tree.parent(node)):
            continue
        for factor, other in ((node.left, node.right), (node.right, node.left)):
            beside = site.tree.kind(other)
            for text, kind in site.scope.list_leaves(written=True) if beside else ():
                sides = (kind, beside) if factor is node.left else (beside, kind)
                if _can_be_multiplied(*sides) and find_product_kind(*sides) == site.kind:
                    like = write_exchanged(Site(site.tree, node), [(factor, text)])
                    yield from (f"{write_operand(site.node)} {sign} {like}" for sign in "-+")


def _can_be_multiplied(left: Kind, right: Kind) -> bool:
    are_arrays = left[0] == right[0] == "array"
    return are_arrays and len(left) > 1 and len(right) > 1 and left[-1] == right[1]


def list_further_elements(site: Site) -> Texts:
    """A list of bodies with one more, which has a number that no line reads: the payload's mass.

    Its other numbers are the last ones of lists, or 0.
    """
    node = site.node
    if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
        return
    listed = node.value.elts if isinstance(node.value, ast.List) else []
    listed = [node.value.elt] if isinstance(node.value, ast.ListComp) else listed
    if not listed or not all(isinstance(each, ast.Tuple) for each in listed):
        return
    name, leaves = node.targets[0].id, list(site.scope.list_leaves())
    unread = [text for text, kind in leaves if kind == NUMBER and site.tree.is_unread(text)]
    numbers = [text for text, kind in leaves if kind == NUMBER and text.endswith("[-1]")]
    lists = [f"{text}[-1]" for text, kind in leaves if kind[0] == "array" and len(kind) == 2]
    usual: dict[Kind, list[str]] = {
        INDEX: [f"len({name}) - 1"],
        NUMBER: ["0.0", *dict.fromkeys((*numbers, *lists))],
    }
    kinds = [site.tree.kind(each) for each in ast.iter_child_nodes(listed[-1])][:-1]
    for place in (place for place, kind in enumerate(kinds) if kind == NUMBER):
        choices = [
            unread if n == place else usual.get(kind or (), []) for n, kind in enumerate(kinds)
        ]
        for values in product(*choices):
            yield f"{site.text}\n{name}.append(({', '.join(values)}))"


def _is_square(kind: Kind) -> bool:
    return len(kind) == MATRIX_LENGTH and kind[1] == kind[2]


def _split_sum(node: ast.AST) -> list[ast.AST]:
    return [*_split_sum(node.left), *_split_sum(node.right)] if is_sum(node) else [node]


def list_further_outer_products(site: Site) -> Texts:
    """A sum of matrices with a mass times a lever's products more: by Steiner's theorem.

    Of an inertia, or of second moments.
    """
    kinds = map(site.tree.kind, _split_sum(site.node))
    is_place = site.is_sum_place(outer=True) and ("array", 3, 3) in kinds
    library = _find_numpy(site) if is_place else ""
    if not library:
        return
    text = write_operand(site.node)
    leaves = list(site.scope.list_leaves(written=True))
    masses = [name for name, kind in leaves if kind == NUMBER]
    for lever in (name for name, kind in leaves if kind == VECTOR):
        square = f"{library}.outer({lever}, {lever})"
        inertia = f"({lever} @ {lever} * {library}.eye(3) - {square})"
        for mass, matrix in product(masses, (square, inertia)):
            yield from (f"{text} {sign} {mass} * {matrix}" for sign in "+-")


def list_further_cross_products(site: Site, *, of_products: bool) -> Texts:
    """A sum of vectors with a cross product more, of a name and a name or a product of two.

    Also the centripetal w x (w x r).
    """
    is_place = site.kind in (VECTOR, None) and site.is_sum_place(outer=True)
    called = _find_called(site, "cross") if is_place and is_sum(site.node) else ""
    if not called:
        return
    names = [text for text, kind in site.scope.list_leaves(written=True) if kind == VECTOR]

    def is_short_product(node: ast.AST | None) -> bool:
        sides = (node.left, node.right) if is_product(node) else ()
        return bool(sides) and all(map(site.tree.is_leaf, sides))

    products = site.list_products(is_short_product) if of_products else []
    others = dict.fromkeys(products or names)
    pairs = [(a, b) for b in others for a in dict.fromkeys([*names, *products]) if a != b]
    calls = [each for each in ast.walk(site.node) if isinstance(each, ast.Call)]
    inside = {ast.unparse(argument) for each in calls for argument in each.args}
    if of_products:
        levers = [name for name in names if name in inside]
        pairs += [(a, f"{called}({a}, {b})") for b in levers for a in names if a != b]
    yield from (f"{site.text} + {called}({a}, {b})" for a, b in pairs)


def list_gyroscopic_products(site: Site) -> Texts:
    """A matrix times a vector with its gyroscopic product: I dw + w x (I w)."""
    is_place = site.is_value and not is_sum(site.parent)
    if is_matrix_product(site.node) and site.kind in (VECTOR, None) and is_place:
        matrix = write_operand(site.node.left)
        names = [text for text, kind in site.scope.list_leaves(written=True) if kind == VECTOR]
        for cross in _list_cross_products(site):
            yield from (f"{site.text} + {cross(name, f'{matrix} @ {name}')}" for name in names)


def _list_cross_products(site: Site) -> Iterator[Callable[[str, str], str]]:
    """How the code writes cross products: by the library's function, by a matrix of one factor."""
    if called := _find_called(site, "cross"):
        yield lambda a, b: f"{called}({a}, {b})"
    for name, scope in site.tree.functions.items():
        is_matrix = scope.result == ("array", *VECTOR[1:], *VECTOR[1:])
        if is_matrix and len(site.tree.list_arguments(name)) == 1:
            yield partial("{}({}) @ {}".format, name)


def list_reactions(site: Site) -> Texts:
    """An element of a list less the next one, which acts on the neighbour; the last has none."""
    node, loop = site.node, site.tree.statement(site.node)
    if not isinstance(node, ast.Subscript) or not site.is_sum_place(outer=True):
        return
    is_loop_index = isinstance(node.slice, ast.Name) and site.scope.kind(node.slice.id) == INDEX
    if is_loop_index and isinstance(site.tree.parent(loop), ast.For):
        elements, index = ast.unparse(node.value), ast.unparse(node.slice)
        following = f"{elements}[{index} + 1] if {index} + 1 < len({elements}) else 0.0"
        yield from (f"{site.text} {sign} ({following})" for sign in "-+")


def list_further_products(site: Site, *, sign: str) -> Texts:
    """A sum of vectors with a product more, of a function's matrix and a name: crm(v) @ s.

    So are cross products of spatial vectors written. A function that no line names is among them,
    since the line that is missing may have called it.
    """
    kind = site.kind or NUMBER
    is_vector = kind[0] == "array" and len(kind) == len(VECTOR)
    if not is_vector or not is_sum(site.node) or not site.is_sum_place(outer=True):
        return
    vectors = [text for text, other in site.scope.list_leaves(written=True) if other == kind]
    loaded = site.tree.loaded_names
    for name, scope in site.tree.functions.items():
        is_matrix = scope.result == ("array", *kind[1:], *kind[1:]) or name not in loaded
        if is_matrix and len(site.tree.list_arguments(name)) == 1:
            for a, b in permutations(vectors, 2):
                yield f"{site.text} {sign} {name}({a}) @ {b}"


def list_like_statements(site: Site) -> Texts:
    """A sum that goes on with another statement after it, like itself but for a name or two.

    So is the moment of a second force at another lever: n += c * f[1], then n += l * g[1].
    """
    if not isinstance(site.node, ast.AugAssign) or not isinstance(site.node.op, SUMS):
        return
    leaves = [node for node in ast.walk(site.node.value) if site.tree.is_leaf(node)]
    bases = [
        node.value
        for node in leaves
        if isinstance(node, ast.Subscript) and isinstance(node.value, LEAF)
    ]
    others = [
        [(node, other) for other in _list_alternatives(site, node)] for node in (*leaves, *bases)
    ]
    for count in (1, 2):
        for changed in combinations(others, count):
            for exchanged in product(*changed):
                if not _overlap([node for node, _ in exchanged]):
                    yield f"{site.text}\n{write_exchanged(site, exchanged)}"


def _list_alternatives(site: Site, node: ast.AST) -> Iterator[str]:
    """What the code names there that may stand for a part of a statement."""
    place, text = Site(site.tree, node), ast.unparse(node)
    for other, kind in site.scope.list_leaves(written=True):
        if other != text and place.kind is not None and place.can_be(kind):
            yield other


def _overlap(nodes: Sequence[ast.AST]) -> bool:
    """Whether one of some parts is in another."""
    return any(part in ast.walk(outer) for part, outer in permutations(nodes, 2))


def list_further_statements(site: Site, *, adding: bool) -> Texts:
    """A statement of a loop with another one after it, which carries a value of the loop on.

    It adds the value to what has one before the loop, or at the end of the loop keeps it there.
    """
    loop, scope = site.parent, site.scope
    if not isinstance(site.node, SIMPLE) or not isinstance(loop, ast.For):
        return
    varying = {each.id for each in ast.walk(loop) if is_stored(each)}
    stored = (each for each in scope.nodes if is_stored(each))
    for name in sorted({each.id for each in stored if each.lineno < loop.lineno}):
        for text, kind in scope.list_leaves(written=True):
            names = {n.id for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Name)}
            is_value = kind[0] in ("array", "number") and names & varying and text != name
            if is_value and kind == scope.kind(name):
                if adding:
                    yield f"{site.text}\n{name} += {text}"
                elif site.node is loop.body[-1]:
                    yield f"{site.text}\n{name} = {text}"
