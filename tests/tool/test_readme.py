"""What the README shows must work."""

from __future__ import annotations

import re
from pathlib import Path

README = Path(__file__).parents[2] / "README.md"


def test_python_example_runs(capsys):
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.S)
    assert len(blocks) == 1
    exec(compile(blocks[0], "README.md", "exec"), {})
    assert capsys.readouterr().out.strip()


def test_every_command_of_the_readme_exists():
    from crosscheck.cli.app import add_installed, app

    add_installed()
    known = {command.name or command.callback.__name__ for command in app.registered_commands}
    known |= {group.name for group in app.registered_groups}
    named = re.findall(r"\.venv/bin/crosscheck (\w+)", README.read_text(encoding="utf-8"))
    assert named
    assert set(named) <= known
