"""README, tutorials and how-tos as a reader follows them: every block in order, in an empty folder.

A block of ``console`` shows commands and what they print, one of ``sh`` commands alone. Both are
run, but for what ``.ci/run`` runs anyway and what ``NOT_RUN`` names with its reason.
"""

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
DOCS = ROOT / "docs"
GUIDE = DOCS / "your-own-model.md"
FMU = DOCS / "how-to" / "fmu-and-c.md"
PAGES = [
    ROOT / "README.md",
    GUIDE,
    DOCS / "reference" / "equations.md",
    *sorted((DOCS / "tutorials").glob("*.md")),
    *sorted((DOCS / "how-to").glob("*.md")),
]
RED = re.compile(r"differ |failed |.* (?:is|are) wrong, by up to ")
NOT_RUN = {
    r"python3 -m venv|\.venv/bin/python -m pip": "installs from a network",
    r"make run": "a line of .ci/run",
    r"crosscheck run": "make run",
    r".*\bbag/|.*record\.toml": "the reader's own recording; tests/measured makes one",
    r".*answers\.mat": "answered by Octave: make octave",
    r".*six-joint": "a model of the page's reader; tests/trial has it",
    r"crosscheck trial my_model.py:pendulum my-arm.toml --quick$": "tests/tool/test_readme.py",
    r"crosscheck baseline (accept|check) paper-labelled": "writes the project's own",
    r"crosscheck simulate .* --t-end 0.5": "15 s; .ci/run has it shorter",
    r"crosscheck view run.nc": "needs the line before",
    r"crosscheck validate paper-labelled --quick --set": "a minute; .ci/run has it with --scenario",
    r"crosscheck (sweep|plot) \S*bistable": "a line of .ci/run, in another folder",
    r"crosscheck cost puma560$": "40 s; .ci/run has it with --quick",
}
EXIT_CODES = {"compare examples/recordings/payload.csv paper-labelled": 1}  # the payload is wrong


class Block(NamedTuple):
    """A fenced block: its language, and its lines."""

    language: str
    lines: list[str]


class Shown(NamedTuple):
    """A command of a console block, and the lines that the page shows of its output."""

    command: str
    lines: list[str]


def blocks(page: Path) -> list[Block]:
    fenced = re.findall(r"^```(\w+)\n(.*?)^```$", page.read_text(encoding="utf-8"), re.S | re.M)
    return [Block(language, text.splitlines()) for language, text in fenced]


def shown(block: Block) -> list[Shown]:
    found: list[Shown] = []
    for line in block.lines:
        if line.startswith("$ ") or block.language == "sh":
            command = re.sub(r"\s+#.*", "", line.removeprefix("$ "))
            found.append(Shown(command.replace(".venv/bin/crosscheck", "crosscheck"), []))
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


def is_run(command: str) -> bool:
    """Whether here: not what is named above, nor what .ci/run has as it stands."""
    lines = (ROOT / ".ci" / "run").read_text(encoding="utf-8").replace(".venv/bin/", "")
    in_ci = any(line.startswith(command) for line in lines.splitlines())
    return not in_ci and not any(re.match(pattern, command) for pattern in NOT_RUN)


def follow(page: Path, folder: Path) -> list[str]:
    """Do all that a page shows, in a folder; the commands that were run."""
    names, done = {"np": None}, []
    for block in blocks(page):
        named = re.fullmatch(r"# (\S+\.(?:py|toml))\b.*", block.lines[0])
        file = folder / named[1] if named else None
        if block.language == "diff":
            assert file is not None
            file.write_text(patched(file.read_text(), block.lines[1:]))
        elif block.language == "python" and file is not None:
            file.write_text("\n".join(block.lines) + "\n")
        elif block.language == "python" and page.parent.name != "how-to":
            exec(compile("\n".join(block.lines), page.name, "exec"), names)
        elif block.language in ("console", "sh"):
            for command, lines in shown(block):
                if not is_run(command):
                    continue
                answer = run(command, folder)
                known = (code for part, code in EXIT_CODES.items() if part in command)
                wanted = next(known, int(any(RED.match(line) for line in lines)))
                assert answer.returncode == wanted, f"{command}\n{answer.stdout}{answer.stderr}"
                assert_shown(answer.stdout, lines)
                done.append(command)
    return done


@pytest.fixture(name="folder")
def prepare_folder(tmp_path: Path) -> Path:
    """Where a reader of a how-to is: with the examples, and the tutorial's model put right."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    given, fixes, *_ = (b.lines for b in blocks(GUIDE) if b.language in ("python", "diff"))
    (tmp_path / "my_model.py").write_text(patched("\n".join(given) + "\n", fixes[1:]))
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_works_as_it_stands(page, folder):
    if page.parent.name in ("how-to", "reference"):
        assert run("crosscheck init my-arm.toml", folder).returncode == 0
    done = follow(page, folder)
    assert len(done) >= {GUIDE: 8, FMU: 4}.get(page, 0)


def test_no_fence_is_without_a_language():
    for page in require_items(PAGES):
        fences = re.findall(r"^```(.*)$", page.read_text(encoding="utf-8"), re.M)
        assert all(fences[::2]), page


def test_what_is_not_run_is_on_a_page():
    commands = [
        command
        for page in PAGES
        for block in blocks(page)
        if block.language in ("console", "sh")
        for command, _ in shown(block)
    ]
    for pattern in require_items(NOT_RUN):
        assert any(re.match(pattern, command) for command in commands), pattern


def test_guide_says_plainly_what_runs_code():
    text = " ".join(GUIDE.read_text(encoding="utf-8").split())
    assert "**A trial runs your model's code**" in text
    assert "Arms, robots, scenarios, studies and baselines are data" in text
