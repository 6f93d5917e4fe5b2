"""The damping that the paper leaves out: which settings explain the numbers that it prints?

A start explains a number if its claim is true of it; one that lacks what the claim is about does
not. A setting belongs to the set if the numbers that its starts explain cannot be distinguished
from those of the best setting.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
import xarray as xr

from crosscheck.audit.claims import catalogue, quantities, rule
from crosscheck.audit.claims.study_plan import plan_of
from crosscheck.audit.experiments.experiments import CONSTANT, NO_ERROR, PD
from crosscheck.audit.experiments.paper_conditions import LAWS, READINGS, Condition
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Equations, Planets, Variant
from crosscheck.audit.measures.rigid import rigid_model
from crosscheck.audit.measures.undefined import to_json
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg

ID, TITLE = "damping_fit", "The unknown damping"
_LAW_WORDS = ("as printed", "printed, ring rate repaired", "integral")
LAW_WORDS = {law.id: words for law, words in zip(LAWS, _LAW_WORDS, strict=True)}

# The numbers that Section 3 prints of meshes and fluctuations, and Section 4.1's frequency.
NUMBERS = ("3.1-09", "3.1-14", "3.2-16", "3.2-20", "3.2-27", "3.2-28", "3.2-29", "4.1-19")
SOURCES = (PD, NO_ERROR, CONSTANT)  # the experiments that they are about
PLANETS: dict[Planets, Equations] = {"free": "corrected", "lumped": "printed"}  # as the paper ran
ALPHA = 0.05  # that one setting or more is left out although it explains as much as the best


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on the set of settings that explain the printed numbers equally well."""
    claims = [catalogue.BY_ID[name] for name in NUMBERS]
    fits = fit_conditions(context, claims)
    chosen = select_best_fits(fits)
    whole, left_out = summarize_settings(chosen), summarize_without_each(fits)
    silent = find_uninformative_claims(fits)
    table = _columns(claims, chosen)
    rigid = find_reversals(context.study, context.scale)
    given = {
        "claims": claims,
        "chosen": whole,
        "laws": [LAW_WORDS[law] for law in whole.laws],
        "most": {  # numbers that a law's best setting explains
            LAW_WORDS[law.id]: max(fit.mean for fit in fits if fit.cell.law == law) for law in LAWS
        },
    }
    page = render_template(
        "hypotheses/damping_fit",
        always=[catalogue.BY_ID[name] for name in silent[rule.State.YES]],
        never=[catalogue.BY_ID[name] for name in silent[rule.State.NO]],
        settings=len(fits),
        starts=len(context.scale.seeds),
        alpha=ALPHA,
        picture=to_markup(draw_explained_numbers(fits, chosen)),
        best=table.html(chosen),
        left_out=SPANS.html(left_out),
        every=table.html(sorted(fits, key=lambda fit: -fit.mean)),
        reversals=REVERSALS.html(rigid),
        **given,
    )
    verdict: dict[str, object] = {
        "id": "damping",
        **to_json(vars(whole)),
        "without": [to_json(vars(summary)) for summary in left_out],
        "true_in_all": silent[rule.State.YES],
        "false_in_all": silent[rule.State.NO],
    }
    records: list[Mapping[str, object]] = [verdict, *REVERSALS.json(rigid), *table.json(fits)]
    outcome = render_template("hypotheses/damping_fit_outcome", **given)
    return AuditChapter(ID, TITLE, page, records, outcome)


def _columns(claims: Sequence[rule.Claim], chosen: Sequence[DampingFit]) -> Columns[DampingFit]:
    """The columns of a setting's fit; claims: whose shares of starts are shown."""

    def share_column(claim: rule.Claim) -> TableColumn[DampingFit]:
        def explained_share(fit: DampingFit) -> float:
            return float(np.mean(fit.explained[claim.id]))

        return TableColumn(claim.id, claim.id, explained_share, ".2f")

    return Columns(
        "damping_fit/{0.cell.id}",
        [
            TableColumn("law", "phase law", lambda fit: LAW_WORDS[fit.cell.law.id]),
            TableColumn("reading", "reading", "cell.reading"),
            TableColumn("planets", "planets", "cell.planets"),
            TableColumn("equations", "equations", "cell.equations"),
            TableColumn("zeta", "ζ", "cell.zeta", "g"),
            TableColumn("explained", "numbers explained", "mean", ".2f"),
            *map(share_column, claims),
            TableColumn("equally_good", None, lambda fit: fit in chosen),
        ],
    )


SPANS: Columns[SettingsSummary] = Columns(
    "damping_fit/without/{0.left_out}",
    [
        TableColumn("left_out", "without"),
        TableColumn("settings", "equally good"),
        TableColumn("explained", "numbers explained, at most", "mean", ".2f"),
        TableColumn("laws", "phase law", lambda row: "; ".join(LAW_WORDS[law] for law in row.laws)),
        TableColumn("readings", "reading", lambda row: ", ".join(row.readings)),
        TableColumn("planets", "planets", lambda row: ", ".join(row.planets)),
        TableColumn("zetas", "ζ", form="g"),
    ],
)
REVERSALS: Columns[Reversals] = Columns(
    "damping_fit/rigid/{0.level}",
    [
        TableColumn("level", "rigid arm"),
        TableColumn("side_change_s", "torque changes sign at [s]", form=".3f"),
        TableColumn("return_s", "and again at [s]", form=".3f"),
    ],
)


def draw_explained_numbers(fits: Sequence[DampingFit], chosen: Sequence[DampingFit]) -> str:
    """Numbers explained over zeta, a panel for each reading and planets' treatment, as svg."""
    picture, grid = make_figure(len(PLANETS), len(READINGS), 2.4)
    for (row, column), axes in np.ndenumerate(grid):
        arm, planets = tuple(READINGS)[column], tuple(PLANETS)[row]
        for law, colour in zip(LAWS, COLOURS, strict=False):
            law_fits = [
                fit for fit in fits
                if (fit.cell.law, fit.cell.arm, fit.cell.planets) == (law, arm, planets)
            ]  # fmt: skip
            best = [fit for fit in law_fits if fit in chosen]
            axes.plot([fit.cell.zeta for fit in law_fits], [fit.mean for fit in law_fits], "o-",
                      color=colour, ms=3, label=LAW_WORDS[law.id])  # fmt: skip
            axes.plot([fit.cell.zeta for fit in best], [fit.mean for fit in best], "o",
                      mfc="none", mec="k", ms=8, label="equally good")  # fmt: skip
        axes.set(xscale="log", ylim=(0, len(fits[0].explained)),
                 title=f"{READINGS[arm]}, planets {planets}, {PLANETS[planets]}")  # fmt: skip
    for axes in grid[-1]:
        axes.set_xlabel("ζ")
    for axes in grid[:, 0]:
        axes.set_ylabel("numbers explained [1]")
    draw_legend(picture, grid[0, 0])
    return to_svg(picture)


@dataclass(frozen=True)
class DampingFit:
    """What a setting explains: by claim, (starts,), whether each start explains its number.

    Of starts that were run in one of its experiments at least.
    """

    cell: Condition
    explained: Mapping[str, np.ndarray]
    answers: Mapping[str, rule.Answer]

    @cached_property
    def counts(self) -> np.ndarray:
        """How many numbers each start explains, (starts,)."""
        return np.sum(list(self.explained.values()), axis=0)

    @property
    def mean(self) -> float:
        """The mean count of printed numbers that a start explains."""
        return float(self.counts.mean())

    def drop_claim(self, claim: str) -> DampingFit:
        """The fit with one number left out."""
        left = {name: yes for name, yes in self.explained.items() if name != claim}
        return DampingFit(self.cell, left, self.answers)


def fit_conditions(context: AuditContext, claims: Sequence[rule.Claim]) -> list[DampingFit]:
    """The fits of every setting; quick: of the claims' own quick settings."""
    plan = plan_of(context.scale)
    cells = [
        Condition(law, zeta, arm, planets, equations)
        for (planets, equations), law, arm, zeta in product(
            PLANETS.items(), LAWS, plan.readings, plan.zetas
        )
    ]
    requests = [(cell, source) for cell in cells for source in SOURCES]
    samples = context.samples(requests, "damping fit")
    return [
        fit_condition(c, quantities.ConditionResults({s: samples[c, s] for s in SOURCES}), claims)
        for c in cells
    ]


def fit_condition(
    cell: Condition, results: quantities.ConditionResults, claims: Sequence[rule.Claim]
) -> DampingFit:
    """The fit of a setting to claims about one quantity each, from the setting's experiments."""
    explained, given = {}, {}
    tracker = quantities.ResultsTracker(results)
    for claim in claims:
        (quantity,) = claim.choices.values()
        explained[claim.id] = claim.limits.contains(quantity(tracker))
        (given[claim.id],) = rule.evaluate_claim(claim, [(cell, results)])
    run = {name: yes[: tracker.run] for name, yes in explained.items()}
    return DampingFit(cell, run, given)


def select_best_fits(fits: Sequence[DampingFit]) -> list[DampingFit]:
    """The best fit, and every one that cannot be distinguished from it (Holm's procedure)."""
    best = max(fits, key=lambda fit: fit.mean)
    others = [fit for fit in fits if fit is not best]
    chances = {id(fit): chance(best.counts, fit.counts) for fit in others}
    worse = sorted(others, key=lambda fit: chances[id(fit)])
    for place, fit in enumerate(worse):
        if chances[id(fit)] > ALPHA / (len(worse) - place):
            return [best, *sorted(worse[place:], key=lambda fit: -fit.mean)]
    return [best]


def chance(best: np.ndarray, other: np.ndarray) -> float:
    """Probability that counts (starts,) of one origin are split with as large a sum in the first.

    Fisher and Pitman's exact test, one-sided: over all ways to choose as many of all starts.
    """
    pooled = np.concatenate([best, other]).astype(int)
    ways = np.zeros((best.size + 1, int(pooled.sum()) + 1))
    ways[0, 0] = 1.0
    for count in pooled:
        ways[1:, count:] += ways[:-1, : ways.shape[1] - count].copy()
    return float(ways[best.size, int(best.sum()) :].sum() / ways[best.size].sum())


@dataclass(frozen=True)
class SettingsSummary:
    """What the settings of a set have in common; left_out: the claim that it does without."""

    left_out: str | None
    laws: tuple[str, ...]
    readings: tuple[str, ...]
    planets: tuple[str, ...]
    zetas: tuple[float, float]
    settings: int
    mean: float


def summarize_settings(
    chosen: Sequence[DampingFit], left_out: str | None = None
) -> SettingsSummary:
    """The span of a set of settings."""
    cells = [fit.cell for fit in chosen]
    zetas = [cell.zeta for cell in cells]
    return SettingsSummary(
        left_out=left_out,
        laws=tuple(dict.fromkeys(cell.law.id for cell in cells)),
        readings=tuple(dict.fromkeys(cell.reading for cell in cells)),
        planets=tuple(dict.fromkeys(cell.planets for cell in cells)),
        zetas=(min(zetas), max(zetas)),
        settings=len(cells),
        mean=max(fit.mean for fit in chosen),
    )


def summarize_without_each(fits: Sequence[DampingFit]) -> list[SettingsSummary]:
    """The spans of the sets that are found without one of the numbers, each left out in turn."""
    return [
        summarize_settings(select_best_fits([fit.drop_claim(claim) for fit in fits]), claim)
        for claim in fits[0].explained
    ]


def find_uninformative_claims(fits: Sequence[DampingFit]) -> dict[rule.State, list[str]]:
    """The claims on which all settings agree, by what they say: these choose no damping."""
    silent: dict[rule.State, list[str]] = {rule.State.YES: [], rule.State.NO: []}
    for claim in fits[0].explained:
        states = {fit.answers[claim].state for fit in fits}
        if len(states) == 1 and (state := states.pop()) in silent:
            silent[state].append(claim)
    return silent


@dataclass(frozen=True)
class Reversals:
    """The first two times [s] at which a rigid arm's shoulder torque changes sign.

    The meshes change sides soon after the first, and back after the second. None where the run
    ends before.
    """

    level: str
    side_change_s: float | None
    return_s: float | None


def find_reversals(study: Study, scale: Scale) -> list[Reversals]:
    """The torque's reversals at every rigid level. Raises Diverged."""
    variants = {
        level: scale.cut(Variant(model=rigid_model(level), record_every=100))
        for level in RIGID_LEVELS
    }
    runs = study.run_variants(variants.values(), "damping fit, rigid arm")
    return [
        Reversals(level, *torque_reversals(runs[variant])) for level, variant in variants.items()
    ]


def torque_reversals(run: xr.Dataset) -> tuple[float | None, float | None]:
    """The first two sign changes [s] of the shoulder's torque; None for what does not happen."""
    time, torque = run["time"].values, run["torque"].values[:, 0]
    changes = [float(t) for t in time[1:][np.diff(np.sign(torque)) != 0]]
    first, second = (*changes, None, None)[:2]
    return first, second
