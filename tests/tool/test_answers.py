"""What a cross-check answers follows its findings, and turns with them."""

import json
from collections.abc import Sequence

import pytest

from crosscheck.cli.files.template import make_plain_arm
from crosscheck.file_types import AGREEMENT, identify_file_type
from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
    make_unfinished_check,
)
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.planning import arms, robots
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.planning.state_suite import COUNT, QUICK_COUNT
from crosscheck.registry import is_rigid_arm
from crosscheck.report.answers import (
    answer_on_equations,
    answer_on_levels,
    answer_on_rigid_arm,
    answer_on_trust,
    answer_questions,
    compare_models,
    find_tip_ends,
    format_agreement_json,
)
from crosscheck.report.finding_groups import list_findings
from crosscheck.report.formatting import format_length
from crosscheck.report.matrix import collect_cells
from crosscheck.report.outline import outline_arm
from crosscheck.report.terminal import print_answers

PRINTED, LEAD, ENGINE, LINKS = (
    "analytic:printed",
    "analytic:physical",
    "pinocchio:gears",
    "analytic:links",
)
CASE = "paper-labelled/geared"


def about(left: str, right: str, quantity: str, family: str, case: str, unit: str = "1") -> Subject:
    return Subject(ComparisonKey(family, case, quantity, left, right), unit, "largest")


def state(left: str, measured: float, case: str = CASE) -> Finding:
    subject = about(left, ENGINE, "mass_matrix", "states", case)
    return make_check(subject, measured=measured, tolerance=1e-12, basis="rounding")


def printed(measured: float) -> Finding:
    subject = about(PRINTED, ENGINE, "mass_matrix", "form-states", CASE)
    return make_measurement(subject, measured=measured)


def tip(level: str, metres: float) -> Finding:
    subject = about(f"pinocchio:{level}", LEAD, "tip", "deviation", "pd", "m")
    return make_measurement(subject, measured=metres)


def said(findings: Sequence[Finding], arm: object) -> str:
    outline = outline_arm(arm)
    return answer_on_equations(compare_models(Agreement(findings), outline), outline)


def test_printed_equations_that_differ_are_said_first_with_their_size(labelled):
    answer = said([state(LEAD, 1e-15), printed(0.0127)], labelled)
    assert answer == (
        "The paper's equations of motion as printed, Eqs. 21-22, do not agree with the engines:"
        " they differ by up to 1.3 % in mass matrix. The corrected derivation agrees with every"
        " engine at each level, to rounding."
    )


def test_printed_equations_within_what_the_derivation_is_allowed_agree(labelled):
    answer = said([state(LEAD, 1e-15), printed(1e-14)], labelled)
    assert answer.startswith("The paper's equations as printed agree with the engines.")


def test_printed_equations_are_allowed_what_the_most_lenient_of_the_engines_is(labelled):
    other = about(LEAD, "exudyn:bodies", "mass_matrix", "states", CASE)
    lenient = make_check(other, measured=1e-15, tolerance=1e-10, basis="rounding")
    for measured, agrees in ((0.9e-10, True), (1.1e-10, False)):
        answer = said([state(LEAD, 1e-15), lenient, printed(measured)], labelled)
        assert answer.startswith("The paper's equations as printed agree") is agrees


def test_a_derivation_that_differs_is_named(labelled):
    answer = said([state(LEAD, 1e-3), state(LINKS, 1e-15)], labelled)
    assert answer == f"Of the project's own derivation these do not agree: {LEAD}."


def test_a_comparison_that_failed_is_no_agreement(labelled):
    findings = [
        state(LEAD, 1e-15),
        make_failed_check(about(LEAD, "exudyn:tree", "bias", "states", CASE), ""),
    ]
    assert "do not agree" in said(findings, labelled)


def test_another_arms_states_count_for_the_verdict_and_not_for_the_sizes(labelled):
    findings = [state(LEAD, 1e-15), state(LEAD, 1e-3, "probe/geared")]
    rows = compare_models(Agreement(findings), outline_arm(labelled))
    assert [(row.model, row.verdict, row.number("mass_matrix")) for row in rows] == [
        (LEAD, "differ", "1e-15")
    ]


@pytest.mark.parametrize(("size", "agrees"), [(1e-15, True), (1e-3, False)])
def test_a_check_of_any_kind_between_the_two_turns_the_answer(size, agrees, labelled):
    modes = make_check(
        about(LEAD, ENGINE, "mesh-modes", "modes", CASE), measured=size, tolerance=1e-9, basis=""
    )
    assert ("do not agree" not in said([state(LEAD, 1e-15), modes], labelled)) is agrees


def test_rigid_levels_are_told_from_the_first_to_the_last():
    levels = [tip("links", 0.039), tip("carriers", 7e-5), tip("coupled", 1.7e-6)]
    expected = (
        "In experiment pd the rigid arm's tip is off by up to 39 mm without the joints' masses and"
        " the gears' inertia (links), by 1.7 µm without the give, play and errors of the teeth"
        " (coupled)."
    )
    assert answer_on_rigid_arm(Agreement(levels)) == expected
    assert "No rigid model" in answer_on_rigid_arm(Agreement([]))
    assert find_tip_ends(Agreement(levels)) == [levels[0], levels[2]]
    assert find_tip_ends(Agreement(levels[:1])) == levels[:1]
    assert find_tip_ends(Agreement([])) == []


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


def test_a_length_below_a_nanometre_is_rounding():
    assert format_length(4.46e-13) == "less than 1 nm"
    assert format_length(1.2e-9) == "0.0012 µm"
    assert format_length(0.0) == "0 µm"


def test_a_level_costs_most_where_a_joint_loses_the_largest_share_of_its_torque():
    found = []
    for joint, newtons, share in (("base", 5.0, 0.01), ("wrist", 0.2, 0.3), ("elbow", 1.0, 0.1)):
        key = ComparisonKey("deviation", "random-states", "torque", "analytic:links", "a:coupled")
        metric = f"largest difference of the torque of {joint} over 20 random states"
        subject = Subject(key, "N m", metric)
        found.append(make_measurement(subject, measured=newtons, relative=share))
    said = "At level links the torque of wrist is off by up to 30 % of its largest."
    assert answer_on_levels(Agreement(found)) == said


def test_of_each_kind_the_check_nearest_its_tolerance_is_listed():
    modes = about(LEAD, ENGINE, "mesh-modes", "modes", CASE)
    found = [state(LEAD, 1e-12 * share) for share in (0.2, 0.9, 0.5)]
    found.append(make_check(modes, measured=0.3, tolerance=1.0, basis=""))
    assert [row.share for row in list_findings(found).tightest] == ["90 %", "30 %"]


@pytest.mark.parametrize(("size", "count"), [(1e-15, "2 of 2"), (1e-3, "1 of 2")])
def test_what_was_checked_is_counted(size, count, labelled):
    findings = [state(LEAD, 1e-15), state(LINKS, size)]
    answer = answer_on_trust(Agreement(findings), outline_arm(labelled))
    assert answer.startswith(f"{count} checks agree")


def test_the_answers_come_before_the_findings_in_json(labelled):
    agreement = Agreement([state(LEAD, 1e-15), printed(0.0127)])
    text = format_agreement_json(agreement, labelled)
    data = json.loads(text)
    assert list(data)[:2] == ["schema_version", "answers"]
    found = answer_questions(agreement, labelled)
    texts = [found.equations, found.rigid, found.trust]
    assert [data["answers"][name]["answer"] for name in ("equations", "rigid", "trust")] == texts
    assert identify_file_type(text.encode()) is AGREEMENT  # else the next run could not replace it
    first = data["answers"]["equations"]["models"][0]
    assert (first["model"], first["verdict"]) == (PRINTED, "differ")


def test_a_quick_page_says_what_it_leaves_out(labelled):
    said = arms.describe_quick_limits(CrossCheckRequest(labelled, quick=True))
    assert "0.05 of 0.5 s of constant-torque and 0.1 of 3 s of pd" in said
    own = arms.describe_quick_limits(CrossCheckRequest(load_arm("three-unlike"), quick=True))
    assert "at most 10000 steps" in own
    assert "up to 300000" in own
    robot = robots.describe_quick_limits(CrossCheckRequest(load_robot("puma560"), quick=True))
    assert robot == (
        f"With --quick models are compared at {robots.QUICK_COUNT} random states, where a full"
        f" cross-check takes {robots.COUNT}, and free motions take at most {robots.QUICK_STEPS}"
        f" steps of {robots.MOST_STEPS}."
    )
    counts = f"compared at {QUICK_COUNT} random states where a full cross-check takes {COUNT}."
    assert counts in said


OUTCOMES = {
    "agree": state(LEAD, 1e-15),
    "differ": state(LEAD, 1e-3),
    "failed": make_failed_check(about(LEAD, ENGINE, "bias", "states", CASE), ""),
    "unfinished": make_unfinished_check(about(LEAD, ENGINE, "force", "states", CASE), ""),
    "measured": printed(0.1),
}


@pytest.mark.parametrize(
    ("verdicts", "code"),
    [
        ("agree measured", 0),
        ("agree unfinished", 3),
        ("unfinished", 3),
        ("unfinished differ", 1),
        ("failed unfinished", 1),
        ("differ", 1),
        ("measured", 1),
        ("", 1),
    ],
)
def test_the_exit_code_is_that_of_the_worst_verdict(verdicts, code):
    assert Agreement([OUTCOMES[verdict] for verdict in verdicts.split()]).exit_code == code


def test_what_is_only_measured_is_no_agreement_of_the_matrix(labelled):
    (cell,) = collect_cells([printed(0.0127)])
    assert (cell.verdict, cell.checks) == ("measured", 0)
