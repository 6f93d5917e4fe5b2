"""Claims as they go into claims.json: every setting with its share of starts and quantiles."""

from __future__ import annotations

from collections.abc import Sequence

from crosscheck.audit.claims.judged import Judged
from crosscheck.audit.claims.rule import PARTS, Answer, Verdict
from crosscheck.audit.claims.summary import Varied
from crosscheck.audit.experiments.cells import AS_GEARS, AS_MODELLED, BETWEEN
from crosscheck.audit.measures.undefined import JsonObject, defined
from crosscheck.audit.page.columns import Columns, TableColumn

ANSWERS = Columns[Answer](
    lambda answer: "/".join(
        part
        for part in (
            answer.place.model.id if answer.place.model else "",
            answer.place.arm,
            "" if answer.place.zeta is None else f"{answer.place.zeta:g}",
            answer.place.choice,
        )
        if part
    ),
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
        TableColumn("quantiles", "quantiles", lambda a: a.quantiles),
        TableColumn("starts", "starts", lambda a: a.starts),
        TableColumn("run", "starts that were run", lambda a: a.starts - a.not_run),
        TableColumn("undefined", "undefined", lambda a: a.undefined),
    ),
)


def record(judged: Judged, variants: Sequence[Varied]) -> dict[str, object]:
    """A claim with its verdict, and all settings."""
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
            for name, model in NAMED.items()
            if model in judged.by_model
        },
        "turns_at": {"low": list(judged.turning.low), "high": list(judged.turning.high)},
        "hangs_on_one_start": judged.hangs_on_a_start,
        "moved_by_a_coarser_grid": judged.moved_by_a_coarser_grid,
        "variants": {one.model.id: {"verdict": one.kind, "beside": one.own} for one in variants},
        "quantile_parts": list(PARTS),
        "settings": ANSWERS.json(judged.answers),
    }


NAMED = {
    "as_modelled": AS_MODELLED,
    "as_the_gears_are": AS_GEARS,
    **{model.id: model for model in BETWEEN},
}


def _verdict(found: Verdict) -> JsonObject:
    """counts: of settings, by what they say."""
    return {
        "verdict": found.kind,
        "depends_on": list(found.depends_on),
        "counts": dict(found.counts._asdict()),
    }
