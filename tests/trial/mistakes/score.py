"""What a trial tells of a planted mistake: right, misleading, silent; is the entry right?"""

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.comparison import ModelTask, Results
from crosscheck.registry import register
from crosscheck.trial.arms.model import make_registry_entry
from crosscheck.trial.arms.subject import build_problem
from crosscheck.trial.changes.arms.causes import build_probe_problems, diagnose
from crosscheck.trial.changes.arms.comparison import ask_and_compare
from crosscheck.trial.changes.arms.term_words import describe_term_error
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.loading import build_equations
from crosscheck.trial.judge.entries import EntryMismatch, format_entry
from crosscheck.trial.request import TrialRequest
from tests.trial.mistakes.equations import RIGID, written

GRAVITY, FRICTION = (0.0, -9.81), 1.7


class Mistake(NamedTuple):
    """A mistake in a right text, by its kind: old pieces, and what stands there instead.

    source: where this kind of mistake is reported or corrected, be it of another machine. entry:
    pattern of the entries of the user's that may be blamed (bias and M of the same mistake among
    them). term: pattern of what must be reported of one of them.
    """

    name: str
    source: str
    kind: str
    replaced: tuple[tuple[str, str], ...]
    entry: str
    term: str
    said: str = ""


ROWS = tomllib.loads(Path(__file__).with_name("mistakes.toml").read_text(encoding="utf-8"))
MISTAKES = [Mistake(**row) for row in ROWS["mistakes"]]
MOST = 3  # explanations of one entry, among which the right one counts


def arm_of(kind: str) -> Arm:
    """With gravity of a rigid arm, whose links' numbers are alike; friction at every joint."""
    arm = load_arm("paper-labelled" if kind in RIGID else "probe")
    joints = [j.model_copy(update={"friction_N_m_s_per_rad": FRICTION}) for j in arm.joints]
    gravity = GRAVITY if kind in RIGID else arm.gravity_m_per_s2
    return arm.model_copy(update={"joints": tuple(joints), "gravity_m_per_s2": gravity})


def supplied(kind: str, replaced: tuple[tuple[str, str], ...] = ()) -> TrialRequest:
    """Equations of a text, for its arm and others."""

    def factory(arm: Arm) -> Equations:
        return written(kind, replaced, arm)

    arm = arm_of(kind)
    equations = build_equations(factory, arm, load_scenario("pd"), kind)
    return TrialRequest(kind, equations, arm, quick=True)


def wrong_entries(asked: TrialRequest) -> list[EntryMismatch]:
    """The wrong entries with their reasons, in this process and without any check."""
    problem = build_problem(asked)
    problems = (problem, *build_probe_problems(problem))
    with register(problem.name, make_registry_entry(problem.name, problem.equations, problem.has)):
        here, *there = ask_and_compare(problems, problem.levels[-1], perform)
        return diagnose(here, there, perform).wrong_entries


def perform(tasks: Sequence[ModelTask]) -> Results:
    """Ask questions of models in this process."""
    return Results({task.key: task.perform() for task in tasks})


@dataclass(frozen=True)
class Scored:
    """A mistake and what was reported of it; texts: of each entry that is not a consequence."""

    mistake: Mistake
    entries: tuple[str, ...]
    texts: tuple[tuple[str, ...], ...]

    @property
    def entry_right(self) -> bool:
        """Whether entries are blamed, and none but those that are wrong."""
        return bool(self.entries) and all(re.match(self.mistake.entry, e) for e in self.entries)

    @property
    def verdict(self) -> str:
        """silent: nothing is reported; misleading: something is that is not so."""
        explained = [texts for texts in self.texts if texts]
        if not explained:
            return "silent"
        right = (any(re.search(self.mistake.term, t) for t in texts) for texts in explained)
        return "right" if all(right) else "misleading"


def scored(mistake: Mistake) -> Scored:
    """Of one mistake."""
    asked = supplied(mistake.kind, mistake.replaced)
    names = build_problem(asked).frame.names
    wrong = [each for each in wrong_entries(asked) if not each.notes]
    entries = tuple(format_entry(each.place, names) for each in wrong)
    return Scored(mistake, entries, tuple(map(texts_of, wrong)))


def texts_of(wrong: EntryMismatch) -> tuple[str, ...]:
    """What is reported of an entry, likeliest first."""
    found = wrong.explanation
    if found is None:
        return ()
    return tuple(
        "; and ".join(map(describe_term_error, each)) for each in (found.errors, *found.others)
    )[:MOST]
