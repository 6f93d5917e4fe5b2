"""The claims: every statement of the paper that asserts a number or a direction, judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.audit.claims.model_judgement import ModelJudgement, VariantVerdict, model_of
from crosscheck.audit.claims.study_plan import StudyPlan, plan_of
from crosscheck.audit.experiments.ensembles import ALIKE, FIRST
from crosscheck.audit.experiments.paper_conditions import (
    AS_GEARS,
    AS_MODELLED,
    DAMPING,
    INTERMEDIATE_MODELS,
    READING,
    VARIANTS,
    GearModel,
)
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.judging import rule
from crosscheck.audit.judging.judgement import CLOSE
from crosscheck.audit.judging.rule import Answer, Verdict, VerdictKind
from crosscheck.audit.measures.undefined import JsonObject, float_or_none, to_json
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.labels import LAW_NAMES
from crosscheck.audit.page.text import render_template

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
MODELS_BY_KEY = {
    "as_modelled": AS_MODELLED,
    "as_the_gears_are": AS_GEARS,
    **{model.id: model for model in INTERMEDIATE_MODELS},
}


@dataclass(frozen=True)
class ClaimRow:
    """A claim and what the model's variants say of it."""

    judged: ModelJudgement
    variants: tuple[VariantVerdict, ...]


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on the claims, their values in all settings and their verdicts."""
    claim_rows = build_claim_rows(context)
    counts = Counter(row.judged.verdict.kind for row in claim_rows)
    outcome = "; ".join(f"{kind}: {count}" for kind, count in counts.most_common())
    return AuditChapter(
        ID,
        TITLE,
        render_claims(claim_rows, plan_of(context.scale), context.scale),
        [build_claim_record(row.judged, row.variants) for row in claim_rows],
        f"of {len(claim_rows)} statements: {outcome}.",
    )


def build_claim_rows(context: AuditContext) -> list[ClaimRow]:
    """One row per claim, in the paper's order, with each of VARIANTS that has its experiments."""
    claim_rows = []
    for judgement in context.judged_claims.values():
        variants = []
        for model, settings in context.variations.items():
            variant_judgement = ModelJudgement(
                judgement.claim, tuple(rule.evaluate_claim(judgement.claim, settings))
            )
            if variant_judgement.answers and not judgement.claim.static:
                base_kind = judgement.by_model[VARIANTS[model]].kind
                variants.append(VariantVerdict(model, variant_judgement.verdict.kind, base_kind))
        claim_rows.append(ClaimRow(judgement, tuple(variants)))
    return claim_rows


def render_claims(claim_rows: Sequence[ClaimRow], plan: StudyPlan, scale: Scale) -> str:
    """The chapter's HTML: the rule, the counts of verdicts by model, every claim in a line."""
    sections = dict.fromkeys(row.judged.claim.section for row in claim_rows)
    simulated_claims = [row.judged for row in claim_rows if not row.judged.claim.static]
    by_model = Counter(
        (model, entry.by_model[model].kind) for entry in simulated_claims for model in COLUMNS
    )
    static = Counter(row.judged.verdict.kind for row in claim_rows if row.judged.claim.static)
    kinds = [kind for kind in ORDER if static[kind] or any(by_model[m, kind] for m in COLUMNS)]
    return render_template(
        "claims/chapter",
        rows={s: [row for row in claim_rows if row.judged.claim.section == s] for s in sections},
        kinds=kinds,
        columns=COLUMNS,
        by_model=by_model,
        asked=len(simulated_claims),
        static=static,
        first=FIRST,
        alike=ALIKE,
        plan=plan,
        starts=scale.most_starts,
        few=rule.FEW,
        most=rule.MOST,
        most_no=rule.state_thresholds(scale.most_starts)[0],
        least_yes=rule.state_thresholds(scale.most_starts)[1],
        on_a_start=[r.judged.claim.id for r in claim_rows if r.judged.is_start_sensitive],
        close=[entry.claim.id for entry in simulated_claims if entry.is_limit_sensitive],
        close_share=CLOSE,
        moved=[r.judged.claim.id for r in claim_rows if r.judged.is_grid_sensitive],
        differing=[
            (r.judged.claim.id, entry)
            for r in claim_rows
            for entry in r.variants
            if entry.kind != entry.base_kind
        ],
        colours=COLOURS,
        model_words=describe_model,
        verdict=describe_verdict,
    )


def describe_verdict(verdict: Verdict) -> str:
    """A verdict in words, with the counts of settings behind it where they do not all agree."""
    words = str(verdict.kind)
    if verdict.depends_on:
        words += f" on {', '.join(verdict.depends_on)}"
    mixed = verdict.kind in (VerdictKind.DEPENDS, VerdictKind.BISTABLE)
    if mixed or (verdict.counts.undefined and verdict.kind != VerdictKind.UNDEFINED):
        parts = [f"{count} {name}" for name, count in verdict.counts._asdict().items()
                if count or name in ("yes", "no")]  # fmt: skip
        words += f" ({', '.join(parts)})"
    return words


def describe_model(model: GearModel) -> str:
    """A model of the gears in words: law, planets and equations."""
    return f"{LAW_NAMES[model.law]}, planets {model.planets}, equations {model.equations}"


def build_answer_record(answer: Answer) -> JsonObject:
    """An answer with the setting where it was found, as JSON."""
    model, share = model_of(answer.place), answer.share
    arm, zeta = (answer.place.value_of(name) for name in (READING, DAMPING))
    parts = model and model.id, arm, zeta and f"{zeta:g}", answer.place.choice
    return to_json(
        {
            "id": "/".join(filter(None, parts)),
            "law": model and model.law.id,
            "planets": model and model.planets,
            "equations": model and model.equations,
            "arm": arm,
            "zeta": zeta,
            "choice": answer.place.choice or None,
            "state": answer.state.value,
            "yes": share and share.yes,
            "share": share and share.value,
            "share_95": share and model and share.interval,
            "quantiles": answer.quantiles,
            "starts": answer.starts,
            "undefined": answer.undefined,
        }
    )


def build_claim_record(
    judgement: ModelJudgement, variants: Sequence[VariantVerdict]
) -> dict[str, object]:
    """A claim with its verdicts and its answers in all settings, as JSON."""
    claim = judgement.claim
    return {
        "id": claim.id,
        "section": claim.section,
        "figure": claim.figure,
        "statement": claim.statement,
        "reading": claim.reading or None,
        "limits": {
            "low": float_or_none(claim.limits.low),
            "high": float_or_none(claim.limits.high),
            "because": claim.limits.because,
        },
        "free_parameter": claim.free or None,
        "quantities": {
            choice: {"id": q.id, "words": q.words, "unit": q.unit, "window": q.window or None}
            for choice, q in claim.choices.items()
        },
        "static": claim.static,
        **_verdict_record(judgement.verdict),
        "models": {
            name: _verdict_record(judgement.by_model[model])
            for name, model in ({} if claim.static else MODELS_BY_KEY).items()
        },
        "turns_at": {"low": list(judgement.turning.low), "high": list(judgement.turning.high)},
        "turns_within_a_quarter": judgement.is_limit_sensitive,
        "hangs_on_one_start": judgement.is_start_sensitive,
        "moved_by_a_coarser_grid": judgement.is_grid_sensitive,
        "variants": {
            variant.model.id: {"verdict": variant.kind, "beside": variant.base_kind}
            for variant in variants
        },
        "quantile_parts": list(rule.PARTS),
        "settings": [build_answer_record(answer) for answer in judgement.answers],
    }


def _verdict_record(verdict: Verdict) -> JsonObject:
    """A verdict as JSON; counts: how many settings have each state."""
    return {
        "verdict": verdict.kind,
        "depends_on": list(verdict.depends_on),
        "counts": dict(verdict.counts._asdict()),
    }
