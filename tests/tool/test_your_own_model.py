"""docs/your-own-model.md as a newcomer follows it: every block in order, in an empty folder."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.loops import require_items
from tests.processes import warm_command_line

pytestmark = pytest.mark.system

ROOT = Path(__file__).parents[2]
GUIDE = ROOT / "docs" / "your-own-model.md"
RED = ("differ ", "failed ", "wrong ")


class Block(NamedTuple):
    """A fenced block: its language, and its lines."""

    language: str
    lines: list[str]


class Shown(NamedTuple):
    """A command of a console block, and the lines that the page shows of its output."""

    command: str
    lines: list[str]


def blocks() -> list[Block]:
    fenced = re.findall(r"^```(\w+)\n(.*?)^```$", GUIDE.read_text(encoding="utf-8"), re.S | re.M)
    return [Block(language, text.splitlines()) for language, text in fenced]


def shown(block: Block) -> list[Shown]:
    found: list[Shown] = []
    for line in block.lines:
        if line.startswith("$ "):
            found.append(Shown(line[2:], []))
        else:
            found[-1].lines.append(line)
    return found


def run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """With the commands of this environment, and this source tree, first on the path."""
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "COLUMNS": "200",
    }
    words = shlex.split(command)
    if words[:2] in (["crosscheck", "trial"], ["crosscheck", "baseline"]):
        return warm_command_line(*words[1:], folder=folder, env=environment)
    return subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def assert_shown(output: str, lines: list[str]) -> None:
    """Every line is there, in this order; dots stand for anything."""
    left = [" ".join(line.split()) for line in output.splitlines()]
    for line in (line for line in lines if line.strip() != "..."):
        parts = (re.escape(" ".join(part.split())) for part in line.split("..."))
        pattern = re.compile(r"\s*" + ".*".join(parts) + r"\s*")
        while left and not pattern.fullmatch(left[0]):
            left.pop(0)
        assert left, f"{line!r} is not in\n{output}"
        left.pop(0)


def patched(text: str, changes: list[str]) -> str:
    """A file with runs of ``-`` lines replaced by the ``+`` lines behind them."""
    for old, new in re.findall(r"((?:^-.*\n)+)((?:^\+.*\n)+)", "\n".join(changes) + "\n", re.M):
        before, after = (re.sub(r"^[-+]", "", part, flags=re.M) for part in (old, new))
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    return text


@pytest.mark.slow
def test_the_guide_works_as_it_stands(tmp_path):
    names = {"np": None}
    assert {block.language for block in blocks()} == {"console", "diff", "python"}
    for block in require_items(blocks()):
        named = re.fullmatch(r"# (\w+\.py)", block.lines[0])
        file = tmp_path / named[1] if named else None
        if block.language == "diff":
            assert file is not None
            file.write_text(patched(file.read_text(), block.lines[1:]))
        elif block.language == "python" and file is not None:
            file.write_text("\n".join(block.lines) + "\n")
        elif block.language == "python":
            exec(compile("\n".join(block.lines), GUIDE.name, "exec"), names)
        else:
            assert block.language == "console"
            for command, lines in shown(block):
                answer = run(command, tmp_path)
                red = any(line.startswith(RED) for line in lines)
                assert answer.returncode == int(red), f"{command}\n{answer.stdout}{answer.stderr}"
                assert_shown(answer.stdout, lines)


def test_examples_and_files_that_the_guide_names_exist():
    links = re.findall(r"\]\(([^)#:]+)\)", GUIDE.read_text(encoding="utf-8"))
    assert len(links) > 10
    assert [link for link in links if not (GUIDE.parent / link).exists()] == []


def test_guide_says_plainly_what_runs_code():
    text = " ".join(GUIDE.read_text(encoding="utf-8").split())
    assert "**A trial runs your model's code**" in text
    assert "Arms, robots, scenarios, studies and baselines are data" in text
