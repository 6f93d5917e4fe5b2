"""Names and docstrings of the product's code follow the rule of CONTRIBUTING.md."""

import ast
import builtins
import re
import tomllib
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from crosscheck.provenance import ROOT
from tests.loops import require_items
from tests.tool.test_words import unclear

RULE = tomllib.loads(Path(__file__).with_name("names.toml").read_text(encoding="utf-8"))
WORDS = {key: set(text.split()) for key, text in RULE.items() if isinstance(text, str)}
NO_BEGINNING = WORDS["prepositions"] | WORDS["pronouns"] | WORDS["adverbs"]
FOLDERS = ("models", "analytic", "crosscheck", "audit")
FILES = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py"))


class FileNames(NamedTuple):
    """The names of a file: docs are its docstrings by what has them; words are counted.

    contradicted: comparisons and choices that are not what a superlative in them says; unused:
    comprehensions of which a variable is not used.
    """

    functions: list[str]
    classes: list[str]
    imported: set[str]
    docs: list[tuple[str, str]]
    words: Counter[str]
    contradicted: list[str]
    unused: list[str]


@cache
def read_names(file: Path) -> FileNames:
    """In one walk; the tree, a hundred times as large, is not kept."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    tops = [each.name for each in tree.body if isinstance(each, ast.FunctionDef)]
    found = FileNames([name for name in tops if name[0] != "_"], [], set(), [], Counter(), [], [])
    uses: Counter[str] = Counter()  # of every place where the code defines or uses a name
    for node in ast.walk(tree):
        uses.update(
            name
            for field in ("id", "arg", "attr", "name")
            if isinstance(name := getattr(node, field, None), str)
        )
        if contradicts_superlative(node):
            found.contradicted.append(f"{file.relative_to(ROOT)}: {ast.unparse(node)}")
        if isinstance(node, ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp):
            found.unused.extend(f"{file.relative_to(ROOT)}: {name}" for name in list_unused(node))
        if isinstance(node, ast.ClassDef):
            found.classes.append(node.name)
        if isinstance(node, ast.ImportFrom):
            found.imported.update(alias.asname or alias.name for alias in node.names)
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module):
            found.docs.append((getattr(node, "name", "module"), ast.get_docstring(node) or ""))
    for name, count in uses.items():
        found.words.update(dict.fromkeys(split_words(name), count))
    return found


def list_unused(node: ast.AST) -> list[str]:
    """Variables of a comprehension that it does not use: another stands where each belongs."""
    names = [each for each in ast.walk(node) if isinstance(each, ast.Name) and each.id[0] != "_"]
    used = {each.id for each in names if isinstance(each.ctx, ast.Load)}
    return [each.id for each in names if each.id not in used]


def name_number(node: ast.expr) -> str:
    """The name of a number, also of one that is multiplied; else ''."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        return name_number(node.left) or name_number(node.right)
    return getattr(node, "id", getattr(node, "attr", ""))


def rank_superlative(name: str) -> int:
    """1 of what is named as a largest number, -1 of a smallest one, 0 of all else."""
    word = next(iter(split_words(name)), "")
    return (word in WORDS["largest"]) - (word in WORDS["smallest"])


def contradicts_superlative(node: ast.AST) -> bool:
    """Whether what is called most is excluded as a bound, or chosen as the least; or vice versa."""
    if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
        chosen = {"max": 1, "min": -1}.get(getattr(node.value.func, "id", ""), 0)
        is_choice = len(node.value.args) == 1 and not isinstance(node.value.args[0], ast.Starred)
        return is_choice and rank_superlative(name_number(node.targets[0])) * chosen < 0
    if not isinstance(node, ast.Compare) or len(node.ops) > 1:
        return False
    left, right = name_number(node.left), name_number(node.comparators[0])
    by_test = {ast.GtE: 1, ast.Lt: 1, ast.LtE: -1, ast.Gt: -1}.get(type(node.ops[0]), 0)
    return any(
        rank_superlative(name) * sign * by_test > 0
        for name, sign in ((right, 1), (left, -1))
        if (name.isupper() or name.startswith("most_")) and name not in WORDS["open_bounds"]
    )


def split_words(name: str) -> list[str]:
    """Words of an identifier, in lower case."""
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name)
    return [word for word in spaced.lower().split("_") if word]


def is_participle(word: str) -> bool:
    return word in WORDS["participles"] or (
        word.endswith("ed") and word not in WORDS["nouns_in_ed"]
    )


def is_function_name(name: str) -> bool:
    """Whether a name may be a function's; a participle may qualify a noun (perturbed_start)."""
    words = split_words(name)
    if not words or words[0] in NO_BEGINNING:
        return not words
    return not is_participle(words[0]) or (
        len(words) > 1 and not is_participle(words[-1]) and words[1] not in NO_BEGINNING
    )


def test_a_verb_a_quantity_and_a_question_are_names_and_a_participle_is_none():
    names = ("load_equations", "mass_matrix", "is_rigid", "perturbed_start")
    others = ("found", "of_arm", "each_left_out", "told_apart", "beside")
    assert [name for name in (*names, *others) if is_function_name(name)] == [*names]


def test_public_functions_are_verbs_quantities_or_questions():
    names = [f"{file.stem}.{name}" for file in FILES for name in read_names(file).functions]
    assert [name for name in require_items(names) if not is_function_name(name.split(".")[1])] == []


def test_a_class_is_a_noun_with_one_definition():
    classes = (name for file in FILES for name in read_names(file).classes)
    names = Counter(name for name in classes if not name.startswith("_"))
    assert [name for name, count in require_items(names.items()) if count > 1] == []
    participles = {
        name for name in names if len(split_words(name)) == 1 and is_participle(name.lower())
    }
    assert participles == set(RULE["participle_classes"])


def test_no_vague_word_is_a_habit():
    counts = sum((read_names(file).words for file in FILES), Counter[str]())
    vague = {word: counts[word] for word in require_items(WORDS["vague"])}
    assert {word: n for word, n in vague.items() if n > RULE["most_vague"]} == {}


def test_a_module_is_named_after_what_it_defines():
    stems = [file.stem for file in FILES]
    assert [stem for stem in require_items(stems) if stem in WORDS["modules"]] == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_docstrings_have_no_private_words(folder):
    docs = [
        (file, *doc)
        for file in FILES
        if file.relative_to(ROOT).parts[0] == folder
        for doc in read_names(file).docs
    ]
    private = {
        f"{file.name}: {name}": words
        for file, name, text in require_items(docs)
        if (words := unclear(re.sub(r"``.*?``", "", text, flags=re.S)))
    }
    assert private == {}


def test_docstrings_name_exceptions_that_exist():
    known = set(vars(builtins))
    for file in FILES:
        known |= read_names(file).imported.union(read_names(file).classes)
    raised = {
        name
        for file in FILES
        for name in re.findall(r"Raises? ([A-Z]\w+)", file.read_text(encoding="utf-8"))
    }
    assert len(raised) > 10
    assert raised - known == set()


@pytest.mark.parametrize(
    "code",
    [
        *("n > MOST_ANGLES", "n <= trial.most_coordinates", "LARGEST * 2 >= n", "n >= LEAST"),
        *("largest = max(lost)", "least = max(least, 0.1)"),
    ],
)
def test_most_and_least_are_what_they_say(code):
    opposite = {"> ": ">= ", "<= ": "< ", ">= ": "> ", "max(lost)": "min(lost)"}
    (change,) = [each for each in opposite.items() if each[0] in code] or [("", "")]
    for text, is_wrong in ((code, False), (code.replace(*change), bool(change[0]))):
        statement: Any = ast.parse(text).body[0]
        node = statement if isinstance(statement, ast.Assign) else statement.value
        assert contradicts_superlative(node) == is_wrong


def test_bounds_in_superlatives_are_bounds():
    assert [each for file in FILES for each in read_names(file).contradicted] == []


def test_every_variable_of_a_comprehension_is_used():
    assert list_unused(ast.parse("[f(k, 0) for k, n in pairs]")) == ["n"]
    assert [each for file in FILES for each in read_names(file).unused] == []
