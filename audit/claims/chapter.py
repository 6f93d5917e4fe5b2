"""The claims: every statement of the paper that asserts a number or a direction, judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, replace

from crosscheck.audit.claims import study_plan
from crosscheck.audit.claims.catalogue import ModelJudgement, model_of
from crosscheck.audit.claims.study_plan import AuditContext, StudyPlan
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
from crosscheck.audit.experiments.samples import Scale
from crosscheck.audit.judging import rule
from crosscheck.audit.judging.judgement import CLOSE
from crosscheck.audit.judging.rule import Answer, Verdict, VerdictKind
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.chapter import LAW_NAMES, AuditChapter, render_template

ID, TITLE = "claims", "The paper's statements, one by one"
COLOURS = {
    VerdictKind.HOLDS: "agree",
    VerdictKind.WHERE_DEFINED: "agree",
    VerdictKind.FAILS: "differ",
    VerdictKind.DEPENDS: "unresolved",
    VerdictKind.BISTABLE: "bistable",
}
# The two models whose verdicts stand side by side; those between them follow.
COLUMNS = {AS_MODELLED: "as modelled in the paper", AS_GEARS: "as the gears are"}
MODELS_BY_KEY = {
    "as_modelled": AS_MODELLED,
    "as_the_gears_are": AS_GEARS,
    **{model.id: model for model in INTERMEDIATE_MODELS},
}


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on the claims, their values in all settings and their verdicts."""
    judgements = list_judgements(context)
    counts = Counter(judged.verdict.kind for judged in judgements)
    outcome = "; ".join(f"{kind}: {count}" for kind, count in counts.most_common())
    return AuditChapter(
        ID,
        TITLE,
        render_claims(judgements, study_plan.FULL, context.scale),
        list(map(build_claim_record, judgements)),
        f"of {len(judgements)} statements: {outcome}.",
    )


def list_judgements(context: AuditContext) -> list[ModelJudgement]:
    """The claims, in the paper's order, with what each of VARIANTS says of them."""
    judgements = []
    for judged in context.judged_claims.values():
        by_model = {
            model: rule.evaluate_claim(judged.claim, [] if judged.claim.static else settings)
            for model, settings in context.variations.items()
        }
        variants = {
            model: rule.verdict(answers, judged.claim.free).kind
            for model, answers in by_model.items()
            if answers
        }
        judgements.append(replace(judged, variants=variants))
    return judgements


def render_claims(judgements: Sequence[ModelJudgement], plan: StudyPlan, scale: Scale) -> str:
    """The chapter's HTML: the rule, the counts of verdicts by model, every claim in a line."""
    sections = dict.fromkeys(judged.claim.section for judged in judgements)
    simulated = [judged for judged in judgements if not judged.claim.static]
    by_model = Counter(
        (model, each.by_model[model].kind) for each in simulated for model in COLUMNS
    )
    static = Counter(judged.verdict.kind for judged in judgements if judged.claim.static)
    kinds = [
        kind for kind in VerdictKind if static[kind] or any(by_model[m, kind] for m in COLUMNS)
    ]
    most_no, least_yes = rule.state_thresholds(scale.most_starts)
    return render_template(
        "claims/chapter",
        by_section={s: [each for each in judgements if each.claim.section == s] for s in sections},
        kinds=kinds,
        columns=COLUMNS,
        by_model=by_model,
        asked=len(simulated),
        static=static,
        first=FIRST,
        alike=ALIKE,
        plan=plan,
        starts=scale.most_starts,
        few=rule.FEW,
        most=rule.MOST,
        most_no=most_no,
        least_yes=least_yes,
        close=[each.claim.id for each in simulated if each.is_limit_sensitive],
        close_share=CLOSE,
        differing=[
            (each.claim.id, model, kind, beside)
            for each in judgements
            for model, kind in each.variants.items()
            if kind != (beside := each.by_model[VARIANTS[model]].kind)
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
    """An answer with the setting where it was found, as JSON: model, reading, zeta and choice."""
    model, share = model_of(answer.place), answer.share
    arm, zeta = (answer.place.value_of(name) for name in (READING, DAMPING))
    parts = model and model.id, arm, zeta and f"{zeta:g}", answer.place.choice
    return {
        "id": "/".join(filter(None, parts)),
        "state": answer.state,
        "yes": share and share.yes,
        "quantiles": answer.quantiles,
        "starts": answer.starts,
        "undefined": answer.undefined,
    }


def build_claim_record(judgement: ModelJudgement) -> JsonObject:
    """A claim with its verdicts and its answers in all settings, as JSON."""
    claim = judgement.claim
    return {
        "id": claim.id,
        "section": claim.section,
        "figure": claim.figure,
        "statement": claim.statement,
        "reading": claim.reading or None,
        "limits": asdict(claim.limits),
        "free_parameter": claim.free or None,
        "quantities": {
            choice: {"id": quantity.id, "unit": quantity.unit}
            for choice, quantity in claim.choices.items()
        },
        "static": claim.static,
        **judgement.verdict.to_dict(),
        "models": {
            name: judgement.by_model[model].to_dict()
            for name, model in ({} if claim.static else MODELS_BY_KEY).items()
        },
        "turns_within_a_quarter": judgement.is_limit_sensitive,
        "variants": {
            model.id: {"verdict": kind, "beside": judgement.by_model[VARIANTS[model]].kind}
            for model, kind in judgement.variants.items()
        },
        "quantile_parts": list(rule.PARTS),
        "settings": [build_answer_record(answer) for answer in judgement.answers],
    }
