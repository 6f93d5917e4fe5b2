"""Edits that change what stands there: a sign, a name, a factor's place, a statement."""

from __future__ import annotations

import ast
import difflib
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations, permutations
from typing import TypeAlias

from crosscheck.trial.changes.numbers import INERTIA_ORDERS
from crosscheck.trial.source.site import (
    Site,
    get_sign,
    is_matrix_product,
    is_power,
    is_product,
    is_stored,
    is_sum,
    write_operand,
)
from crosscheck.trial.source.syntax import INDEX, LEAF, MOST_ELEMENTS, NUMBER, Kind

OPPOSITE = {"+": "-", "-": "+"}
EQUALITY = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==",
}  # fmt: skip
ENDS = "", " + 1"  # of an index
COUNTERPARTS = {"sin": "cos", "cos": "sin", "tril": "triu", "triu": "tril"}
SIMPLE = ast.Assign | ast.AugAssign | ast.Expr
UNITS = (1e3, 1e-3, 10.0, 0.1, math.pi / 180, 180 / math.pi)  # factors of a number of the code
SIMILAR = 0.6  # least similarity of two names, by difflib's ratio
MOST_TURNED = 3  # elements that change places all together
SHORT = 2  # letters of names as formulas have them
NUMBERED = re.compile(r"[^\W\d]{1,3}_?(\d+)")  # a name of few letters, and its number
MATRIX_LENGTH = 3  # of a matrix's kind: the word, and two lengths
Texts: TypeAlias = Iterator[str]


def list_opposites(site: Site) -> Texts:
    """The other sign of what has one."""
    node = site.node
    if is_sum(node):
        other = OPPOSITE[get_sign(node.op)]
        yield f"{write_operand(node.left)} {other} {write_operand(node.right)}"
    if isinstance(node, ast.AugAssign) and get_sign(node.op) in OPPOSITE:
        yield f"{ast.unparse(node.target)} {OPPOSITE[get_sign(node.op)]}= {ast.unparse(node.value)}"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield ast.unparse(node.operand)


def list_negatives(site: Site, *, of_products: bool, inside: bool) -> Texts:
    """A minus before a name or a function, or before a product or a whole sum.

    inside: of what stands in a formula, or else of an argument or of all that a name is given.
    """
    is_inner = isinstance(site.parent, ast.BinOp | ast.UnaryOp)
    is_first = not is_inner or (site.name == "left" and is_sum(site.parent))
    is_kind = isinstance(site.node, ast.BinOp) == of_products
    is_alone = isinstance(site.parent, ast.Call) or (
        not of_products and isinstance(site.parent, ast.Assign)
    )
    if not (is_first and is_kind and site.is_value) or is_alone == inside:
        return
    if not isinstance(site.node, ast.UnaryOp):
        text = site.text if is_product(site.node) else write_operand(site.node)
        yield from [] if text.startswith("-") else [f"-{text}"]


def list_exchanges(site: Site, *, near: bool, written: bool) -> Texts:
    """Another name, attribute or element of the same kind, or another object that has it."""
    is_object = isinstance(site.node, ast.Name) and isinstance(site.parent, LEAF)
    is_object = is_object and site.name == "value"
    if not site.is_leaf and not is_object:
        return
    text, opposed = site.text, _list_opposed(site)
    for other, kind in site.scope.list_leaves(written=written):
        is_other = other not in (text, *opposed) and site.can_be(kind)
        is_other = is_other and (other.isidentifier() or not is_object)
        if is_other and near == (_is_near(text, other, kind) and site.scope.are_alike(text, other)):
            yield other


def list_unused_exchanges(site: Site) -> Texts:
    """What has a name that nothing reads, for a name, an element or a formula of its kind."""
    is_formula = isinstance(site.node, ast.BinOp) and site.is_value
    is_leaf = isinstance(site.node, LEAF) and (site.is_leaf or isinstance(site.parent, LEAF))
    if is_leaf or is_formula:
        for other, kind in site.scope.list_leaves():
            if other.partition("[")[0] in site.scope.unused and site.can_be(kind):
                yield other


def list_near_names(site: Site) -> list[str]:
    """The names, attributes or elements of its kind that one may be mistaken for."""
    kinds = {name: kind for name, kind in site.scope.list_leaves() if site.can_be(kind)}
    return [name for name in kinds if name != site.text and _is_near(site.text, name, kinds[name])]


def _list_opposed(site: Site) -> list[str]:
    """The texts beside which the same once more is nothing, as in a - a, a x a or a.f(a)."""
    above, around = list[ast.expr](), site.tree.parent(site.parent) if site.parent else None
    if isinstance(site.parent, ast.BinOp) and isinstance(site.parent.op, ast.Sub):
        above = [site.parent.left, site.parent.right]
    elif isinstance(site.parent, ast.Call) and ast.unparse(site.parent.func).endswith("cross"):
        above = site.parent.args
    elif isinstance(site.parent, ast.Attribute) and isinstance(around, ast.Call):
        above = around.args if around.func is site.parent else []
    return [ast.unparse(each) for each in above if each is not site.node]


@cache
def _is_near(text: str, other: str, kind: Kind) -> bool:
    """Whether one may be mistaken for the other: few of a kind, or similar notations."""
    if kind != NUMBER and kind[0] != "array":
        return True
    a, b = (ast.parse(each, mode="eval").body for each in (text, other))
    if isinstance(a, ast.Attribute) and isinstance(b, ast.Attribute):
        return a.attr == b.attr or ast.dump(a.value) == ast.dump(b.value)
    if isinstance(a, ast.Subscript) and isinstance(b, ast.Subscript):
        return ast.dump(a.value) == ast.dump(b.value) or ast.dump(a.slice) == ast.dump(b.slice)
    is_short = max(len(text), len(other)) <= SHORT and (
        text[0] == other[0] or text[1:] == other[1:]
    )
    ends = [NUMBERED.fullmatch(each) for each in (text, other)]  # lc2 and L2
    is_short |= all(ends) and len({end and end[1] for end in ends}) == 1
    return is_short or difflib.SequenceMatcher(None, text, other).ratio() > SIMILAR


def list_repeated_exchanges(site: Site) -> Texts:
    """Another name, attribute or element wherever a statement or a call has one more than once."""
    node = site.node
    if isinstance(node, ast.Assign | ast.AugAssign | ast.Return):
        whole: ast.AST = node.value or node
    elif isinstance(node, ast.Call) and site.is_value:
        whole = node
    else:
        return
    leaves = [each for each in ast.walk(whole) if site.tree.is_leaf(each)]
    for text, count in Counter(map(ast.unparse, leaves)).items():
        repeated = [node for node in leaves if count > 1 and ast.unparse(node) == text]
        place = Site(site.tree, repeated[0]) if repeated else site
        for other, kind in site.scope.list_leaves() if repeated else ():
            if other != text and place.can_be(kind):
                yield write_exchanged(site, [(node, other) for node in repeated])


def list_symmetric_signs(site: Site) -> Texts:
    """A matrix that is written out, with the other sign of a number that stands there twice."""
    rows = site.node.elts if isinstance(site.node, ast.List) else []
    if not rows or not all(isinstance(row, ast.List) for row in rows):
        return
    nodes = [each for row in rows for each in ast.iter_child_nodes(row)]
    texts = [ast.unparse(each) for each in nodes if isinstance(each, ast.expr)]
    for text, count in Counter(texts).items():
        if count > 1 and text.strip("-0."):
            other = text.removeprefix("-") if text.startswith("-") else f"-{text}"
            yield write_exchanged(site, [(n, other) for n in nodes if ast.unparse(n) == text])


def list_swaps(site: Site) -> Texts:
    """A sum with two of its names exchanged throughout: A s^2 + B c^2 for A c^2 + B s^2."""
    if not is_sum(site.node):
        return
    leaves = [node for node in ast.walk(site.node) if site.tree.is_leaf(node)]
    texts = list(map(ast.unparse, leaves))
    kinds = {text: site.tree.kind(leaf) for text, leaf in zip(texts, leaves, strict=True)}
    for first, second in combinations(kinds, 2):
        if kinds[first] == kinds[second]:
            other = {first: second, second: first}
            pairs = zip(leaves, texts, strict=True)
            yield write_exchanged(site, [(leaf, other[t]) for leaf, t in pairs if t in other])


def write_exchanged(site: Site, exchanged: Sequence[tuple[ast.AST, str]]) -> str:
    """Source text of a site with other texts in place of some of its nodes."""
    for node, text in exchanged:
        site.tree.put(node, ast.parse(text, mode="eval").body)
    written = ast.unparse(site.node)
    for node, _ in exchanged:
        site.tree.put(node, node)
    return written


def list_counterparts(site: Site) -> Texts:
    """The cosine for the sine, the upper triangle for the lower, and the reverse."""
    *path, name = site.text.split(".") if site.name == "func" else ("",)
    if name in COUNTERPARTS:
        yield ".".join([*path, COUNTERPARTS[name]])


def list_other_functions(site: Site) -> Texts:
    """Another function of the source, of as many arguments, for the one that is called."""
    if site.name != "func" or not isinstance(site.node, ast.Name | ast.Attribute):
        return
    *path, name = site.text.split(".")
    if name in site.tree.functions:
        arguments, result = site.tree.list_arguments(name), site.tree.functions[name].result
        for other, scope in site.tree.functions.items():
            count = len(site.tree.list_arguments(other))
            if other != name and count == len(arguments) and scope.result in (result, None):
                yield ".".join([*path, other])


def list_constants(site: Site) -> Texts:
    """Another number for a number of the code, or the name of an index.

    Of one with a fraction also in another unit, and rounded as people write it.
    """
    value = site.node.value if isinstance(site.node, ast.Constant) else None
    if not isinstance(value, int | float) or isinstance(value, bool):
        return
    steps = [value + 1, value - 1] if value == int(value) else []
    others = [*steps, -value, 2 * value, value / 2, 0, 1, 2]
    if isinstance(value, float):
        converted = [float(f"{value * unit:.15g}") for unit in UNITS]
        others += [*converted, *(float(f"{each:.2g}") for each in converted)]
    for other in dict.fromkeys(others):
        is_whole = isinstance(value, int) and other == int(other)
        if other != value and (is_whole or not site.is_index):
            yield repr(int(other) if is_whole else float(other))
    if site.is_index:
        yield from (text for text, kind in site.scope.list_leaves(written=True) if kind == INDEX)


def list_names_for_constants(site: Site) -> Texts:
    """A name or attribute for a number with a fraction that stands in the place of one."""
    if is_fraction(site):
        yield from (text for text, kind in site.scope.list_leaves() if kind == NUMBER)


def list_zeros(site: Site) -> Texts:
    """A name for a number 0 of a vector or of an entry, such as the offset that is left out."""
    is_zero = isinstance(site.node, ast.Constant) and site.node.value in (0, 0.0)
    if not is_zero or site.is_index:
        return
    elements: Sequence[ast.expr] = ()
    if isinstance(site.parent, ast.Call):
        elements = site.parent.args
    elif isinstance(site.parent, ast.List | ast.Tuple):
        is_row = isinstance(site.tree.parent(site.parent), ast.List)  # of a matrix
        elements = () if is_row else site.parent.elts
    elif isinstance(site.parent, ast.Assign):  # an entry of a matrix
        elements = (
            site.parent.targets[:1] if isinstance(site.parent.targets[0], ast.Subscript) else ()
        )
    if any(not isinstance(each, ast.Constant) for each in elements):
        yield from (text for text, kind in site.scope.list_leaves() if kind == NUMBER)


def list_vacant_elements(site: Site) -> Texts:
    """0 for an element of a vector that has 0 elsewhere: of a force where nothing acts."""
    elements = map(ast.unparse, getattr(site.parent, "elts", ()))
    if site.is_value and not isinstance(site.node, ast.Constant):
        yield from [each for each in elements if each in ("0", "0.0")][:1]


def list_transposes(site: Site) -> Texts:
    """A matrix turned over, or no longer."""
    node, kind = site.node, site.kind
    if isinstance(node, ast.Attribute) and node.attr == "T":
        yield ast.unparse(node.value)
    elif site.is_value and isinstance(node, LEAF | ast.Call):
        is_matrix = kind is not None and len(kind) == MATRIX_LENGTH
        if is_matrix or (kind is None and is_matrix_product(site.parent)):
            yield f"{site.text}.T"


def list_written_transposes(site: Site) -> Texts:
    """A matrix turned over whose elements are written there, as that of a rotation is."""
    rows = site.node.args[0] if isinstance(site.node, ast.Call) and site.node.args else None
    if isinstance(rows, ast.List) and all(isinstance(row, ast.List) for row in rows.elts):
        yield f"{site.text}.T"


def list_orders(site: Site) -> Texts:
    """Factors, arguments, elements or the sides of a difference in another order."""
    node = site.node
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult | ast.Sub):
        yield f"{write_operand(node.right)} {get_sign(node.op)} {write_operand(node.left)}"
    if is_matrix_product(node) and not is_matrix_product(site.parent):
        factors = _split_matrix_product(node)
        for place in range(1, len(factors) - 1):  # the first two are a product of their own
            yield " @ ".join(factors[k] for k in _swap(range(len(factors)), place, place + 1))
    if isinstance(node, ast.Call):
        args = [ast.unparse(each) for each in (*node.args, *node.keywords)]
        for place in range(len(node.args) - 1):
            swapped = [*args[:place], args[place + 1], args[place], *args[place + 2 :]]
            yield f"{ast.unparse(node.func)}({', '.join(swapped)})"
    if isinstance(node, ast.Tuple | ast.List) and isinstance(node.ctx, ast.Load):
        count = len(node.elts)
        places = list(range(count))
        swaps = combinations(range(min(count, MOST_ELEMENTS)), 2)
        turns = [(1, 2, 0), (2, 0, 1)] if count == MOST_TURNED else []
        for order in [*(_swap(places, *pair) for pair in swaps), *turns]:
            listed = ", ".join(ast.unparse(node.elts[place]) for place in order)
            yield f"[{listed}]" if isinstance(node, ast.List) else listed


def _split_matrix_product(node: ast.expr) -> list[str]:
    """The factors of a product of matrices from left to right."""
    if not is_matrix_product(node):
        return [write_operand(node)]
    return [*_split_matrix_product(node.left), write_operand(node.right)]


def _swap(places: Sequence[int], first: int, second: int) -> list[int]:
    other = {first: second, second: first}
    return [other.get(place, place) for place in places]


def list_congruences(site: Site) -> Texts:
    """The outer ones of three matrices exchanged: R' I R for R I R'."""
    node = site.node
    if is_matrix_product(node) and is_matrix_product(node.left):
        inner, outer = node.left, write_operand(node.right)
        yield f"{outer} @ {write_operand(inner.right)} @ {write_operand(inner.left)}"


def list_parentheses(site: Site) -> Texts:
    """A sum with parentheses around more or less of it."""
    node = site.node
    if is_sum(node) and not is_sum(site.parent):
        tokens = _split_formula(node)
        for end in range(3, len(tokens) + 1, 2):
            for begin in range(0, end - 2, 2):
                inner = " ".join(tokens[begin:end])
                yield " ".join([*tokens[:begin], f"({inner})", *tokens[end:]])
    if is_product(node):
        if is_power(node.right):
            base, exponent = write_operand(node.right.left), ast.unparse(node.right.right)
            yield f"({ast.unparse(node.left)} {get_sign(node.op)} {base}) ** {exponent}"
        for several in (side for side in (node.left, node.right) if is_sum(side)):
            left, right = (
                ast.unparse(side) if side is several else write_operand(side)
                for side in (node.left, node.right)
            )
            yield f"{left} {get_sign(node.op)} {right}"


def _split_formula(node: ast.expr) -> list[str]:
    """The factors and summands of a formula that need no parentheses, and the signs between."""
    if not is_sum(node) and not is_product(node):
        return [write_operand(node)]
    is_open = is_sum(node) or not is_sum(node.left)
    left = _split_formula(node.left) if is_open else [write_operand(node.left)]
    is_open = is_sum(node) and is_product(node.right)
    right = _split_formula(node.right) if is_open else [write_operand(node.right)]
    return [*left, get_sign(node.op), *right]


def list_multiples(site: Site) -> Texts:
    """Twice and half of a whole term, and nothing where it is no summand; so of what is squared.

    And half of a sum, or twice, that a minus stands before.
    """
    if is_sum(site.node) and isinstance(site.parent, ast.UnaryOp):
        yield from (f"({site.text}) / 2", f"2 * ({site.text})")
    is_base = is_power(site.parent) and is_product(site.node)
    if (site.is_term and not is_sum(site.node)) or is_base:
        if not is_sum(site.parent) and site.kind in (NUMBER, None) and not site.is_leaf:
            yield "0"
        yield f"2 * {write_operand(site.node) if is_power(site.node) else site.text}"
        yield f"{site.text} / 2"


def list_powers(site: Site) -> Texts:
    """A square, or none."""
    if is_power(site.node):
        yield ast.unparse(site.node.left)
    elif (site.is_number or site.is_array or is_fraction(site)) and not is_power(site.parent):
        yield f"{site.text} ** 2"


def is_fraction(site: Site) -> bool:
    """Whether it is a number of the code with a fraction, and no index."""
    return isinstance(site.node, ast.Constant) and isinstance(site.node.value, float)


def list_operands(site: Site) -> Texts:
    """A summand or a factor less."""
    node = site.node
    if isinstance(node, ast.BinOp) and not is_power(node):
        yield ast.unparse(node.left)
        if not isinstance(node.op, ast.Div):
            yield f"{'-' * isinstance(node.op, ast.Sub)}{write_operand(node.right)}"


def list_steps(site: Site) -> Texts:
    """An index or the end of a range one further, or one less, or the first."""
    if site.is_leaf and site.is_index and site.kind == INDEX:
        yield from (*(f"{site.text} {sign} 1" for sign in OPPOSITE), "0")


def list_bounds(site: Site) -> Texts:
    """The larger or the smaller of an index and another one."""
    if site.is_leaf and site.kind == INDEX:
        for other, kind in site.scope.list_leaves(written=True):
            if kind == INDEX and other != site.text:
                yield from (f"{bound}({site.text}, {other})" for bound in ("max", "min"))


def list_slices(site: Site) -> Texts:
    """All up to an index, or from it; the other half of an array."""
    if isinstance(site.node, ast.Slice) and (site.node.lower is None) != (site.node.upper is None):
        lower, upper = (each and ast.unparse(each) for each in (site.node.lower, site.node.upper))
        yield f"{upper or ''}:{lower or ''}"
    is_element = isinstance(site.parent, ast.Subscript | ast.Tuple)
    if is_element and site.is_leaf and site.is_index and site.kind == INDEX:
        yield from (f":{site.text} + 1", f":{site.text}", f"{site.text}:")


def list_comparisons(site: Site) -> Texts:
    """A comparison that counts equality, or no longer does; or the other of two alternatives."""
    node = site.node
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        other = EQUALITY.get(type(node.ops[0]))
        if other:
            yield f"{write_operand(node.left)} {other} {write_operand(node.comparators[0])}"
    if isinstance(node, ast.IfExp):
        yield from (ast.unparse(node.body), ast.unparse(node.orelse))


def list_ranges(site: Site) -> Texts:
    """A loop from the other end, or from another index on, or up to it."""
    node = site.node
    if not isinstance(node, ast.Call) or ast.unparse(node.func) != "range":
        return
    yield f"reversed({site.text})"
    if len(node.args) == 1:
        stored = {each.id for each in ast.walk(site.parent) if is_stored(each)}
        for index, kind in site.scope.list_leaves(written=True):
            if kind == INDEX and index.isidentifier() and index not in stored:
                yield from (f"range({index})", f"range({index} + 1)")
                yield from (f"range({index}{each}, {ast.unparse(node.args[0])})" for each in ENDS)


def list_subscripts(site: Site) -> Texts:
    """Subscripts of an einsum with two letters of an operand exchanged, or another letter."""
    value = site.node.value if isinstance(site.node, ast.Constant) else None
    is_first = isinstance(site.parent, ast.Call) and site.name == "args" and site.index == 0
    if not isinstance(value, str) or not is_first or "einsum" not in ast.unparse(site.parent.func):
        return
    for operand in re.finditer(r"\w+", value):
        for first, second in combinations(range(*operand.span()), 2):
            if value[first] != value[second]:
                letters = list(value)
                letters[first], letters[second] = letters[second], letters[first]
                yield repr("".join(letters))
    for place, letter in enumerate(value):
        if letter.isalpha():
            others = sorted({each for each in value if each.isalpha()} - {letter})
            yield from (repr(f"{value[:place]}{each}{value[place + 1 :]}") for each in others)


def list_other_indices(site: Site) -> Texts:
    """An element of an element with two of its indices exchanged: dM[k][i, j] for dM[i][k, j]."""
    node, indices = site.node, list[ast.AST]()
    while isinstance(node, ast.Subscript):
        elements = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        indices += [each for each in elements if isinstance(each, ast.Name)]
        node = node.value
    is_nested = isinstance(getattr(site.node, "value", None), ast.Subscript)
    for first, second in combinations(indices, 2) if is_nested and site.is_leaf else ():
        texts = ast.unparse(first), ast.unparse(second)
        if texts[0] != texts[1]:
            yield write_exchanged(site, list(zip((first, second), texts[::-1], strict=True)))


def list_diagonals(site: Site) -> Texts:
    """Another element of the diagonal, I[2, 2] for I[1, 1], or a block that ends there."""
    node = site.node
    if not isinstance(node, ast.Subscript) or not isinstance(node.slice, ast.Tuple):
        return
    places, kind = {ast.unparse(each) for each in node.slice.elts}, site.tree.kind(node.value)
    if len(places) == 1 and kind is not None and len(kind) == MATRIX_LENGTH:
        count = min(*kind[1:], MOST_ELEMENTS)
        others = (f"{place}, {place}" for place in range(count) if str(place) not in places)
        yield from (f"{ast.unparse(node.value)}[{each}]" for each in others)
        (place,) = places
        blocks = [f":{place} + 1"]
        if place.isdecimal():
            blocks = [f"{begin}:{int(place) + 1}" for begin in range(int(place))]
        yield from (f"{ast.unparse(node.value)}[{block}, {block}]" for block in blocks)


def list_differences(site: Site, *, near: bool) -> Texts:
    """A vector less another, such as the lever between two places for one of them.

    near: of two elements of one list, or else of any two in a cross product, which may be a product
    with a matrix that a function makes; also their sum there.
    """
    parent = site.parent
    is_argument = isinstance(parent, ast.Call) and ast.unparse(parent.func).endswith("cross")
    is_factor = is_matrix_product(parent) and isinstance(parent.left, ast.Call)
    if site.is_array and (near or is_argument or is_factor):
        for other, kind in site.scope.list_leaves():
            is_other = other != site.text and site.can_be(kind)
            if is_other and near == (other.partition("[")[0] == site.text.partition("[")[0]):
                yield f"{site.text} - {other}"
                yield from [] if near else [f"{site.text} + {other}"]


def list_near_sums(site: Site, *, whole: bool, written: bool) -> Texts:
    """A number of a formula and its like: both joints' rates for one's, an absolute angle.

    Also of a symbol that is differentiated: (a + b).diff(t) for b.diff(t). whole: in the place of
    all that is called with or assigned, where no difference is usual: whose sums are not listed
    again.
    """
    above = site.tree.parent(site.parent)
    is_method = isinstance(site.parent, ast.Attribute) and isinstance(above, ast.Call)
    is_called = is_method and isinstance(site.node, ast.Name) and site.kind == NUMBER
    is_whole = is_called or (site.is_number and isinstance(site.parent, ast.Call | ast.Assign))
    is_part = site.is_number and isinstance(site.parent, ast.BinOp)
    if is_whole if whole else (is_part or is_whole):
        for other, kind in site.scope.list_leaves(written=written):
            if site.can_be(kind) and other != site.text and _is_near(site.text, other, kind):
                if whole or not (is_whole and written):
                    yield " + ".join(sorted((site.text, other)))
                if not whole:
                    yield f"{site.text} - {other}"


def list_assignments(site: Site) -> Texts:
    """A sum that goes on, or that begins anew; two names of several in the other order."""
    node = site.node
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
        names, value = [ast.unparse(each) for each in node.targets[0].elts], ast.unparse(node.value)
        for place in range(len(names) - 1):
            order = _swap(range(len(names)), place, place + 1)
            yield f"{', '.join(names[each] for each in order)} = {value}"
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], LEAF):
        target, value = ast.unparse(node.targets[0]), ast.unparse(node.value)
        yield from (f"{target} {sign}= {value}" for sign in OPPOSITE)
    if isinstance(node, ast.AugAssign):
        yield f"{ast.unparse(node.target)} = {ast.unparse(node.value)}"


def list_inertia_orders(site: Site) -> Texts:
    """Six elements, or names that six are given, in the order that another program has."""
    node = site.node
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
        elements, end = node.targets[0].elts, f" = {ast.unparse(node.value)}"
    elif isinstance(node, ast.Tuple | ast.List) and isinstance(node.ctx, ast.Load):
        elements, end = node.elts, ""
    else:
        return
    for order, other in permutations(INERTIA_ORDERS, 2):
        if len(elements) == len(order):
            texts = dict(zip(order, map(ast.unparse, elements), strict=True))
            listed = ", ".join(texts[entry] for entry in other)
            yield f"[{listed}]" if isinstance(node, ast.List) else f"{listed}{end}"


def list_neighbours(site: Site) -> Texts:
    """The expression of the line, or of the element, before or after."""
    row: Sequence[ast.AST | None] = ()
    if isinstance(site.parent, ast.List | ast.Tuple) and site.index is not None:
        row, place = site.parent.elts, site.index
    elif site.name == "value" and id(site.parent) in site.tree.places:
        above, name, index = site.tree.places[id(site.parent)]
        if index is not None and isinstance(site.parent, SIMPLE):
            row = [getattr(each, "value", None) for each in getattr(above, name)]
            place = index
    if row and isinstance(site.node, ast.BinOp | ast.Call | ast.List):
        neighbours = (row[k] for k in (place - 1, place + 1) if 0 <= k < len(row))
        yield from (ast.unparse(each) for each in neighbours if isinstance(each, ast.expr))


def list_distributions(site: Site) -> Texts:
    """A factor of each summand in place of one for a whole sum.

    So both levers are not turned by the same matrix.
    """
    node = site.node
    if not is_product(node):
        return
    by = get_sign(node.op)
    for whole, factor in ((node.left, node.right), (node.right, node.left)):
        if not is_sum(whole):
            continue
        text = write_operand(factor)
        for other in _list_like_factors(Site(site.tree, factor)):
            for pair in ((text, other), (other, text)):
                left, right = (
                    f"{write_operand(a)} {by} {b}"
                    if whole is node.left
                    else f"{b} {by} {write_operand(a)}"
                    for a, b in zip((whole.left, whole.right), pair, strict=True)
                )
                yield f"{left} {get_sign(whole.op)} {right}"


def _list_like_factors(site: Site) -> Texts:
    """Names that may stand for a factor, or the factor with another call of its function in it."""
    if site.is_leaf:
        for other, kind in site.scope.list_leaves():
            if site.can_be(kind) and other != site.text:
                yield other
    calls = [each for each in ast.walk(site.node) if isinstance(each, ast.Call)]
    written = [each for each in site.scope.nodes if isinstance(each, ast.Call)] if calls else []
    for call in calls:
        function, text = ast.unparse(call.func), ast.unparse(call)
        likes = (ast.unparse(each) for each in written if ast.unparse(each.func) == function)
        for like in dict.fromkeys(likes):
            if like != text:
                yield f"({write_exchanged(site, [(call, like)])})"


def list_operators(site: Site) -> Texts:
    """A product of matrices for one of elements, and the reverse; a quotient that is not cut."""
    node = site.node
    if not isinstance(node, ast.BinOp):
        return
    left, right = write_operand(node.left), write_operand(node.right)
    are_arrays = NUMBER not in (site.tree.kind(node.left), site.tree.kind(node.right))
    if isinstance(node.op, ast.FloorDiv):
        yield f"{left} / {right}"
    if isinstance(node.op, ast.Mult | ast.MatMult) and are_arrays:
        yield f"{left} {'@' if isinstance(node.op, ast.Mult) else '*'} {right}"


def list_inverses(site: Site) -> Texts:
    """A quotient for a product, and a product or its inverse for a quotient."""
    node = site.node
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div):
        left, right = write_operand(node.left), write_operand(node.right)
        yield f"{left} {'/' if isinstance(node.op, ast.Mult) else '*'} {right}"
        if isinstance(node.op, ast.Div):
            yield f"{right} / {left}"


def list_repetitions(site: Site) -> Texts:
    """A statement left out, twice, or with its mirror: the element across the diagonal."""
    node, text = site.node, site.text
    if isinstance(node, SIMPLE) and not isinstance(node.value, ast.Constant):
        yield from ("pass", f"{text}\n{text}")
        target = node.targets[0] if isinstance(node, ast.Assign) else None
        if isinstance(target, ast.Subscript) and isinstance(target.slice, ast.Tuple):
            mirror = ", ".join(ast.unparse(each) for each in target.slice.elts[::-1])
            yield f"{text}\n{ast.unparse(target.value)}[{mirror}] = {ast.unparse(target)}"
