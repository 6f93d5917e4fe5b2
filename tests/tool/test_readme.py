"""What the README shows must work."""

import re
import sys
import tomllib
from pathlib import Path

from crosscheck.provenance import ROOT
from crosscheck.recordings import record
from crosscheck.trial.fmu import archive

README = Path(__file__).parents[2] / "README.md"


def test_the_example_is_tried_and_its_error_named(tmp_path, monkeypatch, crosscheck, source_search):
    text = README.read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    (tmp_path / "my_model.py").write_text(block, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "sympy", None)  # half a second, which functions do without
    (made, arguments, said) = re.findall(
        r"\$ \S*crosscheck (init .*?) +#.*\n\$ \S*crosscheck (trial .*)\n((?:.+\n)+?)```", text
    )[0]
    assert crosscheck(*made.split()).code == 0
    answer = crosscheck(*arguments.split())
    assert answer.code == 1
    out = " ".join(answer.out.split())
    shown = [" ".join(part.split()) for part in said.split("...\n")]
    assert "my_model.py:13: (m2 + m) * d2 should be m2 * d2 + m * L2" in shown[0]
    assert [part for part in shown if part not in out] == [], out


def test_it_is_short():
    prose = re.sub(r"```.*?```", "", README.read_text(encoding="utf-8"), flags=re.S)
    assert len(prose.split()) <= 450


def test_every_command_of_the_readme_exists():
    from crosscheck.cli.app import build_commands

    known = set(build_commands().commands)
    named = re.findall(r"\.venv/bin/crosscheck (\w+)", README.read_text(encoding="utf-8"))
    assert named
    assert set(named) <= known


def test_an_optional_dependency_is_installed_from_the_project_itself():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"][
        "optional-dependencies"
    ]
    for said in (record.MISSING, archive.EXTRA):
        (extra,) = re.findall(r"\.venv/bin/pip install -e '\.\[(\w+)\]'$", said)
        assert extra in extras
