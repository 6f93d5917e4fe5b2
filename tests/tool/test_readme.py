"""What the README shows must work."""

from __future__ import annotations

import re
from pathlib import Path

README = Path(__file__).parents[2] / "README.md"


def test_the_example_is_tried_and_its_error_named(tmp_path, monkeypatch, crosscheck):
    text = README.read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    (tmp_path / "my_model.py").write_text(block, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    (arguments,) = re.findall(r"\$ crosscheck (trial .*)", text)
    answer = crosscheck(*arguments.split())
    assert answer.code == 1
    said = text[text.index(arguments) :].partition("```")[0]
    for term in ("M[theta_1, theta_2]", "m_payload L1 (L2 - d2) cos(theta_2)"):
        assert term in said
        assert term in answer.out


def test_it_is_short():
    prose = re.sub(r"```.*?```", "", README.read_text(encoding="utf-8"), flags=re.S)
    assert len(prose.split()) <= 600


def test_every_command_of_the_readme_exists():
    from crosscheck.cli.app import add_installed, app

    add_installed()
    known = {command.name or command.callback.__name__ for command in app.registered_commands}
    known |= {group.name for group in app.registered_groups}
    named = re.findall(r"\.venv/bin/crosscheck (\w+)", README.read_text(encoding="utf-8"))
    assert named
    assert set(named) <= known
