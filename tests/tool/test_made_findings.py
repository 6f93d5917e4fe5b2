"""What a cross-check answers, on findings made by hand: one snapshot for each kind of them."""

import json
import math
from dataclasses import replace
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

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
from crosscheck.provenance import record_provenance
from crosscheck.report.answers import (
    answer_on_levels,
    answer_questions,
    compare_models,
    find_tip_ends,
    format_agreement_json,
    format_amount,
)
from crosscheck.report.finding_groups import list_findings, make_row
from crosscheck.report.formatting import (
    format_length,
    format_number,
    format_percent,
    format_rounded,
    format_unit,
    list_first,
)
from crosscheck.report.html import render_report_page
from crosscheck.report.matrix import collect_cells, common_digits, group_models
from crosscheck.report.outline import outline_arm
from crosscheck.report.terminal import print_agreement, print_answers
from crosscheck.run import CrossCheck
from tests.views.agreements import BODIES, GEARS, LEAD, PRINTED, TREE, about, print_with
from tests.views.plain import list_lines

LINKS = "pinocchio:links"
CASE = "paper-labelled/geared"


def check(
    subject: Subject, measured: float, tolerance: float, relative: float | None = None
) -> Finding:
    own = {"measured": measured, "tolerance": tolerance, "relative": relative}
    return make_check(subject, **own, basis="rounding")


def state(left: str, measured: float, case: str = CASE, right: str = GEARS) -> Finding:
    return check(about("states", case, "mass_matrix", left, right), measured, 1e-12)


def printed(measured: float) -> Finding:
    subject = about("form-states", CASE, "mass_matrix", PRINTED, GEARS)
    return make_measurement(subject, measured=measured)


def modes(measured: float) -> Finding:
    return check(about("modes", CASE, "mesh-modes", LEAD, GEARS), measured, 1e-9)


def off(level: str, size: float, case: str = "drop", quantity: str = "tip") -> Finding:
    metric = "largest distance of the tip after 0.1 s"
    if quantity == "torque":
        metric = "largest difference of the torque of hand over 20 random states"
    own = about("deviation", case, quantity, f"a:{level}", "a:geared", metric=metric)
    return make_measurement(own, measured=size, relative=size)


FINDINGS = [
    check(about("states", CASE, "mass_matrix", LEAD, GEARS), 3e-14, 1e-12, 2e-13),
    check(about("states", CASE, "bias", GEARS, LEAD), 5e-13, 1e-12, 5e-13),
    check(about("states", CASE, "mass_matrix", TREE, GEARS), 7e-14, 2e-12, 7e-14),
    check(about("same-step", "pd", "theta", LEAD, TREE), 4e-9, 2e-10, 1e-9),
    make_failed_check(about("states", CASE, "bias", LEAD, BODIES), "no answer (at state 3)"),
    make_unfinished_check(about("refined", "pd", "theta", LEAD, GEARS), "stopped"),
    check(about("momentum", "pd", "momentum", GEARS, against="its start"), 1e-9, 8e-9),
    make_measurement(
        about("form-states", CASE, "mass_matrix", PRINTED, GEARS), measured=0.0127, relative=0.0127
    ),
    make_measurement(about("deviation", "pd", "tip", LINKS, LEAD), measured=0.04),
]


LENIENT = check(about("states", CASE, "mass_matrix", LEAD, BODIES), 1e-15, 1e-10)
LEVELS_OFF = [off("links", 0.0123), off("armature", 9e-3), off("coupled", 2e-7)]
LOST = make_failed_check(about("deviation", "pd", "tip", "a:armature", LEAD), "none")
RUN = check(about("same-step", "pd", "theta", "analytic:links", LINKS), 0.0, 1e-9)
FAILED = [
    make_failed_check(about("states", CASE, f"q{number}", LEAD, TREE), note)
    for number, note in enumerate(
        [
            *("a (x) (at state 3)", "a (y) (at state 3)", "a (x) (at state 5)"),
            *("died", "raised", "died", "", ""),
        ]
    )
]
AGREEMENTS: dict[str, list[Finding]] = {
    "nothing": [],
    "of every sort": FINDINGS,
    "one check": FINDINGS[:1],
    "two checks": FINDINGS[:2],
    "a check that differs": FINDINGS[3:4],
    "printed equations that agree": [state(LEAD, 1e-15), printed(1e-14)],
    "printed within the most lenient engine": [state(LEAD, 1e-15), LENIENT, printed(0.9e-10)],
    "printed beyond it": [state(LEAD, 1e-15), LENIENT, printed(1.1e-10)],
    "printed without a number": [state(LEAD, 1e-15), printed(math.nan)],
    "a derivation that differs": [state(LEAD, 1e-3), state("analytic:links", 1e-15)],
    "another arm's states": [state(LEAD, 1e-15), state(LEAD, 1e-3, "probe/geared")],
    "modes that agree": [state(LEAD, 1e-15), modes(1e-15)],
    "modes that differ": [state(LEAD, 1e-15), modes(1e-3)],
    "failures of one reason": FAILED,
    "levels of experiments": [off("links", 0.5, "constant"), *LEVELS_OFF, LOST],
    "no teeth touch": [
        off("links", 0.0),
        off("links", 0.3, quantity="torque"),
        off("coupled", 0.0),
    ],
    "a level that is geared": [
        *(off("links", 0.2), off("coupled", 0.0), off("coupled", 0.0, quantity="torque"))
    ],
    "levels of one package": [state("analytic:links", 1e-15, right=LEAD)],
    "a run of few digits": [FINDINGS[0], replace(FINDINGS[3], verdict="agree")],
    "a level that differs elsewhere": [
        *(off("coupled", 0.0), off("coupled", 0.0, quantity="torque"), off("coupled", 0.3, "pd"))
    ],
    "a run alone": [RUN],
    "a run and states": [RUN, FINDINGS[0]],
    "a tip off by nothing": [*FINDINGS, off("links", 0.0)],
    "a tip off by 20 mm": [*FINDINGS, off("links", 0.02)],
}


def first_screen(findings: list[Finding], arm: Any) -> str:
    """The lines of the page above its drawing, and whether its verdict is red."""
    made = Agreement(findings, record_provenance(arm, 0, True))
    request = CrossCheckRequest(arm, quick=True)
    page = render_report_page(CrossCheck(request, made, {}, {}))
    is_red = '<section class="verdict no">' in page
    lines = list_lines(page).partition("\nJoint 1")[0]
    return f"{lines}\nred: {is_red}"


@pytest.mark.parametrize("name", AGREEMENTS)
def test_a_cross_check_answers(name: str, labelled, snapshot: SnapshotAssertion):
    agreement = Agreement(AGREEMENTS[name])
    answers = answer_questions(agreement, labelled)
    rows = compare_models(agreement, outline_arm(labelled))
    sizes = [f"{row.model} {row.verdict} {row.number('mass_matrix')}" for row in rows]
    levels = answer_on_levels(agreement, load_robot("puma560"))
    texts = answers.equations, answers.rigid, answers.trust, levels, *sizes
    shown = print_with(print_agreement, agreement), first_screen(AGREEMENTS[name], labelled)
    assert "\n".join(map(list_lines, (*texts, *shown))) == snapshot


@pytest.mark.parametrize("name", ["plain", "direct-between"])
def test_of_an_arm_without_gears_and_motors_nothing_is_asked_about_them(
    name: str, snapshot: SnapshotAssertion
):
    arm = make_plain_arm("plain", 2) if name == "plain" else load_arm(name)
    assert list_lines(print_with(print_answers, Agreement([]), arm)) == snapshot


@pytest.mark.parametrize("name", ["paper-labelled", "three-unlike", "puma560"])
def test_a_quick_page_says_what_it_leaves_out(name: str, snapshot: SnapshotAssertion):
    room, load = (robots, load_robot) if name == "puma560" else (arms, load_arm)
    assert room.describe_quick_limits(CrossCheckRequest(load(name), quick=True)) == snapshot


def test_the_answers_come_before_the_findings_in_json(labelled):
    agreement = Agreement([state(LEAD, 1e-15), printed(0.0127)])
    text = format_agreement_json(agreement, labelled)
    data = json.loads(text)
    assert list(data)[:2] == ["schema_version", "answers"]
    found = answer_questions(agreement, labelled)
    texts = [found.equations, found.rigid, found.trust]
    assert [data["answers"][name]["answer"] for name in ("equations", "rigid", "trust")] == texts
    assert identify_file_type(text.encode()) is AGREEMENT  # else the next run could not replace it


def test_the_tip_of_the_first_and_the_last_level_is_reported():
    assert find_tip_ends(Agreement([*LEVELS_OFF, LOST])) == [LEVELS_OFF[0], LEVELS_OFF[2]]
    assert find_tip_ends(Agreement(LEVELS_OFF[:1])) == LEVELS_OFF[:1]
    assert find_tip_ends(Agreement([])) == []


def test_what_is_only_measured_is_no_agreement_of_the_matrix():
    (cell,) = collect_cells([printed(0.0127)])
    assert (cell.verdict, cell.checks) == ("measured", 0)


def test_of_each_kind_the_tightest_check_is_listed_the_worst_verdict_first():
    listed = list_findings(FINDINGS)
    assert list(listed.verdicts) == ["failed", "differ", "unfinished", "agree", "measured"]
    rows = [(r.finding.about.key.family, r.measured, r.share) for r in listed.tightest]
    states, momentum = ("states", "5e-13", "50 %"), ("momentum", "1e-09", "12 %")
    assert rows == [("same-step", "4e-09 rad", "20 times"), states, momentum]
    assert sum({LEAD, GEARS} <= {*each.title.split()} for each in listed.groups) == 1


@pytest.mark.parametrize(
    ("measured", "shown"),
    [(0.0, "0 %"), (1.0, "100 %"), (2e6, "over a million times"), (math.inf, ""), (math.nan, "")],
)
def test_a_row_says_which_part_of_its_tolerance_was_measured(measured, shown):
    about = Subject(ComparisonKey("r", "pd", "theta", "a", "b"), "rad", "largest")
    row = make_row(make_check(about, measured=measured, tolerance=1.0, basis="x"))
    assert row.share == shown


def test_at_most_ten_tightest_kinds_are_listed():
    many = [check(about(f"kind-{n}", "pd", "x", LEAD, TREE), n, 20.0) for n in range(1, 13)]
    families = [row.finding.about.key.family for row in list_findings(many).tightest]
    assert families == [f"kind-{n}" for n in range(12, 2, -1)]


def test_groups_of_models_are_those_that_checks_connect():
    def pair(left: str, right: str) -> Finding:
        return check(about("states", CASE, "bias", left, right), 0.0, 1.0)

    names = ("ab", "cd", "ef", "gb", "fh")
    cells = collect_cells([pair(*ends) for ends in names])
    assert group_models(cells) == [["c", "d"], ["a", "b", "g"], ["e", "f", "h"]]
    joined = collect_cells([pair(*ends) for ends in (*names, "ad")])
    assert group_models(joined) == [["e", "f", "h"], ["c", "d", "a", "b", "g"]]


@pytest.mark.parametrize(
    ("measured", "quantity", "said"),
    [
        (1e-4, "bias", "0.01 %"),
        (0.0, "bias", "0"),
        (8e-5, "bias", "8e-05"),
        (0.0234, "theta", "0.023 rad"),
    ],
)
def test_a_relative_difference_is_reported_in_per_cent_unless_it_is_tiny(measured, quantity, said):
    subject = about("states", CASE, quantity, LEAD, GEARS)
    assert format_amount(make_measurement(subject, measured=measured)) == said


NAN = float("nan")


@pytest.mark.parametrize(
    ("format_one", "given"),
    [
        (format_rounded, {1234567.0: "1200000", 1e-7: "1e-07", 0.0996: "0.1", NAN: "no number"}),
        (format_percent, {0.0127: "1.3 %", 12.3: "1200 %", float("inf"): "no number"}),
        (
            format_length,
            {1.0: "1 m", 0.99: "990 mm", -2.345: "-2.35 m", 1e-5: "0.01 mm", 9.9e-6: "9.9 µm"}
            | {4.46e-13: "less than 1 nm", 1.2e-9: "0.0012 µm", 0.0: "0 µm"},
        ),
        (list_first, {"abcde": "a, b, c, d, e", "abcdef": "a, b, c, d, e and 1 more"}),
        (format_number, {1234.5: "1.23e+03", 0.0: "0", None: ""}),
        (format_unit, {"1": "", "rad s-1": "rad/s", "m s-2": "m/s²", "N m s-1 m-1": "N m/s m-1"}),
        (common_digits, {1e-16: 16.0, 0.0: 16.0, 1e-15: 15.0, 0.01: 2.0, 1.0: 0.0, 30.0: 0.0}),
    ],
    ids=lambda each: getattr(each, "__name__", None),
)
def test_a_number_is_written_as_people_read_it(format_one, given):
    assert {value: format_one(value) for value in given} == given
