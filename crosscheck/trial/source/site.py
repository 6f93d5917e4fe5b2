"""An expression or a statement of a user's source, and what stands around it."""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import cached_property
from typing import TypeGuard

from crosscheck.trial.source.syntax import INDEX, LEAF, NUMBER, Kind, SourceTree

SUMS, PRODUCTS = ast.Add | ast.Sub, ast.Mult | ast.Div | ast.MatMult
SIGNS = {"Add": "+", "Sub": "-", "Mult": "*", "Div": "/", "MatMult": "@", "Pow": "**"}


class Site:
    """An expression or a statement of the source, and what stands around it."""

    def __init__(self, tree: SourceTree, node: ast.AST) -> None:
        self.tree, self.node, self.scope = tree, node, tree.scopes[id(node)]
        self.parent, self.name, self.index = tree.places[id(node)]

    @cached_property
    def kind(self) -> Kind | None:
        """The kind of the expression, None where that is unknown."""
        return self.tree.kind(self.node)

    @cached_property
    def text(self) -> str:
        """The text of the node, as Python writes it."""
        return ast.unparse(self.node)

    @cached_property
    def is_leaf(self) -> bool:
        """Whether it is a whole name, attribute or element that is read, and not called."""
        return self.tree.is_leaf(self.node)

    @cached_property
    def is_index(self) -> bool:
        """Whether it is an index: inside brackets, or an argument of range."""
        below, above = self.node, self.tree.parent(self.node)
        while isinstance(above, ast.expr | ast.Slice):
            if isinstance(above, ast.Subscript):
                return below is above.slice
            if isinstance(above, ast.Call):
                return isinstance(above.func, ast.Name) and above.func.id == "range"
            below, above = above, self.tree.parent(above)
        return False

    @cached_property
    def is_datum(self) -> bool:
        """Whether its statement gives names numbers, and reads nothing."""
        return self.tree.is_datum(self.node)

    @cached_property
    def is_value(self) -> bool:
        """Whether it is a value that is computed with, and no part of a name."""
        if isinstance(self.node, LEAF):
            is_expression = self.is_leaf
        else:
            is_expression = isinstance(self.node, ast.BinOp | ast.Call | ast.UnaryOp)
        is_name = self.name in ("func", "decorator_list", "iter") or isinstance(self.parent, LEAF)
        is_whole = isinstance(self.parent, ast.Expr)
        is_numeric = self.kind is None or self.kind[0] in ("int", "number", "array")
        return is_expression and is_numeric and not (is_name or is_whole or self.is_index)

    @property
    def is_number(self) -> bool:
        """Whether it is a name, attribute or element that is a number to compute with."""
        return self.is_leaf and self.is_value and self.kind in (NUMBER, INDEX)

    @property
    def is_array(self) -> bool:
        """Whether it is a name, attribute or element that is an array to compute with."""
        return self.is_leaf and self.is_value and (self.kind or NUMBER)[0] == "array"

    @property
    def is_term(self) -> bool:
        """Whether it is a whole summand or anything else that has no factor."""
        is_part = is_product(self.parent) or is_power(self.parent)
        return self.is_value and not is_part and not isinstance(self.node, ast.UnaryOp)

    @property
    def is_whole_formula(self) -> bool:
        """Whether it is a sum that is no summand, or a product that is no factor and no summand."""
        is_formula = is_sum(self.node) or (is_product(self.node) and not is_product(self.parent))
        return is_formula and self.is_value and not is_sum(self.parent)

    def can_be(self, kind: Kind) -> bool:
        """Whether something of a kind may stand here."""
        counts = {INDEX, NUMBER}
        are_numbers = self.kind in counts and kind in counts and not self.is_index
        return self.kind == kind or are_numbers

    def is_sum_place(self, *, outer: bool) -> bool:
        """Whether a summand may be missing here: it is all of a sum.

        outer: whether it is what a statement assigns, returns or collects, or an element of that,
            also where a call makes an array of the list.
        """
        if not self.is_value or is_sum(self.parent):
            return False
        below, above = self.node, self.parent
        while isinstance(above, ast.List | ast.Tuple | ast.Call):
            is_list = isinstance(below, ast.List | ast.Tuple)
            if not is_list and is_call_for_value(above, self.tree.parent(above)):
                break
            below, above = above, self.tree.parent(above)
        return outer == isinstance(above, ast.stmt)

    def list_products(self, is_needed: Callable[[ast.AST | None], bool]) -> list[str]:
        """The products that may stand here: of the function, then those of others of its names."""
        here = (node for node in self.scope.nodes if is_needed(node))
        others = (
            node
            for node in self.tree.list_all_nodes()
            if isinstance(node, ast.BinOp)
            and self.tree.scopes[id(node)] is not self.scope
            and self.can_name(node)
        )
        nodes = (*here, *filter(is_needed, others))
        return [ast.unparse(node) for node in nodes if self.tree.kind(node) in (self.kind, None)]

    def can_name(self, node: ast.AST) -> bool:
        """Whether an expression calls nothing and is made of names that are known here too."""
        parts = [each for each in ast.walk(node) if isinstance(each, ast.Name | ast.Call)]
        return all(isinstance(n, ast.Name) and self.scope.kind(n.id) for n in parts)


def is_call_for_value(node: ast.AST, parent: ast.AST | None) -> bool:
    return isinstance(node, ast.Call) and not isinstance(parent, ast.Expr)


def is_sum(node: ast.AST | None) -> TypeGuard[ast.BinOp]:
    return isinstance(node, ast.BinOp) and isinstance(node.op, SUMS)


def is_product(node: ast.AST | None) -> TypeGuard[ast.BinOp]:
    return isinstance(node, ast.BinOp) and isinstance(node.op, PRODUCTS)


def is_matrix_product(node: ast.AST | None) -> TypeGuard[ast.BinOp]:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult)


def is_power(node: ast.AST | None) -> TypeGuard[ast.BinOp]:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)


def get_sign(operator: ast.operator) -> str:
    return SIGNS.get(type(operator).__name__, "")


def write_operand(node: ast.AST) -> str:
    """The text of an operand."""
    text = ast.unparse(node)
    return text if isinstance(node, LEAF | ast.Call | ast.Constant) else f"({text})"


def is_stored(node: ast.AST) -> TypeGuard[ast.Name]:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
