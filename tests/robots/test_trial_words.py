"""What a robot's trial says of what it found: each line, and JSON, from a made trial."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    Subject,
    make_check,
    make_failed_check,
)
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.changes.search import list_equals
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.judge.entries import EntryMismatch, EntryPlace, LevelDistance
from crosscheck.trial.robots.consistency import describe_places
from crosscheck.trial.robots.explain import RobotDiagnosis, describe_ratio
from crosscheck.trial.robots.trial import RobotTrial
from tests.robots import two_link

ENTRIES = tuple(
    EntryMismatch(EntryPlace(part, int(name == "j2")), share, notes=("twice",) * (name == "j1"))
    for part, name, share in (
        ("bias", "j1", 0.345678),
        ("gravity", "j2", 0.25),
        *(("gravity", f"{n}", 0.01) for n in range(5)),
    )
)
DISTANCES = (
    LevelDistance("armature", 7, 0.345678, 0.1),
    LevelDistance("coupled", 8, 0.5, 0.2),
    LevelDistance("links", 0, 1.23e-15, 1e-16),
)


def finding(quantity: str, by: float, engine: str = "") -> Any:
    family = "trial-states" if engine else "trial-own"
    about = Subject(ComparisonKey(family, "tested", quantity, "yours", engine), "1", "largest")
    return make_check(about, measured=by, tolerance=1e-10, basis="")


def trial(**changes: Any) -> RobotTrial:
    plain: dict[str, Any] = {
        "name": "yours",
        "equations": Equations(),
        "robot": two_link.robot(),
        "stated": "",
        "parts": ("mass_matrix", "bias", "gravity"),
        "remarks": ("a remark",),
        "not_judged": (),
        "distances": DISTANCES,
        "diagnosis": RobotDiagnosis("armature", ENTRIES),
        "failures": {},
        "checks": Agreement([finding("bias", 0.3, "analytic")]),
        "relative_errors": {"bias": np.array([0.345678, 0.0])},
        "allowed": {"bias": 1e-10},
        "seed": 7,
    }
    return RobotTrial(**plain | changes)


OFF = "yours on tested: bias[j1] and 6 more entries are wrong, by up to 35 % of their size"
FINE = RobotDiagnosis("links")
RIGHT = "yours on tested agrees with links (links alone), to 1.2e-15"
LOST = Failure("ValueError", "of its own", "line 1\nline 2")
AGREES = Agreement([finding("bias", 0.0, "analytic")])
IN_LINK = "all of it is in link a: its mass, centre of mass and inertia together explain it"
# A trial, its headline and the causes that it names.
CASES: dict[str, tuple[RobotTrial, str, tuple[str, ...]]] = {
    "wrong": (trial(), f"{OFF}; compared with armature", ("bias[j1]: twice",)),
    "without a reason": (
        trial(diagnosis=RobotDiagnosis("armature", ENTRIES[1:2])),
        "yours on tested: gravity[j2] is wrong, by up to 25 % of its size; compared with armature",
        ("no single number, frame or place explains it",),
    ),
    "with equal explanations": (
        trial(diagnosis=RobotDiagnosis("coupled", ENTRIES, explanations=("a", "b", "c"))),
        f"{OFF}; compared with coupled",
        ("yours are the equations of coupled with a", "would also be explained by b or c"),
    ),
    "in a link": (
        trial(diagnosis=RobotDiagnosis("armature", ENTRIES, ("a note",), links=("link a",))),
        f"{OFF}; compared with armature",
        (IN_LINK, "a note"),
    ),
    "in other coordinates": (
        trial(diagnosis=RobotDiagnosis("armature", ENTRIES, readings=("these", "those"))),
        "yours on tested is right in these or in those, and not in the robot's own coordinates",
        (),
    ),
    "right": (trial(diagnosis=FINE, checks=AGREES), RIGHT, ()),
    "right at several levels": (
        trial(
            diagnosis=FINE,
            distances=(DISTANCES[2], replace(DISTANCES[2], level="coupled"), DISTANCES[0]),
            checks=AGREES,
        ),
        "yours on tested agrees with links, coupled, which are equal in these parts, to 1.2e-15",
        (),
    ),
    "by engines that differ": (
        trial(
            diagnosis=FINE,
            checks=Agreement([*AGREES.findings, finding("bias", 0.3, "exudyn")]),
        ),
        RIGHT,
        ("the engines differ on this robot: `crosscheck cost` shows where",),
    ),
    "without an answer": (
        trial(parts=(), failures={"bias": LOST}, diagnosis=FINE, checks=Agreement([])),
        "yours on tested: no part answered",
        (),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_trial_has_a_headline_and_causes(name):
    made, headline, causes = CASES[name]
    assert (made.answer.headline, made.answer.causes) == (headline, causes)
    lines = list(made.answer.lines)
    assert lines[: 1 + len(causes)] == [headline, *causes]
    assert "a remark" in lines
    assert lines[-1].endswith(("agree", "agrees"))


def test_a_check_that_no_entry_accounts_for_is_a_line():
    alone = trial(diagnosis=FINE, checks=Agreement([finding("symmetric", 0.5)]))
    (line,) = alone.answer.failures
    assert line.endswith("measured 0.5, allowed 1e-10")
    assert list(trial().answer.failures) == []
    failed = make_failed_check(finding("b", 0.0).about, "bias: it raised")
    raised = trial(checks=Agreement([failed]), failures={"bias": LOST}, not_judged=("bias",))
    lines = list(raised.answer.lines)
    assert any(line.endswith("bias: it raised") for line in lines)
    assert lines[-4:-1] == ["bias raised:", "line 1", "line 2"]
    assert "not judged: bias" in lines


def test_of_many_causes_the_terminal_has_the_first():
    causes = tuple(map(str, range(14)))
    shown = list(trial(diagnosis=RobotDiagnosis("armature", ENTRIES, causes)).answer.lines)
    assert shown[1:6] == [*"0123", "and 10 more, all in --json and on the page"]


def test_places_are_told_by_the_first_few():
    names = ["a", "b", "c"]
    assert describe_places([(2,), (0,)], names, 2) == "bias[c], bias[a]"
    assert describe_places([(2,), (0,), (1,)], names, 2) == "bias[c], bias[a], ..."


def test_an_entry_is_beside_the_right_one():
    right, rounding = np.array([1.0, -2.0, 0.5]), np.full(3, 1e-9)
    words = {
        "right is 0": (right, 0.5 * rounding),
        "missing": (0.5 * rounding, right),
        "with the opposite sign": (-right, right),
        "half as large": (right / 2, right),
        "twice as large": (2 * right, right),
        "1.2345 times as large": (1.2345 * right, right),
        "": (right + np.array([0.0, 0.1, 0.0]), right),
    }
    for said, (yours, expected) in words.items():
        assert describe_ratio(yours, expected, rounding) == said
    assert describe_ratio((1 + 5e-6) * right, right, 1e-5 + 0 * rounding) == ""
    assert list_equals(["a"]) == "a"
    assert list_equals(["a", "b"]) == "a or b"
    assert list_equals([*"abcde"]) == "a or b"
