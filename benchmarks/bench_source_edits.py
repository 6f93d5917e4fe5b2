"""Wrong edits of natural code: how many does a trial name the line of, and at what cost?

Run as ``python -m benchmarks.bench_source_edits [WORD] [known]`` from the project's folder: all
codes of benchmarks/source_edits, or those slips whose file or name has the word. Those that are
held out were not run while the search was made; ``known`` leaves them out.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.bench_robot_slips import LINKS
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.testing import try_equations
from crosscheck.trial.source.source_edit import SourceAnswer
from tests.robots import chains

FOLDER = Path(__file__).with_name("source_edits")
ROBOTS: dict[str, Callable[[], Robot]] = {
    "puma560": lambda: load_robot("puma560"),
    "three joints": lambda: chains.robot(LINKS),
}


class Slip(NamedTuple):
    """A wrong edit of a code: the pieces of text, and whether it was held out."""

    file: str
    mechanism: str
    name: str
    right: str
    wrong: str
    held_out: bool = False

    @property
    def text(self) -> str:
        """The code with the edit. Raises ValueError for a piece that is not in it."""
        whole = self.right_text
        if self.right not in whole:
            raise ValueError(f"{self.file}: no {self.right!r} in the text")
        return whole.replace(self.right, self.wrong, 1)

    @property
    def right_text(self) -> str:
        """The code as it is right."""
        return (FOLDER / self.file.partition(":")[0]).read_text(encoding="utf-8")

    @property
    def lines(self) -> range:
        """Numbers of the lines that are wrong."""
        rows = zip(self.text.splitlines(), self.right_text.splitlines(), strict=False)
        first = next(number for number, (a, b) in enumerate(rows, 1) if a != b)
        removed = self.right_text.count("\n") - self.text.count("\n")
        return range(first - removed, first + 1)


class Score(NamedTuple):
    """What a trial made of it: the line named, first, alone; processor time [s]; its answer."""

    is_named: bool
    is_first: bool
    is_alone: bool
    seconds: float
    answer: SourceAnswer | None


def list_slips(word: str = "") -> Iterator[Slip]:
    """All wrong edits whose file or name has a word."""
    rows = tomllib.loads((FOLDER / "slips.toml").read_text(encoding="utf-8"))
    for code in rows["code"]:
        for row in code["slips"]:
            slip = Slip(code["file"], code["mechanism"], **row)
            if word in slip.file or word in slip.name:
                yield slip


def try_slip(slip: Slip) -> Score:
    """Try a code with a wrong edit."""
    file, _, name = slip.file.partition(":")
    mechanism: Any = str(FOLDER / slip.mechanism)
    if slip.mechanism in ROBOTS:
        mechanism = ROBOTS[slip.mechanism]()
    begun = _read_seconds()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file
        path.write_text(slip.text, encoding="utf-8")
        answer = try_equations(f"{path}:{name}", mechanism).source_answer
    seconds = _read_seconds() - begun
    if answer is None or answer.wrong:
        return Score(False, False, False, seconds, answer)
    lines = [each.line for each in (*answer.edits, *answer.alternatives)]
    named = [line in slip.lines for line in lines]
    return Score(any(named), named[0], named == [True], seconds, answer)


def _read_seconds() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def main(word: str = "", half: str = "") -> None:
    """Print each slip with its answer, and the shares by code and by half."""
    scores = dict[tuple[str, bool], list[Score]]()
    for slip in list_slips(word):
        if half == "known" and slip.held_out:
            continue
        score = try_slip(slip)
        scores.setdefault((slip.file, slip.held_out), []).append(score)
        mark = "+" if score.is_first else "~" if score.is_named else "-"
        print(f"{mark} {score.seconds:5.1f} s  {slip.file}: {slip.name}", flush=True)
        if score.answer is not None:
            print(*(f"      {line}" for line in score.answer.sentences), sep="\n")
    for held in (False, True):
        rows = [(file, each) for (file, is_held), each in scores.items() if is_held == held]
        for file, each in [*rows, ("all", [score for _, row in rows for score in row])]:
            if each:
                named, first, alone = (sum(s[k] for s in each) for k in range(3))
                seconds = sum(s.seconds for s in each) / len(each)
                kind = "held out" if held else "known"
                print(
                    f"{kind}, {file}: line named {named} of {len(each)}, first {first},"
                    f" alone {alone}; {seconds:.1f} CPU s each"
                )


if __name__ == "__main__":
    main(*sys.argv[1:])
