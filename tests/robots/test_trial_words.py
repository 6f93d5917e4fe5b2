"""What a robot's trial says of what it found: each line, and JSON, from a made trial."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from crosscheck.trial.robots.output import format_lines, format_robot_trial

from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    Subject,
    make_check,
    make_failed_check,
)
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.robots.consistency import describe_places
from crosscheck.trial.robots.explain import RobotDiagnosis, describe_ratio, list_equals
from crosscheck.trial.robots.judge import LevelDistance, RobotEntry
from crosscheck.trial.robots.trial import RobotTrial
from tests.processes import command_line
from tests.robots import two_link

ENTRIES = tuple(
    RobotEntry(part, f"{part}[{name}]", share, (0,), "twice" * (name == "j1"))
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
        "robot": two_link.robot(),
        "stated": "",
        "parts": ("mass_matrix", "bias", "gravity"),
        "remarks": ("a remark",),
        "not_judged": (),
        "distances": DISTANCES,
        "diagnosis": RobotDiagnosis("armature", ENTRIES),
        "failures": {},
        "agreement": Agreement([finding("bias", 0.3, "analytic")]),
        "relative_errors": {"bias": np.array([0.345678, 0.0])},
        "allowed": {"bias": 1e-10},
        "seed": 7,
    }
    return RobotTrial(**plain | changes)


WRONG = "wrong: bias, gravity off from armature by up to 0.35 of an entry's size"
LISTED = [
    "  bias[j1]: 0.35 of its size; twice",
    "  gravity[j2]: 0.25 of its size",
    *(f"  gravity[{n}]: 0.01 of its size" for n in range(3)),
    "  and 2 more",
]
NO_REASON = "no single number, frame or place explains it"
FINE = RobotDiagnosis("links")
LOST = Failure("ValueError", "of its own", "line 1\nline 2")

SAID: dict[str, tuple[RobotTrial, list[str]]] = {
    "wrong": (trial(), [WRONG, "a remark", *LISTED, NO_REASON]),
    "of one entry": (
        trial(
            diagnosis=RobotDiagnosis("coupled", ENTRIES[:1], explanations=("a", "b", "c")),
            not_judged=("force: it raised", "x"),
        ),
        [
            "wrong: bias off from coupled by up to 0.5 of an entry's size;"
            " not judged: force: it raised, x",
            "a remark",
            LISTED[0],
            "yours are the equations of coupled with a",
            "would also be explained by b or c",
        ],
    ),
    "with many notes": (
        trial(diagnosis=RobotDiagnosis("armature", ENTRIES[1:2], tuple(map(str, range(14))))),
        [
            "wrong: gravity off from armature by up to 0.35 of an entry's size",
            "a remark",
            LISTED[1],
            *map(str, range(12)),
            "  and 2 more sentences, all in --json",
        ],
    ),
    "in a link": (
        trial(diagnosis=RobotDiagnosis("armature", ENTRIES[:1], links=("link a",))),
        [
            "wrong: bias off from armature by up to 0.35 of an entry's size",
            "a remark",
            LISTED[0],
            "all of it is in link a: its mass, centre of mass and inertia together explain it",
        ],
    ),
    "in other coordinates": (
        trial(diagnosis=RobotDiagnosis("armature", ENTRIES[:1], readings=("these", "those"))),
        [
            "right in these: mass_matrix, bias, gravity of armature",
            "and right in those",
            "wrong in the coordinates of the robot's joints:",
            "wrong: bias off from armature by up to 0.35 of an entry's size",
            "a remark",
            LISTED[0],
        ],
    ),
    "right": (
        trial(diagnosis=FINE, agreement=Agreement([finding("bias", 0.0, "analytic")])),
        [
            "agrees with links (links alone): mass_matrix, bias, gravity, to 1.2e-15",
            "a remark",
        ],
    ),
    "right at several levels": (
        trial(
            diagnosis=FINE,
            distances=(DISTANCES[2], replace(DISTANCES[2], level="coupled"), DISTANCES[0]),
            agreement=Agreement([]),
        ),
        [
            "agrees with links, coupled, which are alike in these parts:"
            " mass_matrix, bias, gravity, to 1.2e-15",
            "a remark",
        ],
    ),
    "wrong by itself": (
        trial(diagnosis=FINE, agreement=Agreement([finding("symmetric", 0.5)])),
        [
            "agrees with links (links alone): mass_matrix, bias, gravity, to 1.2e-15",
            "a remark",
            "differ symmetric: measured 0.5, allowed 1e-10",
        ],
    ),
    "by engines that differ": (
        trial(
            diagnosis=FINE,
            agreement=Agreement([finding("bias", 0.0, "analytic"), finding("bias", 0.3, "exudyn")]),
        ),
        [
            "agrees with links (links alone): mass_matrix, bias, gravity, to 1.2e-15",
            "a remark",
            "the engines differ on this robot: `crosscheck cost` shows where",
        ],
    ),
    "without an answer": (
        trial(
            parts=(),
            not_judged=("bias: it raised",),
            failures={"bias": LOST},
            diagnosis=FINE,
            agreement=Agreement([make_failed_check(finding("b", 0.0).about, "bias: it raised")]),
        ),
        [
            "no part answered; not judged: bias: it raised",
            "a remark",
            "failed b: bias: it raised",
            "bias raised:",
            "line 1",
            "line 2",
        ],
    ),
}


def test_a_trial_shows_itself():
    """In a notebook the lines of the terminal, and a map of each part."""
    wrong = trial(diagnosis=RobotDiagnosis("armature", ENTRIES, explanations=("a < b",)))
    assert repr(wrong).splitlines() == list(format_lines(wrong))
    page = wrong._repr_html_()
    assert "a &lt; b" in page
    assert page.count("<table") == len(wrong.relative_errors)


def test_a_trial_is_annotated(tmp_path):
    wrong = trial(diagnosis=RobotDiagnosis("armature", ENTRIES, ("a note",), ("a cause",)))
    (tmp_path / "trial.json").write_text(format_robot_trial(wrong), encoding="utf-8")
    script = Path(__file__).parents[2] / "tools/annotate_trial.py"
    answer = command_line(script, tmp_path / "trial.json", "mine.py", python=())
    lines = answer.stdout.splitlines()
    assert lines[:2] == [
        "::error file=mine.py,title=Wrong entry::bias[j1]: twice",
        "::error file=mine.py,title=Wrong entry::gravity[j2]: differs",
    ]
    assert len(lines) == len(ENTRIES) + 2 + len(wrong.robot.notes)
    assert len([line for line in lines if line.endswith(("a note", "a cause"))]) == 2


@pytest.mark.parametrize("name", SAID)
def test_a_trial_says(name):
    made, said = SAID[name]
    assert list(format_lines(made)) == said


def test_json_has_all_of_a_trial():
    notes = tuple(map(str, range(14)))
    diagnosis = RobotDiagnosis("armature", ENTRIES, notes, ("a", "b"), ("link a",), ("these",))
    content = json.loads(format_robot_trial(trial(diagnosis=diagnosis)))
    expected = {
        "schema_version": 1,
        "robot": "tested",
        "equations": "yours",
        "seed": 7,
        "parts": ["mass_matrix", "bias", "gravity"],
        "remarks": ["a remark"],
        "not_judged": [],
        "agrees": False,
        "level": "armature",
        "largest_difference": 0.345678,
        "notes": list(notes),
        "explanations": [{"with": "a"}, {"with": "b"}],
        "links": ["link a"],
        "right_in": ["these"],
    }
    assert {name: content[name] for name in expected} == expected
    assert content["program"].startswith("geararm-crosscheck ")
    assert [each["level"] for each in content["levels"]] == ["armature", "coupled", "links"]
    assert content["entries"][0] == {
        "entry": "bias[j1]",
        "part": "bias",
        "difference": 0.345678,
        "told": "twice",
    }
    assert len(content["entries"]) == len(ENTRIES)
    assert [each["id"] for each in content["findings"]] == [
        "trial-states/tested/bias/yours~analytic"
    ]
    assert content.keys() == expected.keys() | {
        "program",
        "levels",
        "entries",
        "findings",
        "source_answer",
    }


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
