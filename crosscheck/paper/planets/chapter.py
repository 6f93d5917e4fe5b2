"""Hypothesis H7: does counting three planets as one change the paper's third fluctuation?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.paper.phase.engines import SAMPLE_HEAD, answer, sample_rows
from crosscheck.paper.planets.distributions import distributions
from crosscheck.paper.planets.features import features
from crosscheck.paper.planets.growth import Foretold, growth
from crosscheck.paper.planets.pairs import Freed, TwoModels, two_models
from crosscheck.paper.planets.verdict import Effect, h7_verdict
from crosscheck.paper.record import Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import all_of, word
from crosscheck.report.chapter import Chapter
from crosscheck.report.fragments import heading, paragraph, table
from crosscheck.studies.study import Study

ID, TITLE = "planets", "Three planets counted as one (H7)"
CLAIM = (
    "The paper multiplies one planet's mesh forces by three. Its equations so hold the planets of a"
    " stage alike, which three planets with the same teeth and the same phase could well be. H7:"
    " counting three planets as one changes the third fluctuation."
)


@dataclass(frozen=True)
class H7(Record):
    """The verdict; settings by effect; whether the parting is foretold, and Exudyn agrees."""

    verdict: str
    settings: int
    weaker: int
    stronger: int
    foretold: bool | None
    engines_agree: bool | None
    features_changed: int

    @property
    def id(self) -> str:
        return "H7"


def chapter(study: Study, scale: Scale) -> Chapter:
    """Samples, the growth of differences, another engine, the figures."""
    sampled, grown = distributions(study, scale), growth(study, scale)
    compared, seen = two_models(study, scale), features(study, scale)
    changed = sum(record.changed is True for record in seen.records)
    verdict = _verdict(sampled.records, grown.free, compared, changed)
    html = [
        heading("Are three planets one?"),
        paragraph(f"{CLAIM} {_summary(verdict)}"),
        sampled.html,
        grown.html,
        *_engines(compared),
        seen.html,
    ]
    records = [verdict, *sampled.records, *grown.records, *compared, *seen.records]
    outcome = f"H7 {verdict.verdict}. {_effects(verdict)}"
    return Chapter(ID, TITLE, "\n".join(html), [r.to_dict() for r in records], outcome)


def _verdict(
    settings: Sequence[Freed], foretold: Foretold, compared: Sequence[TwoModels], changed: int
) -> H7:
    effects = [one.effect for one in settings]
    return H7(
        verdict=h7_verdict(effects),
        settings=len(effects),
        weaker=effects.count(Effect.WEAKER),
        stronger=effects.count(Effect.STRONGER),
        foretold=foretold.all_right,
        engines_agree=all_of(one.same for one in compared),
        features_changed=changed,
    )


def _summary(verdict: H7) -> str:
    return (
        f"Verdict: H7 {verdict.verdict}. {_effects(verdict)} Linear theory foretells the parting of"
        " the planets along the free run's own mean motion, not ahead of it:"
        f" {word(verdict.foretold)}. No test tells"
        f" Exudyn's free planets from the analytic model's: {word(verdict.engines_agree)}."
    )


def _effects(verdict: H7) -> str:
    return (
        f"Freeing the planets makes the third fluctuation weaker in {verdict.weaker} and stronger"
        f" in {verdict.stronger} of {verdict.settings} settings;"
        f" {verdict.features_changed} features of the figures are told apart."
    )


def _engines(compared: Sequence[TwoModels]) -> list[str]:
    return [
        heading("3. The same in Exudyn"),
        paragraph(
            "The samples of both models with free planets under omega_t, as in the chapter on the"
            " phase; medians with the quantiles 0.1 and 0.9."
        ),
        table(SAMPLE_HEAD, [row for one in compared for row in sample_rows(one)]),
        *(paragraph(answer(one)) for one in compared),
    ]
