"""The claims: every statement of the paper that asserts a number or a direction, judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.audit.claims import rule
from crosscheck.audit.claims.judged import Judged, Varied
from crosscheck.audit.claims.rule import Answer, Verdict, VerdictKind
from crosscheck.audit.claims.settings import Plan, plan_of
from crosscheck.audit.experiments.cells import AS_GEARS, AS_MODELLED, BETWEEN, VARIANTS, GearModel
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.starts import ALIKE, FIRST
from crosscheck.audit.measures.undefined import JsonObject, defined, shown
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import text
from crosscheck.audit.page.words import LAW_NAMES, number

ID, TITLE = "claims", "The paper's statements, one by one"
# What a reader looks for first: what is wrong, what hangs on chance, what on an unknown.
ORDER = (
    VerdictKind.FAILS,
    VerdictKind.BISTABLE,
    VerdictKind.DEPENDS,
    VerdictKind.UNDEFINED,
    VerdictKind.NOT_SIMULATED,
    VerdictKind.WHERE_DEFINED,
    VerdictKind.HOLDS,
)
COLOURS = {
    VerdictKind.HOLDS: "agree",
    VerdictKind.WHERE_DEFINED: "agree",
    VerdictKind.FAILS: "differ",
    VerdictKind.DEPENDS: "unresolved",
    VerdictKind.BISTABLE: "bistable",
}
# The two that a verdict is told of side by side; what lies between them follows.
COLUMNS = {AS_MODELLED: "as modelled in the paper", AS_GEARS: "as the gears are"}
NAMED = {
    "as_modelled": AS_MODELLED,
    "as_the_gears_are": AS_GEARS,
    **{model.id: model for model in BETWEEN},
}


@dataclass(frozen=True)
class ClaimRow:
    """A claim and what the model's variants say of it."""

    judged: Judged
    variants: tuple[Varied, ...]


def chapter(material: Material) -> AuditChapter:
    """The chapter on the claims, their values in all settings and their verdicts."""
    found = rows(material)
    counts = Counter(row.judged.verdict.kind for row in found)
    outcome = "; ".join(f"{kind}: {count}" for kind, count in counts.most_common())
    return AuditChapter(
        ID,
        TITLE,
        page(found, plan_of(material.scale), material.scale),
        [record(row.judged, row.variants) for row in found],
        f"of {len(found)} statements: {outcome}.",
    )


def rows(material: Material) -> list[ClaimRow]:
    """One row per claim, in the paper's order, with each of VARIANTS that has its experiments."""
    found = []
    for one in material.judged.values():
        variants = []
        for model, settings in material.variations.items():
            other = Judged(one.claim, tuple(rule.answers(one.claim, settings)))
            if other.answers and not one.claim.static:
                own = one.by_model[VARIANTS[model]].kind
                variants.append(Varied(model, other.verdict.kind, own))
        found.append(ClaimRow(one, tuple(variants)))
    return found


def page(found: Sequence[ClaimRow], plan: Plan, scale: Scale) -> str:
    """The chapter's HTML: the rule, the counts of verdicts by model and section, every claim."""
    sections = dict.fromkeys(row.judged.claim.section for row in found)
    counts = Counter((row.judged.claim.section, row.judged.verdict.kind) for row in found)
    asked = [row.judged for row in found if not row.judged.claim.static]
    by_model = Counter((model, one.by_model[model].kind) for one in asked for model in COLUMNS)
    static = Counter(row.judged.verdict.kind for row in found if row.judged.claim.static)
    # Failures and what hangs on the start first; else in the paper's order.
    by_kind = sorted(found, key=lambda row: ORDER.index(row.judged.verdict.kind))
    kinds = [kind for kind in ORDER if any(counts[section, kind] for section in sections)]
    return text(
        "claims/chapter",
        rows={s: [row for row in by_kind if row.judged.claim.section == s] for s in sections},
        counts=counts,
        kinds=kinds,
        columns=COLUMNS,
        by_model=by_model,
        asked=len(asked),
        static=static,
        first=FIRST,
        alike=ALIKE,
        plan=plan,
        starts=scale.most_starts,
        few=rule.FEW,
        most=rule.MOST,
        most_no=rule.ends(scale.most_starts)[0],
        least_yes=rule.ends(scale.most_starts)[1],
        on_a_start=[r.judged.claim.id for r in found if r.judged.hangs_on_a_start],
        moved=[r.judged.claim.id for r in found if r.judged.moved_by_a_coarser_grid],
        differing=[(r.judged.claim.id, one) for r in found for one in r.variants if one.differs],
        colours=COLOURS,
        model_words=model_words,
        verdict=verdict_words,
        turning=turning_words,
        seen=seen_words,
    )


def verdict_words(found: Verdict) -> str:
    """A verdict in words, with the counts of settings behind it where they do not all agree."""
    words = str(found.kind)
    if found.depends_on:
        words += f" on {', '.join(found.depends_on)}"
    mixed = found.kind in (VerdictKind.DEPENDS, VerdictKind.BISTABLE)
    if mixed or (found.counts.undefined and found.kind != VerdictKind.UNDEFINED):
        told = [f"{count} {name}" for name, count in found.counts._asdict().items()
                if count or name in ("yes", "no")]  # fmt: skip
        words += f" ({', '.join(told)})"
    return words


def model_words(model: GearModel) -> str:
    """A model of the gears in words: law and planets."""
    own = f"{LAW_NAMES[model.law]}, planets {model.planets}"
    return f"{COLUMNS[model]}: {own}" if model in COLUMNS else own


def value_words(answer: Answer) -> str:
    """The median and the outer quantiles of an answer, once where they are equal as printed."""
    if answer.quantiles is None:
        return "undefined"
    low, middle, high = map(number, answer.quantiles)
    return middle if low == high else f"{middle} ({low} … {high})"


def share_words(answer: Answer) -> str:
    """How many of an answer's starts support the claim, and how many are undefined."""
    share = answer.share
    if share is None:
        return f"undefined in {answer.undefined} of {answer.starts}"
    left = f", {answer.undefined} undefined" if answer.undefined else ""
    return f"{share}{left}"


def seen_words(answer: Answer) -> str:
    """What the starts gave, and how many support the claim; those without its event apart."""
    if answer.starts == 1:
        return value_words(answer)
    if answer.undefined == answer.starts:
        return "in no start"
    return f"{value_words(answer)}, {share_words(answer)}"


def turning_words(judged: Judged) -> str:
    """The limits at which the verdict would turn."""
    places = [at for pair in judged.turning for at in pair if at is not None]
    return "; ".join(shown(at) for at in sorted(places)) or "at none"


def _answer_id(answer: Answer) -> str:
    place = answer.place
    zeta = "" if place.zeta is None else f"{place.zeta:g}"
    parts = (place.model.id if place.model else "", place.arm, zeta, place.choice)
    return "/".join(part for part in parts if part)


ANSWERS = Columns[Answer](
    _answer_id,
    (
        TableColumn("law", "law", lambda a: a.place.law.id if a.place.law else None),
        TableColumn("planets", "planets", lambda a: a.place.planets if a.place.law else None),
        TableColumn("arm", "arm", lambda a: a.place.arm),
        TableColumn("zeta", "zeta", lambda a: a.place.zeta, "g"),
        TableColumn("choice", "choice", lambda a: a.place.choice or None),
        TableColumn("state", "state", lambda a: a.state.value),
        TableColumn("yes", "yes", lambda a: a.share.yes if a.share else None),
        TableColumn("share", "share", lambda a: a.share.value if a.share else None),
        TableColumn("share_95", "95 % interval", lambda a: a.share.interval if a.share else None),
        TableColumn("quantiles", "quantiles"),
        TableColumn("starts", "starts"),
        TableColumn("run", "starts that were run", lambda a: a.starts - a.not_run),
        TableColumn("undefined", "undefined"),
    ),
)


def record(judged: Judged, variants: Sequence[Varied]) -> dict[str, object]:
    """A claim with its verdicts and its answers in all settings, as JSON."""
    claim = judged.claim
    return {
        "id": claim.id,
        "section": claim.section,
        "figure": claim.figure,
        "statement": claim.statement,
        "reading": claim.reading or None,
        "limits": {
            "low": defined(claim.limits.low),
            "high": defined(claim.limits.high),
            "because": claim.limits.because,
        },
        "free_parameter": claim.free or None,
        "quantities": {
            choice: {"id": q.id, "words": q.words, "unit": q.unit, "window": q.window or None}
            for choice, q in claim.choices.items()
        },
        "static": claim.static,
        **_verdict(judged.verdict),
        "models": {
            name: _verdict(judged.by_model[model])
            for name, model in ({} if claim.static else NAMED).items()
        },
        "turns_at": {"low": list(judged.turning.low), "high": list(judged.turning.high)},
        "hangs_on_one_start": judged.hangs_on_a_start,
        "moved_by_a_coarser_grid": judged.moved_by_a_coarser_grid,
        "variants": {one.model.id: {"verdict": one.kind, "beside": one.own} for one in variants},
        "quantile_parts": list(rule.PARTS),
        "settings": ANSWERS.json(judged.answers),
    }


def _verdict(found: Verdict) -> JsonObject:
    """A verdict as JSON; counts: how many settings have each state."""
    return {
        "verdict": found.kind,
        "depends_on": list(found.depends_on),
        "counts": dict(found.counts._asdict()),
    }
