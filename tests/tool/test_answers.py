"""What a cross-check answers follows its findings, and turns with them."""

import json
import re
from collections.abc import Sequence

import pytest

from crosscheck.cli.files.template import make_plain_arm
from crosscheck.file_types import AGREEMENT, identify_file_type
from crosscheck.findings import Agreement, Finding, make_check, make_measurement
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.planning import arms, robots
from crosscheck.planning.arms import COUNT, QUICK_COUNT
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.registry import is_rigid_arm
from crosscheck.report.answers import (
    answer_on_equations,
    answer_questions,
    compare_models,
    format_agreement_json,
)
from crosscheck.report.matrix import collect_cells
from crosscheck.report.outline import outline_arm
from crosscheck.report.terminal import print_answers
from tests.views.agreements import BODIES, GEARS, LEAD, PRINTED, about

LINKS, CASE = "analytic:links", "paper-labelled/geared"


def state(left: str, measured: float, case: str = CASE) -> Finding:
    subject = about("states", case, "mass_matrix", left, GEARS)
    return make_check(subject, measured=measured, tolerance=1e-12, basis="rounding")


def printed(measured: float) -> Finding:
    subject = about("form-states", CASE, "mass_matrix", PRINTED, GEARS)
    return make_measurement(subject, measured=measured)


def said(findings: Sequence[Finding], arm: object) -> str:
    outline = outline_arm(arm)
    return answer_on_equations(compare_models(Agreement(findings), outline), outline)


def test_printed_equations_within_what_the_derivation_is_allowed_agree(labelled):
    answer = said([state(LEAD, 1e-15), printed(1e-14)], labelled)
    assert answer.startswith("The paper's equations as printed agree with the engines.")


def test_printed_equations_are_allowed_what_the_most_lenient_of_the_engines_is(labelled):
    other = about("states", CASE, "mass_matrix", LEAD, BODIES)
    lenient = make_check(other, measured=1e-15, tolerance=1e-10, basis="rounding")
    for measured, agrees in ((0.9e-10, True), (1.1e-10, False)):
        answer = said([state(LEAD, 1e-15), lenient, printed(measured)], labelled)
        assert answer.startswith("The paper's equations as printed agree") is agrees


def test_a_derivation_that_differs_is_named(labelled):
    answer = said([state(LEAD, 1e-3), state(LINKS, 1e-15)], labelled)
    assert answer == f"Of the project's own derivation these do not agree: {LEAD}."


def test_another_arms_states_count_for_the_verdict_and_not_for_the_sizes(labelled):
    findings = [state(LEAD, 1e-15), state(LEAD, 1e-3, "probe/geared")]
    rows = compare_models(Agreement(findings), outline_arm(labelled))
    assert [(row.model, row.verdict, row.number("mass_matrix")) for row in rows] == [
        (LEAD, "differ", "1e-15")
    ]


@pytest.mark.parametrize(("size", "agrees"), [(1e-15, True), (1e-3, False)])
def test_a_check_of_any_kind_between_the_two_turns_the_answer(size, agrees, labelled):
    own = about("modes", CASE, "mesh-modes", LEAD, GEARS)
    modes = make_check(own, measured=size, tolerance=1e-9, basis="")
    assert ("do not agree" not in said([state(LEAD, 1e-15), modes], labelled)) is agrees


def test_of_an_arm_without_gears_and_motors_nothing_is_asked_about_them(capsys):
    arm = make_plain_arm("plain", 2)
    assert is_rigid_arm(arm)
    answers = answer_questions(Agreement([]), arm)
    assert answers.rigid == ""
    print_answers(Agreement([]), arm)
    asked = capsys.readouterr().out
    assert "geared" not in asked
    assert "How far" not in asked
    motored = load_arm("direct-between")
    assert "geared" in answer_questions(Agreement([]), motored).outline.questions[1]


def test_the_answers_come_before_the_findings_in_json(labelled):
    agreement = Agreement([state(LEAD, 1e-15), printed(0.0127)])
    text = format_agreement_json(agreement, labelled)
    data = json.loads(text)
    assert list(data)[:2] == ["schema_version", "answers"]
    found = answer_questions(agreement, labelled)
    texts = [found.equations, found.rigid, found.trust]
    assert [data["answers"][name]["answer"] for name in ("equations", "rigid", "trust")] == texts
    assert identify_file_type(text.encode()) is AGREEMENT  # else the next run could not replace it


def test_a_quick_page_says_what_it_leaves_out(labelled):
    said = arms.describe_quick_limits(CrossCheckRequest(labelled, quick=True))
    assert "0.05 of 0.5 s of constant-torque and 0.1 of 3 s of pd" in said
    own = arms.describe_quick_limits(CrossCheckRequest(load_arm("three-unlike"), quick=True))
    assert "at most 10000 steps" in own
    assert "up to 300000" in own
    robot = robots.describe_quick_limits(CrossCheckRequest(load_robot("puma560"), quick=True))
    limits = robots.QUICK_COUNT, robots.COUNT, robots.QUICK_STEPS, robots.MOST_STEPS
    assert re.findall(r"\d+", robot) == [str(each) for each in limits]
    assert f"{QUICK_COUNT} random states where a full cross-check takes {COUNT}." in said


def test_what_is_only_measured_is_no_agreement_of_the_matrix(labelled):
    (cell,) = collect_cells([printed(0.0127)])
    assert (cell.verdict, cell.checks) == ("measured", 0)
