"""Docs, pages and help use the field's words: none that only this project would understand."""

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from crosscheck.cli.app import build_commands
from crosscheck.provenance import ROOT
from tests.loops import require_items

BANNED = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
MOST_WORDS = 30  # in a sentence of a message or page
TEMPLATES = ROOT / "crosscheck" / "report" / "templates"
TEXTS = [
    path
    for path in (
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "CHANGELOG.md",
        *sorted((ROOT / "docs").rglob("*.md")),
        *sorted(TEMPLATES.glob("*.j2")),
        *sorted((ROOT / "audit" / "templates").rglob("*.j2")),
    )
    if "generated" not in path.parts
]


def unclear(text: str) -> list[str]:
    """Each banned word in a text, as it stands there."""
    words = "|".join(BANNED)
    return re.findall(rf"(?<![\w.\-])(?:{words})(?![\w\-])", text, flags=re.I)


def read(path: Path) -> str:
    """Words for readers: no code, no expressions of templates."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".j2":
        return re.sub(r"{[%{].*?[%}]}|<style.*?</style>|<[^>]*>", " ", text, flags=re.S)
    return re.sub(r"```.*?```|`[^`\n]*`", " ", text, flags=re.S)


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
def test_a_page_has_no_private_words(path):
    assert unclear(read(path)) == []


def helps(command: Any, name: str) -> dict[str, str]:
    """Of every command and option below."""
    found = {name: str(command.help or "")}
    for each in command.params:
        found[f"{name} {each.name}"] = str(getattr(each, "help", "") or "")
    for own, below in getattr(command, "commands", {}).items():
        found |= helps(below, f"{name} {own}")
    return found


def test_help_has_no_private_words():
    texts = helps(build_commands(), "crosscheck")
    assert {name: unclear(text) for name, text in texts.items() if unclear(text)} == {}


def list_texts(path: Path) -> Iterator[str]:
    """A module's literals but for docstrings, or a template's words; X for what they insert."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".j2":
        text = re.sub(r'{{ "\."[^}]*}}', ".", " ".join(text.split()))
        text = re.sub(r"<style.*?</style>|<script.*?</script>", "", text)
        text = re.sub(r"{% (?:block|endblock).*?%}|</?(?:p|[dt][dhrt]|li|h\d)\b[^>]*>", "\n", text)
        yield re.sub(r"{%.*?%}|<(?!code).*?>", "", re.sub(r"{{.*?}}", "X", text))
        return
    nodes = list(ast.walk(ast.parse(text)))
    bare = {id(each.value) for each in nodes if isinstance(each, ast.Expr)}
    whole = [each for each in nodes if isinstance(each, ast.JoinedStr)]
    bare |= {id(part) for each in whole for part in ast.walk(each)}
    for each in whole:
        parts = (part.value if isinstance(part, ast.Constant) else "X" for part in each.values)
        yield "".join(map(str, parts))
    constants = (each for each in nodes if isinstance(each, ast.Constant) and id(each) not in bare)
    yield from (each.value for each in constants if isinstance(each.value, str))


@pytest.mark.parametrize("folder", ["crosscheck", "models", "analytic", "audit"])
def test_a_sentence_has_at_most_thirty_words(folder):
    paths = [path for end in ("py", "html.j2") for path in (ROOT / folder).rglob(f"*.{end}")]
    texts = "\n".join(text for path in require_items(paths) for text in list_texts(path))
    sentences = re.split(r"\n|(?<=[.!?])\s+(?=[A-Z<✓])", texts)
    assert [each for each in sentences if len(each.split()) > MOST_WORDS] == []


def test_a_banned_word_is_seen():
    assert unclear("A slip, told apart; the Red one. `slip`ped, inred, colour-red") != []
    assert unclear("replay, display, slippery, hundred, reduction, play-back") == []
