"""Every list and table of a report, on findings made by hand whose numbers are all unlike."""

import html
import json
import re
from xml.etree import ElementTree

import pytest

from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    EntryDifferences,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
    make_unfinished_check,
)
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import record_provenance
from crosscheck.registry import LEVELS, MODELS
from crosscheck.report.answers import (
    answer_on_equations,
    answer_on_levels,
    answer_on_rigid_arm,
    answer_on_trust,
    compare_models,
    describe_verdict,
    find_tip_ends,
    find_wrong_entries,
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
from crosscheck.report.junit import format_junit
from crosscheck.report.matrix import (
    collect_cells,
    common_digits,
    fold_cells,
    group_models,
    is_beyond,
)
from crosscheck.report.outline import outline_arm, outline_robot
from crosscheck.report.plots.charts import Pictures
from crosscheck.report.terminal import print_agreement, print_report_summary
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


def test_findings_are_grouped_by_the_models_that_they_are_of():
    groups = list_findings(FINDINGS).groups
    assert [(group.title, group.summary, group.is_open) for group in groups] == [
        (f"{LEAD} and {BODIES}", "2 failed", True),
        (f"{LEAD} and {TREE}", "1 differ; at most 20 times of a tolerance", True),
        (
            f"{LEAD} and {GEARS}",
            "1 unfinished, 1 unresolved, 2 agree; at most 50 % of a tolerance",
            True,
        ),
        (f"{TREE} alone", "2 agree; at most 33 % of a tolerance", False),
        (f"{GEARS} alone", "1 agree; at most 12 % of a tolerance", False),
        (f"{TREE} and {GEARS}", "1 agree; at most 3.5 % of a tolerance", False),
        (f"{LEAD} alone", "1 agree; at most 0 % of a tolerance", False),
        (f"{PRINTED} and {GEARS}", "1 measured", False),
        (f"{LEAD} and {LINKS}", "1 measured", False),
    ]
    third = [(row.finding.quantity, row.tolerance, row.share) for row in groups[2].rows]
    expected = [("theta", "", ""), ("theta_dot", "0.3", "3.3 %"), ("bias", "1e-12", "50 %")]
    assert third == [*expected, ("mass_matrix", "1e-12", "3 %")]


def test_the_matrix_has_a_line_for_each_pair_and_one_for_all_that_agree_with_one_thing():
    cells = collect_cells(FINDINGS)
    listed = [(c.left, c.right, c.between_models, c.verdict, c.checks) for c in cells]
    pairs = [
        (LEAD, GEARS, True, "unfinished", 4),
        (TREE, GEARS, True, "agree", 1),
        (LEAD, TREE, True, "differ", 1),
        (LEAD, BODIES, True, "failed", 2),
        (PRINTED, GEARS, True, "differ", 0),
    ]
    rest = (GEARS, "its start", False, "agree", 1)
    one = (LEAD, "its work", False, "agree", 1), (TREE, "its work", False, "agree", 2)
    assert listed == [*pairs, *one, rest]
    folded = [(c.left, c.right, c.between_models, c.verdict, c.checks) for c in fold_cells(cells)]
    assert folded == [*pairs, ("2 models", "its work", False, "agree", 3), rest]
    digits = [{family: round(value, 1) for family, value in c.digits.items()} for c in cells[:5]]
    states = "at states"
    assert digits == [{states: 12.3}, {states: 13.2}, {"over runs": 9.0}, {}, {states: 1.9}]


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


def test_the_terminal_prints_the_matrix_and_every_check_that_does_not_agree(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    print_agreement(AGREEMENT)
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.split() == ["left", "right", "verdict", "checks", "digits", "in", "common"]
    assert [" ".join(line.split()) for line in lines] == [
        f"{LEAD} {GEARS} unfinished 4 12.3 at states",
        f"{TREE} {GEARS} agree 1 13.2 at states",
        f"{LEAD} {TREE} differ 1 9.0 over runs",
        f"{LEAD} {BODIES} failed 2",
        f"{PRINTED} {GEARS} differ no limit 1.9 at states",
        "2 models its work agree 3",
        f"{GEARS} its start agree 1",
        *RED_LINES,
        TALLY,
    ]


def test_the_terminal_prints_each_model_and_the_first_of_what_does_not_agree(
    labelled, capsys, monkeypatch
):
    monkeypatch.setenv("COLUMNS", "200")
    more = [alone(f"m{n}", "pd", 2.0, 1.0) for n in range(6)]
    print_report_summary(AGREEMENT, labelled)
    first, _, *lines, last = capsys.readouterr().out.splitlines()
    assert (first, last) == (OUTCOME, OUTCOME)
    assert [" ".join(line.split()) for line in lines] == [
        f"{PRINTED} differ 1.3 %",
        f"{LEAD} failed 3e-14 no number",
        "In experiment pd the rigid arm's tip is off by up to 40 mm without the joints' masses"
        " and the gears' inertia (links).",
        *RED_LINES,
        TALLY,
    ]
    for count, told in ((5, ""), (6, "... and 1 more on the page")):
        print_report_summary(Agreement([*FINDINGS, *more[:count]]), labelled)
        lines = capsys.readouterr().out.splitlines()
        assert sum(line.startswith("differ energy/") for line in lines) == 5
        assert [line for line in lines if line.startswith("... and")] == [told] * bool(told)


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


def test_the_pages_tables_have_every_number(page):
    tables = [rows_of(each) for each in re.findall(r"<table\b.*?</table>", page, re.S)]
    by_head = {rows[0]: rows[1:] for rows in reversed(tables) if rows}
    head = "model | verdict | mass matrix | acceleration | joint angle in runs"
    (models,) = (rows for name, rows in by_head.items() if name.startswith(head))
    numbers = [row.partition(" | ")[2] for row in models]
    assert numbers == [
        f"differ | 1.3 % | - | - | - | {GEARS} |",
        f"failed | 3e-14 | - | no number | - | {GEARS}, {TREE}, {BODIES} |",
    ]
    assert by_head["level | tip [m] |"] == [f"{LINKS} | 0.04 |"]
    same_step = f"same-step/pd/theta/{LEAD}~{TREE} rounding | 4e-09 rad | 2e-10 | 20 times | differ"
    unresolved = f"refined/pd/theta_dot/{LEAD}~{GEARS} rounding | 0.01 rad/s | 0.3 | 3.3 %"
    bias = f"states/{CASE}/bias/{GEARS}~{LEAD} rounding of 8 states | 5e-13 | 1e-12 | 50 % | agree"
    stopped = f"refined/pd/theta/{LEAD}~{GEARS} stopped | | | | unfinished |"
    failed = [
        f"states/{CASE}/{quantity}/{LEAD}~{BODIES} no answer (at state {state}) | | | | failed |"
        for quantity, state in (("bias", 3), ("force", 5))
    ]
    listed = [rows[1:] for rows in tables if rows and rows[0].startswith("check, and where")]
    wrong, headline, tightest, *groups = listed
    assert wrong == [*failed, f"{same_step} |", stopped, f"{unresolved} | unresolved |"]
    assert headline == [f"{same_step} |"]
    assert tightest[:3] == [f"{same_step} |", f"{unresolved} | unresolved |", f"{bias} |"]
    assert groups[:2] == [failed, [f"{same_step} |"]]
    assert groups[2][:3] == [stopped, f"{unresolved} | unresolved |", f"{bias} |"]
    assert sum(map(len, groups)) == len(FINDINGS)
    matrix = by_head[f"| {LEAD} | {GEARS} | {TREE} | {BODIES} | {PRINTED} |"]
    pair = "unfinished 12.3 digits at states 4 checks"
    differ = "differ 9.0 digits over runs 1 check"
    assert matrix[0] == f"{LEAD} | - | {pair} | {differ} | failed 2 checks | - |"
    assert matrix[2].startswith(f"{TREE} | {differ} | agree 13.2 digits at states 1 check | - |")
    assert matrix[4].startswith(f"{PRINTED} | - | differ 1.9 digits at states no limit | - |")
    assert f"{LEAD} | its work | agree 1 check |" in [row for rows in tables for row in rows]


def test_the_pages_words_have_every_count(page):
    body = re.sub(r"<(script|style|svg)\b.*?</\1>", "", page, flags=re.S)
    text = " ".join(html.unescape(re.sub("<[^>]+>", " ", body)).split())
    for said in (
        OUTCOME,
        "Equations failed 2 of 2 models why",
        "Rigid arm 40 mm off at the tip why",
        "Checks 7 of 12 agree why",
        "All 14 findings",
        "2 failed 1 differ 1 unfinished 1 unresolved 7 agree 2 measured",
        f"{LEAD} and {GEARS} 1 unfinished, 1 unresolved, 2 agree; at most 50 % of a tolerance",
    ):
        assert said in text, said
    opened = re.findall(r"<details( open)?><summary>(?:<[^>]*>)*([^<]*)", page)
    assert [name.strip() for is_open, name in opened if is_open and " and " in name] == [
        f"{LEAD} and {other}" for other in (BODIES, TREE, GEARS)
    ]


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


def test_each_model_is_beside_the_engines_of_other_packages(labelled):
    rows = compare_models(AGREEMENT, outline_arm(labelled))
    found = [
        (row.model, row.against, row.verdict, {q: f.measured for q, f in row.worst.items()})
        for row in rows
    ]
    assert found == [
        (PRINTED, (GEARS,), "differ", {"mass_matrix": 0.0127}),
        (LEAD, (GEARS, TREE, BODIES), "failed", {"mass_matrix": 3e-14, "theta": None}),
    ]
    assert rows[0].digits is None
    assert rows[1].digits == pytest.approx(12.3, abs=0.01)


def test_what_stands_behind_the_checks_is_counted(labelled):
    assert describe_verdict(AGREEMENT) == OUTCOME
    assert answer_on_trust(AGREEMENT, outline_arm(labelled)) == (
        f"{TALLY}; 2 failed; 1 differ; 1 unresolved. 8 compare two models that share data and no"
        " formula; 4 compare one model with first principles, its own records or the arm's file."
        " A tolerance is what rounding, or a run's measured uncertainty, explains. 2 more numbers"
        " are measured without a limit, such as how far rigid levels and the printed equations are"
        " off."
    )
    robot = load_robot("puma560")
    assert "rigid levels are off" in answer_on_trust(Agreement(FINDINGS[:3]), outline_robot(robot))


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


def test_junit_has_a_case_for_each_check_and_a_property_for_each_measurement():
    root = ElementTree.fromstring(format_junit(AGREEMENT, "mine", {"told": 7}))
    suite = root[0]
    counts = [root.get(key) for key in ("tests", "failures", "errors", "skipped", "time")]
    assert counts == ["12", "2", "3", "0", "0"]
    assert suite.get("name") == "mine"
    cases = suite.findall("testcase")
    assert [(case.get("classname"), case.get("name")) for case in cases[:2]] == [
        (f"states.{CASE}", f"mass_matrix/{LEAD}~{GEARS}"),
        (f"states.{CASE}", f"bias/{GEARS}~{LEAD}"),
    ]
    assert cases[1].findtext("system-out") == (
        "measured 5e-13, allowed 1e-12; of 8 states (rounding)"
    )
    assert cases[4].findtext("system-out") == "no answer (at state 3)"
    properties = {each.get("name"): each.get("value") for each in root.iter("property")}
    measured = {FINDINGS[-2].id: "0.0127 1", FINDINGS[-1].id: "0.04 m"}
    assert properties == {"told": "7", **measured}


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


def test_the_largest_of_all_wrong_entries_is_told():
    def entries(quantity: str, model: str, *relative: tuple[float, ...]) -> EntryDifferences:
        return EntryDifferences(quantity, model, (TREE,), ("x", "theta"), relative, 1e-10)

    mass = entries("mass_matrix", PRINTED, (0.0, 0.02), (0.03, 0.5))
    bias = entries("bias", PRINTED, (0.0,), (0.7,))
    found = find_wrong_entries([mass, entries("bias", LEAD, (0.9,), (0.9,)), bias])
    expected = [("bias[theta]", 0.7), ("M[theta, theta]", 0.5), ("M[x, theta]", 0.03)]
    assert [(each.name, each.relative) for each in found] == expected
    told = "The printed equations are wrong in 3 places (largest bias[theta], 70 %); nothing was"
    assert describe_verdict(Agreement([], entries=[mass, bias])).startswith(told)


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
