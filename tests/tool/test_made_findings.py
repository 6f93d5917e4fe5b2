"""Every list and table of a report, on findings made by hand whose numbers are all unlike."""

import html
import json
import re

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
from crosscheck.registry import LEVELS, MODELS
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
from crosscheck.report.finding_groups import list_findings
from crosscheck.report.formatting import (
    format_length,
    format_number,
    format_percent,
    format_rounded,
    format_unit,
)
from crosscheck.report.html import render_report_page
from crosscheck.report.matrix import (
    collect_cells,
    common_digits,
    group_models,
    is_beyond,
)
from crosscheck.report.outline import outline_arm
from crosscheck.report.plots.charts import Pictures
from crosscheck.report.terminal import print_agreement
from crosscheck.run import CrossCheck

LEAD, PRINTED, LINKS = "analytic:physical", "analytic:printed", "pinocchio:links"
GEARS, TREE, BODIES = "pinocchio:gears", "exudyn:tree", "exudyn:bodies"
CASE = "paper-labelled/geared"


def about(
    family: str, case: str, quantity: str, *models: str, unit: str = "1", against: str = ""
) -> Subject:
    return Subject(ComparisonKey(family, case, quantity, *models), unit, "largest", against)


def check(
    subject: Subject, measured: float, tolerance: float, relative: float | None = None
) -> Finding:
    basis = "rounding"
    return make_check(
        subject, measured=measured, tolerance=tolerance, relative=relative, basis=basis
    )


def alone(model: str, case: str, measured: float, tolerance: float) -> Finding:
    subject = about("energy", case, "energy", model, unit="J", against="its work")
    return check(subject, measured, tolerance)


FINDINGS = [
    check(about("states", CASE, "mass_matrix", LEAD, GEARS), 3e-14, 1e-12, 2e-13),
    make_check(
        about("states", CASE, "bias", GEARS, LEAD),
        measured=5e-13,
        tolerance=1e-12,
        relative=5e-13,
        basis="rounding",
        note="of 8 states",
    ),
    check(about("states", CASE, "mass_matrix", TREE, GEARS), 7e-14, 2e-12, 7e-14),
    check(about("same-step", "pd", "theta", LEAD, TREE, unit="rad"), 4e-9, 2e-10, 1e-9),
    make_failed_check(about("states", CASE, "bias", LEAD, BODIES), "no answer (at state 3)"),
    make_failed_check(about("states", CASE, "force", LEAD, BODIES), "no answer (at state 5)"),
    make_unfinished_check(about("refined", "pd", "theta", LEAD, GEARS), "stopped"),
    make_check(
        about("refined", "pd", "theta_dot", LEAD, GEARS, unit="rad s-1"),
        measured=0.01,
        tolerance=0.3,
        resolved=False,
        basis="rounding",
    ),
    alone(LEAD, "pd", 0.0, 0.0),
    alone(TREE, "pd", 1e-9, 4e-9),
    alone(TREE, "motion", 1e-9, 3e-9),
    check(about("momentum", "pd", "momentum", GEARS, against="its start"), 1e-9, 8e-9),
    make_measurement(
        about("form-states", CASE, "mass_matrix", PRINTED, GEARS), measured=0.0127, relative=0.0127
    ),
    make_measurement(about("deviation", "pd", "tip", LINKS, LEAD, unit="m"), measured=0.04),
]
AGREEMENT = Agreement(FINDINGS)
VERDICTS = {"failed": 2, "differ": 1, "unfinished": 1, "unresolved": 1, "agree": 7, "measured": 2}
TALLY = "7 of 12 checks agree; 1 unfinished, not judged"
OUTCOME = (
    "The printed equations do not agree with the engines; 5 of 12 checks do not agree"
    " (2 failed, 1 differ, 1 unfinished, 1 unresolved), the first of them"
    f" same-step/pd/theta/{LEAD}~{TREE}."
)
RED_LINES = [
    f"differ same-step/pd/theta/{LEAD}~{TREE}: measured 4e-09, allowed 2e-10 rad",
    f"failed states/{CASE}/bias/{LEAD}~{BODIES}: no answer (at state 3); and so in 1 more check",
    f"unfinished refined/pd/theta/{LEAD}~{GEARS}: stopped",
    f"unresolved refined/pd/theta_dot/{LEAD}~{GEARS}: the uncertainty itself, 0.3 rad/s,"
    " exceeds the acceptance limit (measured 0.01)",
]


def test_of_each_kind_the_tightest_check_is_listed_the_worst_verdict_first():
    listed = list_findings(FINDINGS)
    assert (listed.total, listed.verdicts) == (14, VERDICTS)
    assert list(listed.verdicts) == list(VERDICTS)
    rows = [(r.finding.about.key.family, r.measured, r.tolerance, r.share) for r in listed.tightest]
    assert rows == [
        ("same-step", "4e-09 rad", "2e-10", "20 times"),
        ("refined", "0.01 rad/s", "0.3", "3.3 %"),
        ("states", "5e-13", "1e-12", "50 %"),
        ("energy", "1e-09 J", "3e-09", "33 %"),
        ("momentum", "1e-09", "8e-09", "12 %"),
    ]
    assert [row.reason for row in listed.tightest][1:3] == ["rounding", "rounding of 8 states"]


def test_at_most_ten_tightest_kinds_are_listed():
    many = [check(about(f"kind-{n}", "pd", "x", LEAD, TREE), n, 20.0) for n in range(1, 13)]
    families = [row.finding.about.key.family for row in list_findings(many).tightest]
    assert families == [f"kind-{n}" for n in range(12, 2, -1)]


def test_the_printed_equations_are_allowed_what_the_reference_model_is():
    """1e-12; what two engines are allowed between each other, 2e-12, does not count."""
    subject = FINDINGS[-2].about
    for measured, beyond in ((0.9e-12, False), (1.5e-12, True)):
        assert is_beyond(make_measurement(subject, measured=measured), FINDINGS) is beyond
    assert is_beyond(FINDINGS[-1], FINDINGS) is None


def test_an_arm_is_told_by_the_printed_forms_the_derivation_and_its_rigid_levels(labelled):
    outline = outline_arm(labelled)
    assert list(outline.models)[-5:] == [
        LEAD,
        *(f"analytic:{level}" for level in ("links", "carriers", "armature", "coupled")),
    ]
    assert set(outline.models) - set(outline.forms) == set(list(outline.models)[-5:])


def test_groups_of_models_are_those_that_checks_connect():
    def pair(left: str, right: str) -> Finding:
        return check(about("states", CASE, "bias", left, right), 0.0, 1.0)

    names = ("ab", "cd", "ef", "gb", "fh")
    cells = collect_cells([pair(*ends) for ends in names])
    assert group_models(cells) == [["c", "d"], ["a", "b", "g"], ["e", "f", "h"]]
    joined = collect_cells([pair(*ends) for ends in (*names, "ad")])
    assert group_models(joined) == [["e", "f", "h"], ["c", "d", "a", "b", "g"]]


def rows_of(table: str) -> list[str]:
    """The rows of a table of HTML, their cells parted by bars; a dash stands for nothing."""
    rows = re.findall(
        r"<tr\b.*?(?=<tr\b|$)", re.sub(r"</t[hd]>", " | ", table.replace("\N{EN DASH}", "-")), re.S
    )
    return [" ".join(html.unescape(re.sub("<[^>]+>", " ", row)).split()) for row in rows]


@pytest.fixture(scope="module")
def page(labelled) -> str:
    agreement = Agreement(FINDINGS, record_provenance(labelled, 0, True))
    request = CrossCheckRequest(labelled, quick=True)
    return render_report_page(CrossCheck(request, agreement, {}, {}), Pictures({}))


def test_the_pages_first_screen_answers_topic_by_topic(page, labelled):
    agreement = Agreement(FINDINGS, record_provenance(labelled, 0, True))
    told = json.loads(format_agreement_json(agreement, labelled))["answers"]
    answers = {name: told[name]["answer"] for name in ("equations", "rigid", "trust")}
    said = html.unescape(page)
    assert "<h1>Preliminary cross-check of paper-labelled</h1>" in said
    assert said.count('<section class="verdict no">') == 1
    cards = re.findall(r"<article( class=.no.)?>(.*?)<details><summary>why(.*?)<a", said, re.S)
    shown = [
        (bool(red), *(" ".join(re.sub("<[^>]+>", " ", each).split()) for each in texts))
        for red, *texts in cards
    ]
    assert shown == [
        (True, "Equations failed 2 of 2 models", answers["equations"]),
        (False, "Rigid arm 40 mm off at the tip", answers["rigid"]),
        (True, "Checks 7 of 12 agree", answers["trust"]),
    ]
    heads = re.findall(r"<h2 id=.(\w+).>(\d)\. (.*?)</h2>", said)
    assert [(place, number) for place, number, _ in heads] == [
        *(("equations", "1"), ("levels", "2"), ("trust", "3")),
    ]
    assert [head for _, _, head in heads] == list(outline_arm(labelled).questions)
    assert "Bent arm." in said
    for level, title in LEVELS.items():
        assert f"<em>{level}</em>: {title}" in said
    for model in ("analytic:printed", "analytic:physical"):
        assert f"<th>{model}<br><small>{MODELS[model].title}</small></th>" in said
    assert "from the geared arm (analytic:physical) over" in said


@pytest.mark.parametrize(
    ("metres", "card"),
    [(0.0, "0 µm off at the tip; no teeth touch why"), (0.02, "20 mm off at the tip why")],
)
def test_a_tip_that_is_off_by_nothing_has_its_reason_on_the_first_screen(labelled, metres, card):
    key = ComparisonKey("deviation", "drop", "tip", "analytic:links", "analytic:geared")
    about = Subject(key, "m", "largest distance of the tip after 0.1 s")
    found = [*FINDINGS, make_measurement(about, measured=metres)]
    made = Agreement(found, record_provenance(labelled, 0, True))
    request = CrossCheckRequest(labelled, quick=True)
    page = render_report_page(CrossCheck(request, made, {}, {}), Pictures({}))
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


def test_json_has_each_models_largest_differences(labelled):
    models = json.loads(format_agreement_json(AGREEMENT, labelled))["answers"]["equations"]
    assert [(each["model"], each["against"]) for each in models["models"]] == [
        (PRINTED, [GEARS]),
        (LEAD, [GEARS, TREE, BODIES]),
    ]
    assert models["models"][1]["differences"] == [
        {"quantity": "mass_matrix", "measured": 3e-14, "unit": "1", "id": FINDINGS[0].id},
        {"quantity": "theta", "measured": None, "unit": "1", "id": FINDINGS[6].id},
    ]


def tip(case: str, level: str, metres: float, unit: str = "m") -> Finding:
    subject = about("deviation", case, "tip", f"pinocchio:{level}", LEAD, unit=unit)
    return make_measurement(subject, measured=metres)


def test_the_first_and_the_last_level_are_told_of_every_experiment():
    first = [tip("constant", "links", 0.5), tip("constant", "carriers", 0.25)]
    last = [tip("pd", "links", 0.0123), tip("pd", "armature", 9e-3), tip("pd", "coupled", 2e-7)]
    lost = make_failed_check(about("deviation", "pd", "tip", "pinocchio:armature", LEAD), "none")
    found = Agreement([*first, *last, lost, *FINDINGS[:2]])
    assert answer_on_rigid_arm(found) == (
        "In experiment constant the rigid arm's tip is off by up to 500 mm without the joints'"
        " masses and the gears' inertia (links), by 250 mm without the gears' spin (carriers)."
        " In experiment pd the rigid arm's tip is off by up to 12.3 mm without the joints' masses"
        " and the gears' inertia (links), by 0.2 µm"
        " without the give, play and errors of the teeth (coupled)."
    )
    assert find_tip_ends(found) == [last[0], last[2]]
    assert find_tip_ends(Agreement(last[:1])) == last[:1]
    assert find_tip_ends(Agreement([])) == []
    assert "No rigid model" in answer_on_rigid_arm(Agreement([]))


def test_each_level_of_a_robot_is_told_with_its_tip_and_its_torque():
    def torque(level: str, joint: str, relative: float) -> Finding:
        key = ComparisonKey("deviation", "states", "torque", f"a:{level}", "a:geared")
        metric = f"largest difference of the torque of {joint} over 20 random states"
        return make_measurement(Subject(key, "N m", metric), measured=1.0, relative=relative)

    def tip_off(level: str, metres: float) -> Finding:
        key = ComparisonKey("deviation", "drop", "tip", f"a:{level}", "a:geared")
        metric = "largest distance of the tip after 0.1 s"
        return make_measurement(Subject(key, "m", metric), measured=metres)

    found = [tip_off("links", 0.02), torque("links", "base", 0.01), torque("links", "hand", 0.3)]
    found += [tip_off("coupled", 0.0), torque("coupled", "base", 0.04)]
    assert answer_on_levels(Agreement(found)) == (
        "At level links the tip is 20 mm from that of geared after 0.1 s, and the torque of hand is"
        " off by up to 30 % of its largest. At level coupled the tip is 0 µm from that of geared"
        " after 0.1 s, and the torque of base is off by up to 4 % of its largest."
    )
    found[0] = tip_off("links", 0.0)
    first, _ = answer_on_levels(Agreement(found)).split(" At level coupled ")
    assert "the tip is 0 µm from that of geared after 0.1 s, in which no teeth touch, and" in first
    key = ComparisonKey("deviation", "drop", "tip", "a:armature", "a:geared")
    lost = make_failed_check(Subject(key, "m", "largest distance"), "none")
    assert answer_on_levels(Agreement([*found, lost])) == answer_on_levels(Agreement(found))
    same = "All levels are the same: no joint is geared."
    assert answer_on_levels(Agreement([tip_off("links", 0.0), tip_off("coupled", 0.0)])) == same
    assert answer_on_levels(Agreement(FINDINGS[:3])) == "There is one level alone."


@pytest.mark.parametrize(
    ("measured", "unit", "said"),
    [
        (1e-4, "1", "0.01 %"),
        (8e-5, "1", "8e-05"),
        (0.0234, "1", "2.3 %"),
        (0.0234, "rad", "0.023 rad"),
        (1e-5, "m s-2", "1e-05 m s-2"),
    ],
)
def test_a_relative_difference_is_told_in_per_cent_unless_it_is_tiny(measured, unit, said):
    subject = about("states", CASE, "bias", LEAD, GEARS, unit=unit)
    assert format_amount(make_measurement(subject, measured=measured)) == said


def test_a_derivation_without_checks_at_states_has_no_digits_to_tell(labelled):
    outline = outline_arm(labelled)
    run = check(about("same-step", "pd", "theta", "analytic:links", LINKS, unit="rad"), 0.0, 1e-9)
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
        (
            format_unit,
            {
                "1": "",
                "rad s-1": "rad/s",
                "m s-2": "m/s²",
                "N m": "N m",
                "N m s-1 m-1": "N m/s m-1",
            },
        ),
        (common_digits, {1e-16: 16.0, 0.0: 16.0, 1e-15: 15.0, 0.01: 2.0, 1.0: 0.0, 30.0: 0.0}),
    ],
    ids=lambda each: getattr(each, "__name__", None),
)
def test_a_number_is_written_as_people_read_it(format_one, given):
    assert {value: format_one(value) for value in given} == given
