"""The kinds of edits of a source, each with its likelihood: what people write for what is right."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from crosscheck.trial.source.additions import (
    list_arguments,
    list_conditionals,
    list_further_cross_products,
    list_further_derivatives,
    list_further_elements,
    list_further_factors,
    list_further_functions,
    list_further_matrices,
    list_further_matrix_products,
    list_further_outer_products,
    list_further_products,
    list_further_statements,
    list_further_summands,
    list_further_wrappings,
    list_gyroscopic_products,
    list_like_statements,
    list_like_summands,
    list_reactions,
    list_unused,
    list_unused_factors,
    list_unused_levers,
)
from crosscheck.trial.source.changes import (
    Texts,
    list_assignments,
    list_bounds,
    list_comparisons,
    list_congruences,
    list_constants,
    list_counterparts,
    list_diagonals,
    list_differences,
    list_distributions,
    list_exchanges,
    list_inertia_orders,
    list_inverses,
    list_multiples,
    list_names_for_constants,
    list_near_sums,
    list_negatives,
    list_neighbours,
    list_operands,
    list_operators,
    list_opposites,
    list_orders,
    list_other_functions,
    list_other_indices,
    list_parentheses,
    list_powers,
    list_ranges,
    list_repeated_exchanges,
    list_repetitions,
    list_slices,
    list_steps,
    list_subscripts,
    list_swaps,
    list_symmetric_signs,
    list_transposes,
    list_unused_exchanges,
    list_vacant_elements,
    list_written_transposes,
    list_zeros,
)
from crosscheck.trial.source.edit import Edit
from crosscheck.trial.source.moves import list_moves
from crosscheck.trial.source.site import Site
from crosscheck.trial.source.syntax import SourceTree


class EditKind(NamedTuple):
    """A kind of edits: rank, from 1 of the likeliest, and the texts that may stand at a site.

    are_slices: whether these are slices.
    """

    rank: int
    list_texts: Callable[[Site], Texts]
    are_slices: bool = False


# What is a sign or a letter away is likelier than what needs a new expression, which also fits more
# often by chance; what makes something of one statement before what may make it of any. Of one rank
# the kinds with few texts come first, since code may be too slow for all.
KINDS = (
    EditKind(1, list_opposites),
    EditKind(1, partial(list_negatives, of_products=False, inside=True)),
    EditKind(1, partial(list_negatives, of_products=True, inside=True)),
    EditKind(1, list_unused_exchanges),
    EditKind(1, list_further_derivatives),
    EditKind(2, list_diagonals),
    EditKind(2, list_subscripts),
    EditKind(2, list_other_indices),
    EditKind(2, list_comparisons),
    EditKind(2, list_ranges),
    EditKind(2, list_counterparts),
    EditKind(2, list_other_functions),
    EditKind(2, list_operators),
    EditKind(2, list_unused),
    EditKind(2, list_arguments),
    EditKind(2, partial(list_near_sums, whole=True, written=True)),
    EditKind(2, list_congruences),
    EditKind(2, list_transposes),
    EditKind(2, partial(list_differences, near=True)),
    EditKind(2, partial(list_exchanges, near=True, written=True)),
    EditKind(2, list_operands),
    EditKind(2, list_powers),
    EditKind(2, list_constants),
    EditKind(2, list_orders),
    EditKind(2, list_parentheses),
    EditKind(2, list_multiples),
    EditKind(2, list_steps),
    EditKind(2, list_slices, are_slices=True),
    EditKind(2, list_assignments),
    EditKind(2, list_zeros),
    EditKind(2, partial(list_negatives, of_products=False, inside=False)),
    EditKind(2, partial(list_negatives, of_products=True, inside=False)),
    EditKind(3, list_written_transposes),
    EditKind(3, list_unused_levers),
    EditKind(3, list_unused_factors),
    EditKind(3, partial(list_near_sums, whole=False, written=True)),
    EditKind(3, partial(list_exchanges, near=True, written=False)),
    EditKind(3, partial(list_exchanges, near=False, written=True)),
    EditKind(3, partial(list_like_summands, inner=True)),
    EditKind(3, partial(list_like_summands, inner=False)),
    EditKind(3, partial(list_near_sums, whole=False, written=False)),
    EditKind(3, partial(list_differences, near=False)),
    EditKind(3, list_neighbours),
    EditKind(3, list_repeated_exchanges),
    EditKind(3, list_swaps),
    EditKind(3, list_symmetric_signs),
    EditKind(3, list_distributions),
    EditKind(3, list_inverses),
    EditKind(3, list_vacant_elements),
    EditKind(3, list_inertia_orders),
    EditKind(3, list_repetitions),
    EditKind(3, list_further_elements),
    EditKind(4, list_bounds),
    EditKind(4, list_further_matrices),
    EditKind(4, partial(list_exchanges, near=False, written=False)),
    EditKind(4, list_names_for_constants),
    EditKind(4, partial(list_further_statements, adding=False)),
    EditKind(4, partial(list_further_factors, written=True)),
    EditKind(4, list_further_functions),
    EditKind(4, list_further_wrappings),
    EditKind(5, list_further_matrix_products),
    EditKind(5, list_further_outer_products),
    EditKind(5, list_gyroscopic_products),
    EditKind(5, partial(list_further_cross_products, of_products=True)),
    EditKind(5, list_reactions),
    EditKind(5, partial(list_further_summands, outer=True)),
    EditKind(5, partial(list_further_summands, outer=True, written=False)),
    EditKind(5, partial(list_further_statements, adding=True)),
    EditKind(5, partial(list_further_products, sign="+")),
    EditKind(6, list_conditionals),
    EditKind(6, partial(list_further_factors, written=False)),
    EditKind(6, partial(list_further_products, sign="-")),
    EditKind(6, partial(list_further_summands, outer=False)),
    EditKind(6, partial(list_further_cross_products, of_products=False)),
    EditKind(6, list_like_statements),
)
ADDING_RANK = 5  # least rank of edits that add a summand or a statement
RANKS = sorted({kind.rank for kind in KINDS})
MOVE_RANK = 2  # rank of moves of a statement, of which there are few


def list_edits(tree: SourceTree, rank: int, is_sought: Callable[[ast.AST], bool]) -> Iterator[Edit]:
    """The edits of a rank of the nodes that ran and are sought, the likelier kinds first."""
    nodes = (each for each in tree.list_nodes() if isinstance(each, ast.expr | ast.stmt))
    sites = [(Site(tree, node), node) for node in nodes if is_sought(node)]
    for place, kind in enumerate(KINDS):
        if kind.rank == rank:
            for site, node in sites:
                likelihood = rank, place + site.is_datum * len(KINDS)
                for text in kind.list_texts(site):
                    yield Edit(likelihood, node, text, is_slice=kind.are_slices)
    if rank == MOVE_RANK:
        yield from (each for each in list_moves(tree, (rank, len(KINDS))) if is_sought(each.node))
