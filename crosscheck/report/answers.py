"""The three questions that a cross-check answers, from its findings alone."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.findings import Agreement, EntryDifferences, Finding, Verdict, WrongEntry
from crosscheck.models.arm.arm import Arm
from crosscheck.registry import MODELS, names, reference_model
from crosscheck.report.matrix import FORMS, WORST_FIRST, digits, is_beyond
from crosscheck.report.records import document
from crosscheck.report.words import counted, length, percent, rounded, tally

QUESTIONS = (
    "Do the equations agree with the engines?",
    "How far is the rigid arm from the geared one?",
    "Can I trust this?",
)
STATES, RUNS = ("states", "form-states"), ("same-step", "refined", "form")
WORDS = {
    "mass_matrix": "mass matrix",
    "acceleration": "acceleration",
    "theta": "joint angle",
    "F_sp": "mesh force",
}
QUANTITIES = tuple(WORDS)
LEVELS_HAVE = {"links": "links and payload alone", "coupled": "all of the gears' inertia"}
SMALL = 1e-4  # relative differences from here on are told in per cent


@dataclass(frozen=True)
class ModelAnswer:
    """A model beside all others that it was compared with.

    against: those models; worst: by quantity the Finding of the largest difference on the arm
    itself; verdict: the worst of all checks between them; of a model that is only measured,
    ``differ`` where a difference is beyond what the reference model is allowed; digits: decimal
    ones that its checks at states leave in common, None without such checks.
    """

    model: str
    against: tuple[str, ...]
    worst: dict[str, Finding]
    verdict: Verdict
    digits: float | None = None

    @property
    def title(self) -> str:
        """The model's title in the registry."""
        return MODELS[self.model].title

    def number(self, quantity: str) -> str:
        """The largest difference of a quantity, with its unit; empty where it was not compared."""
        finding = self.worst.get(quantity)
        return "" if finding is None else amount(finding)


def amount(finding: Finding) -> str:
    """A measured difference for reading: relative ones in per cent unless they are tiny."""
    value = finding.measured
    if value is None:
        return "no number"
    if finding.unit != "1":
        return f"{rounded(value)} {finding.unit}"
    return percent(value) if value >= SMALL else f"{value:.1g}"


def compared(agreement: Agreement, arm: Arm) -> list[ModelAnswer]:
    """The printed equations, the derivation and the rigid levels, each beside the engines.

    Differences are those on this arm; verdicts and digits are of all checks.
    """
    pairs = [f for f in agreement.findings if f.about.key.right]
    # States of this arm, not of the probe's or another reading's; and any run.
    own = [
        f
        for f in pairs
        if f.about.key.family in RUNS
        or (f.about.key.family in STATES and f.about.key.case.partition("/")[0] == arm.name)
    ]
    found = []
    home = reference_model().partition(":")[
        0
    ]  # the package of the derivation, with rigid models of its own
    derived = [name for name in names("rigid") if name.partition(":")[0] == home]
    for model in (*names("form"), reference_model(), *derived):
        others = [f for f in own if _with_engine(f, model)]
        checks = [f for f in pairs if f.kind == "check" and _with_engine(f, model)]
        if others:
            found.append(_compared(model, others, checks, own))
    return found


def _with_engine(finding: Finding, model: str) -> bool:
    """Whether a finding compares the model with one of another package."""
    if model not in (finding.left, finding.right):
        return False
    other = finding.right if finding.left == model else finding.left
    return other.partition(":")[0] != model.partition(":")[0]


def _compared(
    model: str, others: Sequence[Finding], checks: Sequence[Finding], own: Sequence[Finding]
) -> ModelAnswer:
    worst: dict[str, Finding] = {}
    for quantity in QUANTITIES:
        if found := [f for f in others if f.quantity == quantity]:
            worst[quantity] = max(found, key=_size)
    against = dict.fromkeys(f.right if f.left == model else f.left for f in others)
    if checks:
        verdict = min((f.verdict for f in checks), key=WORST_FIRST.index)
    else:
        verdict = "differ" if any(is_beyond(f, own) for f in others) else "agree"
    states = [f.relative for f in checks if f.about.key.family == "states"]
    common = [digits(value) for value in states if value is not None]
    return ModelAnswer(model, tuple(against), worst, verdict, min(common, default=None))


def _size(finding: Finding) -> float:
    return float("inf") if finding.measured is None else finding.measured


def headline(rows: Sequence[ModelAnswer]) -> str:
    """The answer to the first question in three sentences at most."""
    forms = [row for row in rows if MODELS[row.model].role == "form"]
    rest = [row for row in rows if row not in forms]
    wrong = [row for row in forms if row.verdict != "agree"]
    said = []
    for row in wrong:
        sizes = ", ".join(f"{row.number(q)} in {WORDS[q]}" for q in row.worst)
        title = f"{row.title[0].upper()}{row.title[1:]}"
        said.append(f"{title}, do not agree with the engines: they differ by up to {sizes}.")
    if forms and not wrong:
        said.append("The paper's equations as printed agree with the engines.")
    red = [row.model for row in rest if row.verdict != "agree"]
    if red:
        said.append(f"Of the project's own derivation these do not agree: {', '.join(red)}.")
    elif rest:
        whose = "corrected derivation" if forms else "derivation"
        common = min((row.digits for row in rest if row.digits is not None), default=None)
        to = "to rounding" if common is None else f"to {math.floor(common)} digits at random states"
        said.append(f"The {whose} agrees with every engine at each level, {to}.")
    return " ".join(said)


def rigid_from_geared(agreement: Agreement) -> str:
    """The answer to the second question: how far the tip of the first and the last level is off."""
    by_case: dict[str, list[Finding]] = {}
    for finding in agreement.findings:
        key = finding.about.key
        if key.family == "deviation" and key.quantity == "tip" and finding.measured is not None:
            by_case.setdefault(key.case, []).append(finding)
    if not by_case:
        return "No rigid model was run beside the geared one."
    said = []
    for case, found in by_case.items():
        ends = ", by ".join(map(_tip, (found[0], *found[1:][-1:])))
        said.append(f"In experiment {case} the rigid arm's tip is off by up to {ends}.")
    return " ".join(said)


def _tip(finding: Finding) -> str:
    """How far a rigid level's tip is off, and what of the arm that level has, in words."""
    off, level = length(finding.measured or 0.0), MODELS[finding.left].level
    if level not in LEVELS_HAVE:
        return f"{off} at level {level}"
    return f"{off} with {LEVELS_HAVE[level]} ({level})"


def trust(agreement: Agreement) -> str:
    """The answer to the third question: what was checked, and what stands behind a check."""
    alone = sum(not f.about.key.right for f in agreement.checks)
    counts = Counter(f.verdict for f in agreement.checks)
    said = "".join(
        f"; {counts[verdict]} {verdict}"
        for verdict in WORST_FIRST
        if counts[verdict] and verdict not in ("agree", "unfinished")  # which the tally has
    )
    measured = [f for f in agreement.findings if f.kind == "measurement"]
    printed = any(f.about.key.family in ("form", "form-states") for f in measured)
    whose = "rigid levels and the printed equations" if printed else "rigid levels"
    return (
        f"{tally(agreement)}{said}. {len(agreement.checks) - alone} compare two models that share"
        f" data and no formula; {alone} compare one model with first principles, its own records or"
        " the arm's file. A tolerance is what rounding, or a run's measured uncertainty, explains."
        f" {len(measured)} more numbers are measured without a limit, such as how far {whose} are"
        " off."
    )


def verdict_sentence(agreement: Agreement) -> str:
    """The result in one sentence: are the printed equations right, and do the models agree?"""
    checks, red = agreement.checks, agreement.disagreeing
    total, printed = counted(len(checks), "check"), _printed_verdict(agreement)
    if red:
        counts = Counter(f.verdict for f in red)
        kinds = ", ".join(f"{counts[each]} {each}" for each in WORST_FIRST if counts[each])
        verb = "does" if len(checks) == 1 else "do"
        rest = f"{len(red)} of {total} {verb} not agree ({kinds}), the first of them {red[0].id}"
    elif not checks:
        rest = "nothing was checked"
    else:
        whose = "the corrected ones" if printed else "the equations"
        agree = "agree with every engine"
        rest = f"{whose} {agree} ({len(checks)} of {total})"
    said = f"{printed}; {rest}" if printed else rest
    return f"{said[0].upper()}{said[1:]}."


def _printed_verdict(agreement: Agreement) -> str | None:
    """What is wrong in the printed equations of motion, in words; None where none were compared."""
    form = names("form")[-1]
    wrong = wrong_entries(agreement.entries)
    if wrong:
        first = wrong[0]
        places = counted(len(wrong), "place")
        largest = "" if len(wrong) == 1 else "largest "
        return (
            f"The printed equations are wrong in {places}"
            f" ({largest}{first.name}, {percent(first.relative)})"
        )
    found = [f for f in agreement.findings if f.about.key.family in FORMS and f.left == form]
    if not found:
        return None
    differ = any(is_beyond(f, agreement.findings) for f in found)
    return f"The printed equations {'do not agree' if differ else 'agree'} with the engines"


def wrong_entries(entries: Sequence[EntryDifferences]) -> list[WrongEntry]:
    """The entries in which the printed equations of motion are wrong, the largest first."""
    form = names("form")[-1]
    found = [wrong for each in entries if each.model == form for wrong in each.wrong()]
    return sorted(found, key=lambda wrong: -wrong.relative)


@dataclass(frozen=True)
class Answers:
    """The answers to the three questions.

    verdict: the result in one sentence; rows: the models behind the first answer; equations, rigid,
    trust: the answers as text.
    """

    verdict: str
    rows: tuple[ModelAnswer, ...]
    equations: str
    rigid: str
    trust: str


def answers(agreement: Agreement, arm: Arm) -> Answers:
    """The answers of a cross-check of an arm."""
    rows = compared(agreement, arm)
    texts = headline(rows), rigid_from_geared(agreement), trust(agreement)
    return Answers(verdict_sentence(agreement), tuple(rows), *texts)


def agreement_json(agreement: Agreement, arm: Arm) -> str:
    """JSON text by crosscheck/schema/agreement.schema.json, the answers before the findings."""
    whole, found = agreement.to_dict(), answers(agreement, arm)
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
        for row in found.rows
    ]
    entries = [
        {
            "quantity": each.quantity,
            "model": each.model,
            "engines": each.engines,
            "coordinates": each.coordinates,
            "relative": each.relative,
            "tolerance": each.tolerance,
            "wrong": [{"entry": wrong.name, "relative": wrong.relative} for wrong in each.wrong()],
        }
        for each in agreement.entries
    ]
    said = {
        "verdict": found.verdict,
        "equations": {"answer": found.equations, "models": models, "entries": entries},
        "rigid": {"answer": found.rigid},
        "trust": {"answer": found.trust},
    }
    return document({"schema_version": whole.pop("schema_version"), "answers": said, **whole})
