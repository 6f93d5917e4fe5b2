"""An edit of a user's source as a record, and the sentence on it."""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from crosscheck.trial.source.edit import Edit
from crosscheck.trial.source.site import get_sign, is_sum
from crosscheck.trial.source.style import imitate
from crosscheck.trial.source.syntax import SourceTree

MOST_NAMED = 2  # entries of a list in a sentence
# Characters of a formula that is not shown whole where little space is, and in sentences.
LONG, VERY_LONG = 20, 40


@dataclass(frozen=True)
class SourceEdit:
    """A change of one expression or statement of a user's source that mends entries.

    Args:
        file: Name of the file.
        line: Number of the line at which the expression begins.
        old: Text of the expression or statement, as it stands there.
        new: Text that should stand there, '' for none; or what should follow it.
        start: Text of the lines before the change.
        removed: Text that the change removes, '' where it adds alone.
        added: Text in its place.
        end: Text of the lines behind it.
        entries: The wrong entries that it mends, in words.
        rank: Likelihood of edits of this kind: 1 of the likeliest.
        move: Where the old text should stand, '' where it should be another.
        is_stated: Whether the new text has the mechanism's numbers where the old one has others.
    """

    file: str
    line: int
    old: str
    new: str
    start: str
    removed: str
    added: str
    end: str
    entries: tuple[str, ...]
    rank: int
    move: str = ""
    is_stated: bool = False

    @property
    def place(self) -> str:
        """File and line, as editors and compilers write them."""
        return f"{self.file}:{self.line}"

    @property
    def remedy(self) -> str:
        """The edit, in words, without the ends that very long old and new text share."""
        return self._shorten(VERY_LONG).whole_remedy

    @property
    def short_remedy(self) -> str:
        """The same, also of text that is less long."""
        return self._shorten(LONG).whole_remedy

    @property
    def whole_remedy(self) -> str:
        """The edit, in words."""
        if self.move:
            return f"{self.old} should stand {self.move}"
        if not self.new:
            return f"{self.old} should be left out"
        if not self.removed:
            return f"{self.new} should follow {self.old}"
        if not self.is_stated:
            return f"{self.old} should be {self.new}"
        of_file = f"the file's {self.added} should be {self.removed}"
        of_file = "the file's numbers are wrong" if "[" in self.old else of_file
        return f"{self.old} should be {self.new}, as in the file, or {of_file}"

    def _shorten(self, least: int) -> SourceEdit:
        """The edit without the ends that old and new text share, where both are so long."""
        texts = self.old, self.new
        if self.move or not self.removed or min(map(len, texts)) < least:
            return self
        spans = [list(re.finditer(r"[\w.]+|\*\*|\S", text)) for text in texts]
        words = [[span[0] for span in each] for each in spans]
        first = _count_equal(*words)
        last = _count_equal(*(each[first:][::-1] for each in words))
        middle = [each[first : len(each) - last] for each in spans]
        old, new = (
            text[each[0].start() : each[-1].end()] if each else ""
            for text, each in zip(texts, middle, strict=True)
        )
        is_ambiguous = f"{self.start}{self.removed}{self.end}".count(old) != 1
        if not old or is_ambiguous or not (_is_balanced(old) and _is_balanced(new)):
            return self
        return replace(self, old=old, new=new)


@dataclass(frozen=True)
class SourceAnswer:
    """A change of a user's source that corrects it.

    Args:
        edits: The changes, of which several are made together, in the order of the file.
        alternatives: Other single changes that do the same.
        wrong: Entries that stay wrong, in words; none of a whole answer.
        level: The rigid level that all agrees with, where it is not the one that the trial names.
        is_unequal: Whether it was judged on a mechanism of unequal numbers too.
    """

    edits: tuple[SourceEdit, ...]
    alternatives: tuple[SourceEdit, ...] = ()
    wrong: tuple[str, ...] = ()
    level: str = ""
    is_unequal: bool = True

    @property
    def is_whole(self) -> bool:
        """Whether nothing stays wrong at the level that the trial names."""
        return not (self.wrong or self.level)

    @property
    def sentences(self) -> Iterator[str]:
        """The change, what then agrees and with what numbers, and alternatives."""
        changes = ", and ".join(f"{each.place}: {each.remedy}" for each in self.edits)
        entries = [name for each in self.edits for name in each.entries]
        agree = f"{_list_names(entries)} {'agrees' if len(entries) == 1 else 'agree'}"
        if self.wrong:
            stays = "stays" if len(self.wrong) == 1 else "stay"
            agree += f", while {_list_names(self.wrong)} {stays} wrong"
        else:
            agree = f"all parts agree{f' with {self.level}' * bool(self.level)}"
        yield f"{changes}; then{', with these numbers,' * (not self.is_unequal)} {agree}"
        if self.alternatives:
            listed = "; or ".join(f"{each.place}, {each.remedy}" for each in self.alternatives)
            yield f"the same by another edit: {listed}"


@dataclass(frozen=True)
class SourceSearch:
    """The search of a user's source for the change that corrects it.

    Args:
        answer: The change; None without one.
        place: The file and the lines where it was looked for; '' where nothing was, or in vain for
            a reason that is known.
        has_pairs: Whether two changes together were tried too.
        is_late: Whether its time ended before all was tried.
    """

    answer: SourceAnswer | None = None
    place: str = ""
    has_pairs: bool = False
    is_late: bool = False

    @property
    def sentences(self) -> Iterator[str]:
        """The answer, or that there is none."""
        if self.answer is not None:
            yield from self.answer.sentences
        elif self.place:
            changes = f"no single change{' nor pair of changes' * self.has_pairs}"
            late = "; time ran out before all were tried" * self.is_late
            yield f"{self.place}: {changes} that was tried makes all parts right{late}"


def _count_equal(old: Sequence[str], new: Sequence[str]) -> int:
    """The number of equal words at the beginning of two lists."""
    differing = (n for n, (a, b) in enumerate(zip(old, new, strict=False)) if a != b)
    return next(differing, min(len(old), len(new)))


def _narrow(start: str, removed: str, added: str, end: str) -> tuple[str, str, str, str]:
    """A change of long text without the ends that stay, cut at blanks."""
    if min(len(removed), len(added)) < VERY_LONG:
        return start, removed, added, end
    first = removed.rfind(" ", 0, _count_equal(removed, added)) + 1
    equal = _count_equal(removed[first:][::-1], added[first:][::-1])
    last = removed[::-1].rfind(" ", 0, equal) + 1
    old, new = (text[first : len(text) - last] for text in (removed, added))
    return start + removed[:first], old, new, removed[len(removed) - last :] + end


def _is_balanced(text: str) -> bool:
    """Whether every bracket of a text is closed in it."""
    while (inner := re.sub(r"\(\)|\[\]|\{\}", "", re.sub(r"[^][(){}]", "", text))) != text:
        text = inner
    return not text


def _list_names(names: Sequence[str]) -> str:
    rest = len(names) - MOST_NAMED
    return ", ".join(names[:MOST_NAMED]) + (f" and {rest} more" if rest > 0 else "")


def describe_edit(tree: SourceTree, edit: Edit, entries: tuple[str, ...]) -> SourceEdit:
    """The record of an edit that mends these entries."""
    node, other, lines = edit.node, edit.parse(), tree.code.text.splitlines()
    file = tree.code.name
    line, last = node.lineno, node.end_lineno or node.lineno
    before = "\n".join(lines[line - 1 : last])
    if edit.further or isinstance(node, ast.For | ast.While):
        return _describe_move(lines, edit, file, entries)
    if isinstance(node, ast.stmt) and not isinstance(other, ast.Assign | ast.AugAssign):
        old, pieces = before.strip(), ("", before, "", "")
        new = ast.unparse(other.body[1]) if isinstance(other, ast.If) else ""
        if new:
            indent = before[: len(before) - len(before.lstrip())]
            pieces = f"{before}\n", "", f"{indent}{new}", ""
        return SourceEdit(file, line, old, new, *pieces, entries, edit.rank)
    if (opposite := _describe_opposite(tree, edit, file, entries)) is not None:
        return opposite
    start = lines[line - 1].encode()[: node.col_offset].decode()
    end = lines[last - 1].encode()[node.end_col_offset :].decode()
    around, old, outer = tree.parent(node), _read_text(tree, node), node
    removed = ast.get_source_segment(tree.code.text, node) or ""
    new = imitate(ast.unparse(other), before)
    if isinstance(other, ast.Tuple) and not removed.startswith("("):
        new = new[1:-1]
    if "#" not in removed:  # what stays of the expression stays as it is written
        new = new.replace(imitate(ast.unparse(node), before), old, 1)
    # Python says where parentheses are needed; those that are there already stay.
    is_bare = not (start.rstrip().endswith("(") and end.lstrip().startswith(")"))
    needs_parentheses = isinstance(around, ast.expr) and _needs_parentheses(tree, edit, around)
    added = f"({new})" if is_bare and needs_parentheses else new
    pieces, shown = _narrow(start, removed, added, end), added
    # A part of an element says more with all of it; of several that are equal nobody knows which.
    while isinstance(around, ast.Subscript) or (
        before.count(old) > 1 and isinstance(around, ast.expr)
    ):
        if isinstance(around, ast.Dict) and outer in around.values:
            key = ast.unparse(around.keys[around.values.index(outer)] or outer)
            texts = f"{key}: {old}", f"{key}: {shown}"
            return SourceEdit(file, outer.lineno, *texts, *pieces, entries, edit.rank)
        old, shown = _read_text(tree, around), _replace_text(tree, around, outer, shown)
        outer, around = around, tree.parent(around)
    further = added.removeprefix(f"{old} ")
    if outer is not node:
        new = shown
    elif further != added and further[0] in "+-" and len(further) < len(old):
        new, pieces = further, (f"{start}{removed}", "", f" {further}", end)
    return SourceEdit(file, outer.lineno, old, new, *pieces, entries, edit.rank)


def _describe_opposite(
    tree: SourceTree, edit: Edit, file: str, entries: tuple[str, ...]
) -> SourceEdit | None:
    """The record of a summand's other sign in a long formula; None of all else."""
    node, other = edit.node, edit.parse()
    if not is_sum(node) or not is_sum(other) or ast.dump(node.right) != ast.dump(other.right):
        return None
    summand, line = _read_text(tree, node.right), node.right.lineno
    text = tree.code.text.splitlines()[line - 1]
    start = text.encode()[: node.right.col_offset].decode().rstrip()
    old, new = (f"{get_sign(each.op)} {summand}" for each in (node, other))
    is_long = len(_read_text(tree, node.left)) >= LONG
    is_sign_alone = ast.dump(node.left) == ast.dump(other.left) and start.endswith(old[0])
    if not (is_long and is_sign_alone and text.count(summand) == 1):
        return None
    pieces = start[:-1], old[0], new[0], text[len(start) :]
    return SourceEdit(file, line, old, new, *pieces, entries, edit.rank)


def _describe_move(lines: list[str], edit: Edit, file: str, entries: tuple[str, ...]) -> SourceEdit:
    """The record of an edit that moves a statement."""

    def read(node: ast.stmt) -> str:
        return "\n".join(lines[node.lineno - 1 : node.end_lineno])

    def shift(text: str, columns: int) -> str:
        bare = textwrap.dedent(text)
        return textwrap.indent(bare, " " * (len(text) - len(text.lstrip()) + columns))

    node = edit.node
    assert isinstance(node, ast.stmt)
    if not isinstance(node, ast.For | ast.While):
        assert edit.further is not None  # as it is of statements that change places
        last, line = edit.further[0], node.lineno
        passed = "\n".join(lines[line - 1 : last.lineno - 1])
        removed, moved = f"{passed}\n{read(last)}", last
        where, added = f"before {read(node).strip()}", f"{read(last)}\n{passed}"
        if edit.text == "pass":
            passed = "\n".join(lines[node.end_lineno or line : last.end_lineno])
            where, added = f"after {read(last).strip()}", f"{passed}\n{read(node)}"
            moved = node
    else:
        moved = edit.further[0] if edit.further else node.body[-1]
        where = f"{'in' if edit.further else 'after'} the loop of line {node.lineno}"
        depth = node.body[0].col_offset - node.col_offset
        removed, line = read(moved), moved.lineno
        added = shift(removed, depth if edit.further else -depth)
    text = " ".join(read(moved).split())
    return SourceEdit(file, line, text, text, "", removed, added, "", entries, edit.rank, where)


def _needs_parentheses(tree: SourceTree, edit: Edit, around: ast.expr) -> bool:
    """Whether the text of an edit needs parentheses in the expression around it."""
    other = edit.parse()
    tree.put(edit.node, other)
    text = ast.unparse(around)
    tree.put(edit.node, edit.node)
    return f"({ast.unparse(other)})" in text


def _replace_text(tree: SourceTree, around: ast.AST, node: ast.AST, new: str) -> str:
    """The text of an expression as it stands in the source, with other text for a part of it."""
    lines = [line.encode() for line in tree.code.text.splitlines(keepends=True)]

    def find_span(part: Any) -> tuple[int, int]:
        ends = (part.lineno, part.col_offset), (part.end_lineno, part.end_col_offset)
        first, last = (sum(map(len, lines[: line - 1])) + column for line, column in ends)
        return first, last

    (first, last), (begin, end), text = find_span(around), find_span(node), b"".join(lines)
    return " ".join((text[first:begin] + new.encode() + text[end:last]).decode().split())


def _read_text(tree: SourceTree, node: ast.AST) -> str:
    """The text of a node as it stands in the source, on one line."""
    return " ".join((ast.get_source_segment(tree.code.text, node) or "").split())
