"""What a part of a user's equations may do wrong costs its own checks alone."""

import json
import tomllib
from pathlib import Path

import pytest

from tests.tool.supplied import model_file

CHANGED = "def f(arm): return replace(two_link(arm), {})"
BAD = tomllib.loads(Path(__file__).with_name("bad_input.toml").read_text(encoding="utf-8"))


@pytest.fixture
def judged(crosscheck, tmp_path):
    """``judged(more, *options)``: exit code, JSON and what was printed of the trial of ``f``."""

    def judgement(more: str, *options: object):
        target = tmp_path / "trial.json"
        given = f"{model_file(tmp_path, more)}:f", "--quick", "--jobs", 1, "--json", target
        answer = crosscheck("trial", *given, *options)
        return answer, json.loads(target.read_text())

    return judgement


def verdicts(trial, part: str, family: str = "trial-states") -> set[str]:
    """Of the checks of a part against engines, or of another family."""
    found = [f for f in trial["agreement"]["findings"] if f["family"] == family]
    return {f["verdict"] for f in found if f["quantity"] == part and f["kind"] == "check"}


OF_ONE_ARM = """
def f():
    from crosscheck.models.loading import load_arm
    return replace(two_link(load_arm("paper-labelled")), bias=bad)
"""


@pytest.mark.parametrize("case", BAD["misbehaving"])
def test_a_part_that_fails_costs_itself_alone(judged, case):
    """Of equations of one arm, so that no probe arms take the same time again."""
    source, said = BAD["misbehaving"][case]
    answer, trial = judged(f"{source}\n{OF_ONE_ARM}")
    assert answer.code == 1
    assert answer.err == ""
    assert said in answer.out
    assert verdicts(trial, "answers-bias", "trial-own") == {"failed"}
    assert verdicts(trial, "mass_matrix") == verdicts(trial, "force") == {"agree"}
    assert trial["level"] == "links"


def test_traceback_has_the_users_lines_alone_in_every_view(judged, tmp_path):
    more = "def inner(q):\n    raise ValueError('here')\n\ndef bad(q, v): return inner(q)\n"
    answer, trial = judged(
        more + CHANGED.format("bias=bad"),
        *("--junit", tmp_path / "t.xml", "--out", tmp_path / "page"),
    )
    assert list(trial["tracebacks"]) == ["bias"]
    trace = trial["tracebacks"]["bias"]
    assert "crosscheck/trial" not in trace
    assert trace.count("  File ") == 2
    assert "in inner" in trace
    assert trace in answer.out
    page = (tmp_path / "page" / "trial.html").read_text()
    assert "ValueError: here" in page
    assert "in inner" in page
    assert "ValueError: here" in (tmp_path / "t.xml").read_text()


@pytest.mark.slow
def test_a_part_that_hangs_is_waited_for_once(judged, impatient):
    hanging = "def bad(q, v):\n    while True: time.sleep(1)\n"
    answer, trial = judged(hanging + CHANGED.format("bias=bad"))
    assert answer.code == 3
    assert "TooSlow: bias: stopped after" in answer.out
    assert "unfinished, not judged" in answer.out
    assert verdicts(trial, "mass_matrix") == {"agree"}


def test_answers_that_differ_from_call_to_call_are_named_so(judged):
    answer, _ = judged(
        "def f(arm):\n    own = two_link(arm)\n"
        "    return replace(own, mass_matrix=lambda q:"
        " np.array(own.mass_matrix(q)) * (1 + 1e-6 * random.random()))"
    )
    assert answer.code == 1
    assert "mass_matrix changes from one call to the next" in answer.out


@pytest.mark.parametrize(
    "source",
    [
        "def f(arm):\n    own = two_link(arm)\n    def M(q):\n        found = own.mass_matrix(q)\n"
        "        q[:] = 0\n        return found\n    return replace(own, mass_matrix=M)",
        "def f(arm):\n    own = two_link(arm)\n    def M(q):\n        print('x' * 10**6)\n"
        "        return own.mass_matrix(q)\n    return replace(own, mass_matrix=M)",
        "def f(arm):\n    own, kept = two_link(arm), np.zeros((2, 2))\n    def M(q):\n"
        "        kept[:] = own.mass_matrix(q)\n        return kept\n"
        "    return replace(own, mass_matrix=M)",
    ],
    ids=["changes its arguments", "prints a lot", "returns one array of its own every time"],
)
def test_habits_that_harm_nobody_are_no_slips(judged, source):
    answer, trial = judged(source)
    assert answer.code == 0
    assert "xx" not in answer.out
    assert trial["wrong"] == []
