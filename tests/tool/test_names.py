"""Names and docstrings of the product's code follow the rule of CONTRIBUTING.md."""

import ast
import builtins
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from crosscheck.provenance import ROOT
from tests.loops import require_items
from tests.tool.test_words import unclear

RULE = tomllib.loads(Path(__file__).with_name("names.toml").read_text(encoding="utf-8"))
WORDS = {key: set(text.split()) for key, text in RULE.items() if isinstance(text, str)}
NO_BEGINNING = WORDS["prepositions"] | WORDS["pronouns"] | WORDS["adverbs"]
FOLDERS = ("models", "analytic", "crosscheck", "audit")
FILES = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py"))


@cache
def parse_file(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


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


def public_functions() -> Iterator[tuple[Path, str]]:
    for file in FILES:
        for node in parse_file(file).body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                yield file, node.name


def classes() -> Iterator[tuple[Path, ast.ClassDef]]:
    for file in FILES:
        for node in ast.walk(parse_file(file)):
            if isinstance(node, ast.ClassDef):
                yield file, node


def identifiers() -> Iterator[str]:
    """Every place where the code defines or uses a name."""
    for file in FILES:
        for node in ast.walk(parse_file(file)):
            for field in ("id", "arg", "attr", "name"):
                if isinstance(name := getattr(node, field, None), str):
                    yield name


@pytest.mark.parametrize("name", ["load_equations", "mass_matrix", "is_rigid", "perturbed_start"])
def test_a_verb_a_quantity_and_a_question_are_names(name):
    assert is_function_name(name)


@pytest.mark.parametrize("name", ["found", "of_arm", "each_left_out", "told_apart", "beside"])
def test_a_participle_a_preposition_and_a_pronoun_are_none(name):
    assert not is_function_name(name)


def test_public_functions_are_verbs_quantities_or_questions():
    names = [f"{file.stem}.{name}" for file, name in public_functions()]
    assert [name for name in require_items(names) if not is_function_name(name.split(".")[1])] == []


def test_a_class_is_a_noun_with_one_definition():
    names = Counter(node.name for _, node in classes() if not node.name.startswith("_"))
    assert [name for name, count in require_items(names.items()) if count > 1] == []
    participles = {
        name for name in names if len(split_words(name)) == 1 and is_participle(name.lower())
    }
    assert participles == set(RULE["participle_classes"])


def test_no_vague_word_is_a_habit():
    counts = Counter(word for name in identifiers() for word in {*split_words(name)})
    vague = {word: counts[word] for word in require_items(WORDS["vague"])}
    assert {word: n for word, n in vague.items() if n > RULE["most_vague"]} == {}


def test_a_module_is_named_after_what_it_defines():
    stems = [file.stem for file in FILES]
    assert [stem for stem in require_items(stems) if stem in WORDS["modules"]] == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_docstrings_have_no_private_words(folder):
    nodes = [
        (file, node)
        for file in FILES
        if file.relative_to(ROOT).parts[0] == folder
        for node in ast.walk(parse_file(file))
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module)
    ]
    private = {
        f"{file.name}: {getattr(node, 'name', 'module')}": words
        for file, node in require_items(nodes)
        if (words := unclear(re.sub(r"``.*?``", "", ast.get_docstring(node) or "", flags=re.S)))
    }
    assert private == {}


def test_docstrings_name_exceptions_that_exist():
    known = {node.name for _, node in classes()} | set(vars(builtins))
    for file in FILES:
        known |= {
            alias.asname or alias.name
            for node in ast.walk(parse_file(file))
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
    raised = {
        name
        for file in FILES
        for name in re.findall(r"Raises? ([A-Z]\w+)", file.read_text(encoding="utf-8"))
    }
    assert len(raised) > 10
    assert raised - known == set()
