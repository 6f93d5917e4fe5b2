"""The kinds of edits of a source, each with its likelihood: what people write for what is right."""

from __future__ import annotations

import ast
import difflib
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias, TypeGuard

from crosscheck.trial.source.syntax import INDEX, LEAF, NUMBER, Kind, SourceTree

SUMS, PRODUCTS = ast.Add | ast.Sub, ast.Mult | ast.Div | ast.MatMult
TRIGONOMETRY = {"sin": "cos", "cos": "sin"}
SIMPLE = ast.Assign | ast.AugAssign | ast.Expr
UNITS = (1e3, 1e-3, 10.0, 0.1, math.pi / 180, 180 / math.pi)  # factors of a number of the code
SIMILAR = 0.6  # of names, by difflib's ratio
VECTOR: Kind = ("array", 3)
Others: TypeAlias = Iterator[ast.AST]


class Edit(NamedTuple):
    """An edit: another node in the place of a node.

    likelihood: rank of its kind, 1 of the likeliest, and the kind's place among those of its rank.
    """

    likelihood: tuple[int, int]
    node: ast.expr | ast.stmt
    other: ast.expr | ast.stmt

    @property
    def rank(self) -> int:
        """Rank of the kind."""
        return self.likelihood[0]


class EditKind(NamedTuple):
    """A kind of edits: rank, from 1 of the likeliest, and what may stand for a node."""

    rank: int
    list_others: Callable[[SourceTree, ast.AST], Others]


def list_edits(tree: SourceTree, rank: int) -> Iterator[Edit]:
    """The edits of a rank of what ran, the likelier kinds first."""
    nodes = list(tree.list_nodes())
    for place, kind in enumerate(KINDS):
        if kind.rank == rank:
            for node in nodes:
                for other in kind.list_others(tree, node):
                    yield Edit((rank, place), node, other)


def _parse(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


def _is_binary(node: ast.AST | None, operators: type | object) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, operators)  # type: ignore[arg-type]


def _is_index(tree: SourceTree, node: ast.AST) -> bool:
    """Whether an expression counts: it is in brackets, or an argument of range."""
    above, below = tree.parent(node), node
    while isinstance(above, ast.expr | ast.Slice):
        if isinstance(above, ast.Subscript):
            return below is above.slice
        if isinstance(above, ast.Call):
            return isinstance(above.func, ast.Name) and above.func.id == "range"
        above, below = tree.parent(above), above
    return False


def _is_value(tree: SourceTree, node: ast.AST) -> bool:
    """Whether an expression is a value that is computed with, not a part of a name."""
    if isinstance(node, LEAF):
        if not tree.is_leaf(node):
            return False
    elif not isinstance(node, ast.BinOp | ast.Call | ast.UnaryOp):
        return False
    parent, name, _ = tree.places[id(node)]
    kind = tree.kind(node)
    is_called = name in ("func", "annotation", "decorator_list", "iter") or isinstance(parent, LEAF)
    is_whole = isinstance(parent, ast.Expr) or _is_index(tree, node)
    numeric = kind is None or kind[0] in ("int", "number", "array")
    return not is_called and not is_whole and numeric


def _fit(tree: SourceTree, node: ast.AST, kind: Kind | None, other: Kind | None) -> bool:
    """Whether something of a kind may stand for a node of a kind."""
    if kind is None or other is None:
        return False
    counts = {INDEX, NUMBER}
    return kind == other or (kind in counts and other in counts and not _is_index(tree, node))


def list_opposites(tree: SourceTree, node: ast.AST) -> Others:
    """The other sign of what has one."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, SUMS):
        other = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
        if isinstance(node, ast.BinOp):
            yield ast.BinOp(node.left, other, node.right)
        else:
            yield ast.AugAssign(node.target, other, node.value)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield node.operand


def list_negatives(tree: SourceTree, node: ast.AST) -> Others:
    """A minus before a name or a function."""
    if isinstance(node, LEAF | ast.Call) and _begins_term(tree, node):
        yield ast.UnaryOp(ast.USub(), node)


def list_negative_products(tree: SourceTree, node: ast.AST) -> Others:
    """A minus before a product, or before a sum as a whole."""
    if isinstance(node, ast.BinOp) and _begins_term(tree, node):
        yield _negate(node)


def _begins_term(tree: SourceTree, node: ast.AST) -> bool:
    """Whether a value has no sign or factor before it."""
    parent, name, _ = tree.places[id(node)]
    is_first = not isinstance(parent, ast.BinOp | ast.UnaryOp) or (
        name == "left" and _is_binary(parent, SUMS)
    )
    return is_first and _is_value(tree, node)


def _negate(node: ast.expr) -> ast.expr:
    """The negative of a product by its first factor, as people write it."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, PRODUCTS):
        return ast.BinOp(_negate(node.left), node.op, node.right)
    return ast.UnaryOp(ast.USub(), node)


def _exchange(*, near: bool, written: bool) -> Callable[[SourceTree, ast.AST], Others]:
    def list_exchanges(tree: SourceTree, node: ast.AST) -> Others:
        """Another name, attribute or element of the same kind; near: of a like notation."""
        is_base = isinstance(node, ast.Name) and isinstance(tree.parent(node), LEAF)
        if not (tree.is_leaf(node) or (is_base and isinstance(node, ast.Name))):
            return
        if is_base and (tree.places[id(node)][1] != "value" or not isinstance(node.ctx, ast.Load)):  # type: ignore[attr-defined]
            return
        text, kind = ast.unparse(node), tree.kind(node)
        for other, other_kind, is_written in tree.scopes[id(node)].list_leaves():
            if other == text or is_written != written or not _fit(tree, node, kind, other_kind):
                continue
            if is_base and not other.isidentifier():
                continue
            if near == _is_near(text, other, other_kind):
                yield _parse(other)

    return list_exchanges


def _is_near(text: str, other: str, kind: Kind) -> bool:
    """Whether somebody may take one for the other: of few of a kind, or of a like notation."""
    if kind != NUMBER:
        return True
    a, b = _parse(text), _parse(other)
    if isinstance(a, ast.Attribute) and isinstance(b, ast.Attribute):
        return a.attr == b.attr or ast.dump(a.value) == ast.dump(b.value)
    if isinstance(a, ast.Subscript) and isinstance(b, ast.Subscript):
        return ast.dump(a.value) == ast.dump(b.value) or ast.dump(a.slice) == ast.dump(b.slice)
    short = max(len(text), len(other)) <= 2 and (text[0] == other[0] or text[-1] == other[-1])
    return short or difflib.SequenceMatcher(None, text, other).ratio() > SIMILAR


def list_cofunctions(tree: SourceTree, node: ast.AST) -> Others:
    """The cosine for the sine, and the sine for the cosine."""
    if tree.places.get(id(node), (None, ""))[1] == "func":
        if isinstance(node, ast.Attribute) and node.attr in TRIGONOMETRY:
            yield ast.Attribute(node.value, TRIGONOMETRY[node.attr], ast.Load())
        if isinstance(node, ast.Name) and node.id in TRIGONOMETRY:
            yield ast.Name(TRIGONOMETRY[node.id], ast.Load())


def list_constants(tree: SourceTree, node: ast.AST) -> Others:
    """Another number for a number of the code; of one with a fraction also in another unit."""
    if not isinstance(node, ast.Constant) or type(node.value) not in (int, float):
        return
    value = node.value
    others = [value + 1, value - 1, -value, 2 * value, value / 2, 0, 1, 2]
    if isinstance(value, float):
        others += [value * unit for unit in UNITS]
    for other in dict.fromkeys(others):
        if other != value and not (_is_index(tree, node) and other != int(other)):
            is_whole = isinstance(value, int) and other == int(other)
            yield ast.Constant(int(other) if is_whole else float(other))


def list_transposes(tree: SourceTree, node: ast.AST) -> Others:
    """A matrix turned over, or no longer."""
    if isinstance(node, ast.Attribute) and node.attr == "T" and isinstance(node.ctx, ast.Load):
        yield node.value
    elif _is_value(tree, node) and not isinstance(node, ast.BinOp | ast.UnaryOp):
        kind = tree.kind(node)
        is_factor = kind is None and _is_binary(tree.parent(node), ast.MatMult)
        if is_factor or (kind is not None and len(kind) == 3):
            yield ast.Attribute(node, "T", ast.Load())


def list_orders(tree: SourceTree, node: ast.AST) -> Others:
    """Factors, arguments, indices or the sides of a difference in another order."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult | ast.Sub):
        yield ast.BinOp(node.right, node.op, node.left)
        if _is_binary(node.left, ast.MatMult):  # the outer ones of three
            assert isinstance(node.left, ast.BinOp)  # as it is a product
            first, middle = node.left.left, node.left.right
            yield ast.BinOp(ast.BinOp(node.right, node.op, middle), node.op, first)
    if isinstance(node, ast.Call):
        for place in range(len(node.args) - 1):
            first, second = node.args[place : place + 2]
            args = [*node.args[:place], second, first, *node.args[place + 2 :]]
            yield ast.Call(node.func, args, node.keywords)
    if isinstance(node, ast.Tuple) and len(node.elts) == 2 and isinstance(node.ctx, ast.Load):
        yield ast.Tuple(node.elts[::-1], ast.Load())


def list_parentheses(tree: SourceTree, node: ast.AST) -> Others:
    """A factor of one summand for several, and of several for one."""
    if _is_binary(node, SUMS) and not _is_binary(tree.parent(node), SUMS):
        yield from _widen_factors(_split_sum(node))
    if not _is_binary(node, PRODUCTS):
        return
    assert isinstance(node, ast.BinOp)  # as it is a product
    for whole, factor in ((node.left, node.right), (node.right, node.left)):
        if _is_binary(whole, SUMS):
            terms = _split_sum(whole)
            for place in range(len(terms)):
                is_left = whole is node.left
                left, right = (terms[place][1], factor) if is_left else (factor, terms[place][1])
                product = ast.BinOp(left, node.op, right)
                yield _join_sum([*terms[:place], (terms[place][0], product), *terms[place + 1 :]])


Terms: TypeAlias = list[tuple[ast.operator, ast.expr]]


def _split_sum(node: ast.AST) -> Terms:
    """The summands of a sum with their signs, the first one's an addition."""
    if _is_binary(node, SUMS):
        assert isinstance(node, ast.BinOp)  # as it is a sum
        return [*_split_sum(node.left), (node.op, node.right)]
    assert isinstance(node, ast.expr)  # of which sums consist
    return [(ast.Add(), node)]


def _join_sum(terms: Terms) -> ast.expr:
    whole = terms[0][1]
    for sign, term in terms[1:]:
        whole = ast.BinOp(whole, sign, term)
    return whole


def _widen_factors(terms: Terms) -> Others:
    """Sums in which a factor of one summand is that of its neighbours too."""
    for place, (sign, term) in enumerate(terms):
        if not isinstance(term, ast.BinOp) or not isinstance(term.op, PRODUCTS):
            continue
        for end in dict.fromkeys((place + 2, len(terms))):
            if place + 1 < end <= len(terms):
                inner = _join_sum([(sign, term.right), *terms[place + 1 : end]])
                whole = (sign, ast.BinOp(term.left, term.op, inner))
                yield _join_sum([*terms[:place], whole, *terms[end:]])
        for begin in dict.fromkeys((place - 1, 0)):
            if 0 <= begin < place:
                inner = _join_sum([*terms[begin:place], (sign, term.left)])
                whole = (terms[begin][0], ast.BinOp(inner, term.op, term.right))
                yield _join_sum([*terms[:begin], whole, *terms[place + 1 :]])


def list_multiples(tree: SourceTree, node: ast.AST) -> Others:
    """Twice and half of a whole term."""
    is_part = _is_binary(tree.parent(node), PRODUCTS | ast.Pow)
    is_term = not _is_binary(node, SUMS) and not isinstance(node, ast.UnaryOp)
    if is_term and not is_part and _is_value(tree, node):
        yield ast.BinOp(ast.Constant(2), ast.Mult(), node)
        yield ast.BinOp(node, ast.Div(), ast.Constant(2))


def list_powers(tree: SourceTree, node: ast.AST) -> Others:
    """A square, or none."""
    if _is_binary(node, ast.Pow):
        yield node.left  # type: ignore[attr-defined]
        return
    is_number = tree.is_leaf(node) and tree.kind(node) in (NUMBER, INDEX)
    if is_number and _is_value(tree, node) and not _is_binary(tree.parent(node), ast.Pow):
        yield ast.BinOp(node, ast.Pow(), ast.Constant(2))


def list_operands(tree: SourceTree, node: ast.AST) -> Others:
    """A summand or a factor less."""
    if isinstance(node, ast.BinOp) and not isinstance(node.op, ast.Pow):
        yield node.left
        if not isinstance(node.op, ast.Div):
            yield (
                node.right
                if not isinstance(node.op, ast.Sub)
                else ast.UnaryOp(ast.USub(), node.right)
            )


def list_arguments(tree: SourceTree, node: ast.AST) -> Others:
    """An argument without its function, or with it once more: u x (u x r) for u x r."""
    if not isinstance(node, ast.Call) or not node.args or not _is_value(tree, node):
        return
    *before, last = node.args
    if len(node.args) <= 2:
        yield last
    if len(node.args) == 2:
        yield ast.Call(node.func, [*before, node], node.keywords)


def list_steps(tree: SourceTree, node: ast.AST) -> Others:
    """An index or the end of a range one further, or one less."""
    if tree.is_leaf(node) and tree.kind(node) == INDEX and _is_index(tree, node):
        for sign in (ast.Add(), ast.Sub()):
            yield ast.BinOp(node, sign, ast.Constant(1))


def list_assignments(tree: SourceTree, node: ast.AST) -> Others:
    """A sum that goes on, or that begins anew."""
    if isinstance(node, ast.Assign) and len(node.targets) == 1:
        target = node.targets[0]
        if isinstance(target, LEAF):
            yield from (ast.AugAssign(target, sign, node.value) for sign in (ast.Add(), ast.Sub()))
    if isinstance(node, ast.AugAssign):
        yield ast.Assign([node.target], node.value)


def list_neighbours(tree: SourceTree, node: ast.AST) -> Others:
    """The expression of the line, or of the element, before or after."""
    if not isinstance(node, ast.BinOp | ast.Call | ast.List):
        return
    parent, name, index = tree.places[id(node)]
    if index is not None and isinstance(parent, ast.List | ast.Tuple):
        row = parent.elts
        yield from (row[k] for k in (index - 1, index + 1) if 0 <= k < len(row))
    if name == "value" and isinstance(parent, ast.Assign | ast.AugAssign):
        body, place = _find_body(tree, parent)
        for k in (place - 1, place + 1):
            other = body[k] if 0 <= k < len(body) else None
            if isinstance(other, ast.Assign | ast.AugAssign):
                yield other.value


def _find_body(tree: SourceTree, statement: ast.stmt) -> tuple[list[ast.stmt], int]:
    """The statements that one stands among, and its place."""
    if id(statement) not in tree.places:
        return list(tree.code.statements), tree.statements[id(statement)]
    parent, name, index = tree.places[id(statement)]
    assert index is not None  # of a list
    return getattr(parent, name), index


def list_distributions(tree: SourceTree, node: ast.AST) -> Others:
    """A factor of each summand in place of one for a whole sum."""
    if not _is_binary(node, ast.Mult | ast.MatMult):
        return
    assert isinstance(node, ast.BinOp)  # as it is a product
    for whole, factor in ((node.left, node.right), (node.right, node.left)):
        if not _is_binary(whole, SUMS) or not tree.is_leaf(factor):
            continue
        assert isinstance(whole, ast.BinOp)  # as it is a sum
        text, kind = ast.unparse(factor), tree.kind(factor)
        for other_text, other_kind, _ in tree.scopes[id(node)].list_leaves():
            if other_text != text and _fit(tree, node, kind, other_kind):
                other = _parse(other_text)
                for pair in ((factor, other), (other, factor)):
                    terms = zip((whole.left, whole.right), pair, strict=True)
                    left, right = (
                        ast.BinOp(*((a, node.op, b) if whole is node.left else (b, node.op, a)))
                        for a, b in terms
                    )
                    yield ast.BinOp(left, whole.op, right)


def list_inverses(tree: SourceTree, node: ast.AST) -> Others:
    """A quotient for a product, and a product for a quotient."""
    if _is_binary(node, ast.Mult | ast.Div):
        assert isinstance(node, ast.BinOp)  # as it is a product
        yield ast.BinOp(
            node.left, ast.Div() if isinstance(node.op, ast.Mult) else ast.Mult(), node.right
        )
        if isinstance(node.op, ast.Div):
            yield ast.BinOp(node.right, ast.Div(), node.left)


def list_repetitions(tree: SourceTree, node: ast.AST) -> Others:
    """A statement left out, twice, or with its mirror: an element below the diagonal."""
    if isinstance(node, SIMPLE) and not _is_text(node):
        yield ast.Pass()
        yield join_statements(node, node)
        target = node.targets[0] if isinstance(node, ast.Assign) else None
        if isinstance(target, ast.Subscript) and isinstance(target.slice, ast.Tuple):
            mirror = ast.Tuple(target.slice.elts[::-1], ast.Load())
            value = ast.Subscript(target.value, target.slice, ast.Load())
            other = ast.Subscript(target.value, mirror, ast.Store())
            yield join_statements(node, ast.Assign([other], value))


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def join_statements(first: ast.stmt, second: ast.stmt) -> ast.If:
    """Two statements in the place of one."""
    return ast.If(ast.Constant(True), [first, second], [])


def list_further_factors(tree: SourceTree, node: ast.AST) -> Others:
    """A whole term with a factor more; none of it, or one."""
    if not _is_value(tree, node) or _is_binary(tree.parent(node), PRODUCTS):
        return
    if tree.is_leaf(node):
        yield from (ast.Constant(number) for number in (0, 1))
    if _is_binary(node, SUMS) or isinstance(node, ast.UnaryOp):
        return
    for text, kind, is_written in tree.scopes[id(node)].list_leaves():
        if kind == NUMBER and is_written:
            yield ast.BinOp(_parse(text), ast.Mult(), node)


def list_further_matrices(tree: SourceTree, node: ast.AST) -> Others:
    """A matrix more in front of a product of matrices, behind it, or of a vector."""
    if not _is_value(tree, node) or _is_binary(tree.parent(node), ast.MatMult):
        return
    kind = tree.kind(node)
    if not (_is_binary(node, ast.MatMult) or (kind is not None and kind[0] == "array")):
        return
    for text, other, _ in tree.scopes[id(node)].list_leaves():
        if len(other) == 3 and other[1] == other[2]:
            for matrix in (_parse(text), _parse(f"{text}.T")):
                yield ast.BinOp(matrix, ast.MatMult(), node)
                if kind is None or len(kind) == 3:
                    yield ast.BinOp(node, ast.MatMult(), matrix)


def _is_sum_place(tree: SourceTree, node: ast.AST, *, outer: bool) -> bool:
    """Whether a summand may be missing at an expression, which is all of a sum.

    outer: whether it is what a statement assigns, returns or collects, or an element of that.
    """
    if not _is_value(tree, node) or _is_binary(tree.parent(node), SUMS):
        return False
    above = tree.parent(node)
    while isinstance(above, ast.List | ast.Tuple | ast.Call):
        if isinstance(above, ast.Call) and not isinstance(tree.parent(above), ast.Expr):
            break
        above = tree.parent(above)
    return outer == isinstance(above, ast.stmt)


def _summands(*, outer: bool) -> Callable[[SourceTree, ast.AST], Others]:
    def list_further_summands(tree: SourceTree, node: ast.AST) -> Others:
        """A sum with a summand more: what the code names, or a product of the same function."""
        if not _is_sum_place(tree, node, outer=outer):
            return
        scope, kind = tree.scopes[id(node)], tree.kind(node)
        leaves = (
            text for text, other, w in scope.list_leaves() if w and _fit(tree, node, kind, other)
        )
        products = (
            ast.unparse(each)
            for each in scope.nodes
            if _is_binary(each, ast.Mult | ast.MatMult) and tree.kind(each) in (kind, None)
        )
        for text in dict.fromkeys([*leaves, *products]):
            yield ast.BinOp(node, ast.Add(), _parse(text))
            yield ast.BinOp(node, ast.Sub(), _parse(text))

    return list_further_summands


def _cross_products(*, of_products: bool) -> Callable[[SourceTree, ast.AST], Others]:
    def list_further_cross_products(tree: SourceTree, node: ast.AST) -> Others:
        """A sum of vectors with a cross product more, of a name and a name or a product."""
        kind = tree.kind(node)
        if kind not in (VECTOR, None) or not _is_binary(node, ast.Add):
            return
        if not _is_sum_place(tree, node, outer=True):
            return
        scope = tree.scopes[id(node)]
        calls = (ast.unparse(each.func) for each in scope.nodes if isinstance(each, ast.Call))
        cross = next((text for text in calls if text.endswith("cross")), "")
        names = [text for text, other, w in scope.list_leaves() if w and other == VECTOR]
        products = (
            ast.unparse(each)
            for each in scope.nodes
            if isinstance(each, ast.BinOp)
            and tree.kind(each) == VECTOR
            and tree.is_leaf(each.left)
            and tree.is_leaf(each.right)
        )
        for second in dict.fromkeys(products if of_products else names):
            for first in names if cross else ():
                if first != second:
                    yield ast.BinOp(node, ast.Add(), _parse(f"{cross}({first}, {second})"))

    return list_further_cross_products


def list_further_statements(tree: SourceTree, node: ast.AST) -> Others:
    """A statement of a loop with another one after it, which carries a value of the loop on.

    It adds the value to, or at the end keeps it in, what has a value before the loop.
    """
    loop = tree.parent(node)
    if not isinstance(node, SIMPLE) or not isinstance(loop, ast.For):
        return
    scope = tree.scopes[id(node)]
    own = {each.id for each in ast.walk(loop) if _is_stored(each)}
    for name in sorted({n.id for n in scope.nodes if _is_stored(n) and n.lineno < loop.lineno}):
        kind, target = scope.kind(name), ast.Name(name, ast.Store())
        if kind is None or kind[0] not in ("array", "number"):
            continue
        for text, other, is_written in scope.list_leaves():
            value = _parse(text)
            names = {each.id for each in ast.walk(value) if isinstance(each, ast.Name)}
            if is_written and other == kind and text != name and names & own:
                yield join_statements(node, ast.AugAssign(target, ast.Add(), value))
                if node is loop.body[-1]:
                    yield join_statements(node, ast.Assign([target], value))


def _is_stored(node: ast.AST) -> TypeGuard[ast.Name]:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)


# The likelihood of each kind, by rank. What is one letter or sign away comes first; what needs a
# new expression comes last, and is also what fits by chance where numbers are equal.
KINDS = (
    EditKind(1, list_opposites),
    EditKind(1, list_negatives),
    EditKind(1, list_negative_products),
    EditKind(2, _exchange(near=True, written=True)),
    EditKind(2, list_cofunctions),
    EditKind(2, list_constants),
    EditKind(2, list_transposes),
    EditKind(2, list_orders),
    EditKind(2, list_parentheses),
    EditKind(2, list_multiples),
    EditKind(2, list_powers),
    EditKind(2, list_operands),
    EditKind(2, list_steps),
    EditKind(2, list_assignments),
    EditKind(3, _exchange(near=True, written=False)),
    EditKind(3, _exchange(near=False, written=True)),
    EditKind(3, list_neighbours),
    EditKind(3, list_distributions),
    EditKind(3, list_inverses),
    EditKind(3, list_repetitions),
    EditKind(4, _exchange(near=False, written=False)),
    EditKind(4, list_arguments),
    EditKind(4, list_further_factors),
    EditKind(4, list_further_matrices),
    EditKind(5, _summands(outer=True)),
    EditKind(5, _cross_products(of_products=True)),
    EditKind(5, list_further_statements),
    EditKind(6, _summands(outer=False)),
    EditKind(6, _cross_products(of_products=False)),
)
RANKS = sorted({kind.rank for kind in KINDS})
