"""The three questions that a cross-check answers, from its findings alone."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.findings import Agreement, EntryDifferences, Finding, Verdict, WrongEntry
from crosscheck.mechanisms import supply
from crosscheck.models.arm.arm import Arm
from crosscheck.models.mechanism import Mechanism
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import engine_of, model_names
from crosscheck.report.formatting import (
    describe_tally,
    format_count,
    format_length,
    format_percent,
    format_rounded,
    join_words,
)
from crosscheck.report.matrix import FORMS, WORST_FIRST, common_digits, is_beyond
from crosscheck.report.outline import ReportOutline
from crosscheck.report.records import format_json, to_json_value

STATES, RUNS = ("states", "form-states"), ("same-step", "refined", "form")
LEVEL_OMISSIONS = {
    "links": "the joints' masses and the gears' inertia",
    "carriers": "the gears' spin",
    "armature": "the coupling of the gears' spin to the links",
    "coupled": "the compliance, backlash and errors of the teeth",
}
SMALL = 1e-4  # relative differences from here on are shown in per cent


@dataclass(frozen=True)
class ModelAnswer:
    """A model beside all others that it was compared with.

    title: what it is; against: those models; worst: by quantity the Finding of the largest
    difference on the arm or robot itself; verdict: the worst of all checks between them; of a model
    that is only measured, ``differ`` where a difference is beyond what the reference model is
    allowed; digits: decimal ones that its checks at states leave in common, None without such
    checks.
    """

    model: str
    title: str
    against: tuple[str, ...]
    worst: dict[str, Finding]
    verdict: Verdict
    digits: float | None = None

    def number(self, quantity: str) -> str:
        """The largest difference of a quantity, with its unit; empty where it was not compared."""
        finding = self.worst.get(quantity)
        return "" if finding is None else format_amount(finding)


def format_amount(finding: Finding) -> str:
    """A measured difference for reading: relative ones in per cent unless they are tiny."""
    value = finding.measured
    if value is None:
        return "no number"
    if finding.unit != "1":
        return f"{format_rounded(value)} {finding.unit}"
    return format_percent(value) if value >= SMALL else f"{value:.1g}"


def compare_models(agreement: Agreement, outline: ReportOutline) -> list[ModelAnswer]:
    """The models of a report, each beside the engines.

    Differences are those on this arm or robot; verdicts and digits are of all checks.
    """
    pairs = [f for f in agreement.findings if f.about.key.right]
    # States of this arm, not of the probe's or another reading's; and any run.
    arm_findings = [
        f
        for f in pairs
        if f.about.key.family in RUNS
        or (f.about.key.family in STATES and f.about.key.case.partition("/")[0] == outline.name)
    ]
    rows = []
    for model in outline.models:
        others = [f for f in arm_findings if _is_with_other_engine(f, model)]
        checks = [f for f in pairs if f.kind == "check" and _is_with_other_engine(f, model)]
        if others:
            rows.append(_compare_model(model, outline, others, checks, arm_findings))
    return rows


def _is_with_other_engine(finding: Finding, model: str) -> bool:
    """Whether a finding compares the model with one of another package."""
    if model not in (finding.left, finding.right):
        return False
    other = finding.right if finding.left == model else finding.left
    return engine_of(other) != engine_of(model)


def _compare_model(
    model: str,
    outline: ReportOutline,
    others: Sequence[Finding],
    checks: Sequence[Finding],
    arm_findings: Sequence[Finding],
) -> ModelAnswer:
    worst: dict[str, Finding] = {}
    for quantity in outline.quantities:
        if findings := [f for f in others if f.quantity == quantity]:
            worst[quantity] = max(findings, key=_size)
    against = dict.fromkeys(f.right if f.left == model else f.left for f in others)
    if checks:
        verdict = min((f.verdict for f in checks), key=WORST_FIRST.index)
    else:
        verdict = "differ" if any(is_beyond(f, arm_findings) for f in others) else "agree"
    states = [f.relative for f in checks if f.about.key.family == "states"]
    common = [common_digits(value) for value in states if value is not None]
    digits, title = min(common, default=None), outline.models[model]
    return ModelAnswer(model, title, tuple(against), worst, verdict, digits)


def _size(finding: Finding) -> float:
    return float("inf") if finding.measured is None else finding.measured


def answer_on_equations(rows: Sequence[ModelAnswer], outline: ReportOutline) -> str:
    """The answer to the first question in three sentences at most."""
    forms = [row for row in rows if row.model in outline.forms]
    rest = [row for row in rows if row not in forms]
    wrong = [row for row in forms if row.verdict != "agree"]
    sentences = []
    for row in wrong:
        sizes = ", ".join(f"{row.number(q)} in {outline.quantities[q]}" for q in row.worst)
        title = f"{row.title[0].upper()}{row.title[1:]}"
        sentences.append(f"{title}, do not agree with the engines: they differ by up to {sizes}.")
    if forms and not wrong:
        sentences.append("The paper's equations as printed agree with the engines.")
    red = [row.model for row in rest if row.verdict != "agree"]
    if red:
        sentences.append(f"Of the project's own derivation these do not agree: {', '.join(red)}.")
    elif rest:
        whose = "corrected derivation" if forms else "derivation"
        common = min((row.digits for row in rest if row.digits is not None), default=None)
        to = "to rounding" if common is None else f"to {math.floor(common)} digits at random states"
        where = " at each level" if outline.has_levels else ""
        sentences.append(f"The {whose} agrees with every engine{where}, {to}.")
    return " ".join(sentences)


def answer_on_rigid_arm(agreement: Agreement, _: Arm) -> str:
    """The answer to the second question: how far the tip of the first and the last level is off."""
    by_case = _group_tips(agreement)
    if not by_case:
        return "No rigid model was run beside the geared one."
    sentences = []
    for case, findings in by_case.items():
        first, *others = map(_describe_tip, (findings[0], *findings[1:][-1:]))
        sentences.append(f"In experiment {case} the rigid arm's tip is off by up to {first}.")
        sentences += (f"In experiment {case} it is off by up to {other}." for other in others)
    return " ".join(sentences)


def answer_on_levels(agreement: Agreement, robot: Robot) -> str:
    """Deviation of tip and torques at each level of a robot from its most detailed level."""
    deviations = [f for f in agreement.findings if f.about.key.family == "deviation"]
    by_model: dict[str, list[Finding]] = {}
    for finding in deviations:
        if finding.measured is not None:
            by_model.setdefault(finding.left, []).append(finding)
    sentences: list[str] = []
    for model, findings in by_model.items():
        level = model.partition(":")[2]
        quantities = {finding.quantity for finding in findings if finding.measured == 0}
        if {"tip", "torque"} <= quantities and not any(finding.measured for finding in findings):
            other = findings[0].right.partition(":")[2]
            sentences.append(f"Level {level} does not differ from {other}.")
            continue
        parts = [
            f"the tip is {format_length(f.measured or 0.0)} from that of"
            f" {f.right.partition(':')[2]} after a free motion"
            f"{', in which no teeth touch' if is_without_contact(f) else ''}"
            for f in findings
            if f.quantity == "tip"
        ]
        shares = [f for f in findings if f.quantity == "torque" and f.relative is not None]
        if shares:
            worst = max(shares, key=lambda f: f.relative or 0.0)
            parts.append(
                f"the torque of {robot.coordinate_names[(worst.about.key.joint or 1) - 1]} is off"
                f" by up to {format_percent(worst.relative or 0.0)} of its largest"
            )
        sentences += (f"At level {level} {part}." for part in parts)
    return " ".join(sentences)


def _group_tips(agreement: Agreement) -> dict[str, list[Finding]]:
    """The distances of the rigid levels' tips, by experiment."""
    by_case: dict[str, list[Finding]] = {}
    for finding in agreement.findings:
        key = finding.about.key
        if (key.family, key.quantity) == ("deviation", "tip") and finding.measured is not None:
            by_case.setdefault(key.case, []).append(finding)
    return by_case


def find_tip_ends(agreement: Agreement) -> list[Finding]:
    """Tip deviations of the first and the last rigid level, in the last experiment."""
    groups = list(_group_tips(agreement).values())
    return [groups[-1][0], *groups[-1][1:][-1:]] if groups else []


def is_without_contact(finding: Finding) -> bool:
    """Whether links alone move as gears on meshes do, since no teeth touch.

    A free motion begins in the middle of the backlash. If it ends within, no rotor shows in it.
    """
    levels = tuple(model.partition(":")[2] for model in (finding.left, finding.right))
    return finding.measured == 0 and levels == ("links", "geared")


def _describe_tip(finding: Finding) -> str:
    """The distance of a rigid level's tip, and which inertia of the arm that level omits."""
    off, level = format_length(finding.measured or 0.0), finding.left.partition(":")[2]
    if level not in LEVEL_OMISSIONS:
        return f"{off} at level {level}"
    return f"{off} without {LEVEL_OMISSIONS[level]} ({level})"


def answer_on_trust(agreement: Agreement, outline: ReportOutline) -> str:
    """The answer to the third question: the number of checks, and how a check decides."""
    alone = sum(not f.about.key.right for f in agreement.checks)
    counts = Counter(f.verdict for f in agreement.checks)
    other_verdicts = "".join(
        f"; {counts[verdict]} {verdict}"
        for verdict in WORST_FIRST
        if counts[verdict] and verdict not in ("agree", "unfinished")  # which the tally has
    )
    measured = [f for f in agreement.findings if f.kind == "measurement"]
    printed = any(f.about.key.family in ("form", "form-states") for f in measured)
    whose = "rigid levels and the printed equations" if printed else "rigid levels"
    more = f" {len(measured)} more numbers are measured without a limit, such as how far"
    more = f"{more} {whose} are off." if measured else ""
    return (
        f"{describe_tally(agreement)}{other_verdicts}. {len(agreement.checks) - alone} compare"
        " two models that share"
        f" data and no formula; {alone} compare one model with {outline.truths}."
        f" A tolerance is what rounding, or a run's measured uncertainty, explains.{more}"
    )


def describe_verdict(agreement: Agreement) -> str:
    """The result in one sentence: are the printed equations right, and do the models agree?"""
    checks, red = agreement.checks, agreement.disagreeing
    total, printed = format_count(len(checks), "check"), _describe_printed_equations(agreement)
    if red:
        counts = Counter(f.verdict for f in red)
        verdict_counts = ", ".join(f"{counts[each]} {each}" for each in WORST_FIRST if counts[each])
        verb = "does" if len(checks) == 1 else "do"
        most = f"{len(red)} of {total} {verb} not agree ({verdict_counts})"
        rest = f"{most}, the first of them {red[0].id}"
    elif not checks:
        rest = "nothing was checked"
    else:
        corrected = "the corrected ones agree with every engine"
        pairs = [(f.left, f.right) for f in checks if f.about.key.right]
        engines = list(dict.fromkeys(engine_of(model) for pair in pairs for model in pair))
        who = f"the engines {join_words(engines)}" if len(engines) > 1 else "the models"
        agree = corrected if printed else f"{who} agree with each other"
        rest = f"{agree} ({len(checks)} of {total})"
    sentence = f"{printed}; {rest}" if printed else rest
    return f"{sentence[0].upper()}{sentence[1:]}."


def _describe_printed_equations(agreement: Agreement) -> str | None:
    """Errors in the printed equations of motion, in words; None if none were compared."""
    form = model_names("form")[-1]
    wrong = find_wrong_entries(agreement.entries)
    if wrong:
        first = wrong[0]
        where, largest = (
            ("1 entry", "") if len(wrong) == 1 else (f"{len(wrong)} entries", "largest ")
        )
        worst = f"{largest}{first.name}, {format_percent(first.relative)}"
        return f"The printed equations are wrong in {where} ({worst})"
    findings = [f for f in agreement.findings if f.about.key.family in FORMS and f.left == form]
    if not findings:
        return None
    differ = any(is_beyond(f, agreement.findings) for f in findings)
    return f"The printed equations {'do not agree' if differ else 'agree'} with the engines"


def find_wrong_entries(entries: Sequence[EntryDifferences]) -> list[WrongEntry]:
    """The entries in which the printed equations of motion are wrong, the largest first."""
    form = model_names("form")[-1]
    wrong = [wrong for each in entries if each.model == form for wrong in each.wrong_entries()]
    return sorted(wrong, key=lambda each: -each.relative)


@dataclass(frozen=True)
class Answers:
    """The answers to the three questions of an outline.

    verdict: the result in one sentence; rows: the models behind the first answer; equations, rigid,
    trust: the answers as text.
    """

    verdict: str
    rows: tuple[ModelAnswer, ...]
    equations: str
    rigid: str
    trust: str
    outline: ReportOutline


def answer_questions(agreement: Agreement, mechanism: Mechanism) -> Answers:
    """The answers of a cross-check of an arm or a robot."""
    outline: ReportOutline = supply("outline", mechanism.section)(mechanism)
    rows = compare_models(agreement, outline)
    answer_on_levels = supply("answer_on_levels", mechanism.section)
    rigid = answer_on_levels(agreement, mechanism) if outline.has_levels else ""
    texts = answer_on_equations(rows, outline), rigid, answer_on_trust(agreement, outline)
    return Answers(describe_verdict(agreement), tuple(rows), *texts, outline)


def format_agreement_json(agreement: Agreement, mechanism: Mechanism) -> str:
    """JSON text by crosscheck/schema/agreement.schema.json, the answers before the findings."""
    whole, answers = agreement.to_dict(), answer_questions(agreement, mechanism)
    version = whole.pop("schema_version")
    models = [
        {
            "model": row.model,
            "against": row.against,
            "verdict": row.verdict,
            "differences": [
                {"quantity": q, "measured": f.measured, "unit": f.unit, "id": f.id}
                for q, f in row.worst.items()
            ],
        }
        for row in answers.rows
    ]
    entries = []
    for each in agreement.entries:
        wrong = [{"entry": e.name, "relative": e.relative} for e in each.wrong_entries()]
        entries.append({**to_json_value(each), "wrong": wrong})
    answer_records = {
        "verdict": answers.verdict,
        "equations": {"answer": answers.equations, "models": models, "entries": entries},
        "rigid": {"answer": answers.rigid},
        "trust": {"answer": answers.trust},
    }
    return format_json({"schema_version": version, "answers": answer_records, **whole})
