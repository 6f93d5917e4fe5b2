"""Every list and table of a report, on findings made by hand whose numbers are all unlike."""

import html
import json
import math
import re
from typing import Any

import pytest

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
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import record_provenance
from crosscheck.registry import LEVELS
from crosscheck.report.answers import (
    answer_on_equations,
    answer_on_levels,
    answer_on_rigid_arm,
    compare_models,
    describe_verdict,
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
)
from crosscheck.report.html import render_report_page
from crosscheck.report.matrix import collect_cells, common_digits, group_models
from crosscheck.report.outline import outline_arm
from crosscheck.report.plots.charts import Pictures
from crosscheck.report.terminal import print_agreement
from crosscheck.run import CrossCheck
from tests.views.agreements import BODIES, GEARS, LEAD, PRINTED, TREE, about

LINKS = "pinocchio:links"
CASE = "paper-labelled/geared"


def check(
    subject: Subject, measured: float, tolerance: float, relative: float | None = None
) -> Finding:
    own = {"measured": measured, "tolerance": tolerance, "relative": relative}
    return make_check(subject, **own, basis="rounding")


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


def test_of_each_kind_the_tightest_check_is_listed_the_worst_verdict_first():
    listed = list_findings(FINDINGS)
    assert list(listed.verdicts) == ["failed", "differ", "unfinished", "agree", "measured"]
    rows = [(r.finding.about.key.family, r.measured, r.share) for r in listed.tightest]
    states, momentum = ("states", "5e-13", "50 %"), ("momentum", "1e-09", "12 %")
    assert rows == [("same-step", "4e-09 rad", "20 times"), states, momentum]


@pytest.mark.parametrize(
    ("measured", "shown"),
    [(0.0, format_percent(0.0)), (0.25, "25 %"), (1.0, "100 %"), (math.inf, ""), (math.nan, "")],
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


def page_of(findings: list[Finding], arm: Any) -> str:
    """The text of the page, and its markup."""
    made = Agreement(findings, record_provenance(arm, 0, True))
    request = CrossCheckRequest(arm, quick=True)
    return render_report_page(CrossCheck(request, made, {}, {}), Pictures({}))


def test_the_pages_first_screen_answers_topic_by_topic(labelled):
    told = json.loads(format_agreement_json(Agreement(FINDINGS), labelled))["answers"]
    said = html.unescape(page_of(FINDINGS, labelled))
    assert "<h1>Preliminary cross-check of paper-labelled</h1>" in said
    assert said.count('<section class="verdict no">') == 1
    cards = re.findall(r"<article( class=.no.)?>.*?<details><summary>why(.*?)<a", said, re.S)
    shown = [(bool(red), re.sub("<[^>]+>", " ", text).strip()) for red, text in cards]
    answers = [told[name]["answer"] for name in ("equations", "rigid", "trust")]
    assert shown == list(zip((True, False, True), answers, strict=True))
    heads = re.findall(r"<h2 id=.(?:equations|levels|trust).>(.*?)</h2>", said)
    assert heads == list(outline_arm(labelled).questions)
    for level, title in LEVELS.items():
        assert f"<em>{level}</em>: {title}" in said


@pytest.mark.parametrize(
    ("metres", "card"),
    [
        (0.0, "0 µm tip error in drop; no teeth touch why"),
        (0.02, "20 mm tip error in drop why"),
    ],
)
def test_a_tip_that_is_off_by_nothing_has_its_reason_on_the_first_screen(labelled, metres, card):
    own = about("deviation", "drop", "tip", "analytic:links", "analytic:geared")
    page = page_of([*FINDINGS, make_measurement(own, measured=metres)], labelled)
    assert card in " ".join(html.unescape(re.sub("<[^>]+>", " ", page)).split())


def test_only_what_failed_for_one_reason_has_one_line(capsys):
    notes = ("a (x) (at state 3)", "a (y) (at state 3)", "a (x) (at state 5)")
    notes += ("died", "raised", "died", "", "")
    found = [
        make_failed_check(about("states", CASE, f"q{number}", LEAD, TREE), note)
        for number, note in enumerate(notes)
    ]
    print_agreement(Agreement(found))
    lines = [line.partition("/q")[2] for line in capsys.readouterr().out.splitlines()]
    ends = [line.partition(": ")[2] for line in lines if line]
    same = "; and so in 1 more check"
    assert ends == [f"{notes[0]}{same}", notes[1], f"died{same}", "raised", "", ""]


@pytest.mark.parametrize(
    ("findings", "told"),
    [
        ([], "Nothing was checked."),
        (FINDINGS[:1], "The equations agree with every engine (1 of 1 check)."),
        (FINDINGS[:2], "The equations agree with every engine (2 of 2 checks)."),
        (
            FINDINGS[3:4],
            f"1 of 1 check does not agree (1 differ), the first of them {FINDINGS[3].id}.",
        ),
        (
            [FINDINGS[0], make_measurement(FINDINGS[-2].about, measured=1e-13)],
            "The printed equations agree with the engines; the corrected ones agree with every"
            " engine (1 of 1 check).",
        ),
    ],
)
def test_the_verdict_is_one_sentence(findings, told):
    assert describe_verdict(Agreement(findings)) == told


def off(level: str, size: float, case: str = "drop", quantity: str = "tip") -> Finding:
    metric = "largest distance of the tip after 0.1 s"
    if quantity == "torque":
        metric = "largest difference of the torque of hand over 20 random states"
    own = about("deviation", case, quantity, f"a:{level}", "a:geared", metric=metric)
    return make_measurement(own, measured=size, relative=size)


def test_the_first_and_the_last_level_are_reported_for_every_experiment():
    last = [off("links", 0.0123), off("armature", 9e-3), off("coupled", 2e-7)]
    lost = make_failed_check(about("deviation", "pd", "tip", "a:armature", LEAD), "none")
    found = Agreement([off("links", 0.5, "constant"), *last, lost])
    said = answer_on_rigid_arm(found)
    assert re.findall(r"In experiment (\w+)", said) == ["constant", "drop", "drop"]
    assert re.findall(r"\((\w+)\)", said) == ["links", "links", "coupled"]
    assert find_tip_ends(found) == [last[0], last[2]]
    assert find_tip_ends(Agreement(last[:1])) == last[:1]
    assert find_tip_ends(Agreement([])) == []
    assert "No rigid model" in answer_on_rigid_arm(Agreement([]))


def test_a_level_at_which_no_teeth_touch_is_said_to_be_so():
    found = [off("links", 0.0), off("links", 0.3, quantity="torque"), off("coupled", 0.0)]
    first, last = answer_on_levels(Agreement(found)).split(" At level coupled ")
    assert "0.1 s, in which no teeth touch." in first
    assert "no teeth" not in last
    lost = make_failed_check(about("deviation", "drop", "tip", "a:armature", "a:geared"), "none")
    assert answer_on_levels(Agreement([*found, lost])) == answer_on_levels(Agreement(found))
    apart = [off("links", 0.2), off("coupled", 0.0), off("coupled", 0.0, quantity="torque")]
    assert answer_on_levels(Agreement(apart)).endswith(
        " Level coupled does not differ from geared."
    )


@pytest.mark.parametrize(
    ("measured", "quantity", "said"),
    [(1e-4, "bias", "0.01 %"), (8e-5, "bias", "8e-05"), (0.0234, "theta", "0.023 rad")],
)
def test_a_relative_difference_is_reported_in_per_cent_unless_it_is_tiny(measured, quantity, said):
    subject = about("states", CASE, quantity, LEAD, GEARS)
    assert format_amount(make_measurement(subject, measured=measured)) == said


def test_a_derivation_without_checks_at_states_has_no_digits_to_tell(labelled):
    outline = outline_arm(labelled)
    run = check(about("same-step", "pd", "theta", "analytic:links", LINKS), 0.0, 1e-9)
    for findings, digits in (([run], "to rounding"), ([run, FINDINGS[0]], "to 12 digits")):
        said = answer_on_equations(compare_models(Agreement(findings), outline), outline)
        assert said.startswith(f"The derivation agrees with every engine at each level, {digits}")


NAN = float("nan")


@pytest.mark.parametrize(
    ("format_one", "given"),
    [
        (format_rounded, {1234.0: "1200", 1e-7: "1e-07", 0.0996: "0.1", NAN: "no number"}),
        (format_percent, {0.0127: "1.3 %", 12.3: "1200 %", float("inf"): "no number"}),
        (
            format_length,
            {1.0: "1 m", 0.99: "990 mm", -2.345: "-2.35 m", 1e-5: "0.01 mm", 9.9e-6: "9.9 µm"}
            | {4.46e-13: "less than 1 nm", 1.2e-9: "0.0012 µm", 0.0: "0 µm"},
        ),
        (format_number, {1234.5: "1.23e+03", 0.0: "0", None: ""}),
        (format_unit, {"1": "", "rad s-1": "rad/s", "m s-2": "m/s²", "N m s-1 m-1": "N m/s m-1"}),
        (common_digits, {1e-16: 16.0, 0.0: 16.0, 1e-15: 15.0, 0.01: 2.0, 1.0: 0.0, 30.0: 0.0}),
    ],
    ids=lambda each: getattr(each, "__name__", None),
)
def test_a_number_is_written_as_people_read_it(format_one, given):
    assert {value: format_one(value) for value in given} == given
