"""Sums of products with ``fma``, which rounds once instead of twice.

Which product of a sum is fused is decided here, by the text alone, and not by a compiler: so a text
gives the same bits everywhere.
"""

from __future__ import annotations

import ast


def fuse_products(function: ast.FunctionDef) -> ast.FunctionDef:
    """A straight-line function, a product that is added or taken away written as ``fma``.

    Of two products in a sum the right one is fused.
    """
    result: ast.FunctionDef = _ProductFuser().visit(function)
    return result


class _ProductFuser(ast.NodeTransformer):
    def visit_Subscript(self, node: ast.Subscript) -> ast.Subscript:
        return node  # whole numbers

    def visit_Name(self, node: ast.Name) -> ast.Name:
        return node  # most nodes are names and constants: no look inside, half of the time

    def visit_Constant(self, node: ast.Constant) -> ast.Constant:
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        left, right = self.visit(node.left), self.visit(node.right)
        subtracted = isinstance(node.op, ast.Sub)
        if isinstance(node.op, ast.Add | ast.Sub):
            if _is_product(right):  # a + b c, a - b c
                factor = ast.UnaryOp(ast.USub(), right.left) if subtracted else right.left
                return _fma(factor, right.right, left)
            if _is_product(left):  # a b + c, a b - c
                added = ast.UnaryOp(ast.USub(), right) if subtracted else right
                return _fma(left.left, left.right, added)
        return ast.BinOp(left, node.op, right)


def _is_product(node: ast.expr) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)


def _fma(a: ast.expr, b: ast.expr, c: ast.expr) -> ast.Call:
    return ast.Call(ast.Name("fma", ast.Load()), [a, b, c], [])
